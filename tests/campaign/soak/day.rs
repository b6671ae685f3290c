//! The day: stretch after stretch through two engines, one of which has a bad day.

use std::fmt;
use std::path::Path;
use std::time::Instant;

use gripd::can::Frame;
use gripd::cli::SimulatedFrames;
use gripd::model::Reading;
use gripd::service::{Engine, Sink};
use gripd::signals::Outputs;
use gripd::{Config, Estimates, Faults, Micros, Sample};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::memory::{self, Memory};
use super::road::Stretch;
use super::spoil::{Event, List, Piece};
use super::verdict::{Offs, True, Verdict, offs};
use testing::dice::Dice;
use testing::heard;
use testing::sound::sound;

/// A date, so that stamps are as long as those of a live bus.
const BEGIN: Micros = Micros(1_760_000_000_000_000);
/// Stamps may be ahead of the true time by a little.
const BETWEEN: Micros = Micros::from_millis(20);
/// A truth belongs to a sample as close as this.
const CLOSE: Micros = Micros::from_millis(15);

/// What a day was.
#[derive(Debug, Default)]
pub struct Outcome {
    pub seconds: f64,
    pub stretches: u64,
    pub frames: u64,
    pub samples: u64,
    pub published: u64,
    /// Of all published frames and their times (FNV-1a).
    pub digest: u64,
    pub memory: Memory,
    pub verdict: Verdict,
    took_s: f64,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hours = self.seconds / 3600.0;
        writeln!(
            f,
            "{hours:.2} h of driving in {} stretches, {:.0} s on one core: {} frames, {} samples, {} published, digest {:016x}",
            self.stretches, self.took_s, self.frames, self.samples, self.published, self.digest
        )?;
        writeln!(f, "{}\n{}", self.memory, self.verdict)?;
        let all: u64 = self.verdict.faults.values().sum();
        write!(f, "{all} windows of {} faults", self.verdict.faults.len())
    }
}

/// What an engine hands on for one frame, in memory that is there already.
struct Heard {
    estimates: Vec<(Sample, Estimates)>,
    frames: Vec<Frame>,
}

impl Default for Heard {
    fn default() -> Self {
        Self { estimates: Vec::with_capacity(1 << 12), frames: Vec::with_capacity(1 << 10) }
    }
}

impl Sink for Heard {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        self.estimates.push((*sample, *estimates));
    }

    fn publish(&mut self, frame: &Frame) {
        self.frames.push(*frame);
    }
}

/// What is true, and how the engine without faults did, in order of time.
struct Known<'a> {
    begin: Micros,
    truths: &'a [True],
    clean: Vec<(Micros, Offs)>,
}

impl Known<'_> {
    fn truth(&self, time: Micros) -> Option<&True> {
        let time = time - self.begin;
        let place = self.truths.partition_point(|truth| truth.time < time);
        self.truths.get(place).filter(|truth| truth.time - time < CLOSE)
    }

    fn clean(&self, time: Micros) -> Option<&Offs> {
        let place = self.clean.binary_search_by_key(&time, |(time, _)| *time).ok()?;
        Some(&self.clean[place].1)
    }
}

/// Everything that lasts from stretch to stretch.
struct Day {
    config: Config,
    clean: Engine,
    spoiled: Engine,
    /// Of both cars' gateways.
    senders: [SimulatedFrames; 2],
    list: List,
    blamed: &'static str,
    heard: Heard,
    /// The last frame of each message: its counter must go on.
    last: Vec<Frame>,
    outcome: Outcome,
}

/// Drives for so many hours over these stretches, in any order, and judges.
pub fn drive(hours: f64, seed: u64, stretches: &[Stretch]) -> Outcome {
    let begun = Instant::now();
    let config = Config::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("config/demo.toml")).unwrap();
    let database = config.input_database().unwrap();
    let senders = [(); 2].map(|()| {
        let radius = config.vehicle.wheel_radius_m.value;
        SimulatedFrames::new(Outputs::compile(&config.signals, &database, radius).unwrap())
    });
    let engine = Engine::new(&config).unwrap();
    let outcome = Outcome { digest: 0xCBF2_9CE4_8422_2325, ..Outcome::default() };
    let mut day = Day {
        clean: engine.clone(),
        spoiled: engine,
        config,
        senders,
        list: List::new(),
        blamed: "nothing yet",
        heard: Heard::default(),
        last: Vec::new(),
        outcome,
    };
    while day.outcome.seconds < hours * 3600.0 {
        day.stretch(seed, stretches);
    }
    day.outcome.memory.resident[1] = memory::resident();
    day.outcome.took_s = begun.elapsed().as_secs_f64();
    day.outcome
}

impl Day {
    fn stretch(&mut self, seed: u64, stretches: &[Stretch]) {
        let number = self.outcome.stretches;
        let mut dice = ChaCha8Rng::seed_from_u64(seed << 32 | number);
        // Each of them, then any.
        let stretch = match stretches.get(number as usize) {
            Some(stretch) => stretch,
            None => &stretches[dice.random_range(0..stretches.len())],
        };
        let begin = BEGIN + Micros((self.outcome.seconds * 1e6) as i64) + BETWEEN;
        let mut readings = stretch.readings_from(begin);
        let mut known = Known { begin, truths: &stretch.truths, clean: Vec::new() };
        self.without_faults(&readings, &mut known);

        let plan = self.list.plan(stretch.seconds, &mut dice);
        self.list.sensors(&plan, begin, &mut readings);
        let mut frames = Vec::new();
        self.senders[1].take(&readings, &mut |frame| frames.push(*frame));
        let mut mixed = Dice::new("soak", seed, number);
        for piece in self.list.pieces(&plan, begin, frames, &mut self.blamed, &mut mixed) {
            self.piece(&piece, &known);
        }
        self.outcome.seconds += stretch.seconds.ceil() + BETWEEN.seconds();
        self.outcome.stretches += 1;
        if number == 0 {
            self.outcome.memory = Memory::default();
        }
        if self.outcome.seconds < 3600.0 || number == 0 {
            self.outcome.memory.resident[0] = memory::resident();
        }
    }

    fn without_faults(&mut self, readings: &[Reading], known: &mut Known<'_>) {
        let mut frames = Vec::new();
        self.senders[0].take(readings, &mut |frame| frames.push(*frame));
        for frame in &frames {
            self.clean.frame(frame, &mut self.heard);
            self.heard.frames.clear();
            for (sample, estimates) in self.heard.estimates.drain(..) {
                sound(&estimates);
                let Some(truth) = known.truth(sample.time) else { continue };
                let offs = offs(truth, &estimates);
                self.outcome.verdict.without(&offs);
                known.clean.push((sample.time, offs));
            }
        }
    }

    fn piece(&mut self, piece: &Piece, known: &Known<'_>) {
        if piece.is_fault {
            *self.outcome.verdict.faults.entry(piece.blamed).or_default() += 1;
        }
        let mut published = std::mem::take(&mut self.last);
        if let Some(event) = piece.event {
            self.happens(event, piece);
        }
        if piece.event == Some(Event::Restart) {
            published.clear();
        }
        let carried = published.len();
        for frame in &piece.frames {
            let (engine, heard) = (&mut self.spoiled, &mut self.heard);
            self.outcome.memory.frame(|| engine.frame(frame, heard));
            published.append(&mut self.heard.frames);
            self.outcome.samples += self.heard.estimates.len() as u64;
            for (sample, estimates) in self.heard.estimates.drain(..) {
                sound(&estimates);
                let time = sample.time + piece.behind;
                if piece.is_chaos {
                    continue;
                }
                let (Some(truth), Some(clean)) = (known.truth(time), known.clean(time)) else { continue };
                let offs = offs(truth, &estimates);
                self.outcome.verdict.with(&offs, clean, piece.blamed, time - BEGIN, truth.unchanged_s);
            }
        }
        heard::protected(&published);
        self.outcome.frames += piece.frames.len() as u64;
        self.outcome.published += (published.len() - carried) as u64;
        for frame in &published[carried..] {
            self.outcome.digest = digest(self.outcome.digest, frame);
        }
        for frame in published.iter().rev() {
            if !self.last.iter().any(|last| last.id == frame.id) {
                self.last.push(*frame);
            }
        }
        assert_eq!(self.spoiled.learned().problem(), None);
    }

    fn happens(&mut self, event: Event, piece: &Piece) {
        let (config, engine, heard) = (&self.config, &mut self.spoiled, &mut self.heard);
        match event {
            Event::Reload => self.outcome.memory.exchange(|| {
                let before = std::mem::replace(engine, Engine::new(config).unwrap());
                engine.take_over(before, heard);
            }),
            Event::Restart => self.outcome.memory.exchange(|| {
                let learned = engine.learned();
                *engine = Engine::new(config).unwrap();
                engine.restore(&learned);
            }),
            Event::LinkDown => engine.report(Faults::BUS_DOWN),
            Event::Dropped => engine.report_dropped(piece.frames.len() as u64),
        }
    }
}

fn digest(before: u64, frame: &Frame) -> u64 {
    let (time, id) = (frame.time.0.to_le_bytes(), frame.id.number().to_le_bytes());
    let bytes = time.iter().chain(&id).chain(frame.data());
    bytes.fold(before, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3))
}
