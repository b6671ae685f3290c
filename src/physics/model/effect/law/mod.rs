//! Physics that no other effect has, as a law: something of the car changes in proportion to what it does.
//!
//! ```toml
//! [[effect]]
//! kind = "law"
//! place = "front slip angle"
//! expression = "coefficient * a_x"
//! coefficient = { value = 4e-4, std = 1e-5 }      # rad/(m/s²)
//! ```
//!
//! A law has a [`Place`] (balances, slip angles, stiffnesses, wheels, sensors) and a [`Feature`] of what the driver and the
//! car do; the unit of its coefficient follows from both. Of several terms each is a law. Cars are alike on both sides: a
//! law that is not is possible, for cars that pull to one side, but only where the feature has no side ([`Law::all`]).

mod feature;
mod mechanism;
mod place;

use std::collections::BTreeMap;
use std::fmt;
use std::sync::LazyLock;

use super::config::listed;
use super::{
    Acting, Channel, Effect, Felt, Kind, Now, OF_CHANNEL, Readings, Scale, SearchHints, Setting, Spec,
};

pub use feature::Feature;
pub use place::Place;

/// A place and a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Law {
    /// What changes.
    pub place: Place,
    /// With what.
    pub feature: Feature,
}

/// See [`super::named`]; it is none of the library ([`super::KINDS`]).
pub static KIND: Kind = Kind {
    name: "law",
    words: "law of the {place}",
    about: "something of the car changes with what it does, as no effect of the library has it",
    equation: "Δplace = coefficient × feature",
    source: "found in recordings",
    place: "where the law says",
    to_tell_apart: "a drive in which the feature varies and everything else does not",
    channels: &[],
    parameters: &[Spec {
        name: "coefficient",
        words: "coefficient",
        unit: OF_CHANNEL,
        scale: Scale::Linear,
        mean: 0.0,
        std: 1.0,
        bounds: (-30.0, 30.0),
        step: 0.1,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| match setting.channel {
        Some(Channel::Law(law)) => Box::new(Acts { law, coefficient: setting.values[0] }),
        _ => Box::new(Nothing),
    },
};

/// What stands before the feature in an `expression`.
const COEFFICIENT: &str = "coefficient";

impl Law {
    /// All that make sense: on the one side of a car as on the other, or one-sided by a feature that has no side.
    pub fn all() -> impl Iterator<Item = Self> {
        let with_feature = |place: Place| Feature::all().map(move |feature| Self { place, feature });
        Place::ALL.into_iter().flat_map(with_feature).filter(|law| law.place.takes(law.feature))
    }

    /// From the keys of a table.
    ///
    /// # Errors
    /// The key that is wrong, and what would be accepted.
    pub fn parse(place: &str, expression: &str) -> Result<Self, (&'static str, String)> {
        let rest = expression.trim().strip_prefix(COEFFICIENT).map(str::trim_start);
        let feature = rest.and_then(|rest| rest.strip_prefix('*')).map_or(expression, str::trim);
        match Self::named(place, feature) {
            Ok(_) if rest.is_none() => Err(no_feature(expression)),
            found => found,
        }
    }

    /// By the names of its place and its feature.
    ///
    /// # Errors
    /// Which of them is none, as the key of a table, and what would be accepted.
    pub fn named(place: &str, feature: &str) -> Result<Self, (&'static str, String)> {
        let found = Place::ALL.into_iter().find(|known| known.name() == place);
        let place = found.ok_or_else(|| {
            let known = listed(Place::ALL.iter().map(|place| place.name()));
            ("place", format!("`{place}` is none; use one of {known}"))
        })?;
        let found = Feature::all().find(|known| known.name() == feature);
        Ok(Self { place, feature: found.ok_or_else(|| no_feature(feature))? })
    }

    /// As a table has it.
    pub fn expression(self) -> String {
        format!("{COEFFICIENT} * {}", self.feature.name())
    }

    /// Unit and ordinary size of the coefficient.
    pub fn usual(self) -> (&'static str, f64) {
        let (of_place, of_feature) = (self.place.size(), self.feature.size());
        (UNITS.get(&self).copied().unwrap_or("1"), of_place / of_feature)
    }
}

fn no_feature(text: &str) -> (&'static str, String) {
    let known = listed(Feature::all().map(Feature::name));
    ("expression", format!("`{text}` is none; write \"{COEFFICIENT} * …\" with one of {known}"))
}

/// Of the coefficients.
static UNITS: LazyLock<BTreeMap<Law, &'static str>> = LazyLock::new(|| {
    let unit = |law: Law| -> &'static str {
        match (law.place.unit(), law.feature.unit()) {
            (place, "1") => place,
            (place, feature) if feature.contains(['/', ' ', '·']) => {
                Box::leak(format!("{place}/({feature})").into_boxed_str())
            }
            (place, feature) => Box::leak(format!("{place}/{feature}").into_boxed_str()),
        }
    };
    let every =
        Place::ALL.into_iter().flat_map(|place| Feature::all().map(move |feature| Law { place, feature }));
    every.map(|law| (law, unit(law))).collect()
});

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place.name(), self.feature.name())
    }
}

/// A law with its coefficient.
#[derive(Clone, Copy, Debug)]
struct Acts {
    law: Law,
    coefficient: f64,
}

impl Effect for Acts {
    fn states(&self) -> usize {
        self.law.feature.states()
    }

    fn state_names(&self) -> &'static [&'static str] {
        &["memory", "rate"][..self.states()]
    }

    fn begin(&self, now: &Now<'_>, states: &mut [f64]) {
        self.law.feature.begin(now, states);
    }

    fn act(&self, now: &Now<'_>, states: &[f64], on: &mut Acting) {
        self.law.place.change(self.coefficient * self.law.feature.value(now, states), on);
    }

    fn rates(&self, now: &Now<'_>, _felt: &Felt, states: &[f64], rates: &mut [f64]) {
        self.law.feature.rates(now, states, rates);
    }

    fn fastest_rate(&self, _vx: f64) -> f64 {
        self.law.feature.fastest_rate()
    }

    fn sense(&self, now: &Now<'_>, _felt: &Felt, states: &[f64], readings: &mut Readings) {
        if let Some(quantity) = self.law.place.sensor() {
            readings[quantity as usize] += self.coefficient * self.law.feature.value(now, states);
        }
    }
}

/// A law of nothing: a table without place and expression is refused before.
#[derive(Debug)]
struct Nothing;

impl Effect for Nothing {}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, made};
    use super::super::{Course, EffectConfig};
    use super::*;

    #[test]
    fn names_and_units_come_back() {
        for law in Law::all() {
            assert_eq!(Law::parse(law.place.name(), &law.expression()), Ok(law), "{law}");
        }
        let law = Law::parse("front slip angle", "coefficient*a_x").unwrap();
        assert_eq!(law.usual().0, "rad/(m/s²)");
        assert_eq!(Law::parse("front slip angle", "a_x").unwrap_err().0, "expression");
        assert_eq!(Law::parse("bonnet", "coefficient * a_x").unwrap_err().0, "place");
    }

    #[test]
    fn a_table_is_read_and_written() {
        let text = "kind = \"law\"\nplace = \"rear slip angle\"\nexpression = \"coefficient * delta\"\n\
                    coefficient = { value = 0.1, std = 0.01 }\n";
        let config: EffectConfig = toml::from_str(text).unwrap();
        let written = config.to_toml();
        assert_eq!(toml::from_str::<EffectConfig>(&written.replace("[[effect]]\n", "")).unwrap(), config);
        for (wrong, key) in [
            ("kind = \"law\"\ncoefficient = 1.0\n", "place"),
            ("kind = \"law\"\nplace = \"rear slip angle\"\ncoefficient = 1.0\n", "expression"),
            ("kind = \"steering_lag\"\nplace = \"rear slip angle\"\ntime_constant_s = 0.1\n", "place"),
        ] {
            let error = toml::from_str::<EffectConfig>(wrong).unwrap_err().to_string();
            assert!(error.contains(key), "{error}");
        }
    }

    /// Each law moves its place by its coefficient times its feature, and at no coefficient nothing.
    #[test]
    fn what_a_law_says_is_done() {
        let mut bench = Bench::driving(20.0);
        (bench.now.ax, bench.now.ay, bench.now.steering_wheel) = (-2.0, 4.0, 0.3);
        (bench.now.velocity.vy, bench.now.velocity.yaw_rate, bench.now.t) = (-0.4, 0.2, 30.0);
        for law in Law::all() {
            for coefficient in [0.0, law.usual().1] {
                let effect = made(&KIND, &[coefficient], Some(Channel::Law(law)), &Course::None);
                let states = bench.begun(&*effect);
                let says = coefficient * law.feature.value(&bench.now, &states);
                let on = bench.acted(&*effect, &states);
                let mut readings = [0.0; crate::Quantity::COUNT];
                effect.sense(&bench.now, &Felt::default(), &states, &mut readings);
                match law.place.sensor() {
                    Some(quantity) => assert_eq!(readings[quantity as usize], says, "{law}"),
                    None => assert_eq!(on == bench.plain(), says == 0.0, "{law}"),
                }
            }
        }
    }

    /// In a mirror everything is the other way round.
    #[test]
    fn features_have_the_side_that_they_say() {
        let mut bench = Bench::driving(20.0);
        (bench.now.ax, bench.now.ay, bench.now.steering_wheel) = (-2.0, 4.0, 0.3);
        (bench.now.velocity.vy, bench.now.velocity.yaw_rate) = (-0.4, 0.2);
        let mut mirrored = bench.now;
        (mirrored.ay, mirrored.steering_wheel) = (-4.0, -0.3);
        (mirrored.velocity.vy, mirrored.velocity.yaw_rate) = (0.4, -0.2);
        for feature in Feature::all() {
            let value = |now: &Now<'_>| {
                let mut states = vec![0.0; feature.states()];
                feature.begin(now, &mut states);
                feature.value(now, &states)
            };
            let sign = if feature.has_side() { -1.0 } else { 1.0 };
            assert_eq!(value(&mirrored), sign * value(&bench.now), "{}", feature.name());
        }
    }
}
