//! A plot as a file of its own: no page around it that would bring colours, title and legend.

use super::{Marker, Plot, PlotError, Stroke, Swatch};
use crate::report::{Color, color, escape};

/// Above the plot, for its title.
const TITLE: f64 = 34.0;
/// A line of the legend.
const ROW: f64 = 22.0;
/// From the edge.
const LEFT: f64 = 12.0;
/// From a swatch's left end to its name.
const SWATCH: f64 = 30.0;

impl Plot {
    /// Draws it as a whole SVG file, in the colours of a light screen.
    ///
    /// # Errors
    /// As [`Plot::svg`].
    pub fn svg_file(&self) -> Result<String, PlotError> {
        let inner = self.svg()?;
        let width = f64::from(Self::WIDTH);
        let (legend, rows) = self.legend_drawn(width);
        let top = TITLE + rows * ROW;
        let inner_height = f64::from(self.height) + Self::BAR.floor() * self.bars.len() as f64;
        let height = top + inner_height;
        let inner = inner.replacen(
            "<svg ",
            &format!("<svg y=\"{top}\" width=\"{width}\" height=\"{inner_height}\" "),
            1,
        );
        Ok(Color::resolve(&format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n\
             <text x=\"{LEFT}\" y=\"23\" font-size=\"17\" font-weight=\"600\" fill=\"var(--ink)\">{}</text>\n\
             {legend}{inner}\n</svg>\n",
            color::value("ground"),
            escape(&self.title),
        )))
    }

    /// The legend, and how many lines it takes.
    fn legend_drawn(&self, width: f64) -> (String, f64) {
        let mut text = String::new();
        let (mut x, mut row) = (LEFT, 0.0);
        for (name, color, swatch) in &self.legend {
            // Nobody here can measure text; the widest common letters take about this.
            let wide = SWATCH + 7.6 * name.chars().count() as f64 + 18.0;
            if x > LEFT && x + wide > width {
                (x, row) = (LEFT, row + 1.0);
            }
            let y = TITLE + row * ROW + 10.0;
            let color = format!("var(--{})", color.name());
            text += &swatch.drawn(x, y, &color);
            text += &format!(
                "<text x=\"{}\" y=\"{}\" font-size=\"14\" fill=\"var(--ink)\">{}</text>\n",
                x + SWATCH,
                y + 5.0,
                escape(name)
            );
            x += wide;
        }
        (text, if self.legend.is_empty() { 0.0 } else { row + 1.0 })
    }
}

impl Swatch {
    fn drawn(self, x: f64, y: f64, color: &str) -> String {
        let middle = x + 11.0;
        match self {
            Self::Line(stroke) => {
                let dashes = match stroke {
                    Stroke::Solid => "",
                    Stroke::Dashed => " stroke-dasharray=\"6 4\"",
                    Stroke::Dotted => " stroke-dasharray=\"1.5 3.5\"",
                };
                format!("<path d=\"M{x} {y}h22\" stroke=\"{color}\" stroke-width=\"2\"{dashes}/>\n")
            }
            Self::Points(Marker::Dot) => {
                format!("<circle cx=\"{middle}\" cy=\"{y}\" r=\"3\" fill=\"{color}\"/>\n")
            }
            Self::Points(Marker::Ring) => {
                format!("<circle cx=\"{middle}\" cy=\"{y}\" r=\"4\" fill=\"none\" stroke=\"{color}\"/>\n")
            }
            Self::Points(Marker::Cross) => format!(
                "<path d=\"M{} {}l8 8m-8 0l8 -8\" stroke=\"{color}\" stroke-width=\"1.5\"/>\n",
                middle - 4.0,
                y - 4.0
            ),
            Self::Band | Self::Block => {
                let opacity = if matches!(self, Self::Band) { 0.4 } else { 1.0 };
                format!(
                    "<rect x=\"{x}\" y=\"{}\" width=\"22\" height=\"12\" fill=\"{color}\" \
                     fill-opacity=\"{opacity}\"/>\n",
                    y - 6.0
                )
            }
        }
    }
}
