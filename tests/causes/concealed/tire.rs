//! Tire forces of the suite's simulator (Pacejka 2012, ch. 4; Rajamani 2012, ch. 13).

use super::car::{CURVATURE, SHAPE};

/// Magic formula, pure slip: initial slope `stiffness` (N per unit), peak `peak` (N).
pub fn magic_formula(slip: f64, stiffness: f64, peak: f64) -> f64 {
    if peak <= 0.0 {
        return 0.0;
    }
    let x = stiffness / (SHAPE * peak) * slip;
    peak * (SHAPE * (x - CURVATURE * (x - x.atan())).atan()).sin()
}

/// How one tire answers: stiffnesses, load, and whichever limits hold.
#[derive(Clone, Copy)]
pub struct Grip {
    /// N per unit slip.
    pub longitudinal: f64,
    /// N/rad.
    pub lateral: f64,
    /// Wheel load, N.
    pub load: f64,
    /// Friction of a saturating tire.
    pub friction: Option<f64>,
    /// Strength of the friction ellipse acting on the lateral force, with the friction it is measured by.
    pub ellipse: Option<(f64, f64)>,
}

/// Longitudinal and lateral force (N) of one wheel, in its own plane.
/// A saturating tire follows the magic formula in each direction and stays inside the friction circle.
pub fn force(slip: f64, slip_angle: f64, grip: &Grip) -> [f64; 2] {
    let (mut along, mut across) = match grip.friction {
        None => (grip.longitudinal * slip, grip.lateral * slip_angle),
        Some(friction) => {
            let peak = friction * grip.load.max(0.0);
            (magic_formula(slip, grip.longitudinal, peak), magic_formula(slip_angle, grip.lateral, peak))
        }
    };
    if let Some((factor, friction)) = grip.ellipse {
        // Rajamani 2012, §13.9: longitudinal use of the ellipse takes from the lateral force.
        let used = (factor * along / (friction * grip.load.max(1.0))).clamp(-0.999, 0.999);
        across *= (1.0 - used * used).sqrt();
    }
    if let Some(friction) = grip.friction {
        let excess = along.hypot(across) / (friction * grip.load).max(1e-9);
        if excess > 1.0 {
            along /= excess;
            across /= excess;
        }
    }
    [along, across]
}
