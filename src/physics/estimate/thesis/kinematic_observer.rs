//! Method 2 of thesis 5.2.2: the lateral velocity of a body that turns, from its accelerations alone.

use nalgebra::{Matrix2, vector};

use crate::filter::Gaussian;
use crate::filter::discretize::zero_order_hold_plane;
use crate::{Quantity, Sensors};

/// Kinematic observer: x = (v_x, v_y), v̇_x = r v_y + a_x, v̇_y = −r v_x + a_y, and v_x measured.
///
/// No tire is in it. v_y is seen only through r v_y: not at all while the car goes straight on. It is
/// as good as its a_x = v̇_x − r v_y, which [`SpeedDerivative`] does not give.
#[derive(Clone, Debug)]
pub struct KinematicObserver {
    state: Option<Gaussian<2>>,
    acceleration_noise: f64,
    speed_noise: f64,
}

impl KinematicObserver {
    /// Noise of the speed from the wheels, m/s. Tuned with the test `thesis_lateral`.
    const SPEED_NOISE: f64 = 0.02;
    /// What is known at the first sample, m/s: v_x as measured, v_y near zero. Tuned with the test
    /// `thesis_lateral`.
    const INITIAL_STD: [f64; 2] = [0.1, 0.5];

    /// The lateral accelerometer's noise counts for both accelerations.
    pub fn new(sensors: &Sensors) -> Self {
        Self {
            state: None,
            acceleration_noise: sensors.noise_std(Quantity::LateralAcceleration),
            speed_noise: Self::SPEED_NOISE,
        }
    }

    /// Forgets the motion.
    pub fn reset(&mut self) {
        self.state = None;
    }

    /// Takes speed (m/s), yaw rate r (rad/s) and the accelerations forward and to the left (m/s²), all
    /// held over the `elapsed_s` since the sample before; returns v_y, m/s.
    pub fn step(&mut self, speed: f64, r: f64, acceleration: [f64; 2], elapsed_s: f64) -> f64 {
        let state = self.state.get_or_insert_with(|| Gaussian::new([speed, 0.0], Self::INITIAL_STD));
        // A rotation by r T: exact for any r, zero included.
        let (transition, integral) = zero_order_hold_plane(&Matrix2::new(0.0, r, -r, 0.0), elapsed_s);
        let noise = self.acceleration_noise * elapsed_s;
        state.predict(&transition, &Matrix2::from_diagonal_element(noise * noise));
        state.mean += integral * vector![acceleration[0], acceleration[1]];
        let residual = speed - state.mean[0];
        state.update_component(0, residual, self.speed_noise * self.speed_noise);
        state.mean[1]
    }
}

/// a_x ≈ Δv_x/T (thesis 5.13). It leaves out −r v_y: with it the observer is told that r v_y = 0.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpeedDerivative {
    previous: Option<f64>,
}

impl SpeedDerivative {
    /// Takes a speed (m/s); returns m/s², zero at the first one.
    pub fn step(&mut self, speed: f64, elapsed_s: f64) -> f64 {
        let previous = self.previous.replace(speed).unwrap_or(speed);
        if elapsed_s > 0.0 { (speed - previous) / elapsed_s } else { 0.0 }
    }

    /// Forgets the speed before.
    pub fn reset(&mut self) {
        self.previous = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A car sliding round a circle: v_x, v_y and r constant, so a = (−r v_y, r v_x).
    fn circle(ax_is_true: bool) -> f64 {
        let (vx, vy, r, step) = (15.0, -0.6, 0.4, 0.01);
        let mut observer = KinematicObserver::new(&Sensors::default());
        let mut derivative = SpeedDerivative::default();
        let mut estimate = 0.0;
        for _ in 0..6000 {
            let ax = if ax_is_true { -r * vy } else { derivative.step(vx, step) };
            estimate = observer.step(vx, r, [ax, r * vx], step);
        }
        estimate - vy
    }

    #[test]
    fn with_the_true_acceleration_it_converges_and_with_the_speeds_derivative_it_finds_no_lateral_velocity() {
        assert!(circle(true).abs() < 0.01, "{}", circle(true));
        assert!((circle(false) - 0.6).abs() < 0.01, "it says v_y = 0: {}", circle(false));
    }
}
