//! [`EffectConfig`] from and to TOML (and whatever else serde knows).

use std::fmt::{self, Write as _};

use serde::de::{Error as _, IgnoredAny, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::config::{COURSE_KEYS, EffectConfig, EffectError, listed, nothing, usual};
use super::{Channel, Course, KINDS, Kind, Series, law, named};
use crate::model::Uncertain;

/// Numbers in one line of a series.
const IN_ONE_LINE: usize = 10;

impl<'de> Deserialize<'de> for EffectConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Reader)
    }
}

/// A table as it is written.
#[derive(Default)]
struct Table {
    kind: Option<&'static Kind>,
    channel: Option<Channel>,
    /// Of a law.
    place: Option<String>,
    /// … and with what it changes.
    expression: Option<String>,
    numbers: Vec<(String, Uncertain)>,
    unknown: Vec<String>,
    value: Option<f64>,
    intervals: Option<Vec<Vec<f64>>>,
    series: Option<Series>,
}

struct Reader;

impl<'de> Visitor<'de> for Reader {
    type Value = EffectConfig;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table with kind = … and the effect's parameters")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<EffectConfig, A::Error> {
        let mut table = Table::default();
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "kind" => table.kind = Some(map.next_value::<KindName>()?.0),
                "channel" => table.channel = Some(map.next_value::<ChannelName>()?.0),
                "place" => table.place = Some(map.next_value()?),
                "expression" => table.expression = Some(map.next_value()?),
                "value" => table.value = Some(map.next_value()?),
                "intervals" => table.intervals = Some(map.next_value()?),
                "series" => table.series = Some(map.next_value()?),
                // Its value may be none that a number could be read from; what is wrong is the key.
                unknown
                    if !KINDS.iter().chain([&&law::KIND]).any(|kind| kind.place_of(unknown).is_some()) =>
                {
                    map.next_value::<IgnoredAny>()?;
                    table.unknown.push(key);
                }
                _ => {
                    let number = map.next_value()?;
                    table.numbers.push((key, number));
                }
            }
        }
        table.finish().map_err(A::Error::custom)
    }
}

fn unknown_key(kind: &'static Kind, key: &str) -> Option<EffectError> {
    let known = EffectConfig::keys(kind).any(|known| known == key);
    (!known).then(|| {
        let keys = listed(EffectConfig::keys(kind));
        fail(kind, key, format!("there is no such key; the kind takes {keys}"))
    })
}

fn fail(kind: &Kind, key: &str, reason: String) -> EffectError {
    EffectError { kind: kind.name.to_owned(), key: key.to_owned(), reason }
}

struct KindName(&'static Kind);

impl<'de> Deserialize<'de> for KindName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        named(&name).map(Self).ok_or_else(|| {
            let names = listed(KINDS.iter().map(|kind| kind.name));
            D::Error::custom(format!("effect kind `{name}`: there is no such kind; use one of {names}"))
        })
    }
}

struct ChannelName(Channel);

impl<'de> Deserialize<'de> for ChannelName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse()
            .map(Self)
            .map_err(|reason| D::Error::custom(format!("effect channel `{name}`: {reason}")))
    }
}

impl Table {
    fn finish(self) -> Result<EffectConfig, String> {
        let Some(kind) = self.kind else {
            let names = listed(KINDS.iter().map(|kind| kind.name));
            return Err(format!("effect: kind is missing; use one of {names}"));
        };
        self.of(kind).map_err(|error| error.to_string())
    }

    fn of(self, kind: &'static Kind) -> Result<EffectConfig, EffectError> {
        let given = [self.value.is_some(), self.intervals.is_some(), self.series.is_some()];
        let of_course = COURSE_KEYS.iter().zip(given).filter(|(_, given)| *given).map(|(key, _)| *key);
        let numbers = self.numbers.iter().map(|(key, _)| key);
        let of_law = [("place", self.place.is_some()), ("expression", self.expression.is_some())];
        let of_law = of_law.into_iter().filter(|(_, given)| *given).map(|(key, _)| key);
        let written = self.unknown.iter().chain(numbers).map(String::as_str).chain(of_course).chain(of_law);
        if let Some(error) = written.into_iter().find_map(|key| unknown_key(kind, key)) {
            return Err(error);
        }
        let channel = self.of_what(kind)?;
        let numbers = self.numbers(kind, channel)?;
        let pair = |interval: &Vec<f64>| {
            let reason = || format!("{interval:?} is no stretch of time; write [from, to], in s");
            interval.as_slice().try_into().map_err(|_| fail(kind, "intervals", reason()))
        };
        let intervals: Option<Vec<[f64; 2]>> =
            self.intervals.as_ref().map(|all| all.iter().map(pair).collect()).transpose()?;
        let is_share = kind.course.is_some_and(|course| course.sign > 0.0 && course.unit == "1");
        let course = match (self.value, intervals, self.series) {
            (None, None, None) => Course::None,
            (Some(value), None, None) => Course::Constant(value),
            (Some(value), Some(intervals), None) => Course::Stretches { intervals, value },
            // A road wholly of the other surface.
            (None, Some(intervals), None) if is_share => Course::Stretches { intervals, value: 1.0 },
            (None, Some(_), None) => {
                return Err(fail(kind, "value", "is missing: what it is within the intervals".into()));
            }
            (None, None, Some(series)) => Course::Series(series),
            (_, _, Some(_)) => {
                let reason = "says all there is to say; remove value and intervals beside it".into();
                return Err(fail(kind, "series", reason));
            }
        };
        EffectConfig::new(kind, channel, numbers, course)
    }

    /// Its channel; of a law what it says.
    fn of_what(&self, kind: &'static Kind) -> Result<Option<Channel>, EffectError> {
        if !kind.is_law() {
            return Ok(self.channel);
        }
        let given = |key: &str, value: &Option<String>| {
            value.clone().ok_or_else(|| fail(kind, key, "is missing".into()))
        };
        let (place, expression) = (given("place", &self.place)?, given("expression", &self.expression)?);
        let law = law::Law::parse(&place, &expression).map_err(|(key, reason)| fail(kind, key, reason))?;
        Ok(Some(Channel::Law(law)))
    }

    /// A number for each parameter: the given one, or what is usual.
    fn numbers(&self, kind: &'static Kind, channel: Option<Channel>) -> Result<Vec<Uncertain>, EffectError> {
        let given = |name: &str| self.numbers.iter().find(|(key, _)| key == name).map(|(_, number)| *number);
        let any_main = kind.parameters.iter().any(|spec| spec.is_main && given(spec.name).is_some());
        let number = |place: usize| {
            let spec = kind.spec(place, channel).unwrap_or(kind.parameters[place]);
            let other = match (spec.is_main, any_main) {
                (false, _) => usual(&spec),
                (true, true) => nothing(&spec),
                (true, false) => None,
            };
            let missing = || fail(kind, spec.name, "is missing".into());
            given(spec.name).or(other).ok_or_else(missing)
        };
        (0..kind.parameters.len()).map(number).collect()
    }
}

impl Serialize for EffectConfig {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("kind", self.kind().name)?;
        match self.channel() {
            Some(Channel::Law(law)) => {
                map.serialize_entry("place", law.place.name())?;
                map.serialize_entry("expression", &law.expression())?;
            }
            Some(channel) => map.serialize_entry("channel", &channel.to_string())?,
            None => {}
        }
        for (spec, number) in self.kind().parameters.iter().zip(self.numbers()) {
            map.serialize_entry(spec.name, number)?;
        }
        match self.course() {
            Course::None | Course::Live(_) => {}
            Course::Constant(value) => map.serialize_entry("value", value)?,
            Course::Stretches { intervals, value } => {
                map.serialize_entry("value", value)?;
                map.serialize_entry("intervals", intervals)?;
            }
            Course::Series(series) => map.serialize_entry("series", series)?,
        }
        map.end()
    }
}

impl EffectConfig {
    /// Its table as TOML, heading included. Reading it gives the same to the last bit.
    pub fn to_toml(&self) -> String {
        let mut text = format!("[[effect]]\nkind = \"{}\"\n", self.kind().name);
        match self.channel() {
            Some(Channel::Law(law)) => {
                line(&mut text, "place", format_args!("\"{}\"", law.place.name()));
                line(&mut text, "expression", format_args!("\"{}\"", law.expression()));
            }
            Some(channel) => line(&mut text, "channel", format_args!("\"{channel}\"")),
            None => {}
        }
        for (spec, Uncertain { value, std }) in self.kind().parameters.iter().zip(self.numbers()) {
            if *std == 0.0 {
                line(&mut text, spec.name, format_args!("{value:?}"));
            } else {
                line(&mut text, spec.name, format_args!("{{ value = {value:?}, std = {std:?} }}"));
            }
        }
        match self.course() {
            Course::None | Course::Live(_) => {}
            Course::Constant(value) => line(&mut text, "value", format_args!("{value:?}")),
            Course::Stretches { intervals, value } => {
                line(&mut text, "value", format_args!("{value:?}"));
                line(&mut text, "intervals", format_args!("{intervals:?}"));
            }
            Course::Series(series) => {
                line(&mut text, "series.t", format_args!("{}", array(&series.t)));
                line(&mut text, "series.value", format_args!("{}", array(&series.value)));
            }
        }
        text
    }

    /// The tables of several, with an empty line between them.
    pub fn write_all(configs: &[Self]) -> String {
        configs.iter().map(Self::to_toml).collect::<Vec<_>>().join("\n")
    }
}

fn line(text: &mut String, key: &str, value: fmt::Arguments<'_>) {
    // Writing to a string does not fail.
    let _ = writeln!(text, "{key} = {value}");
}

/// Numbers as a TOML array, in lines that one can read.
fn array(numbers: &[f64]) -> String {
    if numbers.len() <= IN_ONE_LINE {
        return format!("{numbers:?}");
    }
    let row = |row: &[f64]| format!("    {},\n", listed(row.iter().map(|number| format!("{number:?}"))));
    format!("[\n{}]", numbers.chunks(IN_ONE_LINE).map(row).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<EffectConfig, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_not_given_is_what_is_usual() {
        let config = read("kind = \"load_transfer\"\ncg_height_m = 1").unwrap();
        assert_eq!(config.numbers()[0], Uncertain::known(1.0));
        assert_eq!(config.numbers()[1], Uncertain { value: 0.45, std: 0.2 });
        let radii = read("kind = \"tire_radius\"\nrelative_difference_rl = 0.01").unwrap();
        let values: Vec<_> = radii.numbers().iter().map(|number| number.value).collect();
        assert_eq!(values, [0.0, 0.0, 0.01, 0.0]);
        let patch =
            read("kind = \"friction_change\"\nfriction = 0.4\nintervals = [[3, 5.5], [7, 8]]").unwrap();
        let expected = Course::Stretches { intervals: vec![[3.0, 5.5], [7.0, 8.0]], value: 1.0 };
        assert_eq!(patch.course(), &expected);
    }

    #[test]
    fn numbers_go_to_coordinates_with_their_std() {
        let text = "kind = \"tire_saturation\"\nfriction = { value = 0.5, std = 0.1 }";
        let saturation = read(text).unwrap().coordinates()[0];
        assert_eq!(saturation.value, 2.0);
        assert!((saturation.std - 0.4).abs() < 1e-12, "{}", saturation.std);
        let surface = read("kind = \"surface_stiffness\"\nstiffness_factor = 0.5\nvalue = 1").unwrap();
        assert_eq!(surface.coordinates()[0], Uncertain::known(0.5f64.ln()));
    }

    /// Every kind, with uncertain numbers and every sort of course, comes back as it was.
    #[test]
    fn what_is_written_is_read_again() {
        let t: Vec<f64> = (0..25).map(|i| f64::from(i) / 3.0).collect();
        let value = t.iter().map(|t| (t / 7.0).sin().abs()).collect();
        let courses = [
            Course::Constant(0.1),
            Course::Stretches { intervals: vec![[0.1, 1.0 / 3.0], [2.0, 1e3]], value: 0.7 },
            Course::Series(Series { t, value }),
        ];
        let mut all = Vec::new();
        for kind in KINDS {
            let channels = kind.channels.iter().copied().map(Some);
            let channels = if kind.channels.is_empty() { vec![None] } else { channels.collect() };
            let courses = if kind.course.is_some() { &courses[..] } else { &[Course::None] };
            for (channel, course) in
                channels.iter().flat_map(|c| courses.iter().map(move |course| (*c, course)))
            {
                let number = |place: usize| {
                    let spec = kind.spec(place, channel).unwrap();
                    let value = spec.value(spec.mean + 0.3 * spec.std);
                    Uncertain { value, std: if place.is_multiple_of(2) { value.abs() / 7.0 } else { 0.0 } }
                };
                let numbers = (0..kind.parameters.len()).map(number).collect();
                let config = EffectConfig::new(kind, channel, numbers, course.clone()).unwrap();
                let text = config.to_toml();
                let again =
                    read(text.trim_start_matches("[[effect]]\n")).unwrap_or_else(|e| panic!("{text}{e}"));
                assert_eq!(again, config, "{text}");
                let serde = toml::to_string(&config).unwrap();
                assert_eq!(read(&serde).unwrap(), config, "{serde}");
                all.push(config);
            }
        }
        assert!(all.len() > 70);
        #[derive(Deserialize)]
        struct File {
            effect: Vec<EffectConfig>,
        }
        let file: File = toml::from_str(&EffectConfig::write_all(&all)).unwrap();
        assert_eq!(file.effect, all);
    }

    #[test]
    fn the_states_have_names() {
        for kind in KINDS {
            let channel = kind.channels.first().copied();
            let specs = (0..kind.parameters.len()).filter_map(|place| kind.spec(place, channel));
            let numbers =
                specs.map(|spec| Uncertain::known(spec.value(spec.mean + 0.1 * spec.std))).collect();
            let course = if kind.course.is_some() { Course::Constant(0.1) } else { Course::None };
            let effect = EffectConfig::new(kind, channel, numbers, course).unwrap().effect();
            assert_eq!(effect.state_names().len(), effect.states(), "{}", kind.name);
        }
    }
}
