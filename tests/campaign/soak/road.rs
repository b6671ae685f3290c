//! Some minutes of driving, drawn: surfaces, manners and manoeuvres, from standing to standing.

use std::fmt::Write as _;

use gripd::Micros;
use gripd::model::{GRAVITY, Reading, Scenario, Simulation};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::verdict::{Secant, True};
use testing::surface::Surface;

const CAR: &str = include_str!("../../../config/scenarios/demo.toml");

/// What one does for half a minute or a whole one.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Manoeuvre {
    /// Straight on, the lane kept.
    Cruise,
    /// Bends and changes of speed.
    Winding,
    /// Left and right in a steady rhythm.
    Slalom,
    /// To a standstill and on.
    Stop,
    /// As hard as the brake goes, the anti-lock brake at work.
    Emergency,
}

/// What the driver does.
#[derive(Default)]
struct Inputs {
    speed: Vec<[f64; 2]>,
    pressure: Vec<[f64; 2]>,
    other: String,
    effects: String,
    roads: String,
    /// What lies under the wheels, and its friction.
    road: Option<(Surface, f64)>,
}

/// How often one meets a surface.
const USUAL: [Surface; 10] = {
    use Surface::{Dry, Gravel, Ice, Snow, Wet};
    [Dry, Dry, Dry, Dry, Wet, Wet, Wet, Gravel, Snow, Ice]
};

/// What happened on a stretch: what was true, and what the sensors said of it.
pub struct Stretch {
    pub seconds: f64,
    pub truths: Vec<True>,
    pub readings: Vec<Reading>,
}

impl Stretch {
    /// Drives one. Wheels that stand are slow to simulate: a stretch takes as long as a thousandth or a hundredth of it.
    pub fn draw(seed: u64) -> Self {
        let scenario = scenario(&mut ChaCha8Rng::seed_from_u64(seed));
        let mut simulation = Simulation::new(&scenario, seed).unwrap();
        let (mut truths, mut readings, mut secant) = (Vec::new(), Vec::new(), Secant::default());
        while let Some(tick) = simulation.next_tick() {
            truths.push(True::of(tick.truth, &mut secant));
            readings.extend_from_slice(tick.readings);
        }
        readings.sort_by_key(|reading| reading.time);
        Self { seconds: scenario.duration_s, truths, readings }
    }

    /// What the sensors say if it begins at that time.
    pub fn readings_from(&self, begin: Micros) -> Vec<Reading> {
        self.readings.iter().map(|r| Reading { time: r.time + begin, ..*r }).collect()
    }
}

/// A stretch of about six minutes, with its own place, weather and driver, but the same car.
fn scenario(dice: &mut ChaCha8Rng) -> Scenario {
    let mut inputs =
        Inputs { speed: vec![[0.0, 0.0], [1.0, 0.0]], pressure: vec![[0.0, 0.0]], ..Inputs::default() };
    let mut at = 0.0;
    let sections = dice.random_range(6..9);
    for _ in 0..sections {
        at = inputs.section(at, dice);
    }
    let seconds = (at + 4.0_f64).ceil();
    let vehicle = &CAR[CAR.find("[vehicle]").unwrap()..CAR.find("[[road]]").unwrap()];
    let sensors = &CAR[CAR.find("[sensors.wheel_speed]").unwrap()..];
    let Inputs { speed, pressure, other, effects, roads, .. } = inputs;
    let text = format!(
        "duration_s = {seconds}\ninitial_speed_mps = 0.0\nseed = 1\n\
         brake_pressure = [{{ kind = \"points\", points = {pressure:?} }}]\n\
         [driver]\n[[driver.speed_mps]]\nkind = \"points\"\npoints = {speed:?}\n{other}\n{vehicle}\n{roads}\n[abs]\n\
         [[effect]]\nkind = \"load_transfer\"\ncg_height_m = 0.55\n{effects}\n{sensors}"
    );
    Scenario::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

impl Inputs {
    /// Adds a section from a time on; returns when it ends, the car then standing or all but.
    fn section(&mut self, from: f64, dice: &mut ChaCha8Rng) -> f64 {
        use Manoeuvre::*;
        let manoeuvre = [Cruise, Winding, Winding, Slalom, Stop, Emergency][dice.random_range(0..6)];
        let (surface, friction) = match self.road {
            Some(same) if dice.random_range(0..3) > 0 => same,
            _ => self.other_road(from, dice),
        };
        let (low, high) = surface.speeds();
        let speed = dice.random_range(low..high);
        let gentle = 0.3 * friction * GRAVITY;
        // Up to speed or down to it, as the road allows.
        let before = self.speed[self.speed.len() - 1];
        let settled = before[0].max(from) + 1.0 + (speed - before[1]).abs() / gentle;
        let until = settled + dice.random_range(20.0..45.0);
        self.speed.extend([[before[0].max(from) + 1.0, before[1]], [settled, speed]]);
        let manner = [0.06, 0.15, 0.15, 0.3][dice.random_range(0..4)];
        self.steer(manoeuvre, manner * friction * GRAVITY, speed, (settled, until), dice);
        if dice.random_range(0.0..1.0) < 0.15 {
            let angle = dice.random_range(-0.05..0.05);
            let [begin, there, leave, over] = [settled, settled + 3.0, until - 5.0, until - 2.0];
            write!(
                self.effects,
                "[[effect]]\nkind = \"road_bank\"\nseries = {{ t = [{begin}, {there}, {leave}, {over}], value = [0, {angle}, {angle}, 0] }}\n"
            )
            .unwrap();
        }
        let stop_s = speed / gentle;
        match manoeuvre {
            Stop => {
                self.speed.extend([[until, speed], [until + stop_s, 0.0], [until + stop_s + 3.0, 0.0]]);
                until + stop_s + 3.0
            }
            Emergency => {
                let braking_s = (0.9 * speed / (friction * GRAVITY)).min(6.0);
                let over = until + 0.3 + braking_s;
                self.pressure.extend([[until, 0.0], [until + 0.3, 90.0], [over, 90.0], [over + 0.2, 0.0]]);
                self.speed.extend([[until, speed], [until + 0.3, 1.0], [over + 1.0, 1.0]]);
                over + 1.0
            }
            // Slow enough for whatever comes.
            _ => {
                self.speed.extend([[until, speed], [until + stop_s, 4.0]]);
                until + stop_s
            }
        }
    }

    fn other_road(&mut self, from: f64, dice: &mut ChaCha8Rng) -> (Surface, f64) {
        let surface = USUAL[dice.random_range(0..USUAL.len())];
        let (friction, [along, across]) = (surface.friction(dice), surface.stiffness(dice));
        writeln!(
            self.roads,
            "[[road]]\nfrom_s = {from}\ntransition_s = 0.1\nname = \"{}\"\nfriction = {friction}\n\
             longitudinal_factor = {along}\nlateral_factor = {across}",
            surface.name()
        )
        .unwrap();
        if dice.random_range(0..10) == 0 {
            let (side, less) = (["left", "right"][dice.random_range(0..2)], dice.random_range(0.3..0.6));
            writeln!(self.roads, "{side} = {{ friction = {} }}", friction * less).unwrap();
        }
        *self.road.insert((surface, friction))
    }

    fn steer(
        &mut self,
        manoeuvre: Manoeuvre,
        acceleration: f64,
        speed: f64,
        (from, until): (f64, f64),
        dice: &mut ChaCha8Rng,
    ) {
        // For that lateral acceleration, with some understeer.
        let per_g = 15.3 * (2.65 + 0.0025 * speed * speed) / (speed * speed);
        let (angle, time) = (acceleration * per_g, dice.random_range(0.5..1.5));
        let angle = if manoeuvre == Manoeuvre::Cruise { 0.1 * angle } else { angle };
        if manoeuvre == Manoeuvre::Slalom {
            write!(
                self.other,
                "[[steering_wheel_angle]]\nkind = \"sine\"\namplitude = {}\nfrequency_hz = {}\nfrom_s = {from}\nto_s = {until}\n",
                1.4 * angle,
                dice.random_range(0.15..0.5)
            )
            .unwrap();
        } else {
            write!(
                self.other,
                "[[steering_wheel_angle]]\nkind = \"random\"\nrms = {angle}\ncorrelation_time_s = {time}\nfrom_s = {from}\nto_s = {until}\n"
            )
            .unwrap();
        }
        if manoeuvre == Manoeuvre::Winding {
            let time = dice.random_range(2.0..4.0);
            write!(
                self.other,
                "[[driver.speed_mps]]\nkind = \"random\"\nrms = {}\ncorrelation_time_s = {time}\nfrom_s = {from}\nto_s = {until}\n",
                0.5 * acceleration * time
            )
            .unwrap();
        }
    }
}
