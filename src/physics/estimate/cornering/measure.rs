//! The filter's equations on a window's means.

use super::sliding::Excess;
use super::{
    ANGLE_OFFSET, ANGLE_SCALE, AY_OFFSET, Axle, BANK, Belief, CorneringEstimator, Doubt, FRONT, GRAVITY,
    LateralMotion, REAR, Row, SPEED_SCALE, STATES, Said, VY, YAW_OFFSET,
};
use crate::estimate::window::{Means, Path};

/// One axle's equation at a window.
pub(super) struct Equation {
    pub axle: usize,
    /// Sensitivity to the state of the slip angle by the motion …
    pub motion: Row,
    /// … and of that less the one by the force.
    pub h: Row,
    /// What is to be zero, rad: slip angle by the force, less that by the motion.
    pub residual: f64,
    /// Slip angle by the motion, rad.
    pub angle: f64,
    /// Force sideways over the load, and with that along the car.
    pub force: f64,
    pub used: f64,
    /// Slip angle by the stiffness alone, rad.
    pub straight: f64,
    /// What is not known of the bend, rad².
    pub bend_variance: f64,
    /// Noise by the data sheets, rad².
    pub promised: f64,
    /// The car turns as one that drives round a bend, forwards. Where it turns more, it may be a single brake that does
    /// it, and the force is none of this axle's; backwards, with wheel speeds that have no sign, it turns the other way.
    pub is_cornering: bool,
}

impl CorneringEstimator {
    /// Far off its direction of travel, a car's wheels tell its speed badly, m/s²/√Hz.
    const SLIDING_NOISE: f64 = 0.1;
    /// With so much more friction than is in use an axle is at its limit.
    const AT_LIMIT: f64 = 1.15;
    /// Up to this share of the lateral acceleration, yaw acceleration is that of driving round a bend.
    const STEADY: f64 = 0.5;
    /// Below this probability of sliding nothing speaks for it.
    const HARDLY_SLIDING: f64 = 0.1;
    /// A residual of three standard deviations counts less than it would.
    const OUTLIER: f64 = 9.0;
    /// Where the curve is too steep to say how far it is bent.
    const MOST_BENT: f64 = 0.97;
    /// Deviation of a tire's shape from the straightest one, of its distance to the roundest.
    const SHAPE_STD: f64 = 0.3;

    /// v̇_y = a_y − v_x r from window to window, with the sensors' errors and the bank taken off.
    pub(super) fn predict(&mut self, now: &Means) {
        let path = now.path;
        let x = &self.state.mean;
        let turned = path.turned - x[YAW_OFFSET] * path.distance;
        self.state.mean[VY] += self.along(&path);
        let mut transition = nalgebra::SMatrix::<f64, STATES, STATES>::identity();
        transition[(VY, AY_OFFSET)] = -path.time;
        transition[(VY, BANK)] = -path.time;
        transition[(VY, YAW_OFFSET)] = path.distance;
        transition[(VY, SPEED_SCALE)] = -turned;
        let white =
            self.noise.acceleration.hypot(now.speed * self.noise.yaw_rate) * path.time / now.samples.sqrt();
        let is_sliding = self.axles.iter().any(|axle| axle.sliding.is_sure());
        let unmodelled = if is_sliding { Self::SLIDING_NOISE } else { self.config.acceleration_noise };
        let unmodelled = unmodelled * path.time.sqrt();
        let mut noise = nalgebra::SMatrix::<f64, STATES, STATES>::zeros();
        noise[(VY, VY)] = white * white + unmodelled * unmodelled;
        self.state.predict_covariance(&transition, &noise);
        self.walk(path.time);
    }

    /// Random walks of what changes on its own, and the bank, which comes and goes.
    pub(super) fn walk(&mut self, elapsed_s: f64) {
        let config = &self.config;
        let walk = [FRONT, REAR].map(|i| config.stiffness_walk * self.state.mean[i]);
        let common = Self::WALKS_TOGETHER * walk[0] * walk[1] * elapsed_s;
        self.state.covariance[(FRONT, REAR)] += common;
        self.state.covariance[(REAR, FRONT)] += common;
        for (i, walk) in [FRONT, REAR].into_iter().zip(walk) {
            self.state.inflate(i, walk * walk * elapsed_s);
            let most = Self::UNKNOWN_STD * self.state.mean[i];
            let shrink = most / self.state.std(i).max(most);
            self.state.covariance.row_mut(i).scale_mut(shrink);
            self.state.covariance.column_mut(i).scale_mut(shrink);
        }
        let step = Self::ERRORS_WALK * elapsed_s.sqrt();
        for (i, most) in [
            (ANGLE_OFFSET, config.steering_offset_std),
            (AY_OFFSET, config.acceleration_offset_std),
            (YAW_OFFSET, config.yaw_rate_offset_std),
        ] {
            self.state.inflate(i, (step * most).powi(2));
        }
        let kept = (-elapsed_s / config.bank_time_s).exp();
        self.state.mean[BANK] *= kept;
        self.state.covariance.row_mut(BANK).scale_mut(kept);
        self.state.covariance.column_mut(BANK).scale_mut(kept);
        self.state.inflate(BANK, config.bank_std.powi(2) * (1.0 - kept * kept));
    }

    /// Change of v_y along a path, m/s.
    fn along(&self, path: &Path) -> f64 {
        let x = &self.state.mean;
        let turned = path.turned - x[YAW_OFFSET] * path.distance;
        path.pushed - (x[AY_OFFSET] + x[BANK]) * path.time - (1.0 + x[SPEED_SCALE]) * turned
    }

    /// Takes one axle's equation, unless the axle slides.
    pub(super) fn measure(&mut self, equation: &Equation, now: &Means, belief: &Belief) -> Said {
        let Equation { axle, h, force, used, straight, residual, promised, .. } = *equation;
        let monitor = &mut self.axles[axle - FRONT];
        let redundancy = monitor.noise.redundancy();
        let variance = monitor.noise.variance(promised) + equation.bend_variance;
        let expected = self.state.innovation(&h, residual, variance);
        match self.trial.as_mut().map(|trial| trial.step(&expected, variance)) {
            Some(Some(true)) => return Said::OtherCar,
            Some(None) => self.trial = None,
            _ => {}
        }
        let sliding = monitor.sliding.weigh(&Excess {
            angle: -residual * force.signum(),
            variance: expected.variance,
            straight: straight.abs(),
            at_limit: belief.at_most(Self::AT_LIMIT * used),
        });
        if monitor.sliding.is_sure() {
            return Said::Nothing;
        }
        let is_rolling = sliding < Self::HARDLY_SLIDING;
        if is_rolling {
            monitor.noise.learn(&expected, promised);
        }
        let settled = self.state.std(axle) < Self::SETTLED * self.state.mean[axle];
        let doubted = (expected.nis() / Self::OUTLIER).max(1.0) / (1.0 - sliding);
        self.state.update(&h, residual, variance * redundancy * doubted);
        // Steered fast to and fro, sensors a few milliseconds apart disagree in ways that look like softness.
        let steady = now.acceleration.abs() > now.acceleration_spread;
        let mut otherwise = Said::Nothing;
        if expected.nis() > Self::SURPRISING {
            let deviations = expected.normalized() * force.signum();
            let axle = if axle == FRONT { Axle::Front } else { Axle::Rear };
            self.surprised_by = Doubt::Surprise { axle, deviations };
            otherwise = Said::Surprise;
        }
        if !(is_rolling && steady && settled && force.abs() * GRAVITY >= Self::INFORMATIVE) {
            return otherwise;
        }
        let evidence = expected.normalized() * force.signum() / redundancy.sqrt();
        match monitor.cusum.step(evidence.clamp(-Self::ALARM_CLIP, Self::ALARM_CLIP)) {
            Some(_) => Said::Changed,
            None => otherwise,
        }
    }

    /// What the slip angle is by the motion, less what it is by the force.
    pub(super) fn equation(&self, axle: usize, now: &Means, belief: &Belief) -> Equation {
        let car = &self.car;
        let x = &self.state.mean;
        let front = axle == FRONT;
        // Along the car to the axle, and how its inertia turns yaw acceleration into axle force.
        let lever = if front { car.a } else { -car.b };
        let turning = car.yaw_inertia / (car.mass * if front { car.b } else { -car.a });
        let turned = turning * now.yaw_acceleration;
        let force = (now.acceleration - x[AY_OFFSET] + turned) / GRAVITY;
        let used = force.hypot(car.axle_forces(now.along)[axle - FRONT]);
        let speed = now.speed * (1.0 + x[SPEED_SCALE]);
        let along = (x[VY] + lever * (now.yaw_rate - x[YAW_OFFSET])) / speed;
        let steered = if front { now.angle * (1.0 + x[ANGLE_SCALE]) - x[ANGLE_OFFSET] } else { 0.0 };
        let angle = steered - along.atan();
        let (bend, bend_variance) = self.expected_bend(used, belief);
        let straight = x[axle] * force;
        let mut motion = Row::zeros();
        motion[VY] = -1.0 / speed;
        motion[YAW_OFFSET] = lever / speed;
        motion[SPEED_SCALE] = along;
        if front {
            motion[ANGLE_OFFSET] = -1.0;
            motion[ANGLE_SCALE] = now.angle;
        }
        let mut h = motion;
        h[axle] = -force * bend;
        h[AY_OFFSET] = x[axle] * bend / GRAVITY;
        Equation {
            axle,
            motion,
            h,
            residual: straight * bend - angle,
            angle,
            force,
            used,
            straight,
            bend_variance: straight * straight * bend_variance,
            promised: self.promised_variance(axle, x[axle], turning, lever / speed, now),
            is_cornering: turned.abs() < Self::STEADY * now.acceleration.abs()
                && now.yaw_rate * now.acceleration > 0.0,
        }
    }

    /// How far the axle's curve is bent where so much friction is in use: mean and variance over the frictions
    /// believed. Drivers seldom use much of what there is.
    fn expected_bend(&self, used: f64, belief: &Belief) -> (f64, f64) {
        let bends = belief.expect(|mu| {
            let share = used / mu;
            let [least, most] = self.tires.at(share.min(Self::MOST_BENT));
            // The tire's own shape counts as doubt.
            (if share < 1.0 { (1.0 - share).powi(4) } else { 0.0 }, [least, most - least])
        });
        match bends {
            Some([(bend, variance), (spread, _)]) => (bend, variance + (Self::SHAPE_STD * spread).powi(2)),
            // More is in use than was believed to be there.
            None => (2.0, 4.0),
        }
    }

    /// Noise of an axle's equation as the sensors' data sheets promise it, rad².
    fn promised_variance(&self, axle: usize, compliance: f64, turning: f64, lever: f64, now: &Means) -> f64 {
        let averaged = 1.0 / now.samples.sqrt();
        let force = (self.noise.acceleration * averaged).hypot(turning * now.yaw_acceleration_std) / GRAVITY;
        let mut variance = (compliance * force).powi(2) + (lever * self.noise.yaw_rate * averaged).powi(2);
        if axle == FRONT {
            variance += (self.noise.road_angle * averaged).powi(2);
        }
        variance + self.config.slip_angle_noise.powi(2)
    }

    /// The motion now, brought forward from the last window's mean.
    pub(super) fn motion_at(&self, now: &Means) -> LateralMotion {
        let x = &self.state.mean;
        let vy = x[VY] + self.along(&self.window.path);
        let r = now.yaw_rate - x[YAW_OFFSET];
        let angle = now.angle * (1.0 + x[ANGLE_SCALE]) - x[ANGLE_OFFSET];
        LateralMotion {
            lateral_velocity: vy,
            lateral_velocity_std: self.state.std(VY),
            slip_angles: self.car.slip_angles(now.speed * (1.0 + x[SPEED_SCALE]), vy, r, angle),
        }
    }
}
