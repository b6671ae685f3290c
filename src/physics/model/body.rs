//! The planar body: from forces at four wheels to accelerations (thesis 4.1–4.4; methods.md §1).

use super::{GRAVITY, Real, Vehicle};

/// What the body's equations need of the vehicle, as bare numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body<T = f64> {
    /// Mass, kg.
    pub mass: T,
    /// Yaw inertia, kg m².
    pub yaw_inertia: T,
    /// Centre of gravity to front axle, m.
    pub a: T,
    /// Centre of gravity to rear axle, m.
    pub b: T,
    /// Half of the front track, m.
    pub half_track_front: T,
    /// Half of the rear track, m.
    pub half_track_rear: T,
    /// Air drag, N/(m/s)².
    pub drag: T,
    /// Rolling resistance, force / load. It acts on the body, so that the rolling radius is that of
    /// a wheel without torque and a freely rolling wheel has no slip.
    pub rolling_resistance: T,
}

/// Motion in the road plane, in the body's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity<T = f64> {
    /// Longitudinal, m/s.
    pub vx: T,
    /// Lateral, m/s, to the left.
    pub vy: T,
    /// Yaw rate, rad/s, to the left.
    pub yaw_rate: T,
}

/// The front wheels' steering angle with its sine and cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steer<T = f64> {
    /// Sine.
    pub sin: T,
    /// Cosine.
    pub cos: T,
}

impl<T: Real> Steer<T> {
    /// From the angle, rad, positive to the left.
    #[inline(always)]
    pub fn new(angle: T) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { sin, cos }
    }
}

/// Forces on the body that are not the tires'.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct External<T = f64> {
    /// Forward at the centre of gravity, N (grade, head wind).
    pub fx: T,
    /// To the left at the centre of gravity, N (bank, cross wind).
    pub fy: T,
    /// Yaw moment, N m.
    pub moment: T,
}

impl<T: Real> External<T> {
    /// Nothing but the tires.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = T::constant(0.0);
        Self { fx: zero, fy: zero, moment: zero }
    }
}

/// Accelerations of the body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Acceleration<T = f64> {
    /// Change of the longitudinal velocity v̇x, m/s².
    pub vx_rate: T,
    /// Change of the lateral velocity v̇y, m/s².
    pub vy_rate: T,
    /// Yaw acceleration, rad/s².
    pub yaw: T,
    /// Acceleration of the centre of gravity forward, v̇x − vy r, m/s².
    pub ax: T,
    /// Acceleration of the centre of gravity to the left, v̇y + vx r, m/s².
    pub ay: T,
}

impl Body {
    /// From the vehicle's parameters.
    pub fn new(vehicle: &Vehicle) -> Self {
        Self {
            mass: vehicle.mass(),
            yaw_inertia: vehicle.yaw_inertia(),
            a: vehicle.a(),
            b: vehicle.b(),
            half_track_front: 0.5 * vehicle.track_front_m.value,
            half_track_rear: 0.5 * vehicle.track_rear_m.value,
            drag: vehicle.drag_coefficient_kg_per_m.value,
            rolling_resistance: vehicle.rolling_resistance.value,
        }
    }
}

impl<T: Real> Body<T> {
    /// Air drag and rolling resistance, N, against the motion; both vanish smoothly at standstill.
    #[inline(always)]
    pub fn resistance(&self, vx: T) -> T {
        let rolling = self.rolling_resistance * self.mass * GRAVITY;
        self.drag * vx * vx.abs() + rolling * vx / super::wheel::reference_speed(vx)
    }

    /// Accelerations (methods.md §1) under the tire forces `fx` and `fy`, N, along and across each
    /// wheel in the order FL, FR, RL, RR.
    #[inline(always)]
    pub fn accelerate(
        &self,
        velocity: &Velocity<T>,
        steer: Steer<T>,
        fx: &[T; 4],
        fy: &[T; 4],
        external: &External<T>,
    ) -> Acceleration<T> {
        let (front_x, front_y) = (fx[0] + fx[1], fy[0] + fy[1]);
        let front_along = front_x * steer.cos - front_y * steer.sin;
        let front_across = front_x * steer.sin + front_y * steer.cos;
        let rear_y = fy[2] + fy[3];
        let ax = (front_along + fx[2] + fx[3] - self.resistance(velocity.vx) + external.fx) / self.mass;
        let ay = (front_across + rear_y + external.fy) / self.mass;
        let moment = self.a * front_across - self.b * rear_y
            + self.half_track_front * ((fx[1] - fx[0]) * steer.cos + (fy[0] - fy[1]) * steer.sin)
            + self.half_track_rear * (fx[3] - fx[2])
            + external.moment;
        Acceleration {
            vx_rate: ax + velocity.vy * velocity.yaw_rate,
            vy_rate: ay - velocity.vx * velocity.yaw_rate,
            yaw: moment / self.yaw_inertia,
            ax,
            ay,
        }
    }

    /// Velocity of the front axle's middle, along and across its steered wheels, m/s.
    #[inline(always)]
    pub fn front_axle_velocity(&self, velocity: &Velocity<T>, steer: Steer<T>) -> [T; 2] {
        let across = velocity.vy + self.a * velocity.yaw_rate;
        [velocity.vx * steer.cos + across * steer.sin, across * steer.cos - velocity.vx * steer.sin]
    }

    /// Velocity of the rear axle's middle, along and across the car, m/s.
    #[inline(always)]
    pub fn rear_axle_velocity(&self, velocity: &Velocity<T>) -> [T; 2] {
        [velocity.vx, velocity.vy - self.b * velocity.yaw_rate]
    }

    /// Velocity of each contact point along its wheel plane, m/s, tracks and yaw rate included.
    #[inline(always)]
    pub fn contact_speeds(&self, velocity: &Velocity<T>, steer: Steer<T>) -> [T; 4] {
        let [front, _] = self.front_axle_velocity(velocity, steer);
        let at_front = self.half_track_front * velocity.yaw_rate * steer.cos;
        let at_rear = self.half_track_rear * velocity.yaw_rate;
        [front - at_front, front + at_front, velocity.vx - at_rear, velocity.vx + at_rear]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body() -> Body {
        Body::new(&Vehicle::thesis())
    }

    #[test]
    fn more_drive_on_the_right_turns_left() {
        let right = [0.0, 1000.0, 0.0, 500.0];
        let motion = Velocity { vx: 20.0, ..Velocity::default() };
        let acceleration =
            body().accelerate(&motion, Steer::new(0.0), &right, &[0.0; 4], &External::default());
        assert!((acceleration.yaw - (0.75 * 1000.0 + 0.75 * 500.0) / 1700.0).abs() < 1e-12);
    }

    #[test]
    fn the_outer_wheel_is_faster() {
        let motion = Velocity { vx: 10.0, vy: 0.0, yaw_rate: 0.2 };
        let [fl, fr, rl, rr] = body().contact_speeds(&motion, Steer::new(0.0));
        assert!((fr - fl - 0.3).abs() < 1e-12 && (rr - rl - 0.3).abs() < 1e-12);
    }

    #[test]
    fn free_motion_keeps_its_velocity_over_ground() {
        let motion = Velocity { vx: 3.0, vy: -2.0, yaw_rate: 0.5 };
        let mut body = body();
        body.drag = 0.0;
        let a = body.accelerate(&motion, Steer::new(0.3), &[0.0; 4], &[0.0; 4], &External::default());
        assert_eq!((a.ax, a.ay, a.yaw), (0.0, 0.0, 0.0));
        // d|v|²/dt = 2 v·v̇ must vanish: the body's axes turn, the motion does not.
        assert!((motion.vx * a.vx_rate + motion.vy * a.vy_rate).abs() < 1e-12);
    }
}
