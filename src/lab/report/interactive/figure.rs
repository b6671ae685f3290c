//! A figure: one quantity over another.

use serde::Serialize;

use super::panel::variable;
use super::{Numbers, Source};
use crate::report::Color;

/// How points are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// A dot each.
    Dots,
    /// A ring each.
    Rings,
    /// Joined in the order of time; not-a-number is a gap.
    Path,
}

/// What colours the points.
#[derive(Clone, Debug, Serialize)]
pub struct Shade {
    /// Its name with the unit.
    pub name: String,
    /// A number for each point.
    pub values: Numbers,
    /// The scale goes from minus this to this.
    pub most: f64,
}

/// Points. What is outside the zoomed time is drawn faintly; what has no times is of all of it.
#[derive(Clone, Debug, Serialize)]
pub struct Points {
    /// In the legend.
    pub name: String,
    /// Where they come from.
    pub source: Source,
    /// Their colour's variable.
    #[serde(serialize_with = "variable")]
    pub color: Color,
    /// Their shape.
    pub shape: Shape,
    /// When, s; of each point, or none at all.
    pub times: Numbers,
    /// The horizontal axis.
    pub x: Numbers,
    /// The vertical axis.
    pub y: Numbers,
    /// Coloured by this instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shade: Option<Shade>,
}

/// A line, with an interval about it perhaps.
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    /// In the legend.
    pub name: String,
    /// Where it comes from.
    pub source: Source,
    /// Its colour's variable.
    #[serde(serialize_with = "variable")]
    pub color: Color,
    /// The horizontal axis.
    pub x: Numbers,
    /// The vertical axis.
    pub y: Numbers,
    /// Lower and upper edge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<(Numbers, Numbers)>,
}

/// A circle about the origin, or the ring between two.
#[derive(Clone, Debug, Serialize)]
pub struct Ring {
    /// In the legend.
    pub name: String,
    /// Its colour's variable.
    #[serde(serialize_with = "variable")]
    pub color: Color,
    /// Radii: the lower and the upper end of an interval.
    pub radii: (f64, f64),
}

/// A figure.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Figure {
    /// Its heading.
    pub title: String,
    /// The horizontal axis, with the unit.
    pub x_axis: String,
    /// The vertical axis, with the unit.
    pub y_axis: String,
    /// A unit is as long on both axes.
    pub is_equal: bool,
    /// The points.
    pub points: Vec<Points>,
    /// The lines.
    pub lines: Vec<Line>,
    /// The circles.
    pub rings: Vec<Ring>,
    /// What comes of it, in a sentence.
    pub answer: String,
    /// How to read it.
    pub caption: String,
    /// Why there is nothing to draw.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub empty: String,
}

impl Figure {
    /// A figure without points.
    pub fn new(title: &str, x_axis: &str, y_axis: &str) -> Self {
        Self { title: title.into(), x_axis: x_axis.into(), y_axis: y_axis.into(), ..Self::default() }
    }

    /// No point is in it, nor a line that stands by itself.
    pub fn is_empty(&self) -> bool {
        self.points.iter().all(|points| points.x.is_empty() || points.y.is_empty())
            && (!self.points.is_empty() || self.lines.is_empty())
    }
}
