//! The filters, with numbers of any size and none.

use gripd::filter::{Alarm, Cusum, Gaussian};
use nalgebra::{SMatrix, SVector};

use super::run::fuzz;
use testing::dice::Dice;

/// Of sensors and cars: six orders of magnitude, either sign. Where one measurement takes more digits off a
/// variance than a number has, what is left of it is rounding, whatever the form of the filter.
fn ordinary(dice: &mut Dice) -> f64 {
    let size = 10f64.powi(dice.below(6) as i32 - 3);
    if dice.once_in(2) { size } else { -size * (dice.below(1000) as f64 / 1000.0) }
}

fn a_filter(seed: &u64) {
    let dice = &mut Dice::new("filter", *seed, 0);
    let mut filter =
        Gaussian::<4>::new([0; 4].map(|_| ordinary(dice)), [0; 4].map(|_| ordinary(dice).abs() + 1e-9));
    for _ in 0..100 {
        match dice.below(3) {
            0 => {
                // A walk, a decay, a coupling; noise that is there.
                let mut transition = SMatrix::<f64, 4, 4>::identity();
                transition[(dice.below(4), dice.below(4))] = dice.below(1000) as f64 / 1000.0;
                let noise = SVector::<f64, 4>::from_fn(|_, _| ordinary(dice).abs() * 1e-6);
                filter.predict(&transition, &SMatrix::from_diagonal(&noise));
            }
            1 => filter.inflate(dice.below(4), ordinary(dice).abs()),
            _ => {
                let h = SVector::<f64, 4>::from_fn(|_, _| ordinary(dice));
                // A measurement may say anything.
                let residual =
                    if dice.once_in(4) { dice.number().clamp(-1e150, 1e150) } else { ordinary(dice) };
                let before = filter;
                let variance = ordinary(dice).abs() + 1e-6;
                filter.update(&h, residual, variance);
                if !residual.is_finite() {
                    assert_eq!(filter, before);
                }
                for i in 0..4 {
                    let (is, was) = (filter.covariance[(i, i)], before.covariance[(i, i)]);
                    assert!(is <= was * (1.0 + 1e-9), "a measurement made a state less sure: {was} {is}");
                }
            }
        }
        let p = filter.covariance;
        assert!(filter.is_sound() && p == p.transpose(), "{filter:?}");
        for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            let bound = filter.std(i) * filter.std(j);
            assert!(p[(i, j)].abs() <= bound * (1.0 + 1e-6) + f64::MIN_POSITIVE, "{i} {j}: {filter:?}");
        }
    }
}

#[test]
fn a_gaussian_stays_symmetric_positive_and_finite() {
    fuzz("filter", 2000, Dice::draw, a_filter);
}

#[test]
fn a_change_detector_takes_any_number() {
    fuzz("cusum", 2000, Dice::draw, |seed| {
        let mut dice = Dice::new("cusum", *seed, 0);
        let mut cusum = Cusum::new(0.5, 5.0);
        for _ in 0..100 {
            let value = dice.number();
            let alarm = cusum.step(value);
            assert!((0.0..=1.0).contains(&cusum.suspicion()), "{}", cusum.suspicion());
            if alarm == Some(Alarm::Up) {
                assert!(value > 0.0);
            }
        }
    });
}
