//! Drives: where the speed and the lateral acceleration are wanted, and the driver who gets them.

use super::car::{Car, G};
use super::dice::Dice;
use super::hidden::Hidden;
use super::physics::{Input, Moment, STEP, Simulator, Start};

/// Kinds of drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Mixed,
    Highway,
    Slalom,
    AccBrake,
    Hard,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Kind::Mixed => "mixed",
            Kind::Highway => "highway",
            Kind::Slalom => "slalom",
            Kind::AccBrake => "accbrake",
            Kind::Hard => "hard",
        }
    }
}

/// Points per second of a plan.
const RATE: f64 = 100.0;

/// What the driver wants, at 100 Hz.
#[derive(Clone)]
pub struct Plan {
    pub kind: Kind,
    pub seconds: f64,
    pub speed: Vec<f64>,
    /// Lateral acceleration aimed at, m/s²; the steering follows it without feedback.
    pub lateral: Vec<f64>,
}

impl Plan {
    /// A random plan. `lateral_limit` (m/s²) bounds what is aimed at.
    pub fn random(kind: Kind, seconds: f64, lateral_limit: f64, dice: &mut Dice) -> Self {
        let n = (seconds * RATE) as usize + 1;
        let speed = speed_plan(kind, n, dice);
        let lateral = lateral_plan(kind, n, lateral_limit, dice);
        Plan { kind, seconds, speed, lateral }
    }

    fn at(series: &[f64], t: f64) -> f64 {
        let x = (t * RATE).max(0.0);
        let i = (x as usize).min(series.len() - 2);
        let f = (x - i as f64).min(1.0);
        series[i] * (1.0 - f) + series[i + 1] * f
    }

    /// Root mean square of the wanted lateral acceleration and of the wanted longitudinal one on an interval.
    pub fn excitation(&self, start: f64, end: f64) -> (f64, f64) {
        let (i, j) = ((start * RATE) as usize, ((end * RATE) as usize).min(self.speed.len() - 1));
        let count = (j - i).max(1) as f64;
        let lateral = self.lateral[i..j].iter().map(|a| a * a).sum::<f64>() / count;
        let longitudinal =
            self.speed[i..=j].windows(2).map(|w| ((w[1] - w[0]) * RATE).powi(2)).sum::<f64>() / count;
        (lateral.sqrt(), longitudinal.sqrt())
    }
}

/// Moves to `target` at no more than `rate` per second from `*at`, then stays; returns how long the way takes.
fn ramp(series: &mut Vec<f64>, target: f64, rate: f64, n: usize) {
    let from = *series.last().unwrap_or(&target);
    // A half cosine; its steepest slope is π/2 times the mean.
    let seconds = (std::f64::consts::FRAC_PI_2 * (target - from).abs() / rate).max(0.5);
    let steps = (seconds * RATE) as usize;
    for k in 1..=steps {
        if series.len() >= n {
            return;
        }
        let f = 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / steps as f64).cos();
        series.push(from + (target - from) * f);
    }
}

fn speed_plan(kind: Kind, n: usize, dice: &mut Dice) -> Vec<f64> {
    let base = match kind {
        Kind::Highway => dice.between(24.0, 32.0),
        Kind::Slalom => dice.between(15.5, 23.5),
        Kind::Hard => dice.between(17.0, 26.0),
        Kind::Mixed => dice.between(13.0, 28.0),
        Kind::AccBrake => dice.between(12.0, 22.0),
    };
    let mut series = vec![base; (2.0 * RATE) as usize];
    let mut high = false;
    while series.len() < n {
        let (target, up, down, hold) = match kind {
            Kind::Highway => {
                (base + dice.between(-3.0, 3.0), 1.0, dice.between(0.7, 2.5), dice.between(6.0, 15.0))
            }
            Kind::Slalom => (base + dice.between(-1.5, 1.5), 1.2, 1.2, dice.between(8.0, 16.0)),
            Kind::Hard => (dice.between(15.0, 29.0), 1.9, dice.between(1.5, 3.5), dice.between(3.0, 8.0)),
            Kind::Mixed => (dice.between(11.0, 33.0), 1.9, dice.between(1.5, 4.3), dice.between(2.0, 9.0)),
            Kind::AccBrake => {
                high = !high;
                let target = if high { dice.between(24.0, 34.0) } else { dice.between(10.0, 17.0) };
                (target, 2.0, dice.between(3.0, 4.5), dice.between(0.5, 4.0))
            }
        };
        let from = series[series.len() - 1];
        ramp(&mut series, target, if target > from { up } else { down }, n);
        let until = (series.len() + (hold * RATE) as usize).min(n);
        series.resize(until.max(series.len()), target);
    }
    series.truncate(n);
    series
}

fn lateral_plan(kind: Kind, n: usize, limit: f64, dice: &mut Dice) -> Vec<f64> {
    let (low, high, straight) = match kind {
        Kind::Highway => (1.0, 3.0, 0.35),
        Kind::Slalom => (2.0, 4.0, 0.05),
        Kind::Hard => (4.5, 7.5, 0.05),
        Kind::Mixed => (1.8, 4.0, 0.15),
        Kind::AccBrake => (1.0, 2.8, 0.25),
    };
    let mut wanted = vec![0.0; (2.0 * RATE) as usize];
    while wanted.len() < n {
        let steps = (dice.between(4.0, 10.0) * RATE) as usize;
        let amplitude = dice.between(low, high).min(limit);
        let sign = dice.sign();
        let time = |k: usize| k as f64 / RATE;
        let length = time(steps);
        if dice.chance(straight) {
            wanted.resize(wanted.len() + steps / 2, 0.0);
            continue;
        }
        let choice = match kind {
            Kind::Slalom => dice.below(3),
            _ => dice.below(6),
        };
        match choice {
            // Slalom: a sine that grows and fades.
            0 | 1 => {
                let f = dice.between(0.18, 0.55);
                wanted.extend((0..steps).map(|k| {
                    let fade = (time(k).min(length - time(k)) / 1.0).min(1.0);
                    sign * amplitude * fade * (std::f64::consts::TAU * f * time(k)).sin()
                }));
            }
            // Sine sweep.
            2 => {
                let (f0, f1) = (0.15, dice.between(0.8, 1.5));
                wanted.extend((0..steps).map(|k| {
                    let t = time(k);
                    let phase = std::f64::consts::TAU * (f0 * t + 0.5 * (f1 - f0) * t * t / length);
                    let fade = (t.min(length - t) / 0.8).min(1.0);
                    sign * 0.8 * amplitude * fade * phase.sin()
                }));
            }
            // A steady corner between two ramps.
            3 => {
                let rise = dice.between(0.5, 1.5);
                wanted.extend((0..steps).map(|k| {
                    let f = (time(k).min(length - time(k)) / rise).min(1.0);
                    sign * amplitude * f
                }));
            }
            // Lane change and back.
            4 => {
                let period = dice.between(1.8, 3.2);
                let wait = dice.between(0.5, 2.0);
                let lane = |t: f64| {
                    if (0.0..period).contains(&t) { (std::f64::consts::TAU * t / period).sin() } else { 0.0 }
                };
                let total = ((2.0 * period + wait) * RATE) as usize;
                wanted.extend(
                    (0..total).map(|k| sign * amplitude * (lane(time(k)) - lane(time(k) - period - wait))),
                );
            }
            // A few incommensurate sines: a winding road.
            _ => {
                let parts: Vec<(f64, f64)> = (0..5)
                    .map(|_| (dice.between(0.08, 0.7), dice.between(0.0, std::f64::consts::TAU)))
                    .collect();
                wanted.extend((0..steps).map(|k| {
                    let t = time(k);
                    let fade = (t.min(length - t) / 1.0).min(1.0);
                    let sum: f64 = parts.iter().map(|(f, p)| (std::f64::consts::TAU * f * t + p).sin()).sum();
                    amplitude * fade * sum / 3.0
                }));
            }
        }
    }
    wanted.truncate(n);
    smooth(&smooth(&wanted, 12), 12)
}

/// A centred moving average over 2·half + 1 points.
fn smooth(series: &[f64], half: usize) -> Vec<f64> {
    let n = series.len();
    (0..n)
        .map(|i| {
            let (from, to) = (i.saturating_sub(half), (i + half).min(n - 1));
            series[from..=to].iter().sum::<f64>() / (to - from + 1) as f64
        })
        .collect()
}

/// The plan driven in a car with whatever is hidden in it: one moment a millisecond.
pub fn drive(plan: &Plan, car: &Car, hidden: &Hidden) -> Vec<Moment> {
    let start = Start::straight(Plan::at(&plan.speed, 0.0), car);
    let mut simulator = Simulator::new(car, hidden, 0.0, &start, STEP);
    let steps = (plan.seconds / STEP) as usize;
    let mut moments = Vec::with_capacity(steps);
    let (mut speed, mut integral) = (start.u, 0.0f64);
    let (mut force, mut slow_force) = (0.0f64, 0.0f64);
    for _ in 0..steps {
        let t = simulator.time();
        // Hands: the single-track steady-state angle for the wanted lateral acceleration (Rajamani 2012, eq. 3.16).
        let angle = (car.wheelbase() / (speed * speed) + car.understeer()) * Plan::at(&plan.lateral, t);
        let steering = (car.steering_ratio * angle).clamp(-2.2, 2.2);
        // Feet: a force for the wanted speed, through two lags of a foot and a pedal.
        let ahead = Plan::at(&plan.speed, t + 0.25);
        let wish = (ahead - Plan::at(&plan.speed, t - 0.25)) / 0.5;
        let error = Plan::at(&plan.speed, t) - speed;
        integral = (integral + 0.08 * error * STEP).clamp(-0.5, 0.5);
        let wanted = car.mass * (wish + 0.5 * error + integral).clamp(-4.8, 2.3);
        force += (wanted - force) * STEP / 0.15;
        slow_force += (force - slow_force) * STEP / 0.15;
        let engine_braking = -0.04 * car.mass * G;
        let pedal = hidden.road.as_ref().map_or(1.0, |road| road.pedal.at(t));
        let torque = pedal * slow_force.max(engine_braking) * car.radius;
        let braking = (engine_braking - slow_force - 0.1 * car.mass).max(0.0);
        let pressure = braking * car.radius / (2.0 * (car.brake_per_bar[0] + car.brake_per_bar[1]));
        let moment = simulator.advance(&Input { steering, torque, pressure });
        speed = moment.u.max(5.0);
        moments.push(moment);
    }
    moments
}

/// Nobody would hand in a recording of a spin.
pub fn plausible(moments: &[Moment]) -> bool {
    moments.iter().all(|m| {
        m.u > 7.0
            && m.u < 41.0
            && m.v.atan2(m.u).abs() < 0.25
            && m.omega.iter().all(|w| *w * 0.31 > 5.0 && *w * 0.31 < 48.0)
            && m.force[1].abs() < 10.0
    })
}
