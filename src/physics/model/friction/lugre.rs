//! The LuGre model (named in thesis 3.2.2; methods.md §3).

use super::{DynamicFriction, StaticFriction, Stribeck};

/// ż = v − σ0 |v| z/g(v), F = σ0 z + σ1 ż + F_V v, where g is the static curve without its viscous part.
///
/// Extends [`super::Dahl`] by stiction, the Stribeck effect and damping: in steady sliding it is the
/// static curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LuGre {
    /// σ0: force per m of deflection.
    pub stiffness: f64,
    /// σ1: force per m/s at which the deflection changes.
    pub damping: f64,
    /// The force of steady sliding; its viscous coefficient is σ2.
    pub sliding: Stribeck,
}

impl LuGre {
    /// g(v): the deflection's force in steady sliding.
    #[inline]
    fn limit(&self, velocity: f64) -> f64 {
        self.sliding.without_viscous(velocity)
    }
}

impl DynamicFriction for LuGre {
    #[inline]
    fn rate(&self, deflection: f64, velocity: f64) -> f64 {
        velocity - self.stiffness * velocity.abs() * deflection / self.limit(velocity)
    }

    #[inline]
    fn force(&self, deflection: f64, velocity: f64) -> f64 {
        self.stiffness * deflection
            + self.damping * self.rate(deflection, velocity)
            + self.sliding.viscous * velocity
    }

    fn steady_deflection(&self, velocity: f64) -> f64 {
        super::sign(velocity) * self.limit(velocity) / self.stiffness
    }

    fn steady(&self, velocity: f64) -> f64 {
        if velocity == 0.0 { 0.0 } else { self.sliding.sliding(velocity) }
    }

    #[inline]
    fn advance(&self, deflection: f64, velocity: f64, step: f64) -> f64 {
        if velocity == 0.0 {
            return deflection;
        }
        let steady = self.steady_deflection(velocity);
        let left = (-self.stiffness * velocity.abs() * step / self.limit(velocity)).exp();
        steady + (deflection - steady) * left
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::friction::Dahl;

    fn model() -> LuGre {
        let sliding = Stribeck { sliding: 1.0, at_rest: 1.5, viscous: 0.4, velocity: 1e-3, exponent: 2.0 };
        LuGre { stiffness: 1e5, damping: 316.0, sliding }
    }

    #[test]
    fn steady_sliding_is_the_static_curve() {
        let lugre = model();
        for velocity in [-1.0, -1e-3, -1e-4, 1e-4, 5e-4, 2e-3, 0.5] {
            let z = (0..100).fold(0.0, |z, _| lugre.advance(z, velocity, 10.0));
            let (steady, curve) = (lugre.force(z, velocity), lugre.sliding.sliding(velocity));
            assert!((steady - curve).abs() < 1e-9, "{velocity}: {steady} {curve}");
            assert!((lugre.steady(velocity) - curve).abs() < 1e-12);
        }
    }

    #[test]
    fn without_stiction_and_damping_it_is_dahl() {
        let mut lugre = LuGre { damping: 0.0, ..model() };
        (lugre.sliding.at_rest, lugre.sliding.viscous) = (1.0, 0.0);
        let dahl = Dahl::new(1e5, 1.0);
        for velocity in [-0.3, 1e-5, 0.02] {
            let (one, other) = (lugre.advance(3e-6, velocity, 1e-4), dahl.advance(3e-6, velocity, 1e-4));
            assert!((one - other).abs() < 1e-18, "{velocity}");
            assert!((lugre.force(one, velocity) - dahl.force(other, velocity)).abs() < 1e-9);
        }
    }

    #[test]
    fn the_closed_form_solves_the_differential_equation_and_no_step_is_too_long() {
        let lugre = model();
        let (mut z, velocity, h) = (-1e-5, 7e-4, 1e-6);
        for _ in 0..50_000 {
            let k1 = lugre.rate(z, velocity);
            z += h * lugre.rate(z + 0.5 * h * k1, velocity);
        }
        assert!((z - lugre.advance(-1e-5, velocity, 0.05)).abs() < 1e-12);
        // Here one step of Runge–Kutta would multiply the deflection by 1e19.
        let z = lugre.advance(-1e-5, 1.0, 1.0);
        assert!((z - lugre.steady_deflection(1.0)).abs() < 1e-18);
    }

    /// A mass pulled slowly by a spring sticks and slips; with more viscous friction than the Stribeck
    /// effect takes away it creeps.
    #[test]
    fn a_slowly_pulled_mass_sticks_and_slips() {
        let slip_count = |lugre: &LuGre| {
            let (mass, spring, pull) = (1.0, 2.0, 0.1);
            let (mut x, mut v, mut z) = (0.0, 0.0, 0.0);
            let (mut slips, mut sliding) = (0, false);
            for i in 0..400_000 {
                let h = 1e-4;
                z = lugre.advance(z, v, h);
                v += h * (spring * (pull * h * f64::from(i) - x) - lugre.force(z, v)) / mass;
                x += h * v;
                let fast = v > 0.5 * pull;
                slips += u32::from(fast && !sliding);
                sliding = if sliding { v > 0.02 * pull } else { fast };
            }
            slips
        };
        assert!(slip_count(&model()) >= 4, "{}", slip_count(&model()));
        let mut smooth = model();
        smooth.sliding.at_rest = 1.0;
        assert!(slip_count(&smooth) <= 1, "{}", slip_count(&smooth));
    }
}
