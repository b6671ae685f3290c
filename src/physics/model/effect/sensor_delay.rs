//! A late sensor.

use super::{Effect, Kind, Scale, SearchHints, Setting, Spec, channel};
use crate::Quantity;

/// What a sensor says was true a while ago.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SensorDelay {
    quantity: Option<Quantity>,
    delay: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "sensor_delay",
    words: "late {sensor}",
    about: "a sensor is later than the others: filtering, or waiting for the bus",
    equation: "y(t) = x(t − T)",
    source: "signal chain",
    place: "a sensor",
    to_tell_apart: "quick steering or pedal steps: this one channel is late by the same time at every \
                    speed and amplitude, in step with nothing else",
    channels: channel::MEASURED,
    parameters: &[Spec {
        name: "delay_s",
        words: "delay",
        unit: "s",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.04,
        bounds: (-0.1, 0.5),
        step: 0.005,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    // How late an axle's wheels are is an ordinary number.
    search: SearchHints { not_of: channel::WHEELS, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        Box::new(SensorDelay { quantity: setting.quantity(), delay: setting.values[0] })
    },
};

impl Effect for SensorDelay {
    fn delay(&self) -> Option<(Quantity, f64)> {
        self.quantity.map(|quantity| (quantity, self.delay))
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::made;
    use super::*;

    #[test]
    fn it_says_which_and_how_much() {
        let course = super::super::Course::None;
        let effect = made(&KIND, &[0.04], Some(Quantity::YawRate.into()), &course);
        assert_eq!(effect.delay(), Some((Quantity::YawRate, 0.04)));
        assert_eq!(made(&KIND, &[0.04], None, &course).delay(), None);
    }
}
