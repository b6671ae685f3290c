//! Wheels whose rotation is no state: their inertia is the car's.
//!
//! A wheel's rotation is fifty times faster than anything else in the plane. Where it has settled, r ω̇ is the acceleration
//! of the contact point (methods.md §2), and the force on the road is what the torque gives less J ω̇/r. That adds J/r² to
//! the car's mass, and, at half a track from the middle, some per cent to its yaw inertia.

use super::WheelMotion;
use crate::model::Real;
use crate::model::body::{Acceleration, Body};

/// What such wheels add.
#[derive(Clone, Copy, Debug)]
pub struct AddedMass<T = f64> {
    /// J/r² of each wheel, kg; zero where the rotation is given.
    wheel: [T; 4],
    front: T,
    /// All wheels together, kg.
    pub all: T,
    /// Yaw inertia / (yaw inertia with that of the wheels).
    yaw_share: T,
}

/// A body that turns its wheels, too.
#[derive(Clone, Copy, Debug)]
pub struct Carried<T = f64> {
    /// Its accelerations.
    pub acceleration: Acceleration<T>,
    /// How fast the front wheels' speed grows for their turning into the axle's motion across, m/s².
    turning: T,
}

impl<T: Real> AddedMass<T> {
    /// From J/r² of each wheel, kg, zero where its rotation is given.
    #[inline(always)]
    pub fn new(body: &Body<T>, wheel: [T; 4]) -> Self {
        let front = wheel[0] + wheel[1];
        let rear = wheel[2] + wheel[3];
        let inertia = body.half_track_front * body.half_track_front * front
            + body.half_track_rear * body.half_track_rear * rear;
        let yaw_share = body.yaw_inertia / (body.yaw_inertia + inertia);
        Self { wheel, front, all: front + rear, yaw_share }
    }

    /// The accelerations with these wheels, from `bare` ones without; the front wheels are steered with `steer_rate`, rad/s.
    #[inline(always)]
    pub fn carried(
        &self,
        body: &Body<T>,
        motion: &WheelMotion<T>,
        bare: &Acceleration<T>,
        steer_rate: T,
    ) -> Carried<T> {
        let turning = motion.turning(body, bare, steer_rate);
        // The wheels follow v̇x = ax + vy r.
        let swing = motion.velocity().vy * motion.velocity().yaw_rate;
        let ax = (bare.ax * body.mass - self.all * swing - self.front * turning) / (body.mass + self.all);
        let acceleration = Acceleration { ax, vx_rate: ax + swing, yaw: bare.yaw * self.yaw_share, ..*bare };
        Carried { acceleration, turning }
    }

    /// What wheel `i` leaves to the road of a force `fx` along it, N, that torques give.
    #[inline(always)]
    pub fn on_road(&self, body: &Body<T>, carried: &Carried<T>, i: usize, fx: T) -> T {
        let Acceleration { vx_rate, yaw, .. } = carried.acceleration;
        let half_track = if i < 2 { body.half_track_front } else { body.half_track_rear };
        let side = if i.is_multiple_of(2) { -half_track } else { half_track };
        let mut faster = vx_rate + side * yaw;
        if i < 2 {
            faster += carried.turning;
        }
        fx - self.wheel[i] * faster
    }
}
