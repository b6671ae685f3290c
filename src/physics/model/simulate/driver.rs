//! The driver who holds a speed, and the anti-lock brake.

use super::given::Line;
use super::input::Input;
use crate::model::scenario::{AbsConfig, DriverConfig};
use crate::model::tire::Shape;
use crate::model::{Conditions, Plant, Response, State};

/// What the driver asks for, N m over all wheels; the brake torque is zero or positive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Demand {
    pub(super) drive_nm: f64,
    pub(super) brake_nm: f64,
}

/// Holds a speed: acceleration asked for = that of the wanted speed + proportional + integral of
/// the error, limited, lagged, and turned into torques.
#[derive(Clone, Debug)]
pub(super) struct Driver {
    config: DriverConfig,
    speed: Input,
    integral: f64,
    acceleration: f64,
    /// Share of the drive torque that is left while driven wheels spin.
    left: f64,
}

/// Torque is taken away from spinning wheels with this time constant, and comes back with that one, s: an engine's throttle, and a
/// control that tries again.
const LETS_GO_S: f64 = 0.1;
const COMES_BACK_S: f64 = 1.0;

/// Speed below which engine drag fades out, and a car that is to stand is held by its brake, m/s.
const WALKING_MPS: f64 = 1.0;

impl Driver {
    pub(super) fn new(config: &DriverConfig, speed: Input) -> Self {
        Self { config: config.clone(), speed, integral: 0.0, acceleration: 0.0, left: 1.0 }
    }

    /// From `t` on, this speed instead of the scenario's.
    pub(super) fn give(&mut self, t: f64, speed: Line) {
        self.speed.give(t, speed);
    }

    /// Takes the largest slip of a driven wheel, for a step of `h` seconds.
    pub(super) fn feel(&mut self, slip: f64, h: f64) {
        let Some(most) = self.config.lets_go_at_slip else { return };
        let (target, time) = if slip > most { (0.0, LETS_GO_S) } else { (1.0, COMES_BACK_S) };
        self.left += h / (time + h) * (target - self.left);
    }

    /// The torques for the step of `h` seconds that begins at `t`. Where the scenario itself presses
    /// the brake pedal (`pedal`), the driver only lifts the other foot.
    pub(super) fn step(&mut self, t: f64, h: f64, vx: f64, pedal: bool, plant: &Plant) -> Demand {
        let config = &self.config;
        if pedal {
            self.acceleration = 0.0;
            self.integral = 0.0;
            return Demand::default();
        }
        let wanted = self.speed.at(t).max(0.0);
        let rate = (self.speed.at(t + h).max(0.0) - wanted) / h;
        let error = wanted - vx;
        let asked = rate + config.gain_per_s * error + self.integral;
        let limited = asked.clamp(-config.deceleration_max_mps2, config.acceleration_max_mps2);
        if asked == limited && wanted > WALKING_MPS {
            self.integral += h * config.gain_per_s / config.integral_time_s * error;
        }
        self.acceleration += h / (config.lag_s + h) * (limited - self.acceleration);

        let radius = plant.radius.iter().sum::<f64>() / 4.0;
        let rotating = 4.0 * plant.wheel_inertia / (radius * radius);
        let inertia = plant.body.mass + rotating;
        let fading = (vx / WALKING_MPS).clamp(0.0, 1.0);
        if wanted < 0.1 && vx.abs() < WALKING_MPS {
            return Demand { drive_nm: 0.0, brake_nm: 0.5 * config.deceleration_max_mps2 * inertia * radius };
        }
        let engine = config.engine_brake_mps2 * fading;
        let force = self.acceleration * inertia + plant.body.resistance(vx);
        Demand {
            drive_nm: self.left * force.max(0.0) * radius + force.clamp(-engine * inertia, 0.0) * radius,
            brake_nm: (-force - engine * inertia).max(0.0) * radius * fading,
        }
    }
}

/// Cycles each wheel's brake torque about the peak of its tire.
#[derive(Clone, Debug)]
pub(super) struct Abs {
    config: AbsConfig,
    /// Torque that each wheel may have, N m; infinite where there is no intervention.
    limit: [f64; 4],
    active_until: f64,
}

impl Abs {
    pub(super) fn new(config: &AbsConfig) -> Self {
        Self { config: config.clone(), limit: [f64::INFINITY; 4], active_until: f64::NEG_INFINITY }
    }

    /// Limits the brake torques asked for, N m at each wheel; true while it intervenes.
    pub(super) fn step(
        &mut self,
        t: f64,
        h: f64,
        (state, response): (&State, &Response),
        plant: &Plant,
        conditions: &Conditions,
        torque: &mut [f64; 4],
    ) -> bool {
        let vx = state.velocity.vx;
        for (i, torque) in torque.iter_mut().enumerate() {
            let demand = *torque;
            if demand <= 0.0 || vx.abs() < self.config.speed_min_mps {
                self.limit[i] = f64::INFINITY;
                continue;
            }
            let contact = &conditions.contact[i];
            let peak = plant.tire.peak_slip(contact.stiffness_x, contact.friction_x);
            let slip = -response.slip[i] * vx.signum();
            let applied = demand.min(self.limit[i]);
            if slip > self.config.release_at_peak_slips * peak {
                self.limit[i] = (applied - self.config.release_nm_per_s * h).max(0.0);
                self.active_until = t + self.config.active_hold_s;
            } else if slip < self.config.apply_at_peak_slips * peak && self.limit[i].is_finite() {
                self.limit[i] = applied + self.config.apply_nm_per_s * h;
                if self.limit[i] >= demand {
                    self.limit[i] = f64::INFINITY;
                }
            }
            *torque = demand.min(self.limit[i]);
        }
        let braking = torque.iter().any(|torque| *torque > 0.0) || self.limit.iter().any(|l| l.is_finite());
        if !braking || vx.abs() < self.config.speed_min_mps {
            self.active_until = f64::NEG_INFINITY;
        }
        t < self.active_until
    }
}
