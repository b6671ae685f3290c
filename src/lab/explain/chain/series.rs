//! The samples as time series, smoothed alike, so that equations between them keep holding.

use physics::model::{DrivenAxle, Vehicle};
use physics::{Quantity, Sample, Wheel};

/// Standard deviation of the Gaussian that everything is smoothed with, s: frequencies of manoeuvres
/// pass, noise does not. Physical: half of the amplitude is left at 1.9 Hz.
const SMOOTHING_S: f64 = 0.1;
/// The kernel reaches so many standard deviations to both sides. Numerical: beyond are 0.3 % of the kernel.
const REACH: f64 = 3.0;
/// Below this speed wheel sensors are coarse and angles ill-defined, m/s. Physical.
const SLOWEST: f64 = 3.0;
/// Where a unit is wrong by a factor the above means nothing: then this share of the usual speed.
/// Tuned, no test on record.
const SLOWEST_SHARE: f64 = 0.3;
/// A car this slow all the time, m/s, whose speed changes by this share at most, is parked: a wrong unit makes speeds small, and
/// does not hold them. Physical: half a wheel's turn in ten seconds.
const PARKED_MPS: f64 = 0.1;
const PARKED_SPREAD: f64 = 0.01;
/// Blocks for jackknife and bootstrap, s: longer than manoeuvres are correlated. Statistical.
const BLOCK_S: f64 = 3.0;
/// Less motion than this is not worth an audit, s. Tuned, no test on record.
pub(super) const LEAST_MOVING_S: f64 = 5.0;

/// All channels on one grid; gaps in time are rows of NaN.
#[derive(Clone, Debug)]
pub(super) struct Series {
    pub(super) vehicle: Vehicle,
    /// Distance of the rows, s.
    pub(super) dt: f64,
    /// When each row was, s, by the samples' clock; a gap's row when it ended.
    times: Vec<f64>,
    raw: Vec<Vec<f64>>,
    /// What was taken from each channel, so that it reads zero where it should.
    zeros: [f64; Quantity::COUNT],
    /// The wheels whose speed is the car's; none: the vehicle's speed is.
    reference: Vec<Wheel>,
    /// Smoothed speed, m/s, of the wheels that are not driven (of all, where all are), or the vehicle's.
    pub(super) v: Vec<f64>,
    pub(super) v_dot: Vec<f64>,
    /// Smoothed yaw rate.
    pub(super) r: Vec<f64>,
    pub(super) r_dot: Vec<f64>,
    /// v times r, smoothed.
    pub(super) vr: Vec<f64>,
    pub(super) vr_dot: Vec<f64>,
    moving: Vec<bool>,
}

impl Series {
    /// `None` if there is nothing in the samples.
    pub(super) fn new(samples: &[Sample], vehicle: &Vehicle) -> Option<Self> {
        let mut steps: Vec<f64> = samples.iter().map(|s| s.elapsed_s).filter(|s| *s > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        let dt = *steps.get(steps.len() / 2)?;
        let mut raw = vec![Vec::new(); Quantity::COUNT];
        let mut times = Vec::new();
        let mut last = None;
        for sample in samples {
            let gap = sample.elapsed_s > 1.5 * dt || last.is_some_and(|last| sample.time <= last);
            for quantity in Quantity::ALL {
                let channel = &mut raw[quantity as usize];
                if gap {
                    channel.push(f64::NAN);
                }
                channel.push(sample.get(quantity).unwrap_or(f64::NAN));
            }
            times.extend(std::iter::repeat_n(sample.time.seconds(), 1 + usize::from(gap)));
            last = Some(sample.time);
        }
        let mut series = Self {
            vehicle: vehicle.clone(),
            dt,
            reference: Vec::new(),
            times,
            raw,
            zeros: [0.0; Quantity::COUNT],
            v: Vec::new(),
            v_dot: Vec::new(),
            r: Vec::new(),
            r_dot: Vec::new(),
            vr: Vec::new(),
            vr_dot: Vec::new(),
            moving: Vec::new(),
        };
        series.reference = series.best_reference();
        series.refresh();
        Some(series)
    }

    /// When a row was, s, by the samples' clock.
    pub(super) fn time(&self, row: usize) -> f64 {
        self.times[row]
    }

    /// Rows.
    pub(super) fn len(&self) -> usize {
        self.raw[0].len()
    }

    /// Length of the drive, s.
    pub(super) fn seconds(&self) -> f64 {
        self.len() as f64 * self.dt
    }

    /// Of which the car moved, s.
    pub(super) fn moving_seconds(&self) -> f64 {
        self.moving.iter().filter(|moving| **moving).count() as f64 * self.dt
    }

    /// Is the car moving fast enough at this row?
    pub(super) fn moves(&self, row: usize) -> bool {
        self.moving[row]
    }

    /// The block a row belongs to.
    pub(super) fn block(&self, row: usize) -> usize {
        (row as f64 * self.dt / BLOCK_S) as usize
    }

    /// A channel as it came.
    pub(super) fn raw(&self, quantity: Quantity) -> &[f64] {
        &self.raw[quantity as usize]
    }

    /// Does the channel have any value?
    pub(super) fn has(&self, quantity: Quantity) -> bool {
        self.raw(quantity).iter().any(|value| value.is_finite())
    }

    /// Multiplies a channel; call [`Self::refresh`] afterwards.
    pub(super) fn scale(&mut self, quantity: Quantity, factor: f64) {
        self.raw[quantity as usize].iter_mut().for_each(|value| *value *= factor);
        self.zeros[quantity as usize] *= factor;
    }

    /// Takes a constant from a channel; call [`Self::refresh`] afterwards.
    pub(super) fn take_zero(&mut self, quantity: Quantity, zero: f64) {
        self.raw[quantity as usize].iter_mut().for_each(|value| *value -= zero);
        self.zeros[quantity as usize] += zero;
    }

    /// Takes what it reads too much at a time, s, from a channel; call [`Self::refresh`] afterwards.
    pub(super) fn take_course(&mut self, quantity: Quantity, too_much: impl Fn(f64) -> f64) {
        for (value, t) in self.raw[quantity as usize].iter_mut().zip(&self.times) {
            *value -= too_much(*t);
        }
    }

    /// The constant that was taken.
    pub(super) fn zero(&self, quantity: Quantity) -> f64 {
        self.zeros[quantity as usize]
    }

    /// Exchanges two channels; call [`Self::refresh`] afterwards.
    pub(super) fn swap(&mut self, one: Quantity, other: Quantity) {
        self.raw.swap(one as usize, other as usize);
        self.zeros.swap(one as usize, other as usize);
    }

    /// A channel, smoothed.
    pub(super) fn smooth(&self, quantity: Quantity) -> Vec<f64> {
        smooth(self.raw(quantity), self.dt)
    }

    /// Any combination of raw values of a row, smoothed.
    pub(super) fn smoothed(&self, of: impl Fn(usize) -> f64) -> Vec<f64> {
        let raw: Vec<f64> = (0..self.len()).map(of).collect();
        smooth(&raw, self.dt)
    }

    /// The derivative of a smoothed series, per second.
    pub(super) fn derivative(&self, smooth: &[f64]) -> Vec<f64> {
        let at = |row: usize| smooth.get(row).copied().unwrap_or(f64::NAN);
        (0..smooth.len())
            .map(|row| (at(row + 1) - row.checked_sub(1).map_or(f64::NAN, at)) / (2.0 * self.dt))
            .collect()
    }

    /// The wheels that roll freely, as far as they are there; else the vehicle's speed (no wheel); else the wheels there
    /// are.
    fn best_reference(&self) -> Vec<Wheel> {
        let driven = self.vehicle.driven_axle;
        let there = |wheel: &Wheel| self.has(Quantity::wheel_speed(*wheel));
        let all: Vec<Wheel> = Wheel::ALL.into_iter().filter(there).collect();
        let free: Vec<Wheel> =
            all.iter().copied().filter(|wheel| driven == DrivenAxle::All || !driven.drives(*wheel)).collect();
        match (free.is_empty(), self.has(Quantity::VehicleSpeed)) {
            (false, _) => free,
            (true, true) => Vec::new(),
            (true, false) => all,
        }
    }

    /// Is the car's speed that of its wheels?
    pub(super) fn is_by_wheels(&self) -> bool {
        !self.reference.is_empty()
    }

    /// Speed of the car, unsmoothed, m/s.
    pub(super) fn speed(&self, row: usize) -> f64 {
        if self.reference.is_empty() {
            return self.raw(Quantity::VehicleSpeed)[row];
        }
        let sum: f64 = self.reference.iter().map(|wheel| self.raw(Quantity::wheel_speed(*wheel))[row]).sum();
        self.vehicle.wheel_radius_m.value * sum / self.reference.len() as f64
    }

    /// Does the car stand, its wheels below this, rad/s?
    pub(super) fn stands(&self, row: usize, below: f64) -> bool {
        let mut wheels =
            Wheel::ALL.into_iter().map(Quantity::wheel_speed).filter(|wheel| self.has(*wheel)).peekable();
        if wheels.peek().is_none() {
            return self.speed(row).abs() < below * self.vehicle.wheel_radius_m.value;
        }
        wheels.all(|wheel| self.raw(wheel)[row].abs() < below)
    }

    /// Takes a channel out; call [`Self::refresh`] afterwards.
    pub(super) fn forget(&mut self, quantity: Quantity) {
        self.raw[quantity as usize].fill(f64::NAN);
    }

    /// Everything derived, anew.
    pub(super) fn refresh(&mut self) {
        let yaw = Quantity::YawRate;
        self.v = self.smoothed(|row| self.speed(row));
        self.v_dot = self.derivative(&self.v);
        self.r = self.smooth(yaw);
        self.r_dot = self.derivative(&self.r);
        self.vr = self.smoothed(|row| self.speed(row) * self.raw(yaw)[row]);
        self.vr_dot = self.derivative(&self.vr);
        let mut speeds: Vec<f64> = self.v.iter().copied().filter(|v| v.is_finite()).collect();
        speeds.sort_by(f64::total_cmp);
        let share = |tenths: usize| speeds.get(speeds.len() * tenths / 10).copied().unwrap_or(0.0);
        let usual = share(9);
        // Some sensors of a car that is parked say that it creeps, always at the same speed.
        let is_parked = usual < PARKED_MPS && usual - share(1) < PARKED_SPREAD * usual;
        let slowest = if is_parked { f64::INFINITY } else { SLOWEST.min(SLOWEST_SHARE * usual).max(1e-3) };
        self.moving = self.v.iter().map(|v| *v > slowest).collect();
    }

    /// The lateral acceleration by the yaw rate alone: v r + v̇y, vy = b r − v κ a_y.
    pub(super) fn lateral(&self, row: usize) -> f64 {
        let (rear, _) = self.kappa(false);
        self.vr[row] + self.vehicle.b() * self.r_dot[row] - rear * self.v[row] * self.vr_dot[row]
    }

    /// Understeer parameter κ = 1/(c g) of an axle with normalized stiffness c, s²/m, and how well it is
    /// known: slip angle per lateral acceleration.
    pub(super) fn kappa(&self, front: bool) -> (f64, f64) {
        let stiffness =
            if front { self.vehicle.lateral_stiffness_front } else { self.vehicle.lateral_stiffness_rear };
        let kappa = 1.0 / (stiffness.value * physics::model::GRAVITY);
        // Nobody knows it better: the surface, the load and the temperature change it.
        let relative = (stiffness.std / stiffness.value).max(0.3);
        (kappa, relative * kappa)
    }
}

/// Convolution with a Gaussian; NaN wherever the kernel meets one.
fn smooth(raw: &[f64], dt: f64) -> Vec<f64> {
    let reach = (REACH * SMOOTHING_S / dt).ceil() as usize;
    let weight = |offset: usize| (-0.5 * (offset as f64 * dt / SMOOTHING_S).powi(2)).exp();
    let mut kernel: Vec<f64> = (0..=2 * reach).map(|i| weight(i.abs_diff(reach))).collect();
    let sum: f64 = kernel.iter().sum();
    kernel.iter_mut().for_each(|w| *w /= sum);
    let mut smooth = vec![f64::NAN; raw.len()];
    for (centre, window) in raw.windows(kernel.len()).enumerate() {
        smooth[centre + reach] = window.iter().zip(&kernel).map(|(value, w)| value * w).sum();
    }
    smooth
}

/// The value of a smoothed series between rows.
pub(super) fn at(series: &[f64], place: f64) -> f64 {
    if place.is_nan() || place < 0.0 {
        return f64::NAN;
    }
    let row = place as usize;
    let share = place - row as f64;
    let value = |row: usize| series.get(row).copied().unwrap_or(f64::NAN);
    if share == 0.0 { value(row) } else { value(row) + share * (value(row + 1) - value(row)) }
}
