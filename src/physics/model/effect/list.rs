//! Several effects together, in the order in which they act, and their states one after the other.

use std::ops::Range;

use super::{Acting, Effect, Felt, Now, Readings, Recorded};
use crate::Quantity;

/// Effects, each with the place of its own states among all of them. What is said of one in [`Effect`] is here said of all.
#[derive(Debug, Default)]
pub struct EffectList {
    list: Vec<(Box<dyn Effect>, Range<usize>)>,
}

impl EffectList {
    /// In this order.
    pub fn new(effects: impl IntoIterator<Item = Box<dyn Effect>>) -> Self {
        let mut first = 0;
        let placed = effects.into_iter().map(|effect| {
            let own = first..first + effect.states();
            first = own.end;
            (effect, own)
        });
        Self { list: placed.collect() }
    }

    /// Where each one's states are.
    #[inline]
    pub fn places(&self) -> impl Iterator<Item = Range<usize>> {
        self.list.iter().map(|(_, own)| own.clone())
    }

    /// How many states they have.
    #[inline]
    pub fn states(&self) -> usize {
        self.list.last().map_or(0, |(_, own)| own.end)
    }

    /// Where their states begin.
    #[inline]
    pub fn begin(&self, now: &Now<'_>, states: &mut [f64]) {
        for (effect, own) in &self.list {
            effect.begin(now, &mut states[own.clone()]);
        }
    }

    /// What they change before the tires' forces are known.
    #[inline]
    pub fn act(&self, now: &Now<'_>, states: &[f64], on: &mut Acting) {
        for (effect, own) in &self.list {
            effect.act(now, &states[own.clone()], on);
        }
    }

    /// What they change of the tires' slip angles, rad.
    #[inline]
    pub fn slip_angles(&self, now: &Now<'_>, states: &[f64], angles: &mut [f64; 4]) {
        for (effect, own) in &self.list {
            effect.slip_angles(now, &states[own.clone()], angles);
        }
    }

    /// How their states change, per second.
    #[inline]
    pub fn rates(&self, now: &Now<'_>, felt: &Felt, states: &[f64], rates: &mut [f64]) {
        for (effect, own) in &self.list {
            effect.rates(now, felt, &states[own.clone()], &mut rates[own.clone()]);
        }
    }

    /// The fastest rate of their states at a speed, 1/s.
    #[inline]
    pub fn fastest_rate(&self, vx: f64) -> f64 {
        self.list.iter().map(|(effect, _)| effect.fastest_rate(vx)).fold(0.0, f64::max)
    }

    /// The same of those that are no first-order lags.
    #[inline]
    pub fn fastest_but_lags(&self, vx: f64) -> f64 {
        let others = self.list.iter().filter(|(effect, _)| effect.lag_rate(vx).is_none());
        others.map(|(effect, _)| effect.fastest_rate(vx)).fold(0.0, f64::max)
    }

    /// Do states of any of them follow the steering wheel?
    pub fn follows_steering(&self) -> bool {
        self.list.iter().any(|(effect, _)| effect.follows_steering())
    }

    /// Where each one's states are, with their rate at a speed, 1/s, if they are first-order lags.
    #[inline]
    pub fn lags(&self, vx: f64) -> impl Iterator<Item = (Range<usize>, Option<f64>)> {
        self.list.iter().map(move |(effect, own)| (own.clone(), effect.lag_rate(vx)))
    }

    /// What the sensors make of the truth.
    #[inline]
    pub fn sense(&self, now: &Now<'_>, felt: &Felt, states: &[f64], readings: &mut Readings) {
        for (effect, own) in &self.list {
            effect.sense(now, felt, &states[own.clone()], readings);
        }
    }

    /// From what was recorded to what was: the last thing that happened to a reading is undone first.
    #[inline]
    pub fn undo(&self, t: f64, recorded: &mut Recorded) {
        for (effect, _) in self.list.iter().rev() {
            effect.undo(t, recorded);
        }
    }

    /// Sensors that are late, and how much, s.
    #[inline]
    pub fn delays(&self) -> impl Iterator<Item = (Quantity, f64)> {
        self.list.iter().filter_map(|(effect, _)| effect.delay())
    }
}
