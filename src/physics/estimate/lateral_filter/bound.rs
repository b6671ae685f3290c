//! What any filter could know of the stiffness: the posterior Cramér–Rao bound.
//!
//! For a model with additive normal noise the bound of Tichavský et al. (1998) along a given trajectory is
//! the covariance of the Kalman filter linearized at the *truth*: nothing is estimated, only what the
//! readings carry is added up. The steering angle counts as unknown but for its noisy readings.

use super::config::LateralFilterConfig;
use super::hypothesis::{Hypothesis, Noise, Readings};
use super::model::{
    ANGLE, ANGLE_OFFSET, ANGLE_RATE, AY_OFFSET, BANK, FRICTION, FRONT, Inputs, Model, REAR, Row, STATES, VY,
    YAW, YAW_OFFSET,
};
use crate::filter::Gaussian;
use crate::model::Truth;

/// What is assumed to be known, besides the sensors' noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assumptions {
    /// ln of the surface's common factor on stiffnesses and friction is uncertain by this, at the start and
    /// again after each change.
    pub surface_std: f64,
    /// … and of each parameter's own.
    pub own_std: f64,
    /// The sensors' offsets and the bank are unknown as the filter's configuration has it; else known to
    /// be zero, and nothing unmodelled moves the car.
    pub disturbed: bool,
}

impl Default for Assumptions {
    /// A textbook's: offsets known, no bank, nothing unmodelled; of the surface nothing known.
    fn default() -> Self {
        Self { surface_std: 0.7, own_std: 0.03, disturbed: false }
    }
}

/// Standard deviations of the logarithms of front and rear stiffness and of the friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bound {
    /// Front and rear stiffness, relative.
    pub stiffness: [f64; 2],
    /// Friction, relative.
    pub friction: f64,
}

/// Spectral density of a steering of which nothing is known, rad²/s³. Statistical: so much that nothing is assumed
/// of it.
const ANY_STEERING: f64 = 1e4;
/// Motion before the first reading: m/s, rad/s, rad, rad/s. Statistical: wider than any motion the drives begin
/// with.
const UNKNOWN_MOTION: [f64; 4] = [0.5, 0.1, 0.1, 1.0];

/// The bound at each row of `truth` (all `step_s` apart). `changed(i)` tells whether the surface is another one
/// from row `i` on: the bound is that of a filter which knows when.
pub fn stiffness_bound(
    truth: &[Truth],
    step_s: f64,
    model: &Model,
    noise: &Noise,
    config: &LateralFilterConfig,
    assumptions: &Assumptions,
    changed: impl Fn(usize) -> bool,
) -> Vec<Bound> {
    let Some(first) = truth.first() else { return Vec::new() };
    let model = model.at_known_place();
    let mut noise = *noise;
    let mut std = [0.0; STATES];
    std[VY..=ANGLE_RATE].copy_from_slice(&UNKNOWN_MOTION);
    if assumptions.disturbed {
        std[AY_OFFSET] = config.acceleration_offset_std;
        std[YAW_OFFSET] = config.yaw_rate_offset_std;
        std[ANGLE_OFFSET] = config.steering_offset_std;
        std[BANK] = config.bank_std;
    } else {
        (noise.lateral, noise.moment) = (0.0, 0.0);
    }
    let mut knowledge = Hypothesis { state: Gaussian::new([0.0; STATES], std) };
    let own = [assumptions.own_std.powi(2); 3];
    knowledge.open(assumptions.surface_std.powi(2), own);
    let mut bounds = Vec::with_capacity(truth.len());
    let mut before = first;
    for (i, now) in truth.iter().enumerate() {
        if i > 0 {
            knowledge.state.mean = state_of(before, now, step_s);
            knowledge.predict(&model, &inputs_of(before), &inputs_of(now), step_s, &noise, ANY_STEERING);
            if assumptions.disturbed {
                knowledge.fade_bank(config.bank_std.powi(2), config.bank_time_s, step_s);
            }
        }
        if changed(i) {
            for tire in [FRONT, REAR, FRICTION] {
                knowledge.state.forget(tire, 0.0, 0.0);
            }
            knowledge.open(assumptions.surface_std.powi(2), own);
        }
        // At the truth itself: readings without noise leave the mean where it is.
        knowledge.state.mean = state_of(now, now, step_s);
        let (angle, yaw_rate) = (now.steer, now.yaw_rate);
        let readings = Readings { angle, yaw_rate, acceleration: Some(now.lateral_acceleration) };
        knowledge.update(&model, &inputs_of(now), &readings, &noise);
        bounds.push(Bound {
            stiffness: [knowledge.state.std(FRONT), knowledge.state.std(REAR)],
            friction: knowledge.state.std(FRICTION),
        });
        before = now;
    }
    bounds
}

fn state_of(truth: &Truth, next: &Truth, step_s: f64) -> Row {
    let mut x = Row::zeros();
    x[VY] = truth.lateral_velocity;
    x[YAW] = truth.yaw_rate;
    x[ANGLE] = truth.steer;
    x[ANGLE_RATE] = (next.steer - truth.steer) / step_s;
    x[FRONT] = truth.cornering_front.ln();
    x[REAR] = truth.cornering_rear.ln();
    x[FRICTION] = truth.mu_max.ln();
    x
}

fn inputs_of(truth: &Truth) -> Inputs {
    let along = |left: usize| (truth.fx[left] + truth.fx[left + 1]) / (truth.fz[left] + truth.fz[left + 1]);
    Inputs { speed: truth.longitudinal_velocity, longitudinal: [along(0), along(2)], rear_angle: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sensors;
    use crate::estimate::Car;
    use crate::model::Vehicle;
    use crate::model::tire::{PiecewiseLinear, Tire};

    /// The linear car on a sine, its lateral motion by Euler's method in small steps.
    fn truth(amplitude: f64) -> Vec<Truth> {
        let vehicle = Vehicle::thesis();
        let bicycle = Car::new(&vehicle).bicycle(11.5, 11.5);
        let (speed, step) = (25.0, 0.01);
        let (dynamics, input) = bicycle.dynamics(speed);
        let (by_state, by_angle) = bicycle.lateral_acceleration(speed);
        let mut x = nalgebra::Vector2::zeros();
        let load = vehicle.static_wheel_load(true);
        (0..2000)
            .map(|i| {
                let steer = amplitude * (std::f64::consts::PI * f64::from(i) * step).sin();
                for _ in 0..10 {
                    x += 0.1 * step * (dynamics * x + input * steer);
                }
                Truth {
                    longitudinal_velocity: speed,
                    lateral_velocity: x[0],
                    yaw_rate: x[1],
                    lateral_acceleration: by_state.dot(&x) + by_angle * steer,
                    steer,
                    cornering_front: 11.5,
                    cornering_rear: 11.5,
                    mu_max: 1.0,
                    fz: [load; 4],
                    ..Truth::default()
                }
            })
            .collect()
    }

    fn bound(amplitude: f64, disturbed: bool, changed: impl Fn(usize) -> bool) -> Vec<Bound> {
        let car = Car::new(&Vehicle::thesis());
        let config = LateralFilterConfig::default();
        let noise = Noise::promised(&car, &Sensors::default(), &config);
        let model = Model::new(&car, Tire::PiecewiseLinear(PiecewiseLinear));
        let assumptions = Assumptions { disturbed, ..Assumptions::default() };
        stiffness_bound(&truth(amplitude), 0.01, &model, &noise, &config, &assumptions, changed)
    }

    #[test]
    fn twice_the_steering_halves_the_bound_and_what_is_not_known_raises_it() {
        let last = |bounds: Vec<Bound>| bounds[1999];
        let (gentle, firm) = (last(bound(0.005, false, |_| false)), last(bound(0.01, false, |_| false)));
        let ratio = gentle.stiffness[0] / firm.stiffness[0];
        assert!((1.9..2.1).contains(&ratio), "{ratio}");
        let disturbed = last(bound(0.01, true, |_| false));
        assert!(disturbed.stiffness[0] > 1.05 * firm.stiffness[0]);
        // Nothing slid: all that is known of the friction is the surface's share in it.
        assert!(firm.friction > 0.02, "{firm:?}");
    }

    #[test]
    fn a_change_takes_away_what_was_known() {
        let bounds = bound(0.01, false, |row| row == 1000);
        assert!(bounds[1000].stiffness[1] > 5.0 * bounds[999].stiffness[1]);
        assert!(bounds[1999].stiffness[1] < 0.02);
    }
}
