//! Candidates by what they are called, by their unit and by what their bits can carry.

use super::source::{Place, Unit, greatest, is_flag, is_number};
use super::vocabulary;
use crate::dbc::{Database, Signal};
use physics::Quantity;

/// A signal that by its name may be a quantity.
#[derive(Clone, Debug)]
pub(super) struct Named {
    pub(super) place: Place,
    /// 0 to 1: from 0.6 on it is taken for it if nothing says otherwise, below 0.35 it is not mentioned.
    pub(super) score: f64,
    pub(super) unit: Unit,
}

/// Names worth mentioning.
pub(super) const MENTIONED: f64 = 0.35;
/// Names that are enough by themselves.
pub(super) const ENOUGH: f64 = 0.6;

/// All signals that may be a quantity other than a wheel's speed, best first.
pub(super) fn candidates(database: &Database, quantity: Quantity) -> Vec<Named> {
    let mut found: Vec<Named> =
        Place::all(database).filter_map(|place| judge(database, place, quantity)).collect();
    found.retain(|named| named.score >= MENTIONED);
    // The first in the file where nothing else decides.
    found.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.place.cmp(&b.place)));
    found
}

/// How well a signal's name, unit and range fit.
pub(super) fn judge(database: &Database, place: Place, quantity: Quantity) -> Option<Named> {
    let (_, signal) = place.find(database)?;
    // A flag may have more bits than it needs, if the file says that it is 0 or 1.
    let is_bit = signal.size == 1 || (signal.min, signal.max, signal.factor) == (0.0, 1.0, 1.0);
    if is_flag(quantity) { is_bit } else { is_number(signal) }.then_some(())?;
    let words = vocabulary::of(quantity).score(&place.spoken(database)?, is_flag(quantity));
    if words <= 0.0 {
        return None;
    }
    let unit = Unit::of(quantity, signal);
    if unit == Unit::Unfitting {
        return None;
    }
    Some(Named { place, score: words * technical(quantity, signal, &unit), unit })
}

/// Unit, range and resolution, as a factor.
pub(super) fn technical(quantity: Quantity, signal: &Signal, unit: &Unit) -> f64 {
    if is_flag(quantity) {
        return 1.0;
    }
    let mut factor = match unit {
        Unit::Known(_) => 1.0,
        Unit::Guessed(..) => 0.8,
        Unit::Unknown => 0.55,
        Unit::Unfitting => return 0.0,
    };
    if let Some(to_si) = unit.to_si() {
        let [most, step] = needed(quantity);
        if greatest(signal) * to_si.abs() < most {
            return 0.0;
        }
        // Coarser than of use.
        if (signal.factor * to_si).abs() > step {
            factor *= 0.85;
        }
    }
    if !signal.mux().is_always() {
        factor *= 0.95;
    }
    factor
}

/// The least that the bits of any car's sensor carry, and the coarsest step that helps, SI.
fn needed(quantity: Quantity) -> [f64; 2] {
    match quantity {
        Quantity::YawRate => [0.4, 0.011],
        Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration => [4.0, 0.11],
        // One part of the whole may be coarse, and another fine.
        Quantity::SteeringWheelAngle => [3.0, 0.03],
        Quantity::DriveTorque | Quantity::BrakeTorque => [200.0, 60.0],
        Quantity::BrakePressure => [50.0, 1.5],
        Quantity::VehicleSpeed => [30.0, 0.3],
        Quantity::WheelSpeedFl | Quantity::WheelSpeedFr | Quantity::WheelSpeedRl | Quantity::WheelSpeedRr => {
            [80.0, 0.4]
        }
        Quantity::BrakeActive | Quantity::AbsActive => [0.0, f64::INFINITY],
    }
}
