//! A sensor that jumps.

use super::{
    Effect, Felt, Growth, Kind, Now, Readings, Recorded, Scale, SearchHints, Setting, Spec, channel,
    kind::OF_CHANNEL,
};
use crate::Quantity;

/// From a moment on a sensor reads too much by a constant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SensorBias {
    quantity: Option<Quantity>,
    bias: f64,
    at: f64,
}

impl SensorBias {
    fn at(&self, t: f64) -> f64 {
        if t >= self.at { self.bias } else { 0.0 }
    }
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "sensor_bias",
    words: "jump in the zero of {a sensor}",
    about: "from a moment on a sensor reads too much (or too little) by a constant",
    equation: "y = x + b from t ≥ at",
    source: "signal chain",
    place: "a sensor",
    to_tell_apart: "standing still and straight ahead before and after: the jump is there without any \
                    motion",
    channels: channel::MEASURED,
    parameters: &[
        Spec {
            name: "bias",
            words: "jump",
            unit: OF_CHANNEL,
            scale: Scale::Linear,
            mean: 0.0,
            std: 1.0,
            bounds: (-20.0, 20.0),
            step: 0.1,
            model_error: Spec::MODEL_ERROR,
            is_main: true,
        },
        Spec::AT_S,
    ],
    course: None,
    // A wheel whose speed steps has another radius.
    search: SearchHints { not_of: channel::WHEELS, growth: Growth::Proportional, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        Box::new(SensorBias { quantity: setting.quantity(), bias: setting.values[0], at: setting.values[1] })
    },
};

impl Effect for SensorBias {
    fn sense(&self, now: &Now<'_>, _felt: &Felt, _states: &[f64], readings: &mut Readings) {
        if let Some(quantity) = self.quantity {
            readings[quantity as usize] += self.at(now.t);
        }
    }

    fn undo(&self, t: f64, recorded: &mut Recorded) {
        if let Some(value) = self.quantity.and_then(|quantity| recorded.get_mut(quantity)) {
            *value -= self.at(t);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Course;
    use super::super::bench::{Bench, undoes};
    use super::*;

    #[test]
    fn it_jumps_at_its_time() {
        let mut bench = Bench::driving(20.0);
        let channel = Some(Quantity::YawRate.into());
        for (t, expected) in [(9.9, 0.0), (10.0, 0.02)] {
            bench.now.t = t;
            let readings = bench.sensed(&KIND, &[0.02, 10.0], channel, &Felt::default());
            assert_eq!(readings[Quantity::YawRate as usize], expected);
        }
    }

    #[test]
    fn its_usual_size_is_the_channels() {
        let spec = KIND.spec(0, Some(Quantity::YawRate.into())).unwrap();
        assert_eq!((spec.unit, spec.std), ("rad/s", 0.01));
        assert!((spec.bounds.1 - 0.2).abs() < 1e-12);
    }

    #[test]
    fn what_it_does_to_inputs_is_undone() {
        undoes(&KIND, &[0.1, 4.0], &Course::None);
    }
}
