//! Where a model errs: over speed and lateral acceleration, and along the track.

use super::{Axis, Beside, MAIN, MAPPED};
use crate::pages::explain::words::{self, sentence};
use crate::pages::handling::Handling;
use crate::pages::track::Track;
use crate::report::Color;
use crate::report::interactive::{Figure, Grid, Numbers, Points, Shade, Shape, Source};
use identify::understeer::{self, Instant};
use physics::model::{Uncertain, Vehicle};

/// Errors are means over so long, s …
const MEAN_S: f64 = 0.5;
/// … or longer, so that there are no more points than these.
const MOST_POINTS: usize = 3000;
/// So large a share of the errors is within the scale of the colours.
const WITHIN: f64 = 0.97;
/// More recordings in one track cannot be told apart.
const MOST_TRACKS: usize = 4;

/// Means over some time: when, speed, lateral acceleration, error.
type Mean = [f64; 4];

impl Beside {
    /// Numbers that the figures have at most.
    pub fn points(&self) -> usize {
        let maps = MAPPED.min(self.models.len()) * MAIN.len();
        4 * MOST_POINTS * (maps + self.drives.len().min(MOST_TRACKS))
    }

    /// A model's error of a channel, over speed and lateral acceleration.
    pub fn map(&self, axis: &Axis, channel: &str, model: usize) -> Figure {
        let (factor, unit) = self.shown(channel);
        let name = words::channel(channel);
        let title = format!("{}: error, {}", sentence(&name), self.name(model));
        let (across, words) = self.across(axis);
        let mut figure = Figure::new(&title, "speed, km/h", words);
        let [speed, _] = self.driven_columns(axis);
        let means = self.means(axis, [&speed, &across, &self.error(axis, channel, model)]);
        let column =
            |of: fn(&Mean) -> f64, decimals| Numbers::rounded(means.iter().map(of).collect(), decimals);
        let values: Vec<f64> = means.iter().map(|it| factor * it[3]).collect();
        figure.points.push(Points {
            name: self.name(model).into(),
            source: Source::Measured,
            color: Color::First,
            shape: Shape::Dots,
            times: column(|it| it[0], 1),
            x: column(|it| 3.6 * it[1], 1),
            y: column(|it| it[2], 2),
            shade: Some(Shade {
                name: format!("measured − predicted, {unit}"),
                most: factor * self.most(axis, channel),
                values: Numbers::new(values),
            }),
        });
        figure.answer = match self.error.get(channel).and_then(|errors| errors.get(model)) {
            Some(error) => super::told(&[*error], (factor, &unit))
                .map_or_else(String::new, |told| format!("{} {told}.", sentence(self.error_is))),
            None => String::new(),
        };
        figure.caption = "Each dot is a moment's mean. One colour in one corner: the model lacks something there. All colours \
                          everywhere: road and noise."
            .into();
        figure
    }

    /// The track, coloured by a model's error of a channel.
    pub fn track(&self, axis: &Axis, channel: &str, model: usize) -> Figure {
        let (factor, unit) = self.shown(channel);
        let mut figure = Figure::new("Track", "metres ahead of the start", "metres to the left of the start");
        figure.is_equal = true;
        let yaw_rate = axis.column(&self.drives, |_, drive| drive.measured("yaw_rate"));
        let [speed, _] = self.driven_columns(axis);
        let error: Vec<f32> =
            self.error(axis, channel, model).iter().map(|it| (f64::from(*it) * factor) as f32).collect();
        let most = factor * self.most(axis, channel);
        let shade = format!("error, {}, {unit}", self.name(model));
        let mut has_gaps = false;
        for (place, drive) in self.drives.iter().enumerate().take(MOST_TRACKS) {
            let rows = axis.rows(place);
            let track = Track {
                times: &axis.times[rows.clone()],
                speed: &speed[rows.clone()],
                yaw_rate: &yaw_rate[rows.clone()],
                offset: drive.yaw_rate_offset,
                shade: &error[rows],
            };
            if track.is_known() {
                has_gaps |= track.has_gaps();
                figure.points.push(track.points((&shade, most), MOST_POINTS));
            }
        }
        let of = words::channel(channel);
        figure.caption = format!(
            "Coloured by the error of the {of}. From speed and yaw rate alone: it drifts by some per cent of the way."
        );
        if has_gaps {
            figure.caption += " Where there is no line nothing was predicted, as while braking, and the car is taken to go on as \
                               before.";
        }
        if self.drives.len() > MOST_TRACKS {
            figure.caption += &format!(" The first {MOST_TRACKS} recordings.");
        }
        if figure.points.is_empty() {
            figure.empty = "There is no track: it takes speed and yaw rate.".into();
        }
        figure
    }

    /// The handling curve; `told`: the understeer gradient as something else tells it, rad per m/s².
    pub fn handling(&self, axis: &Axis, vehicle: &Vehicle, told: Option<Uncertain>) -> Figure {
        let (lateral, _) = self.across(axis);
        let is_sensor = self.channels().iter().any(|channel| channel == "lateral_acceleration");
        let yaw_rate = axis.column(&self.drives, |_, drive| drive.measured("yaw_rate"));
        let [speed, steering] = self.driven_columns(axis);
        let mut moments = Vec::new();
        for (place, drive) in self.drives.iter().enumerate() {
            moments.extend(understeer::moments(axis.rows(place).map(|row| Instant {
                t: axis.times[row],
                speed: f64::from(speed[row]),
                yaw_rate: f64::from(yaw_rate[row]) - drive.yaw_rate_offset,
                lateral_acceleration: f64::from(lateral[row]),
                road_angle: f64::from(steering[row]) / vehicle.steering_ratio.value,
            })));
        }
        let told = told.map(|it| ("from the cornering stiffness found", it));
        Handling { vehicle, is_sensor, moments, elsewhere: Vec::new(), told }.figure()
    }

    fn name(&self, model: usize) -> &'static str {
        self.models.get(model).map_or("model", |model| model.name)
    }

    /// The lateral acceleration row by row, and its axis.
    fn across(&self, axis: &Axis) -> (Vec<f32>, &'static str) {
        let measured = axis.column(&self.drives, |_, drive| drive.measured("lateral_acceleration"));
        if measured.iter().any(|value| value.is_finite()) {
            return (measured, "lateral acceleration, m/s²");
        }
        let yaw_rate = axis.column(&self.drives, |_, drive| drive.measured("yaw_rate"));
        let [speed, _] = self.driven_columns(axis);
        let product = speed.iter().zip(yaw_rate).map(|(speed, rate)| speed * rate).collect();
        (product, "lateral acceleration (speed × yaw rate), m/s²")
    }

    fn means(&self, axis: &Axis, columns: [&[f32]; 3]) -> Vec<Mean> {
        let seconds: f64 = steps(&axis.times).sum();
        let length = MEAN_S.max(seconds / MOST_POINTS as f64);
        let mut means = Vec::new();
        let (mut sum, mut count, mut begun) = ([0.0; 4], 0.0, f64::NEG_INFINITY);
        for (row, time) in axis.times.iter().enumerate() {
            let values = columns.map(|column| column.get(row).map_or(f64::NAN, |it| f64::from(*it)));
            if !values.iter().all(|it| it.is_finite()) {
                continue;
            }
            if time - begun >= length {
                means.extend((count > 0.0).then(|| sum.map(|sum: f64| sum / count)));
                (sum, count, begun) = ([0.0; 4], 0.0, *time);
            }
            for (sum, value) in sum.iter_mut().zip([*time, values[0], values[1], values[2]]) {
                *sum += value;
            }
            count += 1.0;
        }
        means.extend((count > 0.0).then(|| sum.map(|sum| sum / count)));
        means
    }

    /// Where the colours of a channel's errors end, SI: the same for all models.
    fn most(&self, axis: &Axis, channel: &str) -> f64 {
        let mut sizes: Vec<f32> =
            self.error(axis, channel, 0).iter().map(|it| it.abs()).filter(|it| it.is_finite()).collect();
        sizes.sort_by(f32::total_cmp);
        let place = (WITHIN * sizes.len() as f64) as usize;
        sizes.get(place).map_or(1.0, |it| f64::from(*it).max(1e-6))
    }
}

/// Distances of rows, s; a pause counts as nothing.
fn steps(times: &[f64]) -> impl Iterator<Item = f64> {
    let step = |pair: &[f64]| pair[1] - pair[0];
    times.windows(2).map(step).filter(|step| *step <= Grid::LONGEST_STEP_S)
}
