//! Numbers below one another, each with its interval before and after something was learnt, each on a
//! scale of its own.

use super::Color;
use super::markup::{escape, open_svg};

/// One number.
#[derive(Clone, Debug, PartialEq)]
pub struct Shift {
    /// What it is.
    pub name: String,
    /// Its unit; empty for ratios.
    pub unit: String,
    /// From, value, to: before.
    pub before: Option<[f64; 3]>,
    /// From, value, to: after.
    pub after: Option<[f64; 3]>,
    /// Before, in words.
    pub before_text: String,
    /// After, in words.
    pub after_text: String,
}

/// Before and after on all plots with simulations: the second and the first estimate.
const BEFORE: Color = Color::Second;
const AFTER: Color = Color::First;

const WIDTH: f64 = 960.0;
const ROW: f64 = 50.0;
/// The scale's place.
const LEFT: f64 = 330.0;
const RIGHT: f64 = 750.0;
/// From the row's middle to each of its two lanes.
const LANE: f64 = 9.0;

/// Draws rows; `title` is read out where it cannot be seen.
pub fn svg(title: &str, rows: &[Shift]) -> String {
    let mut svg = open_svg(title, WIDTH, ROW * rows.len() as f64);
    for (place, row) in rows.iter().enumerate() {
        let top = ROW * place as f64;
        if place > 0 {
            svg += &format!("<path d=\"M0 {top}H{WIDTH}\" stroke=\"var(--grid)\" stroke-width=\"0.7\"/>");
        }
        svg += &row.svg(top + 0.5 * ROW);
    }
    svg + "</svg>"
}

/// The legend as HTML.
pub fn legend(before: &str, after: &str) -> String {
    let entry = |name: &str, color: Color, ring: &str| {
        let color = color.name();
        format!("<li><i class=\"dot{ring}\" style=\"color:var(--{color})\"></i>{}</li>", escape(name))
    };
    format!("<ul class=\"legend\">{}{}</ul>", entry(before, BEFORE, " ring"), entry(after, AFTER, ""))
}

impl Shift {
    /// With its middle at this height.
    fn svg(&self, y: f64) -> String {
        let label = |x: f64, y: f64, size: f64, color: Color, text: &str| {
            format!(
                "<text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"{size}\" fill=\"var(--{})\">{}</text>",
                y + 0.36 * size,
                color.name(),
                escape(text)
            )
        };
        let has_unit = !self.unit.is_empty();
        let mut svg = label(0.0, if has_unit { y - LANE } else { y }, 16.0, Color::Ink, &self.name);
        if has_unit {
            svg += &label(0.0, y + LANE + 1.0, 13.0, Color::Muted, &self.unit);
        }
        svg += &label(RIGHT + 24.0, y - LANE, 15.0, BEFORE, &self.before_text);
        svg += &label(RIGHT + 24.0, y + LANE, 15.0, AFTER, &self.after_text);
        let Some((low, high)) = self.scale() else { return svg };
        let at = |x: f64| LEFT + 8.0 + (x - low) / (high - low) * (RIGHT - LEFT - 16.0);
        for (interval, color, y) in [(self.before, BEFORE, y - LANE), (self.after, AFTER, y + LANE)] {
            let Some([from, value, to]) = interval.filter(|it| it.iter().all(|x| x.is_finite())) else {
                continue;
            };
            // A ring and a disc: told apart without colour, too.
            let fill = if color == BEFORE { "ground" } else { color.name() };
            let color = color.name();
            svg += &format!(
                "<path d=\"M{:.1} {y:.1}H{:.1}\" stroke=\"var(--{color})\" stroke-width=\"3\"/>\
                 <circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"var(--{fill})\" stroke=\"var(--{color})\" \
                 stroke-width=\"2\"/>",
                at(from),
                at(to),
                at(value)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn row(after: Option<[f64; 3]>) -> Shift {
        Shift {
            name: "stiffness & co".into(),
            unit: "1/rad".into(),
            before: Some([10.0, 20.0, 30.0]),
            after,
            before_text: "20 ± 5".into(),
            after_text: "45 ± 2".into(),
        }
    }

    #[test]
    fn both_lanes_share_the_rows_scale() {
        let svg = svg("title", &[row(Some([40.0, 45.0, 50.0]))]);
        assert!(svg.contains("stiffness &amp; co") && svg.contains("1/rad"), "{svg}");
        // 20 is a quarter, 45 seven eighths of the way from 10 to 50, in lanes 9 above and below 25.
        assert!(svg.contains("<circle cx=\"439.0\" cy=\"16.0\""), "{svg}");
        assert!(svg.contains("<circle cx=\"691.5\" cy=\"34.0\""), "{svg}");
    }

    #[test]
    fn what_is_not_known_is_not_drawn() {
        assert_eq!(svg("title", &[row(None)]).matches("<circle").count(), 1);
        assert_eq!(svg("title", &[row(Some([f64::NAN; 3]))]).matches("<circle").count(), 1);
        let svg = svg("title", &[Shift { before: None, ..row(None) }]);
        assert!(!svg.contains("circle") && !svg.contains("NaN"));
    }
}
