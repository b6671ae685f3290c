//! The plot itself: axes, background, series, labels.

use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Area, Chart, Drawn, Marker, Plot, Series, said};
use crate::report::{Color, decimate};

impl Plot {
    pub(super) fn text(color: Color) -> TextStyle<'static> {
        ("sans-serif", Self::FINE * Self::SMALL).into_font().color(&color.placeholder())
    }

    /// Of one pixel column, in x.
    fn column(&self) -> f64 {
        (self.x.end - self.x.start) / f64::from(Self::WIDTH - Self::Y_LABELS - Self::MARGIN - Self::RIGHT)
    }

    pub(super) fn draw_chart(&self, area: &Area) -> Drawn {
        let mut chart = ChartBuilder::on(area)
            .margin(Self::FINE * Self::MARGIN)
            .margin_right(Self::FINE * Self::RIGHT)
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
        let decimals_of = |axis: &std::ops::Range<f64>| decimals(axis.end - axis.start);
        let (x_decimals, y_decimals) = (decimals_of(&self.x), decimals_of(&self.y));
        let (label, description) = (Self::text(Color::Muted), Self::text(Color::Ink));
        chart
            .configure_mesh()
            .disable_x_mesh()
            .bold_line_style(Color::Grid.placeholder().stroke_width(Self::FINE))
            .light_line_style(TRANSPARENT)
            .axis_style(Color::Muted.placeholder().stroke_width(Self::FINE))
            .x_labels(13)
            .y_labels((self.height / 42).clamp(3, 9) as usize)
            .x_label_formatter(&|x| format!("{:.*}", x_decimals, if x.abs() < 1e-9 { 0.0 } else { *x }))
            .y_label_formatter(&|y| format!("{:.*}", y_decimals, if y.abs() < 1e-9 { 0.0 } else { *y }))
            .label_style(label)
            .axis_desc_style(description)
            .x_desc(self.x_label.as_str())
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
            Series::Line(color, stroke, points) => {
                let inside = points.iter().filter(|point| self.x.contains(&point.0)).copied();
                let width = if *color == Color::OtherTruth { 2 } else { 3 };
                let style = color.stroked(*stroke).stroke_width(width);
                for piece in decimate::lines(inside, self.column()) {
                    let piece = piece.into_iter().map(|(x, y)| (x, clip(y)));
                    chart.draw_series(LineSeries::new(piece, style)).map_err(said)?;
                }
            }
            Series::Curve(color, stroke, points) => {
                let style = color.stroked(*stroke).stroke_width(3);
                for piece in self.inside(points) {
                    chart.draw_series(LineSeries::new(piece, style)).map_err(said)?;
                }
            }
            Series::Points(color, marker, points) => {
                let (color, inside) =
                    (color.placeholder(), points.iter().filter(|point| self.shows(point)).copied());
                match marker {
                    Marker::Dot => chart.draw_series(inside.map(|at| Circle::new(at, 5, color.filled()))),
                    Marker::Ring => {
                        chart.draw_series(inside.map(|at| Circle::new(at, 7, color.stroke_width(2))))
                    }
                    Marker::Cross => {
                        chart.draw_series(inside.map(|at| Cross::new(at, 7, color.stroke_width(3))))
                    }
                }
                .map_err(said)?;
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

    fn shows(&self, (x, y): &(f64, f64)) -> bool {
        (self.x.start..=self.x.end).contains(x) && (self.y.start..=self.y.end).contains(y)
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
}

/// Decimals that tell the labels of an axis of this length apart.
fn decimals(length: f64) -> usize {
    match length {
        length if length > 8.0 => 0,
        length if length > 0.8 => 1,
        length if length > 0.08 => 2,
        length if length > 0.008 => 3,
        _ => 4,
    }
}
