//! An axle's measurement equation at a window's means.

use super::model::Model;
use super::state::{ANGLE_OFFSET, ANGLE_SCALE, AY_OFFSET, FRONT, Row, SPEED_SCALE, State, VY, YAW_OFFSET};
use super::window::Means;
use crate::estimate::belief::Belief;
use crate::model::GRAVITY;

/// Tuned with the tests `campaign` and `long_drives`.
struct Tuning {
    /// Where the curve is too steep to say how far it is bent.
    most_bent: f64,
    /// Deviation of a tire's shape from the straightest one, of its distance to the roundest.
    shape_std: f64,
    /// Mean and variance of the bend where more is in use than was believed to be there.
    bent_anyhow: (f64, f64),
}

const TUNING: Tuning = Tuning { most_bent: 0.97, shape_std: 0.3, bent_anyhow: (2.0, 4.0) };

/// One axle's equation at a window.
pub struct Equation {
    pub axle: usize,
    /// Sensitivity of the difference between the motion's slip angle and the force's to the state.
    pub h: Row,
    /// Residual of the equation, rad: the force's slip angle less the motion's.
    pub residual: f64,
    /// Lateral force over the load, and the total one with the longitudinal.
    pub force: f64,
    pub used: f64,
    /// Slip angle by the stiffness alone, rad.
    pub straight: f64,
    /// What is not known of the bend, rad².
    pub bend_variance: f64,
    /// Noise by the data sheets, rad².
    pub promised: f64,
}

impl Equation {
    /// Compares the slip angle by the motion with that by the force.
    pub fn new(axle: usize, now: &Means, state: &State, model: &Model, belief: &Belief) -> Self {
        let car = &model.car;
        let x = &state.mean;
        let front = axle == FRONT;
        // Along the car to the axle, and how its inertia turns yaw acceleration into axle force.
        let lever = if front { car.a } else { -car.b };
        let turning = car.yaw_inertia / (car.mass * if front { car.b } else { -car.a });
        let turned = turning * now.yaw_acceleration;
        let force = (now.acceleration - x[AY_OFFSET] + turned) / GRAVITY;
        let used = force.hypot(car.axle_forces(now.along)[axle - FRONT]);
        let speed = now.speed * (1.0 + x[SPEED_SCALE]);
        let along = (x[VY] + lever * (now.yaw_rate - x[YAW_OFFSET])) / speed;
        let steered =
            if front { now.angle * (1.0 + x[ANGLE_SCALE]) - x[ANGLE_OFFSET] } else { now.rear_angle };
        let angle = steered - along.atan();
        let (bend, bend_variance) = model.expected_bend(used, belief);
        let straight = x[axle] * force;
        let mut h = Row::zeros();
        h[VY] = -1.0 / speed;
        h[YAW_OFFSET] = lever / speed;
        h[SPEED_SCALE] = along;
        if front {
            h[ANGLE_OFFSET] = -1.0;
            h[ANGLE_SCALE] = now.angle;
        }
        h[axle] = -force * bend;
        h[AY_OFFSET] = x[axle] * bend / GRAVITY;
        Self {
            axle,
            h,
            residual: straight * bend - angle,
            force,
            used,
            straight,
            bend_variance: straight * straight * bend_variance,
            promised: model.promised_variance(axle, x[axle], turning, lever / speed, now),
        }
    }
}

impl Model {
    /// How far the axle's curve is bent with this friction in use: mean and variance over the believed frictions,
    /// weighted towards low use, because drivers seldom use much of what there is.
    fn expected_bend(&self, used: f64, belief: &Belief) -> (f64, f64) {
        let bends = belief.expect(|mu| {
            let share = used / mu;
            let [least, most] = self.tires.at(share.min(TUNING.most_bent));
            // The tire's own shape counts as doubt.
            (if share < 1.0 { (1.0 - share).powi(4) } else { 0.0 }, [least, most - least])
        });
        match bends {
            Some([(bend, variance), (spread, _)]) => (bend, variance + (TUNING.shape_std * spread).powi(2)),
            None => TUNING.bent_anyhow,
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
}
