//! A plot, drawn with plotters as SVG.

mod bars;
mod chart;
mod clip;
mod file;

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use thiserror::Error;

use super::markup::open_svg;
use super::{Color, escape};

/// A plot that could not be drawn; it tells what plotters says.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("cannot draw the plot `{plot}`: {reason}")]
pub struct PlotError {
    /// Which.
    pub plot: String,
    /// Why.
    pub reason: String,
}

/// A stretch of the background, e.g. a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// From and to, in the x axis's unit.
    pub x: Range<f64>,
    /// Written at its top.
    pub label: String,
    /// Its colour.
    pub color: Color,
}

/// A vertical line, e.g. where something was noticed.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Where.
    pub x: f64,
    /// Written beside it.
    pub label: String,
}

/// A piece of a bar that tells what is the case from when to when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// From, in the x axis's unit.
    pub from: f64,
    /// To.
    pub to: f64,
    /// Its colour.
    pub color: Color,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Without a gap.
    Solid,
    /// In dashes.
    Dashed,
    /// In dots.
    Dotted,
}

impl Stroke {
    pub(super) const ALL: [Self; 3] = [Self::Solid, Self::Dashed, Self::Dotted];

    pub(super) fn dashes(self) -> Option<&'static str> {
        match self {
            Self::Solid => None,
            Self::Dashed => Some("12 8"),
            Self::Dotted => Some("3 7"),
        }
    }

    fn of(color: Color) -> Self {
        if color == Color::OtherTruth { Self::Dashed } else { Self::Solid }
    }
}

/// How a point is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// A small disc.
    Dot,
    /// A ring.
    Ring,
    /// An x.
    Cross,
}

/// A plot in the making. Series are drawn in the order in which they are added, and no peak of them
/// gets lost. What is not finite is a gap; what is outside the y axis is drawn at its end.
#[derive(Clone, Debug)]
pub struct Plot {
    title: String,
    x_label: String,
    y_label: String,
    x: Range<f64>,
    y: Range<f64>,
    height: u32,
    spans: Vec<Span>,
    marks: Vec<Mark>,
    series: Vec<Series>,
    bars: Vec<(String, Vec<Segment>)>,
    legend: Vec<(String, Color, Swatch)>,
}

#[derive(Clone, Debug)]
enum Series {
    /// In order of x.
    Line(Color, Stroke, Vec<(f64, f64)>),
    /// In any order.
    Curve(Color, Stroke, Vec<(f64, f64)>),
    Points(Color, Marker, Vec<(f64, f64)>),
    Band(Color, Vec<(f64, f64, f64)>),
}

#[derive(Clone, Copy, Debug)]
enum Swatch {
    Line(Stroke),
    Points(Marker),
    Band,
    Block,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Drawn = Result<(), String>;

fn said(error: impl std::fmt::Display) -> String {
    error.to_string()
}

impl Plot {
    /// Plotters draws on whole pixels; so it gets this many for each of the page's.
    const FINE: u32 = 2;
    /// Width on the page, pixels; the page scales it.
    const WIDTH: u32 = 960;
    const Y_LABELS: u32 = 66;
    const X_LABELS: u32 = 42;
    const MARGIN: u32 = 10;
    /// Half of the last number below the x axis stands out there.
    const RIGHT: u32 = 24;
    const BAR: f64 = 26.0;
    const SMALL: u32 = 15;

    /// An empty plot. `title` is read out where it cannot be seen; `y_label` has the unit.
    pub fn new(title: &str, y_label: &str, x: Range<f64>, y: Range<f64>) -> Self {
        Self {
            title: title.into(),
            x_label: "time, s".into(),
            y_label: y_label.into(),
            x,
            y,
            height: 220,
            spans: Vec::new(),
            marks: Vec::new(),
            series: Vec::new(),
            bars: Vec::new(),
            legend: Vec::new(),
        }
    }

    /// Height in pixels, without the bars.
    #[must_use]
    pub fn height(mut self, pixels: u32) -> Self {
        self.height = pixels.clamp(120, 2000);
        self
    }

    /// The name of the x axis with its unit, where it is not the time.
    #[must_use]
    pub fn x_label(mut self, label: &str) -> Self {
        self.x_label = label.into();
        self
    }

    /// The background.
    #[must_use]
    pub fn spans(mut self, spans: &[Span]) -> Self {
        self.spans = spans.to_vec();
        self
    }

    /// Vertical lines.
    #[must_use]
    pub fn marks(mut self, marks: &[Mark]) -> Self {
        self.marks = marks.to_vec();
        self
    }

    /// A line, points in order of x.
    #[must_use]
    pub fn line(self, name: &str, color: Color, points: impl Iterator<Item = (f64, f64)>) -> Self {
        self.stroked(name, color, Stroke::of(color), points)
    }

    /// A line of another stroke than its colour has, points in order of x.
    #[must_use]
    pub fn stroked(
        mut self,
        name: &str,
        color: Color,
        stroke: Stroke,
        points: impl Iterator<Item = (f64, f64)>,
    ) -> Self {
        self.legend.push((name.into(), color, Swatch::Line(stroke)));
        self.series.push(Series::Line(color, stroke, points.collect()));
        self
    }

    /// A line through points in any order, e.g. a loop. It is cut off where it leaves the axes.
    #[must_use]
    pub fn curve(
        mut self,
        name: &str,
        color: Color,
        stroke: Stroke,
        points: impl Iterator<Item = (f64, f64)>,
    ) -> Self {
        self.legend.push((name.into(), color, Swatch::Line(stroke)));
        self.series.push(Series::Curve(color, stroke, points.collect()));
        self
    }

    /// Points. Those outside the axes are not drawn.
    #[must_use]
    pub fn points(
        mut self,
        name: &str,
        color: Color,
        marker: Marker,
        points: impl Iterator<Item = (f64, f64)>,
    ) -> Self {
        self.legend.push((name.into(), color, Swatch::Points(marker)));
        self.series.push(Series::Points(color, marker, points.collect()));
        self
    }

    /// A band between two lines: (x, low, high) in order of x.
    #[must_use]
    pub fn band(mut self, name: &str, color: Color, rows: impl Iterator<Item = (f64, f64, f64)>) -> Self {
        self.legend.push((name.into(), color, Swatch::Band));
        self.series.push(Series::Band(color, rows.collect()));
        self
    }

    /// A bar below the plot.
    #[must_use]
    pub fn bar(mut self, name: &str, segments: Vec<Segment>) -> Self {
        self.bars.push((name.into(), segments));
        self
    }

    /// An entry of the legend for a colour of the bars.
    #[must_use]
    pub fn explain(mut self, name: &str, color: Color) -> Self {
        self.legend.push((name.into(), color, Swatch::Block));
        self
    }

    /// Does a line go beyond the y axis, and so run along its end?
    pub fn goes_beyond(&self) -> bool {
        let beyond = |(x, y): &(f64, f64)| {
            self.x.contains(x) && y.is_finite() && !(self.y.start..=self.y.end).contains(y)
        };
        self.series
            .iter()
            .any(|series| matches!(series, Series::Line(.., points) if points.iter().any(beyond)))
    }

    /// The legend as HTML.
    pub fn legend(&self) -> String {
        let mut html = String::from("<ul class=\"legend\">");
        for (name, color, swatch) in &self.legend {
            let kind = match swatch {
                Swatch::Line(Stroke::Dashed) => "dashes",
                Swatch::Line(Stroke::Dotted) => "dots",
                Swatch::Line(Stroke::Solid) => "line",
                Swatch::Points(Marker::Dot) => "dot",
                Swatch::Points(Marker::Ring) => "dot ring",
                Swatch::Points(Marker::Cross) => "cross",
                Swatch::Band => "band",
                Swatch::Block => "band block",
            };
            html += &format!(
                "<li><i class=\"{kind}\" style=\"color:var(--{})\"></i>{}</li>",
                color.name(),
                escape(name)
            );
        }
        html + "</ul>"
    }

    /// Draws it.
    ///
    /// # Errors
    /// What plotters reports; ranges that are empty or not finite.
    pub fn svg(&self) -> Result<String, PlotError> {
        self.draw().map_err(|reason| PlotError { plot: self.title.clone(), reason })
    }

    fn draw(&self) -> Result<String, String> {
        let range =
            |range: &Range<f64>| range.start.is_finite() && range.end.is_finite() && range.start < range.end;
        if !range(&self.x) || !range(&self.y) {
            return Err(format!("an axis from {:?} to {:?}", self.x, self.y));
        }
        let bars = self.bars.len() as u32 * Self::BAR as u32;
        let (width, height) = (Self::FINE * Self::WIDTH, Self::FINE * (self.height + bars));
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
            let (upper, lower) = root.split_vertically(Self::FINE * self.height);
            self.draw_chart(&upper)?;
            self.draw_bars(&lower)?;
            root.present().map_err(said)?;
        }
        let body = text.find('>').and_then(|end| text.get(end + 1..)).ok_or("plotters wrote no SVG")?;
        Ok(open_svg(&self.title, f64::from(width), f64::from(height)) + &Color::substitute(body))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> Plot {
        let span = Span { x: 0.0..6.0, label: "a < b".into(), color: Color::Surface(0) };
        Plot::new("Speed & more", "m/s", 0.0..10.0, 0.0..30.0)
            .spans(&[span])
            .marks(&[Mark { x: 7.0, label: "noticed".into() }])
            .band("interval", Color::First, (0..100).map(|i| (f64::from(i) * 0.1, 5.0, 8.0)))
            .line("truth", Color::OtherTruth, (0..100).map(|i| (f64::from(i) * 0.1, f64::NAN)))
            .line("estimate", Color::First, (0..100).map(|i| (f64::from(i) * 0.1, 1e6)))
            .curve("loop", Color::Second, Stroke::Dotted, [(5.0, 1.0), (2.0, 2.0), (5.0, 3.0)].into_iter())
            .points("measured", Color::Notice, Marker::Cross, [(5.0, 1.0), (50.0, 2.0)].into_iter())
            .bar("source", vec![Segment { from: 2.0, to: 99.0, color: Color::Third }])
    }

    #[test]
    fn everything_is_in_the_picture_and_no_placeholder_is_left() {
        let svg = plot().svg().unwrap();
        for part in
            ["m/s", "time, s", "a &lt; b", "noticed", "source", "<polygon", "<polyline", "Speed &amp; more"]
        {
            assert!(svg.contains(part), "{part} is missing in {svg}");
        }
        assert!(!svg.contains("#C01"), "a placeholder is left");
        assert!(svg.contains("stroke=\"var(--second)\" stroke-dasharray=\"3 7\""), "{svg}");
        assert!(svg.ends_with("</svg>\n") || svg.ends_with("</svg>"), "{}", &svg[svg.len() - 20..]);
        let legend = plot().legend();
        assert!(legend.contains("dashes") && legend.contains("var(--first)"), "{legend}");
    }

    #[test]
    fn a_line_beyond_the_scale_is_known() {
        assert!(plot().goes_beyond());
        let within = Plot::new("", "", 0.0..1.0, 0.0..1.0).line(
            "",
            Color::First,
            [(0.5, 1.0), (0.6, f64::NAN), (9.0, 9.0)].into_iter(),
        );
        assert!(!within.goes_beyond());
    }

    #[test]
    fn as_a_file_it_needs_no_page() {
        let svg = plot().x_label("slip, %").svg_file().unwrap();
        assert!(svg.starts_with("<?xml") && svg.ends_with("</svg>\n"), "{svg}");
        assert!(!svg.contains("var(--"), "a colour needs the page");
        for part in ["slip, %", "Speed &amp; more", ">interval<", ">measured<", "#0b62b8"] {
            assert!(svg.contains(part), "{part} is missing in {svg}");
        }
    }

    #[test]
    fn an_impossible_axis_is_an_error() {
        let error = Plot::new("Slope", "1", 0.0..10.0, 1.0..f64::NAN).svg().unwrap_err();
        assert!(error.to_string().contains("`Slope`"), "{error}");
    }
}
