//! Two channels are taken for each other.

use super::{Channel, Effect, Felt, Kind, Now, Readings, SearchHints, Setting};
use crate::Quantity::{
    LateralAcceleration, LongitudinalAcceleration, WheelSpeedFl, WheelSpeedFr, WheelSpeedRl, WheelSpeedRr,
};

/// Two wheels, or two axes, change places.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ChannelSwap {
    channel: Option<Channel>,
}

/// What can be taken for each other.
const PAIRS: &[Channel] = &[
    Channel::Pair(WheelSpeedFl, WheelSpeedFr),
    Channel::Pair(WheelSpeedRl, WheelSpeedRr),
    Channel::Pair(WheelSpeedFl, WheelSpeedRl),
    Channel::Pair(WheelSpeedFr, WheelSpeedRr),
    Channel::Pair(WheelSpeedFl, WheelSpeedRr),
    Channel::Pair(WheelSpeedFr, WheelSpeedRl),
    Channel::Pair(LateralAcceleration, LongitudinalAcceleration),
];

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "channel_swap",
    words: "{two channels} swapped",
    about: "two channels are taken for each other",
    equation: "y_1 = x_2, y_2 = x_1",
    source: "signal chain",
    place: "two sensors",
    to_tell_apart: "one turn to each side and one acceleration: inner and outer, driven and undriven \
                    wheels tell which is which",
    channels: PAIRS,
    parameters: &[],
    course: None,
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| Box::new(ChannelSwap { channel: setting.channel }),
};

impl Effect for ChannelSwap {
    fn sense(&self, _now: &Now<'_>, _felt: &Felt, _states: &[f64], readings: &mut Readings) {
        if let Some(Channel::Pair(first, second)) = self.channel {
            readings.swap(first as usize, second as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Course;
    use super::super::bench::{Bench, made};
    use super::*;

    #[test]
    fn they_change_places() {
        let effect = made(&KIND, &[], Some(PAIRS[0]), &Course::None);
        let mut readings = std::array::from_fn(|i| i as f64);
        effect.sense(&Bench::driving(20.0).now, &Felt::default(), &[], &mut readings);
        assert_eq!((readings[0], readings[1], readings[2]), (1.0, 0.0, 2.0));
    }
}
