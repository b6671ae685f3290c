//! What healthy drives of the same car say of a candidate: a car's numbers differ a little from drive to drive, because its
//! equations are simpler than it is. What the references have as well, or what is within what they differ by, has not
//! changed.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::super::fit::FreeFit;
use super::super::numbers::{Free, Number, Scope};
use super::Search;
use super::climb::State;
use super::colour::Series;
use super::power::Bar;
use super::refit::Refitted;
use super::rows::rows;
use super::scan::Scored;
use super::trial::Trial;
use crate::explain::model::Place;

/// A candidate as a reference has it, to first order.
#[derive(Clone, Debug)]
pub struct Healthy {
    /// The name of the candidate.
    name: String,
    /// The coordinate of its clearest main number.
    coordinate: f64,
    /// By how much −2 ln likelihood falls with it.
    gain: f64,
}

/// Before references are seen, a number is thought to differ from drive to drive by this share of what it could be, and
/// that counts as much as so many of them. Tuned: `healthy_beside_healthy` (campaign).
pub(super) const SPREAD: f64 = 0.1;
pub(super) const WORTH: f64 = 6.0;

/// What a number could be moves yaw rate and lateral acceleration by no more than this share of what they do: what would
/// move them by more is a number for gentler drives. Tuned: a steering ratio (`concealed_in_real_drives`), whose usual
/// curvature, 0.15/rad², would turn the steering round where the wheel is turned by three rad.
const MOST_MOVED: f64 = 0.3;

/// A number must be so many deviations of that, and of its own, from the references'. Statistical: one in a thousand of
/// Student's distribution with eight degrees of freedom, for each of some tens of candidates.
pub(super) const LEAST_DISTANCE: f64 = 5.0;

/// Sensors that are late by as much in each drive, and radii that are the same, differ by so much, s and a share. The
/// first is the step of a slow message, the second what pressure and heat make of a tire.
const DELAYS: f64 = 0.01;
const SCALES: f64 = 0.005;

/// Mean and spread of what numbers are, where a spread counts as so many of them.
fn spread(values: &[f64], thought: f64) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count.max(1.0);
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let variance = (WORTH * thought * thought + square) / (WORTH + (count - 1.0).max(0.0));
    (mean, (variance * (1.0 + 1.0 / count.max(1.0))).sqrt())
}

/// The same fit with what is thought of the other recordings' delays and of the scale of their speed: as in the
/// references, so many of them.
pub fn expecting<'a>(found: &FreeFit<'a>, references: usize) -> FreeFit<'a> {
    FreeFit { free: expected(&found.free, &found.at, references), ..found.clone() }
}

/// What is free, with what the references let think of it.
pub fn expected(all: &[Free], at: &[f64], references: usize) -> Vec<Free> {
    let of = |free: &Free| {
        let thought = match (free.number, free.of) {
            (Number::SpeedDelay | Number::Of(Place::Delay(_)), Scope::Recording(own))
                if own >= references =>
            {
                DELAYS
            }
            (Number::SpeedScale, Scope::Recording(own)) if own >= references => SCALES,
            _ => return *free,
        };
        let is_theirs = |(other, _): &(&Free, &f64)| {
            other.number == free.number
                && matches!(other.of, Scope::Recording(reference) if reference < references)
        };
        let theirs: Vec<f64> = all.iter().zip(at).filter(is_theirs).map(|(_, at)| *at).collect();
        if theirs.is_empty() { *free } else { Free { prior: spread(&theirs, thought), ..*free } }
    };
    all.iter().map(of).collect()
}

impl Search<'_> {
    /// How much of such a change of a number could be on these drives, by how the predictions change with the number.
    pub(super) fn could_be(&self, slopes: &[Series], by: f64) -> f64 {
        let moved = self.drives.iter().zip(slopes).flat_map(|(drive, [yaw_rate, lateral, ..])| {
            let share = |measured: &[f64], slope: &[f64]| {
                let both = rows(drive).map(|i| measured[i]).zip(slope).filter(|(is, _)| is.is_finite());
                let squares = both.fold((0.0, 0.0), |(is, by), (a, b)| (is + a * a, by + b * b));
                if squares.0 > 0.0 { by.abs() * (squares.1 / squares.0).sqrt() } else { 0.0 }
            };
            [
                share(&drive.yaw_rate, yaw_rate),
                drive.lateral.as_deref().map_or(0.0, |measured| share(measured, lateral)),
            ]
        });
        let most = moved.filter(|share| share.is_finite()).fold(0.0, f64::max);
        (MOST_MOVED / most.max(1e-9)).min(1.0)
    }

    /// Is a candidate beyond what these references have and differ by?
    pub(super) fn is_beyond(&self, of: &Refitted<'_>, references: &[Healthy]) -> bool {
        self.distance(of, references).is_none_or(|distance| distance > LEAST_DISTANCE)
    }

    /// How far its clearest main number is from what the references have, in deviations; none without any, and where it is
    /// not always there.
    pub(super) fn distance(&self, of: &Refitted<'_>, references: &[Healthy]) -> Option<f64> {
        if references.is_empty() || !of.trial.is_always_there() {
            return None;
        }
        let Some(place) = of.clearest_place() else { return Some(0.0) };
        let Free { step, prior: (neutral, usual), .. } = of.free[place];
        let own = of.clearest_main();
        let name = of.trial.name();
        let there = references.iter().filter(|healthy| healthy.name == name);
        let mut there: Vec<f64> = there.map(|healthy| healthy.coordinate).collect();
        if there.is_empty() {
            there.push(neutral);
        }
        let slopes = self.slope(&of.model, &of.free, (&of.at, &of.errors), (place, step), None);
        let (mean, spread) = spread(&there, SPREAD * self.could_be(&slopes, usual) * usual);
        Some((own.value - mean).abs() / own.std.hypot(spread))
    }

    /// What each reference says of these candidates.
    pub(super) fn healthy(
        &self,
        state: &State<'_>,
        trials: &[Trial],
        names: &BTreeSet<String>,
        seed: u64,
    ) -> Vec<Healthy> {
        let of = |reference: usize| -> Vec<Healthy> {
            let there = trials.iter().filter(|trial| names.contains(&trial.name()));
            let own: Vec<Trial> = there.map(|trial| trial.within(Scope::Recording(reference))).collect();
            let (scored, _) = self.scan(state, &own, seed);
            scored.into_iter().filter_map(Healthy::of).collect()
        };
        (0..self.references).into_par_iter().flat_map_iter(of).collect()
    }
}

impl Healthy {
    fn of(scored: Scored) -> Option<Self> {
        let (_, coordinate) = *scored.numbers.first()?;
        Some(Self { name: scored.trial.name(), coordinate, gain: scored.gain })
    }
}

/// How far from so many references' a number must be, where the whole of what it could be is so clear, and this share of
/// that could be on these drives.
pub fn bar(clear: f64, could_be: f64, references: usize) -> Bar {
    let spread = SPREAD * could_be * (1.0 + 1.0 / references.max(1) as f64).sqrt();
    Bar { slope: clear.recip().hypot(spread).recip(), needed: LEAST_DISTANCE }
}

impl Refitted<'_> {
    /// Its evidence beyond the most that a reference has of the same at any time; of what is always there the distance says
    /// more.
    pub fn evidence_beyond(&self, references: &[Healthy]) -> f64 {
        if self.trial.is_always_there() {
            return self.evidence;
        }
        let name = self.trial.name();
        let same = references.iter().filter(|healthy| healthy.name == name);
        self.evidence - same.map(|healthy| healthy.gain).fold(0.0, f64::max)
    }
}
