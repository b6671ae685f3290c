//! Slips as inputs, from measured wheel speeds (thesis 5.3.2 and 5.26).
//!
//! A driven wheel is compared with the undriven one of its side, whose speed the curve carries over to it.
//! What remains at zero force is no slip but a difference of the wheels' radii: it is the offset of a line
//! through slip over traction, and taken away. What is left is smoothed (noise that is cut off on one side
//! only would push the car) and clipped to what a driven tire can have: from zero up to where it saturates.
//! Stretches where the wheels hold the car back have slips below zero, and are left out with the braked
//! ones.

use super::record::Record;
use super::smooth::{centred_mean, centred_slope, median};
use physics::estimate::Car;
use physics::model::{DrivenAxle, GRAVITY, Vehicle};
use physics::{Quantity, Wheel};

/// Slips and accelerations are averaged over this time, s.
const OVER_S: f64 = 0.3;
/// Traction / weight below which a driven wheel holds the car back.
const HOLDS_BACK: f64 = -0.02;
/// Sharper curves than this say nothing of the offset, m/s².
const STRAIGHT_MPS2: f64 = 1.0;
/// How uncertain a stiffness that is said to be known may still be, for the offset.
const LEAST_RELATIVE_STD: f64 = 0.2;
/// Scatter of a slip about its line, before anything is known of it.
const SCATTER: f64 = 1e-3;

/// Fills [`super::Row::slip`]. Returns the offsets it took away, for each driven wheel; `None` where there is
/// no undriven wheel to compare with.
pub(super) fn fill(record: &mut Record, vehicle: &Vehicle) -> Option<[f64; 4]> {
    if vehicle.driven_axle == DrivenAxle::All {
        return None;
    }
    let car = Car::new(vehicle);
    let half = (0.5 * OVER_S / record.period_s).round().max(1.0) as usize;
    let traction = traction(record, vehicle, &car, half);
    let mut offsets = [0.0; 4];
    let mut slips: [Vec<f64>; 4] = Default::default();
    for wheel in Wheel::ALL.into_iter().filter(|wheel| vehicle.driven_axle.drives(*wheel)) {
        let raw: Vec<f64> = record.rows.iter().map(|row| raw_slip(row, wheel, &car)).collect();
        let smooth = centred_mean(&raw, half);
        let usable = |place: &usize| {
            let row = &record.rows[*place];
            !row.braking
                && row.rolling_speed(car.radius) > super::record::SLOWEST_MPS
                && (row.lateral_acceleration.is_nan() || row.lateral_acceleration.abs() < STRAIGHT_MPS2)
        };
        // Neighbours share their means: one of each window is enough.
        let places = (half..record.rows.len()).step_by(2 * half + 1).filter(usable);
        let points: Vec<(f64, f64)> = places.map(|place| (traction[place], smooth[place])).collect();
        let offset = intercept(&points, vehicle);
        let top = saturation(vehicle, wheel);
        slips[wheel as usize] = smooth.iter().map(|slip| (slip - offset).clamp(0.0, top)).collect();
        offsets[wheel as usize] = offset;
    }
    for (place, row) in record.rows.iter_mut().enumerate() {
        for wheel in Wheel::ALL {
            let i = wheel as usize;
            row.slip[i] = slips[i].get(place).copied().unwrap_or(0.0);
        }
        row.braking |= traction[place] < HOLDS_BACK || row.slip.iter().any(|slip| slip.is_nan());
        // The noise of the slips is in the simulated acceleration, and in its derivative by the stiffness:
        // fitting it would make every tire too soft. The outputs are the thesis's: speed, yaw rate, a_y.
        row.longitudinal_acceleration = f64::NAN;
    }
    Some(offsets)
}

/// A driven wheel's speed beside that of the undriven one of its side, carried over through the curve.
fn raw_slip(row: &super::Row, wheel: Wheel, car: &Car) -> f64 {
    let or_zero = |value: f64| if value.is_finite() { value } else { 0.0 };
    let (yaw_rate, across) = (or_zero(row.yaw_rate), or_zero(row.lateral_acceleration));
    let angle = or_zero(row.steering) / car.steering_ratio;
    let reference = wheel.same_side();
    let measured = car.radius * row.wheel_speed[reference as usize];
    let vy = car.steady_lateral_velocity(measured, yaw_rate, across);
    let vx = car.forward_speed(reference, measured, vy, yaw_rate, angle);
    let rolling = car.wheel_plane_speed(wheel, vx, vy, yaw_rate, angle);
    if rolling > 1.0 { car.radius * row.wheel_speed[wheel as usize] / rolling - 1.0 } else { f64::NAN }
}

/// Force of the driven wheels / weight of the car, from the undriven wheels' acceleration.
fn traction(record: &Record, vehicle: &Vehicle, car: &Car, half: usize) -> Vec<f64> {
    let speed: Vec<f64> = record.rows.iter().map(|row| row.undriven_speed(vehicle)).collect();
    let rate = centred_slope(&speed, half, record.period_s);
    let mass = car.mass + 2.0 * car.wheel_inertia / (car.radius * car.radius);
    let force = |(v, rate): (&f64, &f64)| {
        (mass * rate + car.drag * v * v) / (car.mass * GRAVITY) + car.rolling_resistance
    };
    speed.iter().zip(&rate).map(force).collect()
}

/// Slip at zero traction: of a line whose slope is the table's compliance, as far as that is known, and the
/// points' own beyond. Points far off the line (kerbs, gear changes) do not count the second time.
fn intercept(points: &[(f64, f64)], vehicle: &Vehicle) -> f64 {
    let driven = if vehicle.driven_axle == DrivenAxle::All { 4.0 } else { 2.0 };
    let stiffness = vehicle.longitudinal_stiffness;
    let prior = 4.0 / driven / stiffness.value;
    let prior_std = prior * (stiffness.std / stiffness.value).max(LEAST_RELATIVE_STD);
    let mut points: Vec<(f64, f64)> = points.iter().copied().filter(|(x, y)| (x + y).is_finite()).collect();
    if points.is_empty() {
        return 0.0;
    }
    let mut offset = 0.0;
    let mut scatter = SCATTER;
    for _ in 0..3 {
        let count = points.len() as f64;
        let mean_x = points.iter().map(|p| p.0).sum::<f64>() / count;
        let mean_y = points.iter().map(|p| p.1).sum::<f64>() / count;
        let weight = (scatter / prior_std).powi(2);
        let spread = weight + points.iter().map(|p| (p.0 - mean_x).powi(2)).sum::<f64>();
        let common = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum::<f64>();
        let slope = (common + weight * prior) / spread;
        offset = mean_y - slope * mean_x;
        let off = |p: &(f64, f64)| (p.1 - offset - slope * p.0).abs();
        let mut off_all: Vec<f64> = points.iter().map(off).collect();
        // 1.48: the standard deviation of normal numbers whose absolute values have this median.
        scatter = 1.48 * median(&mut off_all).unwrap_or(SCATTER).max(1e-6);
        points.retain(|p| off(p) < 4.0 * scatter);
        if points.is_empty() {
            break;
        }
    }
    offset
}

/// The slip at which the softest tire that the table allows saturates.
fn saturation(vehicle: &Vehicle, wheel: Wheel) -> f64 {
    let stiffness = vehicle.longitudinal_stiffness;
    let softest = (stiffness.value - 2.0 * stiffness.std).max(0.25 * stiffness.value);
    let load = vehicle.static_wheel_load(wheel.is_front()) / (0.25 * vehicle.mass() * GRAVITY);
    vehicle.friction.value * load / softest
}

/// Are there wheels to compare with?
pub(super) fn can_be_had(vehicle: &Vehicle, has: impl Fn(Quantity) -> bool) -> bool {
    vehicle.driven_axle != DrivenAxle::All
        && Wheel::ALL.into_iter().all(|wheel| has(Quantity::wheel_speed(wheel)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::model::scenario::thesis::SIM1;
    use physics::model::simulate::SimulatedDrive;
    use physics::model::{Scenario, Uncertain};

    /// Sim1's first minute with its left front wheel 1 % smaller than the table says.
    fn record(offset: f64) -> (Record, Vehicle) {
        let text = SIM1.replace("duration_s = 200.0", "duration_s = 60.0").replace("0.1\n", "0.01\n");
        let scenario = Scenario::parse(&text).unwrap();
        let driven = SimulatedDrive::simulate(&scenario, 3).unwrap();
        let mut record = Record::new("sim1", &driven.samples, &driven.sensors);
        for row in &mut record.rows {
            row.wheel_speed[0] *= 1.0 + offset;
        }
        let mut vehicle = scenario.vehicle;
        vehicle.longitudinal_stiffness = Uncertain { value: 35.0, std: 20.0 };
        (record, vehicle)
    }

    #[test]
    fn radius_differences_are_no_slip() {
        let (mut record, vehicle) = record(0.01);
        let offsets = fill(&mut record, &vehicle).unwrap();
        assert!((offsets[0] - 0.01).abs() < 4e-4 && offsets[1].abs() < 4e-4, "{offsets:?}");
        // The slip of half the drive torque on one of two driven wheels of stiffness 50.
        let mut misses = Vec::new();
        for row in record.rows.iter().filter(|row| !row.braking) {
            assert_eq!(row.slip[2..], [0.0, 0.0]);
            let force = 0.5 * row.drive_torque / 0.31;
            misses.push(row.slip[0] - force / (50.0 * 1700.0 * GRAVITY / 4.0));
        }
        let count = misses.len() as f64;
        let mean = misses.iter().sum::<f64>() / count;
        let rms = (misses.iter().map(|m| m * m).sum::<f64>() / count).sqrt();
        assert!(count > 3000.0 && mean.abs() < 4e-4 && rms < 1.5e-3, "{count} {mean} {rms}");
    }

    #[test]
    fn nothing_is_clipped_away_below_saturation_and_nothing_is_left_above() {
        let (mut record, vehicle) = record(0.0);
        record.rows[2000].wheel_speed[0] *= 40.0;
        fill(&mut record, &vehicle).unwrap();
        let top = saturation(&vehicle, Wheel::Fl);
        assert!((top - 1.0 / 8.75).abs() < 1e-9, "{top}");
        let slips = record.rows.iter().map(|row| row.slip[0]);
        assert!(slips.clone().all(|slip| (0.0..=top).contains(&slip)));
        assert!(slips.fold(0.0, f64::max) == top);
    }

    #[test]
    fn with_all_wheels_driven_there_is_nothing_to_compare_with() {
        let (mut record, mut vehicle) = record(0.0);
        vehicle.driven_axle = DrivenAxle::All;
        assert_eq!(fill(&mut record, &vehicle), None);
        assert!(!can_be_had(&vehicle, |_| true));
    }
}
