//! Names and data together: one signal for each quantity, or none.

use std::collections::BTreeMap;

use super::by_speed;
use super::corners::Wheels;
use super::drive::Drive;
use super::evidence::Verdict;
use super::mapped::{Chosen, counters, entry};
use super::motion::Motion;
use super::names::ENOUGH;
use super::pick::{Chooser, Picked, Picks};
use super::proposal::{Alternative, Choice, Confidence, Mapped, Proposal};
use super::source::{Place, Unit};
use super::wheels::{self, Found};
use crate::dbc::Database;
use physics::Quantity;

/// Alternatives that are mentioned.
const ALTERNATIVES: usize = 3;

/// Signals that somebody names for a quantity, or none where it is to be left out.
pub type Wishes = BTreeMap<Quantity, Option<Place>>;

/// Proposes a signal for every quantity; `drive` has gathered the recordings, if there are any.
pub fn propose(database: &Database, drive: Option<&Drive>) -> Proposal {
    propose_with(database, drive, Wishes::new())
}

/// The same; what is wished for is taken, whatever its name is and however it behaves.
pub fn propose_with(database: &Database, drive: Option<&Drive>, wishes: Wishes) -> Proposal {
    let taken = wishes.values().copied().flatten().collect();
    let mut chooser = Chooser { database, drive, motion: None, taken, left: 1.0, wishes };
    let found = wheels::find(database, drive);
    let mut choices = chooser.wheels_and_turns(found);
    for quantity in Quantity::ALL {
        if !choices.0.iter().any(|choice| choice.quantity == quantity) {
            let picked = chooser.pick(quantity);
            let place = picked.best.as_ref().map(|best| best.chosen.place);
            let choice = chooser.choice(quantity, picked);
            // Nothing measures two things.
            chooser.taken.extend(place.filter(|_| choice.confidence > Confidence::NotFound));
            choices.0.push(choice);
        }
    }
    let (mut quantities, mut notes) = choices;
    if chooser.driven_in_vain() {
        let are_there = quantities.iter().any(|choice| choice.quantity.wheel().is_some() && is_found(choice));
        notes.push(if are_there {
            "the wheels hardly turn in the recordings, which so tell nothing: drive for some minutes".into()
        } else {
            "no wheels turn in the recordings: is it the right bus, and the right car's file?".into()
        });
    }
    quantities.sort_by_key(|choice| choice.quantity);
    if let Some(drive) = drive {
        let proposed = quantities.iter_mut().filter(|choice| choice.confidence > Confidence::NotFound);
        counters(database, drive, proposed.filter_map(|choice| choice.mapping.as_mut()));
    }
    let is_fd = |mapped: &Mapped| {
        let message =
            mapped.signals.first().and_then(|name| name.split_once('.')).map(|(message, _)| message);
        message.and_then(|name| database.message(name)).is_some_and(|message| message.is_fd)
    };
    let fd = quantities
        .iter()
        .filter(|c| c.confidence > Confidence::NotFound)
        .filter_map(|c| c.mapping.as_ref())
        .any(is_fd);
    let driven_s = drive.map(|_| chooser.motion.as_ref().map_or(0.0, Motion::moving_s));
    Proposal { quantities, notes, driven_s, fd }
}

impl Chooser<'_> {
    /// The wheels, and the three sensors of turning, which decide together what is left.
    fn wheels_and_turns(&mut self, found: Option<Found>) -> (Vec<Choice>, Vec<String>) {
        const TURNS: [Quantity; 3] =
            [Quantity::YawRate, Quantity::LateralAcceleration, Quantity::SteeringWheelAngle];
        let (wheels, motion, others, contradicted) = match found {
            Some(found) => (Some(found.wheels), found.motion, found.others, found.contradicted),
            None => (None, None, Vec::new(), Vec::new()),
        };
        self.motion = motion.or_else(|| by_speed::motion(self.database, self.drive?));
        // Wheels that stand, or have no value, while another signal says that the car drives.
        let wheels = wheels.filter(|_| self.motion.as_ref().is_none_or(|motion| motion.confirmed.is_none()));
        self.taken.extend(wheels.iter().flat_map(|wheels| wheels.places));
        let mut picks = Vec::new();
        for quantity in TURNS {
            let picked = self.pick(quantity);
            if let Some(best) = picked.best.as_ref() {
                self.taken.push(best.chosen.place);
                if quantity == Quantity::YawRate {
                    self.turn_by(best);
                }
            }
            picks.push((quantity, picked));
        }
        let fitting = |picks: &Picks| {
            let evidence = picks.best.as_ref()?.data.as_ref()?;
            (evidence.verdict == Verdict::Fits).then_some(evidence.sign)
        };
        let sensors: Vec<f64> = picks.iter().filter_map(|(_, picks)| fitting(picks)).collect();
        let by_sensors: f64 = sensors.iter().sum();
        if wheels.is_none() && by_sensors < 0.0 {
            self.left = -1.0;
        }
        let mut choices = Vec::new();
        let mut notes = Vec::new();
        match &wheels {
            Some(wheels) => {
                let corners = self.motion.as_ref().map(|motion| wheels::corners(wheels, motion, &sensors));
                let (order, known) =
                    corners.as_ref().map_or(([0, 1, 2, 3], true), |c| (c.order, c.axles_known));
                if let Some(corners) = corners {
                    self.left = if corners.first_is_left { 1.0 } else { -1.0 };
                    notes = corners.notes;
                }
                let named = |groups: &[Wheels], corner: usize| -> Vec<Alternative> {
                    let name = |group: &Wheels| Alternative {
                        signal: group.places[corner].name(self.database),
                        names: group.score,
                        data: String::new(),
                    };
                    groups.iter().take(ALTERNATIVES).map(name).collect()
                };
                for (corner, quantity) in Quantity::ALL.into_iter().take(4).enumerate() {
                    if self.wishes.contains_key(&quantity) {
                        continue;
                    }
                    let mut choice = self.wheel(quantity, wheels, wheels.places[order[corner]], known);
                    choice.alternatives = named(&others, corner);
                    choice.contradicted = named(&contradicted, corner);
                    choices.push(choice);
                }
                if !known && !wheels.corners_named {
                    notes.push("front and rear wheels are proposed in the order of the file".into());
                }
            }
            None => choices.extend(self.unwished_wheels().map(|quantity| Choice {
                why: "no four signals are named or behave like wheels".into(),
                ..nothing(quantity)
            })),
        }
        choices.extend(picks.into_iter().map(|(quantity, picks)| self.choice(quantity, picks)));
        (choices, notes)
    }

    fn unwished_wheels(&self) -> impl Iterator<Item = Quantity> {
        Quantity::ALL.into_iter().take(4).filter(|quantity| !self.wishes.contains_key(quantity))
    }

    /// One wheel of the group.
    fn wheel(&self, quantity: Quantity, wheels: &Wheels, place: Place, axles_known: bool) -> Choice {
        let chosen = Chosen { place, sign_bit: None, unit: wheels.unit.clone() };
        let mut words = Vec::new();
        let mapped = entry(self.database, self.drive, quantity, &chosen, None, &mut words);
        let mut why = if wheels.corners_named {
            vec![format!("named so ({:.2})", wheels.score)]
        } else {
            vec!["one of four of a kind".to_owned()]
        };
        match &self.motion {
            Some(motion) if motion.turned => why.push("all four agree, and differ in curves".into()),
            Some(_) => why.push("all four agree; no curves to tell them apart".into()),
            None if self.drive.is_some() => why.push("the recordings do not tell".into()),
            None => {}
        }
        why.extend(words);
        let told = self.motion.as_ref().is_some_and(|motion| motion.turned);
        let confidence = match (wheels.unit.to_si(), wheels.corners_named, &self.motion) {
            (None, ..) => {
                why.push("its unit is not known: add unit = \"…\"".into());
                Confidence::NotFound
            }
            (_, true, Some(_)) if told && !axles_known => Confidence::Unsure,
            (_, true, Some(_)) if told => Confidence::Sure,
            (_, true, Some(_)) => Confidence::Likely,
            (_, true, None) if wheels.score >= ENOUGH && !self.driven_in_vain() => Confidence::Likely,
            (_, false, Some(_)) if told && axles_known => Confidence::Likely,
            (_, false, _) if !told => Confidence::NotFound,
            _ => Confidence::Unsure,
        };
        let mapping = Some(mapped);
        Choice { confidence, mapping, names: wheels.score, why: why.join("; "), ..nothing(quantity) }
    }

    /// There are recordings, and no wheels that turn in them.
    fn driven_in_vain(&self) -> bool {
        self.drive.is_some() && self.motion.is_none()
    }

    /// Takes the yaw rate from its sensor from now on.
    fn turn_by(&mut self, picked: &Picked) {
        let Some(evidence) =
            picked.data.as_ref().filter(|e| e.verdict == Verdict::Fits && e.strength() > 0.8)
        else {
            return;
        };
        let (Some(series), Some(to_si)) = (self.series(&picked.chosen), evidence.unit.to_si()) else {
            return;
        };
        let zero = evidence.zero.unwrap_or(0.0);
        if let Some(motion) = &mut self.motion {
            motion.take_turn(series.iter().map(|x| evidence.sign * (to_si * x - zero)).collect());
        }
    }

    /// The choice, in words.
    fn choice(&self, quantity: Quantity, picks: Picks) -> Choice {
        let alternative = |picked: &Picked| Alternative {
            signal: picked.chosen.place.name(self.database),
            names: picked.names,
            data: picked.data.as_ref().map(|data| data.words.clone()).unwrap_or_default(),
        };
        let alternatives = picks.others.iter().take(ALTERNATIVES).map(alternative).collect();
        let contradicted = picks.contradicted.iter().take(ALTERNATIVES).map(alternative).collect();
        let base = Choice { alternatives, contradicted, ..nothing(quantity) };
        let Some(best) = picks.best else {
            let why = match picks.absent.first() {
                Some(place) => {
                    format!("{} is called so, but does not come in the recordings", place.name(self.database))
                }
                None if base.contradicted.is_empty() => "nothing fits".to_owned(),
                None => "what is called so behaves otherwise".to_owned(),
            };
            // What has no value now may have one in another drive: its code for that stands in the comment.
            let mapping = picks.contradicted.first().filter(|picked| self.has_no_value(&picked.chosen));
            let mapping = mapping.map(|picked| {
                entry(self.database, self.drive, quantity, &picked.chosen, None, &mut Vec::new())
            });
            return Choice { why, mapping, ..base };
        };
        let mut words = Vec::new();
        words.push(match best.names {
            _ if self.wishes.contains_key(&quantity) => "named by you".to_owned(),
            0.0 => "no name says so".to_owned(),
            names => format!("named so ({names:.2})"),
        });
        words.extend(best.data.as_ref().map(|data| data.words.clone()));
        let turning = matches!(
            quantity,
            Quantity::YawRate | Quantity::LateralAcceleration | Quantity::SteeringWheelAngle
        );
        let left = if turning { self.left } else { 1.0 };
        let mut chosen = best.chosen.clone();
        let fits = best.data.as_ref().is_some_and(|data| data.verdict == Verdict::Fits);
        if let Some(data) = best.data.as_ref().filter(|_| fits) {
            // The data found a unit that makes more sense than the file's.
            if data.unit != chosen.unit && matches!(chosen.unit, Unit::Known(_)) {
                words.push("with the file's unit it makes no sense".to_owned());
            }
            chosen.unit = data.unit.clone();
        }
        if let Unit::Guessed(_, unit) = &chosen.unit {
            let by = if fits { "the recordings" } else { "the range" };
            words.push(format!("unit {unit} by {by}"));
        }
        let data = best.data.as_ref().map(|data| (data, data.sign * left));
        let mapped = entry(self.database, self.drive, quantity, &chosen, data, &mut words);
        let confidence = self.confidence(quantity, &best, &chosen.unit, fits, &mut words);
        if turning && fits && data.is_some_and(|(_, sign)| sign < 0.0) {
            words.push("turned round, so that the left is positive".into());
        } else if quantity == Quantity::LongitudinalAcceleration && mapped.gain.is_some() {
            words.push("turned round, so that forward is positive".into());
        }
        Choice {
            confidence,
            mapping: Some(mapped),
            names: best.names,
            data: best.data,
            why: words.join("; "),
            ..base
        }
    }

    fn confidence(
        &self,
        quantity: Quantity,
        best: &Picked,
        unit: &Unit,
        fits: bool,
        words: &mut Vec<String>,
    ) -> Confidence {
        let flag = matches!(quantity, Quantity::BrakeActive | Quantity::AbsActive);
        if !flag && unit.to_si().is_none() {
            words.push("its unit is not known".into());
            return Confidence::NotFound;
        }
        let is_wished = self.wishes.contains_key(&quantity);
        if quantity == Quantity::DriveTorque && !fits && !is_wished {
            // An engine's torque in front of a gearbox is no axle's.
            let axle = best.chosen.place.spoken(self.database).is_some_and(|spoken| {
                spoken.signal.any(&["wheel*", "whl*", "axle*", "prpl*", "di", "drive", "antrieb*", "rad*"])
            });
            if !axle {
                words.push("an engine's torque is of use only where the gear does not change".into());
                return Confidence::NotFound;
            }
        }
        match (fits, best.names) {
            (true, names) if names >= ENOUGH => Confidence::Sure,
            (true, names) if names > 0.0 || best.data.as_ref().is_some_and(|d| d.strength() > 0.97) => {
                Confidence::Likely
            }
            (true, _) => Confidence::Unsure,
            (false, _) if best.is_weak => Confidence::Unsure,
            // Where nothing behaves like wheels, it may be another car's file.
            (false, names) if names >= 0.8 && !self.driven_in_vain() => Confidence::Likely,
            (false, names) if names >= ENOUGH => Confidence::Unsure,
            _ => {
                words.push("the name alone is too weak".into());
                Confidence::NotFound
            }
        }
    }
}

fn is_found(choice: &Choice) -> bool {
    choice.confidence > Confidence::NotFound
}

fn nothing(quantity: Quantity) -> Choice {
    Choice {
        quantity,
        confidence: Confidence::NotFound,
        mapping: None,
        names: 0.0,
        data: None,
        why: String::new(),
        alternatives: Vec::new(),
        contradicted: Vec::new(),
        repaired: Vec::new(),
    }
}
