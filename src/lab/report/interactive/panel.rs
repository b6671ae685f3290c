//! A panel: lines over time, and when something was so.

use serde::Serialize;

use super::Numbers;
use crate::report::Color;

/// Where a line comes from. It decides how the line is drawn, so that a page in grey still tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// A sensor: a thin solid line, or dots.
    Measured,
    /// What gripd makes of all sensors: a heavier, dashed line.
    Estimated,
    /// What the configured car would do, or what other sensors say: dotted.
    Expected,
    /// What models say, from the plainest on: dotted, dashed, and so on.
    Predicted,
    /// What something is at least or at most: dotted.
    Bound,
}

/// A line, with an interval about it perhaps. It has a number for each of the page's times.
#[derive(Clone, Debug, Serialize)]
pub struct Series {
    /// In the legend.
    pub name: String,
    /// Where it comes from.
    pub source: Source,
    /// Its colour's variable.
    #[serde(serialize_with = "variable")]
    pub color: Color,
    /// The numbers, in the panel's unit.
    pub values: Numbers,
    /// Lower and upper edge of its interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<(Numbers, Numbers)>,
}

/// Stretches of time of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct Span {
    /// What was so.
    pub name: String,
    /// Its colour's variable.
    #[serde(serialize_with = "variable")]
    pub color: Color,
    /// From and to, s.
    pub times: Numbers,
}

impl Span {
    /// Of stretches as [`spans`](super::spans) finds them.
    pub fn new(name: &str, color: Color, spans: &[(f64, f64)]) -> Self {
        let times = spans.iter().flat_map(|(from, to)| [*from, *to]).collect();
        Self { name: name.into(), color, times: Numbers::rounded(times, 2) }
    }
}

/// So large something usually is, whenever.
#[derive(Clone, Debug, Serialize)]
pub struct Band {
    /// In the legend.
    pub name: String,
    /// Its colour's variable.
    #[serde(serialize_with = "variable")]
    pub color: Color,
    /// From, to, in the panel's unit.
    pub values: (f64, f64),
}

/// A panel over the page's times.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Panel {
    /// Its heading.
    pub title: String,
    /// The vertical axis, with the unit.
    pub axis: String,
    /// Lines, from the back to the front.
    pub series: Vec<Series>,
    /// Shaded, with a strip below the lines: when the lines are valid, or held out.
    pub shades: Vec<Span>,
    /// Behind the lines, at all times.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bands: Vec<Band>,
    /// A strip for each, named at the axis; the panel has no lines then.
    pub lanes: Vec<Span>,
    /// The vertical axis never goes beyond these, however wide an interval is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<(f64, f64)>,
    /// The vertical axis always has these in it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reach: Option<(f64, f64)>,
    /// How to read it, in a sentence or two.
    pub caption: String,
    /// Why there is nothing to draw. Set by [`Plots::panel`](super::Plots::panel) where there is none and this is
    /// empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub empty: String,
}

impl Panel {
    /// A panel without lines.
    pub fn new(title: &str, axis: &str) -> Self {
        Self { title: title.into(), axis: axis.into(), ..Self::default() }
    }

    /// Nothing is in it.
    pub fn is_empty(&self) -> bool {
        let is_empty = |series: &Series| {
            let edges = series.interval.as_ref();
            series.values.is_empty() && edges.is_none_or(|(low, high)| low.is_empty() && high.is_empty())
        };
        self.series.iter().all(is_empty) && self.lanes.is_empty()
    }
}

/// A colour as the style sheet knows it.
pub(super) fn variable<S: serde::Serializer>(color: &Color, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(color.name())
}
