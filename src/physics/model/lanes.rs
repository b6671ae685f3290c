//! Several cars at once: each number of the equations is one of each car, side by side.
//!
//! A compiler makes one instruction of what is done to neighbours: two of them on any x86-64 and on
//! aarch64, four with AVX2, eight with AVX-512. Each lane's result depends on its own numbers only, and is
//! the same on all machines.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use super::body::{Body, External, Velocity};
use super::elementary;
use super::plant::{Conditions, Controls, Plant, State};
use super::real::{Mask, Number};
use super::tire::{Contact, MagicFormula, Tire};

/// K numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const K: usize>(pub [f64; K]);

/// K outcomes of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Where<const K: usize>([bool; K]);

impl<const K: usize> Default for Lanes<K> {
    fn default() -> Self {
        Self([0.0; K])
    }
}

// Loops over places, no `array::from_fn` and no `zip`: those are not inlined in every build, and what calls
// them is then no vector any more.

impl<const K: usize> Mask for Where<K> {
    #[inline(always)]
    fn and(mut self, other: Self) -> Self {
        for (place, one) in self.0.iter_mut().enumerate() {
            *one &= other.0[place];
        }
        self
    }

    #[inline(always)]
    fn any(self) -> bool {
        let mut any = false;
        for one in self.0 {
            any |= one;
        }
        any
    }

    #[inline(always)]
    fn all(self) -> bool {
        let mut all = true;
        for one in self.0 {
            all &= one;
        }
        all
    }
}

impl<const K: usize> Lanes<K> {
    #[inline(always)]
    fn each(mut self, of: impl Fn(f64) -> f64) -> Self {
        for one in &mut self.0 {
            *one = of(*one);
        }
        self
    }

    #[inline(always)]
    fn with(mut self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        for (place, one) in self.0.iter_mut().enumerate() {
            *one = of(*one, other.0[place]);
        }
        self
    }

    #[inline(always)]
    fn compared(self, other: Self, of: impl Fn(f64, f64) -> bool) -> Where<K> {
        let mut mask = [false; K];
        for (place, outcome) in mask.iter_mut().enumerate() {
            *outcome = of(self.0[place], other.0[place]);
        }
        Where(mask)
    }
}

impl<const K: usize> Number for Lanes<K> {
    type Mask = Where<K>;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; K])
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.each(f64::sqrt)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.each(f64::abs)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = elementary::sin_cos(&self.0);
        (Self(sin), Self(cos))
    }

    #[inline(always)]
    fn atan(self) -> Self {
        Self(elementary::atan(&self.0))
    }

    #[inline(always)]
    fn at_least(self, bound: Self) -> Self {
        self.with(bound, |a, b| if a < b { b } else { a })
    }

    #[inline(always)]
    fn at_most(self, bound: Self) -> Self {
        self.with(bound, |a, b| if a > b { b } else { a })
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        // As for one number: turned round where the signs differ.
        const SIGN: u64 = 1 << 63;
        self.with(other, |a, b| f64::from_bits(a.to_bits() ^ ((a.to_bits() ^ b.to_bits()) & SIGN)))
    }

    #[inline(always)]
    fn is_below(self, other: Self) -> Where<K> {
        self.compared(other, |a, b| a < b)
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> Where<K> {
        self.compared(other, |a, b| a <= b)
    }

    #[inline(always)]
    fn is_zero(self) -> Where<K> {
        self.compared(self, |a, _| a == 0.0)
    }

    /// Both are worked out.
    #[inline(always)]
    fn pick<const N: usize>(
        mask: Where<K>,
        so: impl FnOnce() -> [Self; N],
        otherwise: impl FnOnce() -> [Self; N],
    ) -> [Self; N] {
        let (so, mut picked) = (so(), otherwise());
        for (number, picked) in picked.iter_mut().enumerate() {
            for (place, picked) in picked.0.iter_mut().enumerate() {
                *picked = if mask.0[place] { so[number].0[place] } else { *picked };
            }
        }
        picked
    }
}

/// An operation with another lane's number, and with a plain one.
macro_rules! operation {
    ($operation:ident, $name:ident, $sign:tt) => {
        impl<const K: usize> $operation for Lanes<K> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.with(other, |a, b| a $sign b)
            }
        }

        impl<const K: usize> $operation<f64> for Lanes<K> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                self.each(|a| a $sign other)
            }
        }
    };
}

operation!(Add, add, +);
operation!(Sub, sub, -);
operation!(Mul, mul, *);
operation!(Div, div, /);

impl<const K: usize> AddAssign for Lanes<K> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const K: usize> Neg for Lanes<K> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|a| -a)
    }
}

/// What K cars have one of each, and what all of them have side by side.
pub trait Abreast<const K: usize>: Sized {
    /// The same of all K.
    type All;

    /// Side by side; none if they cannot be (other tire models).
    fn abreast(each: &[Self; K]) -> Option<Self::All>;
}

/// K of something, number by number.
fn gather<const K: usize, S>(each: &[S; K], of: impl Fn(&S) -> f64) -> Lanes<K> {
    Lanes(std::array::from_fn(|i| of(&each[i])))
}

/// The same for each wheel.
fn by_wheel<const K: usize, S>(each: &[S; K], of: impl Fn(&S) -> &[f64; 4]) -> [Lanes<K>; 4] {
    std::array::from_fn(|wheel| gather(each, |one| of(one)[wheel]))
}

impl<const K: usize> Abreast<K> for State {
    type All = State<Lanes<K>>;

    fn abreast(each: &[Self; K]) -> Option<Self::All> {
        Some(State {
            velocity: Velocity {
                vx: gather(each, |one| one.velocity.vx),
                vy: gather(each, |one| one.velocity.vy),
                yaw_rate: gather(each, |one| one.velocity.yaw_rate),
            },
            wheel_speed: by_wheel(each, |one| &one.wheel_speed),
        })
    }
}

impl<const K: usize> State<Lanes<K>> {
    /// That of one car.
    pub fn lane(&self, lane: usize) -> State {
        let Velocity { vx, vy, yaw_rate } = &self.velocity;
        State {
            velocity: Velocity { vx: vx.0[lane], vy: vy.0[lane], yaw_rate: yaw_rate.0[lane] },
            wheel_speed: self.wheel_speed.map(|speed| speed.0[lane]),
        }
    }
}

impl<const K: usize> Abreast<K> for Controls {
    type All = Controls<Lanes<K>>;

    fn abreast(each: &[Self; K]) -> Option<Self::All> {
        Some(Controls {
            steer: gather(each, |one| one.steer),
            drive_torque: by_wheel(each, |one| &one.drive_torque),
            brake_torque: by_wheel(each, |one| &one.brake_torque),
        })
    }
}

impl<const K: usize> Abreast<K> for Conditions {
    type All = Conditions<Lanes<K>>;

    fn abreast(each: &[Self; K]) -> Option<Self::All> {
        let contact = |wheel: usize| Contact {
            stiffness_x: gather(each, |one| one.contact[wheel].stiffness_x),
            stiffness_y: gather(each, |one| one.contact[wheel].stiffness_y),
            friction_x: gather(each, |one| one.contact[wheel].friction_x),
            friction_y: gather(each, |one| one.contact[wheel].friction_y),
        };
        Some(Conditions {
            contact: [0, 1, 2, 3].map(contact),
            load: by_wheel(each, |one| &one.load),
            toe: by_wheel(each, |one| &one.toe),
            external: External {
                fx: gather(each, |one| one.external.fx),
                fy: gather(each, |one| one.external.fy),
                moment: gather(each, |one| one.external.moment),
            },
        })
    }
}

impl<const K: usize> Abreast<K> for Tire {
    type All = Tire<Lanes<K>>;

    fn abreast(each: &[Self; K]) -> Option<Self::All> {
        let first = each.first()?;
        if each.iter().any(|one| std::mem::discriminant(one) != std::mem::discriminant(first)) {
            return None;
        }
        Some(match *first {
            Self::Linear(linear) => Tire::Linear(linear),
            Self::PiecewiseLinear(piecewise) => Tire::PiecewiseLinear(piecewise),
            Self::Brush(brush) => Tire::Brush(brush),
            Self::MagicFormula(_) => {
                let number = |of: fn(&MagicFormula) -> f64| {
                    gather(each, |one| if let Self::MagicFormula(formula) = one { of(formula) } else { 0.0 })
                };
                Tire::MagicFormula(MagicFormula {
                    shape: number(|formula| formula.shape),
                    curvature: number(|formula| formula.curvature),
                })
            }
        })
    }
}

impl<const K: usize> Abreast<K> for Plant {
    type All = Plant<Lanes<K>>;

    fn abreast(each: &[Self; K]) -> Option<Self::All> {
        let body = |of: fn(&Body) -> f64| gather(each, |one| of(&one.body));
        Some(Plant {
            body: Body {
                mass: body(|body| body.mass),
                yaw_inertia: body(|body| body.yaw_inertia),
                a: body(|body| body.a),
                b: body(|body| body.b),
                half_track_front: body(|body| body.half_track_front),
                half_track_rear: body(|body| body.half_track_rear),
                drag: body(|body| body.drag),
                rolling_resistance: body(|body| body.rolling_resistance),
            },
            tire: Tire::abreast(&each.map(|one| one.tire))?,
            radius: by_wheel(each, |one| &one.radius),
            wheel_inertia: gather(each, |one| one.wheel_inertia),
            nominal: Conditions::abreast(&each.map(|one| one.nominal))?,
        })
    }
}
