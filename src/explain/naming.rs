//! Which effect is it? Every candidate is scored after all that ordinary numbers could explain is taken
//! out; the best ones are fitted together with everything else.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::candidates::Candidate;
use super::fit::{Data, Fit, Learn, within_bounds};
use super::model::{Free, Model, Place};
use super::predict::drive::STEP_S;
use super::predict::noise::{Live, Noise};

/// A candidate with its score.
#[derive(Clone, Debug)]
pub struct Scored {
    /// What.
    pub candidate: Candidate,
    /// By how much −2 ln likelihood would fall, to first order.
    pub gain: f64,
    /// Coordinates of its main numbers, to first order.
    pub numbers: Vec<(usize, f64)>,
    /// What the ordinary numbers would change by then.
    pub ordinary: Vec<f64>,
}

/// A candidate fitted together with all ordinary numbers.
#[derive(Clone, Debug)]
pub struct Refitted<'a> {
    /// What.
    pub candidate: Candidate,
    /// The whole fit.
    pub fit: Fit<'a>,
    /// Twice the logarithm of how much more probable the data are with it than without, its prior
    /// counted in.
    pub evidence: f64,
}

impl<'a> Refitted<'a> {
    /// Judges a fit, whose last effect the candidate is, against the one before.
    pub fn new(before: &Fit<'_>, candidate: Candidate, fit: Fit<'a>) -> Self {
        let new = fit.free.len() - before.free.len();
        let evidence = evidence(before, &fit, new, candidate.live.is_some());
        Self { candidate, fit, evidence }
    }

    /// When it began, s, if it was not there from the start.
    pub fn onset(&self) -> Option<f64> {
        Some(self.fit.model.effects.last()?.onset()).filter(|at| *at > 0.0)
    }

    /// The model with the moment at which it began where it fits best, within so many seconds.
    pub fn begun_within(&self, data: &Data<'_>, within_s: f64) -> Model<'a> {
        let model = &self.fit.model;
        let Some((at, place)) = self.onset().zip(self.candidate.kind.place_of("at_s")) else {
            return model.clone();
        };
        let steps = within_s as i32;
        let tried = (-steps..=steps).into_par_iter().map(|by| {
            begun_at(
                data,
                model,
                &self.fit.noise,
                model.effects.len() - 1,
                place,
                (at + f64::from(by)).max(0.0),
            )
        });
        tried.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(|| model.clone(), |best| best.1)
    }
}

/// Rounds of fitting before any noise is learnt.
const STRICT_ROUNDS: usize = 3;

/// How far a candidate's numbers are moved to see its influence, in standard deviations of their priors;
/// first a small step. What grows with the square, or begins at a threshold, shows only in a large one.
const WAYS: [Option<f64>; 4] = [None, Some(0.7), Some(2.0), Some(-2.0)];

/// The ways for a candidate: a zero that jumps acts in proportion, of it the small step tells all.
fn ways(candidate: &Candidate) -> &'static [Option<f64>] {
    if candidate.kind.name == "sensor_bias" { &WAYS[..1] } else { &WAYS }
}

/// All candidates, best first; of the same effect with different onsets only the best one.
pub fn scan(data: &Data<'_>, fit: &Fit<'_>, library: &[Candidate]) -> Vec<Scored> {
    let ordinary: Vec<(Model<'_>, f64)> = fit.free.iter().map(|free| fit.model.varied(free)).collect();
    let mut best: BTreeMap<String, Scored> = BTreeMap::new();
    let mut keep = |scored: Scored| {
        let name = scored.candidate.name();
        if best.get(&name).is_none_or(|other| other.gain < scored.gain) {
            best.insert(name, scored);
        }
    };
    // So many at a time, for memory.
    for some in library.chunks(64) {
        let mut varied = ordinary.clone();
        let mut owners: Vec<(usize, usize, Free)> = Vec::new();
        for (number, candidate) in some.iter().enumerate().filter(|(_, c)| c.live.is_none()) {
            let model = fit.model.with(candidate.chosen(0));
            for free in model.free_of_effect(model.effects.len() - 1) {
                let Place::Effect(_, place) = free.place else { continue };
                let spec = &candidate.kind.parameters[place];
                if !spec.is_main {
                    continue;
                }
                for (way, share) in ways(candidate).iter().enumerate() {
                    let step = Free { step: share.map_or(free.step, |share| share * free.std), ..free };
                    if let Some(by) = model.moved(&step) {
                        varied.push(by);
                        owners.push((number, way, free));
                    }
                }
            }
        }
        let normal = Normal::new(data, fit, &varied);
        for (number, candidate) in some.iter().enumerate().filter(|(_, c)| c.live.is_none()) {
            for way in 0..WAYS.len() {
                let own = owners.iter().enumerate().filter(|(_, owner)| (owner.0, owner.1) == (number, way));
                let columns: Vec<(usize, Free)> = own.map(|(place, owner)| (place, owner.2)).collect();
                if !columns.is_empty()
                    && let Some(scored) = normal.score(candidate, &columns)
                {
                    keep(scored);
                }
            }
        }
    }
    let live: Vec<Scored> = library
        .par_iter()
        .filter_map(|candidate| {
            let live = candidate.live?;
            let model = fit.model.with(candidate.chosen(fit.noise.live.len()));
            // What the equations seem to miss may be just this: so it is tried with less of that, too.
            let tried = [(0.1, 2.0, 0.1), (0.4, 0.7, 1.0), (0.4, 2.0, 0.1), (1.0, 0.7, 0.1)].map(
                |(size, length, less)| {
                    let length_s = (live.length_s * length).max(live.least_s);
                    let live = Live { size: live.size * size, length_s, ..live };
                    let mut noise = fit.noise.with(live);
                    for (diffusion, least) in noise.diffusion.iter_mut().zip(Noise::LEAST_DIFFUSION) {
                        *diffusion = (*diffusion * less).max(2.0 * least);
                    }
                    let sums = data.pass(&model, &[], &noise);
                    (fit.minus_two_ln - data.minus_two_ln(&sums), live)
                },
            );
            let (gain, live) = tried.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
            let candidate = Candidate { live: Some(live), ..candidate.clone() };
            Some(Scored { candidate, gain, numbers: Vec::new(), ordinary: Vec::new() })
        })
        .collect();
    for scored in live {
        keep(scored);
    }
    let mut all: Vec<Scored> = best.into_values().collect();
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all
}

/// Fits a candidate together with all that was free before, from the fit at which it was scored; if that had
/// not learnt its noise, first without learning any, too.
pub fn refit<'a>(
    data: &Data<'_>,
    before: &Fit<'a>,
    (at, learn): (&Fit<'a>, Learn),
    scored: &Scored,
    rounds: usize,
) -> Refitted<'a> {
    let mut model = at.model.with(scored.candidate.chosen(at.noise.live.len()));
    let effect = model.effects.len() - 1;
    let mut noise = at.noise.clone();
    if let Some(live) = scored.candidate.live {
        noise = noise.with(live);
    }
    let own = model.free_of_effect(effect);
    if !scored.numbers.is_empty() {
        // The first order may be far off where the influence is not linear: from less, too.
        let starts = [1.0, 0.5, 0.25, 0.05].map(|share| {
            let mut model = model.clone();
            for (place, number) in &scored.numbers {
                let Some(free) = own.iter().find(|free| free.place == Place::Effect(effect, *place)) else {
                    continue;
                };
                let by = (share * (number - free.mean)).clamp(-3.0 * free.std, 3.0 * free.std);
                // At nothing at all some have no derivative.
                let by = if by.abs() < free.step { free.step.copysign(by) } else { by };
                model.set(free.place, free.mean + by);
            }
            for (free, by) in at.free.iter().zip(&scored.ordinary) {
                model.set(free.place, at.model.get(free.place) + share * by);
            }
            let cost = data.minus_two_ln(&data.pass(&model, &[], &noise));
            (if cost.is_finite() { cost } else { f64::INFINITY }, model)
        });
        let best = starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, start)) = best {
            model = start;
        }
    }
    let free: Vec<Free> = before.free.iter().copied().chain(own.iter().copied()).collect();
    if learn == Learn::Nothing {
        model = data.search(&model, &free, &noise, STRICT_ROUNDS, learn).model;
    }
    let fit = data.fit(&model, &free, &noise, rounds);
    Refitted::new(before, scored.candidate.clone(), fit)
}

/// Goes on with a fit, the moment at which the effect began free as well.
pub fn refine<'a>(data: &Data<'_>, before: &Fit<'a>, refitted: &Refitted<'a>, rounds: usize) -> Refitted<'a> {
    let Refitted { candidate, fit, .. } = refitted;
    let effect = fit.model.effects.len() - 1;
    let again = |model: &Model<'a>, rounds| data.fit(model, &fit.free, &fit.noise, rounds);
    // It was on a grid so far.
    let at = |model: &Model<'_>, place: usize| model.effects[effect].numbers[place];
    let place = candidate.kind.place_of("at_s").filter(|place| at(&fit.model, *place) > 0.0);
    let refined = match place {
        None => again(&fit.model, rounds),
        Some(place) => {
            let nearby = again(&onset(data, fit, effect, place), rounds);
            let closer = onset(data, &nearby, effect, place);
            if at(&closer, place) == at(&nearby.model, place) { nearby } else { again(&closer, 2) }
        }
    };
    let best = if refined.cost() < fit.cost() { refined } else { fit.clone() };
    Refitted::new(before, candidate.clone(), best)
}

/// The model with the moment at which an effect begins where it fits best, nearby.
pub fn onset<'a>(data: &Data<'_>, fit: &Fit<'a>, effect: usize, place: usize) -> Model<'a> {
    let mut best = (fit.minus_two_ln, fit.model.clone());
    let mut step = 3.0;
    while step > 0.04 {
        let at = best.1.effects[effect].numbers[place];
        let tried: Vec<(f64, Model<'a>)> = [at - step, at + step]
            .into_par_iter()
            .map(|at| begun_at(data, &best.1, &fit.noise, effect, place, at))
            .collect();
        let better = tried.into_iter().filter(|(cost, _)| *cost < best.0).min_by(|a, b| a.0.total_cmp(&b.0));
        match better {
            Some(better) => best = better,
            None => step *= 0.5,
        }
    }
    best.1
}

/// The model with an effect beginning at another moment, after what −2 ln likelihood is with it.
fn begun_at<'a>(
    data: &Data<'_>,
    model: &Model<'a>,
    noise: &Noise,
    effect: usize,
    place: usize,
    at: f64,
) -> (f64, Model<'a>) {
    let mut model = model.clone();
    model.effects[effect].numbers[place] = at;
    (data.minus_two_ln(&data.pass(&model, &[], noise)), model)
}

/// Standard deviation of the moment at which an effect begins, s: how far to either side −2 ln likelihood
/// rises by one, the rest of the model kept; within the grid nobody can tell.
pub fn onset_std(data: &Data<'_>, fit: &Fit<'_>, effect: usize, place: usize) -> f64 {
    let at = fit.model.effects[effect].numbers[place];
    let side = |sign: f64| {
        let mut by = 0.01;
        loop {
            let moved = begun_at(data, &fit.model, &fit.noise, effect, place, at + sign * by);
            let rise = moved.0 - fit.minus_two_ln;
            if rise > 1.0 || by > MOST_ONSET_STD_S {
                return by / rise.max(1.0).sqrt();
            }
            by *= 2.0;
        }
    };
    f64::max(side(-1.0), side(1.0)).hypot(STEP_S)
}

/// No onset is less certain, s.
const MOST_ONSET_STD_S: f64 = 10.0;

/// Laplace's approximation: the gain less what the new numbers' freedom is worth.
fn evidence(before: &Fit<'_>, after: &Fit<'_>, new: usize, is_live: bool) -> f64 {
    let gain = before.cost() - after.cost();
    let count = after.free.len();
    let freedom: f64 = (count - new..count)
        .map(|place| {
            let posterior = after.covariance.get((place, place)).copied().unwrap_or(0.0);
            (after.free[place].std.powi(2) / posterior.max(1e-300)).ln().max(0.0)
        })
        .sum();
    // Size and length of a course were searched for, too.
    gain - freedom - if is_live { 8.0 } else { 0.0 }
}

/// The normal equations of ordinary numbers and candidates.
struct Normal {
    gram: DMatrix<f64>,
    ordinary: usize,
    inverse: DMatrix<f64>,
}

impl Normal {
    fn new(data: &Data<'_>, fit: &Fit<'_>, varied: &[(Model<'_>, f64)]) -> Self {
        let sums = data.pass(&fit.model, varied, &fit.noise);
        let ordinary = fit.free.len();
        let mut gram = DMatrix::zeros(varied.len() + 1, varied.len() + 1);
        for sum in data.counted(&sums) {
            gram += &sum.gram;
        }
        for (place, free) in fit.free.iter().enumerate() {
            let weight = 1.0 / (free.std * free.std);
            gram[(place + 1, place + 1)] += weight;
            gram[(place + 1, 0)] += weight * (free.mean - fit.model.get(free.place));
        }
        let mut own = gram.view((1, 1), (ordinary, ordinary)).into_owned();
        // What ordinary numbers cannot reach without leaving their bounds they do not explain.
        let gradient = DVector::from_fn(ordinary, |place, _| gram[(place + 1, 0)]);
        let _ = within_bounds(&fit.model, &fit.free, &mut own, &gradient);
        let inverse = own.cholesky().map_or_else(|| DMatrix::zeros(ordinary, ordinary), |c| c.inverse());
        Self { gram, ordinary, inverse }
    }

    /// Gain and coordinates of some columns together, the ordinary numbers refitted.
    fn score(&self, candidate: &Candidate, columns: &[(usize, Free)]) -> Option<Scored> {
        let n = self.ordinary;
        let count = columns.len();
        let at = |i: usize| n + 1 + columns[i].0;
        let with = |i: usize| self.gram.view((1, at(i)), (n, 1));
        let own = self.gram.view((1, 0), (n, 1));
        let mut information = DMatrix::zeros(count, count);
        let mut gradient = DVector::zeros(count);
        for i in 0..count {
            let taken = &self.inverse * with(i);
            gradient[i] = self.gram[(at(i), 0)] - taken.dot(&own);
            for j in 0..count {
                information[(i, j)] = self.gram[(at(i), at(j))] - taken.dot(&with(j));
            }
            information[(i, i)] += columns[i].1.std.powi(-2);
        }
        let step = information.cholesky()?.solve(&gradient);
        let gain = gradient.dot(&step);
        let numbers = columns.iter().zip(step.iter()).filter_map(|((_, free), step)| match free.place {
            Place::Effect(_, place) => Some((place, free.mean + step)),
            _ => None,
        });
        let mut rest = own.into_owned();
        for (i, step) in step.iter().enumerate() {
            rest -= with(i) * *step;
        }
        let ordinary = &self.inverse * rest;
        Some(Scored {
            candidate: candidate.clone(),
            gain,
            numbers: numbers.collect(),
            ordinary: ordinary.iter().copied().collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{fitted, recorded, training};
    use super::super::candidates::{library, onsets};
    use super::super::predict::Drive;
    use super::*;
    use crate::model::effect::KINDS;

    /// Scans a drive with effects concealed, and fits the best candidate.
    fn best(effects: &str) -> (String, f64, Vec<f64>) {
        let (vehicle, recording) = recorded(effects);
        let drives = [Drive::new(&recording, &vehicle)];
        let data = training(&drives);
        let plain = fitted(&data, &vehicle);
        let library = library(KINDS, &plain.model, |_| true, &onsets(drives[0].seconds()));
        let scanned = scan(&data, &plain, &library);
        let named = refit(&data, &plain, (&plain, Learn::Noise), &scanned[0], 4);
        let values = named.fit.model.effects[0].values();
        (named.candidate.name(), named.evidence, values)
    }

    #[test]
    fn a_steering_that_lags_is_named_with_its_time_constant() {
        let (name, evidence, values) = best("[[effect]]\nkind = \"steering_lag\"\ntime_constant_s = 0.08");
        assert_eq!(name, "steering_lag");
        assert!(evidence > 100.0, "{evidence}");
        assert!((values[0] - 0.08).abs() < 0.01, "{values:?}");
    }

    #[test]
    fn where_nothing_is_concealed_nothing_is_worth_a_name() {
        let (name, evidence, _) = best("");
        assert!(evidence < super::super::select::LEAST_EVIDENCE, "{name}: {evidence}");
    }
}
