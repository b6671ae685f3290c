//! The road: what the surface does to the tires, over time.

use serde::{Deserialize, Serialize};

use super::{Problem, finite, positive};

/// A stretch of road, from `from_s` until the next one begins. What is not given is the vehicle's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// When it begins, s.
    #[serde(default)]
    pub from_s: f64,
    /// Time over which the surface goes over into this one, s.
    #[serde(default)]
    pub transition_s: f64,
    /// What it is, for plots and reports.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Friction, both directions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Longitudinal stiffness of every wheel / its static load, per unit slip, absolutely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope: Option<f64>,
    /// Longitudinal stiffness against the vehicle's `longitudinal_stiffness`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longitudinal_factor: Option<f64>,
    /// Longitudinal stiffness of the road's surface / static load, per unit slip, in series with the
    /// vehicle's, which is the tire's alone then (thesis 7.1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_stiffness: Option<f64>,
    /// Cornering stiffness of every wheel / its static load, 1/rad, absolutely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cornering: Option<f64>,
    /// Cornering stiffness against the vehicle's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_factor: Option<f64>,
    /// How far the road shakes the rims of the wheels about their rolling, standard deviation, m/s: asphalt 0.02 or
    /// less, gravel 0.05 to 0.3.
    #[serde(default, skip_serializing_if = "is_smooth")]
    pub roughness_mps: f64,
    /// What is different under the left wheels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left: Option<Side>,
    /// What is different under the right wheels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right: Option<Side>,
}

fn is_smooth(roughness_mps: &f64) -> bool {
    *roughness_mps == 0.0
}

/// What one side of a stretch has of its own; the keys are those of [`Stretch`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Side {
    /// Friction, both directions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Longitudinal stiffness / static load, per unit slip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope: Option<f64>,
    /// Longitudinal stiffness against the vehicle's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longitudinal_factor: Option<f64>,
    /// Longitudinal stiffness of the road's surface / static load, per unit slip, in series with the
    /// vehicle's, which is the tire's alone then (thesis 7.1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_stiffness: Option<f64>,
    /// Cornering stiffness / static load, 1/rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cornering: Option<f64>,
    /// Cornering stiffness against the vehicle's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_factor: Option<f64>,
}

impl Side {
    fn validate(&self, key: &str, problems: &mut Vec<Problem>) {
        let limited = [
            ("friction", self.friction, 3.0),
            ("slope", self.slope, 1000.0),
            ("longitudinal_factor", self.longitudinal_factor, 10.0),
            ("surface_stiffness", self.surface_stiffness, 1e6),
            ("cornering", self.cornering, 100.0),
            ("lateral_factor", self.lateral_factor, 10.0),
        ];
        for (name, value, most) in limited {
            let Some(value) = value else { continue };
            positive(problems, &format!("{key}.{name}"), value);
            if value > most {
                problems.push(Problem::new(
                    format!("{key}.{name}"),
                    value,
                    format!("must be at most {most}"),
                ));
            }
        }
        let twice = "says the same thing twice: give one of the two";
        if let (Some(_), Some(factor)) = (self.slope, self.longitudinal_factor) {
            problems.push(Problem::new(
                format!("{key}.longitudinal_factor"),
                factor,
                format!("beside slope {twice}"),
            ));
        }
        if let (Some(_), Some(stiffness)) = (self.slope.or(self.longitudinal_factor), self.surface_stiffness)
        {
            problems.push(Problem::new(
                format!("{key}.surface_stiffness"),
                stiffness,
                format!("beside slope or longitudinal_factor {twice}"),
            ));
        }
        if let (Some(_), Some(factor)) = (self.cornering, self.lateral_factor) {
            problems.push(Problem::new(
                format!("{key}.lateral_factor"),
                factor,
                format!("beside cornering {twice}"),
            ));
        }
    }
}

impl Stretch {
    /// What lies under the wheels of one side.
    pub fn side(&self, left: bool) -> Side {
        let own = if left { self.left } else { self.right }.unwrap_or_default();
        // One way to say the stiffness replaces every other one.
        let longitudinal = |side: &Side| [side.slope, side.longitudinal_factor, side.surface_stiffness];
        let lateral = |side: &Side| [side.cornering, side.lateral_factor];
        let both = self.both_sides();
        let [slope, longitudinal_factor, surface_stiffness] =
            own_or_common(longitudinal(&own), longitudinal(&both));
        let [cornering, lateral_factor] = own_or_common(lateral(&own), lateral(&both));
        let friction = own.friction.or(self.friction);
        Side { friction, slope, longitudinal_factor, surface_stiffness, cornering, lateral_factor }
    }

    fn both_sides(&self) -> Side {
        Side {
            friction: self.friction,
            slope: self.slope,
            longitudinal_factor: self.longitudinal_factor,
            surface_stiffness: self.surface_stiffness,
            cornering: self.cornering,
            lateral_factor: self.lateral_factor,
        }
    }

    pub(super) fn validate(&self, key: &str, problems: &mut Vec<Problem>) {
        finite(problems, &format!("{key}.from_s"), self.from_s);
        if !(0.0..=2.0).contains(&self.roughness_mps) {
            let key = format!("{key}.roughness_mps");
            problems.push(Problem::new(key, self.roughness_mps, "must be 0 to 2"));
        }
        if !(self.transition_s.is_finite() && self.transition_s >= 0.0) {
            let key = format!("{key}.transition_s");
            problems.push(Problem::new(key, self.transition_s, "must be zero or positive"));
        }
        self.both_sides().validate(key, problems);
        for (name, side) in [("left", self.left), ("right", self.right)] {
            if let Some(side) = side {
                side.validate(&format!("{key}.{name}"), problems);
            }
        }
    }
}

fn own_or_common<const N: usize>(own: [Option<f64>; N], common: [Option<f64>; N]) -> [Option<f64>; N] {
    if own.iter().any(Option::is_some) { own } else { common }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_side_may_differ() {
        let stretch = Stretch {
            friction: Some(0.9),
            slope: Some(95.0),
            right: Some(Side { friction: Some(0.1), longitudinal_factor: Some(0.5), ..Side::default() }),
            ..Stretch::default()
        };
        assert_eq!(stretch.side(true).friction, Some(0.9));
        assert_eq!(stretch.side(true).slope, Some(95.0));
        assert_eq!(stretch.side(false).friction, Some(0.1));
        assert_eq!(stretch.side(false).slope, None);
        assert_eq!(stretch.side(false).longitudinal_factor, Some(0.5));
    }

    #[test]
    fn a_road_as_a_spring_is_one_way_to_say_the_stiffness() {
        let soft = Side { surface_stiffness: Some(60.0), ..Side::default() };
        let stretch = Stretch { slope: Some(95.0), left: Some(soft), ..Stretch::default() };
        assert_eq!((stretch.side(true).slope, stretch.side(true).surface_stiffness), (None, Some(60.0)));
        assert_eq!((stretch.side(false).slope, stretch.side(false).surface_stiffness), (Some(95.0), None));
        let mut problems = vec![];
        stretch.validate("road", &mut problems);
        assert!(problems.is_empty());
        let twice = Stretch { surface_stiffness: Some(60.0), ..stretch };
        twice.validate("road", &mut problems);
        assert_eq!(problems.len(), 1);
    }
}
