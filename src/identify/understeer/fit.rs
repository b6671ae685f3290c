//! The straight line through the steady moments.

use nalgebra::{Matrix3, Vector3};
use thiserror::Error;

use super::Moment;
use physics::model::{GRAVITY, Uncertain};

/// The understeer gradient that a drive tells. Road wheel angle = offset + (1 + ratio_error) L r / v + value a_y (1 + ratio_error).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient {
    /// K, rad per m/s²; positive: the car understeers.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: (f64, f64),
    /// Half the interval, if the steering ratio were known, rad per m/s².
    pub half_with_known_ratio: f64,
    /// Road wheel angle that goes straight on, rad: the steering's offset, as far as no other sensor has one.
    pub offset: f64,
    /// True steering ratio / configured one − 1.
    pub ratio_error: f64,
    /// Moments that it stands on.
    pub moments: usize,
}

/// Why a drive does not tell it.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Untold {
    /// Too few moments.
    #[error("it was nearly steady above 21 km/h for {found} s only; {least} s are needed")]
    TooFew {
        /// How many.
        found: usize,
        /// How many it takes.
        least: usize,
    },
    /// Nearly straight on.
    #[error(
        "its steady lateral accelerations are all within {spread:.1} m/s² of each other; {least:.1} m/s² are needed"
    )]
    TooAlike {
        /// Highest less lowest, m/s².
        spread: f64,
        /// What it takes.
        least: f64,
    },
    /// The interval says little.
    #[error("its 95 % interval would be ± {half_deg_per_g:.1} ° per g")]
    TooWide {
        /// Half the interval.
        half_deg_per_g: f64,
    },
}

/// What is asked of a drive.
struct Tuning {
    /// Up to here tires are nearly linear on a dry road, m/s².
    most_lateral: f64,
    /// Fewest moments.
    least_moments: usize,
    /// Least range of lateral accelerations, m/s².
    least_spread: f64,
    /// Widest half interval, rad per m/s²: 2 ° per g, which lies between a neutral car and one that distinctly understeers.
    most_half: f64,
    /// Residuals beyond so many (robust) standard deviations are left out: kerbs, ruts, single gusts.
    outlier: f64,
}

const TUNING: Tuning = Tuning {
    most_lateral: 4.0,
    least_moments: 12,
    least_spread: 1.5,
    most_half: 2.0 / GRAVITY * std::f64::consts::PI / 180.0,
    outlier: 4.0,
};

/// The gradient, from nearly steady moments. The steering ratio's error is found beside it as far as drives at several
/// speeds tell, and is else as uncertain as it was given (`ratio`: value and standard deviation).
///
/// # Errors
/// If the drive does not tell.
pub fn gradient(moments: &[Moment], wheelbase_m: f64, ratio: Uncertain) -> Result<Gradient, Untold> {
    let mut used: Vec<Moment> =
        moments.iter().filter(|it| it.lateral_acceleration.abs() <= TUNING.most_lateral).copied().collect();
    let enough = |used: &[Moment]| {
        let (found, least) = (used.len(), TUNING.least_moments);
        if found < least { Err(Untold::TooFew { found, least }) } else { Ok(()) }
    };
    enough(&used)?;
    let of = |it: &Moment| it.lateral_acceleration;
    let spread = used.iter().map(of).fold(f64::MIN, f64::max) - used.iter().map(of).fold(f64::MAX, f64::min);
    if spread < TUNING.least_spread {
        return Err(Untold::TooAlike { spread, least: TUNING.least_spread });
    }
    let prior = ratio.std / ratio.value;
    let first = Line::through(&used, wheelbase_m, prior);
    let most = TUNING.outlier * robust_std(&first.residuals);
    let mut residuals = first.residuals.iter();
    used.retain(|_| residuals.next().is_none_or(|residual| residual.abs() <= most));
    enough(&used)?;
    let line = Line::through(&used, wheelbase_m, prior);
    line.gradient(&used)
}

/// A line through all moments by least squares: offset, gradient as the steering wheel has it, error of the ratio.
struct Line {
    numbers: Vector3<f64>,
    /// Of the numbers, if residuals were independent.
    covariance: Matrix3<f64>,
    residuals: Vec<f64>,
}

impl Line {
    /// Of residuals, before there are any: a fifth of a degree, rad².
    const FIRST_VARIANCE: f64 = 1.2e-5;
    /// What says that a number is known: far more than any drive could say, 1/rad².
    const KNOWN: f64 = 1e12;

    fn through(used: &[Moment], wheelbase_m: f64, ratio_std: f64) -> Self {
        let row = |it: &Moment| Vector3::new(1.0, it.lateral_acceleration, wheelbase_m * it.curvature);
        let beyond = |it: &Moment| it.road_angle - wheelbase_m * it.curvature;
        // The prior weighs against the residuals' variance, which is known after a first pass.
        let mut variance = Self::FIRST_VARIANCE;
        let mut line =
            Self { numbers: Vector3::zeros(), covariance: Matrix3::zeros(), residuals: Vec::new() };
        for _ in 0..3 {
            let mut information = Matrix3::zeros();
            let mut sum = Vector3::zeros();
            for it in used {
                information += row(it) * row(it).transpose();
                sum += row(it) * beyond(it);
            }
            information[(2, 2)] +=
                if ratio_std > 0.0 { variance / (ratio_std * ratio_std) } else { Self::KNOWN };
            let inverse = information.try_inverse().unwrap_or_else(|| Matrix3::identity() * f64::INFINITY);
            line.numbers = inverse * sum;
            line.residuals = used.iter().map(|it| beyond(it) - row(it).dot(&line.numbers)).collect();
            let squares: f64 = line.residuals.iter().map(|it| it * it).sum();
            variance = squares / used.len().saturating_sub(3).max(1) as f64;
            line.covariance = inverse * variance;
        }
        line
    }

    fn gradient(&self, used: &[Moment]) -> Result<Gradient, Untold> {
        let ratio = 1.0 + self.numbers[2];
        let value = self.numbers[1] / ratio;
        // d value = d numbers[1] / ratio − value / ratio d numbers[2]
        let by = Vector3::new(0.0, 1.0 / ratio, -value / ratio);
        // Neighbours err alike (road bank, a driver's habit): there are fewer independent ones than there are.
        let alike = self.likeness(used);
        let fewer = (1.0 + alike) / (1.0 - alike);
        let width = student(used.len() as f64 / fewer - 3.0) * fewer.sqrt();
        let half = width * (by.transpose() * self.covariance * by)[(0, 0)].sqrt();
        let covariance = &self.covariance;
        let shared = covariance[(1, 2)] * covariance[(1, 2)] / covariance[(2, 2)];
        let half_with_known_ratio = width * (covariance[(1, 1)] - shared).max(0.0).sqrt() / ratio;
        if !(half.is_finite() && half <= TUNING.most_half) {
            return Err(Untold::TooWide { half_deg_per_g: half.to_degrees() * GRAVITY });
        }
        Ok(Gradient {
            value,
            ci95: (value - half, value + half),
            half_with_known_ratio,
            offset: self.numbers[0],
            ratio_error: self.numbers[2],
            moments: used.len(),
        })
    }

    /// Correlation of the residuals of neighbours.
    fn likeness(&self, used: &[Moment]) -> f64 {
        /// What is further apart is no neighbour, s.
        const NEAR_S: f64 = 3.0;
        let pairs = || {
            self.residuals
                .windows(2)
                .zip(used.windows(2))
                .filter(|(_, moments)| moments[1].t - moments[0].t <= NEAR_S)
                .map(|(residuals, _)| residuals)
        };
        let (count, products): (f64, f64) =
            pairs().fold((0.0, 0.0), |(count, sum), pair| (count + 1.0, sum + pair[0] * pair[1]));
        let squares: f64 =
            self.residuals.iter().map(|it| it * it).sum::<f64>() / self.residuals.len().max(1) as f64;
        if count > 0.0 && squares > 0.0 { (products / count / squares).clamp(0.0, 0.95) } else { 0.0 }
    }
}

/// Half the 95 % interval in standard deviations, of so many degrees of freedom (Student's distribution, to 1 % from three
/// on).
fn student(freedom: f64) -> f64 {
    let freedom = freedom.max(1.0);
    1.96 + 2.37 / freedom + 2.8 / (freedom * freedom) + 5.6 / freedom.powi(3)
}

/// Standard deviation by the median of the absolute residuals.
fn robust_std(residuals: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = residuals.iter().map(|it| it.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    1.4826 * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    const WHEELBASE: f64 = 2.7;

    /// A bicycle with this gradient (rad per m/s²), whose ratio is off by a share, in steady curves at several speeds.
    fn bicycle(gradient: f64, ratio_error: f64, noise: f64, seed: u64) -> Vec<Moment> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let one = |place: u32| {
            let speed = 8.0 + 24.0 * random.random::<f64>();
            let lateral = 7.0 * random.random::<f64>() - 3.5;
            let curvature = lateral / (speed * speed);
            let angle = WHEELBASE * curvature + gradient * lateral;
            let noise = noise * random.sample::<f64, _>(StandardNormal);
            Moment {
                t: f64::from(place),
                lateral_acceleration: lateral,
                road_angle: 0.01 + (1.0 + ratio_error) * angle + noise,
                curvature,
            }
        };
        (0..120).map(one).collect()
    }

    #[test]
    fn a_known_bicycle_is_in_its_interval() {
        let ratio = Uncertain { value: 16.0, std: 0.8 };
        for gradient_true in [0.004, 0.001, -0.0015] {
            let mut inside = 0;
            for seed in 0..100 {
                let found = gradient(&bicycle(gradient_true, 0.04, 0.002, seed), WHEELBASE, ratio).unwrap();
                inside += usize::from((found.ci95.0..found.ci95.1).contains(&gradient_true));
                assert!((found.value - gradient_true).abs() < 0.0006, "{found:?}");
                assert!((found.offset - 0.01).abs() < 0.002 && (found.ratio_error - 0.04).abs() < 0.05);
            }
            assert!((88..=100).contains(&inside), "{inside} of 100 for {gradient_true}");
        }
    }

    #[test]
    fn without_noise_it_is_exact() {
        let found = gradient(&bicycle(0.002, 0.0, 0.0, 1), WHEELBASE, Uncertain::known(16.0)).unwrap();
        assert!((found.value - 0.002).abs() < 1e-9, "{found:?}");
        assert!(found.moments > 100, "{found:?}");
    }

    #[test]
    fn an_uncertain_ratio_makes_the_interval_of_one_speed_wider() {
        let at_one_speed: Vec<Moment> = bicycle(0.002, 0.0, 0.0005, 3)
            .into_iter()
            .map(|it| {
                let curvature = it.lateral_acceleration / 400.0;
                let angle = WHEELBASE * (curvature - it.curvature);
                Moment { curvature, road_angle: it.road_angle + angle, ..it }
            })
            .collect();
        let width = |std: f64| {
            let found = gradient(&at_one_speed, WHEELBASE, Uncertain { value: 16.0, std }).unwrap();
            found.ci95.1 - found.ci95.0
        };
        let found = gradient(&at_one_speed, WHEELBASE, Uncertain { value: 16.0, std: 0.8 }).unwrap();
        assert!((2.0 * found.half_with_known_ratio / width(0.0) - 1.0).abs() < 0.1, "{found:?}");
        assert!(width(0.8) > 2.0 * width(0.0), "{} {}", width(0.8), width(0.0));
    }

    #[test]
    fn a_drive_that_does_not_tell_says_why() {
        let all = bicycle(0.002, 0.0, 0.002, 5);
        let ratio = Uncertain::known(16.0);
        assert!(matches!(gradient(&all[..10], WHEELBASE, ratio), Err(Untold::TooFew { found: 10, .. })));
        let straight: Vec<Moment> = all
            .iter()
            .map(|it| Moment { lateral_acceleration: 0.1 * it.lateral_acceleration, ..*it })
            .collect();
        assert!(matches!(gradient(&straight, WHEELBASE, ratio), Err(Untold::TooAlike { .. })));
        let noisy = bicycle(0.002, 0.0, 0.1, 5);
        let error = gradient(&noisy, WHEELBASE, ratio).unwrap_err();
        assert!(matches!(error, Untold::TooWide { .. }), "{error}");
        assert!(error.to_string().contains("° per g"));
    }
}
