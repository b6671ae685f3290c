//! Scores and refits candidates.
//!
//! A scan gives the gain of each candidate to first order, after the ordinary numbers have explained what they can.
//! The best candidates are fitted together with everything else.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::candidates::Candidate;
use super::fit::{Data, Fit, Learn, Varied};
use super::model::{Free, Model, Place};
use super::tuning::TUNING;
use identify::bounded_step;
use physics::model::effect::{Growth, Kind};
use predict::grid::STEP_S;
use predict::noise::{Live, Noise};

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
    /// Of a course: how much of it follows from the driver's inputs, if that was asked.
    pub follows: Option<f64>,
}

impl<'a> Refitted<'a> {
    /// Judges a fit, whose last effect the candidate is, against the one before.
    pub fn new(before: &Fit<'_>, candidate: Candidate, fit: Fit<'a>) -> Self {
        let new = fit.free.len() - before.free.len();
        let evidence = evidence(before, &fit, new, candidate.live.is_some());
        Self { candidate, fit, evidence, follows: None }
    }

    /// Its first number, as a coordinate.
    pub fn size(&self) -> Option<f64> {
        self.fit.model.effects.last()?.numbers.first().copied()
    }

    /// When it began, s, if it was not there from the start.
    pub fn onset(&self) -> Option<f64> {
        Some(self.fit.model.effects.last()?.onset()).filter(|at| *at > 0.0)
    }

    /// The model with the moment at which it began where it fits best, within so many seconds.
    pub fn begun_within(&self, data: &Data<'_>, within_s: f64) -> Model<'a> {
        let model = &self.fit.model;
        let Some((at, place)) = self.onset().zip(self.candidate.kind.onset()) else {
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

/// Rounds of fitting before any noise is learnt. Numerical: Gauss–Newton steps.
const STRICT_ROUNDS: usize = 3;

/// The ways for a kind: of what acts in proportion the small step tells all.
pub fn ways(kind: &Kind) -> &'static [Option<f64>] {
    if kind.search.growth == Growth::Proportional {
        &TUNING.selection.steps_in_stds[..1]
    } else {
        &TUNING.selection.steps_in_stds
    }
}

/// All candidates, best first; of the same effect with different onsets only the best one.
pub fn scan(data: &Data<'_>, fit: &Fit<'_>, library: &[Candidate]) -> Vec<Scored> {
    let mut best: BTreeMap<String, Scored> = BTreeMap::new();
    let mut keep = |scored: Scored| {
        let name = scored.candidate.name();
        if best.get(&name).is_none_or(|other| other.gain < scored.gain) {
            best.insert(name, scored);
        }
    };
    let mut varied: Vec<Varied<'_>> = Vec::new();
    let mut owners: Vec<(&Candidate, Free)> = Vec::new();
    for candidate in library.iter().filter(|candidate| candidate.live.is_none()) {
        let model = fit.model.with(candidate.chosen(0));
        for free in model.free_of_effect(model.effects.len() - 1) {
            let Place::Effect(_, place) = free.place else { continue };
            if !candidate.kind.parameters[place].is_main {
                continue;
            }
            for share in ways(candidate.kind) {
                let step = Free { step: share.map_or(free.step, |share| share * free.std), ..free };
                if let Some(by) = model.moved(&step) {
                    varied.push(by);
                    owners.push((candidate, free));
                }
            }
        }
    }
    let normal = Normal::new(data, fit, &varied);
    for (column, (candidate, free)) in owners.into_iter().enumerate() {
        if let Some(scored) = normal.score(candidate, column, free) {
            keep(scored);
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
    let free = before.free_with(&model);
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
    let place = candidate.kind.onset().filter(|place| at(&fit.model, *place) > 0.0);
    let refined = match place {
        None => data.go_on(fit, rounds),
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
pub fn begun_at<'a>(
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

/// No onset is less certain, s. Numerical: where the search for it ends.
const MOST_ONSET_STD_S: f64 = 10.0;

/// What the size and the length of a course are worth, which were searched for, too. Statistical: e⁴, some fifty pairs
/// that they could be.
pub const OF_A_COURSE: f64 = 8.0;

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
    gain - freedom - if is_live { OF_A_COURSE } else { 0.0 }
}

/// The normal equations of ordinary numbers, and candidates beside them, each alone.
struct Normal {
    /// Products of the innovations with the ordinary numbers' derivatives.
    gradient: DVector<f64>,
    /// [`BlockSums::alone`](predict::sums::BlockSums::alone).
    alone: DMatrix<f64>,
    /// Covariance of the ordinary numbers.
    inverse: DMatrix<f64>,
}

impl Normal {
    fn new(data: &Data<'_>, fit: &Fit<'_>, candidates: &[Varied<'_>]) -> Self {
        let ordinary: Vec<Varied<'_>> = fit.free.iter().map(|free| fit.model.varied(free)).collect();
        let sums = data.pass_beside(&fit.model, &ordinary, candidates, &fit.noise);
        let (mut own, gradient) = data.normal(&sums, &fit.model, &fit.free);
        let mut alone = DMatrix::zeros(ordinary.len() + 2, candidates.len());
        for sum in data.counted(&sums).filter(|sum| !sum.alone.is_empty()) {
            alone += &sum.alone;
        }
        // What ordinary numbers cannot reach without leaving their bounds they do not explain.
        let room: Vec<_> = fit.free.iter().map(|free| fit.model.room(free.place)).collect();
        if let Some(step) = bounded_step(&own, &gradient, &room) {
            for (place, (step, room)) in step.iter().zip(room).enumerate() {
                if *step == room.0 || *step == room.1 {
                    own[(place, place)] *= 1e12;
                }
            }
        }
        let count = ordinary.len();
        let inverse = own.cholesky().map_or_else(|| DMatrix::zeros(count, count), |c| c.inverse());
        Self { gradient, alone, inverse }
    }

    /// Gain and coordinate of a candidate's number, the ordinary ones refitted.
    fn score(&self, candidate: &Candidate, column: usize, free: Free) -> Option<Scored> {
        let own = self.alone.column(column);
        let with = own.rows(1, own.len() - 2);
        let taken = &self.inverse * with;
        let gradient = own[0] - taken.dot(&self.gradient);
        let information = own[own.len() - 1] - taken.dot(&with) + free.std.powi(-2);
        let Place::Effect(_, place) = free.place else { return None };
        let step = (information > 0.0).then(|| gradient / information)?;
        let ordinary = &self.inverse * &self.gradient - taken * step;
        Some(Scored {
            candidate: candidate.clone(),
            gain: gradient * step,
            numbers: vec![(place, free.mean + step)],
            ordinary: ordinary.iter().copied().collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{fitted, recorded, training};
    use super::super::candidates::{library, onsets};
    use super::*;
    use physics::model::effect::KINDS;
    use predict::GriddedDrive;

    /// Scans a drive with effects concealed, and fits the best candidate.
    fn best(effects: &str) -> (String, f64, Vec<f64>) {
        let (vehicle, recording) = recorded(effects);
        let drives = [GriddedDrive::new(&recording, &vehicle)];
        let data = training(&drives);
        let plain = fitted(&data, &vehicle);
        let library = library(KINDS, &plain.model, |_| true, &onsets(drives[0].seconds()));
        let scanned = scan(&data, &plain, &library);
        let named = refit(&data, &plain, (&plain, Learn::Noise), &scanned[0], 4);
        let values = named.fit.model.effects[0].values();
        (named.candidate.name(), named.evidence, values)
    }

    #[test]
    #[ignore = "long: a car fitted, and more"]
    fn a_steering_that_lags_is_named_with_its_time_constant() {
        let (name, evidence, values) = best("[[effect]]\nkind = \"steering_lag\"\ntime_constant_s = 0.08");
        assert_eq!(name, "steering_lag");
        assert!(evidence > 100.0, "{evidence}");
        assert!((values[0] - 0.08).abs() < 0.01, "{values:?}");
    }

    mod by_hand {
        use super::*;

        #[test]
        #[ignore = "by hand, as `causes` has it: the whole library scanned"]
        fn where_nothing_is_concealed_nothing_is_worth_a_name() {
            let (name, evidence, _) = best("");
            assert!(evidence < crate::explain::select::LEAST_EVIDENCE, "{name}: {evidence}");
        }
    }
}
