//! A plot over time, drawn with plotters as SVG.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use thiserror::Error;

use super::{Color, decimate, escape};

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

/// A plot in the making. Series are drawn in the order in which they are added, and no peak of them
/// gets lost. What is not finite is a gap; what is outside the y axis is drawn at its end.
#[derive(Clone, Debug)]
pub struct Plot {
    title: String,
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
    Line(Color, Vec<(f64, f64)>),
    Band(Color, Vec<(f64, f64, f64)>),
}

#[derive(Clone, Copy, Debug)]
enum Swatch {
    Line,
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
    const BAR: f64 = 26.0;
    const SMALL: u32 = 15;

    /// An empty plot. `title` is read out where it cannot be seen; `y_label` has the unit.
    pub fn new(title: &str, y_label: &str, x: Range<f64>, y: Range<f64>) -> Self {
        Self {
            title: title.into(),
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
    pub fn line(mut self, name: &str, color: Color, points: impl Iterator<Item = (f64, f64)>) -> Self {
        self.legend.push((name.into(), color, Swatch::Line));
        self.series.push(Series::Line(color, points.collect()));
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

    /// The legend as HTML.
    pub fn legend(&self) -> String {
        let mut html = String::from("<ul class=\"legend\">");
        for (name, color, swatch) in &self.legend {
            let kind = match swatch {
                Swatch::Line if *color == Color::OtherTruth => "dashes",
                Swatch::Line => "line",
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
        Ok(format!(
            "<svg role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {width} {height}\" \
             xmlns=\"http://www.w3.org/2000/svg\">{}",
            escape(&self.title),
            Color::substitute(body)
        ))
    }

    fn text(color: Color) -> TextStyle<'static> {
        ("sans-serif", Self::FINE * Self::SMALL).into_font().color(&color.placeholder())
    }

    /// Of one pixel column, in x.
    fn column(&self) -> f64 {
        (self.x.end - self.x.start) / f64::from(Self::WIDTH - Self::Y_LABELS - 2 * Self::MARGIN)
    }

    fn draw_chart(&self, area: &Area) -> Drawn {
        let mut chart = ChartBuilder::on(area)
            .margin(Self::FINE * Self::MARGIN)
            .set_label_area_size(LabelAreaPosition::Left, Self::FINE * Self::Y_LABELS)
            .set_label_area_size(LabelAreaPosition::Bottom, Self::FINE * Self::X_LABELS)
            .build_cartesian_2d(self.x.clone(), self.y.clone())
            .map_err(said)?;
        self.draw_spans(&mut chart)?;
        self.draw_mesh(&mut chart)?;
        for series in &self.series {
            self.draw_series(&mut chart, series)?;
        }
        self.draw_labels(&mut chart)
    }

    fn draw_mesh(&self, chart: &mut Chart) -> Drawn {
        let decimals = decimals(self.y.end - self.y.start);
        let (label, description) = (Self::text(Color::Muted), Self::text(Color::Ink));
        chart
            .configure_mesh()
            .disable_x_mesh()
            .bold_line_style(Color::Grid.placeholder().stroke_width(Self::FINE))
            .light_line_style(TRANSPARENT)
            .axis_style(Color::Muted.placeholder().stroke_width(Self::FINE))
            .x_labels(13)
            .y_labels((self.height / 42).clamp(3, 9) as usize)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{:.*}", decimals, if y.abs() < 1e-9 { 0.0 } else { *y }))
            .label_style(label)
            .axis_desc_style(description)
            .x_desc("time, s")
            .y_desc(self.y_label.as_str())
            .draw()
            .map_err(said)
    }

    fn draw_spans(&self, chart: &mut Chart) -> Drawn {
        let bands = self.spans.iter().map(|span| {
            let corners = [(self.clip_x(span.x.start), self.y.start), (self.clip_x(span.x.end), self.y.end)];
            Rectangle::new(corners, span.color.placeholder().filled())
        });
        chart.draw_series(bands).map_err(said)?;
        Ok(())
    }

    fn draw_series(&self, chart: &mut Chart, series: &Series) -> Drawn {
        let clip = |y: f64| y.clamp(self.y.start, self.y.end);
        match series {
            Series::Line(color, points) => {
                let inside = points.iter().filter(|point| self.x.contains(&point.0)).copied();
                let style = color.placeholder().stroke_width(if *color == Color::OtherTruth { 2 } else { 3 });
                for piece in decimate::lines(inside, self.column()) {
                    let piece = piece.into_iter().map(|(x, y)| (x, clip(y)));
                    chart.draw_series(LineSeries::new(piece, style)).map_err(said)?;
                }
            }
            Series::Band(color, rows) => {
                let inside = rows.iter().filter(|row| self.x.contains(&row.0)).copied();
                for piece in decimate::bands(inside, 2.0 * self.column()) {
                    let there = piece.iter().map(|(x, low, _)| (*x, clip(*low)));
                    let back = piece.iter().rev().map(|(x, _, high)| (*x, clip(*high)));
                    let outline: Vec<_> = there.chain(back).collect();
                    chart
                        .draw_series([Polygon::new(outline, color.placeholder().mix(0.25).filled())])
                        .map_err(said)?;
                }
            }
        }
        Ok(())
    }

    /// The spans' names above everything, the marks' below them.
    fn draw_labels(&self, chart: &mut Chart) -> Drawn {
        let per_pixel =
            (self.y.end - self.y.start) / f64::from(self.height - Self::X_LABELS - 2 * Self::MARGIN);
        let right_of = 5.0 * self.column();
        let style = |color: Color| Self::text(color).pos(Pos::new(HPos::Left, VPos::Top));
        for span in self.spans.iter().filter(|span| self.x.contains(&span.x.start)) {
            let place = (span.x.start + right_of, self.y.end - 4.0 * per_pixel);
            chart.draw_series([Text::new(span.label.clone(), place, style(Color::Ink))]).map_err(said)?;
        }
        let line = Color::Notice.placeholder().stroke_width(3);
        for mark in self.marks.iter().filter(|mark| self.x.contains(&mark.x)) {
            let ends = vec![(mark.x, self.y.start), (mark.x, self.y.end - 20.0 * per_pixel)];
            chart.draw_series([PathElement::new(ends, line)]).map_err(said)?;
            let place = (mark.x + right_of, self.y.end - 22.0 * per_pixel);
            chart.draw_series([Text::new(mark.label.clone(), place, style(Color::Notice))]).map_err(said)?;
        }
        Ok(())
    }

    fn draw_bars(&self, area: &Area) -> Drawn {
        let fine = f64::from(Self::FINE);
        let left = fine * f64::from(Self::MARGIN + Self::Y_LABELS);
        let right = fine * f64::from(Self::WIDTH - Self::MARGIN);
        let at = |x: f64| {
            let share = (self.clip_x(x) - self.x.start) / (self.x.end - self.x.start);
            (left + share * (right - left)).round() as i32
        };
        let text = Self::text(Color::Ink).pos(Pos::new(HPos::Right, VPos::Center));
        for (row, (name, segments)) in self.bars.iter().enumerate() {
            let top = fine * Self::BAR * row as f64;
            let (from, to) = ((top + 4.0 * fine) as i32, (top + fine * (Self::BAR - 6.0)) as i32);
            let frame =
                Rectangle::new([(at(self.x.start), from), (at(self.x.end), to)], Color::Grid.placeholder());
            area.draw(&frame).map_err(said)?;
            for segment in segments {
                let corners = [(at(segment.from), from), (at(segment.to), to)];
                area.draw(&Rectangle::new(corners, segment.color.placeholder().filled())).map_err(said)?;
            }
            let place = (left as i32 - 6 * Self::FINE as i32, (from + to) / 2);
            area.draw(&Text::new(name.clone(), place, text.clone())).map_err(said)?;
        }
        Ok(())
    }

    fn clip_x(&self, x: f64) -> f64 {
        x.clamp(self.x.start, self.x.end)
    }
}

/// Decimals that tell the labels of an axis of this length apart.
fn decimals(length: f64) -> usize {
    match length {
        length if length > 8.0 => 0,
        length if length > 0.8 => 1,
        length if length > 0.08 => 2,
        _ => 3,
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
        assert!(!svg.contains("#C010"), "a placeholder is left");
        assert!(svg.ends_with("</svg>\n") || svg.ends_with("</svg>"), "{}", &svg[svg.len() - 20..]);
        let legend = plot().legend();
        assert!(legend.contains("dashes") && legend.contains("var(--first)"), "{legend}");
    }

    #[test]
    fn an_impossible_axis_is_an_error() {
        let error = Plot::new("Slope", "1", 0.0..10.0, 1.0..f64::NAN).svg().unwrap_err();
        assert!(error.to_string().contains("`Slope`"), "{error}");
    }
}
