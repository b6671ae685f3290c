//! The plots of the page.

use std::ops::Range;

use super::super::findings::{Surface, driven};
use super::super::row::Row;
use super::{Story, side};
use lab::report::{Color, Mark, Page, Plot, PlotError, Segment, Span, Stroke};
use physics::estimates::MuSource;
use physics::model::Truth;

impl Story<'_> {
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

    /// The upper end of an axis: all of the intervals and the surfaces' names above them, but no more than
    /// twice what is true, for at first an interval is as wide as it likes.
    fn top(&self, truth: f64, upper: impl Fn(&Row) -> f64) -> f64 {
        let most = self.rows.iter().map(upper).filter(|value| value.is_finite()).fold(truth, f64::max);
        1.15 * most.min(2.0 * truth)
    }

    pub(super) fn slope(&self, page: &mut Page) -> Result<(), PlotError> {
        let most = self.truth.iter().flat_map(|row| row.slope).fold(1.0, f64::max);
        let top = self.top(most, |row| {
            row.round.slope.into_iter().fold(f64::NAN, f64::max) + 1.96 * row.round.slope_std
        });
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

    pub(super) fn friction(&self, page: &mut Page) -> Result<(), PlotError> {
        let top = self.truth.iter().map(|row| row.mu_max).fold(0.3, f64::max) * 1.3;
        // Without an upper end everything above is possible; where nothing at all is told nothing is shaded.
        let interval = |is_open: bool| {
            self.rows.iter().map(move |row| {
                let round = &row.round;
                let is_told = round.mu_low.is_finite() || round.mu_max.is_finite();
                let low = if round.mu_low.is_finite() || !is_told { round.mu_low } else { 0.0 };
                let is_bounded = round.mu_max.is_finite() && round.mu_high.is_finite();
                let high = if is_bounded { round.mu_high } else { top };
                (round.time, low, if is_open == is_bounded { f64::NAN } else { high })
            })
        };
        let mut plot = self
            .plot("Friction, used and available", "friction", 0.0..top)
            .height(260)
            .band("available: this or any more", Color::Muted, interval(true))
            .band("available: 95 % interval", Color::Third, interval(false))
            .line("used: gripd", Color::First, self.published(|row| row.round.mu_used))
            .line("at least available: gripd", Color::Second, self.published(|row| row.round.mu_low))
            .line("available: gripd", Color::Third, self.published(|row| row.round.mu_max))
            .line("available: true", Color::Truth, self.truth(|row| row.mu_max));
        // A bar for each, named beside it: colours enough are taken above.
        let mut told = Vec::new();
        for (source, name, text) in SOURCES {
            if self.rows.iter().any(|row| row.round.mu_source == Some(*source)) {
                plot = plot.bar(
                    name,
                    self.segments(|row| (row.round.mu_source == Some(*source)).then_some(Color::Muted)),
                );
                told.push(format!("{name}: {text}"));
            }
        }
        let plot = plot.bar("valid", self.segments(|row| row.round.mu_valid.then_some(Color::Third)));
        page.plot(
            "Friction between tires and road",
            &plot,
            &format!(
                "Shaded is what the friction may be. While little of it is used, nothing tells how much there is: \
                 only a lower bound is published (grey, open upwards), which sinks with every second in which the \
                 road may have become another one. When a tire comes near its limit, as in the braking on ice, the \
                 interval closes around the friction; and opens again when that is over. The bars below tell what \
                 it comes from ({}), and when it was valid.",
                told.join("; ")
            ),
        )
    }

    pub(super) fn lateral(&self, page: &mut Page) -> Result<(), PlotError> {
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
            .line("true", Color::Truth, self.truth(sideslip))
            .bar("valid", self.segments(|row| row.round.motion_valid.then_some(Color::First)));
        page.plot(
            "Sideslip: direction of motion against the car's, positive to the left",
            &plot,
            "Published without an interval.",
        )
    }

    pub(super) fn cornering(&self, page: &mut Page) -> Result<(), PlotError> {
        let axles = [
            ("front", Color::First, (|row| row.cornering_front) as fn(&Truth) -> f64),
            ("rear", Color::Second, |row| row.cornering_rear),
        ];
        for (axle, (name, color, zero)) in axles.into_iter().enumerate() {
            let most = self.truth.iter().map(zero).fold(1.0, f64::max);
            let top = self.top(most, |row| row.round.cornering[axle] + 1.96 * row.round.cornering_std[axle]);
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
                .line("true, at zero slip", Color::Truth, self.truth(zero))
                .bar("valid", self.segments(|row| row.round.cornering_valid.then_some(color)));
            page.plot(
                &format!("Cornering stiffness of the {name} axle: lateral force / load, per slip angle"),
                &plot,
                "",
            )?;
        }
        Ok(())
    }

    pub(super) fn offset(&self, page: &mut Page) -> Result<(), PlotError> {
        let wheels = driven(&self.scenario.vehicle);
        let true_ = self.truth.first().map_or(0.0, |row| {
            wheels.iter().map(|wheel| row.slip_offset[*wheel as usize]).sum::<f64>() / wheels.len() as f64
        });
        let percent = |value: f64| 100.0 * value;
        let middle = percent(true_);
        let mut plot = self.plot("Slip offset", "%", middle - 0.3..middle + 0.3);
        let looks = [(Color::First, Stroke::Solid), (Color::Second, Stroke::Dashed)];
        for (wheel, (color, stroke)) in wheels.into_iter().zip(looks) {
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
                .stroked(
                    &format!("{}: true", side(wheel)),
                    Color::Truth,
                    stroke,
                    self.truth(move |row| percent(row.slip_offset[index])),
                );
        }
        page.plot("Slip at zero force: difference of the tires' radii, driven to rolling wheel", &plot, "")
    }

    pub(super) fn inputs(&self, page: &mut Page) -> Result<(), PlotError> {
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
            .line("longitudinal", Color::First, self.published(|row| 100.0 * row.round.excitation[0]))
            .line("lateral", Color::Second, self.published(|row| 100.0 * row.round.excitation[1]));
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
}

/// Where the friction comes from: as published, beside its bar, and in words.
const SOURCES: &[(MuSource, &str, &str)] = &[
    (MuSource::LowerBound, "bound", "a lower bound only"),
    (MuSource::SlopeMap, "slope", "the slip slope"),
    (MuSource::Brush, "brush", "the curvature, by the brush model"),
    (MuSource::Joint, "joint", "the joint lateral filter"),
    (MuSource::Abs, "ABS", "an ABS braking"),
    (MuSource::Limit, "spinning", "spinning wheels"),
];
