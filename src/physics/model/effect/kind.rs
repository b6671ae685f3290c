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
    /// Its name in a sentence.
    pub words: &'static str,
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
    /// The share of it by which another model of the same car may differ: more than noise, where a drive tells it
    /// well. See [`Spec::MODEL_ERROR`].
    pub model_error: f64,
    /// Does the effect vanish with it (at `mean`)? Others are its shape: without the first ones they
    /// mean nothing.
    pub is_main: bool,
}

/// In place of a unit: the channel's own. Sizes that go with it are in units of
/// [`Channel::usual_error`]; [`Kind::spec`] and [`Kind::disturbance`] put both in.
pub const OF_CHANNEL: &str = "the channel's";

impl Spec {
    /// [`Spec::model_error`] of most: so far off come the numbers of drives that other equations simulate (the
    /// tests with concealed effects).
    pub const MODEL_ERROR: f64 = 0.02;

    /// When an effect begins, s; at −1 it is there from the start.
    pub const AT_S: Self = Self {
        name: "at_s",
        words: "from the time",
        unit: "s",
        scale: Scale::Linear,
        mean: -1.0,
        std: 60.0,
        bounds: (-1.0, 1e6),
        step: 1.0,
        model_error: 0.0,
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
pub struct Disturbance {
    /// Unit of the course.
    pub unit: &'static str,
    /// Key of its rms (or peak) in the JSON.
    pub rms_name: &'static str,
    /// The name of that number in a sentence.
    pub words: &'static str,
    /// Typical size, in the unit.
    pub size: f64,
    /// Typical duration of a change, s: the correlation length.
    pub length_s: f64,
    /// Only values of this sign can be (`+1`), or both (`0`). Where it is +1 the course is the share of the
    /// road that is another one, and lies in patches.
    pub sign: f64,
    /// Shortest correlation length that a search may give it, s.
    pub shortest_s: f64,
    /// Its peak stands for it in the answer, not its rms: it acts now and then.
    pub is_told_by_its_peak: bool,
    /// Its mean cannot be told from the offset of the sensor, which is an ordinary number.
    pub has_its_mean_in_an_offset: bool,
    /// Of a patch: what the kind's numbers are set to (in their coordinates) while its share is estimated.
    /// One candidate for each: somewhat different, and much.
    pub settings: &'static [&'static [f64]],
    /// Of a patch: wheels may slide there. Where they are seen to slide, a patch is tried.
    pub is_slippery: bool,
}

impl Disturbance {
    /// What most have in common; name, size and length are each one's own.
    pub const USUAL: Self = Self {
        unit: "1",
        rms_name: "",
        words: "",
        size: 1.0,
        length_s: 1.0,
        sign: 0.0,
        shortest_s: 0.2,
        is_told_by_its_peak: false,
        has_its_mean_in_an_offset: false,
        settings: &[],
        is_slippery: false,
    };
}

/// How the influence of an effect grows with its main number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Growth {
    /// In proportion: a small step shows all of it.
    Proportional,
    /// With curvature, a threshold or a limit: large steps show what a small one does not.
    Nonlinear,
    /// With the square: to first order it shows hardly at all, however large it is.
    Quadratic,
}

/// What the plain model and the recording must have for an effect to be told from the ordinary numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing in particular.
    Nothing,
    /// Tires without a limit of their own.
    LinearTire,
    /// Drive and brake torques.
    KnownTorque,
}

/// How an explanation searches for an effect.
#[derive(Clone, Copy, Debug)]
pub struct SearchHints {
    /// Channels of which it is not searched: an ordinary number or another effect does the same.
    pub not_of: &'static [Quantity],
    /// What there must be to tell it.
    pub needs: Needs,
    /// How its influence grows.
    pub growth: Growth,
    /// Each of its numbers is a candidate without the others: one wheel has another radius, not four.
    pub each_number_alone: bool,
    /// Of a kind with an onset: it is searched from the start of the recording, too. Others that are there from the
    /// start are ordinary numbers.
    pub from_start: bool,
    /// Of a torque's channel: the smallest main number that is worth a finding.
    pub least_of_torque: Option<f64>,
}

impl SearchHints {
    /// The search for most effects.
    pub const USUAL: Self = Self {
        not_of: &[],
        needs: Needs::Nothing,
        growth: Growth::Nonlinear,
        each_number_alone: false,
        from_start: false,
        least_of_torque: None,
    };
}

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

    /// Is it an error of the measurement, not physics of the car?
    pub fn is_of_measurement(&self) -> bool {
        !self.channels.is_empty()
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
