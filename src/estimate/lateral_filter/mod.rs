//! Joint filter (draft)
pub mod config;
pub mod hypothesis;
pub mod model;
pub mod steering;

use self::config::LateralFilterConfig;
use self::hypothesis::{Hypothesis, Noise, Verdict};
use self::model::*;
use super::{Car, Cornering, Kinematics};
use crate::filter::Gaussian;
use crate::model::DrivenAxle;
use crate::model::GRAVITY;
use crate::model::tire::Tire;
use crate::{Quantity, Sensors};

/// The filter.
#[derive(Clone, Debug)]
pub struct LateralFilter {
    car: Car,
    config: LateralFilterConfig,
    model: Model,
    noise: Noise,
    pub steady: Hypothesis,
    pub agile: Hypothesis,
    pub evidence: f64,
    before: Option<Inputs>,
    pub steering: f64,
    activity: steering::SteeringActivity,
    minimum_speed: f64,
    pub last: Option<Verdict>,
    pub adoptions: u32,
    pub dbg_x: f64,
}

impl LateralFilter {
    /// 
    pub fn new(car: &Car, tire: Tire, sensors: &Sensors, config: &LateralFilterConfig, minimum_speed: f64) -> Self {
        let variance = |q| sensors.noise_std(q).powi(2);
        let noise = Noise {
            yaw_rate: variance(Quantity::YawRate),
            acceleration: variance(Quantity::LateralAcceleration),
            angle: variance(Quantity::SteeringWheelAngle) / car.steering_ratio.powi(2),
            lateral: config.acceleration_noise.powi(2),
            moment: config.yaw_noise.powi(2),
        };
        let [front, rear] = car.cornering_prior.map(|(value, std)| (value.ln(), (std / value).max(0.05)));
        let mut mean = [0.0; STATES];
        let mut std = [0.0; STATES];
        (mean[FRONT], std[FRONT]) = front;
        (mean[REAR], std[REAR]) = rear;
        (mean[FRICTION], std[FRICTION]) = (config.initial_friction.ln(), config.initial_friction_std);
        std[VY] = 0.5;
        std[YAW] = 0.1;
        std[ANGLE] = 0.1;
        std[ANGLE_RATE] = 0.1;
        std[AY_OFFSET] = config.acceleration_offset_std;
        std[YAW_OFFSET] = config.yaw_rate_offset_std;
        std[ANGLE_OFFSET] = config.steering_offset_std;
        std[BANK] = config.bank_std;
        let hypothesis = Hypothesis { state: Gaussian::new(mean, std) };
        Self {
            car: car.clone(),
            config: config.clone(),
            model: Model::new(car, tire),
            noise,
            steady: hypothesis.clone(),
            agile: hypothesis,
            evidence: 0.0,
            before: None,
            steering: 0.1,
            activity: steering::SteeringActivity::new(noise.angle),
            minimum_speed,
            last: None,
            adoptions: 0,
            dbg_x: 0.0,
        }
    }

    fn inputs(&self, now: &Kinematics, c: &Cornering) -> Inputs {
        let force = now.axle_torque.unwrap_or(0.0) / self.car.radius;
        let (f, r) = match self.car.driven_axle {
            DrivenAxle::Front => (force, 0.0),
            DrivenAxle::Rear => (0.0, force),
            DrivenAxle::All => (0.5 * force, 0.5 * force),
        };
        Inputs {
            speed: c.speed,
            longitudinal: [f / (2.0 * self.car.wheel_load[0]), r / (2.0 * self.car.wheel_load[1])],
        }
    }

    /// 
    pub fn step(&mut self, now: &Kinematics) {
        let Some(c) = now.cornering(self.minimum_speed) else {
            self.before = None;
            return;
        };
        let inputs = self.inputs(now, &c);
        let readings = [c.road_angle, c.yaw_rate, c.lateral_acceleration];
        self.steering = self.config.steering_margin * self.activity.step(c.road_angle, now.elapsed_s);
        self.dbg_x = inputs.longitudinal[0];
        if let Some(before) = self.before {
            let dt = now.elapsed_s;
            for (h, walk) in
                [(&mut self.steady, self.config.steady()), (&mut self.agile, self.config.agile())]
            {
                h.predict(&self.model, &before, &inputs, dt, &self.noise, self.steering);
                h.walk(&walk, dt);
                h.fade_bank(self.config.bank_std.powi(2), self.config.bank_time_s, dt);
            }
        }
        self.before = Some(inputs);
        let a = self.steady.update(&self.model, &inputs, readings, &self.noise);
        let b = self.agile.update(&self.model, &inputs, readings, &self.noise);
        self.last = Some(a);
        let gain = b.ln_likelihood - a.ln_likelihood;
        self.evidence = (self.evidence + gain.clamp(-3.0, 3.0)).max(0.0);
        if self.evidence > self.config.change_evidence {
            self.evidence = 0.0;
            self.adoptions += 1;
            self.steady = self.agile.clone();
            let p = &mut self.steady.state.covariance;
            let (s, o) = (self.config.change_surface_std.powi(2), self.config.change_own_std.powi(2));
            for i in [FRONT, REAR, FRICTION] {
                for j in [FRONT, REAR, FRICTION] {
                    p[(i, j)] += s;
                }
                p[(i, i)] += o;
            }
        }
        if !self.agile.state.is_sound() || !self.steady.state.is_sound() { panic!("unsound"); }
    }

    pub fn stiffness(&self) -> [(f64, f64); 2] {
        [FRONT, REAR].map(|i| (self.steady.state.mean[i].exp(), self.steady.state.std(i)))
    }
}
const _: f64 = GRAVITY;
