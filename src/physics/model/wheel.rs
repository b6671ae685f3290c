//! One wheel: slip, slip angle, rotation (thesis 4.5, 4.7, 4.9; methods.md §2).

use super::Real;

/// Below this speed of the contact point slip and slip angle are related to it instead of to the
/// true speed, m/s: the tire becomes a viscous damper, forces stay bounded and vanish with motion.
pub const LOW_SPEED_MPS: f64 = 0.5;

/// The speed that slip is relative to, m/s.
#[inline(always)]
pub fn reference_speed<T: Real>(along: T) -> T {
    along.abs().at_least(T::constant(LOW_SPEED_MPS))
}

/// SAE slip (r ω − v)/|v| of a wheel whose contact point moves with `along` in the wheel plane.
///
/// Positive when the force points forward, in reverse, too.
#[inline(always)]
pub fn slip<T: Real>(rolling: T, along: T) -> T {
    (rolling - along) / reference_speed(along)
}

/// Angular speed, rad/s, of a wheel that goes forward with this slip: [`slip`] the other way round.
#[inline(always)]
pub fn speed_of_slip<T: Real>(along: T, slip: T, radius: T) -> T {
    along * (slip + 1.0) / radius
}

/// Slip angle, rad, of a wheel whose contact point moves with `along` in and `across` to the wheel
/// plane (to the left). Positive when it gives a force to the left: for a car going forward
/// δ − atan((v_y + a r)/v_x), the negative of the ISO 8855 slip angle.
#[inline(always)]
pub fn slip_angle<T: Real>(along: T, across: T) -> T {
    -(across / reference_speed(along)).atan()
}

/// What is along and across an axle's wheels, along and across one that is turned to the left by a further
/// small angle, rad (toe, roll steer): exact to its third power.
#[inline(always)]
pub fn turned<T: Real>([along, across]: [T; 2], angle: T) -> [T; 2] {
    let one = T::constant(1.0);
    let (sin, cos) = (angle * (one - angle * angle / 6.0), one - angle * 0.5 * angle);
    [along * cos + across * sin, across * cos - along * sin]
}

/// Which way a wheel's brake acts during one integration step.
///
/// Chosen at the step's start and kept through it, so that the step sees smooth equations; a wheel
/// that would be turned backwards by its brake is stopped at the step's end instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Braking<T: Real = f64> {
    /// It acts against the rotation of this sign (+1 or −1)…
    pub sign: T,
    /// …or holds the wheel still.
    pub held: bool,
}

impl<T: Real> Braking<T> {
    /// The state of a brake of torque `brake_nm` on a wheel that turns with `speed`, rad/s, under
    /// all other torques `other_nm`.
    #[inline(always)]
    pub fn of(speed: T, brake_nm: T, other_nm: T) -> Self {
        let (zero, one) = (T::constant(0.0), T::constant(1.0));
        let stands = speed.is_zero();
        let sign = one.with_sign_of(if stands { other_nm } else { speed });
        let holds = zero.is_below(brake_nm) && other_nm.abs().is_at_most(brake_nm);
        Self { sign, held: stands && holds }
    }

    /// Of a wheel that turns, or has no brake.
    #[inline(always)]
    pub fn turning(speed: T) -> Self {
        let one = T::constant(1.0);
        Self { sign: one.with_sign_of(speed), held: one.is_zero() }
    }

    /// Angular acceleration, rad/s²: J ω̇ = τ − r F_x − brake.
    #[inline(always)]
    pub fn acceleration(self, other_nm: T, brake_nm: T, inertia: T) -> T {
        if self.held { T::constant(0.0) } else { (other_nm - self.sign * brake_nm) / inertia }
    }

    /// The wheel's speed at the end of a step: zero, if the brake has stopped it within the step.
    #[inline(always)]
    pub fn stopped(self, speed: T, brake_nm: T) -> T {
        let zero = T::constant(0.0);
        let backwards = zero.is_below(brake_nm) && (speed * self.sign).is_below(zero);
        if backwards || self.held { zero } else { speed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slip_is_sae_and_bounded_at_standstill() {
        assert!((slip(10.5, 10.0) - 0.05).abs() < 1e-12);
        assert_eq!(slip(0.0, 10.0), -1.0);
        assert!(slip(-10.5, -10.0) < 0.0, "spinning faster in reverse drives backwards");
        assert_eq!(slip(0.0, 0.0), 0.0);
        assert_eq!(slip(0.1, 0.0), 0.1 / LOW_SPEED_MPS);
        assert!((0.3 * speed_of_slip(10.0, slip(10.5, 10.0), 0.3) - 10.5).abs() < 1e-12);
    }

    #[test]
    fn slip_angle_opposes_the_sideways_motion() {
        assert!((slip_angle(10.0, -1.0) - 0.1f64.atan()).abs() < 1e-12);
        assert!(slip_angle(-10.0, -1.0) > 0.0);
        assert_eq!(slip_angle(0.0, 0.0), 0.0);
    }

    #[test]
    fn a_wheel_turned_left_against_a_motion_to_the_right_meets_it_sideways() {
        let (angle, speed) = (0.02, [10.0, -1.0]);
        let [along, across] = turned(speed, angle);
        assert!((along - (10.0 * angle.cos() - angle.sin())).abs() < 1e-7);
        assert!((slip_angle(along, across) - slip_angle(10.0, -1.0) - angle).abs() < 1e-7);
        let [back_along, back_across] = turned([along, across], -angle);
        assert!((back_along - 10.0).abs() < 1e-6 && (back_across + 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_brake_holds_up_to_its_torque_and_never_pushes() {
        assert!(Braking::of(0.0, 100.0, 99.0).held);
        assert_eq!(Braking::of(0.0, 100.0, -101.0), Braking { sign: -1.0, held: false });
        let forward = Braking::of(0.1, 100.0, 0.0);
        assert_eq!(forward.acceleration(0.0, 100.0, 2.0), -50.0);
        assert_eq!(forward.stopped(-0.4, 100.0), 0.0);
        assert_eq!(forward.stopped(-0.4, 0.0), -0.4, "without a brake a wheel may turn backwards");
    }
}
