//! The numbers the equations are written in: plain ones, or ones that carry their derivatives.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// What the equations of the car are written in: `f64` to simulate, [`Dual`](super::Dual) to simulate and differentiate.
///
/// Comparisons are on the value: where equations have a kink, the derivative is that of the side one is on. `==` is of all
/// that a number is, derivatives as well.
pub trait Real:
    Copy
    + Debug
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
{
    /// A number that does not depend on anything.
    fn constant(value: f64) -> Self;
    /// The number itself, without its derivatives.
    fn value(self) -> f64;
    /// A function of this number, given its value and its derivative here.
    fn map(self, value: f64, derivative: f64) -> Self;

    /// Square root.
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value().sqrt();
        self.map(root, 0.5 / root)
    }

    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }

    /// Sine and cosine.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value().sin_cos();
        (self.map(sin, cos), self.map(cos, -sin))
    }

    /// Arc tangent.
    #[inline(always)]
    fn atan(self) -> Self {
        let value = self.value();
        self.map(value.atan(), 1.0 / (1.0 + value * value))
    }

    /// The larger of it and a bound.
    #[inline(always)]
    fn at_least(self, bound: Self) -> Self {
        if self.value() < bound.value() { bound } else { self }
    }

    /// The smaller of it and a bound.
    #[inline(always)]
    fn at_most(self, bound: Self) -> Self {
        if self.value() > bound.value() { bound } else { self }
    }

    /// With the sign of another number.
    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        if self.value().is_sign_negative() == other.value().is_sign_negative() { self } else { -self }
    }

    /// Is it below another number?
    #[inline(always)]
    fn is_below(self, other: Self) -> bool {
        self.value() < other.value()
    }

    /// Is it another number or below?
    #[inline(always)]
    fn is_at_most(self, other: Self) -> bool {
        self.value() <= other.value()
    }

    /// Is it zero?
    #[inline(always)]
    fn is_zero(self) -> bool {
        self.value() == 0.0
    }

    /// Exponential.
    #[inline(always)]
    fn exp(self) -> Self {
        let value = self.value().exp();
        self.map(value, value)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn map(self, value: f64, _derivative: f64) -> Self {
        value
    }
}
