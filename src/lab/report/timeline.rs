//! What was when: courses for orientation above, stretches of time below them, one axis for all.

use std::ops::Range;

use super::markup::{escape, open_svg};
use super::{Color, decimate};

/// A course for orientation.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// What it is, with its unit.
    pub name: String,
    /// In order of time.
    pub points: Vec<(f64, f64)>,
}

/// Stretches of time of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What they are.
    pub name: String,
    /// From, to.
    pub stretches: Vec<[f64; 2]>,
    /// Their colour.
    pub color: Color,
}

/// All of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    /// Read out where it cannot be seen.
    pub title: String,
    /// From, to, s.
    pub time: Range<f64>,
    /// What the shaded stretches are.
    pub shade: String,
    /// The shaded stretches.
    pub shaded: Vec<[f64; 2]>,
    /// Above one another.
    pub panels: Vec<Panel>,
    /// Below the panels.
    pub rows: Vec<Row>,
}

const WIDTH: f64 = 960.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 944.0;
/// The line of a name above a panel or row.
const NAME: f64 = 24.0;
const PANEL: f64 = 72.0;
const ROW: f64 = 14.0;
const AXIS: f64 = 44.0;
const GAP: f64 = 10.0;
/// Of the shaded stretches.
const SHADE: Color = Color::Surface(2);
/// At most so many numbers on the axis.
const TICKS: f64 = 12.0;

impl Timeline {
    /// The legend as HTML.
    pub fn legend(&self) -> String {
        format!(
            "<ul class=\"legend\"><li><i class=\"band block\" style=\"color:var(--{})\"></i>{}</li></ul>",
            SHADE.name(),
            escape(&self.shade)
        )
    }

    /// Draws it; nothing if its time has no length.
    pub fn svg(&self) -> String {
        let length = self.time.end - self.time.start;
        if !(length.is_finite() && length > 0.0) {
            return String::new();
        }
        // One without data says so in its line, and takes no more.
        let height = |panel: &Panel| if extent(&panel.points).is_some() { PANEL } else { 0.0 };
        let panels: f64 = self.panels.iter().map(|panel| NAME + height(panel) + GAP).sum();
        let bottom = panels + (NAME + ROW + GAP) * self.rows.len() as f64;
        let mut svg = open_svg(&self.title, WIDTH, bottom + AXIS);
        for [from, to] in &self.shaded {
            svg += &self.block([*from, *to], 0.0, bottom, SHADE);
        }
        let mut top = 0.0;
        for panel in &self.panels {
            let height = height(panel);
            let name =
                if height > 0.0 { panel.name.clone() } else { format!("{}: no value of it", panel.name) };
            svg += &text(LEFT + 4.0, top + 16.0, 14.0, "start", Color::Ink, &name);
            svg += &self.panel(panel, top + NAME);
            top += NAME + height + GAP;
        }
        for row in &self.rows {
            svg += &text(LEFT + 4.0, top + 16.0, 14.0, "start", Color::Ink, &row.name);
            let y = top + NAME;
            svg += &rule(y + 0.5 * ROW);
            for stretch in &row.stretches {
                svg += &self.block(*stretch, y, ROW, row.color);
            }
            top += NAME + ROW + GAP;
        }
        svg + &self.axis(bottom) + "</svg>"
    }

    fn at(&self, t: f64) -> f64 {
        let share = (t - self.time.start) / (self.time.end - self.time.start);
        LEFT + share.clamp(0.0, 1.0) * (RIGHT - LEFT)
    }

    fn block(&self, [from, to]: [f64; 2], y: f64, height: f64, color: Color) -> String {
        if !(from.is_finite() && to.is_finite()) || to < self.time.start || from > self.time.end {
            return String::new();
        }
        format!(
            "<rect x=\"{:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"var(--{})\"/>",
            self.at(from),
            (self.at(to) - self.at(from)).max(2.0),
            color.name()
        )
    }

    fn panel(&self, panel: &Panel, top: f64) -> String {
        let Some((low, high)) = extent(&panel.points) else { return String::new() };
        let step = nice_step((high - low) / 3.0);
        let (low, high) = ((low / step).floor() * step, (high / step).ceil() * step);
        let y = |value: f64| top + (high - value) / (high - low) * PANEL;
        let decimals = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
        // The ends, and zero where it is between them.
        let zero = (low < -0.5 * step && high > 0.5 * step).then_some(0.0);
        let mut svg = String::new();
        for line in [Some(low), zero, Some(high)].into_iter().flatten() {
            svg += &rule(y(line));
            let number = format!("{:.decimals$}", if line == 0.0 { 0.0 } else { line }).replace('-', "−");
            svg += &text(LEFT - 8.0, y(line) + 4.5, 13.0, "end", Color::Muted, &number);
        }
        let inside = panel.points.iter().filter(|point| self.time.contains(&point.0)).copied();
        let column = (self.time.end - self.time.start) / (RIGHT - LEFT);
        for piece in decimate::lines(inside, column) {
            let points: Vec<String> =
                piece.iter().map(|(t, value)| format!("{:.1},{:.1}", self.at(*t), y(*value))).collect();
            svg += &format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"var(--{})\" stroke-width=\"1.3\" \
                 stroke-linejoin=\"round\"/>",
                points.join(" "),
                Color::Muted.name()
            );
        }
        svg
    }

    fn axis(&self, y: f64) -> String {
        let color = Color::Muted.name();
        let mut svg = format!("<path d=\"M{LEFT} {y}H{RIGHT}\" stroke=\"var(--{color})\"/>");
        let step = nice_step((self.time.end - self.time.start) / TICKS);
        let decimals = (-step.log10().floor()).clamp(0.0, 3.0) as usize;
        let first = (self.time.start / step).ceil();
        for count in 0..=(TICKS as u32 + 1) {
            let t = (first + f64::from(count)) * step;
            if t > self.time.end + 1e-9 {
                break;
            }
            svg += &format!("<path d=\"M{:.1} {y}v5\" stroke=\"var(--{color})\"/>", self.at(t));
            svg += &text(self.at(t), y + 19.0, 13.0, "middle", Color::Muted, &format!("{t:.decimals$}"));
        }
        svg + &text(0.5 * (LEFT + RIGHT), y + 38.0, 14.0, "middle", Color::Ink, "time, s")
    }
}

fn rule(y: f64) -> String {
    format!("<path d=\"M{LEFT} {y:.1}H{RIGHT}\" stroke=\"var(--grid)\" stroke-width=\"0.7\"/>")
}

fn text(x: f64, y: f64, size: f64, anchor: &str, color: Color, text: &str) -> String {
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"var(--{})\">{}</text>",
        color.name(),
        escape(text)
    )
}

/// The lowest and the highest value, apart from each other.
fn extent(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let values = || points.iter().map(|point| point.1).filter(|value| value.is_finite());
    let (low, high) = (values().reduce(f64::min)?, values().reduce(f64::max)?);
    let apart = 1e-9 + 1e-3 * high.abs();
    Some(if high - low > apart { (low, high) } else { (low - apart, high + apart) })
}

/// The next of 1, 2, 5, 10, 20, … that is not smaller.
fn nice_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0].into_iter().map(|factor| factor * power).find(|step| *step >= least);
    step.unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timeline() -> Timeline {
        Timeline {
            title: "a & b".into(),
            time: 0.0..100.0,
            shade: "held <out>".into(),
            shaded: vec![[20.0, 40.0], [f64::NAN, 50.0]],
            panels: vec![
                Panel {
                    name: "speed, km/h".into(),
                    points: (0..1000).map(|i| (f64::from(i) * 0.1, f64::from(i % 50))).collect(),
                },
                Panel { name: "nothing".into(), points: vec![(0.0, f64::NAN)] },
            ],
            rows: vec![Row {
                name: "x < y".into(),
                stretches: vec![[50.0, 60.0], [99.99, 1e6]],
                color: Color::Notice,
            }],
        }
    }

    #[test]
    fn everything_is_where_it_was() {
        let svg = timeline().svg();
        assert!(svg.contains("<rect x=\"240.0\" y=\"0.0\" width=\"176.0\""), "20 to 40 s: {svg}");
        assert!(svg.contains("<rect x=\"504.0\" y=\"164.0\" width=\"88.0\" height=\"14.0\""), "{svg}");
        assert!(svg.contains("width=\"2.0\""), "what is short can still be seen");
        assert!(svg.contains("x &lt; y") && svg.contains("a &amp; b") && !svg.contains("NaN"));
        assert!(svg.contains("nothing: no value of it"), "a panel without points says so");
        assert!(timeline().legend().contains("held &lt;out&gt;"));
    }

    #[test]
    fn without_time_there_is_nothing() {
        assert_eq!(Timeline { time: 5.0..5.0, ..timeline() }.svg(), "");
        assert_eq!(Timeline { time: 0.0..f64::NAN, ..timeline() }.svg(), "");
    }

    #[test]
    fn steps_are_round() {
        assert_eq!([0.7, 3.0, 9.0, 10.0, 301.0].map(nice_step), [1.0, 5.0, 10.0, 10.0, 500.0]);
    }
}
