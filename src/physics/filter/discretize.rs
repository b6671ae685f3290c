//! Exact zero-order-hold discretization (methods.md §6; thesis 2.3).

use nalgebra::{Matrix2, Matrix3, SMatrix};

use super::small::times;

/// Discretizes ẋ = A x + B u, u held over `step` seconds: gives F = exp(A T) and Γ = ∫ exp(A t) dt,
/// so that x⁺ = F x + Γ B u; with a nonlinear f and A its Jacobian, x⁺ = x + Γ f(x).
///
/// F and Γ are the blocks of the augmented exponential `exp([A I; 0 0] T) = [F Γ; 0 I]`, summed and
/// doubled together at the size of A; A need not be invertible.
pub fn zero_order_hold<const N: usize>(
    a: &SMatrix<f64, N, N>,
    step: f64,
) -> (SMatrix<f64, N, N>, SMatrix<f64, N, N>) {
    let norm = (0..N).map(|i| a.row(i).iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    let (step, doublings) = halved(step, norm, 0.25);
    let scaled = a * step;
    let mut term = SMatrix::<f64, N, N>::identity();
    let mut transition = term;
    let mut integral = term;
    for k in 1..TERMS + 1 {
        term = times(&term, &scaled) * SHARES[k];
        transition += term;
        integral += term * SHARES[k + 1];
    }
    integral *= step;
    for _ in 0..doublings {
        integral += times(&transition, &integral);
        transition = times(&transition, &transition);
    }
    (transition, integral)
}

/// The same for two states: by Cayley and Hamilton, every power of A is a multiple of A and one of the identity,
/// and so are both results. Γ/T = Σ (A T)ᵏ/(k+1)! is summed by Horner's rule, and F = 1 + A Γ.
pub fn zero_order_hold_plane(a: &Matrix2<f64>, step: f64) -> (Matrix2<f64>, Matrix2<f64>) {
    let determinant = |a: &Matrix2<f64>| a.m11 * a.m22 - a.m12 * a.m21;
    // No eigenvalue is larger, and the powers grow with these alone.
    let half = 0.5 * a.trace().abs();
    let (step, doublings) = halved(step, half + (half * half + determinant(a).abs()).sqrt(), 0.25);
    let scaled = a * step;
    let (trace, determinant) = (scaled.trace(), determinant(&scaled));
    // Multiples of the identity and of A.
    let mut integral = [1.0, 0.0];
    for share in SHARES[2..TERMS + 2].iter().rev() {
        // What does not wait for the terms before is reckoned meanwhile.
        let (of_trace, of_determinant) = (share * trace, share * determinant);
        integral = [1.0 - of_determinant * integral[1], share * integral[0] + of_trace * integral[1]];
    }
    let mut transition = [1.0 - determinant * integral[1], integral[0] + trace * integral[1]];
    let product = |a: [f64; 2], b: [f64; 2]| {
        let square = a[1] * b[1];
        [a[0] * b[0] - determinant * square, a[0] * b[1] + a[1] * b[0] + trace * square]
    };
    for _ in 0..doublings {
        let further = product(transition, integral);
        integral = [integral[0] + further[0], integral[1] + further[1]];
        transition = product(transition, transition);
    }
    let matrix = |[identity, of_a]: [f64; 2]| scaled * of_a + Matrix2::identity() * identity;
    (matrix(transition), matrix(integral) * step)
}

/// The same for three states, likewise: every power of A is made of A², A and the identity.
pub fn zero_order_hold_space(a: &Matrix3<f64>, step: f64) -> (Matrix3<f64>, Matrix3<f64>) {
    // Terms are cheap here, and doublings are not: below a norm of one, eighteen leave less than 1e-16.
    const TERMS: usize = 18;
    let norm = (0..3).map(|i| a[(i, 0)].abs() + a[(i, 1)].abs() + a[(i, 2)].abs()).fold(0.0, f64::max);
    let (step, doublings) = halved(step, norm, 1.0);
    let scaled = a * step;
    let square = times(&scaled, &scaled);
    let (trace, determinant) = (scaled.trace(), scaled.determinant());
    let minors = 0.5 * (trace * trace - square.trace());
    // Multiples of the identity, of A and of A².
    let mut sum = [1.0, 0.0, 0.0];
    for share in SHARES[2..TERMS + 2].iter().rev() {
        let (of_trace, of_minors, of_determinant) = (share * trace, share * minors, share * determinant);
        sum = [
            1.0 + of_determinant * sum[2],
            share * sum[0] - of_minors * sum[2],
            share * sum[1] + of_trace * sum[2],
        ];
    }
    let matrix = |[identity, of_a, of_square]: [f64; 3]| {
        square * of_square + scaled * of_a + Matrix3::from_diagonal_element(identity)
    };
    let mut integral = matrix(sum);
    let by_a = [1.0 + determinant * sum[2], sum[0] - minors * sum[2], sum[1] + trace * sum[2]];
    let mut transition = matrix(by_a);
    integral *= step;
    for _ in 0..doublings {
        integral += times(&transition, &integral);
        transition = times(&transition, &transition);
    }
    (transition, integral)
}

/// Terms of the series: below a norm of 1/4 they leave less than 1e-14.
const TERMS: usize = 10;

/// 1/k: dividing takes longer than all else that a term needs.
const SHARES: [f64; 20] = {
    let mut shares = [f64::INFINITY; 20];
    let mut k = 1;
    while k < shares.len() {
        shares[k] = 1.0 / k as f64;
        k += 1;
    }
    shares
};

/// The step halved until the norm of what happens in it is at most so much, and how often that was.
fn halved(mut step: f64, norm: f64, most: f64) -> (f64, u32) {
    let mut halvings = 0;
    while norm * step.abs() > most && halvings < 200 {
        step *= 0.5;
        halvings += 1;
    }
    (step, halvings)
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
    fn two_states_have_a_way_of_their_own_to_the_same_results() {
        let rotation = matrix![0.0, 0.8; -0.8, 0.0];
        let stiff = matrix![-300.0, 20.0; 1.0, -0.01];
        let shear = matrix![0.0, 1.0; 0.0, 0.0];
        for a in [rotation, stiff, shear, Matrix2::zeros(), matrix![-5.0, -20.0; 3.0, -6.0]] {
            for step in [1e-3, 0.01, 0.3] {
                let (f, gamma) = zero_order_hold(&a, step);
                let plane = zero_order_hold_plane(&a, step);
                assert!(
                    (f - plane.0).norm() < 1e-12 && (gamma - plane.1).norm() < 1e-12 * step,
                    "{a} {step}"
                );
            }
        }
    }

    #[test]
    fn and_so_have_three() {
        let stiff = matrix![-30.0, -1.0, 0.3; 250.0, -0.2, 0.0; -90.0, 0.0, 0.0];
        let jordan = matrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, 0.0];
        for a in [stiff, jordan, Matrix3::zeros(), matrix![-3.0, 1.0, 0.2; 0.5, -40.0, 7.0; 0.1, 0.0, -1.0]] {
            for step in [1e-3, 0.01, 0.3] {
                let (f, gamma) = zero_order_hold(&a, step);
                let space = zero_order_hold_space(&a, step);
                let size = f.norm().max(1.0);
                assert!((f - space.0).norm() < 1e-12 * size, "{a} {step}");
                assert!((gamma - space.1).norm() < 1e-12 * step * size, "{a} {step}");
            }
        }
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
