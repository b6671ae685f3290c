//! Does the steering wheel move at all?
//!
//! It is an input, and inputs are taken at their word: going straight on, their noise would be taken for
//! steering that the car does not follow, and the tires for soft ones.

use super::parameter::Parameter;
use super::record::{Record, Row};
use super::smooth::centred_mean;
use physics::model::{GRAVITY, TireKind, Vehicle};

/// Steering that moves by less than this many times its noise tells nothing of the tires.
const LEAST_RATIO: f64 = 4.0;
/// Steering is averaged over this time, s: nobody steers faster.
const OVER_S: f64 = 0.2;

/// Does a parameter need steering to be seen?
pub(super) const fn needs_steering(parameter: Parameter) -> bool {
    matches!(
        parameter,
        Parameter::LateralFront | Parameter::LateralRear | Parameter::SteeringRatio | Parameter::YawInertia
    )
}

/// Is the steering wheel moved by more than its noise, in any of the records?
pub(super) fn is_steered(records: &[Record]) -> bool {
    records.iter().any(|record| {
        let half = (0.5 * OVER_S / record.period_s).round().max(1.0) as usize;
        let raw: Vec<f64> = record.rows.iter().map(|row| row.steering).collect();
        let smooth = centred_mean(&raw, half);
        let mean_square = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = values
                .filter(|value| value.is_finite())
                .fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
            if count > 0.0 { sum / count } else { 0.0 }
        };
        // Second differences of white noise have six times its variance.
        let noise = mean_square(&mut raw.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2])) / 6.0;
        let whole = centred_mean(&raw, raw.len()).first().copied().unwrap_or(0.0);
        let moved = mean_square(&mut smooth.iter().map(|value| value - whole));
        moved > LEAST_RATIO * LEAST_RATIO * noise / (2 * half + 1) as f64 && moved > 0.0
    })
}

/// Are the tires at their limit now and then? So much of the friction in the vehicle's table …
const NEAR_THE_LIMIT: f64 = 0.7;
/// … for this share of the time.
const NOW_AND_THEN: f64 = 0.01;

/// Do tires slide, in any of the records?
pub(super) fn slides(records: &[Record], vehicle: &Vehicle) -> bool {
    let limit = NEAR_THE_LIMIT * vehicle.friction.value * GRAVITY;
    vehicle.tire != TireKind::Linear
        && records.iter().any(|record| {
            // Without an accelerometer the curve tells.
            let turning = |row: &Row| row.speed(vehicle) * row.yaw_rate;
            let felt = |row: &Row| {
                if row.lateral_acceleration.is_nan() { turning(row) } else { row.lateral_acceleration }
            };
            let near = record.rows.iter().filter(|row| felt(row).abs() > limit).count();
            near as f64 > NOW_AND_THEN * record.rows.len() as f64
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::model::Scenario;
    use physics::model::scenario::thesis::SIM1;
    use physics::model::simulate::SimulatedDrive;

    #[test]
    fn noise_is_no_steering() {
        for (amplitude, steered) in [(0.0, false), (0.01, true)] {
            let text = SIM1
                .replace("duration_s = 200.0", "duration_s = 20.0")
                .replace("\namplitude = 0.1\n", &format!("\namplitude = {amplitude}\n"));
            let driven = SimulatedDrive::simulate(&Scenario::parse(&text).unwrap(), 1).unwrap();
            let record = Record::new("sim1", &driven.samples, &driven.sensors);
            assert_eq!(is_steered(&[record]), steered, "{amplitude}");
        }
    }
}
