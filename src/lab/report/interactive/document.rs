//! Everything that a page is made of.

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
}

/// A moment worth a line through all panels.
#[derive(Clone, Debug, Serialize)]
pub struct Mark {
    /// When, s.
    pub at_s: f64,
    /// What was then.
    pub name: String,
}

/// A number at the head of the page.
#[derive(Clone, Debug)]
pub struct Fact {
    /// What it is.
    pub name: String,
    /// With its unit.
    pub value: String,
    /// What there is to say of it.
    pub note: String,
}

/// A page in the making.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Document {
    /// The page's heading.
    pub title: String,
    /// In a sentence or two what it is about.
    #[serde(skip)]
    pub lead: String,
    /// Numbers at its head.
    #[serde(skip)]
    pub facts: Vec<Fact>,
    /// What has to be known to read it, at its end.
    #[serde(skip)]
    pub notes: Vec<String>,
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
}

impl Document {
    /// Adds a panel. One without data says so.
    pub fn panel(&mut self, mut panel: Panel) {
        if panel.is_empty() && panel.empty.is_empty() {
            panel.empty = "There is no value of it in this recording.".into();
        }
        self.panels.push(panel);
    }

    /// Adds a figure. One without data says so.
    pub fn figure(&mut self, mut figure: Figure) {
        if figure.is_empty() && figure.empty.is_empty() {
            figure.empty = "There is no value of it in this recording.".into();
        }
        self.figures.push(figure);
    }
}
