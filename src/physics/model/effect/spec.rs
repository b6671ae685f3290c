//! The numbers of an effect, and what is known of each before any recording.

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
/// [`Channel::usual_error`](super::Channel::usual_error); [`Kind::spec`](super::Kind::spec) and
/// [`Kind::disturbance`](super::Kind::disturbance) put both in.
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

    /// A main number that is a ratio and nothing at zero. How large it is usually is the effect's own.
    pub const fn ratio(name: &'static str, words: &'static str) -> Self {
        Self {
            name,
            words,
            unit: "1",
            scale: Scale::Linear,
            mean: 0.0,
            std: 1.0,
            bounds: (-1.0, 1.0),
            step: 0.1,
            model_error: Self::MODEL_ERROR,
            is_main: true,
        }
    }

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
