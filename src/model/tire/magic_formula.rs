//! The magic formula (thesis 4.10).

use std::f64::consts::FRAC_PI_2;

use super::Curve;

/// D sin(C atan(B x − E (B x − atan B x))), D the friction, B C D the stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagicFormula {
    /// Shape factor C, above 0 and at most 2: how far the force falls beyond its peak. Up to 1 it
    /// has no peak.
    pub shape: f64,
    /// Curvature factor E, at most 1: how sharp the peak is.
    pub curvature: f64,
}

impl MagicFormula {
    /// The argument of the outer atan, and its derivative by B x.
    #[inline]
    fn bent(&self, bx: f64) -> (f64, f64) {
        if self.curvature == 0.0 {
            return (bx, 1.0);
        }
        let bent = bx - self.curvature * (bx - bx.atan());
        (bent, 1.0 - self.curvature * (1.0 - 1.0 / (1.0 + bx * bx)))
    }
}

impl Curve for MagicFormula {
    #[inline]
    fn force(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        let (bent, _) = self.bent(stiffness / (self.shape * friction) * slip);
        friction * (self.shape * bent.atan()).sin()
    }

    #[inline]
    fn slope(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        let (bent, by_bx) = self.bent(stiffness / (self.shape * friction) * slip);
        stiffness * (self.shape * bent.atan()).cos() * by_bx / (1.0 + bent * bent)
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
