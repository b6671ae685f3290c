//! The linear bicycle model (methods.md §7, method 3): lateral velocity and yaw rate at given speed.

use nalgebra::{Matrix2, Vector2};

/// A planar car reduced to one wheel per axle, its tires linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bicycle {
    /// Mass, kg.
    pub mass: f64,
    /// Yaw inertia, kg m².
    pub yaw_inertia: f64,
    /// Centre of gravity to front axle, m.
    pub a: f64,
    /// Centre of gravity to rear axle, m.
    pub b: f64,
    /// Cornering stiffness of the front axle (both wheels), N/rad.
    pub front: f64,
    /// Cornering stiffness of the rear axle (both wheels), N/rad.
    pub rear: f64,
}

impl Bicycle {
    /// ẋ = A x + B δ for x = (v_y, r), at forward speed `speed` (m/s, not zero).
    pub fn dynamics(&self, speed: f64) -> (Matrix2<f64>, Vector2<f64>) {
        let Self { mass, yaw_inertia, a, b, front, rear } = *self;
        let coupling = a * front - b * rear;
        let state = Matrix2::new(
            -(front + rear) / (mass * speed),
            -speed - coupling / (mass * speed),
            -coupling / (yaw_inertia * speed),
            -(a * a * front + b * b * rear) / (yaw_inertia * speed),
        );
        (state, Vector2::new(front / mass, a * front / yaw_inertia))
    }

    /// Lateral acceleration at the centre of gravity, a_y = v̇_y + v_x r = h·x + d δ: gives (h, d).
    pub fn lateral_acceleration(&self, speed: f64) -> (Vector2<f64>, f64) {
        let (state, input) = self.dynamics(speed);
        (Vector2::new(state[(0, 0)], state[(0, 1)] + speed), input[0])
    }

    /// Steady-state yaw rate per road wheel angle, 1/s.
    pub fn yaw_rate_gain(&self, speed: f64) -> f64 {
        let wheelbase = self.a + self.b;
        let understeer =
            self.mass * (self.b * self.rear - self.a * self.front) / (wheelbase * self.front * self.rear);
        speed / (wheelbase + understeer * speed * speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAR: Bicycle =
        Bicycle { mass: 1700.0, yaw_inertia: 2500.0, a: 1.2, b: 1.6, front: 9e4, rear: 1.1e5 };

    #[test]
    fn the_steady_state_of_the_dynamics_is_the_yaw_rate_gain() {
        let (a, b) = CAR.dynamics(20.0);
        let steady = -a.try_inverse().unwrap() * b;
        assert!((steady[1] - CAR.yaw_rate_gain(20.0)).abs() < 1e-12);
        let (h, d) = CAR.lateral_acceleration(20.0);
        assert!((h.dot(&steady) + d - 20.0 * steady[1]).abs() < 1e-9, "v̇_y = 0 in the steady state");
    }
}
