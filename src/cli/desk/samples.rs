//! A recording as the samples that the service would have made of it.

use std::path::Path;

use super::Failure;
use super::part::Part;
use super::progress::Progress;
use bus::Config;
use bus::can::Frame;
use bus::service::sensors;
use bus::signals::{Inputs, Pushed, Sampler};
use physics::estimate::{Heard, PlainReadings};
use physics::{Micros, Quantity, Sample, Sensors};

/// What a configuration reads from a bus.
pub fn inputs(config: &Config) -> Result<Inputs, Failure> {
    let database = config.input_database()?;
    Inputs::compile(&config.signals, &database, config.vehicle.wheel_radius_m.value).map_err(Failure::usage)
}

/// All samples of a part of a recording; `used` sees every frame that the sampler has used, and from when on its seconds are
/// counted, if not from the first of them. Why the recording could not
/// be read to its end goes to `broken`: what could be read before the damage is still worth something.
pub fn of_recording(
    source: (&Path, Part),
    sampler: &mut Sampler,
    progress: &Progress,
    broken: &mut Vec<String>,
    used: impl FnMut(&Frame, &Sampler, Option<Micros>),
) -> Result<Vec<Sample>, Failure> {
    of_recording_altered(source, |frame| frame, sampler, progress, broken, used)
}

/// The same of frames that are altered before anybody sees them.
pub fn of_recording_altered(
    (path, part): (&Path, Part),
    mut alter: impl FnMut(Frame) -> Frame,
    sampler: &mut Sampler,
    progress: &Progress,
    broken: &mut Vec<String>,
    mut used: impl FnMut(&Frame, &Sampler, Option<Micros>),
) -> Result<Vec<Sample>, Failure> {
    let mut reader = part.open(path)?;
    let mut samples = Vec::new();
    loop {
        match reader.next_frame() {
            Ok(None) => break,
            Err(error) => {
                broken.push(error.to_string());
                break;
            }
            Ok(Some(frame)) => {
                let frame = alter(frame);
                if sampler.push(&frame) == Pushed::Used {
                    used(&frame, sampler, reader.counted_from());
                }
                samples.extend(std::iter::from_fn(|| sampler.next_sample()));
                progress.advance(reader.stats().lines);
            }
        }
    }
    sampler.flush();
    samples.extend(std::iter::from_fn(|| sampler.next_sample()));
    Ok(samples)
}

/// Samples as a plain car's sensors would have made them: without what the configuration's effects do to them, as far as
/// its tables do not hold that already ([`Config::corrected`]).
pub fn make_plain(samples: &mut [Sample], config: &Config) {
    let Some(mut plain) = PlainReadings::new(&config.vehicle, &config.effect) else { return };
    let mut heard = Heard::default();
    for sample in samples {
        heard.hear(sample);
        *sample = plain.step(sample, heard, None).sample;
    }
}

/// What a recording has of the configured quantities. One that never has a value counts as one that the car does not
/// have, and that is told.
pub fn there(inputs: &Inputs, samples: &[Sample], path: &Path) -> Result<Sensors, Failure> {
    let heard = samples.iter().fold(0, |bits, sample| bits | sample.present());
    let mut there = sensors(inputs);
    for quantity in Quantity::ALL.into_iter().filter(|q| inputs.has(*q) && heard & q.bit() == 0) {
        there.remove(quantity);
        // Of nothing at all that is no news.
        if samples.is_empty() {
            continue;
        }
        tracing::warn!("{}: {quantity} never has a value: as if it were not configured", path.display());
    }
    match Quantity::lacking(|quantity| there.has(quantity)).first() {
        Some(lacking) if !samples.is_empty() => {
            let names: Vec<_> = lacking.iter().map(|quantity| quantity.name()).collect();
            Err(Failure::work(format_args!(
                "{}: {} is required and never has a value; `gripd check` tells more",
                path.display(),
                names.join(" or ")
            )))
        }
        _ => Ok(there),
    }
}

/// Nothing of what is needed is in a recording.
pub fn none_of(inputs: &Inputs, path: &Path, what: &str) -> Failure {
    let ids: Vec<_> = inputs.ids().iter().map(ToString::to_string).collect();
    Failure::work(format_args!(
        "{}: {what}: not all of the needed identifiers ({}) are in it; is it of this car and bus? `gripd check` \
         tells more",
        path.display(),
        ids.join(", ")
    ))
}
