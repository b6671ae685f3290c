//! Does the steering wheel move at all, and do the tires come near their limit?
//!
//! It is an input, and inputs are taken at their word: going straight on, their noise would be taken for
//! steering that the car does not follow, and the tires for soft ones.

use super::parameter::Parameter;
use super::record::{Record, Row};
use super::segment::Segment;
use super::smooth::{centred_mean, centred_slope};
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

/// Why a friction is not told, however sure the search is of it: where little of it was used, its number is what the assumed
/// shape of the tire's curve makes of the small forces. `used` is what the drive has used of 1, as a friction.
pub fn far_from_limit(friction: f64, used: f64) -> Option<String> {
    (used < NEAR_THE_LIMIT * friction).then(|| {
        format!(
            "the tires are far from their limit: only {used:.2} was used, less than {:.0} % of it; the road gives at least that",
            100.0 * NEAR_THE_LIMIT
        )
    })
}

/// How much of a friction of 1 is in use: across by speed × yaw rate or by what the accelerometer feels, m/s², whichever says less
/// (a bank is in the one, roll in the other; one that is not a number says nothing), along by the change of speed, m/s².
pub fn friction_in_use(turning: f64, felt: f64, gained: f64) -> f64 {
    turning.abs().min(felt.abs()).hypot(gained) / GRAVITY
}

/// What all but the rest of a share of the values stay below, not-a-numbers left out.
pub fn hardly_exceeded(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    let mut all: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    all.get((share * all.len() as f64) as usize).copied()
}

/// The friction that was used in what is fitted to, but for the hardest moments. That the
/// driven axle does so alone is not counted: how its force depends on its slip is what the search takes the friction from.
pub(super) fn used_friction(records: &[Record], segments: &[Segment], vehicle: &Vehicle) -> Option<f64> {
    let mut all: Vec<f64> = Vec::new();
    for (number, record) in records.iter().enumerate() {
        let half = (0.5 * OVER_S / record.period_s).round().max(1.0) as usize;
        let smooth = |of: &dyn Fn(&Row) -> f64| {
            let raw: Vec<f64> = record.rows.iter().map(of).collect();
            centred_mean(&raw, half)
        };
        let speed = smooth(&|row| row.speed(vehicle));
        let yaw_rate = smooth(&|row| row.yaw_rate);
        let felt = smooth(&|row| row.lateral_acceleration);
        let gained = centred_slope(&speed, half, record.period_s);
        let own = || segments.iter().filter(|segment| segment.record == number);
        let is_fitted = |row: &Row| {
            own().any(|it| (it.t..it.t + it.measured.len() as f64 * it.period_s).contains(&row.t))
        };
        for (i, _) in record.rows.iter().enumerate().filter(|(_, row)| is_fitted(row)) {
            let along = if gained[i].is_finite() { gained[i] } else { 0.0 };
            all.push(friction_in_use(speed[i] * yaw_rate[i], felt[i], along));
        }
    }
    hardly_exceeded(all.into_iter(), 1.0 - NOW_AND_THEN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::model::Scenario;
    use physics::model::scenario::thesis::SIM1;
    use physics::model::simulate::SimulatedDrive;

    #[test]
    fn a_friction_of_which_little_is_used_is_not_told() {
        assert!(far_from_limit(0.73, 0.41).unwrap().contains("only 0.41"));
        assert_eq!(far_from_limit(1.04, 0.98), None);
    }

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
