//! Colours by what they mean.

use plotters::style::RGBColor;

use super::Stroke;

const STYLE: &str = include_str!("page.css");

/// What a colour stands for; on all plots of all pages it is the same. The page's style sheet says
/// which colour that is, on a light and on a dark screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Color {
    /// Text.
    Ink,
    /// Axes and small text.
    Muted,
    /// Lines of the grid.
    Grid,
    /// What is true.
    Truth,
    /// What is true in another sense; drawn dashed.
    OtherTruth,
    /// The first estimate: left, front, or the only one.
    First,
    /// The second estimate: right or rear.
    Second,
    /// A third one, to compare with.
    Third,
    /// Something was noticed.
    Notice,
    /// Surfaces in the background, in the order in which they come.
    Surface(u8),
}

impl Color {
    /// Surfaces that have a colour of their own; then they begin again.
    pub const SURFACES: u8 = 5;

    const ALL: [Self; 14] = [
        Self::Ink,
        Self::Muted,
        Self::Grid,
        Self::Truth,
        Self::OtherTruth,
        Self::First,
        Self::Second,
        Self::Third,
        Self::Notice,
        Self::Surface(0),
        Self::Surface(1),
        Self::Surface(2),
        Self::Surface(3),
        Self::Surface(4),
    ];

    /// The name of the CSS variable, without its dashes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ink => "ink",
            Self::Muted => "muted",
            Self::Grid => "grid",
            Self::Truth => "truth",
            Self::OtherTruth => "truth-2",
            Self::First => "first",
            Self::Second => "second",
            Self::Third => "third",
            Self::Notice => "notice",
            Self::Surface(number) => ["surface-0", "surface-1", "surface-2", "surface-3", "surface-4"]
                [usize::from(number % Self::SURFACES)],
        }
    }

    /// What it is drawn with, before [`Color::substitute`] puts the variable in its place.
    pub(super) fn placeholder(self) -> RGBColor {
        self.stroked(Stroke::Solid)
    }

    /// The placeholder of a line in this style.
    pub(super) fn stroked(self, stroke: Stroke) -> RGBColor {
        let number = match self {
            Self::Surface(number) => Self::Surface(number % Self::SURFACES),
            other => other,
        };
        let index = Self::ALL.iter().position(|color| *color == number).unwrap_or(0);
        RGBColor(0xC0, 0x10 + stroke as u8, index as u8)
    }

    /// Variables for placeholders.
    pub(super) fn substitute(svg: &str) -> String {
        let mut svg = svg.to_owned();
        for color in Self::ALL {
            let variable = format!("\"var(--{})\"", color.name());
            for stroke in Stroke::ALL {
                let RGBColor(red, green, blue) = color.stroked(stroke);
                let drawn = format!("\"#{red:02X}{green:02X}{blue:02X}\"");
                let dashes =
                    stroke.dashes().map_or(String::new(), |it| format!(" stroke-dasharray=\"{it}\""));
                svg = svg
                    .replace(&format!("stroke={drawn}"), &format!("stroke={variable}{dashes}"))
                    .replace(&drawn, &variable);
            }
        }
        svg
    }

    /// The colours of a light screen for variables: for a picture that has no page around it.
    pub(super) fn resolve(svg: &str) -> String {
        Self::ALL.iter().fold(svg.to_owned(), |svg, color| {
            svg.replace(&format!("var(--{})", color.name()), value(color.name()))
        })
    }
}

/// What the style sheet says of a variable first, which is its value on a light screen.
pub(super) fn value(variable: &str) -> &'static str {
    let value = STYLE.split_once(&format!("--{variable}: ")).and_then(|(_, rest)| rest.split_once(';'));
    value.map_or("currentColor", |(value, _)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_color_has_a_placeholder_of_its_own_and_is_in_the_style_sheet_twice() {
        for (index, color) in Color::ALL.iter().enumerate() {
            assert!(Color::ALL.iter().skip(index + 1).all(|c| c.placeholder() != color.placeholder()));
            assert_eq!(
                STYLE.matches(&format!("--{}:", color.name())).count(),
                2,
                "{color:?}: light and dark"
            );
        }
        assert!(Color::ALL.iter().all(|color| value(color.name()).starts_with('#')));
        assert_eq!(Color::Surface(7).name(), "surface-2");
        assert_eq!(Color::Surface(7).placeholder(), Color::Surface(2).placeholder());
    }
}
