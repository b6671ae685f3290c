use super::*;
use crate::estimate::mapping::Mapping;
use crate::estimates::Estimate;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal, Uniform};

fn pair(slope: f64, mu: f64) -> Pair {
    Pair { slope, slope_std: 1.0, mu, mu_std: 0.02, roughness: None }
}

#[test]
fn the_quadratic_coefficient_is_that_of_the_thesis() {
    // Without errors in the slope and with equal ones in μ: a = Σk²μ/Σk⁴ (6.10).
    let pairs: Vec<_> = [(20.0, 0.05), (50.0, 0.24), (70.0, 0.5), (100.0, 0.99)]
        .map(|(slope, mu)| Pair { slope_std: 0.0, ..pair(slope, mu) })
        .to_vec();
    let top: f64 = pairs.iter().map(|p| p.slope.powi(2) * p.mu).sum();
    let bottom: f64 = pairs.iter().map(|p| p.slope.powi(4)).sum();
    let fit = fit(&pairs, Some(MappingKind::Quadratic)).unwrap();
    assert!((fit.regression.a - top / bottom).abs() < 1e-9 * top / bottom);
}

#[test]
fn a_connection_is_found_and_a_parabola_told_from_a_line() {
    let slopes = [40.0, 45.0, 52.0, 60.0, 71.0, 80.0, 88.0, 95.0];
    let scatter = [0.01, -0.015, 0.005, 0.01, -0.01, 0.012, -0.008, 0.0];
    let make = |f: &dyn Fn(f64) -> f64| -> Vec<Pair> {
        slopes.iter().zip(scatter).map(|(&k, e)| pair(k, f(k) + e)).collect()
    };
    let chosen = Calibration::new(&make(&|k| 0.006 * k + 0.3)).chosen.unwrap();
    assert_eq!(chosen.kind, MappingKind::Linear);
    assert!((chosen.coefficients[0] - 0.006).abs() < 0.001, "{chosen:?}");
    assert_eq!((chosen.slope_range, chosen.pairs), ([40.0, 95.0], 8));
    assert_eq!(chosen.roughness_mps, None);
    let mut smooth = make(&|k| 0.006 * k + 0.3);
    for (i, pair) in smooth.iter_mut().enumerate() {
        pair.roughness = Some(0.01 + 0.002 * i as f64);
    }
    assert_eq!(Calibration::new(&smooth).chosen.unwrap().roughness_mps, Some([0.01, 0.024]));
    assert_eq!(chosen.problem(), None);
    let chosen = Calibration::new(&make(&|k| 1.1e-4 * k * k)).chosen.unwrap();
    assert_eq!(chosen.kind, MappingKind::Quadratic);
    assert_eq!(chosen.problem(), None);
}

#[test]
fn what_the_pairs_do_not_support_is_refused_with_the_reason() {
    let refused = |pairs: &[Pair]| Calibration::new(pairs).chosen.unwrap_err();
    let up = |n: i32| -> Vec<Pair> {
        (0..n).map(|i| pair(40.0 + 8.0 * f64::from(i), 0.4 + 0.06 * f64::from(i))).collect()
    };
    assert!(matches!(refused(&[]), Refusal::TooFew { found: 0, needed: 6 }));
    assert!(matches!(refused(&up(5)), Refusal::TooFew { found: 5, .. }));
    let one_surface: Vec<_> = (0..8).map(|i| pair(90.0 + 0.3 * f64::from(i), 0.9)).collect();
    assert!(matches!(refused(&one_surface), Refusal::NotSpread { .. }));
    let down: Vec<_> = up(8).into_iter().map(|p| Pair { mu: 1.2 - p.mu, ..p }).collect();
    assert!(matches!(refused(&down), Refusal::NegativeSlope { .. }));
    let unconnected: Vec<_> = [0.3, 0.9, 0.5, 0.8, 0.2, 0.7, 0.4, 0.6]
        .iter()
        .enumerate()
        .map(|(i, &mu)| pair(20.0 + 5.0 * i as f64, mu))
        .collect();
    assert!(matches!(refused(&unconnected), Refusal::NoConnection { .. }));
    let mut one_braking: Vec<_> =
        (0..7).map(|i| pair(94.0 + 0.3 * f64::from(i), 0.9 + 0.01 * f64::from(i % 3))).collect();
    one_braking.push(pair(50.0, 0.5));
    let reason = refused(&one_braking);
    assert!(matches!(reason, Refusal::RestsOnOne { slope, .. } if slope == 50.0), "{reason}");
}

#[test]
fn a_gap_between_the_slopes_is_told() {
    let pairs: Vec<_> = (0..8)
        .map(|i| {
            let gravel = i % 2 == 0;
            pair(if gravel { 50.0 } else { 95.0 } + f64::from(i), if gravel { 0.6 } else { 0.95 })
        })
        .collect();
    let calibration = Calibration::new(&pairs);
    assert!(calibration.chosen.is_ok() && calibration.remarks[0].contains("between slopes 56 and 96"));
}

/// Pairs of surfaces whose friction is `law` of their slope, but for a scatter.
fn surfaces(rng: &mut ChaCha8Rng, n: usize, law: impl Fn(f64) -> f64, scatter: f64) -> Vec<(Pair, f64)> {
    let slopes = Uniform::new(40.0, 100.0).unwrap();
    let (scatter, mu_error) = (Normal::new(0.0, scatter).unwrap(), Normal::new(0.0, 0.02).unwrap());
    let slope_error = Normal::new(0.0, 3.0).unwrap();
    (0..n)
        .map(|_| {
            let k = slopes.sample(rng);
            let mu = law(k) + scatter.sample(rng) + mu_error.sample(rng);
            let pair = Pair { slope_std: 3.0, ..pair(k + slope_error.sample(rng), mu) };
            (pair, k)
        })
        .collect()
}

#[test]
fn the_interval_covers_what_the_next_braking_measures() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let (mut inside, mut asked) = (0.0, 0.0);
    for _ in 0..400 {
        let rows = surfaces(&mut rng, 13, |k| 0.006 * k + 0.3, 0.05);
        let pairs: Vec<_> = rows.iter().map(|(pair, _)| *pair).collect();
        let fit = fit(&pairs[..12], Some(MappingKind::Linear)).unwrap();
        let mapping = Mapping::new(&fit.config(&pairs[..12]).unwrap()).unwrap();
        let next = pairs[12];
        let slope = Estimate { value: next.slope, std: next.slope_std, age_s: 0.0 };
        let (low, high) = range(&pairs[..12]);
        if (low..=high).contains(&next.slope) {
            let mapped = mapping.at(slope).unwrap();
            asked += 1.0;
            inside += f64::from(u8::from((mapped.low..=mapped.high).contains(&next.mu)));
        }
    }
    let coverage = inside / asked;
    assert!(asked > 250.0 && (0.92..=0.98).contains(&coverage), "{coverage} of {asked}");
}

#[test]
fn the_slope_is_not_diluted_by_the_errors_of_the_regressor() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mean = (0..200)
        .map(|_| {
            let pairs: Vec<_> = surfaces(&mut rng, 12, |k| 0.006 * k + 0.3, 0.0)
                .into_iter()
                // Errors as large as half of the spread: ordinary least squares loses a fifth.
                .map(|(pair, k)| Pair { slope: k + 3.0 * (pair.slope - k), slope_std: 9.0, ..pair })
                .collect();
            fit(&pairs, Some(MappingKind::Linear)).unwrap().regression.a
        })
        .sum::<f64>()
        / 200.0;
    assert!((mean / 0.006 - 1.0).abs() < 0.05, "{mean}");
}

#[test]
fn unconnected_pairs_are_hardly_ever_mapped() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mapped = (0..1000)
        .filter(|_| {
            let pairs: Vec<_> =
                surfaces(&mut rng, 10, |_| 0.6, 0.2).into_iter().map(|(pair, _)| pair).collect();
            Calibration::new(&pairs).chosen.is_ok()
        })
        .count();
    // Half of the significance, as falling lines are refused, too.
    assert!(mapped <= 12, "{mapped} of 1000");
}
