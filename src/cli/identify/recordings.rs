//! Recordings to records: what the service would have seen of them, all kept in memory.

use std::path::{Path, PathBuf};

use crate::Config;
use crate::can::candump::Reader;
use crate::cli::Failure;
use crate::cli::progress::Progress;
use crate::identify::Record;
use crate::service::sensors;
use crate::signals::{Inputs, Sampler};

/// A record for each recording, and why some could not be read to their end.
pub fn read(logs: &[PathBuf], config: &Config) -> Result<(Vec<Record>, Vec<String>), Failure> {
    let database = config.input_database()?;
    let radius = config.vehicle.wheel_radius_m.value;
    let inputs = Inputs::compile(&config.signals, &database, radius).map_err(Failure::usage)?;
    let mut records = Vec::new();
    let mut broken = Vec::new();
    let progress = Progress::of_files(logs);
    for path in logs {
        let mut sampler = Sampler::new(inputs.clone(), &config.signals.sampling);
        let mut reader = Reader::open(path).map_err(Failure::work)?;
        let mut samples = Vec::new();
        loop {
            match reader.next_frame() {
                Ok(None) => break,
                // What could be read before the damage is still worth something.
                Err(error) => {
                    broken.push(error.to_string());
                    break;
                }
                Ok(Some(frame)) => {
                    sampler.push(&frame);
                    samples.extend(std::iter::from_fn(|| sampler.next_sample()));
                    progress.advance(reader.stats().lines);
                }
            }
        }
        sampler.flush();
        samples.extend(std::iter::from_fn(|| sampler.next_sample()));
        if samples.is_empty() && broken.is_empty() {
            let ids: Vec<_> = inputs.ids().iter().map(ToString::to_string).collect();
            return Err(Failure::work(format_args!(
                "{}: nothing to identify from: not all of the needed identifiers ({}) are in it; is it of this car \
                 and bus? `gripd check` tells more",
                path.display(),
                ids.join(", ")
            )));
        }
        records.push(Record::new(&name(path), &samples, &sensors(&inputs)));
    }
    progress.finish();
    Ok((records, broken))
}

/// What a recording is called where its folder does not matter.
fn name(path: &Path) -> String {
    if path.as_os_str() == "-" {
        return "standard input".into();
    }
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
