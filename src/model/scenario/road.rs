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
    /// Cornering stiffness of every wheel / its static load, 1/rad, absolutely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cornering: Option<f64>,
    /// Cornering stiffness against the vehicle's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_factor: Option<f64>,
    /// What is different under the left wheels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left: Option<Side>,
    /// What is different under the right wheels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right: Option<Side>,
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
        // An own factor replaces a common absolute value and the other way round.
        let stiffness = |own: (Option<f64>, Option<f64>), both| {
            if own.0.is_some() || own.1.is_some() { own } else { both }
        };
        let (slope, longitudinal_factor) =
            stiffness((own.slope, own.longitudinal_factor), (self.slope, self.longitudinal_factor));
        let (cornering, lateral_factor) =
            stiffness((own.cornering, own.lateral_factor), (self.cornering, self.lateral_factor));
        Side {
            friction: own.friction.or(self.friction),
            slope,
            longitudinal_factor,
            cornering,
            lateral_factor,
        }
    }

    pub(super) fn validate(&self, key: &str, problems: &mut Vec<Problem>) {
        finite(problems, &format!("{key}.from_s"), self.from_s);
        if !(self.transition_s.is_finite() && self.transition_s >= 0.0) {
            let key = format!("{key}.transition_s");
            problems.push(Problem::new(key, self.transition_s, "must be zero or positive"));
        }
        let both = Side {
            friction: self.friction,
            slope: self.slope,
            longitudinal_factor: self.longitudinal_factor,
            cornering: self.cornering,
            lateral_factor: self.lateral_factor,
        };
        both.validate(key, problems);
        for (name, side) in [("left", self.left), ("right", self.right)] {
            if let Some(side) = side {
                side.validate(&format!("{key}.{name}"), problems);
            }
        }
    }
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
}
