//! The best candidate for a quantity, by names and data.

use super::beside;
use super::choose::Wishes;
use super::drive::Drive;
use super::evidence::{Evidence, Verdict, weigh};
use super::mapped::Chosen;
use super::motion::{Motion, points};
use super::names::{self, Named};
use super::source::{Place, Unit, is_number};
use super::vocabulary::NO_MEASUREMENT;
use super::words::Words;
use crate::dbc::Database;
use physics::Quantity;

/// Correlation from which on the data are enough without a name.
const ALONE: f64 = 0.93;

/// Names that leave no doubt.
const SURELY_NAMED: f64 = 0.95;

/// A candidate with all that speaks for it and against it.
#[derive(Clone, Debug)]
pub(super) struct Picked {
    pub(super) chosen: Chosen,
    pub(super) names: f64,
    pub(super) data: Option<Evidence>,
    /// It is called so beyond doubt, and behaves poorly.
    pub(super) is_weak: bool,
}

/// What was picked and what was not.
#[derive(Default)]
pub(super) struct Picks {
    pub(super) best: Option<Picked>,
    pub(super) others: Vec<Picked>,
    pub(super) contradicted: Vec<Picked>,
    /// Called so, but not in the recordings.
    pub(super) absent: Vec<Place>,
}

pub(super) struct Chooser<'a> {
    pub(super) database: &'a Database,
    pub(super) drive: Option<&'a Drive>,
    pub(super) motion: Option<Motion>,
    pub(super) taken: Vec<Place>,
    /// 1 if the motion's first side is the left one, else −1.
    pub(super) left: f64,
    /// What somebody has named.
    pub(super) wishes: Wishes,
}

impl Chooser<'_> {
    /// A candidate's points, its sign put in.
    pub(super) fn series(&self, chosen: &Chosen) -> Option<Vec<f64>> {
        let drive = self.drive?;
        let mut series = drive.series(self.database, chosen.place)?;
        if let Some(sign) = chosen.sign_bit {
            let bits = drive.series(self.database, sign)?;
            series.iter_mut().zip(&bits).for_each(|(value, bit)| *value *= 1.0 - 2.0 * bit);
        }
        if chosen.sign_bit.is_none() {
            // The finer part of a sum.
            let fine =
                beside::fine(self.database, chosen.place).and_then(|fine| drive.series(self.database, fine));
            if let Some(fine) = fine {
                series.iter_mut().zip(&fine).for_each(|(value, part)| *value += part);
            }
        }
        Some(points(&series))
    }

    /// What the recordings say of a candidate; `None` without any.
    fn weigh(&self, quantity: Quantity, chosen: &Chosen) -> Option<Evidence> {
        self.drive?;
        let motion = self.motion.as_ref()?;
        Some(weigh(quantity, &self.series(chosen)?, &chosen.unit, motion))
    }

    /// The best candidate by names and data.
    pub(super) fn pick(&self, quantity: Quantity) -> Picks {
        let mut picks = Picks::default();
        if let Some(wish) = self.wishes.get(&quantity) {
            picks.best = wish.and_then(|place| self.wished(quantity, place));
            return picks;
        }
        let mut candidates = Vec::new();
        for Named { place, score, unit } in names::candidates(self.database, quantity) {
            if self.taken.contains(&place) {
                continue;
            }
            let sign_bit = beside::sign(self.database, place, quantity);
            let chosen = Chosen { place, sign_bit, unit };
            if self.drive.is_some_and(|drive| !drive.came(self.database, place)) {
                picks.absent.push(place);
                continue;
            }
            let data = self.weigh(quantity, &chosen);
            let picked = Picked { names: score, data, chosen, is_weak: false };
            let still = self.stands_still(quantity, &picked.chosen);
            match (&picked.data, still) {
                (_, Some(words)) => {
                    let data = Some(Evidence {
                        words,
                        verdict: Verdict::Contradicts,
                        ..silent(&picked.chosen.unit)
                    });
                    picks.contradicted.push(Picked { data, ..picked });
                }
                (Some(data), _) if data.verdict == Verdict::Contradicts => picks.contradicted.push(picked),
                _ => candidates.push(picked),
            }
        }
        let fits = |picked: &Picked| picked.data.as_ref().is_some_and(|data| data.verdict == Verdict::Fits);
        if !candidates.iter().any(fits) {
            candidates.extend(self.nameless(quantity, &candidates, &picks.contradicted));
        }
        // Data before names, then both.
        let rank = |picked: &Picked| {
            let strength = picked.data.as_ref().filter(|_| fits(picked)).map_or(0.0, Evidence::strength);
            f64::from(u8::from(fits(picked))) + picked.names + 0.5 * strength
        };
        candidates.sort_by(|a, b| rank(b).total_cmp(&rank(a)).then(a.chosen.place.cmp(&b.chosen.place)));
        if candidates.is_empty() {
            candidates.extend(weak(quantity, &mut picks.contradicted));
        }
        let mut candidates = candidates.into_iter();
        picks.best = candidates.next();
        picks.others = candidates.collect();
        picks
    }

    /// Nothing but "not available" comes.
    pub(super) fn has_no_value(&self, chosen: &Chosen) -> bool {
        let channel = self.drive.and_then(|drive| drive.channel(self.database, chosen.place));
        channel.is_some_and(|channel| channel.range().is_none())
    }

    /// What somebody names is taken, but for a sign and a unit that the recordings tell.
    fn wished(&self, quantity: Quantity, place: Place) -> Option<Picked> {
        let (_, signal) = place.find(self.database)?;
        let sign_bit = beside::sign(self.database, place, quantity);
        let chosen = Chosen { place, sign_bit, unit: Unit::of(quantity, signal) };
        Some(Picked { data: self.weigh(quantity, &chosen), names: 1.0, chosen, is_weak: false })
    }

    /// A sensor that has one value, or none, while the car moves, in words.
    fn stands_still(&self, quantity: Quantity, chosen: &Chosen) -> Option<String> {
        let channel = self.drive?.channel(self.database, chosen.place)?;
        // Without a motion, too.
        if channel.range().is_none() {
            return Some("is never available in the recordings".into());
        }
        let motion = self.motion.as_ref().filter(|motion| motion.moving_s() > 10.0)?;
        let flag = matches!(quantity, Quantity::BrakeActive | Quantity::AbsActive);
        match channel.range() {
            None => None,
            // A value that is always zero may be one that only stays so: brakes that were not used, no curve.
            Some([value, _]) if !flag && !channel.varies() && (value != 0.0 || moved(quantity, motion)) => {
                Some(format!("is always {value} while the car moves"))
            }
            Some(_) => None,
        }
    }

    /// Signals without a telling name that behave like the quantity beyond doubt.
    fn nameless(&self, quantity: Quantity, named: &[Picked], refused: &[Picked]) -> Vec<Picked> {
        const LAWS: [Quantity; 5] = [
            Quantity::YawRate,
            Quantity::LateralAcceleration,
            Quantity::SteeringWheelAngle,
            Quantity::LongitudinalAcceleration,
            Quantity::VehicleSpeed,
        ];
        let (Some(drive), Some(_)) = (self.drive, &self.motion) else { return Vec::new() };
        if !LAWS.contains(&quantity) {
            return Vec::new();
        }
        let mut found = Vec::new();
        for place in Place::all(self.database) {
            let Some((message, signal)) = place.find(self.database) else { continue };
            let known = named.iter().chain(refused).any(|picked| picked.chosen.place == place);
            let told = Words::of(&signal.name).any(NO_MEASUREMENT);
            let varies = drive.channel(self.database, place).is_some_and(|channel| channel.varies());
            if known
                || told
                || !varies
                || signal.size < 7
                || !is_number(signal)
                || self.taken.contains(&place)
            {
                continue;
            }
            // A sign in a bit of its own, where the value has none.
            let magnitude = signal.codec().range().0 >= 0.0 && quantity != Quantity::VehicleSpeed;
            let flags = message.signals.iter().enumerate().filter(|(_, flag)| magnitude && flag.size == 1);
            let flags = flags.map(|(signal, _)| Place { message: place.message, signal });
            let flags = flags.filter(|flag| drive.channel(self.database, *flag).is_some_and(|c| c.varies()));
            let best = std::iter::once(None)
                .chain(flags.map(Some))
                .filter_map(|sign_bit| {
                    self.alone(quantity, Chosen { place, sign_bit, unit: Unit::of(quantity, signal) }, &LAWS)
                })
                .max_by(|a, b| strength(a).total_cmp(&strength(b)));
            found.extend(best);
        }
        found.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
        found
    }

    /// The candidate, if it obeys this quantity's law better than all others'.
    fn alone(&self, quantity: Quantity, chosen: Chosen, laws: &[Quantity]) -> Option<Picked> {
        if chosen.unit == Unit::Unfitting {
            return None;
        }
        let data = self.weigh(quantity, &chosen)?;
        if data.verdict != Verdict::Fits || data.strength() < ALONE {
            return None;
        }
        let (_, signal) = chosen.place.find(self.database)?;
        let other = laws.iter().filter(|law| **law != quantity).any(|law| {
            let unit = Unit::of(*law, signal);
            let chosen = Chosen { unit, ..chosen.clone() };
            chosen.unit != Unit::Unfitting
                && self
                    .weigh(*law, &chosen)
                    .is_some_and(|other| other.verdict == Verdict::Fits && other.strength() > data.strength())
        });
        (!other).then_some(Picked { chosen, names: 0.0, data: Some(data), is_weak: false })
    }
}

/// A sensor that is called so beyond doubt and moves with what it should follow, but by a factor that no unit explains.
/// It is one, if not a good one.
fn weak(quantity: Quantity, contradicted: &mut Vec<Picked>) -> Option<Picked> {
    let (least, why) = match quantity {
        Quantity::LongitudinalAcceleration => (0.6, ": it may be filtered, and late"),
        Quantity::YawRate | Quantity::LateralAcceleration | Quantity::SteeringWheelAngle => {
            (0.8, ": its scale may be wrong")
        }
        _ => return None,
    };
    let is_weak = |picked: &Picked| {
        let follows = |data: &Evidence| {
            data.strength() > least && data.scale.is_some_and(|scale| (0.2..5.0).contains(&scale.abs()))
        };
        picked.names >= SURELY_NAMED
            && matches!(picked.chosen.unit, Unit::Known(_))
            && picked.data.as_ref().is_some_and(follows)
    };
    let mut picked = contradicted.remove(contradicted.iter().position(is_weak)?);
    picked.is_weak = true;
    if let Some(data) = &mut picked.data {
        data.verdict = Verdict::Silent;
        data.words.push_str(why);
    }
    Some(picked)
}

/// Did the car do what the quantity measures?
fn moved(quantity: Quantity, motion: &Motion) -> bool {
    match quantity {
        Quantity::YawRate | Quantity::LateralAcceleration | Quantity::SteeringWheelAngle => {
            motion.turned && motion.turning() > 0.012
        }
        Quantity::LongitudinalAcceleration | Quantity::DriveTorque => motion.changing() > 0.2,
        Quantity::VehicleSpeed => true,
        _ => false,
    }
}

fn strength(picked: &Picked) -> f64 {
    picked.data.as_ref().map_or(0.0, Evidence::strength)
}

fn silent(unit: &Unit) -> Evidence {
    Evidence {
        verdict: Verdict::Silent,
        correlation: None,
        scale: None,
        zero: None,
        words: String::new(),
        unit: unit.clone(),
        sign: 1.0,
    }
}
