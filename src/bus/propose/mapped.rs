//! A chosen signal as an entry of `[signals]`, with what stands beside it in its message.

use super::beside;
use super::drive::Drive;
use super::evidence::{Evidence, Verdict};
use super::proposal::Mapped;
use super::source::{Place, Unit};
use crate::dbc::Database;
use physics::Quantity;

/// Zeros beyond these are no sensor's offset that the estimators would learn, SI.
fn large_zero(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::YawRate => 0.05,
        Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration => 1.2,
        Quantity::SteeringWheelAngle => 0.2,
        _ => f64::INFINITY,
    }
}

/// A signal that was chosen.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    pub(super) place: Place,
    /// The bit with its sign.
    pub(super) sign_bit: Option<Place>,
    pub(super) unit: Unit,
}

/// The entry; `sign` is that of the gain. Adds to `words` what is uncertain about it.
pub(super) fn entry(
    database: &Database,
    drive: Option<&Drive>,
    quantity: Quantity,
    chosen: &Chosen,
    data: Option<(&Evidence, f64)>,
    words: &mut Vec<String>,
) -> Mapped {
    let place = chosen.place;
    let mut mapped = Mapped { signals: vec![place.name(database)], ..Mapped::default() };
    if quantity == Quantity::SteeringWheelAngle
        && let Some(fine) = beside::fine(database, place)
    {
        mapped.signals.push(fine.name(database));
    }
    mapped.sign = chosen.sign_bit.map(|sign| sign.name(database));
    if let Unit::Guessed(_, unit) = &chosen.unit {
        mapped.unit = Some((*unit).to_owned());
    }
    if let Some((evidence, sign)) = data.filter(|(evidence, _)| evidence.verdict == Verdict::Fits) {
        if sign < 0.0 {
            mapped.gain = Some(-1.0);
        }
        if let Some(zero) = evidence.zero.filter(|zero| zero.abs() > large_zero(quantity)) {
            let offset = -sign * (1000.0 * zero).round() / 1000.0;
            words.push(format!("reads {zero:.2} where it should read zero"));
            mapped.offset = Some(offset);
        }
    }
    quality(database, drive, place, &mut mapped, words);
    if let Some((drive, channel)) =
        drive.and_then(|drive| drive.channel(database, place).map(|channel| (drive, channel)))
    {
        if let Some(code) = channel.not_available() {
            words.push(format!("the raw value {code} comes and is far from all others"));
            mapped.not_available.push(code);
        } else if let Some(code) = drive.others_not_available(channel) {
            words.push(format!("other signals of its size have the raw value {code} where they have none"));
            mapped.not_available.push(code);
        }
    }
    mapped
}

/// Signals that tell of its quality, where it is known or seen when they allow it.
fn quality(
    database: &Database,
    drive: Option<&Drive>,
    place: Place,
    mapped: &mut Mapped,
    words: &mut Vec<String>,
) {
    for quality in beside::qualities(database, place) {
        let name = quality.place.name(database);
        let seen = drive.and_then(|drive| drive.channel(database, quality.place));
        let good = match seen {
            None => quality.good,
            Some(channel) if !quality.good.is_empty() => {
                let share: f64 = quality.good.iter().map(|code| channel.share_of(*code)).sum();
                if share < 0.5 {
                    words.push(format!(
                        "{name} would deny {:.0} % of the frames: left out",
                        100.0 * (1.0 - share)
                    ));
                    continue;
                }
                quality.good
            }
            Some(channel) => channel.usual_code().into_iter().collect(),
        };
        if good.is_empty() {
            words.push(format!("{name} may tell of its quality; with which values nothing says"));
        } else if mapped.valid.is_empty() || mapped.valid_when == good {
            mapped.valid.push(name);
            mapped.valid_when = good;
        }
    }
}

/// Names the counters that count, each with the first quantity of its message.
pub(super) fn counters<'m>(
    database: &Database,
    drive: &Drive,
    entries: impl Iterator<Item = &'m mut Mapped>,
) {
    let mut done: Vec<usize> = Vec::new();
    for mapped in entries {
        let Some((name, _)) = mapped.signals.first().and_then(|name| name.split_once('.')) else { continue };
        let Some(message) = database.messages().iter().position(|message| message.name == name) else {
            continue;
        };
        if done.contains(&message) {
            continue;
        }
        let Some((parts, modulo)) = drive.counter(database, message) else { continue };
        done.push(message);
        let bits: u32 =
            parts.iter().filter_map(|part| part.find(database)).map(|(_, s)| u32::from(s.size)).sum();
        mapped.counter = parts.iter().map(|part| part.name(database)).collect();
        mapped.counter_modulo = (bits < 32 && modulo < 1 << bits).then_some(modulo);
    }
}
