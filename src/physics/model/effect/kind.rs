//! What is to be said of a kind of effect.

use super::spec::OF_CHANNEL;
use super::{Channel, Course, Disturbance, Effect, SearchHints, Spec, Usual, law};
use crate::Quantity;

/// A kind of effect.
#[derive(Debug)]
pub struct Kind {
    /// Its name in `[[effect]] kind = …` and in the JSON.
    pub name: &'static str,
    /// Its name in a sentence. What stands in braces is the channel, and is said as it is where none is known: "late
    /// {sensor}".
    pub words: &'static str,
    /// In one sentence, for a chassis engineer.
    pub about: &'static str,
    /// Its equation, in the signs of the conventions.
    pub equation: &'static str,
    /// Where the equation is from.
    pub source: &'static str,
    /// Which of the plain model's equations (or which sensors) it changes, in words.
    pub place: &'static str,
    /// The manoeuvre that shows it best and apart from others.
    pub to_tell_apart: &'static str,
    /// What it can be of; empty where it is of the car, and not of the measurement.
    pub channels: &'static [Channel],
    /// Its numbers.
    pub parameters: &'static [Spec],
    /// Its course in time, where it has one.
    pub course: Option<Disturbance>,
    /// How it is searched for.
    pub search: SearchHints,
    /// Makes one of it.
    pub make: fn(&Setting<'_>) -> Box<dyn Effect>,
}

/// All that an effect is made of.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// A value for each of [`Kind::parameters`].
    pub values: &'a [f64],
    /// What it is of.
    pub channel: Option<Channel>,
    /// Its course in time.
    pub course: &'a Course,
}

impl Setting<'_> {
    /// The one quantity it is of.
    pub fn quantity(&self) -> Option<Quantity> {
        self.channel.and_then(Channel::quantity)
    }
}

/// There is one of each name.
impl PartialEq for Kind {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Kind {
    /// Makes one of it.
    pub fn effect(&self, setting: &Setting<'_>) -> Box<dyn Effect> {
        (self.make)(setting)
    }

    /// Where a parameter is in `values`.
    pub fn place_of(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|spec| spec.name == name)
    }

    /// Where the moment of its onset is in `values`, if it begins at one.
    pub fn onset(&self) -> Option<usize> {
        self.place_of(Spec::AT_S.name)
    }

    /// What of it is nothing unusual, of a channel, if not every car has it.
    pub fn usual(&self, channel: Option<Channel>) -> Option<Usual> {
        let quantity = channel.and_then(Channel::quantity);
        self.search.usual.filter(|usual| usual.of.is_none() || usual.of == quantity)
    }

    /// Is it an error of the measurement, not physics of the car?
    pub fn is_of_measurement(&self) -> bool {
        !self.channels.is_empty()
    }

    /// Is it none of the library, but a [law](super::law)?
    pub fn is_law(&self) -> bool {
        *self == law::KIND
    }

    /// Is it there or not, with no number that says how much?
    pub fn is_all_or_nothing(&self) -> bool {
        self.parameters.is_empty() && self.course.is_none()
    }

    /// [`Kind::words`] of a channel.
    pub fn words_of(&self, channel: Option<&str>) -> String {
        match self.words.split_once('{').and_then(|(before, rest)| Some((before, rest.split_once('}')?))) {
            Some((before, (any, after))) => format!("{before}{}{after}", channel.unwrap_or(any)),
            None => self.words.to_owned(),
        }
    }

    /// One of its numbers, for a channel: with its unit and sizes.
    pub fn spec(&self, place: usize, channel: Option<Channel>) -> Option<Spec> {
        let mut spec = *self.parameters.get(place)?;
        if let (OF_CHANNEL, Some((unit, size))) = (spec.unit, channel.and_then(Channel::usual_error)) {
            spec.unit = unit;
            spec.mean *= size;
            spec.std *= size;
            spec.bounds = (spec.bounds.0 * size, spec.bounds.1 * size);
            spec.step *= size;
        }
        Some(spec)
    }

    /// What is known of its course, for a channel.
    pub fn disturbance(&self, channel: Option<Channel>) -> Option<Disturbance> {
        let mut course = self.course?;
        if let (OF_CHANNEL, Some((unit, size))) = (course.unit, channel.and_then(Channel::usual_error)) {
            course.unit = unit;
            course.size *= size;
        }
        Some(course)
    }
}
