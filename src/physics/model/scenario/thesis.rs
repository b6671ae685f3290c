//! The thesis's test cases (App. B) as scenarios.

use super::{Piece, Scenario, ScenarioError};

/// Sine steering and torque, constant parameters.
pub const SIM1: &str = include_str!("../../../../config/scenarios/sim1.toml");
/// Stiffness and friction halved from 100 to 150 s.
pub const SIM2: &str = include_str!("../../../../config/scenarios/sim2.toml");
/// Straight on, halved from 100 to 150 s.
pub const SIM3: &str = include_str!("../../../../config/scenarios/sim3.toml");
/// Sim3 with torque beyond the halved limit.
pub const SIM3_LIMIT: &str = include_str!("../../../../config/scenarios/sim3_limit.toml");

/// A test case that steers with this amplitude, rad, and whose sensors, if wanted so, have no noise.
///
/// # Errors
/// What is wrong with the scenario.
pub fn steered(text: &str, amplitude: f64, noisy: bool) -> Result<Scenario, ScenarioError> {
    let mut scenario = Scenario::parse(text)?;
    for piece in &mut scenario.steering_wheel_angle {
        if let Piece::Sine { amplitude: own, .. } = piece {
            *own = amplitude;
        }
    }
    if !noisy {
        for sensor in scenario.sensors.by_name.values_mut() {
            sensor.noise_std = 0.0;
        }
    }
    Ok(scenario)
}
