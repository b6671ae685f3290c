//! Friction between two surfaces (thesis 3.2; methods.md §3).
//!
//! Static models give the force at a sliding velocity. At rest they only say how much they can hold;
//! dynamic models answer what happens below that, by the deflection of the contact (pre-sliding).
//!
//! Forces are in N, or in units of the normal load, as the model's parameters are; stiffnesses
//! accordingly in N/m or 1/m. A force has the sign of the velocity of what is pulled over the ground: it
//! is the force on the ground; what is pulled feels its opposite. Tires count the same way.

mod dahl;
mod lugre;
mod sliding;

pub use dahl::Dahl;
pub use lugre::LuGre;
pub use sliding::{Coulomb, Stiction, Stribeck, Viscous};

/// A friction force that is a function of the sliding velocity.
pub trait StaticFriction {
    /// The force while sliding at `velocity`, m/s, other than zero.
    fn sliding(&self, velocity: f64) -> f64;

    /// The largest force that is held at rest.
    fn break_away(&self) -> f64;

    /// The force at any velocity under an applied force: at rest friction balances it, up to what it
    /// can hold.
    fn force(&self, velocity: f64, applied: f64) -> f64 {
        if velocity == 0.0 {
            applied.max(-self.break_away()).min(self.break_away())
        } else {
            self.sliding(velocity)
        }
    }
}

/// A friction force with an inner state: the mean deflection z of the contact, m.
pub trait DynamicFriction {
    /// ż, m/s, at a deflection and a velocity.
    fn rate(&self, deflection: f64, velocity: f64) -> f64;

    /// The force at a deflection and a velocity.
    fn force(&self, deflection: f64, velocity: f64) -> f64;

    /// The deflection in steady sliding, m; at rest that of no force.
    fn steady_deflection(&self, velocity: f64) -> f64;

    /// The deflection after `step` seconds at constant velocity: the exact solution, so that no step is
    /// too long however stiff the contact is. (Runge–Kutta needs σ0 |v| h below 2.8 times the force at
    /// sliding: microseconds for steel at 1 m/s.)
    fn advance(&self, deflection: f64, velocity: f64, step: f64) -> f64;

    /// The force in steady sliding.
    fn steady(&self, velocity: f64) -> f64 {
        self.force(self.steady_deflection(velocity), velocity)
    }
}

/// −1, 0 or 1.
#[inline]
fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}
