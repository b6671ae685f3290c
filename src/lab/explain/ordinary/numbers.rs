//! What is free in a free run: the car's numbers, which all recordings share, and the measurement's, which each has of
//! its own.

use physics::model::effect::{Course, KINDS};
use physics::model::{TireKind, Vehicle};

use super::inputs::FreeDrive;
use super::run::SpeedSensing;
use crate::explain::model::{Chosen, Model, Place, is_at_either};
use identify::Parameter;
use predict::delay::Delayed;

/// A number of the model, or of how the speed is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// Of the model.
    Of(Place),
    /// True speed / recorded speed.
    SpeedScale,
    /// How late the speed is, s.
    SpeedDelay,
    /// By how much a number of the model is another one in some recordings than in the others.
    Change(Place),
    /// The same of the speed's scale …
    SpeedScaleChange,
    /// … and of how late it is, s.
    SpeedDelayChange,
}

impl Number {
    /// Where it stands in the model.
    pub fn place(self) -> Option<Place> {
        match self {
            Self::Of(place) | Self::Change(place) => Some(place),
            _ => None,
        }
    }

    /// Which channel it is added to after the run, yaw rate or lateral acceleration: the run need not be made again for it.
    pub fn offsets(self) -> Option<usize> {
        match self {
            Self::Of(Place::Ordinary(Parameter::YawRateOffset)) => Some(0),
            Self::Of(Place::Ordinary(Parameter::LateralAccelerationOffset)) => Some(1),
            _ => None,
        }
    }
}

/// Which recordings a number is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// All of them: it is the car's.
    Car,
    /// One: it is of how that was measured, or of what was different there.
    Recording(usize),
    /// All from one on.
    Since(usize),
    /// All from one on, of the last one in full and of those before in proportion: it grows by the same from drive to drive.
    Growing {
        /// The first one that has some of it.
        first: usize,
        /// The one that has all of it.
        last: usize,
    },
}

impl Scope {
    /// Is it of this recording?
    pub fn has(self, drive: usize) -> bool {
        match self {
            Self::Car => true,
            Self::Recording(own) => own == drive,
            Self::Since(first) | Self::Growing { first, .. } => first <= drive,
        }
    }

    /// How much of it a recording has that has it.
    pub fn share(self, drive: usize) -> f64 {
        match self {
            Self::Growing { first, last } => {
                (drive + 1).saturating_sub(first) as f64 / (last + 1).saturating_sub(first).max(1) as f64
            }
            _ => 1.0,
        }
    }
}

/// A free number in the coordinate that is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// What it is.
    pub number: Number,
    /// Which recordings it is of.
    pub of: Scope,
    /// Mean and standard deviation of what is thought of it.
    pub prior: (f64, f64),
    /// What it can be.
    pub bounds: (f64, f64),
    /// Step of differences.
    pub step: f64,
}

/// A number of an effect: name, mean and standard deviation of the class of car.
type OfTheClass = (&'static str, f64, f64);

/// A kind of effect, and its numbers.
type OrdinaryKind = (&'static str, &'static [OfTheClass]);

/// Physics that every car has: kind, its number, and what cars of the class have, mean and standard deviation. What is
/// not listed of a kind stays at the library's usual value.
///
/// Relaxation lengths of passenger car tires are 0.3 to 0.7 m (Pacejka, Tire and Vehicle Dynamics, ch. 5.4 and app. 3).
/// A body leans by 2 to 6° per g (Gillespie, Fundamentals of Vehicle Dynamics, ch. 7; Reimpell, The Automotive Chassis,
/// ch. 5.4.3). A steering gives way by 0.2 to 1° per 1000 N of front lateral force, that is 7e-5 to 3.5e-4 rad per N m of
/// a trail of 0.05 m. The centre of gravity of a passenger car is at 0.5 to 0.65 m (Gillespie, ch. 1; Reimpell, ch. 6.1).
const ORDINARY: &[OrdinaryKind] = &[
    ("relaxation_length", &[("length_m", 0.45, 0.2)]),
    ("steering_compliance", &[("compliance_rad_per_nm", 1e-4, 7e-5)]),
    ("body_roll", &[("roll_gain_rad_per_mps2", 0.006, 0.003)]),
    // How stiffness goes with load, and the axles' shares, say nearly the same again of what the height says.
    (LOAD_TRANSFER, &[CG_HEIGHT]),
];

const CG_HEIGHT: OfTheClass = ("cg_height_m", 0.55, 0.08);

/// Physics that every car has, and that shows in few: how stiffness goes with load is of its own where a car is braked and
/// accelerated hard in its curves, for then the height moves the load between the axles, too.
///
/// Pacejka's C = c₁ sin(2 arctan(F_z/c₂)) with c₂ of 1.5 to 3 static loads (Tire and Vehicle Dynamics, ch. 4.3) is an exponent of
/// 1 − 0.6 to 1 − 0.2.
const LOADED: OrdinaryKind = (LOAD_TRANSFER, &[CG_HEIGHT, ("load_sensitivity", 0.45, 0.15)]);

/// Physics that every car has, and that the data may refuse: at the limit, where the wheels that are unloaded decide
/// where a car goes, what the equations lack about differentials, brakes and tires is more than what they gain.
const LOAD_TRANSFER: &str = "load_transfer";

/// Physics that every car has, and that shows in few: 3 m² press a race car of 800 kg onto the road with nearly its weight at
/// 60 m/s, and with a twentieth of it at 15. Race cars have 2 to 4 m² (Katz, Race Car Aerodynamics), passenger cars a tenth of it.
const PRESSED: OrdinaryKind = (
    "downforce",
    &[("downforce_area_m2", 2.0, 1.5), ("share_behind_static", 0.0, 0.05), ("load_sensitivity", 0.45, 0.2)],
);

/// The model with the physics that every car has, unless the configuration has switched it on; and the same without what
/// the data may refuse.
pub fn with_ordinary<'a>(model: &Model<'a>) -> [Model<'a>; 2] {
    let simpler = ORDINARY.iter().filter(|(name, _)| *name != LOAD_TRANSFER);
    [with_all(model, ORDINARY.iter()), with_all(model, simpler)]
}

/// The same with the tires' load sensitivity of this car.
pub fn with_load_sensitivity<'a>(model: &Model<'a>) -> Model<'a> {
    with_all(model, ORDINARY.iter().filter(|(name, _)| *name != LOAD_TRANSFER).chain([&LOADED]))
}

/// The same with downforce.
pub fn with_downforce<'a>(model: &Model<'a>) -> Model<'a> {
    with_all(model, ORDINARY.iter().chain([&PRESSED]))
}

fn with_all<'a>(model: &Model<'a>, all: impl Iterator<Item = &'static OrdinaryKind>) -> Model<'a> {
    let mut model = model.clone();
    for (name, numbers) in all {
        if model.effects.iter().any(|chosen| chosen.kind.name == *name) {
            continue;
        }
        let Some(kind) = KINDS.iter().copied().find(|kind| kind.name == *name) else { continue };
        let mut chosen = Chosen::usual(kind, None, Course::None);
        chosen.free.clear();
        for (number, mean, _) in *numbers {
            if let Some(place) = kind.place_of(number) {
                chosen.numbers[place] = *mean;
                chosen.free.push(place);
            }
        }
        model = model.with(chosen);
    }
    model
}

/// What cars of the class have of an effect's number, where it is listed.
fn class_of(kind: &str, name: &str) -> Option<(f64, f64)> {
    let of_kind = ORDINARY.iter().chain([&LOADED, &PRESSED]).filter(|(ordinary, _)| *ordinary == kind);
    let mut numbers = of_kind.flat_map(|(_, numbers)| *numbers);
    numbers.find(|(number, ..)| *number == name).map(|(_, mean, std)| (*mean, *std))
}

/// Numbers of the vehicle that speed, steering, yaw rate and lateral acceleration can tell.
const OF_THE_CAR: [Parameter; 8] = [
    Parameter::LateralFront,
    Parameter::LateralRear,
    Parameter::YawInertia,
    Parameter::SteeringRatio,
    Parameter::Friction,
    Parameter::MagicShape,
    Parameter::CgToFront,
    Parameter::Mass,
];

/// A message on a car's bus is late by its cycle and its filter, an inertial unit's stamps by its own clock: up to
/// tenths of a second either way, mean and standard deviation.
pub const DELAY: (f64, f64) = (0.02, 0.1);

/// The accelerometer is of the same unit as the gyroscope.
const LATERAL_DELAY: (f64, f64) = (0.0, 0.03);

/// Beyond this a delay is another thing, s: messages are late by 0.3 s at most, and delays are counted from the yaw rate's. A
/// speed half a second early is an acceleration that changes the tires' loads.
const LONGEST_DELAY_S: f64 = 0.3;

/// Wheel radii and speed messages are right to some per cent.
const SPEED_SCALE: (f64, f64) = (1.0, 0.03);

/// A gyroscope reads so much at standstill, rad/s, where a drive does not tell.
const ZERO: (f64, f64) = (0.0, 0.02);

/// The same without delays, as a plain model takes its sensors.
pub fn on_time(mut free: Vec<Free>) -> Vec<Free> {
    free.retain(|free| !matches!(free.number, Number::SpeedDelay | Number::Of(Place::Delay(_))));
    free
}

/// All that is free in a model for these drives.
pub fn free(model: &Model<'_>, vehicle: &Vehicle, drives: &[FreeDrive]) -> Vec<Free> {
    let has_lateral = drives.iter().any(|drive| drive.lateral.is_some());
    let of_the_car = OF_THE_CAR.into_iter().filter(|parameter| match parameter {
        Parameter::MagicShape => vehicle.tire == TireKind::MagicFormula,
        Parameter::Friction => vehicle.tire != TireKind::Linear,
        // Without an acceleration only ratios to the mass can be seen.
        Parameter::Mass => has_lateral,
        _ => true,
    });
    let mut all: Vec<Free> = of_the_car.filter_map(|parameter| of_vehicle(vehicle, parameter)).collect();
    // What was used, a road has: a search that takes hard driving for outliers would find less.
    let used = drives.iter().filter_map(FreeDrive::used_friction).fold(0.0, f64::max);
    let is_friction = |free: &&mut Free| free.number == Number::Of(Place::Ordinary(Parameter::Friction));
    if let Some(friction) = all.iter_mut().find(is_friction) {
        let least = (SURELY_USED * used).ln().min(friction.prior.0);
        friction.bounds.0 = friction.bounds.0.max(least);
    }
    for (place, chosen) in model.effects.iter().enumerate() {
        for (number, spec) in chosen.specs().enumerate().filter(|(number, _)| chosen.free.contains(number)) {
            let told = chosen.told.get(number).map(|std| (chosen.numbers[number], *std));
            let of_class = || class_of(chosen.kind.name, spec.name);
            let prior = told.or_else(of_class).unwrap_or((spec.mean, spec.std));
            let (number, bounds) = (Number::Of(Place::Effect(place, number)), spec.bounds);
            all.push(Free { number, of: Scope::Car, prior, bounds, step: spec.step.min(0.1 * prior.1) });
        }
    }
    for (number, drive) in drives.iter().enumerate() {
        all.extend(of_drive(number, drive));
    }
    all
}

/// So much of the friction that seems to have been used is sure to have been there. Tuned by `free_runs`: a dry lap of a GTI at
/// 1.0 was fitted with 0.85.
const SURELY_USED: f64 = 0.9;

/// A number of the vehicle, if its table calls it uncertain.
fn of_vehicle(vehicle: &Vehicle, parameter: Parameter) -> Option<Free> {
    let prior = parameter.prior(vehicle);
    if prior.std <= 0.0 || !prior.value.is_finite() {
        return None;
    }
    // What the equations can bear, whatever the table believes.
    let (low, high) = match parameter {
        Parameter::LateralFront | Parameter::LateralRear => (prior.value / 8.0, prior.value * 8.0),
        Parameter::YawInertia => (0.5 * prior.value, 2.0 * prior.value),
        Parameter::SteeringRatio => (0.75 * prior.value, 1.3 * prior.value),
        Parameter::Friction => (0.05, 2.0),
        Parameter::MagicShape => (1.02, 1.9),
        _ => (prior.value - 4.0 * prior.std, prior.value + 4.0 * prior.std),
    };
    // And what a car can be.
    let (least, most) = parameter.bounds_in(vehicle);
    let (low, high) = (low.max(least), high.min(most));
    let number = Number::Of(Place::Ordinary(parameter));
    let std = prior.std / prior.value;
    Some(Free {
        number,
        of: Scope::Car,
        prior: (prior.value.ln(), std),
        bounds: (low.max(1e-6).ln(), high.ln()),
        step: (0.05 * std).clamp(2e-4, 5e-3),
    })
}

/// What each drive has of its own: offsets, delays, the scale of its speed.
fn of_drive(number: usize, drive: &FreeDrive) -> Vec<Free> {
    let own = |number_of, prior: (f64, f64), most: f64, step| Free {
        number: number_of,
        of: Scope::Recording(number),
        prior,
        bounds: (prior.0 - most, prior.0 + most),
        step,
    };
    let of = |place| Number::Of(place);
    let mut all = vec![
        own(of(Place::Ordinary(Parameter::YawRateOffset)), drive.zero.unwrap_or(ZERO), 0.2, 1e-4),
        own(of(Place::Ordinary(Parameter::SteeringOffset)), (0.0, 0.1), 1.5, 1e-3),
        own(of(Place::Delay(Delayed::Steering)), DELAY, LONGEST_DELAY_S, 1e-3),
        own(Number::SpeedDelay, DELAY, LONGEST_DELAY_S, 1e-3),
        own(Number::SpeedScale, SPEED_SCALE, 0.12, 1e-3),
    ];
    if drive.lateral.is_some() {
        all.push(own(of(Place::Ordinary(Parameter::LateralAccelerationOffset)), (0.0, 1.0), 8.0, 0.01));
        all.push(own(of(Place::Delay(Delayed::LateralAcceleration)), LATERAL_DELAY, LONGEST_DELAY_S, 1e-3));
    }
    all
}

/// What is thought of the numbers, −2 ln.
pub fn prior_cost(free: &[Free], at: &[f64]) -> f64 {
    free.iter().zip(at).map(|(free, at)| ((at - free.prior.0) / free.prior.1).powi(2)).sum()
}

/// The model and the speed's measurement of each drive at these coordinates.
pub fn placed<'a>(
    model: &Model<'a>,
    free: &[Free],
    coordinates: &[f64],
    drive: usize,
) -> (Model<'a>, SpeedSensing) {
    let mut model = model.clone();
    let mut sensing = SpeedSensing { delay_s: 0.0, scale: 1.0 };
    for (free, coordinate) in free.iter().zip(coordinates) {
        if !free.of.has(drive) {
            continue;
        }
        // What grows begins where it makes no difference.
        let coordinate = match free.of.share(drive) {
            1.0 => *coordinate,
            share => free.prior.0 + share * (coordinate - free.prior.0),
        };
        match free.number {
            Number::Of(place) => model.put(place, coordinate),
            Number::SpeedScale => sensing.scale = coordinate,
            Number::SpeedDelay => sensing.delay_s = coordinate,
            // The car's own number stands before it.
            Number::Change(place) => model.put(place, model.get(place) + coordinate),
            Number::SpeedScaleChange => sensing.scale += coordinate,
            Number::SpeedDelayChange => sensing.delay_s += coordinate,
        }
    }
    (model, sensing)
}

impl Free {
    /// The same where its recording is the only one.
    pub fn alone(&self) -> Self {
        let of = if self.of == Scope::Car { Scope::Car } else { Scope::Recording(0) };
        Self { of, ..*self }
    }

    /// Is it the same number of the same recordings as another model's? An effect may stand at another place there.
    pub fn is_same(&self, model: &Model<'_>, other: &Self, others: &Model<'_>) -> bool {
        let identity = |free: &Self, model: &Model<'_>| match free.number {
            Number::Of(Place::Effect(effect, place)) => {
                let chosen = &model.effects[effect];
                (free.of, Some((chosen.kind.name, chosen.channel, place)), None)
            }
            number => (free.of, None, Some(number)),
        };
        identity(self, model) == identity(other, others)
    }

    /// The same held at a value, which it cannot leave.
    pub fn held_at(&self, value: f64) -> Self {
        Self { prior: (value, 1e-9), bounds: (value, value), ..*self }
    }

    /// Its name, value in its unit, and how the value changes with the coordinate.
    pub fn named(&self, model: &Model<'_>, coordinate: f64) -> (String, f64, f64) {
        match self.number {
            Number::SpeedScale | Number::SpeedScaleChange => ("speed_scale".into(), coordinate, 1.0),
            Number::SpeedDelay | Number::SpeedDelayChange => ("speed_delay_s".into(), coordinate, 1.0),
            Number::Of(Place::Effect(effect, number)) | Number::Change(Place::Effect(effect, number)) => {
                let chosen = &model.effects[effect];
                match chosen.kind.spec(number, chosen.channel) {
                    Some(spec) => {
                        let value = spec.value(coordinate);
                        let slope = (spec.value(coordinate + self.step) - value) / self.step;
                        let of = chosen.channel.map_or_else(String::new, |channel| format!(":{channel}"));
                        (format!("{}{of}.{}", chosen.kind.name, spec.name), value, slope)
                    }
                    None => (chosen.kind.name.into(), coordinate, 1.0),
                }
            }
            Number::Of(place) | Number::Change(place) => {
                let mut model = model.clone();
                model.put(place, coordinate);
                model.ordinary_number(place).unwrap_or_default()
            }
        }
    }

    /// Is the number at what it can be at most or least?
    pub fn is_at_bound(&self, coordinate: f64) -> bool {
        is_at_either(coordinate, self.bounds)
    }
}
