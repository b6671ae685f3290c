//! One fault at a time, for five seconds of a drive: what is told of it, how soon, and when all is well again.
//!
//! The rows of the guide's table (`src/guide/when-things-go-wrong.md`) are made here; a test fails whose row is not in it.

use std::collections::BTreeMap;

use gripd::can::Frame;
use gripd::model::Reading;
use gripd::{Config, Estimates, Faults, Micros, Quantity};
use testing::fault::{Case, FROM, Fault};
use testing::heard::{self, Heard};
use testing::{demo_car as car, program};

/// Runs all of them, prints their rows, and looks for these in the guide.
pub fn check(config: &Config, readings: &[Reading], cases: &[Case]) {
    let clean = run(config, car::frames_of(config, readings));
    let guide = std::fs::read_to_string(program::project("src/guide/when-things-go-wrong.md")).unwrap();
    let mut problems = Vec::new();
    for case in cases {
        let frames = match case.fault {
            Fault::Sensors(spoil) => {
                let mut readings = readings.to_vec();
                spoil(&mut readings);
                readings.sort_by_key(|reading| reading.time);
                car::frames_of(config, &readings)
            }
            Fault::Frames(spoil) => spoil(car::frames_of(config, readings)),
        };
        let heard = run(config, frames);
        heard::protected(&heard.frames);
        let row = row(case, &heard, &clean, &mut problems);
        println!("{row}");
        nothing_wrong_is_valid(case, &heard, &clean, &mut problems);
        if !guide.contains(&row) {
            problems.push(format!("the guide has another row than {row}"));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

fn run(config: &Config, frames: Vec<Frame>) -> Heard {
    let mut heard = Heard::default();
    let mut engine = car::engine(config);
    frames.iter().for_each(|frame| engine.frame(frame, &mut heard));
    engine.finish(&mut heard);
    // From here on in the time of the drive, whatever was done to the clock.
    onward(heard.samples.iter_mut().map(|sample| &mut sample.time));
    onward(heard.estimates.iter_mut().map(|estimates| &mut estimates.time));
    onward(heard.frames.iter_mut().map(|frame| &mut frame.time));
    heard
}

/// Undoes steps back of a clock.
fn onward<'a>(times: impl Iterator<Item = &'a mut Micros>) {
    let (mut newest, mut set_back) = (Micros(i64::MIN), 0);
    for time in times {
        if newest - *time > Micros::from_millis(1000) {
            // To whole seconds: clocks are set back by such, and frames are some milliseconds apart.
            set_back += ((newest - *time).seconds().round() * 1e6) as i64;
        }
        newest = *time;
        *time = *time + Micros(set_back);
    }
}

/// What each status frame tells, once every sensor has spoken, but for what an estimator says of itself.
fn told(heard: &Heard) -> Vec<(f64, Faults)> {
    let times = heard::of(&heard.frames, "GRIP_STATUS").map(|frame| frame.time.seconds());
    let faults = heard::faults(&heard.frames).into_iter().map(|faults| faults - Faults::INCONSISTENT);
    times.zip(faults).filter(|(time, _)| *time > 1.0).collect()
}

fn row(case: &Case, heard: &Heard, clean: &Heard, problems: &mut Vec<String>) -> String {
    let own = told(clean).into_iter().find(|(_, faults)| !faults.is_empty());
    assert_eq!(own, None, "the drive itself is faulty");
    let told = told(heard);
    let all = told.iter().fold(Faults::empty(), |all, (_, faults)| all | *faults);
    if all != case.told {
        problems.push(format!("{}: {all:?} is told, not {:?}", case.name, case.told));
    }
    let first = told.iter().find(|(_, faults)| !faults.is_empty()).map(|(time, _)| time - FROM);
    let last = told.iter().rfind(|(_, faults)| !faults.is_empty()).map_or(0.0, |(time, _)| time - case.until);
    // The same instants of both drives; a gap or a step of the clock leaves some out.
    let whole: BTreeMap<Micros, u16> = clean.samples.iter().map(|s| (s.time, present(s))).collect();
    let mut absent = [0; Quantity::COUNT];
    let mut back = last.max(0.0);
    for sample in &heard.samples {
        let lacking = whole.get(&sample.time).map_or(0, |whole| whole & !present(sample));
        for quantity in Quantity::ALL.into_iter().filter(|quantity| lacking & 1 << *quantity as usize != 0) {
            absent[quantity as usize] += 1;
            back = back.max(sample.time.seconds() + 0.01 - case.until);
        }
    }
    let (told_s, back_s) = case.within;
    if first.is_some_and(|first| !(0.0..=told_s).contains(&first)) || back > back_s {
        problems.push(format!("{}: told after {first:?} s, well again after {back} s", case.name));
    }
    let reaction = match first {
        None => "not told".to_owned(),
        Some(first) => format!("{} after {first:.2} s", names(all)),
    };
    let lost: Vec<&str> =
        Quantity::ALL.into_iter().filter(|q| absent[*q as usize] > 10).map(Quantity::name).collect();
    let lost = match (lost.len(), lost.iter().all(|name| name.starts_with("wheel_speed"))) {
        (0, _) => "all kept".to_owned(),
        (4, true) => "wheel speeds absent".to_owned(),
        (5.., _) => "all absent".to_owned(),
        _ => format!("{} absent", lost.join(", ")),
    };
    let valid = match case.weak {
        [] => "right".to_owned(),
        weak => format!("wrong for a while: {}", weak.join(", ")),
    };
    format!("| {} | {reaction} | {lost} | {valid} | {back:.2} s |", case.name)
}

fn names(faults: Faults) -> String {
    faults.iter_names().map(|(name, _)| name).collect::<Vec<_>>().join(", ")
}

fn present(sample: &gripd::Sample) -> u16 {
    let there = Quantity::ALL.into_iter().filter(|quantity| sample.get(*quantity).is_some());
    there.fold(0, |bits, quantity| bits | 1 << quantity as usize)
}

/// Whatever is flagged valid is near what it is without the fault.
fn nothing_wrong_is_valid(case: &Case, heard: &Heard, clean: &Heard, problems: &mut Vec<String>) {
    let clean: BTreeMap<Micros, &Estimates> = clean.estimates.iter().map(|e| (e.time, e)).collect();
    let mut worst: BTreeMap<&str, (f64, f64, f64, f64)> = BTreeMap::new();
    let mut off = |what, limit: f64, time: Micros, is: f64, was: f64, by: f64| {
        let worst = worst.entry(what).or_default();
        if by > limit && by > worst.3 {
            *worst = (time.seconds(), is, was, by);
        }
    };
    for is in &heard.estimates {
        let Some(was) = clean.get(&is.time) else { continue };
        for (what, valid, is_, was_) in [
            ("slope", is.slope_valid, &is.slope[..], &was.slope[..]),
            ("cornering stiffness", is.cornering_valid, &is.cornering[..], &was.cornering[..]),
        ] {
            for (is_, was_) in is_.iter().zip(was_).filter_map(|(is, was)| is.zip(*was)).filter(|_| valid) {
                off(what, 0.35, is.time, is_.value, was_.value, (is_.value / was_.value - 1.0).abs());
            }
        }
        if let Some((is_, was_)) = is.motion.sideslip.zip(was.motion.sideslip).filter(|_| is.motion.valid) {
            off("sideslip", 0.05, is.time, is_, was_, (is_ - was_).abs());
        }
        if let Some((is_, was_)) = is.friction.max.zip(was.friction.low).filter(|_| is.friction.valid) {
            off("friction", 0.1, is.time, is_, was_, was_ - is_);
        }
    }
    let name = case.name;
    let wrong = worst.into_iter().filter(|(what, worst)| worst.3 > 0.0 && !case.weak.contains(what));
    for (what, (time, is, was, by)) in wrong {
        problems.push(format!(
            "{name}: a valid {what} is off by {by:.2} at {time} s: {is:.3} instead of {was:.3}"
        ));
    }
}
