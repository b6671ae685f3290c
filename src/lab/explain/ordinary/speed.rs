//! The speed that a free run is driven by.

use physics::model::{DrivenAxle, Vehicle};
use physics::{Quantity, Wheel};

use super::grid::{STEP_S, filled, resampled};
use crate::explain::Recording;

/// Slower driving is not compared, m/s. The yardstick's.
pub const COMPARED_MPS: f64 = 4.0;

/// The car's speed: times, s, and m/s. Empty where nothing tells it.
pub fn speed_of(recording: &Recording, vehicle: &Vehicle) -> Vec<(f64, f64)> {
    let points = (recording.seconds() / STEP_S) as usize + 1;
    let speed = speed(recording, vehicle, points).unwrap_or_default();
    let row = |(i, speed): (usize, &f64)| (i as f64 * STEP_S, *speed);
    speed.iter().enumerate().map(row).filter(|(_, speed)| speed.is_finite()).collect()
}

/// The speed on a grid: of the undriven wheels, else of all there are, else the message's.
pub fn speed(recording: &Recording, vehicle: &Vehicle, points: usize) -> Option<Vec<f64>> {
    let has = |wheel: &Wheel| recording.has(Quantity::wheel_speed(*wheel));
    let wheels: Vec<Wheel> = Wheel::ALL.into_iter().filter(has).collect();
    let free: Vec<Wheel> =
        wheels.iter().copied().filter(|wheel| !vehicle.driven_axle.drives(*wheel)).collect();
    let is_driven = free.is_empty() || vehicle.driven_axle == DrivenAxle::All;
    let chosen = if is_driven { wheels } else { free };
    if chosen.is_empty() {
        let message = &recording.tracks[Quantity::VehicleSpeed as usize];
        return recording.has(Quantity::VehicleSpeed).then(|| filled(resampled(message, 0.0, points)));
    }
    let yaw = resampled(&recording.tracks[Quantity::YawRate as usize], 0.0, points);
    let rolling = chosen.iter().map(|wheel| -> Vec<f64> {
        let track = if wheel.is_front() { vehicle.track_front_m } else { vehicle.track_rear_m };
        // In a left turn the left wheel is slower than the middle.
        let side = if wheel.is_left() { 0.5 } else { -0.5 } * track.value;
        let turning = resampled(&recording.tracks[Quantity::wheel_speed(*wheel) as usize], 0.0, points);
        let of = |(turning, yaw): (f64, &f64)| {
            turning * vehicle.wheel_radius_m.value + side * if yaw.is_finite() { *yaw } else { 0.0 }
        };
        turning.into_iter().zip(&yaw).map(of).collect()
    });
    let rolling: Vec<Vec<f64>> = rolling.collect();
    let mean: Vec<f64> = (0..points)
        .map(|i| rolling.iter().map(|wheel| wheel[i]).sum::<f64>() / rolling.len() as f64)
        .collect();
    if is_driven {
        return Some(filled(mean));
    }
    // Wheels that nothing drives are never too fast; those of a smaller radius always turn faster, and say the same.
    let sizes: Vec<f64> = rolling.iter().map(|wheel| usual_ratio(wheel, &mean)).collect();
    let alike = |i: usize| rolling.iter().zip(&sizes).map(move |(wheel, size)| wheel[i] / size);
    Some(filled((0..points).map(|i| fastest(alike(i), BRAKED_MPS)).collect()))
}

/// The median ratio of two speeds of a moving car; 1 of one that does not move.
fn usual_ratio(speed: &[f64], of: &[f64]) -> f64 {
    let moving = speed.iter().zip(of).filter(|(speed, of)| **of > COMPARED_MPS && speed.is_finite());
    let mut ratios: Vec<f64> = moving.map(|(speed, of)| speed / of).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied().unwrap_or(1.0)
}

/// Undriven wheels that are slower than another one by more hardly count: they slip where they are braked. Tuned by `free_runs`,
/// of 0.3 to 1.2 and none: held-out yaw rate of a wet lap 91.7 % (90.3 without), of a dry one 91.6 (90.9); with 0.3 the dry
/// one's fit ends elsewhere (81.5).
const BRAKED_MPS: f64 = 1.2;

/// The mean of speeds, those that are slower than the fastest by a few of these steps hardly counted.
fn fastest(speeds: impl Iterator<Item = f64> + Clone, step: f64) -> f64 {
    let most = speeds.clone().fold(f64::NEG_INFINITY, f64::max);
    let weights = speeds.clone().map(|speed| ((speed - most) / step).exp());
    let all: f64 = weights.clone().sum();
    speeds.zip(weights).map(|(speed, weight)| speed * weight).sum::<f64>() / all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_that_locks_does_not_brake_the_car() {
        let of = |speeds: [f64; 2]| fastest(speeds.into_iter(), BRAKED_MPS);
        assert!((of([20.0, 20.1]) - 20.05).abs() < 0.01, "wheels that roll: their mean");
        assert!(of([20.0, 2.0]) > 19.99);
        assert!(of([f64::NAN, 10.0]).is_nan());
    }

    #[test]
    fn a_smaller_wheel_is_always_faster_but_where_it_locks() {
        let mean: Vec<f64> = (0..50).map(|i| 5.0 + f64::from(i)).collect();
        let mut smaller: Vec<f64> = mean.iter().map(|mean| 1.02 * mean).collect();
        smaller[40..45].fill(0.0);
        assert!((usual_ratio(&smaller, &mean) - 1.02).abs() < 1e-9);
        assert_eq!(usual_ratio(&[0.0], &[0.0]), 1.0);
    }
}
