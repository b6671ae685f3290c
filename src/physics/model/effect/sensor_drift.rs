//! A sensor whose zero drifts.

use super::{
    Acting, Course, Disturbance, Effect, Felt, Kind, Now, Readings, Recorded, SearchHints, Setting, channel,
    kind::OF_CHANNEL,
};
use crate::Quantity;

/// A course of the sensor's zero.
#[derive(Clone, Debug, PartialEq)]
struct SensorDrift {
    quantity: Option<Quantity>,
    drift: Course,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "sensor_drift",
    words: "drifting zero of {a sensor}",
    about: "a sensor's zero drifts: temperature, a slow reset",
    equation: "y = x + u(t)",
    source: "signal chain",
    place: "a sensor",
    to_tell_apart: "standing still and straight ahead now and then: the zero moves without any motion of \
                    the car",
    channels: channel::MEASURED,
    parameters: &[],
    course: Some(Disturbance {
        unit: OF_CHANNEL,
        rms_name: "drift_rms",
        words: "drift, rms",
        size: 1.0,
        length_s: 20.0,
        sign: 0.0,
        shortest_s: 8.0,
        has_its_mean_in_an_offset: true,
        ..Disturbance::USUAL
    }),
    // A torque that drifts is a road grade.
    search: SearchHints { not_of: channel::TORQUES, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        Box::new(SensorDrift { quantity: setting.quantity(), drift: setting.course.clone() })
    },
};

impl Effect for SensorDrift {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        // While a filter estimates it, what was recorded is put right here; otherwise `undo` has done so.
        if matches!(self.drift, Course::Live(_)) && self.quantity == Some(Quantity::SteeringWheelAngle) {
            on.steering_wheel -= self.drift.at(now);
        }
    }

    fn sense(&self, now: &Now<'_>, _felt: &Felt, _states: &[f64], readings: &mut Readings) {
        if let Some(quantity) = self.quantity {
            readings[quantity as usize] += self.drift.at(now);
        }
    }

    fn undo(&self, t: f64, recorded: &mut Recorded) {
        if let Some(value) = self.quantity.and_then(|quantity| recorded.get_mut(quantity)) {
            *value -= self.drift.at_time(t);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Series;
    use super::super::bench::{Bench, made, undoes};
    use super::*;

    #[test]
    fn it_follows_its_course() {
        let mut bench = Bench::driving(20.0);
        let course = Course::Series(Series { t: vec![0.0, 10.0], value: vec![0.0, 0.02] });
        bench.now.t = 5.0;
        let effect = made(&KIND, &[], Some(Quantity::YawRate.into()), &course);
        let mut readings = [0.0; Quantity::COUNT];
        effect.sense(&bench.now, &Felt::default(), &[], &mut readings);
        assert!((readings[Quantity::YawRate as usize] - 0.01).abs() < 1e-12);
        let size = KIND.disturbance(Some(Quantity::LateralAcceleration.into())).map(|course| course.size);
        assert_eq!(size, Some(0.2));
    }

    #[test]
    fn what_it_does_to_inputs_is_undone() {
        undoes(&KIND, &[], &Course::Constant(0.1));
    }
}
