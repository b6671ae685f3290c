//! The filters over days, and change detection against its theory.

use gripd::filter::discretize::zero_order_hold;
use gripd::filter::{Cusum, Gaussian};
use nalgebra::{SMatrix, matrix, vector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A day at 100 Hz.
const DAY: u64 = 8_640_000;

/// Symmetric to the last bit and positive definite: there is a Cholesky factor of the correlations.
fn assert_sound<const N: usize>(filter: &Gaussian<N>, step: u64) {
    assert!(filter.is_sound(), "step {step}: {filter:?}");
    let scale = |i: usize| filter.covariance[(i, i)].sqrt();
    for i in 0..N {
        assert!(filter.covariance[(i, i)] > 0.0, "step {step}: {filter:?}");
        for j in 0..N {
            assert_eq!(
                filter.covariance[(i, j)].to_bits(),
                filter.covariance[(j, i)].to_bits(),
                "step {step}"
            );
        }
    }
    let correlations =
        nalgebra::DMatrix::from_fn(N, N, |i, j| filter.covariance[(i, j)] / (scale(i) * scale(j)));
    assert!(correlations.cholesky().is_some(), "step {step}: {filter:?}");
}

/// Measured almost exactly, in directions nearly the same, with states 15 orders of magnitude apart, one of
/// which is observable for a second each minute only.
#[test]
fn a_kalman_filter_stays_symmetric_and_positive_for_a_day() {
    let transition = matrix![1.0, 0.01, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, 1.0];
    let noise = SMatrix::<f64, 3, 3>::from_diagonal(&vector![1e-14, 1e-12, 1e-4]);
    let mut filter = Gaussian::<3>::new([0.0; 3], [1e3, 1.0, 1e8]);
    for step in 0..DAY {
        filter.predict(&transition, &noise);
        filter.update(&vector![1.0, 0.0, 0.0], 0.0, 1e-12);
        filter.update(&vector![1.0, 1e-7, 0.0], 0.0, 1e-12);
        if step % 6000 < 100 {
            filter.update(&vector![0.0, 1.0, 1e-8], 0.0, 1e-6);
        }
        if step % 50_000 == 0 || step < 100 {
            assert_sound(&filter, step);
        }
    }
    assert_sound(&filter, DAY);
}

/// An extended filter of a lateral motion with unknown stiffness (thesis 5.21): straight on for most of the
/// time, when the stiffness is not observable and its random walk goes on.
#[test]
fn an_extended_filter_stays_so_too() {
    let (mass, inertia, arm, speed, h) = (1700.0, 1700.0, 1.5, 15.0, 0.01);
    let noise = SMatrix::<f64, 3, 3>::from_diagonal(&vector![1e-8, 1e-9, 1e-4]);
    let mut filter = Gaussian::<3>::new([0.0, 0.0, 8.0], [1.0, 0.1, 5.0]);
    let (mut vy, mut yaw) = (0.0, 0.0);
    let load = mass * 9.81 / 4.0;
    // Derivative of [vy, r, C] at a steering angle.
    let rate = |vy: f64, yaw: f64, c: f64, steer: f64| {
        let stiffness = 4.0 * c * load;
        (
            -stiffness / (mass * speed) * vy - speed * yaw + 0.5 * stiffness / mass * steer,
            -stiffness * arm * arm / (inertia * speed) * yaw + 0.5 * stiffness * arm / inertia * steer,
        )
    };
    // A third of a day, as each step is dear.
    for step in 0..DAY / 3 {
        let t = step as f64 * h;
        let steer = if step % 6000 < 500 { 0.01 * (3.0 * t).sin() } else { 0.0 };
        for _ in 0..10 {
            let (dvy, dyaw) = rate(vy, yaw, 11.5, steer);
            (vy, yaw) = (vy + 0.1 * h * dvy, yaw + 0.1 * h * dyaw);
        }
        let (x0, x1, x2) = (filter.mean[0], filter.mean[1], filter.mean[2]);
        let (fvy, fyaw) = rate(x0, x1, x2, steer);
        let (by_c_vy, by_c_yaw) = {
            let (a, b) = rate(x0, x1, x2 + 1.0, steer);
            (a - fvy, b - fyaw)
        };
        let k = 4.0 * x2 * load;
        let a = matrix![
            -k / (mass * speed), -speed, by_c_vy;
            0.0, -k * arm * arm / (inertia * speed), by_c_yaw;
            0.0, 0.0, 0.0];
        let (f, gamma) = zero_order_hold(&a, h);
        filter.mean += gamma * vector![fvy, fyaw, 0.0];
        filter.predict_covariance(&f, &noise);
        let residual = yaw - filter.mean[1];
        filter.update(&vector![0.0, 1.0, 0.0], residual, 1e-6);
        if step % 20_000 == 0 {
            assert_sound(&filter, step);
        }
    }
    assert_sound(&filter, DAY / 3);
    assert!((filter.mean[2] - 11.5).abs() < 0.5, "{:?}", filter.mean);
}

/// Siegmund's approximation, as documented at [`Cusum`].
#[test]
fn false_alarms_are_as_rare_as_the_theory_says() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for (drift, threshold) in [(0.5, 4.0_f64), (0.25, 8.0)] {
        let mut cusum = Cusum::new(drift, threshold);
        let inputs = 2_000_000;
        let mut alarms = 0;
        for _ in 0..inputs {
            let white: f64 = StandardNormal.sample(&mut random);
            alarms += u32::from(cusum.step(white).is_some());
        }
        let a = 2.0 * drift * (threshold + 1.166);
        let expected = (a.exp() - 1.0 - a) / (4.0 * drift * drift);
        let between = f64::from(inputs) / f64::from(alarms);
        assert!((between / expected - 1.0).abs() < 0.1, "{between} between alarms, expected {expected}");
    }
}
