//! Sensors: from the truth to readings at their own times.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::Reading;
use super::tooth_wheel::ToothWheel;
use crate::model::scenario::{ClockConfig, SensorConfig};
use crate::{Micros, Quantity};

/// The true values of all quantities (with effects: what they leave of them) over the last seconds, one row per integration step.
#[derive(Clone, Debug)]
pub(super) struct History {
    step_s: f64,
    rows: Vec<[f64; Quantity::COUNT]>,
    /// Rows written so far; row n is at n · step.
    count: usize,
}

impl History {
    pub(super) fn new(step_s: f64, seconds: f64) -> Self {
        let rows = (seconds / step_s).ceil() as usize + 4;
        Self { step_s, rows: vec![[0.0; Quantity::COUNT]; rows], count: 0 }
    }

    /// Keeps so many seconds from now on, if it has not kept them already.
    pub(super) fn reach_back(&mut self, seconds: f64) {
        let mut longer = Self::new(self.step_s, seconds + 4.0 * self.step_s);
        if longer.rows.len() <= self.rows.len() {
            return;
        }
        let places = longer.rows.len();
        for index in self.count.saturating_sub(self.rows.len())..self.count {
            longer.rows[index % places] = *self.row(index);
        }
        // What lies before that was not kept: as it was at the oldest row.
        let oldest = *self.row(0);
        for index in self.count.saturating_sub(places)..self.count.saturating_sub(self.rows.len()) {
            longer.rows[index % places] = oldest;
        }
        longer.count = self.count;
        *self = longer;
    }

    pub(super) fn push(&mut self, row: [f64; Quantity::COUNT]) {
        let place = self.count % self.rows.len();
        self.rows[place] = row;
        self.count += 1;
    }

    fn row(&self, index: usize) -> &[f64; Quantity::COUNT] {
        let newest = self.count.saturating_sub(1);
        let oldest = self.count.saturating_sub(self.rows.len());
        &self.rows[index.clamp(oldest, newest) % self.rows.len()]
    }

    /// A quantity at `t`, between rows by a straight line (switches: the earlier row).
    pub(super) fn at(&self, quantity: Quantity, t: f64) -> f64 {
        let place = (t / self.step_s).max(0.0);
        let index = place as usize;
        let share = place - index as f64;
        let from = self.row(index)[quantity as usize];
        if matches!(quantity, Quantity::BrakeActive | Quantity::AbsActive) {
            return from;
        }
        from + share * (self.row(index + 1)[quantity as usize] - from)
    }
}

/// One sensor at work.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    quantity: Quantity,
    config: SensorConfig,
    clock: ClockConfig,
    tooth_wheel: Option<ToothWheel>,
    /// The history has what the tooth wheel says: effects come between.
    is_in_history: bool,
    noise: ChaCha8Rng,
    jitter: ChaCha8Rng,
    /// Readings taken so far.
    count: u64,
}

/// A reading on its way: it is there at `due` of true time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    pub(super) due: Micros,
    pub(super) reading: Reading,
}

impl Sensor {
    /// `jitter` must be alike for sensors whose readings travel together. A tooth wheel comes with whether
    /// the history has what it says.
    pub(super) fn new(
        quantity: Quantity,
        config: SensorConfig,
        clock: ClockConfig,
        tooth_wheel: Option<(ToothWheel, bool)>,
        noise: ChaCha8Rng,
        jitter: ChaCha8Rng,
    ) -> Self {
        let is_in_history = tooth_wheel.as_ref().is_some_and(|(_, is_in_history)| *is_in_history);
        let tooth_wheel = tooth_wheel.map(|(tooth_wheel, _)| tooth_wheel);
        Self { quantity, config, clock, tooth_wheel, is_in_history, noise, jitter, count: 0 }
    }

    /// From now on as late as another one.
    pub(super) fn delayed_as(&mut self, other: &Self) {
        self.config.delay_ms = other.config.delay_ms;
    }

    /// How far it looks back, s.
    pub(super) fn delay_s(&self) -> f64 {
        1e-3 * self.config.delay_ms
    }

    /// What its tooth wheel says at `t`, if it has one.
    pub(super) fn pulses(&self, t: f64) -> Option<(Quantity, f64)> {
        Some((self.quantity, self.tooth_wheel.as_ref()?.speed(t)))
    }

    /// The wheel of this sensor, if it has a tooth wheel, turns by `turned` rad until `t`.
    pub(super) fn turn(&mut self, t: f64, h: f64, wheel_turned: &[f64; 4]) {
        if let (Some(tooth_wheel), Some(wheel)) = (&mut self.tooth_wheel, self.quantity.wheel()) {
            tooth_wheel.turn(t, h, wheel_turned[wheel as usize]);
        }
    }

    /// Takes all readings that are scheduled up to `now`.
    pub(super) fn take(&mut self, now: f64, history: &History, pending: &mut Vec<Pending>) {
        loop {
            let scheduled = 1e-3 * (self.config.phase_ms + self.count as f64 * self.config.period_ms);
            // Half a microsecond: what is scheduled on a step is taken on it.
            if scheduled > now + 0.5e-6 {
                return;
            }
            self.count += 1;
            let late: f64 = StandardNormal.sample(&mut self.jitter);
            let due = scheduled + 1e-3 * self.clock.jitter_std_ms * late.abs();
            let time = Micros::from_seconds(due * (1.0 + 1e-6 * self.clock.skew_ppm));
            let value = self.value(scheduled - 1e-3 * self.config.delay_ms, history);
            if !value.is_finite() {
                continue;
            }
            pending.push(Pending {
                due: Micros::from_seconds(due),
                reading: Reading { time, quantity: self.quantity, value },
            });
        }
    }

    fn value(&mut self, t: f64, history: &History) -> f64 {
        let truth = match &self.tooth_wheel {
            Some(tooth_wheel) if !self.is_in_history => tooth_wheel.speed(t),
            _ => history.at(self.quantity, t),
        };
        let noise: f64 = StandardNormal.sample(&mut self.noise);
        let value = self.config.gain * truth + self.config.offset + self.config.noise_std * noise;
        let quantum = self.config.quantum;
        if quantum > 0.0 { (value / quantum).round() * quantum } else { value }
    }
}
