//! Do the sensors tell of the same drive?
//!
//! The yaw rate has two witnesses that know nothing of it. Speed and steering make the car turn: the model of the
//! likeliest filter runs free beside it, held to it by a slow pull only. And who turns at a speed is accelerated sideways:
//! a_y = v_x r but for the car's beginning to slide. All are smoothed, so that noise and delays of tenths of a second
//! hardly count, and compared by their mean squares over some seconds, after the noise is taken off.

use nalgebra::{Matrix2, Vector2};

use crate::estimate::kinematics::Car;
use crate::estimate::lasting::Lasting;
use crate::estimate::lateral_filter::hypothesis::Readings;
use crate::estimate::lateral_filter::model::{
    ANGLE_OFFSET, AY_OFFSET, Inputs, Model, STATES, VY, YAW, YAW_OFFSET,
};
use crate::estimate::motion::earlier_last;
use crate::estimate::motion::lateness::Lateness;
use crate::estimate::motion::proportion::Proportion;
use crate::filter::Gaussian;
use crate::model::GRAVITY;

/// Tuned with the tests `motion` and `faults`, `useless_shows_s` and `lively` with `campaign`.
struct Tuning {
    /// Time constant of the smoothing, s: longer than delays, shorter than curves.
    smooth_s: f64,
    /// The free run is pulled to the filter within this time, s.
    pull_s: f64,
    /// Seconds that are compared together.
    memory_s: f64,
    /// Before so many seconds nothing is said.
    shows_s: f64,
    /// Share of the movement that may be off where all sensors are right (a car that slides, load transfer), …
    share: [f64; 3],
    /// … and what is off anyhow: rad/s by steering, m/s² by gravity on a cross slope.
    anyhow: [f64; 3],
    /// Factor between two that should be equal, less one: roll and geometry make it this much; so many deviations of it
    /// are chance; seconds that it is taken from, and seconds that one error lasts.
    factor: f64,
    factor_deviations: f64,
    factor_memory_s: f64,
    /// What the factor makes of the movement (rms, in what is off anyhow): less comes from superelevated curves.
    factor_least: f64,
    /// … and where it is only the tires that it would spoil; then all but this share (rms) of what is off is the factor.
    /// In superelevated curves the rest is larger.
    factor_least_for_tires: f64,
    rest: f64,
    /// Accelerometers are mounted so far from the centre of gravity, m.
    mounting: f64,
    error_lasts_s: f64,
    /// With so much turning, rad/s, and this share of it as it is steered, the car rolls forwards.
    turning: f64,
    forward: f64,
    /// What comes so late, s, is of no use.
    useless_s: f64,
    /// That takes so many seconds to show. A car that begins to slide turns ahead of its acceleration, too, for a moment.
    useless_shows_s: f64,
    /// So fast does the lateral acceleration change in lively driving, m/s³; what is faster may be a slide as well.
    lively: f64,
    /// An offset makes at least this share of a mean square.
    level: f64,
    /// A doubt ends at this share of what it begins at.
    ends: f64,
    /// So many deviations of the steering's offset are forgiven.
    offset_deviations: f64,
    /// The free run stays within these: lateral velocity over speed, yaw rate rad/s.
    limits: (f64, f64),
}

const TUNING: Tuning = Tuning {
    smooth_s: 0.3,
    pull_s: 2.0,
    memory_s: 6.0,
    shows_s: 2.0,
    share: [0.3, 0.35, 0.35],
    anyhow: [0.015, 0.5, 0.5],
    factor: 0.12,
    factor_deviations: 3.0,
    factor_memory_s: 20.0,
    factor_least: 1.5,
    factor_least_for_tires: 0.5,
    rest: 0.4,
    mounting: 0.7,
    error_lasts_s: 0.6,
    turning: 0.05,
    forward: 0.5,
    useless_s: 0.08,
    useless_shows_s: 3.0,
    lively: 1.5,
    level: 0.7,
    ends: 0.6,
    offset_deviations: 2.0,
    limits: (0.6, 3.0),
};

/// Two sensors that disagree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// Their names, and the unit of the numbers.
    pub sensors: [&'static str; 3],
    /// By how much (rms), and how much there is of it (rms).
    pub off: f64,
    /// See `off`.
    pub of: f64,
    /// For how long, s.
    pub lasts_s: f64,
}

/// Mean squares of two smoothed signals.
#[derive(Clone, Copy, Debug, Default)]
struct Comparison {
    smooth: [f64; 2],
    off: f64,
    of: f64,
    noise: f64,
    /// The mean difference.
    level: f64,
    /// Over a longer time.
    long: Proportion,
    /// That they disagree.
    doubt: Lasting,
    /// They are proportional enough to be right for the motion, not for the tires.
    is_crude: bool,
}

/// The free run and what is compared with it.
#[derive(Clone, Copy, Debug)]
pub struct Witnesses {
    body: Body,
    /// Lateral velocity and yaw rate of the free run.
    free: Option<Vector2<f64>>,
    seen_s: f64,
    /// Steering's yaw rate with the gyro's; acceleration with that of turning as the gyro, and as the steering has it.
    pairs: [Comparison; 3],
    /// Yaw rate with what the steering makes of it, acceleration with that of turning.
    lateness: [Lateness; 2],
    /// The latter once more, where slides hardly count: is the accelerometer of any use?
    uselessness: Lateness,
}

/// What the car is by its data sheet.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// From the centre of gravity to the rear axle, m.
    b: f64,
    /// Rear slip angle for each m/s², and its standard deviation.
    softness: (f64, f64),
}

impl Body {
    /// Of this car.
    pub fn new(car: &Car) -> Self {
        let (stiffness, std) = car.cornering_prior[1];
        let softness = 1.0 / (GRAVITY * stiffness);
        Self { b: car.b, softness: (softness, softness * std / stiffness) }
    }

    /// How much later softer tires let the car turn: its lag is about half of v/(g C).
    fn lag_std(&self, speed: f64) -> f64 {
        0.5 * self.softness.1 * speed
    }

    /// By how much the acceleration is ahead of the turning, s, and what is not known of that: v_y = b r − v α_R, and α_R
    /// rises with v r, so that a_y = v r + v̇_y = v (r + (b/v − v/(g C_R)) ṙ).
    fn lead(&self, speed: f64) -> (f64, f64) {
        let (softness, std) = self.softness;
        (self.b / speed - softness * speed, TUNING.mounting / speed + std * speed)
    }
}

impl Witnesses {
    /// For this car.
    pub fn new(body: Body) -> Self {
        Self {
            body,
            free: None,
            seen_s: 0.0,
            pairs: [Comparison::default(); 3],
            lateness: [Lateness::default(); 2],
            uselessness: Lateness::of_rate(TUNING.lively),
        }
    }

    /// The pairs.
    const NAMES: [[&'static str; 3]; 3] = [
        ["yaw_rate", "steering_wheel_angle with the speed", "rad/s"],
        ["lateral_acceleration", "yaw_rate with the speed", "m/s²"],
        ["lateral_acceleration", "steering_wheel_angle with the speed", "m/s²"],
    ];

    /// Takes a sample, believed or not; the state of the likeliest filter; `white`: the variances of yaw rate and lateral
    /// acceleration.
    pub fn step(
        &mut self,
        model: &Model,
        state: &Gaussian<STATES>,
        inputs: &Inputs,
        readings: &Readings,
        white: [f64; 2],
        elapsed_s: f64,
    ) {
        let x = &state.mean;
        let held = Vector2::new(x[VY], x[YAW]);
        let free = self.free.get_or_insert(held);
        *free += (elapsed_s / TUNING.pull_s).min(1.0) * (held - *free);
        let rates = model.rates(x, *free, inputs, readings.angle - x[ANGLE_OFFSET], [0.0; 2]);
        let scaled = elapsed_s * rates.by_motion;
        let one = Matrix2::identity();
        *free += elapsed_s * (one + 0.5 * scaled * (one + scaled * (one + 0.25 * scaled) / 3.0)) * rates.rate;
        let (slide, turn) = (TUNING.limits.0 * inputs.speed, TUNING.limits.1);
        *free = Vector2::new(free[0].clamp(-slide, slide), free[1].clamp(-turn, turn));
        let turned = readings.yaw_rate - x[YAW_OFFSET];
        let felt = readings.acceleration.map(|felt| felt - x[AY_OFFSET]);
        let pairs = [
            Some(([turned, free[1]], white[0])),
            felt.map(|felt| ([felt, inputs.speed * turned], white[1] + inputs.speed.powi(2) * white[0])),
            felt.map(|felt| ([felt, inputs.speed * free[1]], white[1])),
        ];
        let [by_steering, by_yaw_rate] = &mut self.lateness;
        by_steering.step([turned, free[1]], 0.0, self.body.lag_std(inputs.speed), elapsed_s);
        match felt {
            Some(felt) => {
                let (lead_s, lead_std) = self.body.lead(inputs.speed);
                for lateness in [by_yaw_rate, &mut self.uselessness] {
                    lateness.step([felt, inputs.speed * turned], -lead_s, lead_std, elapsed_s);
                }
            }
            None => {
                (*by_yaw_rate, self.uselessness) = (Lateness::default(), Lateness::of_rate(TUNING.lively));
            }
        }
        self.seen_s += elapsed_s;
        let memory = (elapsed_s / self.seen_s.min(TUNING.memory_s)).min(1.0);
        // A wrong offset of the steering turns the car as long as it is not known better.
        let by_offset = TUNING.offset_deviations
            * state.std(ANGLE_OFFSET)
            * rates.steady_yaw_gain().min(model.steady_gain(inputs.speed));
        let forgiven = [by_offset, 0.0, inputs.speed * by_offset];
        for (i, (pair, said)) in self.pairs.iter_mut().zip(pairs).enumerate() {
            let Some((signals, noise)) = said else {
                *pair = Comparison::default();
                continue;
            };
            pair.step(signals, noise, elapsed_s, memory);
            pair.remember(elapsed_s, self.seen_s);
            let limit = TUNING.anyhow[i] + forgiven[i] + TUNING.share[i] * pair.of.sqrt();
            let ends = pair.doubt.limit(TUNING.ends);
            let is_off = pair.off() > ends * limit
                || pair.factor_is_off(TUNING.factor_least * TUNING.anyhow[i], self.seen_s, ends);
            let is_off = is_off && self.seen_s > TUNING.shows_s;
            let (least, ends) = (
                TUNING.factor_least_for_tires * TUNING.anyhow[i],
                if pair.is_crude { TUNING.ends } else { 1.0 },
            );
            pair.is_crude = self.seen_s > TUNING.shows_s
                && pair.factor_is_off(least, self.seen_s, ends)
                && pair.is_factor();
            pair.doubt.step(is_off, elapsed_s);
        }
    }

    /// The pair that disagrees, the first one if both do. Without its yaw rate a car still has what the others say of it;
    /// that these two disagree is no doubt of its own.
    pub fn doubt(&self) -> Option<Witness> {
        self.pairs.iter().zip(Self::NAMES).take(2).find_map(|(pair, sensors)| {
            pair.doubt.lasts_s().map(|lasts_s| Witness {
                sensors,
                off: pair.off(),
                of: pair.of.sqrt(),
                lasts_s,
            })
        })
    }

    /// No tires are learned from these sensors: yaw rate or acceleration is scaled wrong or late, if by little. (The
    /// steering depends on the tires themselves.)
    pub fn are_crude(&self) -> bool {
        self.pairs[1].is_crude || self.lateness[1].is_crude()
    }

    /// Which comes later than the other of a pair, by how much (s) and for how long (s), where it is too much.
    pub fn late(&self) -> Option<([&'static str; 2], f64, f64)> {
        let names = [["yaw_rate", "steering_wheel_angle"], ["lateral_acceleration", "yaw_rate"]];
        self.lateness.iter().zip(names).rev().find_map(|(lateness, [one, other])| {
            let names = earlier_last([one, other], lateness.late_s());
            lateness.doubt().lasts_s().map(|lasts_s| (names, lateness.late_s().abs(), lasts_s))
        })
    }

    /// Yaw rate and steering agree, and the accelerometer comes later, or both speak against it by an offset. (By a factor is not enough: a
    /// car that turns less than it is steered may have soft tires.)
    pub fn outvote_acceleration(&self) -> bool {
        let [by_steering, by_yaw_rate, by_both] = self.pairs.map(|pair| pair.doubt.is_there());
        let late = &self.uselessness;
        let is_late = late.doubt().is_there()
            && late.late_s() > TUNING.useless_s
            && late.told_by_s() > TUNING.useless_shows_s;
        !by_steering && (is_late || by_yaw_rate && by_both && self.pairs[1].is_level())
    }

    /// The steering angle tells of another turning than the yaw rate.
    pub fn doubt_steering(&self) -> bool {
        self.pairs[0].doubt.is_there()
    }

    /// The car turns to where it is steered: it rolls forwards.
    pub fn show_forward(&self) -> bool {
        let long = &self.pairs[0].long;
        long.square() > TUNING.turning.powi(2) && long.product() > TUNING.forward * long.square()
    }

    /// The drive is interrupted. What disagreed before has to show again.
    pub fn stop(&mut self) {
        *self = Self::new(self.body);
    }
}

impl Comparison {
    fn step(&mut self, signals: [f64; 2], noise: f64, elapsed_s: f64, memory: f64) {
        let weight = (elapsed_s / TUNING.smooth_s).min(1.0);
        for (smooth, signal) in self.smooth.iter_mut().zip(signals) {
            *smooth += weight * (signal - *smooth);
        }
        let [one, other] = self.smooth;
        self.off += memory * ((one - other).powi(2) - self.off);
        self.level += memory * (one - other - self.level);
        self.of += memory * (0.5 * (one * one + other * other) - self.of);
        // White noise that is smoothed so.
        self.noise += memory * (noise * 0.5 * weight - self.noise);
    }

    fn remember(&mut self, elapsed_s: f64, seen_s: f64) {
        let memory = (elapsed_s / seen_s.min(TUNING.factor_memory_s)).min(1.0);
        self.long.step(self.smooth, memory);
    }

    /// The signals are proportional, but not equal: the scale of one is wrong.
    fn factor_is_off(&self, least: f64, seen_s: f64, ends: f64) -> bool {
        let off = (self.long.factor() - 1.0).abs();
        if off * self.long.square().sqrt() < ends * least {
            return false;
        }
        let worth = seen_s.min(TUNING.factor_memory_s) / TUNING.error_lasts_s;
        off > ends * TUNING.factor + TUNING.factor_deviations * self.long.std(worth)
    }

    /// What the signals differ by is a factor and little else.
    fn is_factor(&self) -> bool {
        let rest = (self.long.rest() - 2.0 * self.noise).max(0.0);
        rest < (TUNING.rest * (self.long.factor() - 1.0)).powi(2) * self.long.square()
    }

    /// The signals differ by an offset more than by anything else.
    fn is_level(&self) -> bool {
        self.level * self.level > TUNING.level * self.off
    }

    /// Rms of the difference without the noise.
    fn off(&self) -> f64 {
        (self.off - 2.0 * self.noise).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::lateral_filter::model::{FRICTION, FRONT, REAR};
    use crate::model::Vehicle;
    use crate::model::tire::{Brush, Tire};

    /// Winds along a road at 20 m/s; what is doubted at the end. The gyro has this gain, the steering comes late by so
    /// many samples or is another drive's, the accelerometer feels gravity beside.
    fn drive(gain: f64, late: usize, is_foreign: bool, gravity: f64) -> Option<Witness> {
        let model = Model::new(&Car::new(&Vehicle::thesis()), Tire::Brush(Brush));
        let mut state = Gaussian::new([0.0; STATES], [0.0; STATES]);
        (state.mean[FRONT], state.mean[REAR]) = (12.0_f64.ln(), 14.0_f64.ln());
        let inputs = Inputs { speed: 20.0, ..Inputs::default() };
        let car = Car::new(&Vehicle::thesis());
        let mut witnesses = Witnesses::new(Body::new(&car));
        let mut motion = Vector2::zeros();
        let angle = |i: usize| 0.02 * (0.01 * i as f64).sin() + 0.01 * (0.037 * i as f64).sin();
        for i in 0..2500 {
            let rates = model.rates(&state.mean, motion, &inputs, angle(i), [0.0; 2]);
            motion += 0.01 * rates.rate;
            let shown = if is_foreign { angle(9 * i / 10 + 400) } else { angle(i.saturating_sub(late)) };
            (state.mean[VY], state.mean[YAW], state.mean[FRICTION]) = (motion[0], gain * motion[1], 0.0);
            let acceleration = Some(rates.acceleration + gravity);
            let readings = Readings { angle: shown, yaw_rate: gain * motion[1], acceleration };
            witnesses.step(&model, &state, &inputs, &readings, [1e-5, 1e-3], 0.01);
        }
        witnesses.doubt()
    }

    #[test]
    fn delays_and_small_errors_are_no_doubt_and_wrong_sensors_are() {
        for (gain, late, gravity) in [(1.0, 0, 0.0), (1.0, 30, 0.0), (1.05, 5, 0.3), (0.97, 10, -0.4)] {
            assert_eq!(drive(gain, late, false, gravity), None, "{gain} {late} {gravity}");
        }
        for gain in [0.6, 1.4, -1.0] {
            assert!(drive(gain, 0, false, 0.0).is_some(), "{gain}");
        }
        let doubt = drive(1.0, 0, true, 0.0).unwrap();
        assert!(doubt.sensors[1].starts_with("steering") && doubt.lasts_s > 5.0, "{doubt:?}");
    }
}
