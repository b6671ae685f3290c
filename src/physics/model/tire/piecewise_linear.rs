//! The piecewise linear tire (thesis 4.11, 4.14).

use super::{Curve, Real, Shape};

/// Proportional up to the friction, then constant. Below saturation it is *exactly* linear, so that
/// nothing can be learnt of the friction there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PiecewiseLinear;

impl<T: Real> Curve<T> for PiecewiseLinear {
    #[inline(always)]
    fn force(&self, stiffness: T, friction: T, slip: T) -> T {
        (stiffness * slip).at_least(-friction).at_most(friction)
    }

    #[inline(always)]
    fn slip(&self, stiffness: T, _friction: T, force: T) -> T {
        force / stiffness
    }
}

impl Shape for PiecewiseLinear {
    #[inline]
    fn slope(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        if (stiffness * slip).abs() < friction { stiffness } else { 0.0 }
    }

    fn peak_slip(&self, stiffness: f64, friction: f64) -> f64 {
        friction / stiffness
    }
}
