//! Bounds of the friction by axles that slip further than their forces account for.
//!
//! The tire's curve ([`Bend`](super::bend::Bend)) turns the ratio of slip angle to straight slip angle into the share
//! of the friction in use. The force over the least such share is an upper bound of the friction.

use super::equation::Equation;
use super::model::Model;
use super::sliding::{self, Excess, LateralLimit};
use super::state::{AY_OFFSET, Row, State};
use crate::estimate::belief::Belief;
use crate::model::GRAVITY;

/// Tuned with the test `campaign`: no bound may exclude the truth.
struct Tuning {
    /// Further off its direction of travel (rad) a car spins, and its wheels pull in directions of their own.
    spinning: f64,
    /// Curves bend noticeably from this share of the friction on.
    bent_from: f64,
    /// With this share of the force sideways, an axle's limit is one sideways.
    sideways: f64,
    /// A compliance is hardly known better when it is to bound the friction: the surface may have changed.
    least_compliance_std: f64,
}

const TUNING: Tuning = Tuning { spinning: 0.55, bent_from: 0.75, sideways: 0.7, least_compliance_std: 0.12 };

/// An axle's equation at a window, with its variance as it was learned, rad².
pub type Measured<'a> = (&'a Equation, f64);

/// The narrowest bound. Each axle gives two: one by its slip angle in the estimated motion, one by how much further
/// it slips than the other axle, δ − (a + b) r/v_x. The second needs no lateral velocity, which is poorly known while
/// both axles bend; it takes the other axle's slip angle as that of its stiffness, the least it can be.
pub fn bent_limit(
    [front, rear]: [Measured; 2],
    state: &State,
    model: &Model,
    belief: &Belief,
) -> Option<LateralLimit> {
    let mut narrowest = None;
    for ((own, own_noise), (its, its_noise)) in [(front, rear), (rear, front)] {
        let alone = bound_by(own, own.angle, &own.motion, own_noise, state, model, belief);
        let mut row = own.motion - its.motion;
        row[its.axle] += its.force;
        row[AY_OFFSET] -= state.mean[its.axle] / GRAVITY;
        let steered = own.angle - its.angle + its.straight;
        let beside = bound_by(own, steered, &row, own_noise + its_noise, state, model, belief);
        for limit in [alone, beside] {
            narrowest = LateralLimit::narrower(narrowest, limit);
        }
    }
    let is_spinning = front.0.angle.abs().max(rear.0.angle.abs()) > TUNING.spinning;
    narrowest.map(|limit: LateralLimit| LateralLimit { is_sure: !is_spinning, ..limit })
}

/// The bound by an axle with slip angle `angle`, whose sensitivity to the state is `row`, if the angle surely exceeds
/// that of the stiffness alone. Both angles' deviations are taken off.
fn bound_by(
    equation: &Equation,
    angle: f64,
    row: &Row,
    noise: f64,
    state: &State,
    model: &Model,
    belief: &Belief,
) -> Option<LateralLimit> {
    let Equation { axle, force, used, .. } = *equation;
    if !equation.is_cornering || force.abs() < TUNING.sideways * used {
        return None;
    }
    let angle = angle * force.signum();
    let compliance = state.mean[axle];
    let straight = compliance * used;
    let compliance_std = (state.std(axle) / compliance).max(TUNING.least_compliance_std);
    let angle_variance = state.innovation(row, 0.0, noise).variance;
    let variance = angle_variance + (compliance_std * straight).powi(2);
    let at_limit = belief.at_most(used / TUNING.bent_from);
    let excess = Excess { angle: angle - straight, variance, straight, at_limit };
    if excess.sliding() < sliding::SURE {
        return None;
    }
    let bend = angle / straight;
    let bend_std = bend * (angle_variance.sqrt() / angle).hypot(compliance_std);
    sliding::limit(used, (bend - 2.0 * bend_std, bend + 2.0 * bend_std), &model.tires)
}
