//! A car on which effects are tried, for their tests.

use super::{Acting, Before, Channel, Course, Effect, Felt, Kind, Now, Readings, Recorded, Setting};
use crate::Quantity;
use crate::model::body::Velocity;
use crate::model::{Plant, Vehicle};

/// A plain car and one instant of its drive.
pub(super) struct Bench {
    pub(super) plant: Plant,
    pub(super) now: Now<'static>,
}

impl Bench {
    /// The thesis's car, straight ahead at `speed`, m/s; nothing it borrows is ever changed.
    pub(super) fn driving(speed: f64) -> Self {
        Self::of(&Vehicle::thesis(), speed)
    }

    /// Another one.
    pub(super) fn of(vehicle: &Vehicle, speed: f64) -> Self {
        let plant = Plant::new(vehicle);
        let kept: &'static Plant = Box::leak(Box::new(plant));
        let velocity = Velocity { vx: speed, vy: 0.0, yaw_rate: 0.0 };
        let now = Now::new(kept, vehicle.steering_ratio.value, 0.0, velocity, &Before::default());
        Self { plant, now }
    }

    /// What the plain model has.
    pub(super) fn plain(&self) -> Acting {
        Acting::plain(&self.plant, self.now.steering_wheel, self.now.steering_ratio)
    }

    /// What an effect makes of it.
    pub(super) fn acted(&self, effect: &dyn Effect, states: &[f64]) -> Acting {
        let mut on = self.plain();
        effect.act(&self.now, states, &mut on);
        on
    }

    /// What a stateless effect makes of readings that are all zero.
    pub(super) fn sensed(
        &self,
        kind: &Kind,
        values: &[f64],
        channel: Option<Channel>,
        felt: &Felt,
    ) -> Readings {
        let mut readings = [0.0; Quantity::COUNT];
        made(kind, values, channel, &Course::None).sense(&self.now, felt, &[], &mut readings);
        readings
    }

    /// The rates of an effect's states.
    pub(super) fn rates(&self, effect: &dyn Effect, felt: &Felt, states: &[f64]) -> Vec<f64> {
        let mut rates = vec![f64::NAN; effect.states()];
        effect.rates(&self.now, felt, states, &mut rates);
        rates
    }

    /// The effect's states at its beginning.
    pub(super) fn begun(&self, effect: &dyn Effect) -> Vec<f64> {
        let mut states = vec![f64::NAN; effect.states()];
        effect.begin(&self.now, &mut states);
        states
    }
}

/// An effect of a kind.
pub(super) fn made(
    kind: &Kind,
    values: &[f64],
    channel: Option<Channel>,
    course: &Course,
) -> Box<dyn Effect> {
    kind.effect(&Setting { values, channel, course })
}

/// What an effect of the measurement chain does to each input, it undoes.
pub(super) fn undoes(kind: &Kind, values: &[f64], course: &Course) {
    let inputs = [Quantity::SteeringWheelAngle, Quantity::DriveTorque, Quantity::BrakePressure];
    let mut bench = Bench::driving(20.0);
    bench.now.t = 5.0;
    for quantity in inputs {
        let effect = made(kind, values, Some(quantity.into()), course);
        let mut readings = [3.0; Quantity::COUNT];
        effect.sense(&bench.now, &Felt::default(), &[], &mut readings);
        assert_ne!(readings[quantity as usize], 3.0);
        let [steering_wheel, drive_torque, brake_pressure] = inputs.map(|input| readings[input as usize]);
        let mut recorded = Recorded { steering_wheel, drive_torque, brake_pressure };
        effect.undo(5.0, &mut recorded);
        let undone = [recorded.steering_wheel, recorded.drive_torque, recorded.brake_pressure];
        assert!(undone.iter().all(|value| (value - 3.0).abs() < 1e-12), "{undone:?}");
    }
}

/// An effect of the car without a course.
pub(super) fn simple(kind: &Kind, values: &[f64]) -> Box<dyn Effect> {
    made(kind, values, None, &Course::None)
}

/// An effect of the car whose course always has this value.
pub(super) fn constant(kind: &Kind, values: &[f64], value: f64) -> Box<dyn Effect> {
    made(kind, values, None, &Course::Constant(value))
}
