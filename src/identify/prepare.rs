//! Records to segments.

use super::car::PlainCar;
use super::longitudinal_input::LongitudinalInput;
use super::motion::Input;
use super::parameter::{Parameter, Values};
use super::record::Record;
use super::segment::{Segment, measured};
use physics::Quantity;
use physics::model::Vehicle;

/// λ h that a Runge–Kutta step may reach: its error is (λ h)⁵/120 then.
const RATE_TIMES_STEP: f64 = 0.6;
const MOST_SUBSTEPS: u32 = 50;

/// Cuts all records into segments of about `segment_s` seconds; stretches shorter than `least_s` are left out.
pub(super) fn segments(
    records: &[Record],
    vehicle: &Vehicle,
    values: &Values,
    drive: LongitudinalInput,
    segment_s: f64,
    least_s: f64,
) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (number, record) in records.iter().enumerate() {
        let knows_brakes = drive == LongitudinalInput::Torque
            && record.sensors.has(Quantity::BrakePressure)
            && vehicle.brake_torque_per_bar_front_nm.is_some()
            && vehicle.brake_torque_per_bar_rear_nm.is_some();
        for (from, to) in record.stretches(vehicle, least_s, drive, knows_brakes) {
            cut(record, number, (from, to), (vehicle, values, drive, segment_s), &mut segments);
        }
    }
    segments
}

/// Equal segments of about the wanted length.
fn cut(
    record: &Record,
    number: usize,
    (from, to): (usize, usize),
    (vehicle, values, drive, segment_s): (&Vehicle, &Values, LongitudinalInput, f64),
    segments: &mut Vec<Segment>,
) {
    let steps = to - from - 1;
    let wanted = (segment_s / record.period_s).round().max(1.0);
    let pieces = ((steps as f64 / wanted).round() as usize).max(1);
    // That of the car that is to drive, which need not be the table's: with another one a free run would begin too fast.
    let radius = values.get(Parameter::WheelRadius);
    let car = PlainCar::plain(vehicle, drive, values);
    for piece in 0..pieces {
        let begin = from + steps * piece / pieces;
        let end = from + steps * (piece + 1) / pieces;
        let rows = &record.rows[begin..=end];
        let speed = |row: &super::record::Row| row.rolling_speed(radius);
        let slowest = rows.iter().map(speed).fold(f64::INFINITY, f64::min);
        let rate = car.fastest_rate(slowest) * record.period_s;
        let mut inputs: Vec<Input> = rows.iter().map(|row| Input::of(row, drive)).collect();
        for place in 1..inputs.len() {
            let turned = inputs[place].steering - inputs[place - 1].steering;
            inputs[place - 1].steering_rate = turned / record.period_s;
            inputs[place - 1].acceleration =
                (inputs[place].speed - inputs[place - 1].speed) / record.period_s;
        }
        segments.push(Segment {
            inputs,
            measured: rows.iter().map(|row| measured(row, drive, vehicle)).collect(),
            period_s: record.period_s,
            substeps: ((rate / RATE_TIMES_STEP).ceil() as u32).clamp(1, MOST_SUBSTEPS),
            t: rows[0].t,
            record: number,
            continues: piece > 0,
            start: start(rows, radius),
        });
    }
}

/// Speed and yaw rate at the first row: a line through the first tenths of a second, for the noise.
fn start(rows: &[super::record::Row], radius: f64) -> [f64; 3] {
    let some = &rows[..rows.len().min(15)];
    let line = |value: &dyn Fn(&super::record::Row) -> f64| {
        let points = some.iter().enumerate().map(|(x, row)| (x as f64, value(row)));
        let points: Vec<(f64, f64)> = points.filter(|(_, y)| y.is_finite()).collect();
        let count = points.len() as f64;
        if points.is_empty() {
            return 0.0;
        }
        let mean_x = points.iter().map(|p| p.0).sum::<f64>() / count;
        let mean_y = points.iter().map(|p| p.1).sum::<f64>() / count;
        let spread: f64 = points.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
        let slope: f64 = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
        if spread > 0.0 { mean_y - slope / spread * mean_x } else { mean_y }
    };
    [line(&|row| row.rolling_speed(radius)).max(1.0), 0.0, line(&|row| row.yaw_rate)]
}
