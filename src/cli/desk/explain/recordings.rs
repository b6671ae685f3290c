//! Recordings as they are explained: every reading at its own time, and what the audit of the chain says.

use std::path::{Path, PathBuf};

use crate::cli::Failure;
use crate::cli::desk::part::Part;
use crate::cli::desk::progress::Progress;
use crate::cli::desk::samples;
use bus::Config;
use bus::can::Frame;
use bus::signals::{Sampler, SamplerConfig};
use lab::explain::chain::{self, ChainReport};
use lab::explain::{Order, Recording, order};
use physics::{Micros, Quantity, Sample, Sensors};

/// Everything that was read.
pub struct Read {
    /// The recordings.
    pub recordings: Vec<Recording>,
    /// When each begins: its seconds are counted from there.
    pub starts: Vec<Micros>,
    /// The audit of each.
    pub chain: Vec<ChainReport>,
    /// Why some could not be read to their end.
    pub broken: Vec<String>,
}

impl Read {
    /// Puts the recordings behind the first `references` in the order in which they were driven, as far as they know; says
    /// whether they do.
    pub fn put_in_order(&mut self, references: usize) -> Order {
        let (order, places) = order(&self.recordings[references..]);
        let all = || (0..references).chain(places.iter().map(|place| references + place));
        let mut recordings: Vec<Option<Recording>> = self.recordings.drain(..).map(Some).collect();
        let mut chain: Vec<Option<ChainReport>> = self.chain.drain(..).map(Some).collect();
        self.starts = all().map(|place| self.starts[place]).collect();
        self.recordings = all().filter_map(|place| recordings[place].take()).collect();
        self.chain = all().filter_map(|place| chain[place].take()).collect();
        order
    }

    /// Fails where something could not be read to its end: what was said is of the rest.
    pub fn whole(&self) -> Result<(), Failure> {
        if self.broken.is_empty() { Ok(()) } else { Err(Failure::Work(self.broken.join("; "))) }
    }
}

/// One of them.
pub struct One {
    /// The recording.
    pub recording: Recording,
    /// When it begins.
    pub start: Micros,
    /// The audit.
    pub chain: ChainReport,
}

/// Reads all recordings, of each by its place the part that is asked for.
pub fn read(logs: &[PathBuf], part: impl Fn(usize) -> Part, config: &Config) -> Result<Read, Failure> {
    let mut read = Read { recordings: Vec::new(), starts: Vec::new(), chain: Vec::new(), broken: Vec::new() };
    let progress = Progress::of_files(logs);
    for (place, path) in logs.iter().enumerate() {
        let one = one((path, part(place)), config, &progress, &mut read.broken, |frame| frame)?;
        read.chain.push(one.chain);
        read.starts.push(one.start);
        read.recordings.push(one.recording);
    }
    progress.finish();
    Ok(read)
}

/// Reads one recording, its frames altered; why it could not be read to its end goes to `broken`.
pub fn one(
    (path, part): (&Path, Part),
    config: &Config,
    progress: &Progress,
    broken: &mut Vec<String>,
    alter: impl FnMut(Frame) -> Frame,
) -> Result<One, Failure> {
    let inputs = samples::inputs(config)?;
    // What is implausible is what there is to explain: nothing is taken out.
    let mut unchecked = config.signals.sampling;
    unchecked.cross_checks = false;
    let mut sampler = Sampler::new(inputs.clone(), &unchecked);
    let mut tracks = Tracks::new(path.display().to_string());
    let mut beside = BesideEffects::new(config, &unchecked)?;
    let take = |frame: &Frame, sampler: &Sampler, start: Option<Micros>| {
        tracks.take(start.unwrap_or(frame.time), sampler);
        if let Some(beside) = &mut beside {
            beside.push(frame);
        }
    };
    let samples = samples::of_recording_altered((path, part), alter, &mut sampler, progress, broken, take)?;
    if tracks.recording.seconds() == 0.0 && broken.is_empty() {
        return Err(samples::none_of(&inputs, path, "nothing to explain"));
    }
    let there = samples::there(&inputs, &samples, path)?;
    let chain = match beside {
        Some(beside) => beside.audit(&there),
        None => chain::audit(&samples, &config.vehicle, &there),
    };
    tracks.recording.begins_s = tracks.start.map(Micros::seconds);
    Ok(One { chain, start: tracks.start.unwrap_or_default(), recording: tracks.recording })
}

/// The samples without what the configuration's effects do to them: the simulations have these effects, so that the audit
/// must not find them again.
struct BesideEffects {
    config: Config,
    sampler: Sampler,
    samples: Vec<Sample>,
}

impl BesideEffects {
    /// None for a car without effects.
    fn new(config: &Config, sampling: &SamplerConfig) -> Result<Option<Self>, Failure> {
        if config.effect.is_empty() {
            return Ok(None);
        }
        let config = config.clone().corrected();
        let sampler = Sampler::new(samples::inputs(&config)?, sampling);
        Ok(Some(Self { config, sampler, samples: Vec::new() }))
    }

    fn push(&mut self, frame: &Frame) {
        self.sampler.push(frame);
        self.samples.extend(std::iter::from_fn(|| self.sampler.next_sample()));
    }

    fn audit(mut self, there: &Sensors) -> ChainReport {
        self.sampler.flush();
        self.samples.extend(std::iter::from_fn(|| self.sampler.next_sample()));
        samples::make_plain(&mut self.samples, &self.config);
        chain::audit(&self.samples, &self.config.vehicle, there)
    }
}

/// Readings as they come.
struct Tracks {
    recording: Recording,
    start: Option<Micros>,
    last: [Option<Micros>; Quantity::COUNT],
}

impl Tracks {
    fn new(name: String) -> Self {
        let recording = Recording { name, ..Recording::default() };
        Self { recording, start: None, last: [None; Quantity::COUNT] }
    }

    /// Takes what a frame has brought; seconds are counted from the first one's start.
    fn take(&mut self, start: Micros, sampler: &Sampler) {
        let start = *self.start.get_or_insert(start);
        for quantity in Quantity::ALL {
            let place = quantity as usize;
            if let Some((time, value)) = sampler.newest(quantity)
                && self.last[place].is_none_or(|last| time > last)
            {
                self.last[place] = Some(time);
                self.recording.tracks[place].push(((time - start).seconds(), value));
            }
        }
    }
}
