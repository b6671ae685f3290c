//! Numbers of the car that a drive tells before anybody did: the steering ratio, and which axle is driven.

use super::regression::{FREE, fit, student};
use super::relations::{Relation, link, not_braking, rows};
use super::series::{LEAST_MOVING_S, Series};
use physics::model::{DrivenAxle, Uncertain, Vehicle};
use physics::{Quantity, Sample, Wheel};

/// How far steering gears, tires and the wheels' geometry put the ratio off. Tuned: on seven recordings of four cars whose
/// ratio is known it comes out 10 % low to 8 % high (`tests/commands/setup`).
const GEAR: f64 = 0.08;
/// Driven wheels of any car slip more than this and less than that by acceleration, per m/s². Physical: a slip stiffness of
/// 25 to 50 times the load on half of the wheels.
const SLIPS: std::ops::Range<f64> = 0.001..0.02;

/// The steering ratio by yaw rate and speed, in gentle curves; none where they do not tell it. `vehicle` has the wheelbase,
/// and a ratio to begin with. Signs, delays and zeros should be right already.
pub fn steering_ratio(samples: &[Sample], vehicle: &Vehicle) -> Option<Uncertain> {
    let series = Series::new(samples, vehicle).filter(|s| s.moving_seconds() > LEAST_MOVING_S)?;
    let told = link(&series, Relation::Steering);
    let link = told.filter(|link| link.has_scale() && link.gain > 0.0 && link.explained > 0.5)?;
    let value = vehicle.steering_ratio.value * link.gain;
    // A road car's is 9 to 25; what is connected with the road wheels has 1.
    if !(0.8..40.0).contains(&value) {
        return None;
    }
    let base = vehicle.wheelbase_m.std / vehicle.wheelbase_m.value;
    let share = (link.widened() * link.gain_std / link.gain).hypot(base).hypot(GEAR);
    Some(Uncertain { value, std: value * share })
}

/// The driven axle, by how its wheels are faster than the other axle's while the car gains speed; none where all wheels
/// are driven, or nothing tells.
pub fn driven_axle(samples: &[Sample], vehicle: &Vehicle) -> Option<DrivenAxle> {
    // The speed is that of all wheels, so that it does not depend on what is looked for.
    let vehicle = Vehicle { driven_axle: DrivenAxle::All, ..vehicle.clone() };
    let series = Series::new(samples, &vehicle).filter(|s| s.moving_seconds() > LEAST_MOVING_S)?;
    if !Wheel::ALL.into_iter().all(|wheel| series.has(Quantity::wheel_speed(wheel))) {
        return None;
    }
    let speed = |wheel: Wheel| series.raw(Quantity::wheel_speed(wheel));
    let [fl, fr, rl, rr] = Wheel::ALL.map(speed);
    let ahead = series.smoothed(|row| {
        let (front, rear) = (fl[row] + fr[row], rl[row] + rr[row]);
        2.0 * (front - rear) / (front + rear)
    });
    let free = not_braking(&series);
    // Front wheels run on larger circles; tires of both axles are unlike each other, and grow with the speed.
    let rows = rows(
        &series,
        &ahead,
        0.0,
        |row| free[row],
        |row| {
            let curvature = series.r[row] / series.v[row];
            [series.v_dot[row], 1.0, curvature * curvature, series.v[row] * series.v[row]]
        },
    );
    let fit = fit(&rows, [FREE; 4])?;
    let slope = fit.value[0];
    if !SLIPS.contains(&slope.abs()) || fit.t(0).abs() < student(fit.blocks) {
        return None;
    }
    Some(if slope > 0.0 { DrivenAxle::Front } else { DrivenAxle::Rear })
}
