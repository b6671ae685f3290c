//! Exact zero-order-hold discretization (methods.md §6; thesis 2.3).

use nalgebra::SMatrix;

/// Discretizes ẋ = A x + B u, u held over `step` seconds: gives F = exp(A T) and Γ = ∫ exp(A t) dt,
/// so that x⁺ = F x + Γ B u; with a nonlinear f and A its Jacobian, x⁺ = x + Γ f(x).
///
/// F and Γ are the blocks of the augmented exponential `exp([A I; 0 0] T) = [F Γ; 0 I]`, summed and
/// doubled together at the size of A; A need not be invertible.
pub fn zero_order_hold<const N: usize>(
    a: &SMatrix<f64, N, N>,
    step: f64,
) -> (SMatrix<f64, N, N>, SMatrix<f64, N, N>) {
    let scaled = a * step;
    let doublings = doublings(&scaled);
    let fraction = 0.5_f64.powi(doublings);
    let (scaled, step) = (scaled * fraction, step * fraction);
    let mut term = SMatrix::<f64, N, N>::identity();
    let mut transition = term;
    let mut integral = term;
    for k in 1..=10 {
        term = term * scaled / f64::from(k);
        transition += term;
        integral += term / f64::from(k + 1);
    }
    integral *= step;
    for _ in 0..doublings {
        integral += transition * integral;
        transition *= transition;
    }
    (transition, integral)
}

/// Halvings that bring the norm below 1/4, where ten terms of the series leave less than 1e-14.
fn doublings<const N: usize>(a: &SMatrix<f64, N, N>) -> i32 {
    let norm = (0..N).map(|i| a.row(i).iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    if norm > 0.25 { (norm / 0.25).log2().ceil().min(200.0) as i32 } else { 0 }
}

/// Matrix exponential of `a`.
pub fn exponential<const N: usize>(a: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    zero_order_hold(a, 1.0).0
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{matrix, vector};

    #[test]
    fn a_rotation_becomes_sine_and_cosine() {
        for angle in [1e-6, 0.1, 1.0, 10.0] {
            let rotation = exponential(&matrix![0.0, angle; -angle, 0.0]);
            let exact = matrix![angle.cos(), angle.sin(); -angle.sin(), angle.cos()];
            assert!((rotation - exact).norm() < 1e-12, "{angle}");
        }
    }

    #[test]
    fn both_results_are_blocks_of_the_augmented_exponential() {
        let a = matrix![-3.0, 1.0; 0.5, -40.0];
        let step = 0.05;
        let (transition, integral) = zero_order_hold(&a, step);
        let augmented = exponential(
            &(matrix![
            -3.0, 1.0, 1.0, 0.0;
            0.5, -40.0, 0.0, 1.0;
            0.0, 0.0, 0.0, 0.0;
            0.0, 0.0, 0.0, 0.0]
                * step),
        );
        assert!((augmented.fixed_view::<2, 2>(0, 0) - transition).norm() < 1e-13);
        assert!((augmented.fixed_view::<2, 2>(0, 2) - integral).norm() < 1e-13);
    }

    #[test]
    fn a_double_integrator_needs_no_inverse() {
        let (f, gamma) = zero_order_hold(&matrix![0.0, 1.0; 0.0, 0.0], 0.5);
        assert!((f - matrix![1.0, 0.5; 0.0, 1.0]).norm() < 1e-15);
        assert!((gamma * vector![0.0, 1.0] - vector![0.125, 0.5]).norm() < 1e-15);
    }

    #[test]
    fn a_stiff_decay_stays_a_decay() {
        let (f, gamma) = zero_order_hold(&matrix![-1e4], 0.01);
        assert!(f[(0, 0)].abs() < 1e-30 && (gamma[(0, 0)] * 1e4 - 1.0).abs() < 1e-9);
    }
}
