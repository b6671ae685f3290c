//! The brush tire (thesis 4.12, 8.1).
//!
//! Bristles stick where the contact patch enters and slide where it leaves, under a parabolic
//! pressure. With ψ = C s / (3 μ), the share of the patch that slides, the force is
//! μ (3 ψ − 3 ψ² + ψ³): the polynomial of methods.md §4.

use super::{Contact, Curve, Real, Shape};

/// The brush model; it has no parameter of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Brush;

impl Brush {
    /// Combined slip: forces / normal load at slip and slip angle (rad).
    ///
    /// The sticking part of the patch pulls where its bristles bend to, (C_x s, C_y α); the sliding
    /// part against the sliding velocity, (s, tan α) of the wheel's speed. With friction that
    /// differs in the two directions the sliding friction follows the ellipse.
    #[inline(always)]
    pub fn combined<T: Real>(&self, contact: &Contact<T>, slip: T, slip_angle: T) -> [T; 2] {
        let x = contact.stiffness_x * slip;
        let y = contact.stiffness_y * slip_angle;
        let psi = norm(x / contact.friction_x, y / contact.friction_y) / 3.0;
        let (sin, cos) = slip_angle.sin_cos();
        let (along, across) = (slip * cos, sin);
        let length = norm(along / contact.friction_x, across / contact.friction_y);
        let partly = || {
            let stick = -psi + 1.0;
            let sticking = stick * stick;
            let sliding = psi * psi * (-psi * 2.0 + 3.0) / length;
            [x * sticking + along * sliding, y * sticking + across * sliding]
        };
        let slides = T::constant(1.0).is_at_most(psi);
        // Slips too small to have a length in floating point do not slide, either.
        if psi.at_most(length).is_zero() {
            [x, y]
        } else if slides {
            [along / length, across / length]
        } else {
            partly()
        }
    }
}

/// √(x² + y²); slips are far from where `hypot` would be needed, and it is slow.
#[inline(always)]
fn norm<T: Real>(x: T, y: T) -> T {
    let square = x * x + y * y;
    // The root has no derivative at zero, and is not needed there.
    if square.is_zero() { square } else { square.sqrt() }
}

impl<T: Real> Curve<T> for Brush {
    #[inline(always)]
    fn force(&self, stiffness: T, friction: T, slip: T) -> T {
        let psi = stiffness * slip.abs() / (friction * 3.0);
        let sticks = psi.is_below(T::constant(1.0));
        let force = if sticks { friction * psi * (psi * (psi - 3.0) + 3.0) } else { friction };
        force.with_sign_of(slip)
    }

    /// F = μ (1 − (1 − ψ)³), solved for ψ.
    #[inline(always)]
    fn slip(&self, stiffness: T, friction: T, force: T) -> T {
        let left = (-(force.abs() / friction) + 1.0).at_least(T::constant(1e-9));
        let root = left.value().cbrt();
        let psi = -left.map(root, root / (3.0 * left.value())) + 1.0;
        (psi * 3.0 * friction / stiffness).with_sign_of(force)
    }
}

impl Shape for Brush {
    #[inline]
    fn slope(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        let stick = (1.0 - stiffness * slip.abs() / (3.0 * friction)).max(0.0);
        stiffness * stick * stick
    }

    fn peak_slip(&self, stiffness: f64, friction: f64) -> f64 {
        3.0 * friction / stiffness
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// methods.md §4: C s − C² s|s|/(3 μ) + C³ s³/(27 μ²).
    #[test]
    fn is_the_polynomial_of_the_thesis() {
        let (c, mu) = (40.0, 0.7);
        for step in -50..=50 {
            let s = f64::from(step) * 1e-3;
            let polynomial =
                c * s - c * c * s * s.abs() / (3.0 * mu) + c.powi(3) * s.powi(3) / (27.0 * mu * mu);
            assert!((Brush.force(c, mu, s) - polynomial).abs() < 1e-12, "s = {s}");
        }
        assert_eq!(Brush.force(c, mu, -1.0), -mu);
    }

    #[test]
    fn a_locked_wheel_in_a_turn_brakes_against_its_motion() {
        let contact = Contact { stiffness_x: 50.0, stiffness_y: 12.0, friction_x: 0.8, friction_y: 0.8 };
        let [x, y] = Brush.combined(&contact, -1.0, 0.3);
        assert!((x.hypot(y) - 0.8).abs() < 1e-12);
        assert!((y / -x - 0.3f64.tan()).abs() < 1e-12);
    }
}
