//! The plots of the page: each channel as measured and as both models say it, where they differ and what was found there,
//! courses of what varied, and where the models err.

use super::{has_extension, tires, words};
use crate::explain::{CourseEstimate, Explanation, Finding, Where};
use crate::pages::axles;
use crate::pages::beside::{Axis, Beside, Channel, Drive, Model, Said, line};
use crate::report::interactive::{Mark, Panel, Plots, Series, Source, Span};
use crate::report::{Color, Page};
use physics::model::effect::Spec;

use words::sentence;

/// Deviations of a 95 % interval.
const NORMAL_95: f64 = 1.96;

/// What the models are called on all plots and tables of the page.
pub fn names(explanation: &Explanation) -> [&'static str; 2] {
    match &explanation.simulation {
        // Then there is no difference of the simulation itself.
        Some(simulated) if simulated.steered_alike == Some(false) => {
            ["car that drives like your simulation", "the same with what was found"]
        }
        Some(_) => ["your simulation", "your simulation with what was found"],
        None => ["plain model", "extended model"],
    }
}

/// Draws them.
pub fn write(page: &mut Page, explanation: &Explanation) {
    let beside = beside(explanation);
    if beside.drives.is_empty() {
        page.paragraph("There is nothing to draw: no stretch of the recordings could be simulated.");
        return;
    }
    let courses = explanation.findings.iter().filter(|finding| finding.series.is_some()).count();
    let plots = beside.plots(3 * courses + 1, |axis, plots| {
        Drawn { explanation, beside: &beside, axis }.write(plots);
    });
    page.plots(&plots);
    let inputs = if explanation.is_by_ordinary {
        "steering wheel and measured speed"
    } else {
        "steering wheel, torques and brakes"
    };
    page.raw(&format!(
        "<p class=\"aside\">Predicted: simulated from the {inputs} alone, without feedback of what is shown. {}</p>",
        plots.reading()
    ));
}

/// Recordings and models as they are drawn.
fn beside(explanation: &Explanation) -> Beside {
    let [plain, extended] = names(explanation);
    let mut models = vec![Model { name: plain, color: Color::Second }];
    if has_extension(explanation) {
        models.push(Model { name: extended, color: Color::First });
    }
    let compared = models.len();
    let ordinary = explanation.ordinary.as_ref().filter(|_| !explanation.is_by_ordinary);
    if ordinary.is_some() {
        models.push(Model { name: "ordinary car", color: Color::Third });
    }
    let drive = |name: &&str| {
        let mut drive = Drive::new(name, &explanation.driven, &explanation.split);
        drive.begins_utc = explanation.begins_utc.get(*name).cloned();
        drive.yaw_rate_offset = yaw_rate_offset(explanation, name);
        for trace in explanation.traces.iter().filter(|trace| trace.recording == **name) {
            let said = |predicted: &Vec<f64>| Said {
                t: trace.t.clone(),
                measured: trace.measured.clone(),
                predicted: predicted.clone(),
            };
            let mut said: Vec<Said> =
                [&trace.baseline, &trace.extended].into_iter().take(compared).map(said).collect();
            let free = ordinary.into_iter().flat_map(|ordinary| &ordinary.traces);
            let own = free.filter(|it| it.recording == **name && it.channel.name() == trace.channel);
            said.extend(own.map(|free| Said::of_rows(&free.rows, 2)));
            let (name, unit) = (trace.channel.clone(), trace.unit.clone());
            drive.channels.push(Channel { name, unit, said });
        }
        drive
    };
    let drives =
        words::recordings(explanation).iter().map(drive).filter(|it| !it.channels.is_empty()).collect();
    let mut beside = Beside { models, drives, error_is: "held-out error", ..Beside::default() };
    beside.disturbances.clone_from(&explanation.disturbances);
    for channel in beside.channels() {
        let of = [&explanation.error.baseline, &explanation.error.extended].into_iter().take(compared);
        let errors = of.map(|of| of.holdout.get(&channel).copied().unwrap_or(f64::NAN)).collect();
        beside.error.insert(channel, errors);
    }
    beside
}

/// As far as it was fitted, rad/s.
fn yaw_rate_offset(explanation: &Explanation, recording: &str) -> f64 {
    let numbers = &explanation.parameters.extended;
    let own =
        numbers.get(&format!("yaw_rate_offset of {recording}")).or_else(|| numbers.get("yaw_rate_offset"));
    own.map_or(0.0, |own| own.value)
}

/// An answer on its time axis.
struct Drawn<'a> {
    explanation: &'a Explanation,
    beside: &'a Beside,
    axis: &'a Axis,
}

impl Drawn<'_> {
    fn write(&self, plots: &mut Plots) {
        plots.panel(self.places());
        for finding in &self.explanation.findings {
            if let Some(course) = &finding.series {
                plots.panel(self.course(finding, course));
            }
        }
        self.sideslip().into_iter().for_each(|panel| plots.panel(panel));
        if let Some(vehicle) = &self.explanation.vehicle {
            let told = axles::gradient(&self.explanation.cornering_stiffness);
            plots.figure(self.beside.handling(self.axis, vehicle, told));
        }
        for figure in tires::figures(self.explanation, |recording, t| self.on_axis(recording, t)) {
            plots.figure(figure);
        }
        for figure in self.explanation.history.iter().flat_map(super::history::figures) {
            plots.figure(figure);
        }
        self.onsets(plots);
    }

    /// The recording that a place is of, by its number.
    fn drive(&self, place: &Where) -> Option<usize> {
        match self.beside.drives.as_slice() {
            [_] if place.recording.is_empty() => Some(0),
            drives => drives.iter().position(|drive| drive.name == place.recording),
        }
    }

    /// A moment of a recording on the page.
    fn on_axis(&self, recording: &str, t: f64) -> Option<f64> {
        let drive = self.beside.drives.iter().position(|drive| drive.name == recording)?;
        Some(self.axis.at(drive, t))
    }

    /// When the plain model differs, and when each finding shows.
    fn places(&self) -> Panel {
        let Explanation { findings, place, .. } = self.explanation;
        let mut panel = Panel::new("Where they differ", "");
        let mut lane = |name: String, color: Color, place: &Where| {
            let Some(drive) = self.drive(place) else { return };
            let spans: Vec<(f64, f64)> = self.axis.on_page(drive, &place.intervals).collect();
            if !spans.is_empty() {
                panel.lanes.push(Span::new(&name, color, &spans));
            }
        };
        let [plain, _] = names(self.explanation);
        lane(format!("where the {plain} differs from the recording"), Color::Second, place);
        for finding in findings {
            // The only finding's place is that of the mismatch: once is enough.
            if findings.len() > 1 || finding.place.intervals != place.intervals {
                lane(format!("where {} shows", name(finding)), Color::First, &finding.place);
            }
        }
        panel.empty = if panel.lanes.is_empty() {
            "No stretch of time stands out: what differs, if anything does, differs everywhere alike.".into()
        } else {
            String::new()
        };
        panel
    }

    /// How something varied, with what is known of it.
    fn course(&self, finding: &Finding, course: &CourseEstimate) -> Panel {
        let (factor, unit) = words::shown_unit(finding.channel.as_deref().unwrap_or(""), &course.unit);
        let name = name(finding);
        let axis = if unit.is_empty() { name.clone() } else { format!("{name}, {unit}") };
        let mut panel = Panel::new(&format!("{}: its course", sentence(&name)), &axis);
        let drive = self.drive(&finding.place);
        let column = |by: f64| {
            let values = course.value.iter().zip(&course.std);
            let values: Vec<f64> = values.map(|(value, std)| factor * (value + by * std)).collect();
            let of = |place| (Some(place) == drive).then_some((course.t.as_slice(), values.as_slice()));
            self.axis.column(&self.beside.drives, |place, _| of(place))
        };
        let grid = &self.axis.grid;
        let (low, high) = (grid.lower(&column(-NORMAL_95)), grid.upper(&column(NORMAL_95)));
        let own = line(self.axis, "as found", Source::Estimated, Color::First, &column(0.0), 1.0);
        // The interval may be wide where nothing is known; the course must stay visible.
        let finite = || own.values.values().iter().copied().filter(|value| value.is_finite());
        let core = (finite().fold(0.0, f64::min), finite().fold(0.0, f64::max));
        let room = core.1 - core.0;
        if room > 0.0 {
            panel.limits = Some((core.0 - room, core.1 + room));
        }
        panel.series.push(Series { interval: Some((low, high)), ..own });
        let recording = &finding.place.recording;
        if self.beside.drives.len() > 1 && !recording.is_empty() {
            panel.caption = format!("Over {recording}.");
        }
        panel
    }

    /// Of the ordinary car's free run.
    fn sideslip(&self) -> Option<Panel> {
        let sideslip = &self.explanation.ordinary.as_ref()?.sideslip;
        let columns: Vec<(&str, Vec<f64>, Vec<f64>)> = sideslip
            .iter()
            .map(|(name, rows)| {
                (
                    name.as_str(),
                    rows.iter().map(|row| row[0]).collect(),
                    rows.iter().map(|row| row[1]).collect(),
                )
            })
            .collect();
        let column = self.axis.column(&self.beside.drives, |_, drive| {
            let (_, t, values) = columns.iter().find(|(name, ..)| *name == drive.name)?;
            Some((t.as_slice(), values.as_slice()))
        });
        let mut panel = Panel::new("Sideslip", "sideslip, °, positive to the left");
        let degrees = 1_f64.to_degrees();
        panel.series.push(line(self.axis, "ordinary car", Source::Predicted, Color::Third, &column, degrees));
        panel.caption = "Of the free run: no sensor measures it.".into();
        Some(panel)
    }

    /// Since when something was so.
    fn onsets(&self, plots: &mut Plots) {
        for finding in &self.explanation.findings {
            let at = finding.parameters.get(Spec::AT_S.name).map(|at| at.value);
            // A moment before the recording: it was there from the start.
            let Some(at) = at.filter(|at| *at >= 0.0) else { continue };
            if let Some(drive) = self.drive(&finding.place) {
                let name = format!("{} from here", name(finding));
                plots.marks.push(Mark { at_s: self.axis.at(drive, at), name });
            }
        }
    }
}

fn name(finding: &Finding) -> String {
    words::effect(&finding.effect, finding.channel.as_deref())
}
