//! The mapping: from configured names to values in SI ([`sending`]: and back into frames).

mod altering;
mod cars;
mod sending;

use gripd::can::Frame;
use gripd::signals::{Inputs, Outputs, Pushed, Sampler};
use gripd::{Faults, Micros, Quantity, Sample};
use testing::small_car as car;

fn problems(text: &str) -> Vec<String> {
    let config = car::config(text);
    match Inputs::compile(&config, &car::database(), car::RADIUS) {
        Ok(_) => Vec::new(),
        Err(error) => error.problems.iter().map(ToString::to_string).collect(),
    }
}

/// The one problem of a mapping that is right but for one quantity's line.
fn problem(line: &str) -> String {
    let quantity = line.split([' ', '=']).next().unwrap();
    let mut found = problems(&format!("{}{line}\n", car::signals_without(quantity)));
    assert_eq!(found.len(), 1, "{found:?}");
    found.remove(0)
}

/// One sample of a car whose frames all came at 0 and 5 ms.
fn sample(more: &str, frames: &[Frame]) -> Sample {
    let mut sampler = car::sampler(more);
    let mut all = Vec::new();
    for ms in [0.0, 10.0] {
        all.extend([car::wheels(ms, 54.0), car::esp(ms, -10.0, 2.5), car::steering(ms, 3, -5)]);
    }
    all.extend(frames);
    *car::run(&mut sampler, &all, true).last().unwrap()
}

fn close(value: Option<f64>, expected: f64) {
    assert!(value.is_some_and(|v| (v - expected).abs() < 1e-9), "{value:?} is not {expected}");
}

#[test]
fn units_sign_bits_and_sums_become_si() {
    let sample = sample("", &[]);
    close(sample.get(Quantity::WheelSpeedRr), 15.0 / car::RADIUS);
    close(sample.get(Quantity::YawRate), -10f64.to_radians());
    close(sample.get(Quantity::LateralAcceleration), 2.5);
    close(sample.get(Quantity::SteeringWheelAngle), 4f64.to_radians());
    assert_eq!(sample.faults, Faults::empty());
}

#[test]
fn gain_and_offset_apply_after_the_unit_in_si() {
    let more = "longitudinal_acceleration = { signal = \"ESP.AccLon\", gain = -2, offset = 0.5 }";
    let mut data = [0; 8];
    data[5] = 0x40; // AccLon, 12 bits from bit 44: raw 0x064 = 1 g
    data[6] = 0x06;
    let sample = sample(more, &[car::frame(11.0, car::ESP, &data), car::wheels(20.0, 54.0)]);
    close(sample.get(Quantity::LongitudinalAcceleration), -2.0 * 9.80665 + 0.5);
}

#[test]
fn a_quality_bit_takes_the_value_away_and_says_so() {
    let mut bad = car::esp(15.0, 10.0, 1.0).data().to_vec();
    bad[1] |= 1 << 4;
    let sample = sample("", &[car::frame(15.0, car::ESP, &bad), car::wheels(20.0, 54.0)]);
    assert_eq!(sample.get(Quantity::YawRate), None);
    assert_eq!(sample.faults, Faults::NOT_AVAILABLE);
    // The acceleration of the same frame has no such bit.
    assert!(sample.get(Quantity::LateralAcceleration).is_some());
}

#[test]
fn a_quality_signal_may_have_any_good_values_and_stand_in_another_message() {
    let signals = car::signals_without("yaw_rate")
        + "yaw_rate = { signal = \"ESP.Yaw\", valid = \"MUXED.Page\", valid_when = [2, 3] }";
    let yaw = |page: Option<u8>| {
        let config = car::config(&signals);
        let inputs = Inputs::compile(&config, &car::database(), car::RADIUS).unwrap();
        let mut frames: Vec<_> =
            page.iter().map(|page| car::frame(0.0, car::MUXED, &[*page, 0, 0, 0])).collect();
        frames.extend([car::wheels(1.0, 54.0), car::steering(1.0, 0, 0), car::esp(1.0, 5.0, 0.0)]);
        frames.push(car::wheels(600.0, 54.0));
        let samples = car::run(&mut Sampler::new(inputs, &config.sampling), &frames, true);
        samples.first().map(|sample| (sample.get(Quantity::YawRate), sample.faults))
    };
    assert_eq!(yaw(Some(3)).unwrap().0, Some(5f64.to_radians()));
    assert_eq!(yaw(Some(1)).unwrap(), (None, Faults::NOT_AVAILABLE));
    // Nobody has vouched for it: it counts as not received.
    assert_eq!(yaw(None).unwrap().0, None);
}

#[test]
fn codes_for_not_available_are_taken_from_the_configuration_and_from_the_dbc() {
    for (raw, named) in [(-2048i16, true), (-2047, false)] {
        let mut data = car::esp(15.0, 0.0, 0.0).data().to_vec();
        data[4] = raw as u8;
        data[5] = (raw >> 8) as u8 & 15;
        let frames = [car::frame(15.0, car::ESP, &data), car::wheels(20.0, 54.0)];
        // The value table calls −2048 "SNA" and −2047 "NoFault".
        assert_eq!(sample("", &frames).get(Quantity::LateralAcceleration).is_none(), named, "{raw}");
        for code in [raw as i64, raw as i64 & 0xFFF] {
            let more = format!("sampling = {{}}\n{}", car::signals_without("lateral_acceleration"));
            let signals =
                format!("{more}lateral_acceleration = {{ signal = \"ESP.AccLat\", not_available = {code} }}");
            let config = car::config(&signals);
            let inputs = Inputs::compile(&config, &car::database(), car::RADIUS).unwrap();
            let mut all = vec![car::wheels(0.0, 54.0), car::steering(0.0, 0, 0)];
            all.extend(frames);
            let samples = car::run(&mut Sampler::new(inputs, &config.sampling), &all, true);
            assert_eq!(samples.last().unwrap().get(Quantity::LateralAcceleration), None, "{code}");
        }
    }
}

#[test]
fn a_multiplexed_quantity_is_read_only_where_it_is() {
    let more = "brake_pressure = \"MUXED.Pressure\"\nabs_active = \"MUXED.Abs\"";
    let frames = [
        car::frame(11.0, car::MUXED, &[0, 0xE8, 0x03, 0]),
        car::frame(12.0, car::MUXED, &[1, 0x01, 0x00, 0]),
        car::frame(13.0, car::MUXED, &[7, 0xFF, 0xFF, 0]),
        car::wheels(20.0, 54.0),
    ];
    let sample = sample(more, &frames);
    close(sample.get(Quantity::BrakePressure), 100.0);
    close(sample.get(Quantity::AbsActive), 1.0);
}

#[test]
fn frames_of_the_wrong_kind_or_length_are_dropped_and_longer_ones_are_not() {
    let mut sampler = car::sampler("");
    let id = gripd::can::CanId::standard(car::ESP).unwrap();
    let full = car::esp(0.0, 1.0, 1.0);
    let dropped = Pushed::Dropped(Faults::FRAME);
    assert_eq!(sampler.push(&car::frame(0.0, car::ESP, &full.data()[..7])), dropped);
    assert_eq!(sampler.push(&Frame::remote(Micros(0), id, 8).unwrap()), dropped);
    let fd = gripd::can::FrameKind::Fd { bit_rate_switch: true, error_state: false };
    let mut long = full.data().to_vec();
    long.resize(12, 0);
    assert_eq!(sampler.push(&Frame::new(Micros(0), id, fd, &long).unwrap()), Pushed::Used);
    // The same number as an extended identifier is another message.
    let extended = gripd::can::CanId::extended(car::ESP).unwrap();
    assert_eq!(sampler.push(&Frame::data_frame(Micros(0), extended, full.data()).unwrap()), Pushed::Ignored);
    let error = Frame::new(Micros(0), id, gripd::can::FrameKind::Error, full.data()).unwrap();
    assert_eq!(sampler.push(&error), Pushed::Ignored);
    assert_eq!(sampler.counts().get(Faults::FRAME), 2);
}

#[test]
fn a_frozen_counter_and_a_wrong_checksum_drop_the_frame_a_jump_is_only_told() {
    let signals = car::signals_without("yaw_rate")
        + "yaw_rate = { signal = \"ESP.Yaw\", counter = \"ESP.Counter\", crc = { signal = \"ESP.Crc\", kind = \"e2e_p01a\", data_id = 257 } }";
    let config = car::config(&signals);
    let inputs = Inputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    let mut outputs = Outputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    let mut sampler = Sampler::new(inputs, &config.sampling);
    let mut frames = Vec::new();
    for ms in (0..100).step_by(10) {
        let mut values = Sample::empty(Micros::from_millis(ms), 0.01);
        for quantity in Quantity::ALL {
            values.set(quantity, 0.1);
        }
        outputs.send(&values, &mut |frame| frames.extend((frame.id.number() == car::ESP).then_some(*frame)));
    }
    assert_eq!(frames.len(), 10);
    assert_eq!(sampler.push(&frames[0]), Pushed::Used);
    assert_eq!(sampler.push(&frames[1]), Pushed::Used);
    assert_eq!(sampler.push(&frames[1]), Pushed::Dropped(Faults::COUNTER));
    assert_eq!(sampler.counts().get(Faults::COUNTER), 1);
    assert_eq!(sampler.push(&frames[4]), Pushed::Used);
    assert_eq!(sampler.counts().get(Faults::COUNTER), 2);
    let mut damaged = frames[5].data().to_vec();
    damaged[3] ^= 0x10;
    let damaged = Frame::data_frame(frames[5].time, frames[5].id, &damaged).unwrap();
    assert_eq!(sampler.push(&damaged), Pushed::Dropped(Faults::CHECKSUM));
    assert_eq!(sampler.push(&frames[5]), Pushed::Used);
}

#[test]
fn every_problem_is_reported_at_once_and_names_its_key() {
    let found = problems("yaw_rate = { signal = \"ESP.Yav\", gain = 0 }");
    assert_eq!(found.len(), 4, "{found:?}");
    assert!(found.iter().any(|p| p.starts_with("signals: some speed is required")), "{found:?}");
    assert!(found.iter().any(|p| p.starts_with("signals.yaw_rate: ") && p.contains("ESP.Yaw")), "{found:?}");
    assert!(found.iter().any(|p| p.starts_with("signals.yaw_rate.gain: ")), "{found:?}");
}

#[test]
fn each_mistake_is_answered_with_what_to_do() {
    for (line, key, hint) in [
        ("yaw_rate = { signal = \"ESP.Yaw\", sign = \"ESP.AccQuality\" }", "yaw_rate.sign", "1 = negative"),
        ("yaw_rate = { signal = \"ESP.Yaw\", sign = \"WHEELS.FL\" }", "yaw_rate.sign", "same message"),
        ("yaw_rate = { signal = \"ESP.Yaw\", unit = \"furlong\" }", "yaw_rate.unit", "deg/s"),
        ("yaw_rate = \"MUXED.Nameless\"", "yaw_rate", "add unit = "),
        ("yaw_rate = \"WHEELS.FL\"", "yaw_rate", "deg/s"),
        ("yaw_rate = {}", "yaw_rate", "sum"),
        ("yaw_rate = { signal = \"ESP.Yaw\", sum = [\"ESP.Yaw\"] }", "yaw_rate", "either"),
        ("yaw_rate = { signal = \"ESP.Yaw\", not_available = [65536] }", "yaw_rate.not_available", "14 bits"),
        (
            "yaw_rate = { signal = \"ESP.Yaw\", valid = \"ESP.YawQuality\", valid_when = 2 }",
            "yaw_rate.valid_when",
            "1 bits",
        ),
        ("yaw_rate = { signal = \"ESP.Yaw\", counter_modulo = 15 }", "yaw_rate.counter_modulo", "counter = "),
        (
            "yaw_rate = { signal = \"ESP.Yaw\", counter = \"ESP.Counter\", counter_modulo = 17 }",
            "yaw_rate.counter",
            "2 to 2^bits",
        ),
        (
            "yaw_rate = { signal = \"ESP.Yaw\", crc = { signal = \"ESP.Counter\", kind = \"sum8\" } }",
            "yaw_rate.crc",
            "one byte",
        ),
        ("yaw_rate = { signal = \"ESP.Yaw\", timeout_ms = 0 }", "yaw_rate.timeout_ms", "between"),
        ("yaw_rate = { signal = \"ESP.Yaw\", delay_ms = -1 }", "yaw_rate.delay_ms", "between"),
        ("yaw_rate = { signal = \"ESP.Yaw\", noise_std = 0 }", "yaw_rate.noise_std", "positive"),
        ("yaw_rate = { signal = \"ESP.Yaw\", min = 2, max = 1 }", "yaw_rate.min", "less than max"),
        ("sampling = { period_ms = 0.5 }", "sampling.period_ms", "between"),
    ] {
        let problem = problem(line);
        assert!(problem.starts_with(&format!("signals.{key}: ")), "{line}\n{problem}");
        assert!(problem.contains(hint), "{line}\n{problem}");
    }
}

#[test]
fn two_counters_for_one_message_are_a_contradiction_and_the_same_twice_is_not() {
    let rest = car::signals_without("yaw_rate");
    let yaw = "yaw_rate = { signal = \"ESP.Yaw\", counter = \"ESP.Counter\" }\n";
    let lon = |counter: &str| {
        format!("longitudinal_acceleration = {{ signal = \"ESP.AccLon\", counter = \"ESP.{counter}\" }}\n")
    };
    assert_eq!(problems(&format!("{rest}{yaw}{}", lon("Counter"))), Vec::<String>::new());
    let found = problems(&format!("{rest}{yaw}{}", lon("AccQuality")));
    assert!(found.len() == 1 && found[0].contains("another quantity of ESP"), "{found:?}");
}
