//! What `explain` takes as a recording grows, and as the library of candidates does: seconds on the clock and of the
//! processors (all cores together), by the library's own interface.
//!
//! `cargo bench --bench explain` (ten minutes); `-- 2.5 10` for these lengths only, min. One drive with one
//! cause, cut to each length: up to five minutes all of it is searched, beyond that an excerpt.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark that cannot be set up may fail loudly")]

use std::time::Instant;

use gripd::explain::{Case, Explanation, Recording};
use gripd::model::effect::{KINDS, Kind};
use gripd::model::{Piece, Scenario, TireKind, Uncertain, Vehicle};

const DRIVE: &str = include_str!("../tests/data/steered.toml");

/// What is missing in the plain model.
const CAUSE: &str = "relaxation_length";

/// Lengths, min.
const LENGTHS: [f64; 5] = [2.5, 5.0, 10.0, 20.0, 40.0];

/// How long the drive is with which the library grows, min, and which of its effects are in it: one of so many.
const SHORT: f64 = 2.5;
const SHARES: [usize; 3] = [4, 2, 1];

fn main() {
    // `cargo bench` says `--bench`, too.
    let given: Vec<f64> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    let lengths = if given.is_empty() { LENGTHS.to_vec() } else { given };
    let longest = lengths.iter().copied().fold(SHORT, f64::max);
    let (vehicle, recording) = driven(60.0 * longest);
    println!("minutes  seconds  processor s  per minute  found");
    for minutes in lengths {
        let took = explained(&vehicle, &cut(&recording, 60.0 * minutes), KINDS);
        println!("{minutes:7.1}  {took}  {:10.1}  {}", took.processor / minutes, took.found());
    }
    println!("candidates  seconds  processor s  per candidate  found");
    let short = cut(&recording, 60.0 * SHORT);
    for one_of in SHARES {
        let some: Vec<&Kind> =
            KINDS.iter().copied().filter(|kind| kind.name != CAUSE).step_by(one_of).collect();
        let library: Vec<&'static Kind> = KINDS
            .iter()
            .copied()
            .filter(|kind| kind.name == CAUSE || some.iter().any(|s| s.name == kind.name))
            .collect();
        let took = explained(&vehicle, &short, &library);
        let candidates = took.explanation.ranking.len();
        println!("{candidates:10}  {took}  {:13.2}  {}", took.processor / candidates as f64, took.found());
    }
}

/// An answer, and what it took, s.
struct Took {
    clock: f64,
    processor: f64,
    explanation: Explanation,
}

impl std::fmt::Display for Took {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(to, "{:7.1}  {:11.1}", self.clock, self.processor)
    }
}

impl Took {
    fn found(&self) -> String {
        let names: Vec<&str> =
            self.explanation.findings.iter().map(|finding| finding.effect.as_str()).collect();
        format!("{:?} {}", self.explanation.verdict, names.join(", "))
    }
}

fn explained(vehicle: &Vehicle, recording: &Recording, library: &[&'static Kind]) -> Took {
    let recordings = std::slice::from_ref(recording);
    let case = Case {
        vehicle,
        effects: &[],
        recordings,
        references: 0,
        in_order: false,
        held_out: 0,
        chain: &[],
        library,
        seed: 1,
    };
    let (begin, before) = (Instant::now(), processor_seconds());
    let explanation = case.explain(&|_, _| {}).explanation;
    Took { clock: begin.elapsed().as_secs_f64(), processor: processor_seconds() - before, explanation }
}

/// What all threads of this process have had of the processors, s.
fn processor_seconds() -> f64 {
    /// Linux counts in hundredths.
    const TICKS_PER_S: f64 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    // The name of the program, in brackets, may have spaces of its own.
    let (_, rest) = stat.rsplit_once(") ").unwrap();
    rest.split(' ').skip(11).take(2).map(|ticks| ticks.parse::<f64>().unwrap()).sum::<f64>() / TICKS_PER_S
}

/// The drive with its cause, about as fast all the time, and what a user knows of the car.
fn driven(seconds: f64) -> (Vehicle, Recording) {
    let text = format!("{DRIVE}\n[[effect]]\nkind = \"{CAUSE}\"\nlength_m = 0.4");
    let mut scenario = Scenario::parse(&text).unwrap();
    scenario.duration_s = seconds;
    scenario.vehicle.tire = TireKind::Linear;
    for piece in &mut scenario.drive_torque {
        if let Piece::Sine { offset, .. } = piece {
            *offset = 50.0;
        }
    }
    let recording = Recording::simulated("drive", &scenario).unwrap();
    let mut vehicle = scenario.vehicle.clone();
    vehicle.mass_kg = Uncertain { value: 1560.0, std: 60.0 };
    vehicle.lateral_stiffness_front = Uncertain { value: 12.0, std: 1.5 };
    vehicle.lateral_stiffness_rear = Uncertain { value: 13.0, std: 1.5 };
    (vehicle, recording)
}

/// The beginning of a recording.
fn cut(recording: &Recording, seconds: f64) -> Recording {
    let mut recording = recording.clone();
    for track in &mut recording.tracks {
        track.truncate(track.partition_point(|(t, _)| *t <= seconds));
    }
    recording
}
