//! The Dahl tire: a tire with an inner state (thesis 4.13; methods.md §4).

use crate::model::friction::{Dahl, DynamicFriction};

/// Deflection of the contact patch, with forces / normal load:
/// ż = v_r − σ0 |v_r| z/μ − κ |r0 ω| z, μ_x = σ0 z, where v_r = r0 ω − v_x.
///
/// As the thesis has it (κ = 0) this is the Dahl friction of a block that is dragged: in steady slip it
/// always ends at μ, whatever the slip, so that it has no slip curve. A rolling tire sheds its
/// deflection at the rear of the patch and brings undeflected rubber in at the front: κ, the inverse of
/// a relaxation length. With it there is a curve of the slope σ0/κ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DahlTire {
    /// σ0: force / normal load per m of deflection.
    pub stiffness: f64,
    /// κ: share of the deflection that is shed per m of rolling, 1/m; zero for the thesis's model.
    pub shedding: f64,
}

impl DahlTire {
    /// The thesis's: it sheds nothing.
    pub fn dragged(stiffness: f64) -> Self {
        Self { stiffness, shedding: 0.0 }
    }

    /// One whose slip curve has this slope (force / normal load per unit slip) at zero, and which
    /// follows a change of slip within `relaxation_m`, m, of rolling.
    pub fn rolling(slope: f64, relaxation_m: f64) -> Self {
        Self { stiffness: slope / relaxation_m, shedding: relaxation_m.recip() }
    }

    /// ż, m/s, at `rolling` = r0 ω and `along` = v_x, m/s.
    #[inline]
    pub fn rate(&self, friction: f64, deflection: f64, rolling: f64, along: f64) -> f64 {
        rolling - along - self.decay(friction, rolling, along) * deflection
    }

    /// Longitudinal force / normal load.
    #[inline]
    pub fn force(&self, deflection: f64) -> f64 {
        self.stiffness * deflection
    }

    /// The deflection, m, after `step` seconds at constant speeds: exact, whatever the step.
    #[inline]
    pub fn advance(&self, friction: f64, deflection: f64, rolling: f64, along: f64, step: f64) -> f64 {
        if self.shedding == 0.0 {
            return Dahl::new(self.stiffness, friction).advance(deflection, rolling - along, step);
        }
        let decay = self.decay(friction, rolling, along);
        if decay == 0.0 {
            return deflection;
        }
        let steady = (rolling - along) / decay;
        steady + (deflection - steady) * (-decay * step).exp()
    }

    /// How fast a deflection is forgotten, 1/s: the system's own rate, which limits the steps of any
    /// other integration.
    #[inline]
    pub fn decay(&self, friction: f64, rolling: f64, along: f64) -> f64 {
        self.stiffness * (rolling - along).abs() / friction + self.shedding * rolling.abs()
    }

    /// Force / normal load in steady slip (SAE, driving: (r0 ω − v)/v) of a wheel going forward.
    pub fn steady(&self, friction: f64, slip: f64) -> f64 {
        let decay = self.decay(friction, 1.0 + slip, 1.0);
        if decay > 0.0 { self.stiffness * slip / decay } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Force after rolling far at constant slip.
    fn settled(tire: &DahlTire, friction: f64, slip: f64) -> f64 {
        let (along, step) = (10.0, 0.01);
        let z = (0..100_000).fold(0.0, |z, _| tire.advance(friction, z, along * (1.0 + slip), along, step));
        tire.force(z)
    }

    #[test]
    fn dragged_it_has_no_slip_curve() {
        let tire = DahlTire::dragged(100.0);
        for slip in [1e-3, 0.01, 0.1] {
            for friction in [0.2, 1.0] {
                assert!((settled(&tire, friction, slip) - friction).abs() < 1e-9);
                assert!((tire.steady(friction, -slip) + friction).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn rolling_it_has_one_of_the_slope_asked_for() {
        let tire = DahlTire::rolling(50.0, 0.2);
        assert!((tire.steady(0.9, 1e-8) / 1e-8 - 50.0).abs() < 1e-3);
        for slip in [-0.3, -0.01, 0.002, 0.05] {
            let steady = tire.steady(0.9, slip);
            assert!((settled(&tire, 0.9, slip) - steady).abs() < 1e-9);
            assert!(steady.abs() < 0.9 && steady * slip > 0.0);
        }
    }

    #[test]
    fn a_change_of_slip_is_followed_within_the_relaxation_length() {
        let tire = DahlTire::rolling(50.0, 0.2);
        // So little slip that friction does not matter: 1 − 1/e after 0.2 m.
        let z = tire.advance(1.0, 0.0, 10.0 * 1.000_001, 10.0, 0.02);
        let share = tire.force(z) / tire.steady(1.0, 1e-6);
        assert!((share - (1.0 - (-1.0_f64).exp())).abs() < 1e-4, "{share}");
    }

    #[test]
    fn the_closed_form_solves_the_differential_equation() {
        for tire in [DahlTire::dragged(80.0), DahlTire::rolling(40.0, 0.3)] {
            let (mut z, h) = (-0.005, 1e-6);
            for _ in 0..100_000 {
                let k1 = tire.rate(0.7, z, 10.3, 10.0);
                z += h * tire.rate(0.7, z + 0.5 * h * k1, 10.3, 10.0);
            }
            assert!((z - tire.advance(0.7, -0.005, 10.3, 10.0, 0.1)).abs() < 1e-9);
        }
    }
}
