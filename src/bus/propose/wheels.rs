//! Which four signals are the wheels, and which of them is on which corner.

use super::beside;
use super::corners::{self, Wheels};
use super::drive::Drive;
use super::motion::{FEWEST, Motion, SLOW, points};
use super::names;
use super::source::{Place, RADIUS_M, Unit};
use crate::dbc::Database;
use physics::Quantity;

/// What each axle's names weigh beside the sign of one sensor: sensors are often the wrong way round, wheels on
/// both axles hardly ever. Only where three sensors agree against both axles are the names not believed.
const AXLE: f64 = 1.25;

/// The wheels that were chosen.
pub(super) struct Found {
    pub(super) wheels: Wheels,
    /// With recordings in which they behave like wheels: what the car did.
    pub(super) motion: Option<Motion>,
    /// Other groups.
    pub(super) others: Vec<Wheels>,
    /// Groups that are called wheels and do not behave so.
    pub(super) contradicted: Vec<Wheels>,
}

/// Finds them.
pub(super) fn find(database: &Database, drive: Option<&Drive>) -> Option<Found> {
    let mut named = corners::groups(database);
    let Some(drive) = drive else {
        let best = (!named.is_empty()).then(|| named.remove(0))?;
        return Some(Found { wheels: best, motion: None, others: named, contradicted: Vec::new() });
    };
    // What has no value all the time is not there.
    let has_values =
        |place: &Place| drive.channel(database, *place).is_some_and(|channel| channel.range().is_some());
    let came = |wheels: &Wheels| wheels.places.iter().all(has_values);
    let mut groups: Vec<Wheels> = named.into_iter().filter(came).collect();
    let known = groups.len();
    groups.extend(corners::nameless(database).into_iter().filter(came));
    for wheels in &mut groups {
        if wheels.unit == Unit::Unknown {
            wheels.unit = unit_by_speed(database, drive, wheels).unwrap_or(Unit::Unknown);
        }
    }
    let turning = called_turning(database, drive);
    let mut judged: Vec<(usize, Wheels, Motion)> = Vec::new();
    let mut contradicted = Vec::new();
    let mut silent = Vec::new();
    for (place, wheels) in groups.into_iter().enumerate() {
        // Four are enough to choose from; nameless ones only where no name does.
        if judged.len() >= 4 || (place >= known && !judged.is_empty() && judged[0].0 < known) {
            break;
        }
        match Motion::of(database, drive, &wheels, &turning) {
            Some(motion) => judged.push((place, wheels, motion)),
            None if place < known && drives(database, drive, &wheels) => contradicted.push(wheels),
            None if place < known => silent.push(wheels),
            None => {}
        }
    }
    // By name first; among the nameless those that tell the sides apart, and the finest.
    let quality = |(place, wheels, motion): &(usize, Wheels, Motion)| {
        let step = wheels.places[0].find(database).map_or(f64::INFINITY, |(_, signal)| signal.factor.abs());
        (*place >= known, !motion.turned, step)
    };
    judged.sort_by(|a, b| {
        let (a, b) = (quality(a), quality(b));
        (a.0, a.1).cmp(&(b.0, b.1)).then(if a.0 { a.2.total_cmp(&b.2) } else { std::cmp::Ordering::Equal })
    });
    let mut judged = judged.into_iter();
    if let Some((_, wheels, motion)) = judged.next() {
        let others = judged.map(|(_, wheels, _)| wheels).filter(|other| other.corners_named).collect();
        return Some(Found { wheels, motion: Some(motion), others, contradicted });
    }
    // A car that stands says nothing against the names.
    let best = (!silent.is_empty()).then(|| silent.remove(0))?;
    Some(Found { wheels: best, motion: None, others: silent, contradicted })
}

/// The points of the signals that are called yaw rate, lateral acceleration or steering angle.
fn called_turning(database: &Database, drive: &Drive) -> Vec<Vec<f64>> {
    [Quantity::YawRate, Quantity::LateralAcceleration, Quantity::SteeringWheelAngle]
        .into_iter()
        .flat_map(|quantity| {
            names::candidates(database, quantity).into_iter().take(3).map(move |n| (quantity, n))
        })
        .filter_map(|(quantity, named)| {
            let mut series = drive.series(database, named.place)?;
            if let Some(sign) = beside::sign(database, named.place, quantity) {
                let bits = drive.series(database, sign)?;
                series.iter_mut().zip(&bits).for_each(|(value, bit)| *value *= 1.0 - 2.0 * bit);
            }
            Some(points(&series))
        })
        .collect()
}

/// Do they turn long enough to be compared, if they are wheels?
fn drives(database: &Database, drive: &Drive, wheels: &Wheels) -> bool {
    let to_mps = RADIUS_M * wheels.unit.to_si().unwrap_or(1.0);
    let turns = |place: &Place| {
        let series = drive.series(database, *place).unwrap_or_default();
        points(&series).iter().filter(|value| *value * to_mps > SLOW).count() >= FEWEST
    };
    wheels.places.iter().any(turns)
}

/// The unit of wheels that have none, by a speed that has one.
fn unit_by_speed(database: &Database, drive: &Drive, wheels: &Wheels) -> Option<Unit> {
    let speed = names::candidates(database, Quantity::VehicleSpeed)
        .into_iter()
        .find(|speed| speed.unit.to_si().is_some() && drive.came(database, speed.place))?;
    let to_si = speed.unit.to_si()?;
    let speed = points(&drive.series(database, speed.place)?);
    let wheel = points(&drive.series(database, wheels.places[0])?);
    let mut ratios: Vec<f64> = speed
        .iter()
        .zip(&wheel)
        .filter(|(v, w)| **v * to_si > 3.0 && **w > 0.0)
        .map(|(v, w)| v * to_si / w)
        .collect();
    ratios.sort_by(f64::total_cmp);
    let ratio = *ratios.get(ratios.len() / 2).filter(|_| ratios.len() > 20)?;
    let units =
        ["km/h", "m/s", "rad/s", "mph", "rpm"].map(|unit| Unit::guessed(Quantity::WheelSpeedFl, unit));
    let off = |unit: &Unit| unit.to_si().map_or(f64::INFINITY, |to_si| (to_si * RADIUS_M / ratio).ln().abs());
    units.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).filter(|unit| off(unit) < 0.15)
}

/// Which corner is which.
pub(super) struct Corners {
    /// Places in the group's order, of front left, front right, rear left, rear right.
    pub(super) order: [usize; 4],
    /// The first side of the motion is the left one.
    pub(super) first_is_left: bool,
    /// What is to be said about it.
    pub(super) notes: Vec<String>,
    /// Front and rear are known.
    pub(super) axles_known: bool,
}

/// Settles the corners: `sensors` are the signs of yaw rate, lateral acceleration and steering angle, each as it
/// is if the motion's first side is the left one.
pub(super) fn corners(wheels: &Wheels, motion: &Motion, sensors: &[f64]) -> Corners {
    let mut notes = Vec::new();
    let [first, second] = motion.sides;
    // What the names say of the first side, axle by axle. In a group's order even places are left ones.
    let named = |axle: usize| -> f64 {
        let left = 2 * axle;
        let here = first.contains(&left) && !first.contains(&(left + 1));
        let there = second.contains(&left) && !second.contains(&(left + 1));
        f64::from(u8::from(here)) - f64::from(u8::from(there))
    };
    let axles = if wheels.corners_named { [named(0), named(1)] } else { [0.0; 2] };
    let by_sensors: f64 = if motion.turned { sensors.iter().sum() } else { 0.0 };
    let total = AXLE * (axles[0] + axles[1]) + by_sensors;
    let first_is_left = total >= 0.0;
    let [left, right] = if first_is_left { [first, second] } else { [second, first] };
    let mut axles_known = wheels.corners_named;
    // The first of a side is the one with the lower place: the front one, by its name.
    let mut ahead = |side: [usize; 2], index: usize| -> [usize; 2] {
        let by_name = wheels.corners_named && (side[0] < 2) != (side[1] < 2);
        let by_data = motion.front.map(|front| front.first[index]);
        axles_known &= by_name || by_data.is_some();
        let keep = if by_name { true } else { by_data.unwrap_or(true) };
        if keep { side } else { [side[1], side[0]] }
    };
    let index = |left: bool| usize::from(left != first_is_left);
    let (left, right) = (ahead(left, index(true)), ahead(right, index(false)));
    let order = [left[0], right[0], left[1], right[1]];
    if !wheels.corners_named {
        axles_known = motion.front.is_some();
        notes.push(match (motion.turned, motion.front) {
            (false, _) => "the recording goes too straight on to tell one wheel from another".into(),
            (true, None) => {
                "left and right wheels are told by the curves and the usual signs of the sensors (a mirror \
                image would fit as well); front and rear are not told: a recording with tight turns would"
                    .to_owned()
            }
            (true, Some(_)) => {
                "wheels are told by the curves: the sides by the usual signs of the sensors (a mirror \
                image would fit as well), the front ones by their larger circles"
                    .into()
            }
        });
        return Corners { order, first_is_left, notes, axles_known };
    }
    if motion.turned && axles == [0.0, 0.0] {
        axles_known = false;
        notes.push("the names of the wheels do not agree with the curves: two that are called an axle turn like one side".into());
    }
    for (axle, name) in ["front", "rear"].iter().enumerate() {
        if motion.turned && axles[axle] != 0.0 && (axles[axle] > 0.0) != first_is_left {
            notes.push(format!(
                "the {name} wheels turn in curves as if left and right were exchanged: they are proposed exchanged"
            ));
        }
    }
    if let Some(front) = motion.front {
        let named_first = motion.sides.map(|side| side[0] < 2 && side[1] >= 2);
        if named_first == [true, true] && front.first == [false, false] {
            notes.push(format!(
                "in tight turns the rear wheels run on larger circles than the front ones ({:.0} standard deviations): \
                 are front and rear exchanged?",
                front.significance
            ));
        }
    }
    Corners { order, first_is_left, notes, axles_known }
}
