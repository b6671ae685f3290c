//! Roads and sensors as cars have them: what disturbs every drive and does not follow from what the driver does. Nothing of
//! it is to be found. Sizes as in recordings of ordinary cars: an uneven road's side force of some 60 N, coloured noise about
//! as strong as the white one, gyroscopes that wander within their data sheets, an engine's second order, hopping wheels,
//! frames between 10 and 200 Hz, coarse readings, stamps in batches.

use std::f64::consts::TAU;

use super::bus::Timing;
use super::dice::Dice;
use super::hidden::CHANNELS;
use super::physics::{Moment, STEP};
use super::sensors::NOISE;

/// A course in time, one sample a millisecond; nothing where it has none.
#[derive(Clone, Debug, Default)]
pub struct Course(Vec<f64>);

impl Course {
    pub fn at(&self, t: f64) -> f64 {
        let x = (t / STEP).max(0.0);
        let (i, f) = (x as usize, x.fract());
        match (self.0.get(i), self.0.get(i + 1)) {
            (Some(now), Some(next)) => now * (1.0 - f) + next * f,
            _ => 0.0,
        }
    }

    fn of(seconds: f64, value: impl FnMut(f64) -> f64) -> Self {
        let count = (seconds / STEP) as usize + 2;
        Self((0..count).map(|k| k as f64 * STEP).map(value).collect())
    }

    /// Random waves between two frequencies, Hz.
    pub fn waves(seconds: f64, (low, high): (f64, f64), rms: f64, dice: &mut Dice) -> Self {
        const COUNT: usize = 50;
        let waves: [(f64, f64); COUNT] = std::array::from_fn(|_| {
            let frequency = low * (high / low).powf(dice.unit());
            (TAU * frequency, dice.between(0.0, TAU))
        });
        let each = rms * (2.0 / COUNT as f64).sqrt();
        Self::of(seconds, |t| waves.iter().map(|(w, phase)| each * (w * t + phase).sin()).sum())
    }

    /// Noise of first order with that memory, s.
    pub fn wander(seconds: f64, memory: f64, rms: f64, dice: &mut Dice) -> Self {
        let keeps = (-STEP / memory).exp();
        let drives = rms * (1.0 - keeps * keeps).sqrt();
        let mut value = rms * dice.normal();
        Self::of(seconds, |_| {
            value = keeps * value + drives * dice.normal();
            value
        })
    }

    fn and(mut self, other: &Self) -> Self {
        self.0.iter_mut().zip(&other.0).for_each(|(own, other)| *own += other);
        self
    }
}

/// What acts on the car.
#[derive(Clone, Debug)]
pub struct Road {
    /// Side force at the front axle, N; the rear one meets it a wheelbase later.
    pub side: Course,
    /// Force along, N.
    pub along: Course,
    /// What the engine gives beyond what it says, relative.
    pub engine: Course,
    /// What is left of the pedal while gears change.
    pub pedal: Course,
}

impl Road {
    pub fn random(seconds: f64, dice: &mut Dice) -> Self {
        let holes: Vec<(f64, f64)> =
            (0..(seconds / 12.0) as usize).map(|_| (dice.between(0.0, seconds), dice.sign())).collect();
        let hole = |t: f64| -> f64 {
            let bump = |(at, sign): &(f64, f64)| {
                let since = t - at;
                if since < 0.0 { 0.0 } else { sign * (-since / 0.05).exp() * (TAU * 9.0 * since).sin() }
            };
            holes.iter().map(bump).sum()
        };
        let shifts: Vec<f64> =
            (1..(seconds / 20.0) as usize).map(|k| 20.0 * k as f64 + dice.between(-6.0, 6.0)).collect();
        let shifting = |t: f64| shifts.iter().any(|at| (0.0..0.35).contains(&(t - at)));
        // Of two axles together, which hardly move alike.
        let side = dice.between(20.0, 70.0) / 2f64.sqrt();
        let size = dice.between(100.0, 400.0);
        Self {
            side: Course::waves(seconds, (1.0, 12.0), side, dice)
                .and(&Course::of(seconds, |t| size * hole(t))),
            along: Course::waves(seconds, (1.0, 12.0), dice.between(10.0, 50.0), dice)
                .and(&Course::of(seconds, |t| -2.0 * size * hole(t).abs())),
            engine: Course::wander(seconds, 1.0, dice.between(0.0, 0.03), dice),
            pedal: Course::of(seconds, |t| if shifting(t) { 0.0 } else { 1.0 }),
        }
    }
}

/// What the sensors show beside the drive and their white noise.
pub fn colour(moments: &[Moment], seconds: f64, dice: &mut Dice) -> [Course; CHANNELS] {
    let strength = dice.between(0.3, 1.2);
    let hop = dice.between(11.0, 13.0);
    let engine_size = dice.between(0.02, 0.12);
    let order = engine_order(moments);
    let mut own = |channel: usize| -> Course {
        let white = NOISE[channel];
        let coloured = Course::wander(seconds, 0.15, strength * white, dice);
        let hopping = |rms: f64, dice: &mut Dice| Course::waves(seconds, (hop, hop + 1.5), rms, dice);
        match channel {
            0..=3 => Course::wander(seconds, 0.15, 0.3 * strength * white, dice)
                .and(&hopping(0.7 * strength * white, dice)),
            // 0.03 °/s within minutes.
            4 => coloured.and(&Course::wander(seconds, 100.0, 0.0005, dice)),
            5 | 6 => {
                let shaking = Course::of(seconds, |t| {
                    let k = ((t / STEP) as usize).min(moments.len() - 1);
                    let load = 0.5 + moments[k].input.torque.abs() / 2000.0;
                    let (phase, gain) = order[k];
                    engine_size * load * gain * (phase + channel as f64).sin()
                });
                coloured
                    .and(&Course::wander(seconds, 100.0, 0.01, dice))
                    .and(&hopping(0.7 * strength * white, dice))
                    .and(&shaking)
            }
            _ => Course::default(),
        }
    };
    std::array::from_fn(&mut own)
}

/// Phase, rad, of the second order of an engine that is kept below 3000 per minute, and what a sensor's filter leaves of it.
fn engine_order(moments: &[Moment]) -> Vec<(f64, f64)> {
    const CUT_OFF: f64 = TAU * 25.0;
    const GEARS: [f64; 6] = [13.0, 8.0, 5.3, 4.0, 3.2, 2.6];
    let mut phase = 0.0;
    let of = |moment: &Moment| {
        let wheel = 0.25 * moment.omega.iter().sum::<f64>();
        let gear = GEARS.into_iter().find(|gear| wheel * gear < 3000.0 / 60.0 * TAU).unwrap_or(2.6);
        let frequency = 2.0 * wheel * gear;
        phase += frequency * STEP;
        (phase, 1.0 / (1.0 + (frequency / CUT_OFF).powi(2)))
    };
    moments.iter().map(of).collect()
}

/// How often frames come, how coarse they are and how they are stamped.
pub fn timing(dice: &mut Dice) -> Timing {
    let mut coarse = [0.0; CHANNELS];
    for (channel, step) in [(4, 0.0043), (5, 0.036), (6, 0.036), (7, 0.0087)] {
        coarse[channel] = if dice.chance(0.25) { step } else { 0.0 };
    }
    let wheels = if dice.chance(0.25) { 0.03 } else { 0.0 };
    coarse[..4].fill(wheels);
    let period = [
        *dice.pick(&[0.01, 0.02, 0.02, 0.05, 0.1]),
        *dice.pick(&[0.005, 0.01, 0.01, 0.02, 0.1]),
        *dice.pick(&[0.01, 0.01, 0.02, 0.1]),
        *dice.pick(&[0.01, 0.02, 0.05, 0.1]),
    ];
    Timing { period, batch: *dice.pick(&[0.0, 0.0, 0.01, 0.02]), coarse }
}
