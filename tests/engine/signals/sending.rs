//! From values in SI to frames, as the simulator sends them.

use gripd::signals::{Inputs, Outputs, Sampler};
use gripd::{Faults, Micros, Quantity, Sample};
use testing::small_car as car;

#[test]
fn what_the_simulator_sends_is_what_the_service_reads() {
    let signals = format!(
        "{}\nlongitudinal_acceleration = \"ESP.AccLon\"\nbrake_pressure = {{ signal = \"MUXED.Pressure\", not_available = 65535 }}",
        car::signals_without("yaw_rate")
            + "yaw_rate = { signal = \"ESP.Yaw\", sign = \"ESP.YawSign\", valid = \"ESP.YawQuality\", counter = \"ESP.Counter\", crc = { signal = \"ESP.Crc\", kind = \"vw_mqb\", magic = 0xAA } }"
    );
    let config = car::config(&signals);
    let mut outputs = Outputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    let inputs = Inputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    let mut sampler = Sampler::new(inputs, &config.sampling);
    let mut samples = Vec::new();
    for step in 0..300 {
        let time = Micros::from_millis(step * 10);
        let mut truth = Sample::empty(time, 0.01);
        for wheel in gripd::Wheel::ALL {
            truth.set(Quantity::wheel_speed(wheel), 50.0 + 0.01 * step as f64);
        }
        truth.set(Quantity::SteeringWheelAngle, (step as f64 - 150.0) * 0.01);
        truth.set(Quantity::LateralAcceleration, (step as f64 * 0.05).sin() * 5.0);
        truth.set(Quantity::LongitudinalAcceleration, (step as f64 * 0.03).cos() * 2.0);
        if !(100..200).contains(&step) {
            truth.set(Quantity::YawRate, (step as f64 * 0.05).sin() * 0.5);
            truth.set(Quantity::BrakePressure, step as f64 * 0.1);
        }
        outputs.send(&truth, &mut |frame| {
            sampler.push(frame);
        });
        samples.extend(std::iter::from_fn(|| sampler.next_sample()).map(|s| (s.time, s)));
    }
    assert!(samples.len() > 290);
    for (time, sample) in samples {
        let step = time.0 / 10_000;
        let near = |quantity, truth: f64, step: f64| {
            let value = sample.get(quantity).unwrap_or_else(|| panic!("{quantity} at {time}"));
            assert!(
                (value - truth).abs() <= 0.5 * step + 1e-9,
                "{quantity} at {time}: {value} is not {truth}"
            );
        };
        let phase = step as f64 * 0.05;
        near(Quantity::WheelSpeedFl, 50.0 + 0.01 * step as f64, 0.01 / 3.6 / car::RADIUS);
        near(Quantity::SteeringWheelAngle, (step as f64 - 150.0) * 0.01, 0.1f64.to_radians() * 1.01);
        near(Quantity::LateralAcceleration, phase.sin() * 5.0, 0.01);
        near(Quantity::LongitudinalAcceleration, (step as f64 * 0.03).cos() * 2.0, 0.01 * 9.80665);
        if (100..200).contains(&step) {
            assert_eq!(sample.get(Quantity::YawRate), None, "{time}");
            assert_eq!(sample.get(Quantity::BrakePressure), None, "{time}");
            assert!(sample.faults.contains(Faults::NOT_AVAILABLE));
        } else {
            near(Quantity::YawRate, phase.sin() * 0.5, 0.01f64.to_radians());
            near(Quantity::BrakePressure, step as f64 * 0.1, 0.1);
        }
    }
    assert_eq!(sampler.counts().get(Faults::all() - Faults::NOT_AVAILABLE), 0, "{}", sampler.counts());
}

#[test]
fn a_quality_signal_in_another_message_is_sent_with_it() {
    let signals = car::signals_without("yaw_rate")
        + "yaw_rate = { signal = \"ESP.Yaw\", valid = \"MUXED.Page\", valid_when = 2 }";
    let config = car::config(&signals);
    let mut outputs = Outputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    let mut sampler = car::sampler("");
    assert_eq!(sampler.inputs().ids().len(), 3);
    let inputs = Inputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    assert_eq!(inputs.ids().len(), 4);
    sampler = Sampler::new(inputs, &config.sampling);
    let mut samples = Vec::new();
    for step in 0..100 {
        let mut values = Sample::empty(Micros::from_millis(step * 10), 0.01);
        for quantity in Quantity::ALL.into_iter().filter(|q| *q != Quantity::YawRate || step < 50) {
            values.set(quantity, 0.25);
        }
        outputs.send(&values, &mut |frame| {
            sampler.push(frame);
        });
        samples.extend(std::iter::from_fn(|| sampler.next_sample()));
    }
    let with_yaw = |sample: &&Sample| sample.get(Quantity::YawRate).is_some();
    // The quality's message has the higher identifier: it tells of the frames that come after it.
    assert_eq!(samples.iter().filter(with_yaw).count(), 50);
    assert!(samples.iter().all(|sample| sample.wheel_speeds().is_some()));
}

#[test]
fn each_message_is_sent_at_its_own_period_and_phase_whatever_the_step() {
    let config = car::config(car::SIGNALS);
    let mut outputs = Outputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    assert!(outputs.set_period("ESP", Micros::from_millis(20), Micros::from_millis(3)));
    assert!(!outputs.set_period("ESC", Micros::from_millis(20), Micros(0)));
    let mut times = Vec::new();
    for ms in 0..100 {
        let mut values = Sample::empty(Micros::from_millis(ms), 0.001);
        for quantity in Quantity::ALL {
            values.set(quantity, 1.0);
        }
        outputs.send(&values, &mut |frame| {
            if frame.id.number() == car::ESP {
                times.push(frame.time.0 / 1000);
            }
        });
    }
    assert_eq!(times, [3, 23, 43, 63, 83]);
}

#[test]
fn what_does_not_fit_saturates_without_becoming_a_code() {
    let rest = car::signals_without("lateral_acceleration");
    let config =
        car::config(&(rest + "lateral_acceleration = { signal = \"ESP.AccLat\", not_available = 2047 }"));
    let mut outputs = Outputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    let database = car::database();
    let signal = database.signal("ESP.AccLat").unwrap().1;
    for (value, raw) in [(1000.0, 2046), (-1000.0, -2047), (5.0, 500)] {
        let mut values = Sample::empty(Micros((value * 1e6) as i64 + 2_000_000_000), 0.01);
        for quantity in Quantity::ALL {
            values.set(quantity, 1.0);
        }
        values.set(Quantity::LateralAcceleration, value);
        let mut sent = None;
        let mut outputs = outputs.clone();
        outputs.send(&values, &mut |frame| {
            sent = sent.or((frame.id.number() == car::ESP).then(|| signal.raw(frame.data())))
        });
        assert_eq!(sent, Some(Some(raw)), "{value}");
    }
    // A value that is not there and cannot be said not to be there is not sent at all.
    let mut nothing = true;
    let mut values = Sample::empty(Micros(0), 0.01);
    values.set(Quantity::WheelSpeedFl, 1.0);
    outputs.send(&values, &mut |frame| nothing &= frame.id.number() != car::WHEELS);
    assert!(nothing);
}
