//! Numbers with their derivatives by N parameters: forward differentiation, exact to rounding.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use super::real::Real;

/// A value and its derivatives by N things.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// Its derivatives.
    pub by: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// The thing itself that `place` counts: its derivative by itself is 1.
    #[inline]
    pub fn variable(value: f64, place: usize) -> Self {
        let mut by = [0.0; N];
        by[place] = 1.0;
        Self { value, by }
    }

    #[inline(always)]
    fn zip(self, other: Self, value: f64, from_self: f64, from_other: f64) -> Self {
        let mut by = [0.0; N];
        // Loops over places and no `zip`, here and below: the latter is not inlined in every build, and then
        // nothing of the equations stays in registers.
        for (place, by) in by.iter_mut().enumerate() {
            *by = from_self * self.by[place] + from_other * other.by[place];
        }
        Self { value, by }
    }
}

impl<const N: usize> Real for Dual<N> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self { value, by: [0.0; N] }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn map(mut self, value: f64, derivative: f64) -> Self {
        for by in &mut self.by {
            *by *= derivative;
        }
        self.value = value;
        self
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl<const N: usize> AddAssign for Dual<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        for (place, by) in self.by.iter_mut().enumerate() {
            *by += other.by[place];
        }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self.value -= other.value;
        for (place, by) in self.by.iter_mut().enumerate() {
            *by -= other.by[place];
        }
        self
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, self.value * other.value, other.value, self.value)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        let value = self.value * inverse;
        self.zip(other, value, inverse, -value * inverse)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(-self.value, -1.0)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: f64) -> Self {
        self.value += other;
        self
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: f64) -> Self {
        self.value -= other;
        self
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.map(self.value * other, other)
    }
}

impl<const N: usize> Div<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: f64) -> Self {
        self * (1.0 / other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Something with everything in it.
    fn mixture<T: Real>(x: T, y: T) -> T {
        let (sin, cos) = (x * y).sin_cos();
        let quotient = (sin + 2.0) / (y * y + 1.0) - x * cos;
        (quotient * quotient + 0.5).sqrt() + quotient.atan() * 3.0 - (x / 4.0).exp() + (-y).abs()
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_central_differences(x in -2.0..2.0f64, y in 0.1..2.0f64) {
            let dual = mixture(Dual::<2>::variable(x, 0), Dual::variable(y, 1));
            let h = 1e-6;
            let by_x = (mixture(x + h, y) - mixture(x - h, y)) / (2.0 * h);
            let by_y = (mixture(x, y + h) - mixture(x, y - h)) / (2.0 * h);
            prop_assert!((dual.value - mixture(x, y)).abs() < 1e-12);
            prop_assert!((dual.by[0] - by_x).abs() < 1e-6 && (dual.by[1] - by_y).abs() < 1e-6);
        }
    }

    #[test]
    fn bounds_and_signs_take_the_derivative_of_their_side() {
        let x = Dual::<1>::variable(-3.0, 0);
        assert_eq!(x.abs(), Dual { value: 3.0, by: [-1.0] });
        assert_eq!(x.at_least(Dual::constant(-1.0)), Dual { value: -1.0, by: [0.0] });
        assert_eq!(x.at_most(Dual::constant(-1.0)), x);
        assert_eq!(Dual::<1>::variable(2.0, 0).with_sign_of(x), Dual { value: -2.0, by: [-1.0] });
    }
}
