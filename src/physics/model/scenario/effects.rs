//! What a scenario's effects must agree with.

use super::{Problem, Scenario};
use crate::Quantity;
use crate::model::effect::EffectConfig;
use crate::model::simulate::OWN_STATES;

impl Scenario {
    pub(super) fn validate_effects(&self, problems: &mut Vec<Problem>) {
        if let Some((place, key, reason)) = EffectConfig::problem_among(&self.effect) {
            problems.push(Problem::new(format!("effect[{place}].{key}"), "", reason));
        }
        let states: usize = EffectConfig::effects(&self.effect).iter().map(|effect| effect.states()).sum();
        if states > OWN_STATES {
            let reason = format!("have {states} states together; {OWN_STATES} are possible");
            problems.push(Problem::new("effect", "", reason));
        }
        for quantity in Quantity::ALL {
            let Some(sensor) = self.sensors.get(quantity) else { continue };
            let total = sensor.delay_ms + 1e3 * self.delay_by_effects(quantity);
            if total < -1e-9 {
                let reason = format!(
                    "a sensor cannot say what is yet to come: with the sensor_delay of {quantity} it is {:.1} ms \
                     early; make it late by as much, and the others, too",
                    -total
                );
                problems.push(Problem::new(format!("sensors.{quantity}.delay_ms"), sensor.delay_ms, reason));
            }
        }
    }

    /// How late a sensor is by effects, s.
    pub(crate) fn delay_by_effects(&self, quantity: Quantity) -> f64 {
        let delays = self.effect.iter().filter_map(|config| config.effect().delay());
        delays.filter(|(late, _)| *late == quantity).map(|(_, delay)| delay).sum()
    }

    /// How much stiffer the tires can become, in N per unit slip. What only moves load between the wheels
    /// is within the margin that the integration has.
    pub(super) fn stiffer_by_effects(&self) -> f64 {
        let stiffer = |config: &EffectConfig| {
            let number = |name| config.kind().place_of(name).map(|place| config.numbers()[place].value);
            let stiffness = number("stiffness_factor").unwrap_or(1.0);
            let mass = number("mass_kg").unwrap_or(0.0) / self.vehicle.mass();
            stiffness.max(1.0) * (1.0 + mass.max(0.0))
        };
        self.effect.iter().map(stiffer).product()
    }
}
