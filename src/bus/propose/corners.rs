//! Four signals that are called alike but for the corner of the car: the wheels.

use std::collections::HashMap;

use super::names::{MENTIONED, technical};
use super::source::{Place, Unit, is_number};
use super::vocabulary;
use crate::dbc::{Database, Signal};
use physics::Quantity;

/// Four wheels, in the order front left, front right, rear left, rear right.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wheels {
    pub(super) places: [Place; 4],
    /// As of [`super::names::Named`].
    pub(super) score: f64,
    pub(super) unit: Unit,
    /// The name says which corner; else only that there are four of a kind.
    pub(super) corners_named: bool,
}

/// How corners are called, front left first.
const CORNERS: &[[&str; 4]] = &[
    ["fl", "fr", "rl", "rr"],
    ["lf", "rf", "lr", "rr"],
    ["vl", "vr", "hl", "hr"],
    ["frl", "frr", "rel", "rer"],
    ["frntl", "frntr", "rearl", "rearr"],
    ["frontleft", "frontright", "rearleft", "rearright"],
    ["leftfront", "rightfront", "leftrear", "rightrear"],
    ["frntleft", "frntright", "rearleft", "rearright"],
    ["frlf", "frrt", "relf", "rert"],
    ["frntlft", "frntrt", "rearlft", "rearrt"],
    ["lftfrnt", "rtfrnt", "lftrear", "rtrear"],
    ["frontli", "frontre", "heckli", "heckre"],
    ["vornelinks", "vornerechts", "hintenlinks", "hintenrechts"],
    ["vornli", "vornre", "hintenli", "hintenre"],
    ["lv", "rv", "lh", "rh"],
    ["avg", "avd", "arg", "ard"],
    ["avantgauche", "avantdroite", "arrieregauche", "arrieredroite"],
    ["antsx", "antdx", "postsx", "postdx"],
    ["asx", "adx", "psx", "pdx"],
    ["di", "dd", "ti", "td"],
    ["frontl", "frontr", "rearl", "rearr"],
    ["vf", "hf", "vb", "hb"],
];

/// All groups of four by their names or comments, best first.
pub(super) fn groups(database: &Database) -> Vec<Wheels> {
    let mut found: Vec<Wheels> = Vec::new();
    let texts: [fn(&Signal) -> &str; 2] = [|signal| &signal.name, |signal| &signal.comment];
    for text in texts {
        let mut by_text: HashMap<String, Vec<Place>> = HashMap::new();
        let numbers = || Place::all(database).filter(|p| p.find(database).is_some_and(|(_, s)| is_number(s)));
        for place in numbers() {
            let Some((_, signal)) = place.find(database) else { continue };
            by_text.entry(squashed(text(signal))).or_default().push(place);
        }
        for place in numbers() {
            let Some((_, signal)) = place.find(database) else { continue };
            for places in alike(database, place, &squashed(text(signal)), &by_text) {
                let known = found.iter().any(|group| group.places == places);
                if let Some(group) = judge(database, places).filter(|_| !known) {
                    found.push(group);
                }
            }
        }
    }
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    found
}

/// Letters and digits only, small.
fn squashed(text: &str) -> String {
    text.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}

/// The groups whose front left this may be.
fn alike(
    database: &Database,
    first: Place,
    text: &str,
    by_text: &HashMap<String, Vec<Place>>,
) -> Vec<[Place; 4]> {
    let mut found = Vec::new();
    for corners in CORNERS {
        for (at, _) in text.match_indices(corners[0]) {
            let other = |corner: &str| {
                let name = format!("{}{corner}{}", &text[..at], &text[at + corners[0].len()..]);
                nearest(database, first, by_text.get(&name)?)
            };
            let (Some(b), Some(c), Some(d)) = (other(corners[1]), other(corners[2]), other(corners[3]))
            else {
                continue;
            };
            found.push([first, b, c, d]);
        }
    }
    found
}

/// The one of the same make, best in the same message.
fn nearest(database: &Database, first: Place, places: &[Place]) -> Option<Place> {
    let (_, one) = first.find(database)?;
    let same = |place: &&Place| {
        place.find(database).is_some_and(|(_, other)| {
            (one.size, one.factor, one.offset, &one.unit)
                == (other.size, other.factor, other.offset, &other.unit)
        })
    };
    let fitting = places.iter().filter(same);
    fitting.min_by_key(|place| place.message.abs_diff(first.message)).copied()
}

/// How well four signals' names and units fit; `None` if they are evidently something else.
fn judge(database: &Database, places: [Place; 4]) -> Option<Wheels> {
    let (_, signal) = places[0].find(database)?;
    let unit = Unit::of(Quantity::WheelSpeedFl, signal);
    let words = vocabulary::of(Quantity::WheelSpeedFl);
    let scores = places.iter().map(|place| Some(words.score(&place.spoken(database)?, false)));
    let mut least = scores.collect::<Option<Vec<f64>>>()?.into_iter().fold(1.0, f64::min);
    // Four corners and a unit of speed leave little doubt, whatever the word for wheel is.
    if least == 0.0 && matches!(unit, Unit::Known(_)) {
        let told = places.iter().all(|place| {
            place.spoken(database).is_some_and(|spoken| {
                !spoken.signal.any(vocabulary::NO_MEASUREMENT) && !spoken.signal.any(words.not)
            })
        });
        least = if told { 0.65 } else { 0.0 };
    }
    let score = least * technical(Quantity::WheelSpeedFl, signal, &unit);
    (score >= MENTIONED).then_some(Wheels { places, score, unit, corners_named: true })
}

/// Groups of four of one make in one message, or two and two in two messages, whatever they are called: for the
/// data to judge.
pub(super) fn nameless(database: &Database) -> Vec<Wheels> {
    let mut found = Vec::new();
    let mut pairs: Vec<([Place; 2], &Signal)> = Vec::new();
    for (message, content) in database.messages().iter().enumerate() {
        let mut makes: Vec<(&Signal, Vec<Place>)> = Vec::new();
        for (signal, one) in content.signals.iter().enumerate() {
            let usable = one.size >= 9 && is_number(one);
            if !usable || Unit::of(Quantity::WheelSpeedFl, one) == Unit::Unfitting {
                continue;
            }
            let place = Place { message, signal };
            match makes.iter_mut().find(|(make, _)| same_make(make, one)) {
                Some((_, places)) => places.push(place),
                None => makes.push((one, vec![place])),
            }
        }
        for (make, places) in makes {
            match places.as_slice() {
                [a, b] => pairs.push(([*a, *b], make)),
                // Beyond six there are too many ways to choose.
                several @ [_, _, _, _, ..] if several.len() <= 6 => {
                    found.extend(fours(several).map(|places| group(places, make)));
                }
                _ => {}
            }
        }
    }
    for (place, ([a, b], make)) in pairs.iter().enumerate() {
        for ([c, d], other) in &pairs[place + 1..] {
            if same_make(make, other) {
                found.push(group([*a, *b, *c, *d], make));
            }
        }
    }
    found
}

fn group(places: [Place; 4], make: &Signal) -> Wheels {
    Wheels { places, score: 0.0, unit: Unit::of(Quantity::WheelSpeedFl, make), corners_named: false }
}

fn same_make(one: &Signal, other: &Signal) -> bool {
    (one.size, one.factor, one.offset, &one.unit) == (other.size, other.factor, other.offset, &other.unit)
}

/// All ways to take four.
fn fours(places: &[Place]) -> impl Iterator<Item = [Place; 4]> {
    let count = places.len();
    (0..1_usize << count).filter(|mask| mask.count_ones() == 4).filter_map(move |mask| {
        let chosen: Vec<Place> =
            places.iter().enumerate().filter(|(bit, _)| mask >> bit & 1 == 1).map(|(_, p)| *p).collect();
        chosen.try_into().ok()
    })
}
