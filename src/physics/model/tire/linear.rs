//! The linear tire.

use super::{Curve, Real, Shape};

/// Force proportional to slip, without limit: right for small slip only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Linear;

impl<T: Real> Curve<T> for Linear {
    #[inline(always)]
    fn force(&self, stiffness: T, _friction: T, slip: T) -> T {
        stiffness * slip
    }

    #[inline(always)]
    fn slip(&self, stiffness: T, _friction: T, force: T) -> T {
        force / stiffness
    }
}

impl Shape for Linear {
    #[inline]
    fn slope(&self, stiffness: f64, _friction: f64, _slip: f64) -> f64 {
        stiffness
    }

    fn peak_slip(&self, _stiffness: f64, _friction: f64) -> f64 {
        f64::INFINITY
    }
}
