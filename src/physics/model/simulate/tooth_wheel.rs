//! A wheel speed sensor: pulses of a tooth wheel, timed.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::model::scenario::ToothWheelConfig;

/// Pulses remembered: 2.7 s at the 1500 pulses per second of 60 m/s.
const PULSES: usize = 4096;

/// Place of a tooth, as a share of the pitch, at most: teeth never change places.
const PITCH_ERROR_MAX: f64 = 0.4;

#[derive(Clone, Copy, Debug)]
struct Pulse {
    time_s: f64,
    /// Number of the tooth, counted on over revolutions, backwards in reverse.
    tooth: i64,
}

/// One wheel's tooth wheel and its evaluation.
///
/// The speed is that of a pulse at least one window before the last one, to the last one: on
/// average half a window and half a pulse old, with the teeth's pitch errors in it.
#[derive(Clone, Debug)]
pub(super) struct ToothWheel {
    pitch: f64,
    errors: Vec<f64>,
    window_s: f64,
    standstill_s: f64,
    angle: f64,
    /// The tooth that comes next when turning forward.
    next: i64,
    pulses: Vec<Pulse>,
    /// How many pulses there were; the newest is at (count − 1) modulo the length.
    count: usize,
}

impl ToothWheel {
    pub(super) fn new(config: &ToothWheelConfig, rng: &mut ChaCha8Rng) -> Self {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let errors = (0..config.teeth)
            .map(|_| (config.pitch_error_std * normal()).clamp(-PITCH_ERROR_MAX, PITCH_ERROR_MAX))
            .collect();
        Self {
            pitch: TAU / f64::from(config.teeth),
            errors,
            window_s: config.window_ms * 1e-3,
            standstill_s: config.standstill_ms * 1e-3,
            // Between two teeth, wherever they are.
            angle: 0.5 * TAU / f64::from(config.teeth),
            next: 1,
            pulses: Vec::with_capacity(PULSES),
            count: 0,
        }
    }

    fn place(&self, tooth: i64) -> f64 {
        let error = self.errors[tooth.rem_euclid(self.errors.len() as i64) as usize];
        self.pitch * (tooth as f64 + error)
    }

    /// The wheel turns by `turned` rad within the `h` seconds that end at `t`.
    pub(super) fn turn(&mut self, t: f64, h: f64, turned: f64) {
        // A thousand turns per second and more: no wheel, and no end of pulses.
        if turned.is_nan() || turned.abs() > TAU * 1000.0 * h {
            return;
        }
        let from = self.angle;
        self.angle += turned;
        while self.place(self.next) <= self.angle {
            self.pulse(t - h * (self.angle - self.place(self.next)) / turned, self.next);
            self.next += 1;
        }
        while self.place(self.next - 1) > self.angle {
            self.next -= 1;
            self.pulse(t - h + h * (self.place(self.next) - from) / turned, self.next);
        }
    }

    fn pulse(&mut self, time_s: f64, tooth: i64) {
        let pulse = Pulse { time_s, tooth };
        if self.pulses.len() < PULSES {
            self.pulses.push(pulse);
        } else {
            self.pulses[self.count % PULSES] = pulse;
        }
        self.count += 1;
    }

    /// The speed, rad/s, as known at time `t`, which may lie in the past by what is remembered.
    pub(super) fn speed(&self, t: f64) -> f64 {
        let oldest = self.count.saturating_sub(PULSES);
        let mut back = (oldest..self.count).rev().map(|i| self.pulses[i % PULSES]);
        let Some(last) = back.find(|pulse| pulse.time_s <= t) else { return 0.0 };
        let age = t - last.time_s;
        if age > self.standstill_s {
            return 0.0;
        }
        let Some(first) = back.find(|pulse| pulse.time_s <= last.time_s - self.window_s) else { return 0.0 };
        let speed = (last.tooth - first.tooth) as f64 * self.pitch / (last.time_s - first.time_s);
        // Had it been faster, there would have been another pulse, however long this pitch is.
        let most = (1.0 + 2.0 * PITCH_ERROR_MAX) * self.pitch / age.max(f64::MIN_POSITIVE);
        speed.clamp(-most, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    fn wheel(pitch_error_std: f64) -> ToothWheel {
        let config = ToothWheelConfig { teeth: 48, pitch_error_std, window_ms: 10.0, standstill_ms: 500.0 };
        ToothWheel::new(&config, &mut ChaCha8Rng::seed_from_u64(3))
    }

    fn run(wheel: &mut ToothWheel, from: f64, seconds: f64, speed: impl Fn(f64) -> f64) -> f64 {
        let steps = (seconds / 1e-3).round() as usize;
        for i in 1..=steps {
            let t = from + i as f64 * 1e-3;
            wheel.turn(t, 1e-3, 1e-3 * speed(t - 0.5e-3));
        }
        from + seconds
    }

    #[test]
    fn a_perfect_wheel_at_constant_speed_tells_it() {
        let mut wheel = wheel(0.0);
        let t = run(&mut wheel, 0.0, 1.0, |_| 70.0);
        assert!((wheel.speed(t) - 70.0).abs() < 1e-6);
        let t = run(&mut wheel, t, 1.0, |_| -70.0);
        assert!((wheel.speed(t) + 70.0).abs() < 1e-6);
    }

    #[test]
    fn pitch_errors_repeat_each_revolution_and_have_no_mean() {
        let mut wheel = wheel(0.01);
        let revolution = TAU / 70.0;
        let start = run(&mut wheel, 0.0, 1.0, |_| 70.0);
        run(&mut wheel, start, 0.5, |_| 70.0);
        let at = |t: f64| wheel.speed(start + t);
        let (mut sum, mut square) = (0.0, 0.0);
        for i in 0..400 {
            let t = f64::from(i) * revolution / 400.0;
            assert!((at(t) - at(t + revolution)).abs() < 1e-6);
            sum += (at(t) - 70.0) / 400.0;
            square += (at(t) - 70.0).powi(2) / 400.0;
        }
        assert!(sum.abs() < 0.02, "mean {sum}");
        // Two ends of std 1 % of a pitch each, over the 6 pitches of 10 ms: √2 · 0.01/6 · 70 rad/s.
        assert!((0.08..0.25).contains(&square.sqrt()), "rms {}", square.sqrt());
    }

    #[test]
    fn it_is_late_by_half_its_window_and_half_a_pulse() {
        let mut wheel = wheel(0.0);
        let t = run(&mut wheel, 0.0, 3.0, |t| 50.0 + 10.0 * t);
        let delays = (0..1000).map(|i| {
            let t = t - f64::from(i) * 1e-3;
            (50.0 + 10.0 * t - wheel.speed(t)) / 10.0
        });
        let mean = delays.sum::<f64>() / 1000.0;
        assert!((0.005..0.0085).contains(&mean), "{mean}");
    }

    #[test]
    fn a_stopping_wheel_comes_to_zero() {
        let mut wheel = wheel(0.01);
        let t = run(&mut wheel, 0.0, 1.0, |_| 10.0);
        let t = run(&mut wheel, t, 0.3, |_| 0.0);
        assert!(wheel.speed(t) < 0.8 && wheel.speed(t) > 0.0);
        let t = run(&mut wheel, t, 0.3, |_| 0.0);
        assert_eq!(wheel.speed(t), 0.0);
    }
}
