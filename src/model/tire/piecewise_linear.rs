//! The piecewise linear tire (thesis 4.11, 4.14).

use super::Curve;

/// Proportional up to the friction, then constant. Below saturation it is *exactly* linear, so that
/// nothing can be learnt of the friction there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PiecewiseLinear;

impl Curve for PiecewiseLinear {
    #[inline]
    fn force(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        (stiffness * slip).max(-friction).min(friction)
    }

    #[inline]
    fn slope(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        if (stiffness * slip).abs() < friction { stiffness } else { 0.0 }
    }

    fn peak_slip(&self, stiffness: f64, friction: f64) -> f64 {
        friction / stiffness
    }
}
