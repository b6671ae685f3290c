//! Over time: each channel as measured and as predicted, below it the error; and how the car was driven.

use super::{Axis, Beside, Drive, Said};
use crate::pages::explain::words::{self, sentence, three, with_unit};
use crate::report::Color;
use crate::report::interactive::{Band, Panel, Series, Source, Span};

/// Deviations of a 95 % interval.
const NORMAL_95: f64 = 1.96;
/// By so many times the range of the others the plainest model may go beyond it: of what is measured, and of the errors, of
/// which it is the one to be seen.
const BEYOND: [f64; 2] = [0.5, 4.0];

impl Beside {
    /// Lines that the panels of all channels have, the time and what was driven counted.
    pub fn lines(&self) -> usize {
        3 + self.channels().len() * (1 + 2 * self.models.len())
    }

    /// A channel, and its error.
    pub fn channel(&self, axis: &Axis, channel: &str) -> [Panel; 2] {
        let (factor, unit) = self.shown(channel);
        let name = sentence(&words::channel(channel));
        let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
        let mut values = Panel::new(&name, &format!("{}{unit}", words::channel(channel)));
        let mut errors = Panel::new(&format!("{name}: error"), &format!("measured − predicted{unit}"));
        let measured = axis.column(&self.drives, |_, drive| drive.measured(channel));
        values.series.push(line(axis, "measured", Source::Measured, Color::Truth, &measured, factor));
        for (place, model) in self.models.iter().enumerate() {
            let column = self.predicted(axis, channel, place);
            if !column.iter().any(|value| value.is_finite()) {
                continue;
            }
            values.series.push(line(axis, model.name, Source::Predicted, model.color, &column, factor));
            let error = self.error(axis, channel, place);
            errors.series.push(line(axis, model.name, Source::Predicted, model.color, &error, factor));
        }
        values.limits = limits(&values.series, 1, BEYOND[0]);
        errors.limits = limits(&errors.series, 0, BEYOND[1]);
        let held_out = self.held_out(axis);
        for panel in [&mut values, &mut errors] {
            panel.shades.extend(held_out.clone());
        }
        self.disturbance(channel, &mut errors);
        if let Some(told) = self.told(channel) {
            let count = self.error.get(channel).map_or(0, Vec::len);
            let names: Vec<&str> = self.models.iter().take(count).map(|model| model.name).collect();
            errors.caption =
                format!("{} (root mean square): {told} ({}).", sentence(self.error_is), names.join(" → "));
        }
        [values, errors]
    }

    /// How large what no model predicts usually is.
    fn disturbance(&self, channel: &str, panel: &mut Panel) {
        let Some(left) = self.disturbances.get(channel) else { return };
        let (factor, unit) = words::shown_unit(channel, &left.unit);
        let most = NORMAL_95 * factor * left.std;
        if most.is_finite() && most > 0.0 {
            let size = with_unit(&three(most), &unit);
            let name = format!(
                "road, wind and noise: within ± {size} for 95 % of the time, lasting {} s",
                three(left.time_constant_s)
            );
            panel.bands.push(Band { name, color: Color::Muted, values: (-most, most) });
            panel.reach = Some((-most, most));
        }
    }

    /// Speed and steering; without the speed where that is compared.
    pub fn driven(&self, axis: &Axis) -> Vec<Panel> {
        let [speed, steering] = self.driven_columns(axis);
        let of = |name: &str, column: &[f32], factor: f64| {
            vec![line(axis, name, Source::Measured, Color::Truth, column, factor)]
        };
        let series = of("speed", &speed, 3.6);
        let speed = Panel { series, reach: Some((0.0, 10.0)), ..Panel::new("Speed", "speed, km/h") };
        let series = of("angle", &steering, 1_f64.to_degrees());
        let steering = Panel { series, ..Panel::new("Steering wheel", "angle, °, positive to the left") };
        let is_compared = self.channels().iter().any(|channel| channel == "speed");
        if is_compared { vec![steering] } else { vec![speed, steering] }
    }

    /// Speed, m/s, and steering wheel angle, rad, row by row.
    pub fn driven_columns(&self, axis: &Axis) -> [Vec<f32>; 2] {
        let column = |drive: &Drive, place: usize| drive.driven.iter().map(|row| row[place]).collect();
        let columns: Vec<[Vec<f64>; 3]> =
            self.drives.iter().map(|drive| [0, 1, 2].map(|place| column(drive, place))).collect();
        [1, 2].map(|of| {
            axis.column(&self.drives, |place, _| {
                columns.get(place).map(|own| (own[0].as_slice(), own[of].as_slice()))
            })
        })
    }

    /// What a model predicts of a channel, SI, row by row.
    pub fn predicted(&self, axis: &Axis, channel: &str, model: usize) -> Vec<f32> {
        self.of_model(axis, channel, model, |said| &said.predicted)
    }

    /// By how much it is off: measured less predicted.
    pub fn error(&self, axis: &Axis, channel: &str, model: usize) -> Vec<f32> {
        // Each model beside what it is compared with: a mean beside a mean.
        let measured = self.of_model(axis, channel, model, |said| &said.measured);
        let predicted = self.predicted(axis, channel, model);
        measured.iter().zip(predicted).map(|(measured, predicted)| measured - predicted).collect()
    }

    fn of_model(&self, axis: &Axis, channel: &str, model: usize, of: fn(&Said) -> &Vec<f64>) -> Vec<f32> {
        axis.column(&self.drives, |_, drive| {
            let said = drive.said(channel, model)?;
            Some((said.t.as_slice(), of(said).as_slice()))
        })
    }

    fn held_out(&self, axis: &Axis) -> Option<Span> {
        let all = self.drives.iter().enumerate();
        let spans: Vec<(f64, f64)> =
            all.flat_map(|(place, drive)| axis.on_page(place, &drive.held_out)).collect();
        (!spans.is_empty()).then(|| Span::new("held out of the fit", Color::Third, &spans))
    }
}

/// A line of a column in another unit (`factor` of it are one SI unit).
pub fn line(axis: &Axis, name: &str, source: Source, color: Color, column: &[f32], factor: f64) -> Series {
    let column: Vec<f32> = column.iter().map(|value| (f64::from(*value) * factor) as f32).collect();
    Series { name: name.into(), source, color, values: axis.grid.line(&column), interval: None }
}

/// The plainest model, which is the line at this place, must not press everything else flat when it is far off.
fn limits(series: &[Series], plainest: usize, beyond: f64) -> Option<(f64, f64)> {
    let range = |one: &Series| {
        let finite = || one.values.values().iter().copied().filter(|value| value.is_finite());
        Some((finite().reduce(f64::min)?, finite().reduce(f64::max)?))
    };
    let plain = range(series.get(plainest)?)?;
    let others = series.iter().enumerate().filter(|(place, _)| *place != plainest);
    let (low, high) =
        others.filter_map(|(_, one)| range(one)).reduce(|all, one| (all.0.min(one.0), all.1.max(one.1)))?;
    let beyond = beyond * (high - low);
    let is_beyond = plain.0 < low - beyond || plain.1 > high + beyond;
    is_beyond.then_some((low - beyond, high + beyond))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::interactive::Numbers;

    #[test]
    fn a_model_far_off_leaves_room_for_the_others() {
        let series = |values: Vec<f64>| Series {
            name: String::new(),
            source: Source::Predicted,
            color: Color::First,
            values: Numbers::new(values),
            interval: None,
        };
        let [own, far, near] = [[-1.0, 1.0], [-1e5, 0.0], [-1.5, 0.0]].map(|ends| series(ends.to_vec()));
        assert_eq!(limits(&[own.clone(), far.clone()], 1, 0.5), Some((-2.0, 2.0)));
        assert_eq!(limits(&[far.clone(), own.clone()], 0, 4.0), Some((-9.0, 9.0)));
        assert_eq!(limits(&[own, near], 1, 0.5), None);
        assert_eq!(limits(&[far], 0, 4.0), None, "by itself it is all there is to see");
        assert_eq!(limits(&[], 0, 4.0), None);
    }
}
