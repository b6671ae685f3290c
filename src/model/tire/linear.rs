//! The linear tire.

use super::Curve;

/// Force proportional to slip, without limit: right for small slip only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Linear;

impl Curve for Linear {
    #[inline]
    fn force(&self, stiffness: f64, _friction: f64, slip: f64) -> f64 {
        stiffness * slip
    }

    #[inline]
    fn slope(&self, stiffness: f64, _friction: f64, _slip: f64) -> f64 {
        stiffness
    }

    fn peak_slip(&self, _stiffness: f64, _friction: f64) -> f64 {
        f64::INFINITY
    }
}
