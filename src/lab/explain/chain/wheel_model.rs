//! How the four wheel speeds must differ in curves and under drive and brake forces, for every way in
//! which their channels may have been mixed up.

use super::regression::{FREE, Fit, Prior, Row, fit, inflation};
use super::relations::rows;
use super::series::Series;
use physics::model::{DrivenAxle, GRAVITY};
use physics::{Quantity, Wheel};

/// Which channel is taken for which wheel.
pub(super) type Order = [Wheel; 4];

/// As configured.
pub(super) const AS_LABELLED: Order = Wheel::ALL;

/// Differences of wheel speeds, relative to their mean, smoothed: front right − left, rear right − left,
/// front − rear.
struct Contrasts([Vec<f64>; 3]);

impl Contrasts {
    fn new(series: &Series, order: Order) -> Self {
        let wheel = |place: usize, row: usize| series.raw(Quantity::wheel_speed(order[place]))[row];
        let relative = |of: fn([f64; 4]) -> f64| {
            series.smoothed(|row| {
                let speeds: [f64; 4] = std::array::from_fn(|place| wheel(place, row));
                let mean = 0.25 * speeds.iter().sum::<f64>();
                // At standstill there is nothing to be relative to.
                if mean.abs() < 1e-3 { 0.0 } else { of(speeds) / mean }
            })
        };
        Self([
            relative(|[fl, fr, _, _]| fr - fl),
            relative(|[_, _, rl, rr]| rr - rl),
            relative(|[fl, fr, rl, rr]| 0.5 * (fl + fr - rl - rr)),
        ])
    }
}

/// The three contrasts fitted: last coefficients are what is constant, the radii.
#[derive(Clone, Copy, Debug)]
pub(super) struct WheelFit {
    /// [slope against yaw rate, zero of the yaw rate, constant] of the front and of the rear axle.
    pub(super) axles: [Fit<3>; 2],
    /// [longer path of the front, drive slip, brake slip, constant].
    pub(super) along: Fit<4>,
}

/// One contrast's part in the likelihood.
pub(super) struct Residuals {
    /// Squares, by block.
    pub(super) blocks: Vec<(usize, f64)>,
    /// Variance times how many rows say the same.
    pub(super) variance: f64,
}

/// Fits the model to the wheels in a given order. `turn` puts the yaw rate's scale right.
pub(super) fn model(series: &Series, order: Order, turn: f64) -> Option<(WheelFit, [Residuals; 3])> {
    let contrasts = Contrasts::new(series, order);
    let vehicle = &series.vehicle;
    let tracks = [vehicle.track_front_m.value, vehicle.track_rear_m.value];
    let axle = |index: usize| {
        // The slope against the track's is one, or the wheels are not where they are said to be.
        let track = tracks[index];
        let rows = rows(
            series,
            &contrasts.0[index],
            0.0,
            |_| true,
            |row| {
                let v = series.v[row];
                [track * turn * series.r[row] / v, track / v, 1.0]
            },
        );
        let rows = weighted(series, rows);
        let priors = [(1.0, 0.1), (0.0, 0.01), FREE];
        let fit = constrained(&rows, priors, &[(0.5, 2.0)])?;
        Some((fit, residuals(&rows, fit.value)))
    };
    let (front, front_residuals) = axle(0)?;
    let (rear, rear_residuals) = axle(1)?;
    let (along, along_residuals) = along(series, &contrasts.0[2], turn)?;
    Some((WheelFit { axles: [front, rear], along }, [front_residuals, rear_residuals, along_residuals]))
}

/// Front against rear: the front wheels' path is longer in tight curves, driven wheels turn faster under
/// drive torque, and front wheels brake more.
fn along(series: &Series, contrast: &[f64], turn: f64) -> Option<(Fit<4>, Residuals)> {
    let vehicle = &series.vehicle;
    let slip = 1.0 / vehicle.longitudinal_stiffness.value;
    let (front, _) = series.kappa(true);
    let (rear, _) = series.kappa(false);
    let path = |row: usize| {
        let (v, r) = (series.v[row], turn * series.r[row]);
        let ay = v * r;
        // Seen from the front axle: direction of motion, and the angle the wheels are turned by.
        let direction = vehicle.wheelbase_m.value * r / v - rear * ay;
        let steer = direction + front * ay;
        steer * direction - 0.5 * steer * steer + 0.5 * (rear * ay).powi(2)
    };
    let driven = match vehicle.driven_axle {
        DrivenAxle::Front => 1.0,
        DrivenAxle::Rear => -1.0,
        DrivenAxle::All => 0.0,
    };
    let rows = rows(
        series,
        contrast,
        0.0,
        |_| true,
        |row| {
            let a = series.v_dot[row] / GRAVITY;
            [path(row), driven * a.max(0.0), a.min(0.0), 1.0]
        },
    );
    let rows = weighted(series, rows);
    // What no car can do is not fitted.
    let ranges = [(0.3, 1.7), (0.3 * slip, 8.0 * slip), (0.0, 4.0 * slip)];
    let priors = [(1.0, 0.3), (2.0 * slip, 2.0 * slip), (slip, slip), FREE];
    let fit = constrained(&rows, priors, &ranges)?;
    Some((fit, residuals(&rows, fit.value)))
}

/// A fit whose first coefficients stay within what a car can do: those beyond are held at the bound.
fn constrained<const K: usize>(
    rows: &[Row<K>],
    mut priors: [Prior; K],
    ranges: &[(f64, f64)],
) -> Option<Fit<K>> {
    let free = fit(rows, priors)?;
    let mut held = false;
    for ((prior, value), (low, high)) in priors.iter_mut().zip(free.value).zip(ranges) {
        if !(*low..=*high).contains(&value) {
            *prior = (value.clamp(*low, *high), 1e-6);
            held = true;
        }
    }
    if held { fit(rows, priors) } else { Some(free) }
}

/// Relative differences are noisier the slower the car is.
fn weighted<const K: usize>(series: &Series, mut rows: Vec<Row<K>>) -> Vec<Row<K>> {
    let stride = (0.04 / series.dt).round().max(1.0) as usize;
    for row in &mut rows {
        let weight = 0.1 * series.v[row.place * stride];
        row.y *= weight;
        row.x.iter_mut().for_each(|x| *x *= weight);
    }
    rows
}

fn residuals<const K: usize>(rows: &[Row<K>], theta: [f64; K]) -> Residuals {
    let error = |row: &Row<K>| row.y - row.x.iter().zip(theta).map(|(x, t)| x * t).sum::<f64>();
    let errors: Vec<(usize, f64)> = rows.iter().map(|row| (row.place, error(row))).collect();
    let mut blocks: Vec<(usize, f64)> = Vec::new();
    for (row, (_, error)) in rows.iter().zip(&errors) {
        match blocks.last_mut() {
            Some((block, sum)) if *block == row.block => *sum += error * error,
            _ => blocks.push((row.block, error * error)),
        }
    }
    let variance = errors.iter().map(|(_, e)| e * e).sum::<f64>() / errors.len().max(1) as f64;
    Residuals { blocks, variance: (variance * inflation(&errors)).max(1e-18) }
}
