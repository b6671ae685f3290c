//! The demo's page.

use std::ops::Range;

use super::findings::{Change, Findings, Quality, Surface, at, driven};
use super::recorder::Row;
use super::terminal::percent;
use crate::Wheel;
use crate::model::{Scenario, Truth};
use crate::report::{Color, Mark, Page, Plot, PlotError, Segment, Span, number};

/// Everything the page is made of.
pub struct Story<'a> {
    pub scenario: &'a Scenario,
    pub seed: u64,
    pub truth: &'a [Truth],
    pub rows: &'a [Row],
    pub findings: &'a Findings,
}

impl Story<'_> {
    /// The page.
    pub fn html(&self) -> Result<String, PlotError> {
        let mut page =
            Page::new("gripd demo: tire stiffness and friction from a car's CAN bus", &self.lead());
        self.slope(&mut page)?;
        page.heading("What was found on each surface");
        page.table(&self.surface_columns(), &self.surface_rows());
        self.friction(&mut page)?;
        self.lateral(&mut page)?;
        self.cornering(&mut page)?;
        self.offset(&mut page)?;
        self.inputs(&mut page)?;
        page.heading("How good the published numbers were");
        page.table(
            &["over the whole drive", "valid", "truth in the 95 % interval", "mean error", "rms error"],
            &self.findings.quality.iter().map(quality_row).collect::<Vec<_>>(),
        );
        page.heading("How to read this");
        page.notes(NOTES);
        page.paragraph(&format!("Seed {}: the same seed draws the same page.", self.seed));
        Ok(page.html())
    }

    /// What was driven and what was found, in one sentence.
    fn lead(&self) -> String {
        let names: Vec<&str> = self.findings.surfaces.iter().map(|surface| surface.name.as_str()).collect();
        let noticed: Vec<String> = self.findings.changes.iter().map(noticed).collect();
        let mut text = format!("{:.0} s of simulated driving on {}.", self.scenario.duration_s, list(&names));
        if !noticed.is_empty() {
            let noticed: Vec<&str> = noticed.iter().map(String::as_str).collect();
            text += &format!(" gripd, reading only the car's CAN frames, noticed {}", list(&noticed));
            text += &match self.findings.false_notices() {
                0 => String::from("; it raised no false alarm."),
                1 => String::from("; it raised one false alarm."),
                count => format!("; it raised {count} false alarms."),
            };
        }
        let wheel = self.first_wheel() as usize;
        let slopes: Vec<(String, String)> = self
            .findings
            .surfaces
            .iter()
            .filter_map(|surface| {
                let round = &self.last_valid(surface, |row| row.round.slope_valid)?.round;
                let truth = self.findings.in_use.get(at(self.truth, round.time)?)?;
                Some((number(round.slope[wheel], 0), number(truth.slope[wheel], 0)))
            })
            .collect();
        if !slopes.is_empty() {
            let (found, true_): (Vec<&str>, Vec<&str>) =
                slopes.iter().map(|(a, b)| (a.as_str(), b.as_str())).unzip();
            text += &format!(" Slip slope found: {}; true in use: {}.", list(&found), list(&true_));
        }
        for surface in &self.findings.surfaces {
            if let Some(row) = self.last_valid(surface, |row| row.round.mu_valid)
                && let Some(truth) = at(self.truth, row.round.time).and_then(|index| self.truth.get(index))
            {
                let (found, true_) = (self.friction_found(surface), number(truth.mu_max, 2));
                text += &format!(" Friction found on {}: {found}; true: {true_}.", surface.name);
            }
        }
        text
    }

    fn first_wheel(&self) -> Wheel {
        driven(&self.scenario.vehicle).first().copied().unwrap_or(Wheel::Fl)
    }

    fn time(&self) -> Range<f64> {
        0.0..self.scenario.duration_s
    }

    fn plot(&self, title: &str, y_label: &str, y: Range<f64>) -> Plot {
        let span = |(index, surface): (usize, &Surface)| Span {
            x: surface.time.clone(),
            label: surface.name.clone(),
            color: Color::Surface(index as u8),
        };
        let spans: Vec<_> = self.findings.surfaces.iter().enumerate().map(span).collect();
        Plot::new(title, y_label, self.time(), y).spans(&spans)
    }

    /// Where changes were noticed.
    fn marks(&self) -> Vec<Mark> {
        let mark = |(time, right): &(f64, bool)| {
            let change = self.findings.changes.iter().rfind(|change| change.at <= *time);
            let label = match (right, change.and_then(|change| change.delay)) {
                (true, Some(delay)) => format!("noticed after {delay:.1} s"),
                _ => "false alarm".into(),
            };
            Mark { x: *time, label }
        };
        self.findings.notices.iter().map(mark).collect()
    }

    fn truth(&self, value: impl Fn(&Truth) -> f64) -> impl Iterator<Item = (f64, f64)> {
        self.truth.iter().map(move |row| (row.time.seconds(), value(row)))
    }

    fn published(&self, value: impl Fn(&Row) -> f64) -> impl Iterator<Item = (f64, f64)> {
        self.rows.iter().map(move |row| (row.round.time, value(row)))
    }

    /// value ± 1.96 standard deviations.
    fn interval(
        &self,
        value: impl Fn(&Row) -> f64,
        std: impl Fn(&Row) -> f64,
    ) -> impl Iterator<Item = (f64, f64, f64)> {
        self.rows.iter().map(move |row| {
            let (value, half) = (value(row), 1.96 * std(row));
            (row.round.time, value - half, value + half)
        })
    }

    fn slope(&self, page: &mut Page) -> Result<(), PlotError> {
        let top = self.truth.iter().flat_map(|row| row.slope).fold(1.0, f64::max) * 1.3;
        let first = self.first_wheel() as usize;
        let in_use = self.truth.iter().zip(&self.findings.in_use);
        let mut plot = self
            .plot("Slip slope over time, estimated and true", "slip slope", 0.0..top)
            .height(330)
            .marks(&self.marks());
        for (wheel, color) in driven(&self.scenario.vehicle).into_iter().zip([Color::First, Color::Second]) {
            let index = wheel as usize;
            let name = side(wheel);
            plot = plot.band(
                &format!("{name}: 95 % interval"),
                color,
                self.interval(move |row| row.round.slope[index], |row| row.round.slope_std),
            );
            plot = plot.line(
                &format!("{name}: gripd"),
                color,
                self.published(move |row| row.round.slope[index]),
            );
        }
        let plot = plot
            .line(
                "true, in use",
                Color::Truth,
                in_use.map(|(row, true_)| (row.time.seconds(), true_.slope[first])),
            )
            .line("true, at zero slip", Color::OtherTruth, self.truth(move |row| row.slope[first]));
        page.plot(
            "Longitudinal slip slope: force / static wheel load, per slip",
            &plot,
            "A tire gives less and less force for more slip. In use: the straight line through all forces \
             and slips on this surface so far, which is what a linear estimate can find at best. No line: \
             not available.",
        )
    }

    fn friction(&self, page: &mut Page) -> Result<(), PlotError> {
        let top = self.truth.iter().map(|row| row.mu_max).fold(0.3, f64::max) * 1.3;
        let interval = self.rows.iter().map(move |row| {
            let round = &row.round;
            // Without an upper end everything above is possible.
            let high = if round.mu_high.is_finite() { round.mu_high } else { top };
            (round.time, round.mu_low, if round.mu_max.is_finite() { high } else { f64::NAN })
        });
        let mut plot = self
            .plot("Friction, used and available", "friction", 0.0..top)
            .height(260)
            .band("available: 95 % interval", Color::Third, interval)
            .line("used: gripd", Color::First, self.published(|row| row.round.mu_used))
            .line("at least available: gripd", Color::Second, self.published(|row| row.round.mu_low))
            .line("available: gripd", Color::Third, self.published(|row| row.round.mu_max))
            .line("available: true", Color::Truth, self.truth(|row| row.mu_max))
            .bar("source", self.segments(|row| source_color(&row.round.mu_source)))
            .bar("valid", self.segments(|row| row.round.mu_valid.then_some(Color::Third)));
        for (source, text) in SOURCES {
            if self.rows.iter().any(|row| row.round.mu_source == *source)
                && let Some(color) = source_color(source)
            {
                plot = plot.explain(text, color);
            }
        }
        page.plot(
            "Friction between tires and road",
            &plot,
            "While little of the friction is used, nothing tells how much there is: then only the lower \
             bound is published, and the friction itself is not available. It becomes so when a tire comes \
             near its limit, as in the braking on ice.",
        )
    }

    fn lateral(&self, page: &mut Page) -> Result<(), PlotError> {
        let most = |values: &mut dyn Iterator<Item = f64>| {
            values.fold(0.1, |most: f64, value| most.max(value.abs()))
        };
        let top = 1.3 * most(&mut self.truth.iter().map(|row| row.lateral_velocity));
        let plot = self
            .plot("Lateral velocity", "m/s", -top..top)
            .line("bicycle model", Color::Second, self.published(|row| row.bicycle))
            .line("gripd", Color::First, self.published(|row| row.round.lateral_velocity))
            .line("true", Color::Truth, self.truth(|row| row.lateral_velocity))
            .bar("valid", self.segments(|row| row.round.motion_valid.then_some(Color::First)));
        page.plot(
            "Lateral velocity at the centre of gravity, positive to the left",
            &plot,
            "Published in steps of 0.02 m/s. The bicycle model has the data sheet's stiffness; gripd learns it.",
        )?;
        // At walking pace the angle means nothing.
        let sideslip = |row: &Truth| if row.speed > 2.0 { row.sideslip.to_degrees() } else { f64::NAN };
        let top = 1.3 * most(&mut self.truth.iter().map(sideslip));
        let plot = self
            .plot("Sideslip", "degrees", -top..top)
            .line("gripd", Color::First, self.published(|row| row.round.sideslip.to_degrees()))
            .line("true", Color::Truth, self.truth(sideslip));
        page.plot("Sideslip: direction of motion against the car's, positive to the left", &plot, "")
    }

    fn cornering(&self, page: &mut Page) -> Result<(), PlotError> {
        let axles = [
            ("front", Color::First, (|row| row.cornering_front) as fn(&Truth) -> f64),
            ("rear", Color::Second, |row| row.cornering_rear),
        ];
        for (axle, (name, color, zero)) in axles.into_iter().enumerate() {
            let top = 1.5 * self.truth.iter().map(zero).fold(1.0, f64::max);
            let in_use = self.truth.iter().zip(&self.findings.in_use);
            let plot = self
                .plot(&format!("Cornering stiffness, {name}"), "1/rad", 0.0..top)
                .band(
                    "95 % interval",
                    color,
                    self.interval(
                        move |row| row.round.cornering[axle],
                        move |row| row.round.cornering_std[axle],
                    ),
                )
                .line("gripd", color, self.published(move |row| row.round.cornering[axle]))
                .line(
                    "true, in use",
                    Color::Truth,
                    in_use.map(|(row, true_)| (row.time.seconds(), true_.cornering[axle])),
                )
                .line("true, at zero slip", Color::OtherTruth, self.truth(zero))
                .bar("valid", self.segments(|row| row.round.cornering_valid.then_some(color)));
            page.plot(
                &format!("Cornering stiffness of the {name} axle: lateral force / load, per slip angle"),
                &plot,
                "",
            )?;
        }
        Ok(())
    }

    fn offset(&self, page: &mut Page) -> Result<(), PlotError> {
        let wheels = driven(&self.scenario.vehicle);
        let true_ = self.truth.first().map_or(0.0, |row| {
            wheels.iter().map(|wheel| row.slip_offset[*wheel as usize]).sum::<f64>() / wheels.len() as f64
        });
        let percent = |value: f64| 100.0 * value;
        let middle = percent(true_);
        let mut plot = self.plot("Slip offset", "%", middle - 0.3..middle + 0.3);
        for (wheel, color) in wheels.into_iter().zip([Color::First, Color::Second]) {
            let index = wheel as usize;
            plot = plot
                .band(
                    &format!("{}: 95 % interval", side(wheel)),
                    color,
                    self.interval(
                        move |row| percent(row.round.offset[index]),
                        move |row| percent(row.round.offset_std),
                    ),
                )
                .line(
                    &format!("{}: gripd", side(wheel)),
                    color,
                    self.published(move |row| percent(row.round.offset[index])),
                )
                .line(
                    &format!("{}: true", side(wheel)),
                    Color::Truth,
                    self.truth(move |row| percent(row.slip_offset[index])),
                );
        }
        page.plot("Slip at zero force: difference of the tires' radii, driven to rolling wheel", &plot, "")
    }

    fn inputs(&self, page: &mut Page) -> Result<(), PlotError> {
        let fastest = self.truth.iter().map(|row| row.speed).fold(1.0, f64::max);
        let plot = self
            .plot("Speed", "km/h", 0.0..3.6 * 1.25 * fastest)
            .height(190)
            .line("gripd", Color::First, self.published(|row| 3.6 * row.round.speed))
            .line("true", Color::Truth, self.truth(|row| 3.6 * row.speed));
        page.plot("Speed", &plot, "")?;
        let load: f64 = self.truth.first().map_or(1.0, |row| row.fz.iter().sum());
        let plot = self
            .plot("Normalized force and excitation", "force / weight", -0.6..0.6)
            .height(190)
            .line("longitudinal", Color::First, self.truth(move |row| row.fx.iter().sum::<f64>() / load))
            .line("lateral", Color::Second, self.truth(move |row| row.fy.iter().sum::<f64>() / load));
        page.plot("Tire forces of the whole car: what there is to learn from", &plot, "")?;
        let plot = self
            .plot("Excitation as published", "%", 0.0..120.0)
            .height(170)
            .line("longitudinal", Color::First, self.published(|row| row.round.excitation[0]))
            .line("lateral", Color::Second, self.published(|row| row.round.excitation[1]));
        page.plot("Excitation: how well the forces tell the stiffness", &plot, "")?;
        let most = self.truth.iter().fold(0.1, |most: f64, row| most.max(row.steering_wheel_angle.abs()));
        let top = 1.4 * most.to_degrees();
        let plot = self.plot("Steering wheel angle", "degrees", -top..top).height(170).line(
            "true",
            Color::Truth,
            self.truth(|row| row.steering_wheel_angle.to_degrees()),
        );
        page.plot("Steering wheel angle, positive to the left", &plot, "")
    }

    /// Stretches of the drive with one colour.
    fn segments(&self, color: impl Fn(&Row) -> Option<Color>) -> Vec<Segment> {
        let mut segments: Vec<Segment> = Vec::new();
        let mut goes_on = None;
        for row in self.rows {
            let (time, color) = (row.round.time, color(row));
            if let Some(last) = segments.last_mut()
                && goes_on.is_some()
                && time - last.to < 0.1
            {
                last.to = time;
            }
            if let Some(new) = color
                && color != goes_on
            {
                segments.push(Segment { from: time, to: time, color: new });
            }
            goes_on = color;
        }
        segments
    }

    /// The last row that counts on this surface. Before the change was noticed, what is published is of
    /// the surface before.
    fn last_valid(&self, surface: &Surface, valid: impl Fn(&Row) -> bool) -> Option<&Row> {
        let on = self.noticed_part(surface);
        self.rows.iter().rfind(|row| on.contains(&row.round.time) && valid(row))
    }

    fn noticed_part(&self, surface: &Surface) -> Range<f64> {
        let Range { start, end } = surface.time;
        match self.findings.changes.iter().find(|change| change.at == start) {
            Some(change) => change.delay.map_or(end, |delay| start + delay)..end,
            None => start..end,
        }
    }

    fn surface_columns(&self) -> Vec<&str> {
        let names = self.findings.surfaces.iter().map(|surface| surface.name.as_str());
        ["at the end of each surface"].into_iter().chain(names).collect()
    }

    fn surface_rows(&self) -> Vec<Vec<String>> {
        let each = |name: String, cell: &dyn Fn(&Surface) -> String| {
            std::iter::once(name).chain(self.findings.surfaces.iter().map(cell)).collect::<Vec<String>>()
        };
        let found = |row: Option<&Row>, value: &dyn Fn(&Row) -> f64, std: &dyn Fn(&Row) -> f64| match row {
            Some(row) => format!("{} ± {}", number(value(row), 1), number(1.96 * std(row), 1)),
            None => "not valid".into(),
        };
        let end = |surface: &Surface| at(self.truth, surface.time.end - 0.01);
        let truth = |surface: &Surface, value: &dyn Fn(&Truth) -> f64| {
            end(surface).and_then(|i| self.truth.get(i)).map_or(f64::NAN, value)
        };
        let in_use = |surface: &Surface, value: &dyn Fn(&super::findings::InUse) -> f64| {
            end(surface).and_then(|i| self.findings.in_use.get(i)).map_or(f64::NAN, value)
        };
        let mut rows = Vec::new();
        for wheel in driven(&self.scenario.vehicle) {
            let index = wheel as usize;
            rows.push(each(format!("Slip slope, {}: gripd", side(wheel)), &|surface| {
                let row = self.last_valid(surface, |row| row.round.slope_valid);
                found(row, &|row| row.round.slope[index], &|row| row.round.slope_std)
            }));
        }
        let first = self.first_wheel() as usize;
        rows.push(each("\u{2003}true, in use (at zero slip)".into(), &|surface| {
            let [used, zero] = [in_use(surface, &|i| i.slope[first]), truth(surface, &|t| t.slope[first])];
            format!("{} ({})", number(used, 1), number(zero, 1))
        }));
        for (axle, name) in ["front", "rear"].into_iter().enumerate() {
            rows.push(each(format!("Cornering stiffness, {name}, 1/rad: gripd"), &|surface| {
                let row = self.last_valid(surface, |row| row.round.cornering_valid);
                found(row, &|row| row.round.cornering[axle], &|row| row.round.cornering_std[axle])
            }));
            rows.push(each("\u{2003}true, in use (at zero slip)".into(), &|surface| {
                let used = in_use(surface, &|i| i.cornering[axle]);
                let zero = truth(surface, &|t| [t.cornering_front, t.cornering_rear][axle]);
                format!("{} ({})", number(used, 1), number(zero, 1))
            }));
        }
        rows.push(each("Friction available: gripd".into(), &|surface| self.friction_found(surface)));
        rows.push(each("\u{2003}true".into(), &|surface| number(truth(surface, &|t| t.mu_max), 2)));
        rows
    }

    fn friction_found(&self, surface: &Surface) -> String {
        if let Some(row) = self.last_valid(surface, |row| row.round.mu_valid) {
            let round = &row.round;
            let [max, low, high] = [round.mu_max, round.mu_low, round.mu_high].map(|value| number(value, 2));
            return format!("{max} ({low} to {high})");
        }
        let on = self.noticed_part(surface);
        let rows = self.rows.iter().filter(|row| on.contains(&row.round.time));
        let least = rows.map(|row| row.round.mu_low).fold(f64::NAN, f64::max);
        format!("at least {}", number(least, 2))
    }
}

/// Sources of the friction that can be told apart in the bar, and their names.
const SOURCES: &[(&str, &str)] = &[
    ("lower_bound", "source: lower bound only"),
    ("slope_map", "source: slip slope"),
    ("brush", "source: curvature (brush model)"),
    ("joint", "source: joint lateral filter"),
    ("abs", "source: ABS braking"),
];

fn source_color(source: &str) -> Option<Color> {
    match source {
        "lower_bound" => Some(Color::Muted),
        "slope_map" => Some(Color::Second),
        "brush" => Some(Color::Third),
        "joint" => Some(Color::First),
        "abs" => Some(Color::Notice),
        _ => None,
    }
}

fn side(wheel: Wheel) -> &'static str {
    match wheel {
        Wheel::Fl => "front left",
        Wheel::Fr => "front right",
        Wheel::Rl => "rear left",
        Wheel::Rr => "rear right",
    }
}

fn noticed(change: &Change) -> String {
    match change.delay {
        Some(delay) => format!("the {} after {delay:.1} s", change.to),
        None => format!("the {} not at all", change.to),
    }
}

/// "a, b and c".
fn list(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

fn quality_row(quality: &Quality) -> Vec<String> {
    let unit =
        |value: f64| format!("{} {}", number(value, quality.decimals), quality.unit).trim_end().to_owned();
    vec![
        quality.name.to_owned(),
        percent(quality.valid),
        percent(quality.covered),
        unit(quality.bias),
        unit(quality.rms),
    ]
}

const NOTES: &[(&str, &str)] = &[
    (
        "gripd",
        "Decoded from the frames that gripd published on the bus, through its output DBC. Nothing else of \
         it is shown, but for the bicycle model's lateral velocity.",
    ),
    (
        "true",
        "From the simulated car: brush tires, load transfer, uneven tire radii, sensors with noise, \
         offsets, delays and tooth errors. gripd is told a data sheet's numbers, which are somewhat wrong.",
    ),
    (
        "not available",
        "Sent as such, never as an old value: a slope after a surface change until enough force has been \
         seen; the lateral motion below walking pace; the friction while too little of it is used.",
    ),
    ("valid", "May be acted upon. What is published but not valid is for information only."),
    (
        "95 % interval",
        "Value ± 1.96 standard deviations as published. For both slopes and both offsets one standard \
         deviation is published, that of the less certain one. Compared with the truth in use.",
    ),
];
