//! The configuration with what was identified.

use std::path::Path;

use crate::cli::Failure;
use crate::cli::desk::applied::Applied;
use identify::{Identification, Parameter};
use lab::explain::ordinary::Ordinary;

/// The two axles' stiffnesses as one.
const BOTH: &str = "lateral_stiffness";

/// With what the recordings tell; what contradicts the table, or ends at a bound, only by force.
pub fn toml((from, to): (&Path, &Path), found: &Identification, force: bool) -> Result<String, Failure> {
    let mut applied = begin(from, to, found.seconds)?;
    for it in &found.parameters {
        let keys = match it.name {
            BOTH => vec![Parameter::LateralFront.name(), Parameter::LateralRear.name()],
            name if is_of_the_vehicle(name) => vec![name],
            _ => continue,
        };
        for key in keys {
            match &it.doubt {
                Some(doubt) if it.is_in_doubt() => applied.put_doubtful(key, doubt, force),
                _ if it.identifiable => applied.put(key, (it.value, it.std)),
                _ => (),
            }
        }
    }
    applied.text(&[])
}

/// The same of the ordinary car, whose tires bend.
pub fn of_ordinary((from, to): (&Path, &Path), found: &Ordinary, force: bool) -> Result<String, Failure> {
    let mut applied = begin(from, to, found.seconds)?;
    applied.bend_tires(found.tire);
    for it in found.numbers.iter().filter(|it| is_of_the_vehicle(&it.name)) {
        match &it.doubt {
            Some(doubt) => applied.put_doubtful(&it.name, doubt, force),
            None => applied.put(&it.name, (it.estimate.value, it.estimate.std)),
        }
    }
    applied.text(&[])
}

fn begin<'p>(from: &'p Path, to: &Path, seconds: f64) -> Result<Applied<'p>, Failure> {
    let mut applied = Applied::read(from, to)?;
    applied.say(&format!(
        "Written by gripd identify: {} with what {seconds:.0} s of recordings tell.",
        applied.name()
    ));
    Ok(applied)
}

/// Offsets are of sensors, and stand in other tables.
fn is_of_the_vehicle(name: &str) -> bool {
    Parameter::named(name).is_some_and(|parameter| !parameter.is_offset())
}
