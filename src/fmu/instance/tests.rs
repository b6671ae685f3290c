//! An instance as importing programs use it, and misuse it.

use super::*;
use physics::model::Vehicle;
use physics::model::effect::EffectConfig;

fn car(part: Part, effects: &str) -> Car {
    #[derive(serde::Deserialize)]
    struct Tables {
        #[serde(default)]
        effect: Vec<EffectConfig>,
    }
    let Tables { effect } = toml::from_str(effects).unwrap();
    Car { name: "car".into(), part, vehicle: Vehicle::thesis(), effect }
}

const EFFECTS: &str = "[[effect]]\nkind = 'load_transfer'\ncg_height_m = 0.6\nload_sensitivity = 0.2\n\
    [[effect]]\nkind = 'relaxation_length'\nlength_m = 0.5\n\
    [[effect]]\nkind = 'sensor_bias'\nchannel = 'yaw_rate'\nbias = 0.02\n\
    [[effect]]\nkind = 'sensor_delay'\nchannel = 'lateral_acceleration'\ndelay_s = -0.02\n";

impl Instance {
    fn of(&self, name: &str) -> u32 {
        self.variables.iter().position(|variable| variable.name == name).unwrap() as u32
    }

    fn put(&mut self, name: &str, value: f64) {
        let reference = self.of(name);
        let is_switch = self.variables[reference as usize].is_switch();
        self.set(reference, is_switch, value).unwrap();
    }

    fn ask(&mut self, name: &str) -> f64 {
        self.get(self.of(name), false).unwrap()
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let mut instance = Instance::new(car(Part::Car, EFFECTS));
    let said = |refused: Result<(), Refused>| refused.unwrap_err().to_string();
    assert!(said(instance.set(9999, false, 1.0)).contains("9999"));
    assert!(said(instance.set(instance.of("holds_speed"), false, 1.0)).contains("real"));
    assert!(said(instance.set(instance.of("yaw_rate"), false, 1.0)).contains("calculated"));
    assert!(said(instance.set(instance.of("steering_wheel_angle"), false, f64::NAN)).contains("NaN"));
    assert!(said(instance.set_rate(instance.of("vehicle.mass_kg"), 1.0)).contains("no input"));
    instance.put("vehicle.mass_kg", -3.0);
    assert!(said(instance.initialize()).contains("vehicle.mass_kg = -3"));
    instance.put("vehicle.mass_kg", 1700.0);
    instance.put("initial_speed", 20.0);
    instance.start_at(5.0);
    instance.initialize().unwrap();
    assert!(said(instance.set(instance.of("initial_speed"), false, 1.0)).contains("after"));
    assert!(said(instance.step(5.0, 0.0015)).contains("internal_step"));
    assert!(said(instance.step(5.5, 0.001)).contains("begins at 5.5 s, and the car is at 5 s"));
    assert!(said(instance.step(5.0, 2e5)).contains("longer than"));
    // Nothing of it has done any harm.
    instance.step(5.0, 0.01).unwrap();
    assert!((instance.seconds() - 5.01).abs() < 1e-12);
    assert!((instance.ask("speed") - 20.0).abs() < 0.1);
    instance.put("vehicle.mass_kg", -3.0);
    assert!(said(instance.step(5.01, 0.01)).contains("vehicle.mass_kg = -3"));
    instance.reset();
    assert_eq!((instance.ask("speed"), instance.ask("vehicle.mass_kg")), (0.0, 1700.0));
}

#[test]
fn a_copy_goes_the_same_way() {
    let mut instance = Instance::new(car(Part::Car, EFFECTS));
    instance.put("initial_speed", 20.0);
    instance.put("steering_wheel_angle", 0.05);
    instance.initialize().unwrap();
    instance.step(0.0, 0.5).unwrap();
    let mut copy = instance.clone();
    for of in [&mut instance, &mut copy] {
        of.put("vehicle.friction", 0.5);
        of.step(0.5, 0.5).unwrap();
    }
    let bits = |of: &Instance| of.truth.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&instance), bits(&copy));
    assert_eq!(instance.ask("friction_fl"), 0.5);
    // All sensors are as late as the one that is early is early: it is late by nothing.
    assert!(instance.car.all_late_s() > 0.019);
    assert_eq!(instance.ask("measured.lateral_acceleration"), instance.ask("lateral_acceleration"));
}

/// A driver who knows how the speed goes on holds it.
#[test]
fn a_driver_holds_the_speed() {
    let mut instance = Instance::new(car(Part::Car, ""));
    instance.put("initial_speed", 10.0);
    instance.put("holds_speed", 1.0);
    instance.put("inputs_are_of_the_end", 1.0);
    instance.put("wanted_speed", 10.0);
    instance.initialize().unwrap();
    for i in 0..1000 {
        let wanted = 10.0 + 1.5 * f64::from(i + 1) * 0.01;
        instance.put("wanted_speed", wanted);
        instance.step(f64::from(i) * 0.01, 0.01).unwrap();
    }
    assert!((instance.ask("speed") - 25.0).abs() < 0.3, "{}", instance.ask("speed"));
}

/// GIVEN the whole car and beside it the correction, led along its motion THEN the forces are those that the plain car
/// lacks, and the errors of its sensors those of the car's.
#[test]
fn a_correction_is_what_the_plain_car_lacks() {
    let mut whole = Instance::new(car(Part::Car, EFFECTS));
    let mut beside = Instance::new(car(Part::Correction, EFFECTS));
    let mut none = Instance::new(car(Part::Correction, ""));
    whole.put("initial_speed", 20.0);
    let motion = ["longitudinal_velocity", "lateral_velocity", "yaw_rate"];
    let wheels = ["wheel_speed_fl", "wheel_speed_fr", "wheel_speed_rl", "wheel_speed_rr"];
    for of in [&mut whole, &mut beside, &mut none] {
        of.put("inputs_are_of_the_end", 1.0);
    }
    for of in [&mut beside, &mut none] {
        for name in motion.iter().chain(&wheels) {
            let value = whole.ask(name);
            of.put(name, value);
        }
    }
    for of in [&mut whole, &mut beside, &mut none] {
        of.initialize().unwrap();
    }
    let mut largest: f64 = 0.0;
    for i in 0..2000 {
        let t = f64::from(i) * 1e-3;
        let steering = 0.06 * (3.0 * (t + 1e-3)).sin();
        whole.put("steering_wheel_angle", steering);
        whole.step(t, 1e-3).unwrap();
        for of in [&mut beside, &mut none] {
            of.put("steering_wheel_angle", steering);
            for name in motion.iter().chain(&wheels) {
                let value = whole.ask(name);
                of.put(name, value);
            }
            of.step(t, 1e-3).unwrap();
        }
        // The plain car's force at the same motion, and what is to be added to it, make that of the whole car.
        let mass = 1700.0;
        let lacking = beside.ask("added_force_left");
        let plain = mass * none.truth[column("lateral_acceleration")];
        let apart = plain + lacking - mass * whole.ask("lateral_acceleration");
        assert!(apart.abs() < 1e-3, "{t}: {apart}");
        largest = largest.max(lacking.abs());
        assert_eq!(none.ask("added_force_left"), 0.0);
        let of_sensor = whole.ask("measured.yaw_rate") - whole.ask("yaw_rate");
        assert!((beside.ask("error.yaw_rate") - of_sensor).abs() < 1e-9, "{t}");
    }
    assert!(largest > 200.0, "{largest}");
}

fn column(name: &str) -> usize {
    physics::model::Truth::columns().iter().position(|column| column == name).unwrap()
}
