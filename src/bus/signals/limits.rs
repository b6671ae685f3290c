//! What a quantity can be and how fast it can change: the check of each value as it comes.

use physics::{Micros, Quantity};

/// Frames that must agree on a new level before it is believed.
const AGREEING: u8 = 3;
/// Frames can come in a burst although they were measured a period apart: no less than this counts as
/// the time between two values.
const SHORTEST_S: f64 = 0.01;

/// Bounds of a quantity, SI. They are wide: a value outside is a broken sensor or a wrong mapping, not
/// an extraordinary manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    pub(super) min: f64,
    pub(super) max: f64,
    /// Per second.
    pub(super) rate_max: f64,
}

impl Limits {
    /// The bounds of a quantity where `[signals]` gives none.
    ///
    /// | quantity | range | fastest change |
    /// |---|---|---|
    /// | wheel speed | −400…400 rad/s (430 km/h with 0.3 m) | 5000 rad/s²: a wheel locked on ice by 5 kN m |
    /// | yaw rate | ±5 rad/s | 60 rad/s² |
    /// | accelerations | ±50 m/s² | 10 000 m/s³: a kerb |
    /// | steering wheel | ±30 rad (two times lock to lock) | 100 rad/s |
    /// | drive torque | ±50 000 N m | none |
    /// | brake torque | −1000…60 000 N m | none |
    /// | brake pressure | −10…500 bar | none |
    /// | vehicle speed | −40…150 m/s | 1000 m/s² |
    /// | flags | none | none |
    pub(super) fn typical(quantity: Quantity) -> Self {
        let (min, max, rate_max) = match quantity {
            _ if quantity.wheel().is_some() => (-400.0, 400.0, 5000.0),
            Quantity::YawRate => (-5.0, 5.0, 60.0),
            Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration => (-50.0, 50.0, 1e4),
            Quantity::SteeringWheelAngle => (-30.0, 30.0, 100.0),
            Quantity::DriveTorque => (-5e4, 5e4, f64::INFINITY),
            Quantity::BrakeTorque => (-1e3, 6e4, f64::INFINITY),
            Quantity::BrakePressure => (-10.0, 500.0, f64::INFINITY),
            Quantity::VehicleSpeed => (-40.0, 150.0, 1e3),
            _ => (f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY),
        };
        Self { min, max, rate_max }
    }

    #[inline]
    pub(super) fn holds(&self, value: f64) -> bool {
        self.min <= value && value <= self.max
    }

    #[inline]
    fn reaches(&self, from: (Micros, f64), to: (Micros, f64)) -> bool {
        // Infinity times zero would be no number.
        self.rate_max == f64::INFINITY
            || (to.1 - from.1).abs() <= self.rate_max * (to.0 - from.0).seconds().max(SHORTEST_S)
    }
}

/// Judges a quantity's rate of change, value by value.
///
/// A lone spike is refused. A level that three values in a row agree on is believed, however far it is
/// from the last: a sensor that recovers must not be locked out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RateCheck {
    accepted: Option<(Micros, f64)>,
    candidate: Option<(Micros, f64)>,
    agreeing: u8,
}

impl RateCheck {
    /// May this value be used? `forget` is how long an accepted value says anything of the next.
    #[inline]
    pub(super) fn accepts(&mut self, limits: &Limits, forget: Micros, time: Micros, value: f64) -> bool {
        let new = (time, value);
        let plausible = match self.accepted {
            Some(last) if time - last.0 <= forget => limits.reaches(last, new),
            _ => true,
        };
        if !plausible {
            let agrees = self.candidate.is_some_and(|candidate| limits.reaches(candidate, new));
            self.agreeing = if agrees { self.agreeing + 1 } else { 1 };
            self.candidate = Some(new);
            if self.agreeing < AGREEING {
                return false;
            }
        }
        *self = Self { accepted: Some(new), candidate: None, agreeing: 0 };
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORGET: Micros = Micros::from_millis(200);

    fn accepted(values: &[(i64, f64)]) -> Vec<bool> {
        let limits = Limits::typical(Quantity::YawRate);
        let mut check = RateCheck::default();
        values
            .iter()
            .map(|&(ms, value)| check.accepts(&limits, FORGET, Micros::from_millis(ms), value))
            .collect()
    }

    #[test]
    fn a_spike_is_refused_and_a_new_level_believed() {
        assert_eq!(accepted(&[(0, 0.1), (10, 3.0), (20, 0.1)]), [true, false, true]);
        assert_eq!(
            accepted(&[(0, 0.1), (10, 3.0), (20, 3.1), (30, 3.0), (40, 3.0)]),
            [true, false, false, true, true]
        );
    }

    #[test]
    fn noise_between_extremes_is_never_believed() {
        let wild = [(0, 0.0), (10, 4.0), (20, -4.0), (30, 4.0), (40, -4.0), (50, 4.0)];
        assert_eq!(accepted(&wild), [true, false, false, false, false, false]);
    }

    #[test]
    fn a_burst_of_frames_is_no_jump_and_after_a_silence_anything_may_be() {
        assert_eq!(accepted(&[(0, 0.0), (0, 0.5), (0, 1.0)]), [true; 3]);
        assert_eq!(accepted(&[(0, 0.0), (500, 4.0)]), [true; 2]);
    }
}
