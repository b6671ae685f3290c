//! Braking that the bus does not tell of.
//!
//! Brake forces are not in the equations where neither pressure nor pedal is on the bus: a car that slows
//! down more than drive torque, drag and rolling resistance explain is taken for braking, and that stretch
//! is left out (thesis 5.3.2).

use super::record::Record;
use super::smooth::{centred_mean, centred_slope, median};
use physics::Quantity;
use physics::estimate::Car;
use physics::model::{GRAVITY, Vehicle};

/// Unexplained deceleration that counts as braking, m/s²: with an accelerometer, which feels no grade,
/// and with the wheels' acceleration, which contains it.
const UNEXPLAINED: [f64; 2] = [0.4, 0.8];
/// … and more by this share of the lateral acceleration.
const IN_CURVES: f64 = 0.1;
/// Drag of an engine without fuel, m/s², where there is no torque that tells of it.
const ENGINE_DRAG: f64 = 0.6;
/// Brakes come on before and go off after they are noticed by this much, s.
const AROUND_S: f64 = 0.4;
/// Accelerations are looked at over this time, s.
const OVER_S: f64 = 0.4;

/// Does the bus tell itself?
pub(super) fn is_told(record: &Record) -> bool {
    let told = [Quantity::BrakeActive, Quantity::BrakePressure, Quantity::BrakeTorque];
    told.into_iter().any(|quantity| record.sensors.has(quantity))
}

/// Marks rows as braked.
pub(super) fn recognize(record: &mut Record, vehicle: &Vehicle) {
    let unexplained = unexplained_deceleration(record, vehicle);
    let around = (AROUND_S / record.period_s).round() as usize;
    let count = record.rows.len();
    for (place, (deceleration, tolerance)) in unexplained.iter().enumerate() {
        if deceleration > tolerance {
            let to = (place + around + 1).min(count);
            for row in &mut record.rows[place.saturating_sub(around)..to] {
                row.braking = true;
            }
        }
    }
}

/// For each row deceleration that nothing explains, and how much of it is still none, m/s².
fn unexplained_deceleration(record: &Record, vehicle: &Vehicle) -> Vec<(f64, f64)> {
    let car = Car::new(vehicle);
    let half = (0.5 * OVER_S / record.period_s).round().max(1.0) as usize;
    let speed: Vec<f64> = record.rows.iter().map(|row| row.speed(vehicle)).collect();
    let by_wheels = centred_slope(&speed, half, record.period_s);
    let felt: Vec<f64> = record.rows.iter().map(|row| row.longitudinal_acceleration).collect();
    let felt = centred_mean(&felt, half);
    let torque: Vec<f64> = record.rows.iter().map(|row| row.drive_torque).collect();
    let torque = centred_mean(&torque, half);
    // All four wheels turn with the car.
    let mass = car.mass + 4.0 * car.wheel_inertia / (car.radius * car.radius);
    let across: Vec<f64> = record.rows.iter().map(|row| row.lateral_acceleration).collect();
    let across = centred_mean(&across, half);
    // Drag, rolling resistance, and the steered wheels' lateral force, part of which points backwards.
    let resisted = |place: usize| {
        let v = speed[place];
        let angle = record.rows[place].steering / car.steering_ratio;
        let curve = across[place] * car.b / (car.a + car.b) * angle.sin();
        let curve = if curve.is_finite() { curve } else { 0.0 };
        car.drag * v * v / mass + car.rolling_resistance * GRAVITY + curve
    };
    // An accelerometer that is mounted at an angle, or a slope of the road it is not: what it feels more
    // than the wheels in the median is its offset.
    let mut difference: Vec<f64> = felt.iter().zip(&by_wheels).map(|(a, b)| a - b).collect();
    difference.retain(|value| value.is_finite());
    let offset = median(&mut difference).unwrap_or(0.0);
    let row = |place: usize| {
        let (acceleration, tolerance) = match felt[place] - offset {
            felt if felt.is_finite() => (felt, UNEXPLAINED[0]),
            _ => (by_wheels[place], UNEXPLAINED[1]),
        };
        // Sideslip and the change of load are not accounted for.
        let curve = IN_CURVES * across[place].abs();
        let tolerance = tolerance + if curve.is_finite() { curve } else { 0.0 };
        let driven = car.drive_torque_ratio * torque[place] / (car.radius * mass);
        if driven.is_finite() {
            (driven - resisted(place) - acceleration, tolerance)
        } else {
            (-resisted(place) - acceleration, ENGINE_DRAG)
        }
    };
    (0..record.rows.len()).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::model::Vehicle;
    use physics::{Micros, Sample, Sensors};

    /// Ten seconds: driving at 300 N m, then from 4 to 6 s braked at 2 m/s² with the torque gone.
    fn record(with_torque: bool, told: bool) -> Record {
        let vehicle = Vehicle::thesis();
        let radius = vehicle.wheel_radius_m.value;
        let mass = 1700.0 + 4.0 * 2.65 / (radius * radius);
        let mut sensors = Sensors::default();
        sensors.add(Quantity::WheelSpeedRl, Some(0.05));
        if told {
            sensors.add(Quantity::BrakeActive, None);
        }
        let mut v = 15.0;
        let mut samples = Vec::new();
        for step in 0..1000_i64 {
            let braked = (400..600).contains(&step);
            let torque = if braked { 0.0 } else { 300.0 };
            v += 0.01 * if braked { -2.0 } else { torque / radius / mass - 0.5 * v * v / 1700.0 };
            let mut sample = Sample::empty(Micros(10_000 * step), 0.01);
            for quantity in [
                Quantity::WheelSpeedFl,
                Quantity::WheelSpeedFr,
                Quantity::WheelSpeedRl,
                Quantity::WheelSpeedRr,
            ] {
                sample.set(quantity, v / radius);
            }
            if with_torque {
                sample.set(Quantity::DriveTorque, torque);
            }
            samples.push(sample);
        }
        Record::new("test", &samples, &sensors)
    }

    #[test]
    fn a_car_that_slows_down_too_much_brakes() {
        for with_torque in [true, false] {
            let mut record = record(with_torque, false);
            assert!(!is_told(&record));
            recognize(&mut record, &Vehicle::thesis());
            let braked = |at: usize| record.rows[at].braking;
            assert!((420..580).all(braked), "{with_torque}");
            assert!(!(0..340).any(braked) && !(660..1000).any(braked), "{with_torque}");
        }
    }

    #[test]
    fn a_bus_that_tells_is_believed() {
        assert!(is_told(&record(true, true)));
    }
}
