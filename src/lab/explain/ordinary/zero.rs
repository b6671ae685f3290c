//! A gyroscope's zero, which it reads while the car stands. Where a drive turns to one side only, nothing else tells it from
//! the steering's.

use super::grid::{STEP_S, resampled};

/// Slower than this the car stands, m/s. Physical: less than one of a wheel's 48 teeth a second.
const STANDS_MPS: f64 = 0.04;

/// It is looked at in means over so many grid points, at least so many of them. Statistical.
const SECOND_POINTS: usize = 100;
const LEAST_SECONDS: usize = 3;

/// It wanders by so much in a minute, rad/s rms, in more time by more, as the root of that. Tuned by 25 real drives of six cars
/// (`the_real_recordings_tell_what_is_wrong_with_them`): none has more than 0.0012 over all its stops.
const WANDERS: f64 = 0.002;
const WANDERS_IN_S: f64 = 60.0;

/// By so much a zero moves while so many seconds are recorded, rad/s rms.
pub fn zero_wanders(recorded_s: f64) -> f64 {
    WANDERS * (recorded_s / WANDERS_IN_S).max(1.0).sqrt()
}

/// What is read at standstill, rad/s, and by how much the zero may differ from that while the car drives. None where it does
/// not stand. The speed is on a grid that begins at 0 s.
pub fn standing(yaw_rate: &[(f64, f64)], speed: &[f64]) -> Option<(f64, f64)> {
    let yaw_rate = resampled(yaw_rate, 0.0, speed.len());
    let seconds = yaw_rate.chunks_exact(SECOND_POINTS).zip(speed.chunks_exact(SECOND_POINTS));
    let standing = seconds.filter(|(_, speed)| speed.iter().all(|speed| speed.abs() < STANDS_MPS));
    let means: Vec<f64> = standing
        .map(|(yaw_rate, _)| yaw_rate.iter().sum::<f64>() / SECOND_POINTS as f64)
        .filter(|mean| mean.is_finite())
        .collect();
    if means.len() < LEAST_SECONDS {
        return None;
    }
    let count = means.len() as f64;
    let zero = means.iter().sum::<f64>() / count;
    let square = means.iter().map(|mean| (mean - zero).powi(2)).sum::<f64>() / (count - 1.0);
    Some((zero, square.sqrt().hypot(zero_wanders(speed.len() as f64 * STEP_S))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It stands for 10 s, drives for 40 and stands again, the gyroscope's zero being this.
    fn drive(zero: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
        let stands = |t: f64| !(10.0..50.0).contains(&t);
        let times: Vec<f64> = (0..6000).map(|i| f64::from(i) * STEP_S).collect();
        let speed: Vec<f64> = times.iter().map(|t| if stands(*t) { 0.0 } else { 8.0 }).collect();
        let turning = |t: f64| if stands(t) { 0.0 } else { 0.4 };
        let yaw_rate: Vec<(f64, f64)> = times.iter().map(|t| (*t, turning(*t) + zero(*t))).collect();
        standing(&yaw_rate, &speed)
    }

    #[test]
    fn a_standing_gyroscope_reads_its_zero() {
        let (zero, std) = drive(|_| 0.013).unwrap();
        assert!((zero - 0.013).abs() < 1e-9 && (std - 0.002).abs() < 1e-6, "{zero} {std}");
    }

    #[test]
    fn a_zero_that_differs_between_stops_is_not_known() {
        let (zero, std) = drive(|t| if t < 30.0 { 0.0 } else { 0.04 }).unwrap();
        assert!((zero - 0.02).abs() < 1e-9 && std > 0.02, "{zero} {std}");
    }

    #[test]
    fn a_car_that_does_not_stand_tells_nothing() {
        let yaw_rate: Vec<(f64, f64)> = (0..3000).map(|i| (f64::from(i) * STEP_S, 0.01)).collect();
        assert_eq!(standing(&yaw_rate, &vec![3.0; 3000]), None);
        assert_eq!(standing(&[], &vec![0.0; 3000]), None);
    }
}
