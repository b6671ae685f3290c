//! The `[[effect]]` tables: an effect with its numbers, read, checked and written.
//!
//! ```
//! use physics::model::effect::EffectConfig;
//! #[derive(serde::Deserialize)]
//! struct File {
//!     effect: Vec<EffectConfig>,
//! }
//! # fn main() -> Result<(), toml::de::Error> {
//! let text = "
//!     [[effect]]
//!     kind = \"load_transfer\"
//!     cg_height_m = { value = 0.55, std = 0.05 }
//!
//!     [[effect]]
//!     kind = \"sensor_delay\"
//!     channel = \"yaw_rate\"
//!     delay_s = 0.04
//! ";
//! let file: File = toml::from_str(text)?;
//! let effects = EffectConfig::effects(&file.effect);
//! assert_eq!(effects.len(), 2);
//! let again: File = toml::from_str(&EffectConfig::write_all(&file.effect))?;
//! assert_eq!(again.effect, file.effect);
//! # Ok(())
//! # }
//! ```

use thiserror::Error;

use super::{Channel, Course, Effect, KINDS, Kind, Scale, Setting, Spec};
use crate::model::Uncertain;

/// An effect with its numbers: what an `[[effect]]` table says. All numbers are within their bounds.
#[derive(Clone, Debug)]
pub struct EffectConfig {
    kind: &'static Kind,
    channel: Option<Channel>,
    numbers: Vec<Uncertain>,
    course: Course,
}

/// An effect that cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("effect {kind}: {key}: {reason}")]
pub struct EffectError {
    /// Its kind, with the channel if it has one.
    pub kind: String,
    /// The key of its table.
    pub key: String,
    /// What is wrong, and what would be accepted.
    pub reason: String,
}

impl PartialEq for EffectConfig {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.kind, other.kind)
            && self.channel == other.channel
            && self.numbers == other.numbers
            && self.course == other.course
    }
}

impl EffectConfig {
    /// From its parts; `numbers` follow [`Kind::parameters`], values and standard deviations in the
    /// unit of the parameter.
    ///
    /// # Errors
    /// The first part that cannot be, by its key in the table.
    pub fn new(
        kind: &'static Kind,
        channel: Option<Channel>,
        numbers: Vec<Uncertain>,
        course: Course,
    ) -> Result<Self, EffectError> {
        let config = Self { kind, channel, numbers, course };
        match config.problem() {
            None => Ok(config),
            Some((key, reason)) => Err(EffectError { kind: config.title(), key, reason }),
        }
    }

    /// What it is.
    pub fn kind(&self) -> &'static Kind {
        self.kind
    }

    /// What it is of.
    pub fn channel(&self) -> Option<Channel> {
        self.channel
    }

    /// A number for each of [`Kind::parameters`], with the standard deviation of its prior: zero where it
    /// is known; what is usual where the table does not give the number.
    pub fn numbers(&self) -> &[Uncertain] {
        &self.numbers
    }

    /// Its course in time; [`Course::None`] where the kind has none.
    pub fn course(&self) -> &Course {
        &self.course
    }

    /// What is known of its parameters, for its channel.
    pub fn specs(&self) -> impl Iterator<Item = Spec> + '_ {
        (0..self.kind.parameters.len()).filter_map(|place| self.kind.spec(place, self.channel))
    }

    /// Its numbers and their standard deviations in the coordinates that are searched ([`Spec::scale`]).
    pub fn coordinates(&self) -> Vec<Uncertain> {
        let coordinate = |(spec, number): (Spec, &Uncertain)| {
            let value = spec.coordinate(number.value);
            let std = if number.std == 0.0 { 0.0 } else { number.std / spec.scale.slope(value).abs() };
            Uncertain { value, std }
        };
        self.specs().zip(&self.numbers).map(coordinate).collect()
    }

    /// Makes it.
    pub fn effect(&self) -> Box<dyn Effect> {
        let values: Vec<f64> = self.numbers.iter().map(|number| number.value).collect();
        self.kind.effect(&Setting { values: &values, channel: self.channel, course: &self.course })
    }

    /// Some in the order in which they act: that of [`KINDS`], among the same kind that of the file.
    pub fn in_order(configs: &[Self]) -> Vec<&Self> {
        // Laws come last.
        let place = |config: &&Self| {
            KINDS.iter().position(|kind| std::ptr::eq(*kind, config.kind)).unwrap_or(KINDS.len())
        };
        let mut configs: Vec<_> = configs.iter().collect();
        configs.sort_by_key(place);
        configs
    }

    /// Makes all of them, in the order in which they act.
    pub fn effects(configs: &[Self]) -> Vec<Box<dyn Effect>> {
        Self::in_order(configs).into_iter().map(Self::effect).collect()
    }

    /// What is wrong with several together: where, its key and the reason. Only what begins at a time or
    /// has a course can be there twice; others would be one effect with the sum of the numbers.
    pub fn problem_among(configs: &[Self]) -> Option<(usize, &'static str, String)> {
        let can_repeat = |kind: &Kind| kind.course.is_some() || kind.place_of("at_s").is_some();
        configs.iter().enumerate().find_map(|(place, config)| {
            let same =
                |other: &&Self| std::ptr::eq(other.kind, config.kind) && other.channel == config.channel;
            let first = configs[..place].iter().position(|other| same(&other))?;
            if can_repeat(config.kind) {
                return None;
            }
            let title = config.title();
            Some((
                place,
                "kind",
                format!("{title} is there already, as effect[{first}]; make one of the two"),
            ))
        })
    }

    /// Its name, with the channel if it has one.
    pub fn title(&self) -> String {
        let name = self.kind.name;
        self.channel.map_or_else(|| name.to_owned(), |channel| format!("{name} of {channel}"))
    }

    /// The keys that a kind's table takes.
    pub fn keys(kind: &Kind) -> impl Iterator<Item = &'static str> + use<> {
        let of_channel = (!kind.channels.is_empty()).then_some("channel");
        let of_law: &[&str] = if kind.is_law() { &["place", "expression"] } else { &[] };
        let of_course = if kind.course.is_some() { COURSE_KEYS } else { &[] };
        let parameters = kind.parameters.iter().map(|spec| spec.name);
        ["kind"]
            .into_iter()
            .chain(of_channel)
            .chain(of_law.iter().copied())
            .chain(parameters)
            .chain(of_course.iter().copied())
    }

    fn problem(&self) -> Option<(String, String)> {
        self.channel_problem().or_else(|| self.number_problem()).or_else(|| self.course_problem())
    }

    fn channel_problem(&self) -> Option<(String, String)> {
        let allowed = self.kind.channels;
        if self.kind.is_law() {
            let is_law = matches!(self.channel, Some(Channel::Law(_)));
            return (!is_law).then(|| ("place".into(), "is missing: what the law changes".into()));
        }
        let reason = match self.channel {
            None if allowed.is_empty() => return None,
            Some(channel) if allowed.contains(&channel) => return None,
            Some(channel) if allowed.is_empty() => {
                format!("`{channel}`: this kind is of the car and takes none")
            }
            Some(channel) => format!("`{channel}` is not possible; use one of {}", listed(allowed)),
            None => format!("is missing; use one of {}", listed(allowed)),
        };
        Some(("channel".into(), reason))
    }

    fn number_problem(&self) -> Option<(String, String)> {
        let count = self.kind.parameters.len();
        if self.numbers.len() != count {
            return Some(("kind".into(), format!("needs {count} numbers, not {}", self.numbers.len())));
        }
        self.specs().zip(&self.numbers).find_map(|(spec, Uncertain { value, std })| {
            let (low, high) = spec.range();
            let reason = if !value.is_finite() {
                format!("{value} is no finite number")
            } else if !(low..=high).contains(value) {
                format!("{value} cannot be; {}", range_text(low, high, spec.unit))
            } else if !(std.is_finite() && *std >= 0.0) {
                format!("std = {std} cannot be; it must be zero or positive")
            } else {
                return None;
            };
            Some((spec.name.to_owned(), reason))
        })
    }

    fn course_problem(&self) -> Option<(String, String)> {
        let Some(known) = self.kind.disturbance(self.channel) else {
            return (self.course != Course::None)
                .then(|| ("value".into(), "this kind does not vary and takes no course".into()));
        };
        let (low, high) = known.range();
        let wrong = |value: f64| {
            (!(low..=high).contains(&value))
                .then(|| format!("{value} cannot be; {}", range_text(low, high, known.unit)))
        };
        let found = match &self.course {
            Course::Live(_) => ("value", Some("is known to a running filter only".into())),
            Course::None => (
                "value",
                Some("is missing; give value = …, with intervals = [[from, to], …] if it is not always there, or \
                      series = { t = […], value = […] }".into()),
            ),
            Course::Constant(value) => ("value", wrong(*value)),
            Course::Stretches { intervals, value } => match wrong(*value) {
                Some(reason) => ("value", Some(reason)),
                None => ("intervals", interval_problem(intervals)),
            },
            Course::Series(series) => {
                let times = || time_problem(&series.t, series.value.len());
                ("series", times().or_else(|| series.value.iter().find_map(|value| wrong(*value))))
            }
        };
        found.1.map(|reason| (found.0.to_owned(), reason))
    }
}

/// Keys of a course.
pub(super) const COURSE_KEYS: &[&str] = &["value", "intervals", "series"];

/// The number where the table has none: the usual one, as uncertain as it usually is. None where it is the
/// effect itself.
pub(super) fn usual(spec: &Spec) -> Option<Uncertain> {
    let value = spec.value(spec.mean);
    let std = spec.std * spec.scale.slope(spec.mean).abs();
    (value.is_finite() && std.is_finite()).then_some(Uncertain { value, std })
}

/// The number at which a main parameter does nothing, known.
pub(super) fn nothing(spec: &Spec) -> Option<Uncertain> {
    (spec.scale != Scale::Inverse).then(|| Uncertain::known(spec.value(spec.mean)))
}

fn interval_problem(intervals: &[[f64; 2]]) -> Option<String> {
    if intervals.is_empty() {
        return Some("is empty; give one [from, to] or more, in s".into());
    }
    let mut end = f64::NEG_INFINITY;
    for [from, to] in intervals {
        if !(from.is_finite() && to.is_finite() && from < to) {
            return Some(format!("[{from}, {to}] is no stretch of time; to must be later than from, in s"));
        }
        if *from < end {
            return Some(format!("[{from}, {to}] begins before the one ahead of it has ended at {end} s"));
        }
        end = *to;
    }
    None
}

fn time_problem(t: &[f64], values: usize) -> Option<String> {
    if t.len() != values {
        return Some(format!("has {} times and {values} values; each value needs its time", t.len()));
    }
    if t.len() < 2 {
        return Some("needs two points or more".into());
    }
    if let Some(time) = t.iter().find(|time| !time.is_finite()) {
        return Some(format!("t = {time} is no time in s"));
    }
    let falls = t.windows(2).find(|pair| pair[1] < pair[0])?;
    Some(format!("t = {} comes after {}; times must not fall", falls[1], falls[0]))
}

fn range_text(low: f64, high: f64, unit: &str) -> String {
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("it must be {} to {}{unit}", short(low), short(high)),
        (true, false) => format!("it must be {}{unit} or more", short(low)),
        _ => format!("it must be {}{unit} or less", short(high)),
    }
}

/// A bound in four digits: those of friction are one over a round number.
fn short(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// Names in a row.
pub(super) fn listed<T: std::fmt::Display>(names: impl IntoIterator<Item = T>) -> String {
    names.into_iter().map(|name| name.to_string()).collect::<Vec<_>>().join(", ")
}

/// Names of the columns that effects add to a table of truth, in the order in which they act: the course of
/// what varies, then the own states.
pub fn column_names(configs: &[EffectConfig]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let mut add = |name: String| {
        let repeated = |count: usize| if count == 1 { name.clone() } else { format!("{name}_{count}") };
        let free = (1..).map(repeated).find(|name| !names.contains(name));
        names.extend(free);
    };
    for config in EffectConfig::in_order(configs) {
        let name = match config.channel() {
            Some(channel) => format!("{}_{}", config.kind().name, channel.to_string().replace('/', "_")),
            None => config.kind().name.to_owned(),
        };
        if config.kind().course.is_some() {
            add(name.clone());
        }
        for state in config.effect().state_names() {
            add(format!("{name}_{state}"));
        }
    }
    names
}
