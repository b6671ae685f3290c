//! What varies as it likes while one drives: a sensor's zero that drifts, the wind, the road's bank. It is a straight line
//! between points in time, each a free number of its own.

use super::super::fit::FreeFit;
use super::super::inputs::FreeDrive;
use super::super::numbers::{Free, Number, Scope};
use super::refit::Refitted;
use super::trial::{Trial, What, has, new_kinds, own};
use crate::explain::candidates::{Candidate, library};
use crate::explain::model::Place;
use crate::explain::result::{CourseEstimate, Estimate};
use physics::Quantity;
use physics::model::effect::{Channel, Disturbance, Kind};

/// There are so many points in a correlation length …
const POINTS_PER_LENGTH: f64 = 2.0;

/// … which are so many seconds apart at least, and so many at most. Numerical.
const SHORTEST_LINE_S: f64 = 2.0;
const MOST_POINTS: f64 = 60.0;

/// At each point it is thought to have so many times its usual size, and differs by this share of that. Tuned: drifts of a
/// GTI's gyroscope, 0.5 to 4 times of what is usual (`concealed_in_real_drives`).
const STDS: f64 = 2.0;
const STEP: f64 = 0.1;

/// Lines between few points are smoother than what they follow, and what is thought of them makes them smaller: by this share
/// of the rms. Tuned by banks and drifts that were put into real drives, 10 to 30 % small (`concealed_in_real_drives`).
const SMOOTHED: f64 = 0.2;

/// It is clearly there where it is so many deviations from nothing, and this share of its peak.
const CLEAR: f64 = 2.0;
const LEAST_OF_PEAK: f64 = 0.2;

/// What could vary in one recording. Of several recordings none: a course is of one drive.
pub fn courses(found: &FreeFit<'_>, drives: &[FreeDrive], kinds: &[&'static Kind], of: Scope) -> Vec<Trial> {
    let mut all = own(drives, of);
    let (Some(drive), None) = (all.next(), all.next()) else { return Vec::new() };
    let seconds = drive.time(drive.points());
    let trial = |candidate: Candidate| {
        let every = (free_course(&candidate)?.length_s / POINTS_PER_LENGTH).max(SHORTEST_LINE_S);
        let count = (seconds / every).ceil().min(MOST_POINTS);
        let points = (0..=count as usize).map(|point| seconds * point as f64 / count).collect();
        let mut trial = Trial::new(What::Effect(Candidate { live: None, ..candidate }), of, 0.0);
        trial.points = points;
        Some(trial)
    };
    let kinds = new_kinds(kinds, &found.model);
    let candidates = library(&kinds, &found.model, |quantity| has(drives, of, quantity), &[]);
    candidates.into_iter().filter_map(trial).collect()
}

/// The course of what may be anything; not of a patch, which is a share of another road, nor of what acts for moments, nor of
/// a wheel: it counts teeth, and has no zero that could drift.
pub fn free_course(candidate: &Candidate) -> Option<Disturbance> {
    let is_of_wheel = candidate.channel.and_then(Channel::quantity).and_then(Quantity::wheel).is_some();
    let course = candidate.kind.disturbance(candidate.channel).filter(|_| !is_of_wheel);
    course.filter(|course| course.sign == 0.0 && !course.is_told_by_its_peak)
}

impl Trial {
    /// Does it vary as it likes?
    pub fn is_course(&self) -> bool {
        !self.points.is_empty()
    }

    /// Does it vary as it likes and move the car across? Wind, bank and a drift of what is steered are hardly told apart by
    /// how the car turns: they differ by less than what the car's equations miss.
    pub fn moves_across(&self) -> bool {
        let steers = Channel::One(Quantity::SteeringWheelAngle);
        let channel = self.candidate().map(|candidate| candidate.channel);
        self.is_course() && channel.is_some_and(|channel| channel.is_none_or(|channel| channel == steers))
    }

    /// Is it the zero of gyroscope or accelerometer that moves while one drives? What the model misses of the motion is in the
    /// other sensors as well, so that sensor's own slow noise is what is asked for.
    pub fn is_of_zero(&self) -> bool {
        [Quantity::YawRate, Quantity::LateralAcceleration].into_iter().any(|of| self.moves_zero_of(of))
    }

    /// Is it this sensor's zero that moves while one drives?
    pub fn moves_zero_of(&self, quantity: Quantity) -> bool {
        self.candidate().is_some_and(|candidate| {
            candidate.is_added_in_time() && candidate.channel == Some(Channel::One(quantity))
        })
    }

    /// What is free of its course, if it is this effect of the car.
    pub(super) fn free_points(&self, effect: usize) -> impl Iterator<Item = Free> + use<'_> {
        let size = self.candidate().and_then(free_course).map_or(0.0, |course| course.size);
        (0..self.points.len()).map(move |point| Free {
            number: Number::Of(Place::Course(effect, point)),
            of: self.of,
            prior: (0.0, STDS * size),
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            step: STEP * size,
        })
    }
}

impl Refitted<'_> {
    /// How it varied. What cannot be told from the zero of the sensor, which is a number of its own, is left out.
    pub fn course(&self) -> Option<CourseEstimate> {
        let course = self.trial.candidate().and_then(free_course).filter(|_| self.trial.is_course())?;
        let first = self.free.len() - self.trial.points.len();
        let mut value = self.at[first..].to_vec();
        if course.has_its_mean_in_an_offset {
            let mean = mean_by(&value).iter().sum::<f64>();
            value.iter_mut().for_each(|value| *value -= mean);
        }
        let std = (first..self.free.len()).map(|place| self.covariance[(place, place)].max(0.0).sqrt());
        let (t, unit) = (self.trial.points.clone(), course.unit.into());
        Some(CourseEstimate { t, std: std.collect(), value, unit })
    }

    /// The root of its mean square, under its name.
    pub fn course_size(&self) -> Option<(&'static str, Estimate)> {
        let name = self.trial.candidate().and_then(free_course)?.rms_name;
        let CourseEstimate { value, .. } = self.course()?;
        let first = self.free.len() - value.len();
        let slope = mean_by(&value);
        let square: f64 = slope.iter().zip(&value).map(|(slope, value)| slope * value).sum();
        let rms = square.max(1e-300).sqrt();
        let by = |i: usize, j: usize| slope[i] * slope[j] * self.covariance[(first + i, first + j)];
        let variance: f64 = (0..value.len()).flat_map(|i| (0..value.len()).map(move |j| by(i, j))).sum();
        Some((name, Estimate { value: rms, std: (variance.max(0.0).sqrt() / rms).hypot(SMOOTHED * rms) }))
    }
}

/// The mean of a line through evenly spaced values times what is 1 at one of them and falls to nothing at its neighbours, for
/// each of them: they add up to the line's mean, and times the values to its mean square.
fn mean_by(value: &[f64]) -> Vec<f64> {
    let lines = value.len().saturating_sub(1).max(1) as f64;
    let of = |i: usize| {
        let neighbours = [i.checked_sub(1), Some(i + 1)].map(|at| at.and_then(|at| value.get(at)));
        let sides = neighbours.into_iter().flatten().map(|other| value[i] / 3.0 + other / 6.0);
        sides.sum::<f64>() / lines
    };
    (0..value.len()).map(of).collect()
}

/// Where a course is clearly there, s.
pub fn clear_stretches(course: &CourseEstimate) -> Vec<[f64; 2]> {
    let peak = course.value.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
    let is_clear = |i: usize| course.value[i].abs() > (CLEAR * course.std[i]).max(LEAST_OF_PEAK * peak);
    let mut all: Vec<[f64; 2]> = Vec::new();
    for i in (0..course.t.len()).filter(|i| is_clear(*i)) {
        let from = course.t[i.saturating_sub(1)];
        let to = course.t[(i + 1).min(course.t.len() - 1)];
        match all.last_mut().filter(|last| last[1] >= from) {
            Some(last) => last[1] = to,
            None => all.push([from, to]),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lines_mean_and_mean_square_are_those_between_its_points() {
        let value = [0.0, 3.0, -3.0];
        let by = mean_by(&value);
        assert!((by.iter().sum::<f64>() - 0.75).abs() < 1e-12, "{by:?}");
        let square: f64 = by.iter().zip(value).map(|(by, value)| by * value).sum();
        assert!((square - 3.0).abs() < 1e-12, "{square}");
    }

    #[test]
    fn stretches_reach_to_the_next_points() {
        let value = vec![0.0, 0.1, 0.5, 0.0, 0.0, 0.02, -0.4];
        let t = (0..7).map(f64::from).collect();
        let course = CourseEstimate { t, value, std: vec![0.02; 7], unit: "rad".into() };
        assert_eq!(clear_stretches(&course), [[1.0, 3.0], [5.0, 6.0]]);
    }
}
