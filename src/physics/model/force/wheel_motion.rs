//! How the wheels move with the body, and how their forces move it (methods.md §1 and §2).

use crate::model::Real;
use crate::model::body::{Acceleration, Body, External, Steer, Velocity};
use crate::model::wheel;

/// The wheels' motion over the road at one instant, in the order FL, FR, RL, RR.
#[derive(Clone, Copy, Debug)]
pub struct WheelMotion<T = f64> {
    velocity: Velocity<T>,
    steer: Steer<T>,
    toe: Option<[T; 4]>,
    /// Velocity of the front axle's middle across its steered wheels, m/s.
    front_across: T,
    /// Speed of each contact point along its wheel, m/s.
    pub along: [T; 4],
    /// Slip angle of each wheel as the motion gives it, rad, positive when it gives a force to the left. Both wheels of an
    /// axle share that of its middle (thesis 4.9).
    pub slip_angle: [T; 4],
}

impl<T: Real> WheelMotion<T> {
    /// Of a body on wheels that are turned to the left of their axle by `toe`, rad, if at all.
    #[inline(always)]
    pub fn new(body: &Body<T>, velocity: Velocity<T>, steer: Steer<T>, toe: Option<[T; 4]>) -> Self {
        let mut along = body.contact_speeds(&velocity, steer);
        let [front_along, front_across] = body.front_axle_velocity(&velocity, steer);
        let [rear_along, rear_across] = body.rear_axle_velocity(&velocity);
        let front = wheel::slip_angle(front_along, front_across);
        let rear = wheel::slip_angle(rear_along, rear_across);
        let mut slip_angle = [front, front, rear, rear];
        if let Some(toe) = &toe {
            let across = [front_across, front_across, rear_across, rear_across];
            for i in 0..4 {
                slip_angle[i] += toe[i];
                [along[i], _] = wheel::turned([along[i], across[i]], toe[i]);
            }
        }
        Self { velocity, steer, toe, front_across, along, slip_angle }
    }

    /// The body's accelerations under the forces `fx` and `fy`, N, along and across each wheel.
    #[inline(always)]
    pub fn accelerate(
        &self,
        body: &Body<T>,
        fx: &[T; 4],
        fy: &[T; 4],
        external: &External<T>,
    ) -> Acceleration<T> {
        let (mut on_body_x, mut on_body_y) = (*fx, *fy);
        if let Some(toe) = &self.toe {
            for i in 0..4 {
                [on_body_x[i], on_body_y[i]] = wheel::turned([fx[i], fy[i]], -toe[i]);
            }
        }
        body.accelerate(&self.velocity, self.steer, &on_body_x, &on_body_y, external)
    }

    /// The body's motion.
    #[inline(always)]
    pub fn velocity(&self) -> &Velocity<T> {
        &self.velocity
    }

    /// How fast the front wheels' speed along grows, m/s², for their turning into the axle's motion across: with the body
    /// (`acceleration`), and by the steering, whose rate is `steer_rate`, rad/s.
    #[inline(always)]
    pub(super) fn turning(&self, body: &Body<T>, acceleration: &Acceleration<T>, steer_rate: T) -> T {
        (acceleration.vy_rate + body.a * acceleration.yaw) * self.steer.sin + self.front_across * steer_rate
    }
}
