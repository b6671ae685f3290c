//! The brush tire (thesis 4.12, 8.1).
//!
//! Bristles stick where the contact patch enters and slide where it leaves, under a parabolic
//! pressure. With ψ = C s / (3 μ), the share of the patch that slides, the force is
//! μ (3 ψ − 3 ψ² + ψ³): the polynomial of methods.md §4.

use super::{Contact, Curve};

/// The brush model; it has no parameter of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Brush;

impl Brush {
    /// Combined slip: forces / normal load at slip and slip angle (rad).
    ///
    /// The sticking part of the patch pulls where its bristles bend to, (C_x s, C_y α); the sliding
    /// part against the sliding velocity, (s, tan α) of the wheel's speed. With friction that
    /// differs in the two directions the sliding friction follows the ellipse.
    #[inline]
    pub fn combined(&self, contact: &Contact, slip: f64, slip_angle: f64) -> [f64; 2] {
        let x = contact.stiffness_x * slip;
        let y = contact.stiffness_y * slip_angle;
        let psi = norm(x / contact.friction_x, y / contact.friction_y) / 3.0;
        if psi == 0.0 {
            return [0.0, 0.0];
        }
        let (sticking, sliding) =
            if psi < 1.0 { ((1.0 - psi) * (1.0 - psi), psi * psi * (3.0 - 2.0 * psi)) } else { (0.0, 1.0) };
        let (sin, cos) = slip_angle.sin_cos();
        let (along, across) = (slip * cos, sin);
        let length = norm(along / contact.friction_x, across / contact.friction_y);
        // Slips too small to have a length in floating point do not slide either.
        let scale = if length > 0.0 { sliding / length } else { 0.0 };
        [x * sticking + along * scale, y * sticking + across * scale]
    }
}

/// √(x² + y²); slips are far from where `hypot` would be needed, and it is slow.
#[inline]
fn norm(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

impl Curve for Brush {
    #[inline]
    fn force(&self, stiffness: f64, friction: f64, slip: f64) -> f64 {
        let psi = (stiffness * slip.abs() / (3.0 * friction)).min(1.0);
        (friction * psi * (3.0 - psi * (3.0 - psi))).copysign(slip)
    }

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
