//! Static models: Coulomb, viscous, stiction, and all of it with the Stribeck effect (thesis 3.2.1,
//! Fig. 3.2).

use super::{StaticFriction, sign};

/// The same force at every velocity (Fig. 3.2a).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    /// F_C: the force.
    pub sliding: f64,
}

impl StaticFriction for Coulomb {
    fn sliding(&self, velocity: f64) -> f64 {
        self.sliding * sign(velocity)
    }

    fn break_away(&self) -> f64 {
        self.sliding
    }
}

/// Proportional to the velocity, as of a lubricant (Fig. 3.2b). Holds nothing at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viscous {
    /// F_V: force per m/s.
    pub coefficient: f64,
}

impl StaticFriction for Viscous {
    fn sliding(&self, velocity: f64) -> f64 {
        self.coefficient * velocity
    }

    fn break_away(&self) -> f64 {
        0.0
    }
}

/// Coulomb friction that holds more at rest than it resists sliding (Fig. 3.2c).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiction {
    /// F_C: the force while sliding.
    pub sliding: f64,
    /// F_S: the force that is held at rest, above F_C.
    pub at_rest: f64,
}

impl StaticFriction for Stiction {
    fn sliding(&self, velocity: f64) -> f64 {
        self.sliding * sign(velocity)
    }

    fn break_away(&self) -> f64 {
        self.at_rest
    }
}

/// All of them together, the excess of stiction fading as sliding gets faster (Fig. 3.2d):
/// sgn(v) (F_C + (F_S − F_C) exp(−|v/v_st|^δ)) + F_V v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stribeck {
    /// F_C: the force of fast sliding, without the viscous part.
    pub sliding: f64,
    /// F_S: the force that is held at rest, at least F_C.
    pub at_rest: f64,
    /// F_V: viscous force per m/s.
    pub viscous: f64,
    /// v_st, m/s: here 1/e = 37 % of F_S − F_C is left, whatever the exponent.
    pub velocity: f64,
    /// δ: how the excess fades, 0.5 to 2; with 2 it is that of [`super::LuGre`].
    pub exponent: f64,
}

impl Stribeck {
    /// g(v), the part without viscous friction, without sign.
    #[inline]
    pub fn without_viscous(&self, velocity: f64) -> f64 {
        let fading = (-(velocity / self.velocity).abs().powf(self.exponent)).exp();
        self.sliding + (self.at_rest - self.sliding) * fading
    }

    /// The velocity, m/s, from which on the force grows again: the least force while sliding. Zero if
    /// it grows from the start, infinite if it never does.
    pub fn least_force_velocity(&self) -> f64 {
        let excess = self.at_rest - self.sliding;
        if excess <= 0.0 {
            return 0.0;
        }
        if self.viscous <= 0.0 {
            return f64::INFINITY;
        }
        // Of the derivative's two zeros the upper one: the fading part falls fastest between them.
        let slope = |velocity: f64| {
            let ratio = velocity / self.velocity;
            self.viscous
                - excess * self.exponent / self.velocity
                    * ratio.powf(self.exponent - 1.0)
                    * (-ratio.powf(self.exponent)).exp()
        };
        let (mut low, mut high) = (0.0, 64.0 * self.velocity);
        // The steepest fall lies at the inflection, (δ−1)/δ = ratio^δ, or at zero.
        let steepest = self.velocity
            * ((self.exponent - 1.0).max(0.0) / self.exponent).powf(self.exponent.recip()).max(1e-9);
        if slope(steepest) >= 0.0 {
            return 0.0;
        }
        low = steepest.max(low);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if slope(middle) < 0.0 { low = middle } else { high = middle }
        }
        high
    }
}

impl StaticFriction for Stribeck {
    fn sliding(&self, velocity: f64) -> f64 {
        self.without_viscous(velocity) * sign(velocity) + self.viscous * velocity
    }

    fn break_away(&self) -> f64 {
        self.at_rest.max(self.sliding)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Stribeck =
        Stribeck { sliding: 0.7, at_rest: 1.0, viscous: 0.1, velocity: 0.05, exponent: 2.0 };

    #[test]
    fn at_the_stribeck_velocity_37_percent_of_the_excess_is_left_whatever_the_exponent() {
        for exponent in [0.5, 1.0, 2.0] {
            let model = Stribeck { exponent, viscous: 0.0, ..ALL };
            let left = (model.sliding(-0.05).abs() - 0.7) / 0.3;
            assert!((left - 0.3679).abs() < 1e-4, "{left}");
        }
    }

    #[test]
    fn the_combination_contains_the_others() {
        for v in [-3.0, -0.01, 0.2, 5.0] {
            let same = |one: f64, other: f64| assert!((one - other).abs() < 1e-15, "{one} {other} at {v}");
            let plain = Stribeck { at_rest: 0.7, ..ALL };
            same(Stribeck { viscous: 0.0, ..plain }.sliding(v), Coulomb { sliding: 0.7 }.sliding(v));
            same(
                Stribeck { sliding: 0.0, at_rest: 0.0, ..plain }.sliding(v),
                Viscous { coefficient: 0.1 }.sliding(v),
            );
            let sudden = Stribeck { viscous: 0.0, velocity: 1e-6, ..ALL };
            same(sudden.sliding(v), Stiction { sliding: 0.7, at_rest: 1.0 }.sliding(v));
        }
    }

    #[test]
    fn at_rest_the_applied_force_is_held_up_to_break_away() {
        let stiction = Stiction { sliding: 0.7, at_rest: 1.0 };
        assert_eq!(stiction.force(0.0, -0.9), -0.9);
        assert_eq!(stiction.force(0.0, 1.4), 1.0);
        assert_eq!(stiction.force(1e-9, 1.4), 0.7);
        assert_eq!(Viscous { coefficient: 2.0 }.force(0.0, 1.0), 0.0);
    }

    #[test]
    fn the_least_force_lies_where_it_is_said() {
        for exponent in [0.7, 1.0, 2.0] {
            let model = Stribeck { exponent, ..ALL };
            let least = model.least_force_velocity();
            let at = |factor: f64| model.sliding(factor * least);
            assert!(at(1.0) < at(0.99) && at(1.0) < at(1.01), "{exponent}: {least}");
        }
        assert_eq!(Stribeck { viscous: 100.0, ..ALL }.least_force_velocity(), 0.0);
        assert_eq!(Stribeck { viscous: 0.0, ..ALL }.least_force_velocity(), f64::INFINITY);
    }
}
