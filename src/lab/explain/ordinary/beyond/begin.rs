//! The ordinary car to begin with: its numbers and the colour of its noise, learned in turn.

use nalgebra::DMatrix;

use super::super::fit::FreeFit;
use super::super::numbers::{Free, Number, Scope, prior_cost};
use super::Search;
use super::climb::{Climbed, LEAST_ROUND, ROUNDS, State};
use super::colour::{Colour, Series};
use crate::explain::model::{Chosen, Model, Place};
use identify::Parameter;
use physics::model::effect::{Course, named};

/// So many times as far as a round's step is tried. Numerical: on a lap with an accelerometer 2.5 m ahead
/// (`concealed_in_real_drives`) thirty rounds were not enough without.
const FURTHER: [f64; 6] = [2.0, 4.0, 8.0, 16.0, 32.0, 64.0];

/// Wheels may differ by a per cent in radius before anybody looks for a reason, and tracks by two per cent from what is
/// written. With a third of that a wheel that is 1.5 % small was taken for a slippery road.
const RADIUS: f64 = 0.01;
const TRACK: f64 = 0.02;

impl Search<'_> {
    /// The ordinary car at what is likeliest for coloured noise.
    pub(super) fn begin<'a>(&self, found: &FreeFit<'a>) -> State<'a> {
        let (model, free, at) = self.with_wheels(found);
        self.learned(&model, &free, &at)
    }

    /// A car with its numbers where they are likeliest, and the noise's colour there. They begin at `at`.
    pub(super) fn learned<'a>(&self, model: &Model<'a>, free: &[Free], at: &[f64]) -> State<'a> {
        let errors = self.errors(model, free, at);
        let mut state = self.with_slopes(self.in_colour(self.colour(&errors), (model, free, at), errors));
        for _ in 0..ROUNDS {
            let next = self.round_from(&state);
            let gained = state.cost - next.cost;
            if gained > 0.0 {
                state = self.with_slopes(next);
            }
            if gained < LEAST_ROUND {
                break;
            }
        }
        let Climbed { at, errors, cost, covariance, .. } =
            self.climb(&state, &state.colour, &state.model, &state.free, state.start());
        State { at, errors, cost, covariance, ..state }
    }

    /// The numbers in the noise's colour, and that beside them. Each holds the other back: what the numbers miss is in the colour,
    /// and what is in the colour moves no number. So a round's step is a small part of a way, and is tried in multiples.
    fn round_from<'a>(&self, state: &State<'a>) -> State<'a> {
        let State { model, free, .. } = state;
        let climbed = self.climb(state, &state.colour, model, free, state.start());
        let further = |times: f64| {
            let to = |((from, to), free): ((&f64, &f64), &Free)| {
                (from + times * (to - from)).clamp(free.bounds.0, free.bounds.1)
            };
            let at: Vec<f64> = state.at.iter().zip(&climbed.at).zip(free).map(to).collect();
            let errors = self.errors(model, free, &at);
            let there = (model, &free[..], &at[..]);
            let new = self.in_colour(self.colour(&errors), there, errors);
            if new.cost < state.cost {
                return new;
            }
            // A colour is learned by least squares, and costs by what outliers do.
            let old = self.in_colour(state.colour.clone(), there, new.errors.clone());
            if new.cost < old.cost { new } else { old }
        };
        let mut best = further(1.0);
        for times in FURTHER {
            let next = further(times);
            if next.cost >= best.cost {
                break;
            }
            best = next;
        }
        best
    }

    /// A place in a colour, with what it costs.
    fn in_colour<'a>(
        &self,
        colour: Colour,
        (model, free, at): (&Model<'a>, &[Free], &[f64]),
        errors: Vec<Series>,
    ) -> State<'a> {
        let rows = self.rows(&colour, &errors);
        let train = self.cost(&colour, &rows, &self.white(&colour, &rows, &errors)).train;
        let cost = train + prior_cost(free, at);
        State {
            model: model.clone(),
            free: free.to_vec(),
            at: at.to_vec(),
            errors,
            slopes: Vec::new(),
            colour,
            cost,
            covariance: DMatrix::zeros(0, 0),
        }
    }

    fn with_slopes<'a>(&self, mut state: State<'a>) -> State<'a> {
        state.slopes = self.slopes(&state.model, &state.free, &state.at, &state.errors);
        state
    }

    /// The ordinary car with what the wheels' readings need: tires of a set differ, and tracks are not known to the
    /// millimetre.
    fn with_wheels<'a>(&self, found: &FreeFit<'a>) -> (Model<'a>, Vec<Free>, Vec<f64>) {
        let (mut model, mut free, mut at) = (found.model.clone(), found.free.clone(), found.at.clone());
        let mut add = |number: Number, prior: (f64, f64), most: f64| {
            let bounds = (prior.0 - most, prior.0 + most);
            free.push(Free { number, of: Scope::Car, prior, bounds, step: 0.05 * prior.1 });
            at.push(prior.0);
        };
        let radii = named("tire_radius").filter(|kind| model.effects.iter().all(|of| of.kind != *kind));
        if let Some(kind) = radii {
            model = model.with(Chosen::usual(kind, None, Course::None));
        }
        for (axle, track) in [Parameter::TrackFront, Parameter::TrackRear].into_iter().enumerate() {
            if self.drives.iter().all(|drive| drive.axles[axle].is_none()) {
                continue;
            }
            add(Number::Of(Place::Ordinary(track)), (model.get(Place::Ordinary(track)), TRACK), 5.0 * TRACK);
            for wheel in [2 * axle, 2 * axle + 1].into_iter().filter(|_| radii.is_some()) {
                add(Number::Of(Place::Effect(model.effects.len() - 1, wheel)), (0.0, RADIUS), 5.0 * RADIUS);
            }
        }
        (model, free, at)
    }
}
