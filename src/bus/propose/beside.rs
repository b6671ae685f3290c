//! What stands beside a value in its message: the bit with its sign, the finer part, quality, counter.

use super::source::Place;
use super::vocabulary::NO_MEASUREMENT;
use super::words::Words;
use crate::dbc::{Database, Message, Signal};
use physics::Quantity;

/// A signal that says whether the value may be used.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Quality {
    pub(super) place: Place,
    /// Raw values at which it may; empty where nothing tells.
    pub(super) good: Vec<u64>,
}

/// The one-bit signal that is 1 where the value is negative. Only a value that cannot be negative itself has one.
pub(super) fn sign(database: &Database, place: Place, quantity: Quantity) -> Option<Place> {
    let signed = matches!(
        quantity,
        Quantity::YawRate
            | Quantity::LateralAcceleration
            | Quantity::LongitudinalAcceleration
            | Quantity::SteeringWheelAngle
    );
    let (message, value) = place.find(database)?;
    if !signed || value.codec().range().0 < 0.0 {
        return None;
    }
    let told: Vec<(usize, &Signal)> = indexed(message)
        .filter(|(_, signal)| {
            signal.size == 1 && Words::of(&signal.name).any(&["vz", "sign", "vorz*", "neg*", "sgn"])
        })
        .collect();
    let own: Vec<usize> = told
        .iter()
        .map(|(place, _)| *place)
        .filter(|flag| is_of(message, *flag, place.signal, true))
        .collect();
    // With no word in common, the bit right above the value.
    let end = value.start_bit + u16::from(value.size);
    let next =
        || told.iter().find(|(_, flag)| (end..end + 3).contains(&flag.start_bit)).map(|(place, _)| *place);
    let signal = own.first().copied().or_else(next)?;
    Some(Place { message: place.message, signal })
}

/// The signal that is to be added: finer steps that together make up one step of the coarse one.
pub(super) fn fine(database: &Database, place: Place) -> Option<Place> {
    let (message, coarse) = place.find(database)?;
    let step = coarse.factor.abs();
    let signal = indexed(message).find(|(_, fine)| {
        let (low, high) = fine.codec().range();
        let named = Words::of(&fine.name).any(&["frac*", "fine*", "fein*", "nachk*"]);
        let same_unit = fine.unit == coarse.unit || fine.unit.is_empty();
        let fills = (0.75..1.25).contains(&((high - low + fine.factor.abs()) / step));
        fine.name != coarse.name
            && (3..=8).contains(&fine.size)
            && same_unit
            && fine.factor.abs() < 0.5 * step
            && fills
            && named
    })?;
    Some(Place { message: place.message, signal: signal.0 })
}

/// Signals of the message that tell of this value's quality.
pub(super) fn qualities(database: &Database, place: Place) -> Vec<Quality> {
    const TELLING: &[&str] = &[
        "qf", "qbit", "qb", "qual*", "valid*", "vld", "fault*", "falt", "flt", "fehler~", "stat", "status",
        "sta", "gueltig*", "inv*", "err*", "ok",
    ];
    let Some((message, _)) = place.find(database) else { return Vec::new() };
    indexed(message)
        .filter(|(_, flag)| flag.size <= 4 && Words::of(&flag.name).any(TELLING))
        .filter(|(flag, _)| is_of(message, *flag, place.signal, false))
        .map(|(signal, flag)| Quality { place: Place { message: place.message, signal }, good: good(flag) })
        .collect()
}

/// At which raw values it is well: by the names of the values, else by its own where that is beyond doubt.
fn good(flag: &Signal) -> Vec<u64> {
    const WELL: &[&str] =
        &["ok", "valid", "normal", "good", "noerror", "nofault", "gueltig", "io", "inordnung", "allwssvalid"];
    let mask = flag.codec().extractor.mask();
    let plain = |text: &str| -> String {
        text.chars().filter(char::is_ascii_alphanumeric).flat_map(char::to_lowercase).collect()
    };
    let named: Vec<u64> = flag
        .values
        .iter()
        .filter(|(_, name)| WELL.contains(&plain(name).as_str()))
        .map(|(value, _)| *value as u64 & mask)
        .collect();
    let words = Words::of(&flag.name);
    if !named.is_empty() || !flag.values.is_empty() || flag.size > 1 {
        return named;
    }
    // VW's QBit is 1 while the value is a substitute.
    if words.any(&["fault*", "falt", "flt", "fehler~", "qbit", "inv*", "err*"]) {
        vec![0]
    } else if words.any(&["valid*", "vld", "gueltig*", "ok"]) {
        vec![1]
    } else {
        Vec::new()
    }
}

/// The message's counter, by its name; several parts, least significant first.
pub(super) fn counter(message: &Message) -> Vec<usize> {
    let named = |signal: &Signal| {
        signal.size <= 8
            && Words::of(&signal.name).any(&[
                "counter*",
                "cnt*",
                "zaehler~",
                "alive*",
                "alv",
                "msgcnt",
                "rollingcounter",
            ])
    };
    let found: Vec<usize> =
        indexed(message).filter(|(_, signal)| named(signal)).map(|(place, _)| place).collect();
    match found.as_slice() {
        [one] => vec![*one],
        [one, other] => {
            let lower = |place: &usize| {
                message.signals.get(*place).is_some_and(|s| Words::of(&s.name).any(&["lsb", "low", "l"]))
            };
            let upper = |place: &usize| {
                message.signals.get(*place).is_some_and(|s| Words::of(&s.name).any(&["msb", "high", "h"]))
            };
            match (lower(one) && upper(other), lower(other) && upper(one)) {
                (true, false) => vec![*one, *other],
                (false, true) => vec![*other, *one],
                _ => Vec::new(),
            }
        }
        _ => Vec::new(),
    }
}

fn indexed(message: &Message) -> impl Iterator<Item = (usize, &Signal)> {
    message.signals.iter().enumerate()
}

/// Does the flag's name speak of this value, and of none of the others more?
fn is_of(message: &Message, flag: usize, value: usize, exclusive: bool) -> bool {
    let Some(flag_words) = message.signals.get(flag).map(distinct) else { return false };
    // A word that every signal of the message has tells nothing.
    let weight = |word: &String| -> f64 {
        let having =
            message.signals.iter().filter(|other| distinct(other).iter().any(|own| alike(word, own)));
        1.02 - having.count() as f64 / message.signals.len() as f64
    };
    let all: f64 = flag_words.iter().map(weight).sum();
    let shared = |place: usize| -> f64 {
        let Some(signal) = message.signals.get(place) else { return 0.0 };
        let own = distinct(signal);
        let common = flag_words.iter().filter(|word| own.iter().any(|other| alike(word, other)));
        // Of two that have as much in common, the one with less besides.
        common.map(weight).sum::<f64>() - 0.001 * own.len() as f64
    };
    let mine = shared(value);
    let others = (0..message.signals.len()).filter(|place| *place != flag && *place != value);
    let others = others.filter(|place| message.signals.get(*place).is_some_and(|s| s.size >= 6));
    let most = others.map(shared).fold(0.0, f64::max);
    mine > 0.6 * all && mine > 0.1 && if exclusive { mine > most } else { mine >= most }
}

/// The words of a name, without those of quality and order.
fn distinct(signal: &Signal) -> Vec<String> {
    let words = Words::of(&signal.name);
    let tells = |word: &&str| {
        let alone = Words::of(word);
        !alone.any(NO_MEASUREMENT) && !alone.any(&["sig", "val", "d", "b", "no", "q", "bit"])
    };
    words.iter().filter(tells).map(str::to_owned).collect()
}

/// The same word, or one that begins with the same four letters, half of it or more.
fn alike(one: &str, other: &str) -> bool {
    let common = one.chars().zip(other.chars()).take_while(|(a, b)| a == b).count();
    one == other || (common >= 4 && 2 * common >= one.len().min(other.len()))
}
