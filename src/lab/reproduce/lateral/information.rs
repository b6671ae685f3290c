//! What the sensors can tell at all: of v_y by kinematics, of C_y by the bicycle.

use nalgebra::{Complex, Matrix2, Vector2, matrix, vector};

use physics::filter::discretize::exponential;
use physics::filter::{Observability, Spectrum};
use physics::model::{Bicycle, GRAVITY};

/// Period of the samples, s.
pub(super) const PERIOD_S: f64 = 0.01;

/// The kinematic model's step while the car turns with `r` (rad/s).
fn turn(r: f64) -> Matrix2<f64> {
    exponential(&(matrix![0.0, r; -r, 0.0] * PERIOD_S))
}

/// Observability rank (thesis 2.12) of (v_x, v_y) from v_x at yaw rate `r` (rad/s).
pub(super) fn kinematic_rank(r: f64) -> usize {
    let seen = Observability::<2>::time_invariant(&turn(r), &[(vector![1.0, 0.0], 1.0)]);
    seen.spectrum(&vector![1.0, 1.0]).rank(Spectrum::<2>::ROUNDING)
}

/// Least standard deviation, m/s, of v_y from `duration_s` of speeds with `speed_noise` (m/s), if the
/// accelerations are known exactly: by the Gramian.
pub(super) fn kinematic_std(r: f64, duration_s: f64, speed_noise: f64) -> f64 {
    let mut seen = Observability::<2>::new();
    for _ in 0..(duration_s / PERIOD_S).round() as usize {
        seen.measure(&vector![1.0, 0.0], speed_noise * speed_noise);
        seen.advance(&turn(r));
    }
    seen.spectrum(&vector![1.0, 1.0]).bound(1)
}

/// The thesis's car, or one with its centre of gravity `a` behind the front axle, with C_F = C_R such
/// that the normalized stiffness of the car is `stiffness` (1/rad).
pub(super) fn bicycle(a: f64, stiffness: f64) -> Bicycle {
    let (mass, wheelbase) = (1700.0, 3.0);
    let axle = 0.5 * stiffness * mass * GRAVITY;
    Bicycle { mass, yaw_inertia: 1700.0, a, b: wheelbase - a, front: axle, rear: axle }
}

/// Yaw rate (rad/s) and lateral acceleration (m/s²) per radian of steering at `frequency` (Hz; 0: steady).
fn response(model: &Bicycle, speed: f64, frequency: f64) -> Option<Vector2<Complex<f64>>> {
    let complex = |x: f64| Complex::new(x, 0.0);
    let (a, b) = model.dynamics(speed);
    let (h, d) = model.lateral_acceleration(speed);
    let s = Complex::new(0.0, std::f64::consts::TAU * frequency);
    let inverse = (Matrix2::identity() * s - a.map(complex)).try_inverse()?;
    let state = inverse * b.map(complex);
    let ay = h.map(complex).dot(&state) + complex(d);
    Some(vector![state[1], ay])
}

/// Change of [`response`] per relative change of C_y.
pub(super) fn sensitivity(
    a: f64,
    stiffness: f64,
    speed: f64,
    frequency: f64,
) -> Option<Vector2<Complex<f64>>> {
    let change = 1e-4_f64;
    let at = |factor: f64| response(&bicycle(a, stiffness * factor), speed, frequency);
    let difference = at(change.exp())? - at((-change).exp())?;
    Some(difference / Complex::new(2.0 * change, 0.0))
}

/// Cramér–Rao bound: least relative standard deviation of C_y from `duration_s` of steering sine, the
/// other parameters and the initial state known. `noise`: of yaw rate and lateral acceleration.
pub(super) fn stiffness_std(
    speed: f64,
    (frequency, amplitude): (f64, f64),
    duration_s: f64,
    noise: [f64; 2],
) -> Option<f64> {
    let gains = sensitivity(1.5, super::course::STIFFNESS, speed, frequency)?;
    let per_sample: f64 =
        gains.iter().zip(noise).map(|(gain, std)| 0.5 * (amplitude * gain.norm() / std).powi(2)).sum();
    Some(1.0 / (per_sample * duration_s / PERIOD_S).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_neutral_car_tells_nothing_of_its_stiffness_in_steady_cornering() {
        let neutral = sensitivity(1.5, 11.5, 20.0, 0.0).unwrap();
        assert!(neutral.iter().all(|gain| gain.norm() < 1e-6), "{neutral}");
        let understeering = sensitivity(1.3, 11.5, 20.0, 0.0).unwrap();
        assert!(understeering.iter().all(|gain| gain.norm() > 0.1), "{understeering}");
        let fast = sensitivity(1.5, 11.5, 20.0, 0.5).unwrap();
        assert!(fast.iter().any(|gain| gain.norm() > 0.1), "{fast}");
    }

    /// The bound is what a weighted least-squares fit of a simulated sine has as its covariance.
    #[test]
    fn the_bound_is_the_covariance_of_a_fit() {
        let (speed, frequency, amplitude, noise) = (20.0, 0.5, 0.01, [0.003, 0.07]);
        let seconds = 20.0;
        let outputs = |stiffness: f64| {
            let model = bicycle(1.5, stiffness);
            let (a, b) = model.dynamics(speed);
            let (h, d) = model.lateral_acceleration(speed);
            let (mut x, mut rows) = (Vector2::zeros(), Vec::new());
            let fine = PERIOD_S / 10.0;
            for i in 0..(2.0 * seconds / fine) as usize {
                let angle = amplitude * (std::f64::consts::TAU * frequency * i as f64 * fine).sin();
                if i % 10 == 0 && i as f64 * fine >= seconds {
                    rows.push([x[1], h.dot(&x) + d * angle]);
                }
                x += (a * x + b * angle) * fine;
            }
            rows
        };
        let (up, down) = (outputs(11.5 * 1.001), outputs(11.5 / 1.001));
        let information: f64 = up
            .iter()
            .zip(&down)
            .flat_map(|(up, down)| {
                (0..2).map(|i| ((up[i] - down[i]) / (2.0 * 1.001_f64.ln()) / noise[i]).powi(2))
            })
            .sum();
        let fitted = 1.0 / information.sqrt();
        let bound = stiffness_std(speed, (frequency, amplitude), seconds, noise).unwrap();
        assert!((fitted / bound - 1.0).abs() < 0.02, "{fitted} {bound}");
    }
}
