//! What axles tell of the friction that slip further than their forces account for.
//!
//! How much further, the tire's curve turns into a share of the friction ([`Bend`](super::bend::Bend)): what is in use,
//! over that share, is what there is at most.

use super::measure::Equation;
use super::sliding::{self, Excess, LateralLimit};
use super::{AY_OFFSET, Belief, CorneringEstimator, FRONT, GRAVITY, Row};

impl CorneringEstimator {
    /// Further off its direction of travel (rad) a car spins, and its wheels pull in directions of their own.
    const SPINNING: f64 = 0.55;
    /// Curves bend noticeably from this share of the friction on.
    const BENT_FROM: f64 = 0.75;
    /// With this share of the force sideways, an axle's limit is one sideways.
    const SIDEWAYS: f64 = 0.7;
    /// A compliance is hardly known better when it is to bound the friction: the surface may have changed.
    const LEAST_COMPLIANCE_STD: f64 = 0.12;

    /// The friction by axles that slip further than their forces account for: by the motion as it is believed, and by
    /// how much further one slips than the other, δ − (a + b) r/v_x. That needs no lateral velocity, which nobody
    /// knows well while both bend; the other slips as far as its own force has it, or further.
    pub(super) fn bent_limit(&self, [front, rear]: [&Equation; 2], belief: &Belief) -> Option<LateralLimit> {
        let noise = |of: &Equation| self.axles[of.axle - FRONT].noise.variance(of.promised);
        let mut narrowest = None;
        for (own, its) in [(front, rear), (rear, front)] {
            let alone = self.bound_by(own, own.angle, &own.motion, noise(own), belief);
            let mut row = own.motion - its.motion;
            row[its.axle] += its.force;
            row[AY_OFFSET] -= self.state.mean[its.axle] / GRAVITY;
            let steered = own.angle - its.angle + its.straight;
            let beside = self.bound_by(own, steered, &row, noise(own) + noise(its), belief);
            for limit in [alone, beside] {
                narrowest = LateralLimit::narrower(narrowest, limit);
            }
        }
        let is_spinning = front.angle.abs().max(rear.angle.abs()) > Self::SPINNING;
        narrowest.map(|limit: LateralLimit| LateralLimit { is_sure: !is_spinning, ..limit })
    }

    /// The friction by an axle whose slip angle is `angle`, which moves with the state by `row`, if that is surely
    /// more than its stiffness alone has it: how much more, with all that is not known of both taken off.
    fn bound_by(
        &self,
        equation: &Equation,
        angle: f64,
        row: &Row,
        noise: f64,
        belief: &Belief,
    ) -> Option<LateralLimit> {
        let Equation { axle, force, used, .. } = *equation;
        if !equation.is_cornering || force.abs() < Self::SIDEWAYS * used {
            return None;
        }
        let angle = angle * force.signum();
        let compliance = self.state.mean[axle];
        let straight = compliance * used;
        let compliance_std = (self.state.std(axle) / compliance).max(Self::LEAST_COMPLIANCE_STD);
        let angle_variance = self.state.innovation(row, 0.0, noise).variance;
        let variance = angle_variance + (compliance_std * straight).powi(2);
        let at_limit = belief.at_most(used / Self::BENT_FROM);
        let excess = Excess { angle: angle - straight, variance, straight, at_limit };
        if excess.sliding() < sliding::SURE {
            return None;
        }
        let bend = angle / straight;
        let bend_std = bend * (angle_variance.sqrt() / angle).hypot(compliance_std);
        sliding::limit(used, (bend - 2.0 * bend_std, bend + 2.0 * bend_std), &self.tires)
    }
}
