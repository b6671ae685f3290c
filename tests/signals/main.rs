//! The mapping: from configured names to values in SI, and back into frames.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that fails may panic")]

mod signals_support;
mod support;

use gripd::can::Frame;
use gripd::dbc::Database;
use gripd::signals::{Inputs, Outputs, Pushed, Sampler, SignalsConfig};
use gripd::{Faults, Micros, Quantity, Sample};
use signals_support as car;

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
    assert_eq!(found.len(), 8, "{found:?}");
    assert!(found.iter().any(|p| p.starts_with("signals.wheel_speed_fl: is required")), "{found:?}");
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

/// Mappings of the needed signals of real cars: they must compile against the real files.
#[test]
fn real_files_can_be_mapped() {
    let Some(folder) = support::shared("dbc") else { return };
    let cars = [
        (
            "vw_pq.dbc",
            r#"
            wheel_speed_fl = "Bremse_3.Radgeschw__VL_4_1"
            wheel_speed_fr = "Bremse_3.Radgeschw__VR_4_1"
            wheel_speed_rl = "Bremse_3.Radgeschw__HL_4_1"
            wheel_speed_rr = "Bremse_3.Radgeschw__HR_4_1"
            yaw_rate = { signal = "Bremse_5.BR5_Giergeschw", sign = "Bremse_5.BR5_Vorzeichen", valid = "Bremse_5.BR5_Sta_Gierrate" }
            lateral_acceleration = "Bremse_2.Querbeschleunigung"
            steering_wheel_angle = { signal = "Lenkwinkel_1.LW1_LRW", sign = "Lenkwinkel_1.LW1_LRW_Sign", not_available = 0x7FFF, counter = "Lenkwinkel_1.LW1_Zaehler" }
        "#,
        ),
        (
            "hyundai_2015_ccan.dbc",
            r#"
            wheel_speed_fl = { signal = "WHL_SPD11.WHL_SPD_FL", counter = ["WHL_SPD11.WHL_SPD_AliveCounter_LSB", "WHL_SPD11.WHL_SPD_AliveCounter_MSB"] }
            wheel_speed_fr = "WHL_SPD11.WHL_SPD_FR"
            wheel_speed_rl = "WHL_SPD11.WHL_SPD_RL"
            wheel_speed_rr = "WHL_SPD11.WHL_SPD_RR"
            yaw_rate = { signal = "ESP12.YAW_RATE", unit = "deg/s", valid = ["ESP12.YAW_RATE_STAT", "ESP12.YAW_RATE_DIAG"] }
            lateral_acceleration = { signal = "ESP12.LAT_ACCEL", counter = "ESP12.ESP12_AliveCounter" }
            steering_wheel_angle = "SAS11.SAS_Angle"
            brake_pressure = "ESP12.CYL_PRES"
        "#,
        ),
        (
            "hyundai_canfd_generated.dbc",
            r#"
            wheel_speed_fl = "WHEEL_SPEEDS.WHL_SpdFLVal"
            wheel_speed_fr = "WHEEL_SPEEDS.WHL_SpdFRVal"
            wheel_speed_rl = "WHEEL_SPEEDS.WHL_SpdRLVal"
            wheel_speed_rr = "WHEEL_SPEEDS.WHL_SpdRRVal"
            yaw_rate = { signal = "IMU_01_10ms.IMU_YawRtVal", valid = "IMU_01_10ms.IMU_YawSigSta" }
            lateral_acceleration = "IMU_01_10ms.IMU_LatAccelVal"
            steering_wheel_angle = "STEERING_SENSORS.STEERING_ANGLE"
        "#,
        ),
        (
            "ford_lincoln_base_pt.dbc",
            r#"
            wheel_speed_fl = "WheelSpeed.WhlFl_W_Meas"
            wheel_speed_fr = "WheelSpeed.WhlFr_W_Meas"
            wheel_speed_rl = "WheelSpeed.WhlRl_W_Meas"
            wheel_speed_rr = "WheelSpeed.WhlRr_W_Meas"
            yaw_rate = { signal = "Yaw_Data_FD1.VehYaw_W_Actl", valid = "Yaw_Data_FD1.VehYawWActl_D_Qf", valid_when = 3 }
            lateral_acceleration = "BrakeSnData_3.VehLatComp_A_Actl"
            steering_wheel_angle = { signal = "SteeringPinion_Data.StePinComp_An_Est", valid = "SteeringPinion_Data.StePinCompAnEst_D_Qf", valid_when = 3 }
        "#,
        ),
        (
            "tesla_model3_party.dbc",
            r#"
            wheel_speed_fl = { signal = "ESP_wheelSpeeds.ESP_wheelSpeedFrL", valid = "ESP_B.ESP_wheelSpeedsQF", valid_when = 1, counter = "ESP_wheelSpeeds.ESP_wheelSpeedsCounter" }
            wheel_speed_fr = "ESP_wheelSpeeds.ESP_wheelSpeedFrR"
            wheel_speed_rl = "ESP_wheelSpeeds.ESP_wheelSpeedReL"
            wheel_speed_rr = "ESP_wheelSpeeds.ESP_wheelSpeedReR"
            steering_wheel_angle = "SCCM_steeringAngleSensor.SCCM_steeringAngle"
        "#,
        ),
        (
            "fca_giorgio.dbc",
            r#"
            wheel_speed_fl = "ABS_1.WHEEL_SPEED_FL"
            wheel_speed_fr = "ABS_1.WHEEL_SPEED_FR"
            wheel_speed_rl = "ABS_1.WHEEL_SPEED_RL"
            wheel_speed_rr = "ABS_1.WHEEL_SPEED_RR"
            yaw_rate = "ABS_2.YAW_RATE"
            lateral_acceleration = "ABS_2.LATERAL_ACCEL"
            steering_wheel_angle = "EPS_1.STEERING_ANGLE"
        "#,
        ),
    ];
    for (file, text) in cars {
        let database = Database::load(&folder.join(file)).unwrap();
        // Outputs, because not every file has all that Inputs requires.
        let outputs = Outputs::compile(&car::config(text), &database, 0.32);
        assert!(outputs.is_ok(), "{file}: {}", outputs.unwrap_err());
    }
}

/// What a shipped configuration says in `[signals]`, and its DBC, both where the file says they are.
fn shipped(name: &str) -> (SignalsConfig, gripd::model::Vehicle, Vec<std::path::PathBuf>) {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("config");
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let table: toml::Table = toml::from_str(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
    let signals = table["signals"].clone().try_into().unwrap_or_else(|e| panic!("{name}: {e}"));
    let vehicle: gripd::model::Vehicle =
        table["vehicle"].clone().try_into().unwrap_or_else(|e| panic!("{name}: {e}"));
    vehicle.validate().unwrap();
    let inputs = table["dbc"]["input"].as_array().unwrap();
    (signals, vehicle, inputs.iter().map(|path| folder.join(path.as_str().unwrap())).collect())
}

#[test]
fn shipped_configurations_fit_their_dbc_files() {
    for name in ["demo.toml", "rav4.toml", "thesis.toml"] {
        let (signals, vehicle, paths) = shipped(name);
        let database = Database::load_all(&paths).unwrap();
        assert_eq!(database.warnings(), &[], "{name}");
        Inputs::compile(&signals, &database, vehicle.wheel_radius_m.value)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn the_volkswagen_example_fits_a_real_mqb_file() {
    let Some(path) = support::shared("dbc/vw_mqb.dbc") else { return };
    let (signals, vehicle, _) = shipped("vw_mqb.toml");
    let database = Database::load(&path).unwrap();
    let inputs =
        Inputs::compile(&signals, &database, vehicle.wheel_radius_m.value).unwrap_or_else(|e| panic!("{e}"));
    assert!(inputs.has(Quantity::BrakePressure));
}

#[test]
fn the_demo_car_can_be_simulated_with_all_its_quantities() {
    let (signals, vehicle, paths) = shipped("demo.toml");
    let database = Database::load_all(&paths).unwrap();
    let outputs = Outputs::compile(&signals, &database, vehicle.wheel_radius_m.value).unwrap();
    let wanted = [Quantity::DriveTorque, Quantity::BrakePressure, Quantity::AbsActive, Quantity::YawRate];
    assert!(wanted.into_iter().all(|quantity| outputs.has(quantity)));
}
