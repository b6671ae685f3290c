//! The magic formula (thesis 4.10).

use std::f64::consts::FRAC_PI_2;

use super::{Curve, Real, Shape};

/// D sin(C atan(B x − E (B x − atan B x))), D the friction, B C D the stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagicFormula<T = f64> {
    /// Shape factor C, above 0 and at most 2: how far the force falls beyond its peak. Up to 1 it
    /// has no peak.
    pub shape: T,
    /// Curvature factor E, at most 1: how sharp the peak is.
    pub curvature: T,
}

impl<T: Real> MagicFormula<T> {
    /// The argument of the outer atan, and its derivative by B x.
    #[inline(always)]
    fn bent(&self, bx: T) -> (T, T) {
        // One that is zero and free is not the same: it has a derivative.
        if self.curvature == T::constant(0.0) {
            return (bx, T::constant(1.0));
        }
        let bent = bx - self.curvature * (bx - bx.atan());
        let flat = bx * bx / (bx * bx + 1.0);
        (bent, -(self.curvature * flat) + 1.0)
    }
}

impl<T: Real> Curve<T> for MagicFormula<T> {
    #[inline(always)]
    fn force(&self, stiffness: T, friction: T, slip: T) -> T {
        let (bent, _) = self.bent(stiffness / (self.shape * friction) * slip);
        let (sin, _) = (self.shape * bent.atan()).sin_cos();
        friction * sin
    }

    #[inline(always)]
    fn slip(&self, stiffness: T, friction: T, force: T) -> T {
        // sin(C atan z) = F/D gives z at once; B x follows from it by Newton's method, whose last step,
        // in T, has the exact derivative.
        let share = (force / friction).at_least(T::constant(-1.0 + 1e-9)).at_most(T::constant(1.0 - 1e-9));
        let sine = share.value();
        let angle = share.map(sine.asin(), 1.0 / (1.0 - sine * sine).sqrt());
        let (sin, cos) = (angle / self.shape).sin_cos();
        let wanted = sin / cos;
        let mut bx = wanted;
        if self.curvature.value() != 0.0 {
            for _ in 0..12 {
                let (bent, by) = self.bent(T::constant(bx.value()));
                let step = (bent.value() - wanted.value()) / by.value();
                bx = T::constant(bx.value() - step);
                if step.abs() < 1e-13 * bx.value().abs() {
                    break;
                }
            }
        }
        let (bent, by) = self.bent(T::constant(bx.value()));
        bx = bx - (bent - wanted) / by;
        bx * self.shape * friction / stiffness
    }
}

impl Shape for MagicFormula {
    #[inline]
    fn slope(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        self.force_and_slope(stiffness, friction, slip)[1]
    }

    // Its arcs are nearly all of the work, and the same for both.
    #[inline]
    fn force_and_slope(&self, stiffness: f64, friction: f64, slip: f64) -> [f64; 2] {
        let (bent, by_bx) = self.bent(stiffness / (self.shape * friction) * slip);
        let (sin, cos) = Real::sin_cos(self.shape * bent.atan());
        [friction * sin, stiffness * cos * by_bx / (1.0 + bent * bent)]
    }

    fn peak_slip(&self, stiffness: f64, friction: f64) -> f64 {
        if self.shape <= 1.0 {
            return f64::INFINITY;
        }
        let wanted = (FRAC_PI_2 / self.shape).tan();
        // The bent argument grows with B x (E ≤ 1): bracket, then bisect.
        let (mut low, mut high) = (0.0, wanted);
        while self.bent(high).0 < wanted && high < 1e9 {
            low = high;
            high *= 2.0;
        }
        for _ in 0..64 {
            let middle = 0.5 * (low + high);
            if self.bent(middle).0 < wanted { low = middle } else { high = middle }
        }
        high * self.shape * friction / stiffness
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Dual;

    #[test]
    fn a_curvature_of_zero_has_a_derivative() {
        let force = |curvature| MagicFormula { shape: 1.5, curvature }.force(12.0, 0.9, 0.1);
        let (magic, h) =
            (MagicFormula { shape: Dual::constant(1.5), curvature: Dual::<1>::variable(0.0, 0) }, 1e-6);
        let [stiffness, friction, slip] = [12.0, 0.9, 0.1].map(Dual::constant);
        let by = magic.force(stiffness, friction, slip).by[0];
        assert!((by - (force(h) - force(-h)) / (2.0 * h)).abs() < 1e-8 && by.abs() > 0.001, "{by}");
        // And the other way round.
        let slip = |curvature| MagicFormula { shape: 1.5, curvature }.slip(12.0, 0.9, 0.5);
        let by = magic.slip(stiffness, friction, Dual::constant(0.5)).by[0];
        assert!((by - (slip(h) - slip(-h)) / (2.0 * h)).abs() < 1e-8 && by.abs() > 1e-4, "{by}");
    }
}
