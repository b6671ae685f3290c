//! What kinds of effects there are, and what is known of each before any recording.

use super::{Channel, Course, Effect};
use crate::Quantity;

/// The coordinate in which a number is searched, and in which what is known of it is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// The number itself.
    Linear,
    /// One over it: a friction without limit is 0.
    Inverse,
    /// Its natural logarithm: for factors.
    Logarithmic,
}

impl Scale {
    /// From the number to the coordinate.
    pub fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Inverse => value.recip(),
            Self::Logarithmic => value.ln(),
        }
    }

    /// From the coordinate to the number.
    pub fn value(self, coordinate: f64) -> f64 {
        match self {
            Self::Linear => coordinate,
            Self::Inverse => coordinate.recip(),
            Self::Logarithmic => coordinate.exp(),
        }
    }

    /// How the number changes with the coordinate, there: turns one's standard deviation into the
    /// other's.
    pub fn slope(self, coordinate: f64) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Inverse => -coordinate.powi(-2),
            Self::Logarithmic => coordinate.exp(),
        }
    }
}

/// One number of an effect. `mean`, `std`, `bounds` and `step` are in the coordinate of `scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spec {
    /// Its key in the `[[effect]]` table and in the JSON, with its unit in the name or in `unit`.
    pub name: &'static str,
    /// Its unit; 1 for ratios, [`OF_CHANNEL`] for a share of the channel's usual error.
    pub unit: &'static str,
    /// The coordinate.
    pub scale: Scale,
    /// Where nothing happens (main numbers) or the usual one (the others).
    pub mean: f64,
    /// How far from that it usually is: the standard deviation of the prior.
    pub std: f64,
    /// What it can be at all.
    pub bounds: (f64, f64),
    /// A step over which its influence is about linear and well above rounding.
    pub step: f64,
    /// Does the effect vanish with it (at `mean`)? Others are its shape: without the first ones they
    /// mean nothing.
    pub is_main: bool,
}

/// In place of a unit: the channel's own. Sizes that go with it are in units of
/// [`Channel::usual_error`]; [`Kind::spec`] and [`Kind::surroundings`] put both in.
pub const OF_CHANNEL: &str = "the channel's";

impl Spec {
    /// When an effect begins, s; at −1 it is there from the start.
    pub const AT_S: Self = Self {
        name: "at_s",
        unit: "s",
        scale: Scale::Linear,
        mean: -1.0,
        std: 60.0,
        bounds: (-1.0, 1e6),
        step: 1.0,
        is_main: false,
    };

    /// The coordinate of a value.
    pub fn coordinate(&self, value: f64) -> f64 {
        self.scale.coordinate(value)
    }

    /// The value at a coordinate.
    pub fn value(&self, coordinate: f64) -> f64 {
        self.scale.value(coordinate)
    }

    /// The smallest and the largest value.
    pub fn range(&self) -> (f64, f64) {
        let (low, high) = (self.value(self.bounds.0), self.value(self.bounds.1));
        (low.min(high), low.max(high))
    }
}

/// What varies while one drives, and nobody measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Unit of the course.
    pub unit: &'static str,
    /// Key of its rms (or peak) in the JSON.
    pub rms_name: &'static str,
    /// Typical size, in the unit.
    pub size: f64,
    /// Typical duration of a change, s: the correlation length.
    pub length_s: f64,
    /// Only values of this sign can be (`+1`), or both (`0`).
    pub sign: f64,
}

/// A kind of effect.
#[derive(Debug)]
pub struct Kind {
    /// Its name in `[[effect]] kind = …` and in the JSON.
    pub name: &'static str,
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
    /// What it can be of; empty where it is of the car.
    pub channels: &'static [Channel],
    /// Its numbers.
    pub parameters: &'static [Spec],
    /// Its course in time, where it has one.
    pub course: Option<Surroundings>,
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
    pub fn surroundings(&self, channel: Option<Channel>) -> Option<Surroundings> {
        let mut course = self.course?;
        if let (OF_CHANNEL, Some((unit, size))) = (course.unit, channel.and_then(Channel::usual_error)) {
            course.unit = unit;
            course.size *= size;
        }
        Some(course)
    }
}
