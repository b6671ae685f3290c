//! What a drive could have told of what varies as it likes: of courses drawn at random, as likely as each other.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::super::conceal::drawn;
use super::Search;
use super::climb::State;
use super::course::free_course;
use super::power::{Bar, Power, smallest};
use super::round::{LEAST_CLEAR, LEAST_HELD_GAIN};
use super::scan::Ground;
use super::trial::Trial;
use crate::explain::finding::TOLD_APART;
use crate::explain::select::LEAST_EVIDENCE;
use physics::model::effect::{Disturbance, Series};

/// Courses that are drawn, by this seed. Statistical: a chance is known to a twentieth.
const DRAWN: u64 = 100;
const SEED: u64 = 1;

/// Courses of the ordinary size over so many seconds, as likely as each other.
pub fn likely_courses(of: Disturbance, seconds: f64) -> impl Iterator<Item = Series> {
    (0..DRAWN).map(move |number| drawn(of.size, of.length_s, seconds, SEED, number))
}

/// What the points of a course leave when the ordinary numbers have taken what they can.
struct Traces<'t> {
    trial: &'t Trial,
    /// Of fitted rows, times the roots of their weights: a column for each point.
    left: DMatrix<f64>,
    /// Sums of squares and products of these, and of held-out rows.
    information: DMatrix<f64>,
    held: DMatrix<f64>,
    /// What would be known of the points: the inverse of the former with what was thought before.
    covariance: DMatrix<f64>,
    /// By how much −2 ln likelihood must fall for them beside what it falls by chance.
    price: f64,
}

impl<'t> Traces<'t> {
    fn of(ground: &Ground<'_>, trial: &'t Trial) -> Option<Self> {
        let (_, columns, stds) = ground.points(trial)?;
        let left: Vec<DVector<f64>> = columns.par_iter().map(|column| ground.left(column)).collect();
        let all = DMatrix::from_columns(&left);
        let held = DVector::from_iterator(
            all.nrows(),
            ground.rows.held.iter().map(|held| f64::from(u8::from(*held))),
        );
        let times = |by: DVector<f64>| {
            DMatrix::from_fn(all.nrows(), all.ncols(), |row, column| all[(row, column)] * by[row])
        };
        let (left, held) = (times(ground.weights.map(f64::sqrt)), times(held));
        let information = left.tr_mul(&left);
        let mut with_prior = information.clone();
        for (i, std) in stds.iter().enumerate() {
            with_prior[(i, i)] += std.powi(-2);
        }
        let factor = with_prior.cholesky()?;
        let freedom: f64 = factor.l().diagonal().iter().zip(&stds).map(|(l, std)| (l * std).ln()).sum();
        let covariance = factor.inverse();
        let by_chance = (&covariance * &information).trace();
        let price = 2.0 * freedom.max(0.0) - by_chance;
        Some(Self { trial, held: held.tr_mul(&held), left, information, covariance, price })
    }

    /// By how much −2 ln likelihood falls for such a course, and what is found of it.
    fn found(&self, course: &DVector<f64>) -> (f64, DVector<f64>) {
        let with = &self.information * course;
        let found = &self.covariance * &with;
        (with.dot(&found), found)
    }

    /// By how much it falls where this takes the place of another one's course.
    fn takes(&self, other: &Traces<'_>, course: &DVector<f64>) -> f64 {
        let with = self.left.tr_mul(&(&other.left * course));
        with.dot(&(&self.covariance * &with))
    }
}

impl Search<'_> {
    /// Of each of these courses.
    pub(super) fn course_powers(&self, state: &State<'_>, courses: &[Trial]) -> Vec<Power> {
        let short = Ground::new(self, state, self.short_colour(&state.errors));
        let all = Ground::new(self, state, state.colour.clone());
        let (Some(short), Some(all)) = (short, all) else { return Vec::new() };
        let across: Vec<Traces<'_>> = courses
            .iter()
            .filter(|trial| trial.moves_across())
            .filter_map(|trial| Traces::of(&short, trial))
            .collect();
        let of = |trial: &Trial| {
            // As the search looks at it: a zero that wanders is no noise.
            if trial.is_of_zero() {
                self.course_power(&Traces::of(&short, trial)?, &across)
            } else {
                self.course_power(&Traces::of(&all, trial)?, &[])
            }
        };
        courses.iter().filter_map(of).collect()
    }

    fn course_power(&self, of: &Traces<'_>, across: &[Traces<'_>]) -> Option<Power> {
        let (name, points) = (of.trial.name(), &of.trial.points);
        let disturbance = of.trial.candidate().and_then(free_course)?;
        let evidence = (LEAST_EVIDENCE + of.price + self.price_of_trying(&name)).max(0.0).sqrt();
        let lost_by_chance = (&of.held * &of.covariance).trace();
        let held = (LEAST_HELD_GAIN + lost_by_chance).sqrt();
        let (mut noticed, mut ways, mut rival) = (Vec::new(), Vec::new(), None::<(String, f64)>);
        for series in likely_courses(disturbance, *points.last()?) {
            let course = DVector::from_iterator(points.len(), points.iter().map(|t| series.at(*t)));
            let (gain, found) = of.found(&course);
            let square = |course: &DVector<f64>| course.dot(&(&of.held * course));
            let held_gain = square(&course) - square(&(&course - &found));
            let deviations = found.iter().enumerate().map(|(i, by)| by.abs() / of.covariance[(i, i)].sqrt());
            let mut bars = vec![
                Bar { slope: gain.sqrt(), needed: evidence },
                Bar { slope: deviations.fold(0.0, f64::max), needed: LEAST_CLEAR },
                Bar { slope: held_gain.max(0.0).sqrt(), needed: held },
            ];
            noticed.push(bars.clone());
            // All that moves the car across is one class. A zero's name needs more evidence than any of that has.
            let taken = across.iter().map(|other| (other, other.takes(of, &course)));
            if let Some((other, taken)) = taken.max_by(|a, b| (a.1 - a.0.price).total_cmp(&(b.1 - b.0.price)))
            {
                let needed = (TOLD_APART + of.price - other.price).max(0.0).sqrt();
                bars.push(Bar { slope: (gain - taken).max(0.0).sqrt(), needed });
                let alike = (taken / gain).clamp(0.0, 1.0).sqrt();
                if rival.as_ref().is_none_or(|(_, most)| *most < alike) {
                    rival = Some((other.trial.name(), alike));
                }
            }
            ways.push(bars);
        }
        Some(Power {
            name,
            number: disturbance.rms_name.into(),
            unit: disturbance.unit.into(),
            ordinary: disturbance.size,
            noticed: smallest(&noticed, disturbance.size, 0.9),
            named: smallest(&ways, disturbance.size, 0.9),
            rival,
            ways,
            neutral: 0.0,
            from_s: None,
        })
    }
}
