//! What each channel reads when it should read zero.

use super::regression::{FREE, Fit, Prior, fit, student};
use super::relations::{LOADED_RADIUS, Link, Relation, rows};
use super::report::{AuditFinding, ChainReport, Confidence, Offset};
use super::series::Series;
use super::standing::Standing;
use super::tuning::TUNING;
use physics::Quantity;

/// Offsets beyond these are no ordinary sensor's, SI, and whether a road could do the same.
fn extraordinary(quantity: Quantity) -> (f64, Option<&'static str>) {
    match quantity {
        Quantity::YawRate => (0.03, None),
        Quantity::LateralAcceleration => (0.5, Some("road_bank, or the sensor is not level")),
        Quantity::LongitudinalAcceleration => (0.6, Some("road_grade, or the sensor is not level")),
        _ => (0.2, Some("wheel_alignment")),
    }
}

/// What was taken before counts in.
fn add(
    report: &mut ChainReport,
    (series, quantity): (&Series, Quantity),
    value: f64,
    std: f64,
    blocks: usize,
    from: &'static str,
) {
    let value = value + series.zero(quantity);
    if !(value.is_finite() && std.is_finite()) {
        return;
    }
    let repair = format!("take {value:.4} from its offset (offset = {:.4} if there is none)", -value);
    let (bound, physics) = extraordinary(quantity);
    let physics = physics.filter(|_| value.abs() < TUNING.beyond_roads * bound);
    let t = value / std;
    let known = report.findings.iter().any(|f| f.effect == "sensor_bias" && f.channel == quantity.name());
    if value.abs() > bound && t.abs() > student(blocks) && (value.abs() - bound) > std && !known {
        report.findings.push(AuditFinding {
            effect: "sensor_bias",
            channel: quantity.name().to_owned(),
            value: Some(value),
            std: Some(std),
            t,
            evidence: format!("{value:+.4} ± {std:.4} {} {from}", quantity.unit()),
            confidence: if physics.is_none() { Confidence::Certain } else { Confidence::Likely },
            repair: repair.clone(),
            or: physics.map(str::to_owned).into_iter().collect(),
        });
    }
    report.offsets.push(Offset { channel: quantity.name(), value, std, from, repair });
}

/// Zeros of yaw rate sensors that are known to this, rad/s, are worth taking out.
const TAKEN_OUT: f64 = 0.005;

/// Takes out the zeros of yaw rate and lateral acceleration: whatever they are, scales and delays are the same then. They are
/// in products with the speed, so that no constant makes up for them.
pub(super) fn take_zeros(series: &mut Series) {
    let yaw = Standing::of(series).map(|standing| standing.zero()).or_else(|| {
        let axles = [
            (Quantity::WheelSpeedRl, Quantity::WheelSpeedRr, series.vehicle.track_rear_m.value),
            (Quantity::WheelSpeedFl, Quantity::WheelSpeedFr, series.vehicle.track_front_m.value),
        ];
        let zeros = axles.into_iter().filter_map(|(left, right, track)| {
            let fit = turning(series, (left, right, track), 0.0, FREE)?;
            fit.is_significant(0).then(|| (-fit.value[1] / fit.value[0], fit.std[1] / fit.value[0].abs()))
        });
        zeros.min_by(|a, b| a.1.total_cmp(&b.1))
    });
    if let Some((zero, _)) = yaw.filter(|(zero, std)| zero.is_finite() && *std < TAKEN_OUT) {
        series.take_zero(Quantity::YawRate, zero);
        series.refresh();
    }
    if let Some(fit) = lateral(series, 0.0, (0.0, TAKEN_OUT)).filter(|fit| fit.value[3].is_finite()) {
        series.take_zero(Quantity::LateralAcceleration, fit.value[3]);
    }
    if let Some(fit) = steering(series, 0.0, (0.0, TAKEN_OUT)).filter(|fit| fit.value[4].is_finite()) {
        series.take_zero(Quantity::SteeringWheelAngle, fit.value[4] * steering_scale(series));
    }
}

/// From δ v / L, per speed, to the steering wheel's angle, rad.
fn steering_scale(series: &Series) -> f64 {
    series.vehicle.steering_ratio.value * series.vehicle.wheelbase_m.value
}

/// So well a zero of the yaw rate is known at best, rad/s: it wanders. Physical.
const SETTLED: f64 = 1e-3;

/// The yaw rate while the car stands, and its standard deviation: nothing could be clearer.
pub(super) fn at_standstill(series: &Series, report: &mut ChainReport) -> Option<(f64, f64)> {
    let standing = Standing::of(series)?;
    let (mean, std) = standing.zero();
    // A zero that moves has a mean, which is no error of its own.
    let moves = report.drift.as_ref().map_or(0.0, |course| course.rms);
    let seconds = standing.count().max(10);
    add(report, (series, Quantity::YawRate), mean, std.hypot(moves), seconds, "at standstill");
    Some((mean, std))
}

/// All offsets.
pub(super) fn offsets(series: &Series, delays: &[Link], report: &mut ChainReport) {
    let standing = at_standstill(series, report);
    let delay = |relation: Relation| {
        delays.iter().find(|link| link.relation == relation).map_or(0.0, |link| link.delay)
    };
    let yaw = yaw_rate(series, delay(Relation::RearWheels));
    // What the wheels say is their own error, too; standing still has none.
    if let Some(fit) = yaw.as_ref().filter(|_| standing.is_none()) {
        add(
            report,
            (series, Quantity::YawRate),
            -fit.value[1],
            fit.std[1],
            fit.blocks,
            "against the rear wheels",
        );
    }
    let by_wheels = yaw.map_or((0.0, 0.02), |fit| (-fit.value[1], fit.std[1]));
    let zero = standing.map_or(by_wheels, |(mean, std)| (mean, std.max(SETTLED)));
    if let Some(fit) = lateral(series, delay(Relation::Lateral), zero) {
        let from = "against speed x yaw rate (includes the road's bank)";
        add(report, (series, Quantity::LateralAcceleration), fit.value[3], fit.std[3], fit.blocks, from);
    }
    if let Some(fit) = steering(series, delay(Relation::Steering), zero) {
        let scale = steering_scale(series);
        let (value, std) = (fit.value[4] * scale, fit.std[4] * scale);
        add(report, (series, Quantity::SteeringWheelAngle), value, std, fit.blocks, "against the yaw rate");
    }
    let y = series.smooth(Quantity::LongitudinalAcceleration);
    let level = rows(series, &y, delay(Relation::Longitudinal), |_| true, |row| [1.0, series.v_dot[row]]);
    if let Some(fit) = fit(&level, [FREE, (1.0, 0.1)]) {
        let from = "against the wheels (includes the road's grade)";
        add(report, (series, Quantity::LongitudinalAcceleration), fit.value[0], fit.std[0], fit.blocks, from);
    }
}

/// The rear wheels' difference when the yaw rate reads zero; equal radii within some tenths of a percent. Going round one way
/// at one speed, a zero and a slope look alike: track and radius are known by a tenth at least.
fn yaw_rate(series: &Series, delay: f64) -> Option<Fit<4>> {
    let rear = (Quantity::WheelSpeedRl, Quantity::WheelSpeedRr, series.vehicle.track_rear_m.value);
    turning(series, rear, delay, (1.0, 0.1))
}

/// Radii of an axle's wheels, relative: they differ by so much as a rule …
const RADII_DIFFER: f64 = 0.002;
/// … and by so much where the fit strains against that. Physical: [`TIRES_DIFFER`](super::wheels).
const RADII_DIFFER_MUCH: f64 = 0.03;
/// Strain: so many deviations. Statistical: one of twenty.
const STRAINED: f64 = 2.0;

/// The difference of an axle's wheels against the yaw rate: its slope, with what is thought of it; what it is where the yaw
/// rate reads zero; a share of the speed, which is what radii make that differ; and what the load does to these in curves.
fn turning(
    series: &Series,
    (left, right, track): (Quantity, Quantity, f64),
    delay: f64,
    slope: Prior,
) -> Option<Fit<4>> {
    let (left, right) = (series.raw(left), series.raw(right));
    let to_yaw = series.vehicle.wheel_radius_m.value / track;
    let y = series.smoothed(|row| (right[row] - left[row]) * to_yaw);
    let features = |row: usize| [series.r[row], 1.0, series.v[row], series.v[row] * series.lateral(row)];
    let rows = rows(series, &y, delay, |_| true, features);
    let loaded = (0.0, LOADED_RADIUS / track);
    let with = |differ: f64| fit(&rows, [slope, FREE, (0.0, differ / track), loaded]);
    let usual = with(RADII_DIFFER)?;
    let is_strained = usual.value[2].abs() * track > STRAINED * RADII_DIFFER;
    if is_strained { with(RADII_DIFFER_MUCH) } else { Some(usual) }
}

fn lateral(series: &Series, delay: f64, zero: (f64, f64)) -> Option<Fit<4>> {
    let y = series.smooth(Quantity::LateralAcceleration);
    let rows = rows(
        series,
        &y,
        delay,
        |row| series.vr[row].abs() < 3.0,
        |row| [series.vr[row], series.r_dot[row], series.v[row], 1.0],
    );
    fit(&rows, [FREE, FREE, (-zero.0, zero.1), FREE])
}

/// Only while going nearly straight: there the steering ratio does not matter.
fn steering(series: &Series, delay: f64, zero: (f64, f64)) -> Option<Fit<5>> {
    let to_yaw = 1.0 / steering_scale(series);
    let angle = series.raw(Quantity::SteeringWheelAngle);
    let y = series.smoothed(|row| angle[row] * series.speed(row) * to_yaw);
    let rows = rows(
        series,
        &y,
        delay,
        |row| series.vr[row].abs() < 2.0,
        |row| {
            let (v, r) = (series.v[row], series.r[row]);
            [r, v * v * r, v * series.r_dot[row], 1.0, v]
        },
    );
    fit(&rows, [(1.0, 0.3), (0.0, 0.01), (0.01, 0.01), (-zero.0, zero.1), FREE])
}
