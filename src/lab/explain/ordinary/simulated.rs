//! Somebody's simulation beside a recording of the same drive: what the recording has that the simulation has not.
//!
//! ```text
//! simulation ─► the ordinary car that drives like it ──┬──────────────► run ─┐
//! recording − simulation ──────────────────────────────┼─► + what it says ───┴─► search beside that car
//! recorded steering and speed ─────────────────────────┘
//! ```
//!
//! Effects act as differences around the simulated motion. The ordinary car is fitted to the simulation first, far beyond
//! what cars are: a simulation may have no load transfer at all. What it then still lacks of the simulation drops out,
//! because the search is not for the recording itself: it is for what that car says, and the recording minus the
//! simulation. Where the simulation was steered otherwise (by a driver model), there is no such difference point by point,
//! and the car that drives like it stands for it.

use std::collections::BTreeMap;

use physics::Quantity;
use physics::model::effect::EffectConfig;
use physics::model::{TireKind, Uncertain, Vehicle};
use serde::Serialize;

use super::answer::{Asked, Fitted, LEAST_FIT, Ordinary, as_configured};
use super::bend::with_bend;
use super::drives::MOST_S;
use super::fit::{FreeFit, fit};
use super::inputs::{Compared, FreeDrive, Held, Unusable, turning};
use super::numbers::{Free, Number, Scope, free, placed, with_ordinary};
use super::run::{Predicted, run};
use super::scores::{errors, fits, traces};
use crate::explain::Recording;
use crate::explain::align::align;
use crate::explain::model::{Model, Place};
use crate::explain::result::ByChannel;
use predict::car::Compute;

/// How a simulation lies beside its recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Simulated {
    /// The simulation.
    pub name: String,
    /// What is added to its times to come to the recording's, s.
    pub time_offset_s: f64,
    /// Was it steered as the recorded car was? None where it does not tell how it was steered.
    pub steered_alike: Option<bool>,
    /// How much of the simulation the ordinary car that drives like it gives, %, by channel.
    pub emulated_fit: ByChannel,
    /// Parameters of it that were tuned to the recording before, by its names and in its units.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub tuned: BTreeMap<String, f64>,
    /// Names of what was found first, and is not needed beside what was found after it: the second pass left it out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fell_away: Vec<String>,
    /// Do the tires of the car that drives like it have a bend of their own? Then its stiffnesses are those of such tires.
    #[serde(skip)]
    pub is_bent: bool,
}

/// Why a simulation cannot be compared with a recording.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Incomparable {
    /// Nothing to compare.
    #[error("the simulation has no yaw rate; add a column yaw_rate with its unit")]
    NoYawRate,
    /// Different times.
    #[error(
        "simulation and recording have {0:.0} s in common wherever they are laid beside each other; 12 s are needed"
    )]
    NoOverlap(f64),
    /// Different drives.
    #[error(
        "the simulation is of another drive: wherever it is laid beside the recording, {of} of both share no more than \
         {percent:.0} % (50 % are needed); check units and signs of its columns, too"
    )]
    AnotherDrive {
        /// By what they were laid beside each other.
        of: Quantity,
        /// Their squared correlation, %.
        percent: f64,
    },
    /// One of the two cannot be run.
    #[error("{name}: {why}")]
    Unusable {
        /// Which.
        name: String,
        /// Why.
        why: Unusable,
    },
    /// The ordinary car does not come near it.
    #[error(
        "no car of the ordinary kind drives like this simulation: the best gives {0:.0} % of its yaw rate ({LEAST_FIT:.0} % \
         are needed); check the units and signs of its columns, and wheelbase, steering ratio and mass in [vehicle]"
    )]
    NoCar(f64),
}

/// A simulation's numbers may be off by this share at least, whatever the configuration believes of the car's.
const LOOSE: f64 = 0.15;

/// But for the mass: that is on the data sheet, and differs by people and luggage. Named by `beside_a_single_track`: with the
/// share of the others a yaw inertia that is a third too small was called a mass that is too large.
const LOOSE_MASS: f64 = 0.05;

/// What every car has may be missing in a simulation: so many deviations of the class count as one.
const LACKING: f64 = 5.0;

/// The simulation's numbers stay within this, in the coordinates of the search, while the recording is looked at. Numerical.
const KEPT: f64 = 1e-3;

impl Ordinary {
    /// What a recording has that a simulation has not.
    ///
    /// # Errors
    /// Why the two cannot be compared.
    pub fn beside(
        vehicle: &Vehicle,
        effects: &[EffectConfig],
        (recording, simulation): (&Recording, &Recording),
        asked: Asked<'_>,
    ) -> Result<(Self, Simulated), Incomparable> {
        if !simulation.has(Quantity::YawRate) {
            return Err(Incomparable::NoYawRate);
        }
        let alignment = align(recording, simulation)?;
        let simulation = &shifted(simulation, alignment.offset_s);
        let whole = &completed(recording, simulation);
        // A simulation's tires are of any kind: as configured, or with a bend of their own.
        let configured = loosened(vehicle);
        let bent = with_bend(&configured);
        let drive = |of: &Recording, held| {
            let unusable = |why| Incomparable::Unusable { name: of.name.clone(), why };
            FreeDrive::new(of, &bent, held, MOST_S).map_err(unusable)
        };
        let simulated = [drive(whole, Held::Nothing)?];
        let of = |vehicle, loads| Emulation::of(vehicle, effects, &simulated, loads);
        let (of_configured, of_bent) =
            rayon::join(|| of(&configured, Loads::AsOfCars), || of(&bent, Loads::AsOfCars));
        let usual = if of_configured.given() > of_bent.given() { of_configured } else { of_bent };
        let in_proportion = of(usual.vehicle, Loads::InProportion);
        let is_clear = 100.0 - in_proportion.given() < CLEARLY_LESS * (100.0 - usual.given());
        let emulation = if is_clear { in_proportion } else { usual };
        if emulation.given().is_nan() || emulation.given() < LEAST_FIT {
            return Err(Incomparable::NoCar(emulation.given()));
        }
        let recorded = [drive(recording, Held::EveryThird)?];
        let says = emulation.says(&recorded[0]);
        let known = Compared::of(simulation, &bent, recorded[0].from_s, recorded[0].points());
        let drops_out = alignment.steered_alike != Some(false);
        let lacks = drops_out.then(|| Lacks::of(&known, &says, &bent));
        let searched =
            [lacks.as_ref().map_or_else(|| recorded[0].clone(), |lacks| lacks.taken(&recorded[0]))];
        let found = fit(&emulation.car.model, emulation.kept(), &searched);
        let fitted = Fitted {
            vehicle: emulation.vehicle,
            drives: &searched,
            found: &found,
            plain: &found,
            simulated: Some(&FreeFit { free: emulation.thought.clone(), ..emulation.car.clone() }),
        };
        let mut answer = fitted.answer(asked);
        // Back to what was recorded.
        let back = |said: &Predicted| lacks.as_ref().map_or_else(|| said.clone(), |lacks| lacks.given(said));
        let sensed = [back(&found.predicted[0])];
        let with_found =
            answer.beyond.predicted.as_ref().map_or_else(|| sensed.clone(), |all| [back(&all[0])]);
        let plain = [back(&says)];
        answer.fit = fits(&recorded, &sensed);
        answer.plain_fit = fits(&recorded, &plain);
        answer.found_fit = fits(&recorded, &with_found);
        answer.error = errors(&recorded, [&plain, &sensed, &with_found]);
        answer.traces = traces(&recorded, &with_found, &plain);
        let simulated = Simulated {
            name: simulation.name.clone(),
            time_offset_s: alignment.offset_s,
            steered_alike: alignment.steered_alike,
            emulated_fit: emulation.fits,
            tuned: BTreeMap::new(),
            fell_away: answer.beyond.fell_away.clone(),
            is_bent: emulation.vehicle.tire == TireKind::MagicFormula,
        };
        Ok((answer, simulated))
    }
}

/// The simulation on the recording's clock.
fn shifted(simulation: &Recording, offset_s: f64) -> Recording {
    let mut all = simulation.clone();
    for track in &mut all.tracks {
        track.iter_mut().for_each(|(t, _)| *t += offset_s);
    }
    all
}

/// The same with the recorded steering and speed where it does not tell them.
fn completed(recording: &Recording, simulation: &Recording) -> Recording {
    let mut all = simulation.clone();
    let wheels = &Quantity::ALL[..4];
    let has_speed = wheels.iter().chain([&Quantity::VehicleSpeed]).any(|quantity| simulation.has(*quantity));
    let of_speed = wheels.iter().chain([&Quantity::VehicleSpeed]).filter(|_| !has_speed);
    let of_steering =
        (!simulation.has(Quantity::SteeringWheelAngle)).then_some(&Quantity::SteeringWheelAngle);
    for quantity in of_speed.chain(of_steering) {
        all.tracks[*quantity as usize].clone_from(&recording.tracks[*quantity as usize]);
    }
    all
}

/// The car with every number open: a simulation's numbers are anybody's.
fn loosened(vehicle: &Vehicle) -> Vehicle {
    let mut own = vehicle.clone();
    let open = |number: &mut Uncertain, share: f64| number.std = number.std.max(share * number.value.abs());
    let inertia = own.yaw_inertia_kgm2.get_or_insert(Uncertain::known(vehicle.yaw_inertia()));
    open(inertia, LOOSE);
    open(&mut own.mass_kg, LOOSE_MASS);
    for number in [&mut own.lateral_stiffness_front, &mut own.lateral_stiffness_rear, &mut own.friction] {
        open(number, LOOSE);
    }
    own
}

/// A number as it may be in a simulation: of the car anything, of the measurement nearly nothing. Free scales and delays would
/// make up for stiffnesses, and the recording would be looked at through them.
fn lacking(free: &Free) -> Free {
    let std = match free.number {
        Number::Of(Place::Effect(..)) => LACKING * free.prior.1,
        Number::SpeedScale => SPEED_SCALE.min(free.prior.1),
        Number::SpeedDelay | Number::Of(Place::Delay(_)) => LATE_S.min(free.prior.1),
        _ => free.prior.1,
    };
    let mean = match free.number {
        Number::SpeedDelay | Number::Of(Place::Delay(_)) => 0.0,
        _ => free.prior.0,
    };
    Free { prior: (mean, std), ..*free }
}

/// A simulation's speed is its own, or that of the recorded wheels by radii that are known to half a per cent. Tuned by
/// `beside_a_single_track`: with three per cent the car that drives like the single-track model had a scale of 1.035.
const SPEED_SCALE: f64 = 0.005;

/// A simulation is not late, but for a step or two and how it lies beside the recording, s. Tuned like that: a speed that was
/// 78 ms early.
const LATE_S: f64 = 0.01;

/// How a simulation's tires take more load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Loads {
    /// Their stiffness grows less than it, as that of all tires.
    AsOfCars,
    /// In proportion, which is usual in simulations: braking turns the car in, and turns do not soften its axles.
    InProportion,
}

/// A car whose stiffness is in proportion to the load is believed where it leaves this share of what the usual one leaves.
/// Tuned by `beside_a_single_track`: without it a speed that is 60 ms early stood for what braking does to that model.
const CLEARLY_LESS: f64 = 0.8;

/// Puts stiffness in proportion to the load into a car's load transfer, and lets the search have it otherwise.
fn put_in_proportion(model: &mut Model<'_>) {
    for chosen in model.effects.iter_mut().filter(|chosen| !chosen.free.is_empty()) {
        if let Some(place) = chosen.kind.place_of(SENSITIVITY).filter(|place| !chosen.free.contains(place)) {
            chosen.numbers[place] = 0.0;
            chosen.free.push(place);
        }
    }
}

/// The number of a load transfer that says how much less than the load stiffness grows.
const SENSITIVITY: &str = "load_sensitivity";

/// The ordinary car that drives like a simulation.
struct Emulation<'a> {
    vehicle: &'a Vehicle,
    car: FreeFit<'a>,
    /// What is free of it, with what is thought of real cars' numbers.
    thought: Vec<Free>,
    /// How much of the simulation it gives, %.
    fits: ByChannel,
}

impl<'a> Emulation<'a> {
    fn of(vehicle: &'a Vehicle, effects: &[EffectConfig], simulated: &[FreeDrive], loads: Loads) -> Self {
        let [mut model, ..] = with_ordinary(&as_configured(vehicle, effects));
        if loads == Loads::InProportion {
            put_in_proportion(&mut model);
        }
        let thought = free(&model, vehicle, simulated);
        let in_it = |free: &Free| match free.number {
            Number::Of(Place::Effect(effect, number)) if model.effects[effect].is(number, SENSITIVITY) => {
                Free { prior: (0.0, KEPT), ..*free }
            }
            _ => lacking(free),
        };
        let car = fit(&model, thought.iter().map(in_it).collect(), simulated);
        let fits = fits(simulated, &car.predicted).train;
        Self { vehicle, car, thought, fits }
    }

    /// How much of its yaw rate, %.
    fn given(&self) -> f64 {
        self.fits.get(Quantity::YawRate.name()).copied().unwrap_or(f64::NAN)
    }

    /// Its numbers of the car as they are; the zeros of the recording's own sensors free, from those that made the car drive
    /// like the simulation.
    fn kept(&self) -> Vec<Free> {
        let of = |(free, at): (&Free, &f64)| match free.of {
            Scope::Car => Free {
                prior: (*at, 0.1 * KEPT),
                bounds: (at - KEPT, at + KEPT),
                step: free.step.min(0.5 * KEPT),
                ..*free
            },
            // Zeros are free; how late something is, and by how much it reads too much, is a candidate like every other.
            _ => Free { prior: (*at, free.prior.1.min(known(free))), ..*free },
        };
        self.car.free.iter().zip(&self.car.at).map(of).collect()
    }

    /// What it says of a drive.
    fn says(&self, drive: &FreeDrive) -> Predicted {
        let (model, sensing) = placed(&self.car.model, &self.car.free, &self.car.at, 0);
        run(drive, &model.car(), sensing, Compute::Readings)
    }
}

/// How well delays and scales of the recording are known before they are searched: to the step of a message, and to half a
/// per cent.
fn known(free: &Free) -> f64 {
    match free.number {
        Number::SpeedDelay | Number::SpeedScale | Number::Of(Place::Delay(_)) => 0.005,
        _ => f64::INFINITY,
    }
}

/// What the car that drives like a simulation lacks of it.
struct Lacks(Compared);

impl Lacks {
    fn of(known: &Compared, says: &Predicted, vehicle: &Vehicle) -> Self {
        let axle = |axle: usize| {
            let says = turning(vehicle, axle, &says.wheels[2 * axle], &says.wheels[2 * axle + 1]);
            known.axles[axle].as_ref().map(|known| minus(known, &says))
        };
        Self(Compared {
            yaw_rate: minus(&known.yaw_rate, &says.yaw_rate),
            lateral: known.lateral.as_ref().map(|known| minus(known, &says.lateral)),
            longitudinal: None,
            wheels: Default::default(),
            axles: [axle(0), axle(1)],
        })
    }

    /// A drive without it.
    fn taken(&self, drive: &FreeDrive) -> FreeDrive {
        let both = |of: &Option<Vec<f64>>, lacks: &Option<Vec<f64>>| {
            of.as_ref().zip(lacks.as_ref()).map(|(of, lacks)| minus(of, lacks))
        };
        let mut taken = drive.clone();
        taken.yaw_rate = minus(&drive.yaw_rate, &self.0.yaw_rate);
        taken.lateral = both(&drive.lateral, &self.0.lateral);
        taken.axles = std::array::from_fn(|axle| both(&drive.axles[axle], &self.0.axles[axle]));
        taken
    }

    /// What a car says, with it.
    fn given(&self, said: &Predicted) -> Predicted {
        let mut given = said.clone();
        add(&mut given.yaw_rate, &self.0.yaw_rate);
        if let Some(lateral) = &self.0.lateral {
            add(&mut given.lateral, lateral);
        }
        given
    }
}

/// Point by point.
fn minus(of: &[f64], what: &[f64]) -> Vec<f64> {
    of.iter().zip(what).map(|(of, what)| of - what).collect()
}

/// Point by point.
fn add(to: &mut [f64], what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(to, what)| *to += what);
}
