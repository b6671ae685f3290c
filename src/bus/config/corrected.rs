//! Effects put into the tables that can hold them, for those who read a bus and do not simulate: the service
//! and `identify`.

use super::Config;
use crate::signals::QuantityConfig;
use physics::model::Uncertain;
use physics::model::effect::{Channel, EffectConfig, KINDS};
use physics::{Quantity, Wheel};

impl Config {
    /// The same with the errors of the measurement chain taken out by `[signals]`: wrong signs, scales and
    /// zeros, delays, swapped channels, unequal tires. Effects that are no such errors stay.
    pub fn with_true_signals(mut self) -> Self {
        self.put(Self::takes_reading);
        self
    }

    /// The same, and drag, rolling resistance, load and the height of the centre of gravity in `[vehicle]`.
    /// Effects that no table can hold stay.
    pub fn corrected(mut self) -> Self {
        self.put(|config, effect| config.takes_reading(effect) || config.takes_number(effect));
        self
    }

    /// Asks for each effect whether it could be put; what happened to a reading last is undone first.
    fn put(&mut self, takes: impl Fn(&mut Self, &EffectConfig) -> bool) {
        let mut effects = std::mem::take(&mut self.effect);
        effects.sort_by_key(|effect| KINDS.iter().position(|kind| kind.name == effect.kind().name));
        let mut stay: Vec<EffectConfig> =
            effects.into_iter().rev().filter(|effect| !takes(self, effect)).collect();
        stay.reverse();
        self.effect = stay;
    }

    fn takes_reading(&mut self, effect: &EffectConfig) -> bool {
        let name = effect.kind().name;
        let number = |name: &str| value(effect, name);
        if let ("channel_swap", Some(Channel::Pair(a, b))) = (name, effect.channel()) {
            let quantities = &mut self.signals.quantities;
            let (was_a, was_b) = (quantities.remove(&a), quantities.remove(&b));
            quantities.extend(was_b.map(|config| (a, config)));
            quantities.extend(was_a.map(|config| (b, config)));
            return true;
        }
        if name == "tire_radius" {
            for wheel in Wheel::ALL {
                let larger = effect.numbers().get(wheel as usize).map_or(0.0, |number| number.value);
                // A larger tire turns less often on the same way.
                self.scale(Quantity::wheel_speed(wheel), 1.0 + larger);
            }
            return true;
        }
        let Some(quantity) = effect.channel().and_then(Channel::quantity) else { return false };
        match name {
            "sensor_sign" => self.scale(quantity, -1.0),
            "sensor_scale" => self.scale(quantity, 1.0 / (1.0 + number("relative_error").value)),
            "sensor_bias" if number("at_s").value < 0.0 => {
                let bias = number("bias").value;
                self.change(quantity, |config| config.offset -= bias);
            }
            "sensor_delay" => {
                let delay = number("delay_s").value;
                self.change(quantity, |config| config.delay_ms += 1e3 * delay);
            }
            _ => return false,
        }
        true
    }

    fn takes_number(&mut self, effect: &EffectConfig) -> bool {
        let number = |name: &str| value(effect, name);
        let vehicle = &mut self.vehicle;
        match effect.kind().name {
            "air_drag" => add(&mut vehicle.drag_coefficient_kg_per_m, number("drag_coefficient_kg_per_m")),
            "rolling_resistance" => add(&mut vehicle.rolling_resistance, number("coefficient")),
            "load_transfer" => vehicle.cg_height_m = number("cg_height_m"),
            "cg_shift" if number("at_s").value < 0.0 => add(&mut vehicle.cg_to_front_m, number("shift_m")),
            "payload" if number("at_s").value < 0.0 => {
                let (load, behind) = (number("mass_kg"), number("position_behind_cg_m").value);
                let empty = vehicle.mass_kg.value;
                let share = load.value / (empty + load.value);
                add(&mut vehicle.mass_kg, load);
                vehicle.cg_to_front_m.value += share * behind;
                if let Some(inertia) = &mut vehicle.yaw_inertia_kgm2 {
                    inertia.value += share * empty * behind * behind;
                }
            }
            _ => return false,
        }
        true
    }

    fn scale(&mut self, quantity: Quantity, by: f64) {
        self.change(quantity, |config| {
            config.gain = Some(config.gain.unwrap_or(1.0) * by);
            config.offset *= by;
        });
    }

    fn change(&mut self, quantity: Quantity, change: impl FnOnce(&mut QuantityConfig)) {
        if let Some(config) = self.signals.quantities.get_mut(&quantity) {
            change(config);
        }
    }
}

/// A number of an effect by its key; zero, if it has none of that name.
fn value(effect: &EffectConfig, name: &str) -> Uncertain {
    let place = effect.kind().place_of(name);
    place.and_then(|place| effect.numbers().get(place)).copied().unwrap_or(Uncertain { value: 0.0, std: 0.0 })
}

fn add(to: &mut Uncertain, more: Uncertain) {
    *to = Uncertain { value: to.value + more.value, std: to.std.hypot(more.std) };
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn config(effects: &str) -> Config {
        let text = format!(
            "dbc.input = [\"car.dbc\"]\n\
             [signals]\n\
             yaw_rate = {{ signal = \"E.Y\", offset = 0.01 }}\n\
             lateral_acceleration = {{ signal = \"E.A\", delay_ms = 2 }}\n\
             wheel_speed_fl = \"W.FL\"\n\
             wheel_speed_fr = \"W.FR\"\n\
             [vehicle]\nmass_kg = {{ value = 1500, std = 30 }}\ncg_to_front_m = 1.2\nwheelbase_m = 2.7\n\
             yaw_inertia_kgm2 = 2500\ntrack_front_m = 1.5\ntrack_rear_m = 1.5\nwheel_radius_m = 0.3\n\
             wheel_inertia_kgm2 = 1.2\nsteering_ratio = 15\ndriven_axle = \"front\"\n{effects}"
        );
        Config::parse(&text, Path::new("car.toml")).expect("the table is right")
    }

    fn effect(kind: &str, rest: &str) -> String {
        format!("[[effect]]\nkind = \"{kind}\"\n{rest}\n")
    }

    /// What a mapping makes of a raw value.
    fn read(config: &Config, quantity: Quantity, raw: f64) -> f64 {
        let quantity = &config.signals.quantities[&quantity];
        quantity.gain.unwrap_or(1.0) * raw + quantity.offset
    }

    #[test]
    fn what_happened_to_a_reading_is_undone_last_first() {
        let plain = config("");
        let wrong = config(
            &(effect("sensor_bias", "channel = \"yaw_rate\"\nbias = 0.02")
                + &effect("sensor_scale", "channel = \"yaw_rate\"\nrelative_error = 0.1")
                + &effect("sensor_sign", "channel = \"yaw_rate\"")),
        );
        // As the effects do it, in the order of the library.
        let order = |name: &str| KINDS.iter().position(|kind| kind.name == name);
        let mut chain = [("sensor_bias", 0), ("sensor_scale", 1), ("sensor_sign", 2)];
        chain.sort_by_key(|(name, _)| order(name));
        let truth = 0.3;
        let recorded = chain.iter().fold(truth, |reading, (_, which)| match which {
            0 => reading + 0.02,
            1 => reading * 1.1,
            _ => -reading,
        });
        // The mapping adds its offset: a raw value that reads as recorded.
        let raw = recorded - 0.01;
        assert!((read(&plain, Quantity::YawRate, raw) - recorded).abs() < 1e-12);
        let right = wrong.with_true_signals();
        assert!((read(&right, Quantity::YawRate, raw) - truth).abs() < 1e-12);
        assert!(right.effect.is_empty());
    }

    #[test]
    fn delays_swaps_and_radii_go_into_the_signals() {
        let right = config(
            &(effect("sensor_delay", "channel = \"lateral_acceleration\"\ndelay_s = 0.04")
                + &effect("channel_swap", "channel = \"wheel_speed_fl/wheel_speed_fr\"")
                + &effect("tire_radius", "relative_difference_fl = 0.01\nrelative_difference_fr = 0\nrelative_difference_rl = 0\nrelative_difference_rr = 0")),
        )
        .with_true_signals();
        let of = |quantity| &right.signals.quantities[&quantity];
        assert!((of(Quantity::LateralAcceleration).delay_ms - 42.0).abs() < 1e-9);
        assert_eq!(of(Quantity::WheelSpeedFl).signal.as_deref(), Some("W.FR"));
        assert_eq!(of(Quantity::WheelSpeedFr).signal.as_deref(), Some("W.FL"));
        let gains =
            [Quantity::WheelSpeedFl, Quantity::WheelSpeedFr].map(|quantity| read(&right, quantity, 100.0));
        assert!((gains.iter().sum::<f64>() - 201.0).abs() < 1e-9, "{gains:?}");
    }

    #[test]
    fn loads_and_resistances_go_into_the_vehicle_and_the_rest_stays() {
        let effects = effect("payload", "mass_kg = { value = 300, std = 40 }\nposition_behind_cg_m = 0.6")
            + &effect("air_drag", "drag_coefficient_kg_per_m = 0.4")
            + &effect("load_transfer", "cg_height_m = 0.6")
            + &effect("relaxation_length", "length_m = 0.5")
            + &effect("sensor_bias", "channel = \"yaw_rate\"\nbias = 0.02\nat_s = 30");
        let plain = config(&effects);
        let drag = plain.vehicle.drag_coefficient_kg_per_m.value;
        let right = plain.clone().corrected();
        assert_eq!(right.vehicle.mass_kg, Uncertain { value: 1800.0, std: 50.0 });
        assert!((right.vehicle.cg_to_front_m.value - 1.3).abs() < 1e-12);
        let inertia = right.vehicle.yaw_inertia_kgm2.expect("it is in the table").value;
        assert!((inertia - 2500.0 - 250.0 * 0.36).abs() < 1e-9);
        assert!((right.vehicle.drag_coefficient_kg_per_m.value - drag - 0.4).abs() < 1e-12);
        assert_eq!(right.vehicle.cg_height_m.value, 0.6);
        let stay: Vec<&str> = right.effect.iter().map(|effect| effect.kind().name).collect();
        assert!(stay.len() == 2 && stay.contains(&"relaxation_length") && stay.contains(&"sensor_bias"));
        assert_eq!(plain.with_true_signals().vehicle.mass_kg.value, 1500.0);
    }
}
