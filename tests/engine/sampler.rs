//! From frames to samples: time, order, gaps, time-outs.

use gripd::can::Frame;
use gripd::signals::{Inputs, Pushed, Sampler};
use gripd::{Faults, Micros, Quantity, Sample, Wheel};
use proptest::prelude::*;
use testing::small_car as car;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A second of frames with their own periods and phases; the yaw rate is a ramp of 10 °/s per second.
fn ramp() -> Vec<Frame> {
    let mut frames = Vec::new();
    for ms in 0..1000 {
        let t = f64::from(ms);
        if ms % 11 == 3 {
            frames.push(car::wheels(t, 54.0));
        }
        if ms % 14 == 1 {
            frames.push(car::esp(t, 0.01 * t, 0.0));
        }
        if ms % 20 == 7 {
            frames.push(car::steering(t, 1, 0));
        }
    }
    frames
}

fn yaw_degrees(sample: &Sample) -> Option<f64> {
    sample.get(Quantity::YawRate).map(|yaw| yaw / DEGREE)
}

#[test]
fn asynchronous_frames_become_samples_on_the_grid_with_values_of_that_instant() {
    let samples = car::run(&mut car::sampler(""), &ramp(), true);
    assert_eq!(samples.first().unwrap().time, Micros(10_000));
    assert_eq!(samples.last().unwrap().time, Micros(990_000));
    for (index, sample) in samples.iter().enumerate() {
        assert_eq!(sample.time.0, 10_000 * (index as i64 + 1));
        assert_eq!(sample.elapsed_s, 0.01);
        assert_eq!(sample.faults, Faults::empty());
        // The last ESP frame is of 995 ms; after it the value is held.
        let expected = (sample.time.0 as f64 * 1e-5).min(9.95);
        let yaw = yaw_degrees(sample).unwrap();
        // The ramp is cut into steps of 0.01 °/s.
        assert!((yaw - expected).abs() < 0.011, "{}: {yaw} is not {expected}", sample.time);
    }
}

#[test]
fn samples_do_not_depend_on_frames_that_are_not_needed_nor_on_how_often_one_asks() {
    let frames = ramp();
    let expected = car::run(&mut car::sampler(""), &frames, false);
    let mut crowded = Vec::new();
    for frame in &frames {
        let t = frame.time.seconds() * 1000.0;
        crowded.extend([car::frame(t, 0x7FF, &[1]), *frame, car::frame(t + 900.0, 0x123, &[])]);
    }
    assert_eq!(car::run(&mut car::sampler(""), &crowded, false), expected);
    let mut sampler = car::sampler("");
    frames.iter().take(10).for_each(|frame| {
        sampler.push(frame);
    });
    let mut seldom: Vec<_> = std::iter::from_fn(|| sampler.next_sample()).collect();
    seldom.extend(car::run(&mut sampler, &frames[10..], false));
    assert_eq!(seldom, expected);
}

#[test]
fn frames_that_overtake_one_another_within_the_lag_change_nothing() {
    let frames = ramp();
    let mut shuffled = frames.clone();
    // Steering frames come 15 ms late: a gateway that batches.
    shuffled.sort_by_key(|frame| frame.time.0 + if frame.id.is_extended() { 15_000 } else { 0 });
    assert_ne!(shuffled, frames);
    let tail = |frames: &[Frame]| {
        let samples = car::run(&mut car::sampler(""), frames, true);
        samples.into_iter().filter(|s| (100_000..900_000).contains(&s.time.0)).collect::<Vec<_>>()
    };
    assert_eq!(tail(&shuffled), tail(&frames));
}

#[test]
fn a_late_frame_is_still_taken_if_it_is_the_newest_of_its_kind() {
    let mut sampler = car::sampler("");
    car::run(&mut sampler, &ramp(), false);
    // Samples up to 960 ms are made; the newest steering frame is of 987 ms.
    assert_eq!(sampler.push(&car::steering(900.0, 2, 0)), Pushed::Dropped(Faults::TIME));
    assert_eq!(sampler.push(&car::steering(988.0, 2, 0)), Pushed::Used);
    assert_eq!(sampler.last_seen(Quantity::SteeringWheelAngle), Some(Micros(988_000)));
    sampler.flush();
    let samples: Vec<_> = std::iter::from_fn(|| sampler.next_sample()).collect();
    assert!(samples[0].faults.contains(Faults::TIME));
    assert_eq!(samples.last().unwrap().get(Quantity::SteeringWheelAngle), Some(2.0 * 1.5 * DEGREE));
}

#[test]
fn of_frames_with_the_same_stamp_the_later_counts() {
    let mut frames = vec![car::wheels(0.0, 54.0), car::steering(0.0, 0, 0), car::esp(0.0, 1.0, 0.0)];
    frames.extend([car::esp(20.0, 2.0, 0.0), car::esp(20.0, 3.0, 0.0), car::esp(20.0, 4.0, 0.0)]);
    frames.push(car::esp(60.0, 4.0, 0.0));
    let samples = car::run(&mut car::sampler(""), &frames, false);
    let yaw: Vec<_> = samples.iter().map(|s| yaw_degrees(s).unwrap().round()).collect();
    assert_eq!(yaw, [1.0, 3.0, 4.0, 4.0]); // 2.5 is rounded away from zero
    assert!(samples.iter().all(|s| s.faults.is_empty()));
}

#[test]
fn a_known_delay_moves_a_value_back_to_when_it_was_true() {
    let rest = car::signals_without("yaw_rate");
    let config = car::config(&format!("{rest}yaw_rate = {{ signal = \"ESP.Yaw\", delay_ms = 40 }}"));
    let inputs = Inputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    let samples = car::run(&mut Sampler::new(inputs, &config.sampling), &ramp(), false);
    let sample = samples.iter().find(|s| s.time.0 == 500_000).unwrap();
    assert!((yaw_degrees(sample).unwrap() - 5.4).abs() < 0.011, "{:?}", yaw_degrees(sample));
    // It costs that much patience, and no interpolation.
    assert_eq!(samples.last().unwrap().time.0, 930_000);
}

#[test]
fn flags_are_held_and_never_between_zero_and_one() {
    let mut frames = ramp();
    for ms in (0..1000).step_by(50) {
        frames.push(car::frame(f64::from(ms), car::MUXED, &[1, u8::from(ms % 100 == 0), 0, 0]));
    }
    frames.sort_by_key(|frame| frame.time);
    let samples = car::run(&mut car::sampler("abs_active = \"MUXED.Abs\""), &frames, true);
    for sample in samples {
        let expected = f64::from(u8::from(sample.time.0 / 50_000 % 2 == 0));
        assert_eq!(sample.get(Quantity::AbsActive), Some(expected), "{}", sample.time);
    }
}

#[test]
fn a_silent_message_is_held_until_its_time_out_then_absent_then_back() {
    let mut frames = ramp();
    frames.retain(|frame| !frame.id.is_extended() || !(300_000..=700_000).contains(&frame.time.0));
    let mut sampler = car::sampler("");
    let samples = car::run(&mut sampler, &frames, true);
    for sample in &samples {
        // The last steering frame before is of 287 ms, the next of 707 ms, the time-out 200 ms.
        let gone = sample.time.0 > 487_000 && sample.time.0 < 707_000;
        assert_eq!(sample.get(Quantity::SteeringWheelAngle).is_none(), gone, "{}", sample.time);
        assert_eq!(sample.faults.contains(Faults::TIMEOUT), gone, "{}", sample.time);
        assert!(sample.get(Quantity::YawRate).is_some());
    }
    assert_eq!(sampler.counts().get(Faults::TIMEOUT), 1);
}

#[test]
fn a_quantity_may_have_its_own_time_out_and_one_never_heard_is_told() {
    let more =
        "brake_pressure = { signal = \"MUXED.Pressure\", timeout_ms = 50 }\nabs_active = \"MUXED.Abs\"";
    let mut frames = ramp();
    frames.insert(20, car::frame(frames[20].time.seconds() * 1e3, car::MUXED, &[0, 10, 0, 0]));
    let heard = frames[20].time.0;
    let samples = car::run(&mut car::sampler(more), &frames, true);
    for sample in &samples {
        let age = sample.time.0 - heard;
        assert_eq!(
            sample.get(Quantity::BrakePressure).is_some(),
            (0..=50_000).contains(&age),
            "{}",
            sample.time
        );
        assert_eq!(sample.get(Quantity::AbsActive), None);
    }
    assert!(samples.last().unwrap().faults.contains(Faults::TIMEOUT));
    // Nothing is missed before it had a fair chance to come.
    assert_eq!(samples[0].faults, Faults::empty());
}

#[test]
fn after_a_gap_samples_go_on_at_the_new_time_and_say_how_long_it_was() {
    let mut frames = ramp();
    frames.extend(ramp().into_iter().map(|mut frame| {
        frame.time = frame.time + Micros::from_millis(3_600_000);
        frame
    }));
    let mut sampler = car::sampler("");
    let samples = car::run(&mut sampler, &frames, true);
    assert!(samples.len() < 310, "{}", samples.len());
    assert_eq!(sampler.counts().get(Faults::TIME), 1);
    let jump = samples.iter().position(|s| s.elapsed_s > 1.0).unwrap();
    assert_eq!(samples[jump].time, Micros::from_millis(3_600_010));
    assert_eq!(samples[jump].elapsed_s, (samples[jump].time - samples[jump - 1].time).seconds());
    assert!(samples[jump - 1].is_empty());
    // No line is drawn across it.
    assert!(samples[..jump].iter().all(|s| yaw_degrees(s).is_none_or(|yaw| yaw < 10.0)));
    assert!(samples[jump + 5..].iter().all(|s| yaw_degrees(s).is_some()));
}

#[test]
fn after_a_clock_set_back_everything_starts_anew() {
    let mut frames: Vec<_> = ramp();
    for frame in &mut frames {
        frame.time = frame.time + Micros::from_millis(5000);
    }
    frames.extend(ramp());
    let mut sampler = car::sampler("");
    let samples = car::run(&mut sampler, &frames, true);
    assert_eq!(sampler.counts().to_string(), "time 1");
    let back = samples.iter().position(|s| s.time.0 < 5_000_000).unwrap();
    assert_eq!((samples[back].time.0, samples[back].elapsed_s), (10_000, 0.01));
    assert!(samples[back].faults.contains(Faults::TIME));
    assert_eq!(samples[back..].iter().map(|s| s.time).collect::<Vec<_>>(), {
        let alone = car::run(&mut car::sampler(""), &ramp(), true);
        alone.iter().map(|s| s.time).collect::<Vec<_>>()
    });
}

#[test]
fn a_lone_frame_from_another_time_does_no_lasting_harm() {
    for stray in [0.0, 9e12] {
        let mut frames: Vec<_> = ramp();
        for frame in &mut frames {
            frame.time = frame.time + Micros::from_millis(100_000);
        }
        frames.insert(60, car::esp(stray, 1.0, 0.0));
        let samples = car::run(&mut car::sampler(""), &frames, true);
        assert!(samples.len() < 400, "{}", samples.len());
        let last = samples.last().unwrap();
        assert_eq!((last.time.0, last.faults), (100_990_000, Faults::empty()));
        assert!(last.wheel_speeds().is_some() && last.get(Quantity::YawRate).is_some());
    }
}

#[test]
fn the_first_sample_waits_for_the_required_quantities_or_half_a_second() {
    let mut frames = ramp();
    frames.retain(|frame| !frame.id.is_extended() || frame.time.0 > 200_000);
    assert_eq!(car::run(&mut car::sampler(""), &frames, true)[0].time.0, 210_000);
    frames.retain(|frame| !frame.id.is_extended());
    let samples = car::run(&mut car::sampler(""), &frames, true);
    assert_eq!(samples[0].time.0, 510_000);
    assert_eq!(samples[0].faults, Faults::TIMEOUT);
}

#[test]
fn values_that_cannot_be_are_taken_out_and_told() {
    let mut frames = ramp();
    let at = |ms: i64, frames: &[Frame]| frames.iter().position(|f| f.time.0 > ms * 1000).unwrap();
    // 163 °/s is no spin any more for a car whose limit was set to 100 °/s.
    let signals =
        car::signals_without("yaw_rate") + "yaw_rate = { signal = \"ESP.Yaw\", max = 1.75, rate_max = 2 }";
    frames.insert(at(509, &frames), car::esp(509.5, 163.0, 0.0));
    frames.insert(at(700, &frames), car::esp(700.5, 90.0, 0.0));
    let config = car::config(&signals);
    let inputs = Inputs::compile(&config, &car::database(), car::RADIUS).unwrap();
    let mut sampler = Sampler::new(inputs, &config.sampling);
    let samples = car::run(&mut sampler, &frames, true);
    assert_eq!(sampler.counts().to_string(), "range 1, rate 1");
    assert!(samples.iter().all(|s| yaw_degrees(s).is_none_or(|yaw| yaw < 10.0)));
    // Out of range is not available until the next frame; a spike is passed over.
    assert_eq!(samples.iter().filter(|s| yaw_degrees(s).is_none()).count(), 1);
}

#[test]
fn two_samplers_agree_whatever_the_period() {
    for period in [1.0, 5.0, 7.5, 20.0, 100.0] {
        let samples =
            car::run(&mut car::sampler(&format!("sampling = {{ period_ms = {period} }}")), &ramp(), true);
        assert!(samples.iter().all(|s| s.time.0 % ((period * 1000.0) as i64) == 0));
        assert!((samples.len() as f64 - 990.0 / period).abs() < 2.0, "{period}: {}", samples.len());
    }
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![Just(car::WHEELS), Just(car::ESP), Just(car::MUXED), 0..0x800u32];
    let time = prop_oneof![0..3_000_000i64, any::<i64>(), Just(i64::MAX), Just(i64::MIN)];
    (id, time, proptest::collection::vec(any::<u8>(), 0..=8)).prop_map(|(id, time, data)| {
        let mut frame = car::frame(0.0, id, &data);
        frame.time = Micros(time);
        frame
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn whatever_comes_samples_are_finite_ordered_and_few(frames in proptest::collection::vec(any_frame(), 0..60)) {
        let mut sampler = car::sampler("brake_pressure = { signal = \"MUXED.Pressure\", delay_ms = 100 }");
        let (mut newest, mut last): (Option<Micros>, Option<Micros>) = (None, None);
        for frame in &frames {
            if sampler.push(frame) != Pushed::Ignored {
                // After the clock was set back, the first of the earlier samples may be some frames away.
                if newest.is_some_and(|newest| newest - frame.time > Micros::from_millis(1000)) {
                    (newest, last) = (None, None);
                }
                newest = newest.max(Some(frame.time));
            }
            let mut count = 0;
            while let Some(sample) = sampler.next_sample() {
                count += 1;
                prop_assert!(count < 400);
                prop_assert!(sample.elapsed_s > 0.0 && sample.elapsed_s.is_finite());
                prop_assert!(last.is_none_or(|last| sample.time > last));
                prop_assert_eq!(sample.time.0.rem_euclid(10_000) * i64::from(sample.time.0 < i64::MAX - 10_000), 0);
                for quantity in Quantity::ALL {
                    prop_assert!(sample.get(quantity).is_none_or(f64::is_finite));
                }
                last = Some(sample.time);
            }
        }
    }
}

#[test]
fn the_noise_of_each_quantity_is_known() {
    let sampler = car::sampler("longitudinal_acceleration = { signal = \"ESP.AccLon\", noise_std = 0.3 }");
    let inputs = sampler.inputs();
    assert_eq!(inputs.noise_std(Quantity::LongitudinalAcceleration), Some(0.3));
    assert_eq!(inputs.noise_std(Quantity::BrakePressure), None);
    for wheel in Wheel::ALL {
        assert!(inputs.noise_std(Quantity::wheel_speed(wheel)).is_some_and(|std| (0.01..0.2).contains(&std)));
    }
    assert_eq!(inputs.ids().len(), 3);
    assert_eq!(inputs.message_name(inputs.ids()[0]), Some("ESP"));
}
