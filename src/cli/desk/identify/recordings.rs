//! Recordings to records: what the service would have seen of them, all kept in memory.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::cli::Failure;
use crate::cli::desk::part::Part;
use crate::cli::desk::progress::Progress;
use crate::cli::desk::samples;
use bus::Config;
use bus::can::{CanId, Frame};
use bus::signals::Sampler;
use identify::Record;
use physics::Micros;

/// Everything that was read.
pub struct Read {
    /// One for each recording.
    pub records: Vec<Record>,
    /// Why some could not be read to their end.
    pub broken: Vec<String>,
}

/// Reads all recordings.
pub fn read(logs: &[PathBuf], part: &Part, config: &Config) -> Result<Read, Failure> {
    let inputs = samples::inputs(config)?;
    let mut records = Vec::new();
    let mut broken = Vec::new();
    let progress = Progress::of_files(logs);
    for path in logs {
        let mut sampler = Sampler::new(inputs.clone(), &config.signals.sampling);
        let mut start = None;
        let mut frames: HashMap<CanId, u32> = HashMap::new();
        let used = |frame: &Frame, _: &Sampler, from: Option<Micros>| {
            start.get_or_insert(from.unwrap_or(frame.time));
            *frames.entry(frame.id).or_default() += 1;
        };
        let samples =
            samples::of_recording((path, part.clone()), &mut sampler, &progress, &mut broken, used)?;
        if samples.is_empty() && broken.is_empty() {
            return Err(samples::none_of(&inputs, path, "nothing to identify from"));
        }
        let there = samples::there(&inputs, &samples, path)?;
        let record = Record::new(&name(path), &samples, &there);
        let seconds = record.rows.len() as f64 * record.period_s;
        let quickest = frames.values().copied().max().unwrap_or(1);
        let record = record.no_denser_than(seconds / f64::from(quickest));
        records.push(match start {
            Some(start) => record.counted_from(start),
            None => record,
        });
    }
    progress.finish();
    Ok(Read { records, broken })
}

/// What a recording is called where its folder does not matter.
fn name(path: &Path) -> String {
    if path.as_os_str() == "-" {
        return "standard input".into();
    }
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
