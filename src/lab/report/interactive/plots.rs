//! Everything that the plots of a page are made of.

use serde::Serialize;

use super::{Figure, Numbers, Panel};

/// A recording begins here, or a clock jumps.
#[derive(Clone, Debug, Serialize)]
pub struct Clock {
    /// Place on the page's time axis, s.
    pub from_s: f64,
    /// What the recording's clock says there, s since 1970 in UTC; `None` where it is no wall clock.
    pub utc_s: Option<f64>,
    /// The recording.
    pub name: String,
    /// What the recording's own seconds are there, where these are told; else they are the page's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_s: Option<f64>,
}

/// A moment worth a line through all panels.
#[derive(Clone, Debug, Serialize)]
pub struct Mark {
    /// When, s.
    pub at_s: f64,
    /// What was then.
    pub name: String,
}

/// Plots in the making.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Plots {
    /// Which clocks the time axis stands for.
    pub clocks: Vec<Clock>,
    /// Moments.
    pub marks: Vec<Mark>,
    /// The time axis of all panels, s.
    pub times: Numbers,
    /// Only the extremes of stretches of this length are kept, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stretch_s: Option<f64>,
    /// Lines over time, from top to bottom.
    pub panels: Vec<Panel>,
    /// One quantity over another.
    pub figures: Vec<Figure>,
    /// On a screen without room for both beside each other the panels come first.
    #[serde(skip)]
    pub panels_first: bool,
}

const NOTHING: &str = "There is no value of it in this recording.";

impl Plots {
    /// Adds a panel. One without data says so.
    pub fn panel(&mut self, mut panel: Panel) {
        if panel.is_empty() && panel.empty.is_empty() {
            panel.empty = NOTHING.into();
        }
        self.panels.push(panel);
    }

    /// How to use them, in a sentence or two.
    pub fn reading(&self) -> String {
        let mut text =
            "Drag over a plot to zoom: all show the same time. A double click shows all again.".to_owned();
        if let Some(stretch) = self.stretch_s {
            text += &format!(
                " Of each {stretch:.2} s there are the lowest and the highest value of every line: no peak is lost."
            );
        }
        text
    }

    /// Adds a figure. One without data says so.
    pub fn figure(&mut self, mut figure: Figure) {
        if figure.is_empty() && figure.empty.is_empty() {
            figure.empty = NOTHING.into();
        }
        self.figures.push(figure);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Color;
    use crate::report::interactive::{Series, Source};

    #[test]
    fn a_panel_without_data_says_so() {
        let mut plots = Plots::default();
        plots.panel(Panel::new("Speed", "speed, km/h"));
        let values = Numbers::new(vec![1.0]);
        let series = Series {
            name: "s".into(),
            source: Source::Measured,
            color: Color::First,
            values,
            interval: None,
        };
        plots.panel(Panel { series: vec![series.clone()], ..Panel::new("Yaw", "yaw rate, °/s") });
        // A column without a number, its interval likewise.
        let none = || Numbers::new(vec![f64::NAN; 3]);
        let unknown = Series { values: none(), interval: Some((none(), none())), ..series };
        plots.panel(Panel { series: vec![unknown], ..Panel::new("Stiffness", "1/rad") });
        let says_so: Vec<bool> = plots.panels.iter().map(|panel| !panel.empty.is_empty()).collect();
        assert_eq!(says_so, [true, false, true]);
    }
}
