//! A finding of the answer: what is missing, where, with which numbers.

use std::collections::BTreeMap;

use physics::Quantity;
use physics::model::effect::law::Law;
use physics::model::effect::{Channel, Kind, Series};
use serde::Serialize;

use super::super::chain::ZeroCourse;
use super::{ByChannel, SecondPass};

/// A number with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// In its unit.
    pub value: f64,
    /// Of the same unit.
    pub std: f64,
}

/// Where simulation and recording differ.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Where {
    /// The equation, or the sensor, in words.
    pub equation: String,
    /// Quantities in which it shows, the clearest one first.
    pub channels: Vec<String>,
    /// In which driving, in words.
    pub regimes: Vec<String>,
    /// When, s from the recording's start.
    pub intervals: Vec<[f64; 2]>,
    /// The same in UTC, where the recording's stamps are dates.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub intervals_utc: Vec<[String; 2]>,
    /// The recording that the intervals are of.
    pub recording: String,
}

/// What sort of a finding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Nature {
    /// Physics that not every car has.
    #[default]
    Unusual,
    /// How something is measured.
    Measurement,
    /// Physics that no effect of the library is.
    Law,
    /// Physics that every car has, and a plain model leaves out.
    Ordinary,
}

impl Nature {
    /// Of an effect.
    pub fn of(kind: &Kind) -> Self {
        if kind.is_law() {
            Self::Law
        } else if kind.is_of_measurement() {
            Self::Measurement
        } else if kind.search.every_car_has {
            Self::Ordinary
        } else {
            Self::Unusual
        }
    }

    /// The same of a channel, where its numbers are these: little of some effects is nothing unusual.
    pub fn of_size(kind: &Kind, channel: Option<Channel>, numbers: &BTreeMap<String, Estimate>) -> Self {
        let main = kind.parameters.iter().filter(|spec| spec.is_main);
        let mut values = main
            .filter_map(|spec| numbers.get(spec.name))
            .map(|number| (number.value, number.std))
            .peekable();
        let is_told = values.peek().is_some();
        if is_told && kind.usual(channel).is_some_and(|usual| usual.holds(values)) {
            Self::Ordinary
        } else {
            Self::of(kind)
        }
    }
}

/// Something that is missing in the plain model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Finding {
    /// Its name in the library.
    pub effect: String,
    /// The quantity it is of.
    pub channel: Option<String>,
    /// What sort of a finding it is.
    pub kind: Nature,
    /// By how much held-out squared errors fall with it, as a share of the plain model's, by channel; where the ordinary
    /// car decides.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub explained_share: ByChannel,
    /// How probable it is among all that was tried.
    pub probability: f64,
    /// What this recording cannot tell it from.
    pub indistinguishable_from: Vec<String>,
    /// The manoeuvre that would.
    pub to_tell_apart: String,
    /// Its numbers.
    pub parameters: BTreeMap<String, Estimate>,
    /// When it began, in UTC, where `at_s` is among its numbers and the recording's stamps are dates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_utc: Option<String>,
    /// How it varied, if it did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub series: Option<CourseEstimate>,
    /// Where it shows.
    #[serde(rename = "where")]
    pub place: Where,
    /// In one sentence.
    pub about: String,
    /// Its equation.
    pub equation: String,
    /// Twice the logarithm of the odds for it.
    pub evidence: f64,
    /// Of a number of the car that has changed: what the references have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_value: Option<Estimate>,
    /// Beside somebody's simulation: the same again with all that was found in both runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_pass: Option<SecondPass>,
    /// Of a law: what it says.
    #[serde(flatten)]
    pub law: Option<FoundLaw>,
}

/// An effect with the quantity it is of, as the rankings and `--verify` name it.
pub fn full_name(effect: &str, channel: Option<&str>) -> String {
    match channel {
        Some(channel) => format!("{effect}:{channel}"),
        None => effect.to_owned(),
    }
}

/// What a law says, with its numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FoundLaw {
    /// What changes.
    pub place: String,
    /// By how much: numbers times what it follows.
    pub expression: String,
    /// The same one by one.
    pub terms: Vec<Term>,
    /// What in a car could make it, in words, the likelier first.
    pub mechanisms: Vec<&'static str>,
}

/// A coefficient and what it is of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Term {
    /// What the car or the driver does.
    pub feature: String,
    /// The number before it.
    pub coefficient: Estimate,
    /// Its unit.
    pub unit: String,
}

impl FoundLaw {
    /// Of one term.
    pub fn new(law: Law, coefficient: Estimate) -> Self {
        let feature = law.feature.name().to_owned();
        Self {
            place: law.place.name().into(),
            expression: format!("{:.3e}*{feature}", coefficient.value),
            terms: vec![Term { feature, coefficient, unit: law.usual().0.into() }],
            mechanisms: law.mechanisms(),
        }
    }

    /// Takes another number of its only term.
    pub fn take(&mut self, coefficient: Estimate) {
        if let [term] = self.terms.as_mut_slice() {
            term.coefficient = coefficient;
            self.expression = format!("{:.3e}*{}", coefficient.value, term.feature);
        }
    }
}

impl Finding {
    /// What is the same for all findings of a kind.
    pub fn of(kind: &Kind, channel: Option<Channel>) -> Self {
        let equation = match channel {
            Some(channel) => format!("{}: {channel}", kind.place),
            None => kind.place.into(),
        };
        Self {
            effect: kind.name.into(),
            channel: channel.map(|channel| channel.to_string()),
            kind: Nature::of(kind),
            to_tell_apart: kind.to_tell_apart.into(),
            place: Where { equation, ..Where::default() },
            about: kind.about.into(),
            equation: kind.equation.into(),
            ..Self::default()
        }
    }
}

/// How something varied, with what is known of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CourseEstimate {
    /// Times, s.
    pub t: Vec<f64>,
    /// Values.
    pub value: Vec<f64>,
    /// Standard deviations.
    pub std: Vec<f64>,
    /// Their unit.
    pub unit: String,
}

impl CourseEstimate {
    /// Of a zero, in a recording that begins then, s.
    pub fn of_zero(zero: &ZeroCourse, begins_s: f64) -> Self {
        let Series { t, value } = zero.points();
        let since: Vec<f64> = t.iter().map(|t| t - begins_s).collect();
        let std = vec![zero.std; t.len()];
        Self { t: since, value: value.clone(), std, unit: Quantity::YawRate.unit().into() }
    }
}

/// A candidate and its score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranked {
    /// Its name.
    pub effect: String,
    /// The quantity it is of.
    pub channel: Option<String>,
    /// Twice the logarithm of the odds for it, alone.
    pub score: f64,
    /// Was it fitted together with everything else, or judged to first order only?
    pub refitted: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::Quantity;
    use physics::model::effect::named;

    #[test]
    fn a_wheel_that_is_hardly_smaller_is_nothing_unusual() {
        let of = |kind: &str, number: &str, value: f64| {
            let numbers = [(number.to_owned(), Estimate { value, std: 1e-4 })];
            Nature::of_size(named(kind).unwrap(), None, &numbers.into())
        };
        assert_eq!(of("tire_radius", "relative_difference_rl", -0.0007), Nature::Ordinary);
        assert_eq!(of("tire_radius", "relative_difference_rl", -0.007), Nature::Unusual);
        assert_eq!(of("sensor_scale", "relative_error", 0.001), Nature::Measurement);
        assert_eq!(of("load_transfer", "cg_height_m", 0.5), Nature::Ordinary);
        assert_eq!(Nature::of_size(named("tire_radius").unwrap(), None, &BTreeMap::new()), Nature::Unusual);
    }

    /// A body that dives and squats tilts the accelerometer: along the car, and to one side only.
    #[test]
    fn an_accelerometer_that_pitches_is_nothing_unusual() {
        let surely = |quantity, value: f64, std: f64| {
            let numbers = [("relative_error".to_owned(), Estimate { value, std })];
            Nature::of_size(named("sensor_scale").unwrap(), Some(Channel::One(quantity)), &numbers.into())
        };
        let of = |quantity, value| surely(quantity, value, 1e-4);
        // What may well be within.
        assert_eq!(surely(Quantity::LongitudinalAcceleration, 0.08, 1e-3), Nature::Ordinary);
        assert_eq!(of(Quantity::LongitudinalAcceleration, 0.04), Nature::Ordinary);
        assert_eq!(of(Quantity::LongitudinalAcceleration, -0.04), Nature::Measurement);
        assert_eq!(of(Quantity::LongitudinalAcceleration, 0.08), Nature::Measurement);
        assert_eq!(of(Quantity::LateralAcceleration, 0.04), Nature::Measurement);
    }
}
