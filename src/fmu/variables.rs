//! What an FMU of a car takes and gives: the same list in the description and in the library.

use physics::Quantity;
use physics::model::Truth;
use physics::model::effect::EffectConfig;

use crate::car::{Car, Part};
use crate::quantities::{OUTPUTS, VEHICLE};

/// What a variable is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// The time.
    Independent,
    /// Driver's inputs.
    Input,
    /// What comes out.
    Output,
    /// A number that may be changed at any time.
    Tunable,
    /// A number that counts from the start.
    Fixed,
}

/// Where a variable's value comes from or goes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// The time.
    Time,
    /// An input.
    Input(Input),
    /// A column of [`Truth`].
    Truth(usize),
    /// What the sensor says.
    Measured(Quantity),
    /// What the sensor says beyond what is.
    Error(Quantity),
    /// What effects add: its place in [`ADDED`].
    Added(usize),
    /// A number of `[vehicle]`.
    Vehicle(&'static str),
    /// A number of an effect: which, and which of its numbers.
    Effect(usize, usize),
    /// How it is driven.
    Setting(Setting),
}

/// What a driver does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Angle of the steering wheel.
    SteeringWheelAngle,
    /// Torque of all driven wheels.
    DriveTorque,
    /// Brake torque of all wheels.
    BrakeTorque,
    /// Brake pressure.
    BrakePressure,
    /// The speed to be held.
    Speed,
    /// Velocity forward, of somebody else's car, as all that follows.
    VelocityForward,
    /// Velocity to the left.
    VelocityLeft,
    /// Yaw rate.
    YawRate,
    /// Speeds of the wheels.
    WheelFl,
    /// Front right.
    WheelFr,
    /// Rear left.
    WheelRl,
    /// Rear right.
    WheelRr,
}

impl Input {
    /// How many there are.
    pub const COUNT: usize = 12;

    /// All of them, each at its place.
    pub const ALL: [Self; Self::COUNT] = [
        Self::SteeringWheelAngle,
        Self::DriveTorque,
        Self::BrakeTorque,
        Self::BrakePressure,
        Self::Speed,
        Self::VelocityForward,
        Self::VelocityLeft,
        Self::YawRate,
        Self::WheelFl,
        Self::WheelFr,
        Self::WheelRl,
        Self::WheelRr,
    ];
}

/// What effects add to a plain car: name, unit, words.
pub const ADDED: [(&str, &str, &str); 7] = [
    (
        "added_force_forward",
        "N",
        "Force on the body forward, at the centre of gravity, beyond the plain car's",
    ),
    (
        "added_force_left",
        "N",
        "Force on the body to the left, at the centre of gravity, beyond the plain car's",
    ),
    ("added_yaw_moment", "N.m", "Yaw moment on the body beyond the plain car's"),
    ("added_wheel_torque_fl", "N.m", "Torque on the front left wheel, as it rolls, beyond the plain car's"),
    ("added_wheel_torque_fr", "N.m", "Torque on the front right wheel, as it rolls, beyond the plain car's"),
    ("added_wheel_torque_rl", "N.m", "Torque on the rear left wheel, as it rolls, beyond the plain car's"),
    ("added_wheel_torque_rr", "N.m", "Torque on the rear right wheel, as it rolls, beyond the plain car's"),
];

/// What counts from the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Speed at the start.
    InitialSpeed,
    /// Integration step.
    Step,
    /// A driver holds the speed.
    HoldsSpeed,
    /// Inputs are those of the end of a step.
    InputsAreOfTheEnd,
    /// Somebody else's car has wheels that turn.
    HasWheels,
}

/// A variable. Its value reference is its place in the list.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name, with dots.
    pub name: String,
    /// In a sentence.
    pub description: String,
    /// Unit as FMI names them; empty for switches.
    pub unit: &'static str,
    /// What it is for.
    pub causality: Causality,
    /// Where its value comes from.
    pub place: Place,
    /// Where it starts; not a number for what is calculated.
    pub start: f64,
    /// Smallest and largest value, where there are such.
    pub range: Option<(f64, f64)>,
}

impl Variable {
    /// Yes or no, not a number?
    pub fn is_switch(&self) -> bool {
        self.unit.is_empty()
    }
}

/// Units with signs that names of FMI do not have.
fn plain(unit: &str) -> &'static str {
    match unit {
        "m/s²" => "m/s2",
        "N m" => "N.m",
        "1/(m/s)²" => "s2/m2",
        "1/rad²" => "1/rad2",
        "rad/(N m)" => "rad/(N.m)",
        "rad/(m/s²)" => "rad.s2/m",
        "kg/m" => "kg/m",
        "m/N" => "m/N",
        "m/s" => "m/s",
        "rad/s" => "rad/s",
        "rad" => "rad",
        "m" => "m",
        "s" => "s",
        "N" => "N",
        "kg" => "kg",
        "bar" => "bar",
        _ => "1",
    }
}

/// All variables of a car.
pub fn variables(car: &Car) -> Vec<Variable> {
    let mut all = vec![Variable {
        name: "time".into(),
        description: "Simulation time".into(),
        unit: "s",
        causality: Causality::Independent,
        place: Place::Time,
        start: f64::NAN,
        range: None,
    }];
    inputs(car, &mut all);
    outputs(car, &mut all);
    settings(car, &mut all);
    parameters(car, &mut all);
    all
}

fn inputs(car: &Car, all: &mut Vec<Variable>) {
    let mut add = |input, name: &str, unit, description: &str| {
        all.push(Variable {
            name: name.into(),
            description: description.into(),
            unit,
            causality: Causality::Input,
            place: Place::Input(input),
            start: 0.0,
            range: None,
        });
    };
    let angle = "Angle of the steering wheel, positive to the left";
    add(Input::SteeringWheelAngle, "steering_wheel_angle", "rad", angle);
    add(Input::DriveTorque, "drive_torque", "N.m", "Drive torque of all driven wheels together");
    add(
        Input::BrakeTorque,
        "brake_torque",
        "N.m",
        "Brake torque of all wheels together, added to the pressure's",
    );
    if car.takes_pressure() {
        add(Input::BrakePressure, "brake_pressure", "bar", "Brake pressure");
    }
    if car.part == Part::Car {
        let speed = "Speed that a driver holds with torque and brakes; without effect unless holds_speed";
        add(Input::Speed, "wanted_speed", "m/s", speed);
        return;
    }
    let forward = "Velocity of the centre of gravity forward, of the car that is corrected";
    add(Input::VelocityForward, "longitudinal_velocity", "m/s", forward);
    add(Input::VelocityLeft, "lateral_velocity", "m/s", "Velocity of the centre of gravity to the left");
    add(Input::YawRate, "yaw_rate", "rad/s", "Yaw rate, positive to the left");
    let wheels = [Input::WheelFl, Input::WheelFr, Input::WheelRl, Input::WheelRr];
    for (input, (end, words)) in wheels.into_iter().zip(WHEELS) {
        let description = format!("Angular speed of the {words} wheel; without effect unless has_wheels");
        add(input, &format!("wheel_speed_{end}"), "rad/s", &description);
    }
}

fn outputs(car: &Car, all: &mut Vec<Variable>) {
    let mut add = |name, description, unit, place| {
        let (causality, start) = (Causality::Output, f64::NAN);
        all.push(Variable { name, description, unit, causality, place, start, range: None });
    };
    if car.part == Part::Correction {
        for (place, (name, unit, words)) in ADDED.into_iter().enumerate() {
            add(name.to_owned(), words.to_owned(), unit, Place::Added(place));
        }
        for quantity in car.measured() {
            let words = format!("What the sensor says beyond what is: {}", quantity.name().replace('_', " "));
            add(format!("error.{quantity}"), words, plain(quantity.unit()), Place::Error(quantity));
        }
        return;
    }
    for (place, column) in Truth::columns().into_iter().enumerate() {
        let of = |name: &str| OUTPUTS.iter().find(|(known, ..)| *known == name);
        let wheel = column.rsplit_once('_').filter(|(_, end)| WHEELS.iter().any(|(wheel, _)| wheel == end));
        let (known, words) = match (of(&column), wheel) {
            (Some(known), _) => (known, known.2.to_owned()),
            (None, Some((name, wheel))) => {
                let words = WHEELS.iter().find(|(known, _)| *known == wheel).map_or("", |(_, words)| words);
                match of(name) {
                    Some(known) => (known, format!("{}, {words} wheel", known.2)),
                    None => continue,
                }
            }
            // Not of a car that is driven from outside.
            (None, None) => continue,
        };
        // Inputs have these names already.
        let name = if INPUT_NAMES.contains(&column.as_str()) { format!("{column}_now") } else { column };
        add(name, words, known.1, Place::Truth(place));
    }
    for quantity in car.measured() {
        let name = format!("measured.{quantity}");
        let words = format!("What the sensor says: {}", quantity.name().replace('_', " "));
        add(name, words, plain(quantity.unit()), Place::Measured(quantity));
    }
}

/// Outputs that would have an input's name.
const INPUT_NAMES: [&str; 3] = ["steering_wheel_angle", "drive_torque", "brake_torque"];

/// Ends of names, and words.
const WHEELS: [(&str, &str); 4] =
    [("fl", "front left"), ("fr", "front right"), ("rl", "rear left"), ("rr", "rear right")];

fn settings(car: &Car, all: &mut Vec<Variable>) {
    let mut add = |of, name: &str, unit, start, range, description: &str| {
        all.push(Variable {
            name: name.into(),
            description: description.into(),
            unit,
            causality: Causality::Fixed,
            place: Place::Setting(of),
            start,
            range,
        });
    };
    let step = "Integration step, in whole microseconds; communication steps are multiples of it";
    add(Setting::Step, "internal_step", "s", 1e-3, Some((1e-5, 1e-2)), step);
    if car.part == Part::Car {
        let speed = "Speed at the start, rolling freely straight ahead; negative in reverse";
        add(Setting::InitialSpeed, "initial_speed", "m/s", 0.0, Some((-100.0, 100.0)), speed);
        add(Setting::HoldsSpeed, "holds_speed", "", 0.0, None, "A driver holds wanted_speed");
    } else {
        let wheels = "The wheel speeds are given; else all wheels roll freely";
        add(Setting::HasWheels, "has_wheels", "", 1.0, None, wheels);
    }
    let end = "Inputs that are set before a step are those of its end, and go there in a straight line; else they hold \
               through the step";
    add(Setting::InputsAreOfTheEnd, "inputs_are_of_the_end", "", 0.0, None, end);
}

fn parameters(car: &Car, all: &mut Vec<Variable>) {
    for (name, number) in car.vehicle.parameters() {
        let Some((_, unit, words)) = VEHICLE.iter().find(|(known, ..)| *known == name) else { continue };
        all.push(Variable {
            name: format!("vehicle.{name}"),
            description: with_deviation((*words).to_owned(), number.std),
            unit,
            causality: Causality::Tunable,
            place: Place::Vehicle(name),
            start: number.value,
            range: None,
        });
    }
    let names = effect_names(&car.effect);
    for (place, (effect, of)) in car.effect.iter().zip(names).enumerate() {
        let title = effect.kind().words_of(effect.channel().map(|channel| channel.to_string()).as_deref());
        for (number, (spec, value)) in effect.specs().zip(effect.numbers()).enumerate() {
            all.push(Variable {
                name: format!("effect.{of}.{}", spec.name),
                description: with_deviation(format!("{title}: {}", spec.words), value.std),
                unit: plain(spec.unit),
                causality: Causality::Tunable,
                place: Place::Effect(place, number),
                start: value.value,
                range: Some(spec.range()).filter(|(low, high)| low.is_finite() && high.is_finite()),
            });
        }
    }
}

fn with_deviation(words: String, std: f64) -> String {
    if std > 0.0 { format!("{words} (known to ± {})", short(std)) } else { words }
}

/// Three digits.
fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// A name for each effect: its kind, its channel, and a number where there are several.
fn effect_names(effects: &[EffectConfig]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for effect in effects {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let channel = effect.channel().map(|channel| channel.to_string().replace(|c| !is_plain(c), "_"));
        let name = match channel.filter(|_| !effect.kind().is_law()) {
            Some(channel) => format!("{}_{channel}", effect.kind().name),
            None => effect.kind().name.to_owned(),
        };
        let numbered = |count: usize| if count == 1 { name.clone() } else { format!("{name}_{count}") };
        let free = (1..).map(numbered).find(|name| !names.contains(name));
        names.push(free.unwrap_or(name));
    }
    names
}
