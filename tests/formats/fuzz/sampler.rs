//! From frames to samples.

use std::sync::OnceLock;

use gripd::can::Frame;
use gripd::signals::{Inputs, Sampler};
use gripd::{Micros, Quantity, Sample};

use super::run::fuzz;
use testing::demo_car as car;
use testing::frames::traffic;

fn sampler() -> Sampler {
    static NEW: OnceLock<Sampler> = OnceLock::new();
    let make = || {
        let config = car::config();
        let radius = config.vehicle.wheel_radius_m.value;
        let inputs = Inputs::compile(&config.signals, &config.input_database().unwrap(), radius).unwrap();
        Sampler::new(inputs, &config.signals.sampling)
    };
    NEW.get_or_init(make).clone()
}

/// Numbers, later than the sample before unless the frames' clock was set back, and not for ever.
fn check(frames: &[Frame]) {
    let mut sampler = sampler();
    let mut last: Option<Sample> = None;
    let mut newest = Micros(i64::MIN);
    let mut made = 0;
    for frame in frames {
        if sampler.inputs().ids().contains(&frame.id) && newest - frame.time > Micros::from_millis(1000) {
            (newest, last) = (frame.time, None);
        }
        newest = newest.max(frame.time);
        sampler.push(frame);
        while let Some(sample) = sampler.next_sample() {
            made += 1;
            for quantity in Quantity::ALL {
                assert!(sample.get(quantity).is_none_or(f64::is_finite), "{sample:?}");
            }
            assert!(sample.elapsed_s > 0.0, "{sample:?}");
            assert!(last.is_none_or(|last| sample.time > last.time), "{last:?} {sample:?}");
            assert!(made < 200 * frames.len(), "no end");
            last = Some(sample);
        }
    }
    sampler.flush();
    assert!(std::iter::from_fn(|| sampler.next_sample()).take(1000).count() < 1000, "no end");
}

#[test]
fn samples() {
    fuzz("sampler", 1000, |dice| traffic(dice, car::drive()), |frames| check(frames));
}
