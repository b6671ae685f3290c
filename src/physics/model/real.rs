//! The numbers the equations are written in: plain ones, several at once, or ones that carry their
//! derivatives.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// The outcome of a comparison: of one number, or of several at once.
pub trait Mask: Copy + Debug + PartialEq {
    /// Where both are.
    fn and(self, other: Self) -> Self;
    /// Is it so anywhere?
    fn any(self) -> bool;
    /// Is it so everywhere?
    fn all(self) -> bool;
}

impl Mask for bool {
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self && other
    }

    #[inline(always)]
    fn any(self) -> bool {
        self
    }

    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

/// What the equations of the plain car are written in: `f64` to simulate one, [`Lanes`](super::Lanes) to
/// simulate several at once, [`Dual`](super::Dual) to simulate and differentiate.
///
/// Several numbers at once may be on both sides of a kink: equations ask with a comparison and take what
/// belongs to it with [`Number::pick`]. `==` is of all that a number is: of every one of several, and of derivatives.
pub trait Number:
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
    /// What a comparison gives.
    type Mask: Mask;

    /// A number that does not depend on anything.
    fn constant(value: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Arc tangent.
    fn atan(self) -> Self;
    /// The larger of it and a bound.
    fn at_least(self, bound: Self) -> Self;
    /// The smaller of it and a bound.
    fn at_most(self, bound: Self) -> Self;
    /// With the sign of another number.
    fn with_sign_of(self, other: Self) -> Self;
    /// Is it below another number?
    fn is_below(self, other: Self) -> Self::Mask;
    /// Is it another number or below?
    fn is_at_most(self, other: Self) -> Self::Mask;
    /// Is it zero?
    fn is_zero(self) -> Self::Mask;
    /// What belongs to the outcome of a comparison. Of a single number only that is worked out.
    fn pick<const N: usize>(
        mask: Self::Mask,
        so: impl FnOnce() -> [Self; N],
        otherwise: impl FnOnce() -> [Self; N],
    ) -> [Self; N];
}

/// One real number: `f64`, or [`Dual`](super::Dual) with its derivatives.
///
/// Comparisons are on the value: where equations have a kink, the derivative is that of the side one
/// is on.
pub trait Real: Number<Mask = bool> {
    /// The number itself, without its derivatives.
    fn value(self) -> f64;
    /// A function of this number, given its value and its derivative here.
    fn map(self, value: f64, derivative: f64) -> Self;

    /// Exponential.
    #[inline(always)]
    fn exp(self) -> Self {
        let value = self.value().exp();
        self.map(value, value)
    }
}

/// The functions of one real number by its value and its derivative.
macro_rules! number_of_real {
    () => {
        type Mask = bool;

        #[inline(always)]
        fn sqrt(self) -> Self {
            let root = self.value().sqrt();
            self.map(root, 0.5 / root)
        }

        #[inline(always)]
        fn abs(self) -> Self {
            if self.value() < 0.0 { -self } else { self }
        }

        #[inline(always)]
        fn sin_cos(self) -> (Self, Self) {
            let (sin, cos) = self.value().sin_cos();
            (self.map(sin, cos), self.map(cos, -sin))
        }

        #[inline(always)]
        fn atan(self) -> Self {
            let value = self.value();
            self.map(value.atan(), 1.0 / (1.0 + value * value))
        }

        #[inline(always)]
        fn at_least(self, bound: Self) -> Self {
            if self.value() < bound.value() { bound } else { self }
        }

        #[inline(always)]
        fn at_most(self, bound: Self) -> Self {
            if self.value() > bound.value() { bound } else { self }
        }

        #[inline(always)]
        fn with_sign_of(self, other: Self) -> Self {
            if self.value().is_sign_negative() == other.value().is_sign_negative() { self } else { -self }
        }

        #[inline(always)]
        fn is_below(self, other: Self) -> bool {
            self.value() < other.value()
        }

        #[inline(always)]
        fn is_at_most(self, other: Self) -> bool {
            self.value() <= other.value()
        }

        #[inline(always)]
        fn is_zero(self) -> bool {
            self.value() == 0.0
        }

        #[inline(always)]
        fn pick<const COUNT: usize>(
            mask: bool,
            so: impl FnOnce() -> [Self; COUNT],
            otherwise: impl FnOnce() -> [Self; COUNT],
        ) -> [Self; COUNT] {
            if mask { so() } else { otherwise() }
        }
    };
}
pub(super) use number_of_real;

impl Number for f64 {
    number_of_real!();

    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
}

impl Real for f64 {
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn map(self, value: f64, _derivative: f64) -> Self {
        value
    }
}
