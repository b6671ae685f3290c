//! What an answer owes to the numbers that were held while few were searched for.
//!
//! Whoever asks for some parameters takes the others, sensors' offsets among them, for known. Where they are not, what was
//! asked for makes up for them, with an interval that knows nothing of that. Freeing them too shows it (Hausman's test of a
//! specification, 1978): estimates that differ by more than their variances can are not of the same thing.

use nalgebra::{DMatrix, DVector};

use super::fit::{Fit, Noise, Search};
use super::free::{Free, Tied};
use super::parameter::Parameter;
use super::uncertainty;

/// Where estimates go when what was held is free, too.
#[derive(Clone, Debug)]
pub(super) struct Freed {
    /// Coordinates of what was asked for, and their standard deviations.
    theta: DVector<f64>,
    std: DVector<f64>,
    /// What was held and moved most, by its standard deviations of before.
    most: Option<Parameter>,
}

/// Deviations of the difference beyond which it is none of chance. Statistical: 0.3 %.
const BEYOND_CHANCE: f64 = 3.0;

/// Searches on from an end with what was held. None where nothing was, or where that comes to no end.
pub(super) fn freed(search: &Search<'_>, end: &Fit, held: &[Free], usual: &Noise) -> Option<Freed> {
    if held.is_empty() {
        return None;
    }
    let all: Vec<Free> = search.free.iter().chain(held).copied().collect();
    let wider = Search { free: &all, ..*search };
    let fit = wider.with_more(end, held.iter().map(|free| free.mean), usual)?;
    let covariance = covariance(&fit, &all)?;
    let asked = search.free.len();
    let std = DVector::from_fn(asked, |i, _| covariance[(i, i)].sqrt());
    let moved = |place: usize| {
        let free = &all[asked + place];
        let scale = if free.std.is_finite() { free.std } else { 1.0 };
        ((fit.point.theta[asked + place] - free.mean) / scale).abs()
    };
    let most = (0..held.len()).max_by(|a, b| moved(*a).total_cmp(&moved(*b)));
    Some(Freed {
        theta: fit.point.theta.rows(0, asked).into_owned(),
        std,
        most: most.map(|place| held[place].parameters.first()),
    })
}

fn covariance(fit: &Fit, free: &[Free]) -> Option<DMatrix<f64>> {
    let inverse = fit.all.eliminate(0.0)?.information.cholesky()?.inverse();
    Some(uncertainty::overstated(fit, free)? * inverse)
}

/// How one stiffness of both axles is to be read: how to ask for each, and what each is where the recordings tell them apart.
pub(super) fn of_both(search: &Search<'_>, end: &Fit, each: [Free; 2], usual: &Noise) -> String {
    let [front, rear] = each.map(|free| free.parameters.name());
    let apart = apart(search, end, each, usual).map_or_else(String::new, |apart| format!("; {apart}"));
    format!("one value for both axles (--parameters {front},{rear} for each){apart}")
}

/// The stiffness of each axle where their difference is none of chance.
fn apart(search: &Search<'_>, end: &Fit, [front, rear]: [Free; 2], usual: &Noise) -> Option<String> {
    let place = search.free.iter().position(|free| free.parameters == Tied::BothLateral)?;
    let mut all = search.free.to_vec();
    all[place] = front;
    all.push(rear);
    let wider = Search { free: &all, ..*search };
    let fit = wider.with_more(end, std::iter::once(end.point.theta[place]), usual)?;
    let covariance = covariance(&fit, &all)?;
    let places = [place, all.len() - 1];
    let [front_at, rear_at] = places.map(|place| fit.point.theta[place]);
    let [of_front, of_rear, common] =
        [(0, 0), (1, 1), (0, 1)].map(|(a, b)| covariance[(places[a], places[b])]);
    let std = (of_front + of_rear - 2.0 * common).max(0.0).sqrt();
    let differ = (front_at - rear_at).abs() > BEYOND_CHANCE * std;
    if !differ {
        return None;
    }
    let said = |free: &Free, at: f64, variance: f64| {
        let value = free.value(at);
        format!("{} ± {}", short(value), short(variance.sqrt() * free.parameters.value_by_coordinate(at)))
    };
    Some(format!(
        "the axles differ: with each of them free the front is {}, the rear {}",
        said(&front, front_at, of_front),
        said(&rear, rear_at, of_rear)
    ))
}

impl Freed {
    /// Why a number is not to be believed, where it is so far from what it is when nothing is held: coordinate, half of its
    /// interval and standard deviation of the one.
    pub(super) fn against(
        &self,
        place: usize,
        free: &Free,
        (at, half, std): (f64, f64, f64),
    ) -> Option<String> {
        let apart = (self.theta[place] - at).abs();
        let by_chance = (self.std[place].powi(2) - std * std).max(0.0).sqrt();
        if apart <= half.max(BEYOND_CHANCE * by_chance) {
            return None;
        }
        let value = free.value(self.theta[place]);
        let std = self.std[place] * free.parameters.value_by_coordinate(self.theta[place]);
        let most = self.most.map_or_else(String::new, |most| format!(", {} most of all", most.name()));
        Some(format!(
            "it makes up for numbers that were held{most}: with all of them free it is {} ± {}",
            short(value),
            short(std)
        ))
    }
}

/// Three digits.
fn short(value: f64) -> String {
    let digits = (2 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}
