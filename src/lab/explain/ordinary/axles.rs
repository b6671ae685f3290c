//! The cornering stiffness of the ordinary car's axles, as a plain car would have it.

use physics::model::GRAVITY;
use physics::model::effect::steering_compliance::{KIND as COMPLIANCE, TRAIL_M};

use super::fit::FreeFit;
use super::fitted_number::LEAST_TOLD;
use super::numbers::placed;
use crate::explain::model::{Model, Place, is_at_either};
use identify::{AxleStiffness, CorneringStiffness, Doubt, Parameter};

/// Of a fit: value and deviation from all of its numbers together, for the tire's stiffness and what gives way in the steering
/// are hardly told apart, and their sum is.
pub fn of(found: &FreeFit<'_>) -> CorneringStiffness {
    CorneringStiffness { front: axle(found, true), rear: axle(found, false) }
}

fn axle(found: &FreeFit<'_>, front: bool) -> Option<AxleStiffness> {
    let parameter = if front { Parameter::LateralFront } else { Parameter::LateralRear };
    let own = found
        .free
        .iter()
        .position(|free| free.number == super::numbers::Number::Of(Place::Ordinary(parameter)))?;
    let at = |coordinates: &[f64]| stiffness(&placed(&found.model, &found.free, coordinates, 0).0, front);
    let value = at(&found.at);
    let slopes: Vec<f64> = (0..found.free.len())
        .map(|i| {
            let mut moved = found.at.clone();
            moved[i] += found.free[i].step;
            (at(&moved) - value) / found.free[i].step
        })
        .collect();
    let pairs = || (0..slopes.len()).flat_map(|i| (0..slopes.len()).map(move |j| (i, j)));
    let variance: f64 = pairs().map(|(i, j)| slopes[i] * found.covariance[(i, j)] * slopes[j]).sum();
    let before: f64 =
        slopes.iter().zip(&found.free).map(|(slope, free)| (slope * free.prior.1).powi(2)).sum();
    let (std, before) = (variance.max(0.0).sqrt(), before.sqrt());
    let is_at_bound = is_at_either(found.at[own], found.free[own].bounds);
    // What the table says is of the same quantity: a plain car's.
    let against = match Doubt::of_parameter(parameter, (value, std), &found.model.vehicle, is_at_bound) {
        Some(doubt) => Some(doubt.why),
        None => {
            (std > LEAST_TOLD * before).then(|| "the recordings add little to what was known before".into())
        }
    };
    Some(AxleStiffness::of((value, std), against))
}

/// Small angles: the steering gives way by its compliance times the trail times the force.
fn stiffness(model: &Model<'_>, front: bool) -> f64 {
    let get = |parameter| model.values.get(parameter);
    if !front {
        return get(Parameter::LateralRear);
    }
    let tire = get(Parameter::LateralFront);
    let wheelbase = model.vehicle.wheelbase_m.value;
    let load = get(Parameter::Mass) * GRAVITY * (wheelbase - get(Parameter::CgToFront)) / wheelbase;
    let compliance: f64 = model
        .effects
        .iter()
        .filter(|chosen| std::ptr::eq(chosen.kind, &COMPLIANCE))
        .filter_map(|chosen| chosen.values().first().copied())
        .sum();
    tire / (1.0 + compliance * TRAIL_M * load * tire)
}
