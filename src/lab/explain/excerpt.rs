//! The part of a long recording in which causes are searched.
//!
//! It has some minutes of every kind of driving, and those minutes in which the plain model errs most. An hour of
//! driving shows a cause a hundred times over. So the search takes minutes; the fit and the proof take all of the
//! recording ([`super::long_recording`]).

use std::collections::{BTreeMap, BTreeSet};

use super::fit::{Data, Fit};
use super::locate::{rate, steering_rate, turn};
use super::split::BLOCK_S;
use super::tuning::TUNING;
use physics::Quantity;
use predict::GriddedDrive;
use predict::grid::{STEP_S, points};
use predict::sums::BlockSums;

/// A unit, s: two blocks that are fitted to and one that is held out ([`super::split`]).
const UNIT_S: f64 = 3.0 * BLOCK_S;

/// A drive, and the number of a unit in it.
type Unit = (usize, usize);

/// A part of the recordings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    units: BTreeSet<Unit>,
}

impl Excerpt {
    /// Of recordings that are worth it, by what is driven; none of shorter ones.
    pub fn of(data: &Data<'_>) -> Option<Self> {
        let all: f64 = data.drives.iter().map(GriddedDrive::used_seconds).sum();
        if all <= TUNING.long.longest_s {
            return None;
        }
        let kinds = Kinds::of(data.drives);
        let (held, fitted): (Vec<Unit>, Vec<Unit>) = kinds.driven.keys().partition(|unit| {
            let middle = |third: usize| unit.1 as f64 * UNIT_S + (third as f64 + 0.5) * BLOCK_S;
            (0..3).all(|third| data.split.is_held_out(unit.0, middle(third)))
        });
        let mut units = kinds.most_varied(&fitted, TUNING.long.varied_s);
        units.extend(kinds.most_varied(&held, TUNING.long.varied_s / 3.0));
        Some(Self { units })
    }

    /// The drives, gone over only within it.
    pub fn drives(&self, drives: &[GriddedDrive]) -> Vec<GriddedDrive> {
        let of = |(number, drive): (usize, &GriddedDrive)| {
            let mut stretches: Vec<(usize, usize)> = Vec::new();
            for (_, unit) in self.units.iter().filter(|unit| unit.0 == number) {
                let (from, to) = (points(*unit as f64 * UNIT_S), points((unit + 1) as f64 * UNIT_S));
                match stretches.last_mut() {
                    Some(last) if last.1 == from => last.1 = to,
                    _ => stretches.push((from, to)),
                }
            }
            drive.within(&stretches)
        };
        drives.iter().enumerate().map(of).collect()
    }

    /// Adds where a model that was fitted to the excerpt errs most beyond what it usually does, as far as may be
    /// looked at. Says whether there was any such place.
    pub fn locate(&mut self, data: &Data<'_>, fit: &Fit<'_>) -> bool {
        let sums = data.pass(&fit.model, &[], &fit.noise);
        let mut by_unit: BTreeMap<Unit, f64> = BTreeMap::new();
        for (sum, excess) in excesses(data.counted(&sums)) {
            let middle = 0.5 * (sum.t.0 + sum.t.1);
            *by_unit.entry((sum.drive, (middle / UNIT_S) as usize)).or_default() += excess;
        }
        let mut order: Vec<(Unit, f64)> = by_unit.into_iter().collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1));
        let worst: Vec<_> = order.iter().take(5).collect();
        tracing::debug!(?worst, units = ?self.units, "where the model errs most");
        let worth = order
            .into_iter()
            .filter(|(unit, excess)| *excess > TUNING.long.least_excess && !self.units.contains(unit));
        let found: Vec<Unit> = worth.take(TUNING.long.most_located).map(|(unit, _)| unit).collect();
        self.units.extend(&found);
        !found.is_empty()
    }
}

/// How much more than in the median block each sensor errs in a block, 2 ln likelihood.
fn excesses<'s>(sums: impl Iterator<Item = &'s BlockSums>) -> Vec<(&'s BlockSums, f64)> {
    let mut all: Vec<(&BlockSums, f64)> = sums.map(|sum| (sum, 0.0)).collect();
    for channel in Quantity::ALL {
        let place = channel as usize;
        let share = |sum: &BlockSums| (sum.of[place] > 20).then(|| sum.square[place] / sum.of[place] as f64);
        let mut sorted: Vec<f64> = all.iter().filter_map(|(sum, _)| share(sum)).collect();
        sorted.sort_by(f64::total_cmp);
        let Some(median) = sorted.get(sorted.len() / 2).copied() else { continue };
        for (sum, excess) in &mut all {
            let more = share(sum).map_or(1.0, |share| share / median).max(1.0);
            *excess += sum.of[place] as f64 * (more - 1.0 - more.ln());
        }
    }
    all
}

/// Levels of a feature, by the shares of all driving below them: what is rare has a level of its own.
/// Tuned, no test on record.
const LEVELS: [f64; 7] = [0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98];

/// Features of driving, of an instant.
const FEATURES: [fn(&GriddedDrive, usize) -> f64; 5] =
    [|d, k| d.speed[k], turn, steering_rate, rate, |d, k| d.inputs[k].brake_pressure];

/// Parts of the recordings: what drifts shows in early and late ones. Tuned, no test on record.
const TIMES: usize = 6;

/// Kinds of driving: a level of a feature, or a part of the recordings, each.
const KINDS: usize = FEATURES.len() * (LEVELS.len() + 1) + TIMES;

/// Instants that are looked at, grid points apart. Numerical: driving changes more slowly.
const EVERY: usize = points(0.1);

/// How long each unit is driven in each kind.
struct Kinds {
    driven: BTreeMap<Unit, [f64; KINDS]>,
    all: [f64; KINDS],
}

impl Kinds {
    fn of(drives: &[GriddedDrive]) -> Self {
        let of = |(number, drive): (usize, &GriddedDrive)| {
            let instants = drive.runs.iter().flat_map(|(from, to)| (*from..*to).step_by(EVERY));
            let unit = |k: usize| (number, (k as f64 * STEP_S / UNIT_S) as usize);
            instants.map(|k| (unit(k), FEATURES.map(|feature| feature(drive, k)))).collect::<Vec<_>>()
        };
        let instants: Vec<(Unit, [f64; FEATURES.len()])> = drives.iter().enumerate().flat_map(of).collect();
        let levels: [[f64; LEVELS.len()]; FEATURES.len()] = std::array::from_fn(|feature| {
            let mut values: Vec<f64> = instants.iter().map(|(_, values)| values[feature]).collect();
            values.sort_by(f64::total_cmp);
            LEVELS.map(|share| {
                let place = (share * values.len() as f64) as usize;
                values.get(place).copied().unwrap_or(0.0)
            })
        });
        let mut driven: BTreeMap<Unit, [f64; KINDS]> = BTreeMap::new();
        let mut all = [0.0; KINDS];
        for (place, (unit, values)) in instants.iter().enumerate() {
            let own = driven.entry(*unit).or_insert([0.0; KINDS]);
            let mut add = |kind: usize| {
                own[kind] += EVERY as f64 * STEP_S;
                all[kind] += EVERY as f64 * STEP_S;
            };
            for (number, (levels, value)) in levels.iter().zip(values).enumerate() {
                let level = levels.iter().filter(|level| value > *level).count();
                add(number * (LEVELS.len() + 1) + level);
            }
            add(KINDS - TIMES + place * TIMES / instants.len());
        }
        Self { driven, all }
    }

    /// Units of so many seconds together, one after the other the one that adds most: of each kind the first
    /// seconds are worth most, and the rarer it is, the more.
    fn most_varied(&self, units: &[Unit], seconds: f64) -> BTreeSet<Unit> {
        let mut taken = BTreeSet::new();
        let (mut have, mut left) = ([0.0; KINDS], seconds);
        let of_times = |own: &[f64; KINDS]| own[KINDS - TIMES..].iter().sum::<f64>();
        while left > 0.0 {
            let worth = |unit: &Unit| -> f64 {
                let own = &self.driven[unit];
                let kinds = (0..KINDS).filter(|kind| self.all[*kind] > 0.0);
                kinds
                    .map(|kind| {
                        ((have[kind] + own[kind]).sqrt() - f64::sqrt(have[kind])) / self.all[kind].sqrt()
                    })
                    .sum()
            };
            let rest = units.iter().filter(|unit| !taken.contains(*unit));
            let Some((best, _)) = rest.map(|unit| (*unit, worth(unit))).max_by(|a, b| a.1.total_cmp(&b.1))
            else {
                break;
            };
            let own = &self.driven[&best];
            for (have, own) in have.iter_mut().zip(own) {
                *have += own;
            }
            left -= of_times(own);
            taken.insert(best);
        }
        taken
    }
}
