//! Arc tangent, sine and cosine without branches or tables, for several numbers at once.
//!
//! Sums and products only, in a fixed order, and one division: the same bits on every machine, whatever the
//! width of its registers. Within 2 units in the last place of the true values; sine and cosine for angles
//! up to 10⁵ rad.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, SQRT_2};

/// (atan t − t)/t³ by powers of t², for |t| ≤ tan(π/8): the polynomial through the 13 Chebyshev points, whose
/// error is below 10⁻²⁰ t.
const ATAN: [f64; 13] = [
    -0.3333333333333333,
    0.19999999999999993,
    -0.14285714285711515,
    0.11111111110754406,
    -0.0909090906699066,
    0.07692306735321475,
    -0.06666642004996545,
    0.05881925033877732,
    -0.052580394289794816,
    0.04719381457895137,
    -0.04104381417807643,
    0.03063443323901452,
    -0.013916943217800841,
];

/// π/2 in three parts, of which the first two have 33 bits: exact in products with up to 2²⁰.
const HALF_PI: [f64; 3] = [1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21];

/// Added and taken away it leaves the nearest whole number, which its last bits are then, too.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// 1/3!, 1/5!, … with their signs: on ±π/4 the next term is below half a unit in the last place.
const SIN: [f64; 7] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];

/// 1/4!, 1/6!, … with their signs.
const COS: [f64; 7] = [
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// π/2 − its nearest number.
const HALF_PI_REST: f64 = 6.123233995736766e-17;

/// One number after the other: written so that a compiler sees the same done to neighbours.
#[inline(always)]
fn each<const K: usize>(of: impl Fn(usize) -> f64) -> [f64; K] {
    let mut all = [0.0; K];
    for (i, one) in all.iter_mut().enumerate() {
        *one = of(i);
    }
    all
}

/// Horner's scheme.
#[inline(always)]
fn polynomial<const K: usize, const N: usize>(coefficients: &[f64; N], x: &[f64; K]) -> [f64; K] {
    let mut sum = [coefficients[N - 1]; K];
    for coefficient in coefficients[..N - 1].iter().rev() {
        sum = each(|i| sum[i] * x[i] + coefficient);
    }
    sum
}

/// Arc tangents.
#[inline(always)]
pub fn atan<const K: usize>(x: &[f64; K]) -> [f64; K] {
    // tan(π/8) and tan(3π/8): around 0, 1 and ∞ a variable is small.
    const LOW: f64 = SQRT_2 - 1.0;
    const HIGH: f64 = SQRT_2 + 1.0;
    let size: [f64; K] = each(|i| x[i].abs());
    let choose = |low: &[f64; K], middle: &[f64; K], high: &[f64; K]| {
        let lower: [f64; K] = each(|i| if size[i] > LOW { middle[i] } else { low[i] });
        each::<K>(|i| if size[i] > HIGH { high[i] } else { lower[i] })
    };
    let all = |value: f64| [value; K];
    let over = choose(&size, &each(|i| size[i] - 1.0), &all(-1.0));
    let under = choose(&all(1.0), &each(|i| size[i] + 1.0), &size);
    let base = choose(&all(0.0), &all(FRAC_PI_4), &all(FRAC_PI_2));
    // The parts of π/4 and π/2 that do not fit into a number.
    let rest = choose(&all(0.0), &all(0.5 * HALF_PI_REST), &all(HALF_PI_REST));
    let t: [f64; K] = each(|i| over[i] / under[i]);
    let square: [f64; K] = each(|i| t[i] * t[i]);
    let sum = polynomial(&ATAN, &square);
    each(|i| (base[i] + (t[i] + (t[i] * square[i] * sum[i] + rest[i]))).copysign(x[i]))
}

/// Sines and cosines of angles up to 10⁵ rad.
#[inline(always)]
pub fn sin_cos<const K: usize>(x: &[f64; K]) -> ([f64; K], [f64; K]) {
    let shifted: [f64; K] = each(|i| x[i] * FRAC_2_PI + ROUND);
    let quarters: [f64; K] = each(|i| shifted[i] - ROUND);
    let t: [f64; K] =
        each(|i| x[i] - quarters[i] * HALF_PI[0] - quarters[i] * HALF_PI[1] - quarters[i] * HALF_PI[2]);
    let square: [f64; K] = each(|i| t[i] * t[i]);
    let sum = polynomial(&SIN, &square);
    let sin: [f64; K] = each(|i| t[i] + t[i] * square[i] * sum[i]);
    let sum = polynomial(&COS, &square);
    let rough: [f64; K] = each(|i| 1.0 - 0.5 * square[i]);
    // What was lost in the difference comes back.
    let cos: [f64; K] =
        each(|i| rough[i] + ((1.0 - rough[i] - 0.5 * square[i]) + square[i] * square[i] * sum[i]));
    // Bits instead of comparisons: which of them it is, and its sign.
    let mixed = |one: &[f64; K], other: &[f64; K], by: u64| {
        each::<K>(|i| {
            let quarter = shifted[i].to_bits();
            let swap = (quarter & 1).wrapping_neg();
            let bits = (one[i].to_bits() & !swap) | (other[i].to_bits() & swap);
            f64::from_bits(bits ^ ((quarter.wrapping_add(by) & 2) << 62))
        })
    };
    (mixed(&sin, &cos, 0), mixed(&cos, &sin, 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// So many numbers lie between two of the same sign.
    fn apart(one: f64, other: f64) -> u64 {
        one.to_bits().abs_diff(other.to_bits())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn arc_tangents_are_those_of_the_library(x in -3.0..3.0f64, power in -12..12i32) {
            for x in [x, x * 10f64.powi(power)] {
                prop_assert!(apart(atan(&[x])[0], x.atan()) <= 2, "{x}");
            }
        }

        #[test]
        fn sines_and_cosines_are_those_of_the_library(x in -4.0..4.0f64, large in -1e5..1e5f64) {
            for x in [x, large, 1e-6 * x] {
                let ([sin], [cos]) = sin_cos(&[x]);
                let (right_sin, right_cos) = x.sin_cos();
                // Beside a zero of theirs the last places are those of the angle, not of the value.
                let near = |one: f64, right: f64| apart(one, right) <= 2 || (one - right).abs() < 1e-19 * (1.0 + x.abs());
                prop_assert!(near(sin, right_sin) && near(cos, right_cos), "{x}: {sin} {right_sin} {cos} {right_cos}");
            }
        }
    }

    #[test]
    fn signs_and_ends_are_kept() {
        assert_eq!(atan(&[0.0])[0].to_bits(), 0.0f64.to_bits());
        assert_eq!(atan(&[-0.0])[0].to_bits(), (-0.0f64).to_bits());
        let ends = [1.0, -1.0, f64::INFINITY, f64::NEG_INFINITY, 1e-300, 2.0];
        assert_eq!(atan(&ends), ends.map(f64::atan));
        assert!(atan(&[f64::NAN])[0].is_nan());
        assert_eq!(sin_cos(&[0.0]), ([0.0], [1.0]));
    }

    #[test]
    fn neighbours_do_not_matter() {
        let x = [0.3, -7.0, 2.1, 1e3, -0.6, 12.0, 1e-9, -2.5];
        let (sin, cos) = sin_cos(&x);
        for (i, x) in x.iter().enumerate() {
            assert_eq!(atan(&[*x])[0], atan(&[9.0, *x])[1]);
            assert_eq!(sin_cos(&[*x]), ([sin[i]], [cos[i]]));
        }
    }
}
