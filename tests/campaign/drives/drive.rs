//! One drive, drawn from its seed.

use std::fmt::Write as _;
use std::path::Path;

use gripd::model::{Scenario, Truth, Uncertain, Vehicle};
use gripd::{Config, Estimates, Sample};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::cars::CARS;
use testing::driven;
use testing::surface::Surface;

const SERVICE: &str = include_str!("../../../config/demo.toml");
const SENSORS: &str = include_str!("../../../config/scenarios/demo.toml");

/// How much of the friction a driver uses, rms of the accelerations against mu g.
const MANNERS: [(&str, f64); 3] = [("calm", 0.08), ("brisk", 0.22), ("hard", 0.4)];

/// A drive with what the service is told of it.
pub struct Drive {
    pub seed: u64,
    pub scenario: Scenario,
    pub config: Config,
    /// With which power of the load each tire's stiffness / load falls.
    pub load_sensitivity: f64,
    /// Car, manner, surfaces and troubles, in words.
    pub about: String,
}

struct Dice(ChaCha8Rng);

impl Dice {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    fn chance(&mut self, share: f64) -> bool {
        self.0.random_range(0.0..1.0) < share
    }

    fn normal(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }

    fn pick<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.0.random_range(0..list.len())]
    }
}

impl Drive {
    pub fn draw(seed: u64) -> Self {
        let mut dice = Dice(ChaCha8Rng::seed_from_u64(seed));
        let car = dice.0.random_range(0..CARS.len());
        let sheet: Vehicle = toml::from_str(CARS[car]).unwrap();
        let (manner, use_of_friction) = *dice.pick(&MANNERS);
        let mut about = format!("{} {manner}", ["compact", "saloon", "van"][car]);
        let mut text = String::from("initial_speed_mps = 12.0\n");
        let mut effects = String::new();

        // The road: each surface for half a minute or so.
        let mut roads = String::new();
        let mut inputs = Inputs::default();
        let mut at = 0.0;
        for number in 0..dice.0.random_range(2..4) {
            let surface = *dice.pick(&Surface::ALL);
            let until = at + dice.between(28.0, 45.0);
            let friction = surface.friction(&mut dice.0);
            let [along, across] = surface.stiffness(&mut dice.0);
            writeln!(
                roads,
                "[[road]]\nfrom_s = {at}\ntransition_s = 0.1\nname = \"{}\"\nfriction = {friction}\n\
                 longitudinal_factor = {along}\nlateral_factor = {across}",
                surface.name()
            )
            .unwrap();
            write!(about, ", {}", surface.name()).unwrap();
            if number > 0 && dice.chance(0.2) {
                about += " with a slippery side";
                let low = friction * dice.between(0.3, 0.6);
                writeln!(
                    roads,
                    "{} = {{ friction = {low} }}",
                    if dice.chance(0.5) { "left" } else { "right" }
                )
                .unwrap();
            }
            inputs.add(surface, friction, use_of_friction, (at, until), &sheet, &mut dice);
            at = until;
        }
        let seconds = at;
        // No engine drives a wheel to a hundred metres a second: traction control, or the foot, lets it go.
        let lets_go = Dice(ChaCha8Rng::seed_from_u64(!seed)).between(0.1, 0.5);
        if dice.chance(0.5) {
            about += ", braking";
            // The pedal is pressed: full pressure within 0.3 s, the anti-lock brake does the rest.
            let from = seconds - 4.0;
            writeln!(
                text,
                "brake_pressure = [{{ kind = \"points\", points = [[{from}, 0], [{}, 90], [{}, 90], [{seconds}, 0]] }}]",
                from + 0.3,
                seconds - 0.4
            )
            .unwrap();
        }
        if dice.chance(0.4) {
            about += ", bank";
            let (from, angle) = (dice.between(5.0, seconds - 20.0), dice.between(-0.05, 0.05));
            writeln!(
                effects,
                "[[effect]]\nkind = \"road_bank\"\nseries = {{ t = [{from}, {}, {}, {}], value = [0, {angle}, {angle}, 0] }}",
                from + 3.0,
                from + 12.0,
                from + 15.0
            )
            .unwrap();
        }
        if dice.chance(0.4) {
            about += ", load";
            let mass = dice.between(0.05, 0.2) * sheet.mass_kg.value;
            writeln!(
                effects,
                "[[effect]]\nkind = \"payload\"\nmass_kg = {mass}\nposition_behind_cg_m = {}",
                dice.between(-0.2, 0.7)
            )
            .unwrap();
        }
        writeln!(text, "duration_s = {seconds}\nseed = {seed}").unwrap();
        text += &inputs.text(lets_go);
        text += "[vehicle]\n";
        text += &toml::to_string(&truly(&sheet, &mut dice)).unwrap();
        let [fl, fr, rl, rr] = [(); 4].map(|()| 0.005 * dice.normal());
        let load_sensitivity = dice.between(0.3, 0.7);
        write!(
            text,
            "[radius_difference]\nfl = {fl}\nfr = {fr}\nrl = {rl}\nrr = {rr}\n{roads}[abs]\n{effects}[[effect]]\n\
             kind = \"load_transfer\"\ncg_height_m = {}\nload_sensitivity = {load_sensitivity}\n{}",
            sheet.cg_height_m.value,
            &SENSORS[SENSORS.find("[sensors.wheel_speed]").unwrap()..]
        )
        .unwrap();
        let mut scenario = Scenario::parse(&text).unwrap_or_else(|error| panic!("{seed}: {error}\n{text}"));
        for (name, size) in [
            ("yaw_rate", 0.003),
            ("lateral_acceleration", 0.06),
            ("longitudinal_acceleration", 0.06),
            ("steering_wheel_angle", 0.02),
        ] {
            scenario.sensors.by_name.get_mut(name).unwrap().offset = size * dice.normal();
        }
        let mut config = Config::parse(SERVICE, Path::new("demo.toml")).unwrap();
        config.vehicle = sheet;
        Drive { seed, scenario, config, load_sensitivity, about }
    }

    /// Drives it: every sample and estimate, beside what was true.
    pub fn through_the_engine(&self, take: impl FnMut(&Sample, &Truth, &Estimates)) {
        driven::drive(&self.scenario, self.seed, self.config.clone(), &[], |reading| *reading, take);
    }
}

/// The car as it is: off its data sheet by what that allows, on tires of its own, new or worn.
fn truly(sheet: &Vehicle, dice: &mut Dice) -> Vehicle {
    let mut car = sheet.clone();
    let mut off = |number: &mut Uncertain| {
        let by = dice.normal().clamp(-2.0, 2.0) * number.std;
        *number = Uncertain::known(number.value + by);
    };
    off(&mut car.mass_kg);
    off(&mut car.cg_to_front_m);
    off(&mut car.wheel_radius_m);
    off(&mut car.wheel_inertia_kgm2);
    off(&mut car.steering_ratio);
    off(&mut car.drag_coefficient_kg_per_m);
    off(&mut car.rolling_resistance);
    off(&mut car.cg_height_m);
    [
        &mut car.yaw_inertia_kgm2,
        &mut car.brake_torque_per_bar_front_nm,
        &mut car.brake_torque_per_bar_rear_nm,
    ]
    .into_iter()
    .flatten()
    .for_each(&mut off);
    // Tread worn down makes a tire stiffer.
    let wear = dice.between(0.85, 1.3);
    for stiffness in
        [&mut car.longitudinal_stiffness, &mut car.lateral_stiffness_front, &mut car.lateral_stiffness_rear]
    {
        *stiffness = Uncertain::known(stiffness.value * wear * dice.between(0.93, 1.07));
    }
    car.tire = gripd::model::TireKind::MagicFormula;
    car.magic_formula_shape = Uncertain::known(dice.between(1.25, 1.6));
    car.magic_formula_curvature = Uncertain::known(dice.between(-1.0, 0.4));
    car
}

/// What the driver does.
#[derive(Default)]
struct Inputs {
    speed: String,
    steering: String,
}

impl Inputs {
    /// Drives on a surface for a while: speed and steering at random, as strongly as the manner and the grip have it.
    fn add(
        &mut self,
        surface: Surface,
        friction: f64,
        use_of_friction: f64,
        (from, until): (f64, f64),
        car: &Vehicle,
        dice: &mut Dice,
    ) {
        let (low, high) = surface.speeds();
        let speed = dice.between(low, high);
        let acceleration = use_of_friction * friction * gripd::model::GRAVITY;
        let time = dice.between(2.0, 4.0);
        // One slows down before a worse surface.
        write!(self.speed, "[{}, {speed:.2}], [{:.2}, {speed:.2}], ", from + 0.01, until - 4.0).unwrap();
        writeln!(
            self.steering,
            "[[driver.speed_mps]]\nkind = \"random\"\nrms = {}\ncorrelation_time_s = {time}\nfrom_s = {from}\nto_s = {until}",
            0.5 * acceleration * time
        )
        .unwrap();
        // Steering for that lateral acceleration, the car taken for neutral with some understeer.
        let per_g =
            car.steering_ratio.value * (car.wheelbase_m.value + 0.0025 * speed * speed) / (speed * speed);
        writeln!(
            self.steering,
            "[[steering_wheel_angle]]\nkind = \"random\"\nrms = {}\ncorrelation_time_s = {}\nfrom_s = {from}\nto_s = {until}",
            acceleration * per_g,
            dice.between(0.5, 1.2)
        )
        .unwrap();
    }

    fn text(&self, lets_go: f64) -> String {
        let points = self.speed.trim_end_matches(", ");
        format!(
            "[driver]\nlets_go_at_slip = {lets_go}\n[[driver.speed_mps]]\nkind = \"points\"\npoints = [{points}]\n{}",
            self.steering
        )
    }
}
