//! Numbers over the drives as they are told: in their units, since when, and whether they grow.

use super::super::Search;
use super::super::changed::is_of_sensor;
use super::super::climb::State;
use super::super::power::NINE_OF_TEN;
use super::super::references::LEAST_DISTANCE;
use super::super::trial::{Trial, What};
use super::over_drives::Profile;
use super::profiles::Linear;
use super::{OverDrives, Since};
use crate::explain::model::Place;
use crate::explain::ordinary::numbers::{Free, Number, Scope};
use crate::explain::result::Estimate;
use crate::explain::select::LEAST_EVIDENCE;

/// Of a probability of 95 % each side has half of the rest; of a normal variable, in deviations. Statistical.
const NORMAL_95: f64 = 1.96;

impl Search<'_> {
    /// A number over the drives.
    pub(super) fn told(
        &self,
        state: &State<'_>,
        trial: &Trial,
        main: Free,
        profile: &Profile,
        (healthy, middle): (usize, usize),
        price: f64,
    ) -> OverDrives {
        let (number, unit, usual) = trial.size(&state.model, &main, main.prior.1);
        let value = |coordinate: f64| value(trial, &main, state, coordinate);
        let of = |it: Estimate| {
            let (value, slope) = value(main.prior.0 + it.value);
            Estimate { value, std: slope.abs() * it.std }
        };
        let (_, slope) = value(main.prior.0);
        let std = profile.step_std(middle);
        let freedom = 2.0 * (main.prior.1 / std).max(1.0).ln();
        let needed = (LEAST_EVIDENCE + price + freedom + self.price_of_trying(&trial.name()))
            .sqrt()
            .max(LEAST_DISTANCE);
        OverDrives {
            name: trial.name(),
            number,
            unit,
            values: profile.values(healthy).into_iter().map(of).collect(),
            told_from: (needed + NINE_OF_TEN) * std * slope.abs(),
            usual,
        }
    }

    /// A change that was taken, as the drives have it now.
    pub(super) fn since(
        &self,
        linear: &Linear<'_, '_>,
        trial: &Trial,
        place: usize,
        (state, thought): (&State<'_>, &[Vec<Free>]),
        (moments, price): (std::ops::Range<usize>, f64),
    ) -> Option<Since> {
        let spread = linear.changed(place);
        let profiles: Vec<Profile> =
            thought.iter().filter_map(|thought| linear.profile(&spread, thought)).collect();
        let odds: Vec<(usize, f64)> =
            moments.clone().zip(&profiles).map(|(since, of)| (since, of.from(since).together)).collect();
        let since = odds.iter().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let profile = &profiles[since - moments.start];
        let number = self.told(state, trial, spread.main, profile, (since, since), price);
        let (_, slope) = value(trial, &spread.main, state, spread.main.prior.0);
        let trend =
            profile.trend(since).map(|it| Estimate { value: slope * it.value, std: slope.abs() * it.std });
        // In the last drives' direction.
        let change = number.values.last().map_or(0.0, |last| last.value)
            - number.values[..since].iter().map(|it| it.value).sum::<f64>() / since as f64;
        let grows = trend.map(|trend| trend.value * change.signum() > NORMAL_95 * trend.std);
        Some(Since { number, since, since_ci: interval(&odds), trend, grows })
    }
}

/// The shortest row of moments that has 95 % of the probability.
fn interval(odds: &[(usize, f64)]) -> [usize; 2] {
    let most = odds.iter().map(|(_, of)| *of).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = odds.iter().map(|(_, of)| (0.5 * (of - most)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    let all = (0..odds.len()).flat_map(|from| (from..odds.len()).map(move |to| (from, to)));
    let holds = all.filter(|(from, to)| weights[*from..=*to].iter().sum::<f64>() >= 0.95 * sum);
    let shortest = holds.min_by_key(|(from, to)| to - from);
    shortest.map_or([0, 0], |(from, to)| [odds[from].0, odds[to].0])
}

/// The value of a candidate's number at a coordinate, and how it changes with that.
fn value(trial: &Trial, main: &Free, state: &State<'_>, coordinate: f64) -> (f64, f64) {
    match (&trial.what, main.number) {
        (What::Effect(candidate), Number::Of(Place::Effect(_, number))) => {
            match candidate.kind.spec(number, candidate.channel) {
                Some(spec) => (spec.value(coordinate), spec.scale.slope(coordinate)),
                None => (coordinate, 1.0),
            }
        }
        (What::Number { name, .. }, Number::Change(of)) if !is_of_sensor(name) => {
            let is_common = |free: &Free| free.number == Number::Of(of) && free.of == Scope::Car;
            match state.free.iter().position(is_common) {
                Some(common) => {
                    let (_, value, slope) =
                        state.free[common].named(&state.model, state.at[common] + coordinate);
                    (value, slope)
                }
                None => (coordinate, 1.0),
            }
        }
        (What::Number { .. }, Number::Change(_)) => (coordinate.exp_m1(), coordinate.exp()),
        (_, Number::SpeedScaleChange) => (-coordinate, -1.0),
        _ => (coordinate, 1.0),
    }
}
