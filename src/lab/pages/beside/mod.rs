//! Measured beside what models predict, as `explain` and `identify` draw it: over time, over speed and lateral
//! acceleration, and along the track.

mod axis;
mod figures;
mod panels;

pub use axis::Axis;
pub use panels::line;

use std::collections::BTreeMap;

use super::explain::words;
use crate::explain::{Block, Disturbance, Driven};
use crate::report::interactive::Plots;
use crate::report::{Color, Fact};

/// Whose errors are looked at closely.
const MAIN: [&str; 2] = ["yaw_rate", "lateral_acceleration"];
/// The errors of so many models are mapped.
const MAPPED: usize = 2;

/// One of the models.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// What it is called.
    pub name: &'static str,
    /// Its colour on every plot.
    pub color: Color,
}

/// What a model says of a channel, SI.
#[derive(Clone, Debug, Default)]
pub struct Said {
    /// Times, s from the recording's start.
    pub t: Vec<f64>,
    /// What was measured then, as the model is compared with it.
    pub measured: Vec<f64>,
    /// What the model says.
    pub predicted: Vec<f64>,
}

impl Said {
    /// Of rows: time, measured, and at this place predicted.
    pub fn of_rows(rows: &[[f64; 4]], predicted: usize) -> Self {
        let column = |place: usize| rows.iter().map(|row| row[place]).collect();
        Self { t: column(0), measured: column(1), predicted: column(predicted) }
    }
}

/// One quantity of a recording.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Its name in the configuration.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// By model; empty where that says nothing of it.
    pub said: Vec<Said>,
}

/// A recording.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    /// The recording.
    pub name: String,
    /// When it begins, in UTC, where its stamps are dates.
    pub begins_utc: Option<String>,
    /// What is compared.
    pub channels: Vec<Channel>,
    /// Time, s; speed, m/s; steering wheel angle, rad.
    pub driven: Vec<[f64; 3]>,
    /// Stretches that nothing was fitted to, s.
    pub held_out: Vec<[f64; 2]>,
    /// Zero of the yaw rate's sensor, rad/s, as far as it is known.
    pub yaw_rate_offset: f64,
}

/// Recordings and models.
#[derive(Clone, Debug, Default)]
pub struct Beside {
    /// The plainest one first.
    pub models: Vec<Model>,
    /// Recordings, in the order in which they stand behind each other.
    pub drives: Vec<Drive>,
    /// Root mean square error of the first models, SI, by channel …
    pub error: BTreeMap<String, Vec<f64>>,
    /// … and what error that is.
    pub error_is: &'static str,
    /// What the best model leaves, by channel.
    pub disturbances: BTreeMap<String, Disturbance>,
}

impl Beside {
    /// Names of all channels in the order in which one asks for them.
    pub fn channels(&self) -> Vec<String> {
        let names = self.drives.iter().flat_map(|drive| &drive.channels).map(|channel| &channel.name);
        words::in_order(names).into_iter().map(str::to_owned).collect()
    }

    /// The plots of all recordings, as far as they are alike everywhere; of what else is drawn there are so many lines. `more`
    /// draws it, between the main channels and the others.
    pub fn plots(&self, lines: usize, more: impl FnOnce(&Axis, &mut Plots)) -> Plots {
        let axis = Axis::new(self, self.lines() + lines);
        let mut plots = axis.plots(self);
        let (main, others): (Vec<String>, Vec<String>) =
            self.channels().into_iter().partition(|channel| MAIN.contains(&channel.as_str()));
        for channel in &main {
            self.channel(&axis, channel).into_iter().for_each(|panel| plots.panel(panel));
        }
        more(&axis, &mut plots);
        self.driven(&axis).into_iter().for_each(|panel| plots.panel(panel));
        for channel in &others {
            self.channel(&axis, channel).into_iter().for_each(|panel| plots.panel(panel));
        }
        for channel in &main {
            for model in 0..self.models.len().min(MAPPED) {
                plots.figure(self.map(&axis, channel, model));
            }
        }
        if let Some(channel) = main.first() {
            plots.figure(self.track(&axis, channel, 0));
        }
        plots
    }

    /// The errors as numbers at the head of a page.
    pub fn facts(&self) -> Vec<Fact> {
        let fact = |channel: &&str| {
            let names: Vec<&str> = self.models.iter().map(|model| model.name).collect();
            Some(Fact {
                name: format!("{}, {}", words::sentence(self.error_is), words::channel(channel)),
                value: self.told(channel)?,
                note: format!("root mean square; {}", names.join(" → ")),
            })
        };
        MAIN.iter().filter_map(fact).collect()
    }

    /// The unit that a channel is shown in, and what an SI unit is in it.
    fn shown(&self, channel: &str) -> (f64, String) {
        let own = self.drives.iter().flat_map(|drive| &drive.channels).find(|it| it.name == channel);
        words::shown_unit(channel, own.map_or("", |it| it.unit.as_str()))
    }

    /// The error of each model, in words: "0.62 → 0.11 °/s"; nothing where it is not known.
    pub fn told(&self, channel: &str) -> Option<String> {
        let (factor, unit) = self.shown(channel);
        told(self.error.get(channel)?, (factor, &unit))
    }
}

/// Errors one after the other, SI, in the unit that they are shown in.
pub fn told(errors: &[f64], (factor, unit): (f64, &str)) -> Option<String> {
    let mut all: Vec<String> =
        errors.iter().filter(|it| it.is_finite()).map(|it| words::three(factor * it)).collect();
    all.dedup();
    (!all.is_empty()).then(|| words::with_unit(&all.join(" → "), unit))
}

impl Drive {
    /// How it was driven, and what of it was held out.
    pub fn new(name: &str, driven: &[Driven], split: &[Block]) -> Self {
        let own = driven.iter().find(|it| it.recording == name);
        let held_out = split.iter().filter(|block| block.is_holdout && block.recording == name);
        Self {
            name: name.into(),
            driven: own.map_or_else(Vec::new, |own| own.rows.clone()),
            held_out: held_out.map(|block| block.t).collect(),
            ..Self::default()
        }
    }

    /// What a model says of a channel; nothing where it says nothing.
    fn said(&self, channel: &str, model: usize) -> Option<&Said> {
        let own = self.channels.iter().find(|it| it.name == channel)?;
        own.said.get(model).filter(|said| !said.t.is_empty())
    }

    /// What was measured of a channel: as the first model that says something is compared with it.
    fn measured(&self, channel: &str) -> Option<(&[f64], &[f64])> {
        let own = self.channels.iter().find(|it| it.name == channel)?;
        let said = own.said.iter().find(|said| !said.t.is_empty())?;
        Some((&said.t, &said.measured))
    }
}
