//! Maximum-likelihood fit of a model to drives: its numbers and its noise, by the likelihood of the innovations.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::model::{Free, Model, Place};
use super::split::{Part, Split};
use identify::bounded_step;
use predict::GriddedDrive;
use predict::car::BODY_STATES;
use predict::noise::Noise;
use predict::pass::{Beside, Other, pass_run};
use predict::sums::{BlockSums, PassOptions};

/// A number goes no farther in one step than so many standard deviations of its prior. Numerical: beyond, equations that are
/// not linear say little.
const FARTHEST: f64 = 4.0;

/// The drives and which of their blocks may be looked at.
#[derive(Clone, Debug)]
pub struct Data<'a> {
    /// All drives.
    pub drives: &'a [GriddedDrive],
    /// Their blocks.
    pub split: Split,
    /// Which of them count.
    pub part: Part,
    /// Noise of the sensors as it shows from one reading to the next.
    pub own_noise: Noise,
    /// Which share of the recordings the drives go over: less than 1, if they are an excerpt. So much evidence is asked for; more
    /// than 1, where evidence counts for less.
    pub share: f64,
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fit<'a> {
    /// With its numbers.
    pub model: Model<'a>,
    /// With its noise.
    pub noise: Noise,
    /// What was free.
    pub free: Vec<Free>,
    /// −2 ln likelihood, without prior.
    pub minus_two_ln: f64,
    /// What the prior adds.
    pub prior: f64,
    /// Covariance of the free numbers, in their coordinates.
    pub covariance: DMatrix<f64>,
    /// Sums of the last pass, block by block.
    pub sums: Vec<BlockSums>,
}

/// A model with one number changed, and by how much.
pub type Varied<'a> = (Model<'a>, f64);

/// What a search changes beside the free numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learn {
    /// Noise of sensors and equations.
    Noise,
    /// The same where it was learnt from an excerpt before: little is left to learn.
    Rest,
    /// Nothing.
    Nothing,
}

/// A step that helps.
struct Stepped<'a> {
    model: Model<'a>,
    sums: Vec<BlockSums>,
    /// By so much the cost fell.
    gained: f64,
}

impl Fit<'_> {
    /// What a search makes as small as it can: −2 ln likelihood with the prior.
    pub fn cost(&self) -> f64 {
        self.minus_two_ln + self.prior
    }

    /// How far the main numbers of an effect are from nothing, each with its place among what is free, if it was fitted.
    pub fn main_numbers(&self, effect: usize) -> impl Iterator<Item = (f64, Option<usize>)> {
        let of = &self.model.effects[effect];
        let numbers = of.specs().zip(&of.numbers).enumerate().filter(|(_, (spec, _))| spec.is_main);
        numbers.map(move |(at, (spec, number))| {
            let place = self.free.iter().position(|free| free.place == Place::Effect(effect, at));
            (number - spec.mean, place)
        })
    }

    /// What is free of a model that has more effects than this one: theirs, too.
    pub fn free_with(&self, model: &Model<'_>) -> Vec<Free> {
        let more = self.model.effects.len()..model.effects.len();
        self.free.iter().copied().chain(more.flat_map(|effect| model.free_of_effect(effect))).collect()
    }
}

impl<'d> Data<'d> {
    /// An excerpt of the same drives.
    pub fn over<'e>(&self, excerpt: &'e [GriddedDrive]) -> Data<'e> {
        let seconds = |drives: &[GriddedDrive]| drives.iter().map(GriddedDrive::used_seconds).sum::<f64>();
        Data {
            drives: excerpt,
            split: self.split.clone(),
            part: self.part,
            own_noise: self.own_noise.clone(),
            share: self.share * seconds(excerpt) / seconds(self.drives).max(1.0),
        }
    }

    /// The same drives, another part.
    pub fn of(&self, part: Part) -> Self {
        Self { part, ..self.clone() }
    }

    /// One pass over all drives.
    pub fn pass(&self, model: &Model<'_>, varied: &[Varied<'_>], noise: &Noise) -> Vec<BlockSums> {
        self.pass_beside(model, varied, &[], noise)
    }

    /// One pass over all drives, with more cars beside it, each to be looked at alone.
    pub fn pass_beside(
        &self,
        model: &Model<'_>,
        varied: &[Varied<'_>],
        alone: &[Varied<'_>],
        noise: &Noise,
    ) -> Vec<BlockSums> {
        let car = model.car();
        let other = |(other, by): &Varied<'_>| Other {
            car: other.car(),
            by: *by,
            same_until: model.same_until(other),
        };
        let others = |varied: &[Varied<'_>]| varied.iter().map(other).collect::<Vec<_>>();
        let (together, alone) = (others(varied), others(alone));
        let beside = Beside { together: &together, alone: &alone };
        let drives = self.drives.iter().enumerate();
        let runs: Vec<_> =
            drives.flat_map(|drive| drive.1.runs.iter().map(move |run| (drive, *run))).collect();
        let one = |(drive, run)| pass_run(drive, run, &car, beside, noise, &mut PassOptions::default());
        runs.into_par_iter().flat_map_iter(one).collect()
    }

    /// The sums that count.
    pub fn counted<'s>(
        &self,
        sums: &'s [BlockSums],
    ) -> impl Iterator<Item = &'s BlockSums> + use<'_, 's, 'd> {
        sums.iter().filter(|sum| self.split.counts(self.part, sum.drive, 0.5 * (sum.t.0 + sum.t.1)))
    }

    /// −2 ln likelihood of what counts.
    pub fn minus_two_ln(&self, sums: &[BlockSums]) -> f64 {
        self.counted(sums).map(|sum| sum.log_s + sum.square.iter().sum::<f64>()).sum()
    }

    /// How much each equation misses: twice the log-likelihood ratio of its diffusion against the least there
    /// is (Kristensen, Madsen & Jørgensen 2004).
    pub fn missing(&self, fit: &Fit<'_>) -> [f64; BODY_STATES] {
        let missing = |place: usize| {
            let mut noise = fit.noise.clone();
            noise.diffusion[place] = Noise::LEAST_DIFFUSION[place];
            let without = self.minus_two_ln(&self.pass(&fit.model, &[], &noise));
            (without - fit.minus_two_ln).max(0.0)
        };
        let mut all = [0.0; BODY_STATES];
        all.par_iter_mut().enumerate().for_each(|(place, value)| *value = missing(place));
        all
    }

    /// Variances of a fit's free numbers, in their coordinates: as the curvature of the likelihood has them, or,
    /// where that is more, as the scatter of its slope from block to block has them. The latter sees what the
    /// former believes not to be there: errors that go on for a while (White 1982). Never more than was
    /// thought before.
    pub fn variances(&self, fit: &Fit<'_>) -> Vec<f64> {
        let count = fit.free.len();
        let before = fit.free.iter().map(|free| free.std * free.std);
        if fit.covariance.nrows() != count {
            return before.collect();
        }
        let mut scatter = DMatrix::zeros(count, count);
        for sum in self.counted(&fit.sums) {
            let slope = sum.gram.view((1, 0), (count, 1));
            scatter += slope * slope.transpose();
        }
        let robust = &fit.covariance * scatter * &fit.covariance;
        let after = fit.covariance.diagonal().sup(&robust.diagonal());
        before.zip(after.iter()).map(|(before, after)| after.min(before)).collect()
    }

    /// Fits until nothing gets better any more, noise included: what candidates are measured against must
    /// have no room left of its own.
    pub fn fit_thoroughly<'a>(&self, model: &Model<'a>, free: &[Free], noise: &Noise) -> Fit<'a> {
        let mut best = self.fit(model, free, noise, 8);
        // Much noise of the equations hides that there is little: from that end, too.
        let other = self.fit_strictly(&best, 4);
        let other = self.fit(&other.model, free, &other.noise, 4);
        if other.cost() < best.cost() {
            best = other;
        }
        for _ in 0..4 {
            let (noise, _) = self.diffusion(&best.model, (&best.noise, best.minus_two_ln), &[4.0, 2.0]);
            let next = self.fit(&best.model, free, &noise, 5);
            let gained = best.cost() - next.cost();
            if gained > 0.0 {
                best = next;
            }
            if gained < 1.0 {
                break;
            }
        }
        best
    }

    /// Fits the free numbers and the noise, from where the model is.
    pub fn fit<'a>(&self, model: &Model<'a>, free: &[Free], noise: &Noise, rounds: usize) -> Fit<'a> {
        self.search(model, free, noise, rounds, Learn::Noise)
    }

    /// The same; each round is told when it begins.
    pub fn fit_watched<'a>(
        &self,
        model: &Model<'a>,
        free: &[Free],
        noise: &Noise,
        rounds: usize,
        told: &dyn Fn(usize),
    ) -> Fit<'a> {
        let sums = self.derived(model, free, noise);
        self.steps((model.clone(), noise.clone(), sums), free, rounds, Learn::Noise, told)
    }

    /// Goes on with a fit to the same drives: what it ended with is known.
    pub fn go_on<'a>(&self, fit: &Fit<'a>, rounds: usize) -> Fit<'a> {
        let from = (fit.model.clone(), fit.noise.clone(), fit.sums.clone());
        self.steps(from, &fit.free, rounds, Learn::Noise, &|_| ())
    }

    /// Goes on with a fit to an excerpt.
    pub fn fit_again<'a>(&self, fit: &Fit<'a>, rounds: usize) -> Fit<'a> {
        self.search(&fit.model, &fit.free, &fit.noise, rounds, Learn::Rest)
    }

    /// Fits the numbers of a model to equations that hardly err: noise of the equations forgives what a
    /// model misses, and what forgives much tells little of which way to go.
    pub fn fit_strictly<'a>(&self, from: &Fit<'a>, rounds: usize) -> Fit<'a> {
        self.search(&from.model, &from.free, &self.strict(&from.noise), rounds, Learn::Nothing)
    }

    /// Sensors as good as their readings look, equations that hardly err.
    pub fn strict(&self, noise: &Noise) -> Noise {
        let diffusion = Noise::LEAST_DIFFUSION.map(|least| 2.0 * least);
        Noise {
            diffusion,
            slip: 2.0 * Noise::LEAST_SLIP,
            sensor: self.own_noise.sensor,
            live: noise.live.clone(),
        }
    }

    /// Gauss–Newton steps, the noise learnt in between or not.
    pub fn search<'a>(
        &self,
        model: &Model<'a>,
        free: &[Free],
        noise: &Noise,
        rounds: usize,
        learn: Learn,
    ) -> Fit<'a> {
        let sums = self.derived(model, free, noise);
        self.steps((model.clone(), noise.clone(), sums), free, rounds, learn, &|_| ())
    }

    /// One pass over all drives with the derivatives by the free numbers.
    fn derived(&self, model: &Model<'_>, free: &[Free], noise: &Noise) -> Vec<BlockSums> {
        self.pass(model, &free.iter().map(|free| model.varied(free)).collect::<Vec<_>>(), noise)
    }

    /// A search from a model and noise with their derivatives.
    fn steps<'a>(
        &self,
        (mut model, mut noise, mut sums): (Model<'a>, Noise, Vec<BlockSums>),
        free: &[Free],
        rounds: usize,
        learn: Learn,
        told: &dyn Fn(usize),
    ) -> Fit<'a> {
        // The sums are always those of model and noise as they are.
        let mut last = None;
        let mut is_stuck = false;
        for round in 0..rounds {
            told(round);
            let (information, gradient) = self.normal(&sums, &model, free);
            let Some(inverse) = information.clone().cholesky().map(|c| c.inverse()) else { break };
            let Some(step) = bounded_step(&information, &gradient, &limits(&model, free)) else { break };
            last = Some(inverse);
            let before = self.minus_two_ln(&sums);
            let mut value = before;
            // What did not help does not help again.
            let better = if is_stuck { None } else { self.stepped(&model, free, &noise, (&step, before)) };
            let gained = better.as_ref().map_or(0.0, |better| better.gained);
            if let Some(better) = better {
                model = better.model;
                value = self.minus_two_ln(&better.sums);
                if learn != Learn::Nothing {
                    (noise, value) = self.with_sensors(&model, &better.sums, (&noise, value));
                }
            }
            // The noise settles with the numbers: now and then is enough.
            let factor = match (learn, round) {
                (Learn::Noise, 0) => Some(4.0),
                (Learn::Noise, 2 | 5) | (Learn::Rest, 0) => Some(2.0),
                _ => None,
            };
            if let Some(factor) = factor {
                (noise, value) = self.diffusion(&model, (&noise, value), &[factor]);
            }
            is_stuck = gained == 0.0 && value == before;
            if !is_stuck {
                sums = self.derived(&model, free, &noise);
            }
            if gained < 0.5 && (round > 2 || learn == Learn::Nothing) {
                break;
            }
        }
        let (information, _) = self.normal(&sums, &model, free);
        let covariance = information.cholesky().map(|c| c.inverse());
        let covariance = covariance.or(last).unwrap_or_default();
        let minus_two_ln = self.minus_two_ln(&sums);
        let prior = prior(&model, free);
        Fit { model, noise, free: free.to_vec(), minus_two_ln, prior, covariance, sums }
    }

    /// Goes a step, or a part of it if all of it makes it worse than −2 ln likelihood was; none, if no part is better.
    fn stepped<'a>(
        &self,
        model: &Model<'a>,
        free: &[Free],
        noise: &Noise,
        (step, value): (&DVector<f64>, f64),
    ) -> Option<Stepped<'a>> {
        let before = value + prior(model, free);
        let mut share = 1.0;
        for _ in 0..4 {
            let mut moved = model.clone();
            for (free, step) in free.iter().zip(step.iter()) {
                moved.set(free.place, model.get(free.place) + share * step);
            }
            let sums = self.pass(&moved, &[], noise);
            let after = self.minus_two_ln(&sums) + prior(&moved, free);
            if after < before {
                return Some(Stepped { model: moved, sums, gained: before - after });
            }
            share *= 0.3;
        }
        None
    }

    /// The normal equations, prior included.
    pub fn normal(
        &self,
        sums: &[BlockSums],
        model: &Model<'_>,
        free: &[Free],
    ) -> (DMatrix<f64>, DVector<f64>) {
        let count = free.len();
        let mut information = DMatrix::zeros(count, count);
        let mut gradient = DVector::zeros(count);
        for sum in self.counted(sums) {
            information += sum.gram.view((1, 1), (count, count));
            gradient += sum.gram.view((1, 0), (count, 1));
        }
        for (place, free) in free.iter().enumerate() {
            let weight = 1.0 / (free.std * free.std);
            information[(place, place)] += weight;
            gradient[place] += weight * (free.mean - model.get(free.place));
        }
        (information, gradient)
    }
}

/// How far each number may go in one step, down and up: within its bounds, and no farther than is likely at all.
fn limits(model: &Model<'_>, free: &[Free]) -> Vec<(f64, f64)> {
    let each = free.iter().map(|free| {
        let (least, most) = model.room(free.place);
        (least.max(-FARTHEST * free.std), most.min(FARTHEST * free.std))
    });
    each.collect()
}

/// What the prior says against a model.
pub fn prior(model: &Model<'_>, free: &[Free]) -> f64 {
    free.iter().map(|free| ((model.get(free.place) - free.mean) / free.std).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::super::bench::{fitted, recorded, training};
    use super::*;
    use predict::delay::Delayed;

    #[test]
    fn a_fit_finds_the_car_and_says_how_sure_it_is() {
        let (vehicle, recording) = recorded("");
        let drives = [GriddedDrive::new(&recording, &vehicle)];
        let data = training(&drives);
        let fit = fitted(&data, &vehicle);
        let variances = data.variances(&fit);
        let truth = |name: &str| match name {
            "mass_kg" => Some(1500.0),
            "yaw_inertia_kgm2" => Some(2600.0),
            "lateral_stiffness_front" => Some(11.0),
            "lateral_stiffness_rear" => Some(14.0),
            _ => None,
        };
        let mut compared = 0;
        for (free, variance) in fit.free.iter().zip(variances) {
            let Some((name, value, slope)) = fit.model.ordinary_number(free.place) else { continue };
            let Some(truth) = truth(&name) else { continue };
            let std = variance.sqrt() * slope;
            compared += 1;
            assert!((value - truth).abs() < 3.0 * std, "{name}: {value} ± {std}, truth {truth}");
            assert!(std < 0.03 * truth, "{name}: ± {std}");
        }
        assert_eq!(compared, 4);
    }

    #[test]
    fn everything_late_together_is_the_same_drive_and_one_thing_late_is_not() {
        let (vehicle, recording) = recorded("");
        let drives = [GriddedDrive::new(&recording, &vehicle)];
        let data = training(&drives);
        let fit = fitted(&data, &vehicle);
        let rise = |late_by: fn(Delayed) -> f64| {
            let mut model = fit.model.clone();
            for late in Delayed::ALL {
                model.delays[late as usize] += late_by(late);
            }
            data.minus_two_ln(&data.pass(&model, &[], &fit.noise)) - fit.minus_two_ln
        };
        // Torques act later than their frames, all others are late: earlier torques make up for it.
        let all = rise(|late| if late == Delayed::Torque { -0.01 } else { 0.01 });
        let steering = rise(|late| if late == Delayed::Steering { 0.01 } else { 0.0 });
        let torque = rise(|late| if late == Delayed::Torque { 0.01 } else { 0.0 });
        assert!(all.abs() < 30.0, "{all}");
        assert!(steering > 200.0 && torque > 60.0, "{steering} {torque}");
    }
}
