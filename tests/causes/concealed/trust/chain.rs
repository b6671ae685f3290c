//! Sensors, bus, seeds, and causes at no strength.

use super::super::bus;
use super::super::cause::{CAUSES, Cause, Tires};
use super::super::drive::{self, Kind, Plan};
use super::super::hidden::{CHANNELS, SensorFault};
use super::super::recipe;
use super::super::recording::{Order, Recording};
use super::super::sensors::{Chain, NOISE};
use super::super::visible;
use super::*;

/// Moments of a car that speeds up at 2 rad/s² of its wheels and turns faster and faster.
fn ramp() -> Vec<Moment> {
    (0..4000)
        .map(|k| {
            let t = k as f64 * STEP;
            let mut m = Moment { u: 20.0, r: 0.01 * t, force: [0.3, 0.5 * t], ..Moment::default() };
            m.input.steering = 0.1 * t;
            m.omega = [60.0 + 2.0 * t; 4];
            m.angle = [60.0 * t + t * t; 4];
            m
        })
        .collect()
}

#[test]
fn sensors_show_what_is_there_when_it_was_there() {
    let (moments, chain) = (ramp(), Chain::default());
    let shows = |hidden: &Hidden, channel: usize| chain.shows(&moments, STEP, hidden, channel, 2.0);
    let ideal = Hidden::default();
    // A mean over 10 ms that leaves 1 ms later is 6 ms old.
    close(shows(&ideal, 0), 60.0 + 2.0 * (2.0 - 0.006), 1e-9, "wheel");
    close(shows(&ideal, 4), 0.02, 1e-9, "yaw rate");
    close(shows(&ideal, 5), 1.0, 1e-9, "lateral acceleration");
    let fault = |channel: usize, fault: SensorFault| {
        let mut hidden = Hidden::default();
        hidden.faults[channel] = fault;
        shows(&hidden, channel)
    };
    close(fault(4, SensorFault { delay: 0.5, ..SensorFault::default() }), 0.015, 1e-9, "delay");
    close(fault(4, SensorFault { scale: 0.1, ..SensorFault::default() }), 0.022, 1e-9, "scale");
    close(fault(7, SensorFault { negative: true, ..SensorFault::default() }), -0.2, 1e-9, "sign");
    close(fault(5, SensorFault { step: Some((1.9, 0.3)), ..SensorFault::default() }), 1.3, 1e-9, "bias");
    close(
        fault(5, SensorFault { step: Some((2.1, 0.3)), ..SensorFault::default() }),
        1.0,
        1e-9,
        "no bias yet",
    );
    close(fault(5, SensorFault { clip: Some(0.7), ..SensorFault::default() }), 0.7, 1e-9, "clip");
    let mut swapped = moments.clone();
    swapped.iter_mut().for_each(|m| m.angle[1] *= 1.1);
    let shown = chain.shows(&swapped, STEP, &Hidden { swap: Some((0, 1)), ..Hidden::default() }, 0, 2.0);
    close(shown, 1.1 * 63.988, 1e-9, "swapped wheel");
    // Forward of the centre of gravity: + x r' across, − x r² along.
    let away = Hidden { accelerometer_at: 0.7, ..Hidden::default() };
    close(shows(&away, 6), 0.3 - 0.7 * 0.02 * 0.02, 1e-9, "longitudinal away from the centre");
}

#[test]
fn a_tooth_wheel_errs_as_it_turns_and_not_on_average() {
    let mut moments = ramp();
    (0..moments.len()).for_each(|k| moments[k].angle = [0.06 * k as f64; 4]);
    let chain = Chain::random(&mut Dice::new(3, 3));
    let shown: Vec<f64> = (100..3900)
        .map(|k| chain.shows(&moments, STEP, &Hidden::default(), 2, k as f64 * STEP) - 60.0)
        .collect();
    let mean = shown.iter().sum::<f64>() / shown.len() as f64;
    let spread = (shown.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / shown.len() as f64).sqrt();
    assert!(mean.abs() < 5e-3 && spread > 2e-3 && spread < NOISE[2], "{mean} {spread}");
}

#[test]
fn the_log_says_what_the_sensors_show() {
    let moments = ramp();
    let hidden = Hidden::default();
    let log = bus::candump(&moments, 4.0, &hidden, &Chain::default(), &mut Dice::new(1, 1));
    let mut last = 0.0;
    let (mut errors, mut counts) = ([0.0f64; 3], [0usize; 3]);
    for line in log.lines() {
        let mut words = line.split(' ');
        let stamp: f64 = words.next().unwrap().trim_matches(['(', ')']).parse().unwrap();
        assert!(stamp >= last, "frames in order");
        last = stamp;
        let (id, hex) = words.nth(1).unwrap().split_once('#').unwrap();
        let bytes: Vec<u8> =
            (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect();
        let code = |at: usize| f64::from(i16::from_le_bytes([bytes[at], bytes[at + 1]]));
        let t = stamp - 1_770_000_000.0;
        let (which, error) = match id {
            "1A0" if t > 0.1 => (0, (code(0) / 128.0 - 60.0 - 2.0 * (t - 0.006)) / NOISE[0]),
            "1B0" => (1, (code(0) * 1e-4 - 0.01 * t) / NOISE[4]),
            "1C0" => (2, (code(0) * 0.001_745_33 - 0.1 * t) / NOISE[7]),
            _ => continue,
        };
        errors[which] += error * error;
        counts[which] += 1;
    }
    assert!(counts[0] > 190 && counts[1] > 390 && counts[2] > 390, "{counts:?}");
    for (error, count) in errors.iter().zip(counts) {
        // White noise, quantisation (which is most of the steering's), and half a millisecond of clock.
        let rms = (error / count as f64).sqrt();
        assert!(rms > 0.85 && rms < 1.3, "{rms}");
    }
}

#[test]
fn a_seed_gives_the_same_recording_for_ever() {
    let order =
        Order { factor: 0.5, number: 3, seconds: Some(30.0), ..Order::of(Cause::find("road_bank"), 8) };
    let (one, two) = (Recording::make(order).unwrap(), Recording::make(order).unwrap());
    assert!(one.log == two.log && one.toml == two.toml && one.truth() == two.truth());
    let other = Recording::make(Order { number: 4, ..order }).unwrap();
    assert!(other.log != one.log && other.toml != one.toml);
    // Nothing in what the program is given tells the cause, and the number does not reach it.
    assert!(!one.toml.contains("bank") && !one.log.contains("bank"));
}

/// What every channel shows each 20 ms, over its noise.
fn shown(moments: &[Moment], hidden: &Hidden) -> Vec<[f64; CHANNELS]> {
    let chain = Chain::default();
    let at = |t: f64| {
        std::array::from_fn(|c| chain.shows(moments, STEP, hidden, c, t) / NOISE[c].max(0.1 * NOISE[4]))
    };
    (2..moments.len() / 20).map(|k| at(k as f64 * 0.020)).collect()
}

#[test]
fn a_cause_at_no_strength_changes_nothing_and_at_its_own_it_does() {
    let mut dice = Dice::new(21, 1);
    let (linear, magic) = (Car::random(&mut dice, false), Car::random(&mut dice, true));
    let plan = Plan::random(Kind::Mixed, 24.0, 6.0, &mut dice);
    let plain = |car: &Car| shown(&drive::drive(&plan, car, &Hidden::default()), &Hidden::default());
    let (plain_linear, plain_magic) = (plain(&linear), plain(&magic));
    for cause in CAUSES {
        let (car, plain) =
            if cause.tires == Tires::Magic { (&magic, &plain_magic) } else { (&linear, &plain_linear) };
        let difference = |factor: f64| {
            let made = recipe::make((cause, factor), &plan, car, Hidden::default(), &mut Dice::new(21, 2));
            let other = shown(&drive::drive(&plan, car, &made.hidden), &made.hidden);
            let worst =
                plain.iter().zip(&other).flat_map(|(p, o)| p.iter().zip(o).map(|(a, b)| (a - b).abs()));
            worst.fold(0.0f64, |m, x| if x.is_finite() { m.max(x) } else { f64::INFINITY })
        };
        // Clipping and a torque limit begin where the drive's own peak is; the others are gone.
        if cause.has_strength() && !matches!(cause.key, "sensor_clip" | "torque_limit") {
            assert!(difference(0.0) < 1e-9, "{} is there at no strength: {}", cause.key, difference(0.0));
        }
        if cause.key == "control" {
            assert!(difference(1.0) == 0.0, "a control has something hidden");
        } else {
            assert!(difference(1.0) > 0.05, "{} does nothing: {}", cause.key, difference(1.0));
        }
    }
}

#[test]
fn what_is_visible_grows_with_the_square_of_its_strength() {
    let look = |key: &str, factor: f64| {
        let cause = Cause::find(key);
        let order = Order { factor, number: 2, seconds: Some(20.0), ..Order::of(cause, 12) };
        let recording = Recording::make(order).unwrap();
        let seen = visible::visibility(&recording.car, &recording.moments, &recording.made, None);
        (recording, seen)
    };
    let ((_, small), (_, large)) = (look("accelerometer_position", 0.5), look("accelerometer_position", 1.0));
    let ratio = large.likelihood_ratio / small.likelihood_ratio;
    assert!(ratio > 3.0 && ratio < 5.0, "{ratio}: {} {}", small.likelihood_ratio, large.likelihood_ratio);
    // What ordinary parameters can follow is not visible.
    let (recording, seen) = look("payload_within_doubt", 1.0);
    assert!(seen.likelihood_ratio < visible::DETECTABLE, "{}", seen.likelihood_ratio);
    assert!(recording.made.hidden.payload > 20.0);
}

#[test]
fn the_dice_are_fair() {
    let mut dice = Dice::new(1, 1);
    let n = 40_000;
    let (mut mean, mut square, mut units) = (0.0, 0.0, 0.0);
    for _ in 0..n {
        let z = dice.normal();
        mean += z / f64::from(n);
        square += z * z / f64::from(n);
        units += dice.unit() / f64::from(n);
    }
    assert!(mean.abs() < 0.02 && (square - 1.0).abs() < 0.03 && (units - 0.5).abs() < 0.006);
}
