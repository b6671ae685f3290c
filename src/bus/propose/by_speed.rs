//! What the car did where no wheels tell it: by the vehicle's speed and the sensor that is called yaw rate, if others
//! confirm them.

use super::beside;
use super::drive::Drive;
use super::motion::{Confirmed, FEWEST, Motion, SLOW, TRACK_M, derivative, deviation, points};
use super::names::{self, ENOUGH, Named};
use super::regression::line;
use crate::dbc::Database;
use physics::Quantity;

/// Correlation from which on a sensor confirms another: higher than with wheels, for both are known by name only. Tuned:
/// the recordings of `tests/commands/map` confirm with 0.9 and more, files of other cars with less than 0.5.
const CONFIRMS: f64 = 0.8;
/// Candidates of each quantity that are tried.
const TRIED: usize = 3;

/// The motion by names alone, if a lateral acceleration is in proportion to speed × yaw rate, or a steering angle to the
/// curvature.
pub(super) fn motion(database: &Database, drive: &Drive) -> Option<Motion> {
    let speeds = called(database, drive, Quantity::VehicleSpeed);
    let turns = called(database, drive, Quantity::YawRate);
    let pairs = speeds.iter().flat_map(|speed| turns.iter().map(move |turn| (speed, turn)));
    let motions = pairs.filter_map(|(speed, turn)| of(database, drive, speed, turn));
    let by_strength = |motion: &Motion| motion.confirmed.as_ref().map_or(0.0, |told| told.correlation);
    motions.reduce(|best, other| if by_strength(&other) > by_strength(&best) { other } else { best })
}

/// Signals that are called so well enough, and come.
fn called(database: &Database, drive: &Drive, quantity: Quantity) -> Vec<Named> {
    let mut named = names::candidates(database, quantity);
    named.retain(|named| {
        let varies = drive.channel(database, named.place).is_some_and(|channel| channel.varies());
        named.score >= ENOUGH && named.unit.to_si().is_some() && varies
    });
    named.truncate(TRIED);
    named
}

fn of(database: &Database, drive: &Drive, speed: &Named, turn: &Named) -> Option<Motion> {
    let raw: Vec<f64> = scaled(drive.series(database, speed.place)?, speed.unit.to_si()?);
    let all = points(&raw);
    let moving = all.iter().filter(|v| **v > SLOW).count();
    if moving < FEWEST || all.iter().any(|v| *v > 150.0) || deviation(&all) < 0.05 {
        return None;
    }
    let speed: Vec<f64> = all.iter().map(|v| if *v > SLOW { *v } else { f64::NAN }).collect();
    let turn = si(database, drive, turn, Quantity::YawRate)?;
    let difference = turn.iter().zip(&speed).map(|(r, v)| if v.is_nan() { *v } else { TRACK_M * r });
    let mut motion = Motion {
        change: derivative(&raw),
        difference: difference.collect(),
        speed,
        turn,
        sides: [[0, 2], [1, 3]],
        turned: true,
        front: None,
        confirmed: None,
    };
    motion.confirmed = confirmed(database, drive, &motion);
    motion.confirmed.is_some().then_some(motion)
}

/// By the sensor that follows it best.
fn confirmed(database: &Database, drive: &Drive, motion: &Motion) -> Option<Confirmed> {
    let laws = [
        (Quantity::LateralAcceleration, motion.lateral(), "a lateral acceleration", 0.6..1.6),
        // A steering angle over the curvature: wheelbase times ratio, m.
        (Quantity::SteeringWheelAngle, motion.steering(), "a steering angle", 15.0..95.0),
    ];
    let mut best: Option<Confirmed> = None;
    for (quantity, law, with, possible) in laws {
        for named in called(database, drive, quantity) {
            let Some(found) = si(database, drive, &named, quantity).and_then(|series| line(&series, &[&law]))
            else {
                continue;
            };
            let correlation = found.correlation.abs();
            let is_possible = found.factors.first().is_some_and(|slope| possible.contains(&slope.abs()));
            if is_possible
                && correlation > CONFIRMS
                && best.as_ref().is_none_or(|best| correlation > best.correlation)
            {
                best = Some(Confirmed { correlation, with });
            }
        }
    }
    best
}

/// The points of a signal in SI, its sign put in.
fn si(database: &Database, drive: &Drive, named: &Named, quantity: Quantity) -> Option<Vec<f64>> {
    let mut series = drive.series(database, named.place)?;
    if let Some(sign) = beside::sign(database, named.place, quantity) {
        let bits = drive.series(database, sign)?;
        series.iter_mut().zip(&bits).for_each(|(value, bit)| *value *= 1.0 - 2.0 * bit);
    }
    Some(scaled(points(&series), named.unit.to_si()?))
}

fn scaled(series: Vec<f64>, factor: f64) -> Vec<f64> {
    series.into_iter().map(|value| factor * value).collect()
}
