//! Tires: normalized forces from slip and slip angle (thesis 4.3, methods.md §4).
//!
//! Every model is a curve: force / normal load over slip, with an initial slope (the normalized
//! stiffness) and a limit (the friction). The curves take both as arguments, because the surface
//! changes them while one drives; what belongs to the tire alone (its shape) is in [`Tire`].

mod brush;
mod closest;
mod dahl;
pub mod ellipse;
mod given_force;
mod linear;
mod magic_formula;
mod piecewise_linear;

pub use brush::Brush;
pub use closest::Closest;
pub use dahl::DahlTire;
pub use linear::Linear;
pub use magic_formula::MagicFormula;
pub use piecewise_linear::PiecewiseLinear;

use super::{Real, TireKind, Vehicle};

/// What tire and surface make of each other at one wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<T = f64> {
    /// Longitudinal stiffness k: force / normal load per unit slip.
    pub stiffness_x: T,
    /// Lateral stiffness: force / normal load per rad of slip angle.
    pub stiffness_y: T,
    /// Longitudinal friction: the largest force / normal load.
    pub friction_x: T,
    /// Lateral friction: the largest force / normal load.
    pub friction_y: T,
}

impl<T: Real> Contact<T> {
    /// A force along / load within what there is of friction: at all of it no slip is certain any more.
    #[inline(always)]
    pub fn transmitted(&self, x: T) -> T {
        let most = self.friction_x * 0.99;
        x.at_most(most).at_least(-most)
    }
}

impl Contact {
    /// Tire and road surface as springs in series (thesis 7.1): 1/k = 1/k_tire + 1/k_road.
    pub fn in_series(tire: f64, road: f64) -> f64 {
        tire * road / (tire + road)
    }
}

/// One normalized force curve. Odd in the slip; `stiffness` and `friction` are positive.
pub trait Curve<T: Real = f64> {
    /// Force / normal load at a slip (or at a slip angle in rad).
    fn force(&self, stiffness: T, friction: T, slip: T) -> T;

    /// The slip at which the force has this value, which must be below the friction: the one on the
    /// rising side.
    fn slip(&self, stiffness: T, friction: T, force: T) -> T;
}

/// What a plain curve knows of itself beside its force.
pub trait Shape: Curve {
    /// Derivative of [`Curve::force`] by the slip, exact; at a kink the value of the outer side.
    fn slope(&self, stiffness: f64, friction: f64, slip: f64) -> f64;

    /// [`Curve::force`] and [`Self::slope`] at once.
    #[inline]
    fn force_and_slope(&self, stiffness: f64, friction: f64, slip: f64) -> [f64; 2] {
        [self.force(stiffness, friction, slip), self.slope(stiffness, friction, slip)]
    }

    /// The smallest slip at which the force is largest; infinite if it grows for ever.
    fn peak_slip(&self, stiffness: f64, friction: f64) -> f64;
}

/// A tire model with the parameters of its shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tire<T = f64> {
    /// Proportional, without limit.
    Linear(Linear),
    /// Proportional up to the friction, then constant.
    PiecewiseLinear(PiecewiseLinear),
    /// Magic formula.
    MagicFormula(MagicFormula<T>),
    /// Brush.
    Brush(Brush),
}

impl Tire {
    /// The model that the `[vehicle]` table asks for.
    pub fn new(vehicle: &Vehicle) -> Self {
        match vehicle.tire {
            TireKind::Linear => Self::Linear(Linear),
            TireKind::Piecewise => Self::PiecewiseLinear(PiecewiseLinear),
            TireKind::Brush => Self::Brush(Brush),
            TireKind::MagicFormula => Self::MagicFormula(MagicFormula {
                shape: vehicle.magic_formula_shape.value,
                curvature: vehicle.magic_formula_curvature.value,
            }),
        }
    }
}

impl<T: Real> Tire<T> {
    /// Longitudinal force / normal load at pure slip.
    #[inline(always)]
    pub fn longitudinal(&self, contact: &Contact<T>, slip: T) -> T {
        self.force(contact.stiffness_x, contact.friction_x, slip)
    }

    /// Lateral force / normal load at a pure slip angle, rad; positive angle, positive force.
    #[inline(always)]
    pub fn lateral(&self, contact: &Contact<T>, slip_angle: T) -> T {
        self.force(contact.stiffness_y, contact.friction_y, slip_angle)
    }

    /// Longitudinal and lateral force / normal load at slip and slip angle (rad) together.
    ///
    /// Piecewise linear and magic formula: each as if alone, both scaled back onto the friction
    /// ellipse (thesis 4.15). Brush: its own combined slip ([`Brush::combined`]). Linear: no limit.
    #[inline(always)]
    pub fn combined(&self, contact: &Contact<T>, slip: T, slip_angle: T) -> [T; 2] {
        match self {
            Self::Linear(_) => [contact.stiffness_x * slip, contact.stiffness_y * slip_angle],
            Self::PiecewiseLinear(curve) => ellipse::pair(curve, contact, slip, slip_angle),
            Self::MagicFormula(curve) => ellipse::pair(curve, contact, slip, slip_angle),
            Self::Brush(brush) => brush.combined(contact, slip, slip_angle),
        }
    }
}

/// Hands a call on to the model.
macro_rules! of_model {
    ($tire:expr, $curve:ident => $call:expr) => {
        match $tire {
            Tire::Linear($curve) => $call,
            Tire::PiecewiseLinear($curve) => $call,
            Tire::MagicFormula($curve) => $call,
            Tire::Brush($curve) => $call,
        }
    };
}

impl<T: Real> Curve<T> for Tire<T> {
    #[inline(always)]
    fn force(&self, stiffness: T, friction: T, slip: T) -> T {
        of_model!(self, curve => curve.force(stiffness, friction, slip))
    }

    #[inline(always)]
    fn slip(&self, stiffness: T, friction: T, force: T) -> T {
        of_model!(self, curve => curve.slip(stiffness, friction, force))
    }
}

impl Shape for Tire {
    #[inline]
    fn slope(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        of_model!(self, curve => curve.slope(stiffness, friction, slip))
    }

    #[inline]
    fn force_and_slope(&self, stiffness: f64, friction: f64, slip: f64) -> [f64; 2] {
        of_model!(self, curve => curve.force_and_slope(stiffness, friction, slip))
    }

    fn peak_slip(&self, stiffness: f64, friction: f64) -> f64 {
        of_model!(self, curve => curve.peak_slip(stiffness, friction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TIRES: [Tire; 5] = [
        Tire::Linear(Linear),
        Tire::PiecewiseLinear(PiecewiseLinear),
        Tire::Brush(Brush),
        Tire::MagicFormula(MagicFormula { shape: 1.3, curvature: 0.0 }),
        Tire::MagicFormula(MagicFormula { shape: 1.65, curvature: -2.0 }),
    ];

    #[test]
    fn the_initial_slope_is_the_stiffness() {
        for tire in TIRES {
            let small = 1e-7;
            assert!((tire.force(50.0, 0.8, small) / small - 50.0).abs() < 1e-3, "{tire:?}");
            assert!((tire.slope(50.0, 0.8, 0.0) - 50.0).abs() < 1e-9, "{tire:?}");
        }
    }

    #[test]
    fn the_peak_is_the_friction_and_lies_where_it_is_said() {
        for tire in &TIRES[1..] {
            let peak = tire.peak_slip(50.0, 0.8);
            assert!((tire.force(50.0, 0.8, peak) - 0.8).abs() < 1e-9, "{tire:?}");
            assert!(tire.force(50.0, 0.8, 0.98 * peak) < 0.8, "{tire:?}");
        }
        assert_eq!(TIRES[0].peak_slip(50.0, 0.8), f64::INFINITY);
    }

    #[test]
    fn springs_in_series_are_softer_than_each() {
        assert_eq!(Contact::in_series(100.0, 100.0), 50.0);
        assert!((Contact::in_series(95.0, 1e9) - 95.0).abs() < 1e-4);
    }

    fn contact() -> impl Strategy<Value = Contact> {
        (1.0..200.0, 1.0..40.0, 0.05..1.3, 0.05..1.3).prop_map(
            |(stiffness_x, stiffness_y, friction_x, friction_y)| Contact {
                stiffness_x,
                stiffness_y,
                friction_x,
                friction_y,
            },
        )
    }

    proptest! {
        #[test]
        fn curves_are_odd_and_their_slope_is_their_derivative(
            index in 0..TIRES.len(), stiffness in 1.0..200.0, friction in 0.05..1.3, slip in -2.0..2.0f64,
        ) {
            let tire = TIRES[index];
            let force = |slip: f64| tire.force(stiffness, friction, slip);
            prop_assert_eq!(force(-slip), -force(slip));
            // A kink within the difference's reach would spoil the comparison, not the curve.
            let kink = tire.peak_slip(stiffness, friction);
            prop_assume!((slip.abs() - kink).abs() > 1e-5);
            let difference = (force(slip + 1e-6) - force(slip - 1e-6)) / 2e-6;
            let slope = tire.slope(stiffness, friction, slip);
            prop_assert!((difference - slope).abs() < 1e-3 * stiffness.max(1.0), "{difference} {slope}");
            prop_assert_eq!(tire.force_and_slope(stiffness, friction, slip), [force(slip), slope]);
        }

        #[test]
        fn the_slip_of_a_force_gives_that_force(
            index in 0..TIRES.len(), stiffness in 1.0..200.0, friction in 0.05..1.3, share in -0.99..0.99f64,
        ) {
            let force = share * friction;
            let slip = TIRES[index].slip(stiffness, friction, force);
            prop_assert!((TIRES[index].force(stiffness, friction, slip) - force).abs() < 1e-9 * friction);
        }

        #[test]
        fn combined_forces_stay_within_the_ellipse(
            index in 1..TIRES.len(), contact in contact(), slip in -50.0..50.0f64, angle in -1.57..1.57f64,
        ) {
            let [x, y] = TIRES[index].combined(&contact, slip, angle);
            let used = (x / contact.friction_x).powi(2) + (y / contact.friction_y).powi(2);
            prop_assert!(used <= 1.0 + 1e-12, "{used}");
            prop_assert!(x * slip >= 0.0 && y * angle >= 0.0);
        }

        #[test]
        fn combined_with_one_slip_alone_is_that_curve(
            index in 0..TIRES.len(), contact in contact(), slip in -1.5..1.5f64,
        ) {
            let tire = TIRES[index];
            let [x, y] = tire.combined(&contact, slip, 0.0);
            prop_assert!((x - tire.longitudinal(&contact, slip)).abs() < 1e-9 && y == 0.0);
            let [x, y] = tire.combined(&contact, 0.0, slip);
            prop_assert!((y - tire.lateral(&contact, slip)).abs() < 1e-9 && x == 0.0);
        }
    }
}
