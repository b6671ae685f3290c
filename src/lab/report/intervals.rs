//! Intervals below one another, before and after something was learnt; each on a scale of its own.

use super::Color;
use super::markup::{escape, open_svg};

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval {
    /// What it is, with its unit.
    pub name: String,
    /// From, value, to: before.
    pub before: Option<[f64; 3]>,
    /// From, value, to: after.
    pub after: Option<[f64; 3]>,
    /// The same in words, at the end of the row.
    pub text: String,
}

const WIDTH: f64 = 960.0;
const ROW: f64 = 34.0;
/// The scale's place.
const LEFT: f64 = 340.0;
const RIGHT: f64 = 690.0;

/// Draws rows; `title` is read out where it cannot be seen.
pub fn svg(title: &str, rows: &[Interval]) -> String {
    let mut svg = open_svg(title, WIDTH, ROW * rows.len() as f64);
    for (place, row) in rows.iter().enumerate() {
        svg += &row.svg(ROW * (place as f64 + 0.5));
    }
    svg + "</svg>"
}

/// The legend as HTML.
pub fn legend(before: &str, after: &str) -> String {
    format!(
        "<ul class=\"legend\"><li><i class=\"band block\" style=\"color:var(--{})\"></i>{}</li>\
         <li><i class=\"line\" style=\"color:var(--{})\"></i>{}</li></ul>",
        Color::Grid.name(),
        escape(before),
        Color::First.name(),
        escape(after)
    )
}

impl Interval {
    /// With its middle at this height.
    fn svg(&self, y: f64) -> String {
        let label = |x: f64, anchor: &str, size: f64, color: Color, text: &str| {
            format!(
                "<text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"var(--{})\">{}\
                 </text>",
                y + 0.36 * size,
                color.name(),
                escape(text)
            )
        };
        let rect = |from: f64, to: f64, half: f64, color: Color| {
            format!(
                "<rect x=\"{from:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"var(--{})\"/>",
                y - half,
                (to - from).max(1.5),
                2.0 * half,
                color.name()
            )
        };
        let mut svg = label(0.0, "start", 15.0, Color::Ink, &self.name);
        svg += &label(RIGHT + 58.0, "start", 14.0, Color::Ink, &self.text);
        let Some((low, high)) = self.scale() else { return svg };
        let at = |x: f64| LEFT + (x - low) / (high - low) * (RIGHT - LEFT);
        if let Some([from, value, to]) = self.before {
            svg += &rect(at(from), at(to), 9.0, Color::Grid);
            svg += &rect(at(value) - 0.75, at(value) + 0.75, 9.0, Color::Muted);
            svg += &label(at(from) - 5.0, "end", 12.0, Color::Muted, &short(from));
            svg += &label(at(to) + 5.0, "start", 12.0, Color::Muted, &short(to));
        }
        if let Some([from, value, to]) = self.after {
            svg += &rect(at(from), at(to), 2.0, Color::First);
            svg += &format!(
                "<circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"var(--{})\"/>",
                at(value),
                Color::First.name()
            );
        }
        svg
    }

    fn scale(&self) -> Option<(f64, f64)> {
        let ends = || self.before.iter().chain(&self.after).flatten().filter(|x| x.is_finite());
        let low = ends().copied().fold(f64::INFINITY, f64::min);
        let high = ends().copied().fold(f64::NEG_INFINITY, f64::max);
        (low < high).then_some((low, high))
    }
}

/// Three significant digits.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(after: Option<[f64; 3]>) -> Interval {
        let before = Some([15.0, 35.0, 55.0]);
        Interval { name: "stiffness & co".into(), before, after, text: "50 ± 1".into() }
    }

    #[test]
    fn each_row_fills_its_own_scale() {
        let svg = svg("title", &[row(Some([48.0, 50.0, 52.0])), row(Some([55.0, 75.0, 95.0]))]);
        assert!(svg.contains("stiffness &amp; co") && svg.contains("50 ± 1"));
        // 50 is seven eighths of the way from 15 to 55; 95 the end of the second row's scale.
        assert!(svg.contains("<circle cx=\"646.2\" cy=\"17.0\""), "{svg}");
        assert!(svg.contains("<circle cx=\"602.5\" cy=\"51.0\""), "{svg}");
    }

    #[test]
    fn nothing_learnt_draws_no_dot() {
        assert!(!svg("title", &[row(None)]).contains("circle"));
        let nothing = Interval { before: None, ..row(None) };
        assert!(!svg("title", &[nothing]).contains("rect"));
    }
}
