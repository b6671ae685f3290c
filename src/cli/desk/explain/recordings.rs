//! Recordings as they are explained: every reading at its own time, and what the audit of the chain says.

use std::path::PathBuf;

use crate::cli::Failure;
use crate::cli::desk::part::Part;
use crate::cli::desk::progress::Progress;
use crate::cli::desk::samples;
use bus::Config;
use bus::can::Frame;
use bus::signals::Sampler;
use lab::explain::chain::{self, ChainReport};
use lab::explain::{Order, Recording, order};
use physics::{Micros, Quantity};

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

/// Reads all recordings, of each by its place the part that is asked for.
pub fn read(logs: &[PathBuf], part: impl Fn(usize) -> Part, config: &Config) -> Result<Read, Failure> {
    let inputs = samples::inputs(config)?;
    let mut read = Read { recordings: Vec::new(), starts: Vec::new(), chain: Vec::new(), broken: Vec::new() };
    let progress = Progress::of_files(logs);
    for (place, path) in logs.iter().enumerate() {
        // What is implausible is what there is to explain: nothing is taken out.
        let mut unchecked = config.signals.sampling;
        unchecked.cross_checks = false;
        let mut sampler = Sampler::new(inputs.clone(), &unchecked);
        let mut tracks = Tracks::new(path.display().to_string());
        let take = |frame: &Frame, sampler: &Sampler, start: Option<Micros>| {
            tracks.take(start.unwrap_or(frame.time), sampler);
        };
        let samples =
            samples::of_recording((path, part(place)), &mut sampler, &progress, &mut read.broken, take)?;
        if tracks.recording.seconds() == 0.0 && read.broken.is_empty() {
            return Err(samples::none_of(&inputs, path, "nothing to explain"));
        }
        let there = samples::there(&inputs, &samples, path)?;
        read.chain.push(chain::audit(&samples, &config.vehicle, &there));
        read.starts.push(tracks.start.unwrap_or_default());
        tracks.recording.begins_s = tracks.start.map(Micros::seconds);
        read.recordings.push(tracks.recording);
    }
    progress.finish();
    Ok(read)
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
