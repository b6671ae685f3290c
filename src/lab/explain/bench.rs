//! A drive of the project's own simulator, for the unit tests of explain. (tests/concealed has a simulator of its
//! own.)

use super::candidates::library;
use super::case::Case;
use super::fit::{Data, Fit, Learn};
use super::model::Model;
use super::naming::{Refitted, refit, scan};
use super::split::{Part, Split};
use physics::model::effect::{KINDS, Kind};
use physics::model::{Scenario, Uncertain, Vehicle};
use predict::noise::Noise;
use predict::{GriddedDrive, Recording, Torque};

/// Steering, driving and braking, for forty-five seconds.
const DRIVE: &str = include_str!("../../../tests/data/steered.toml");

/// The recording of that drive with effects (TOML), and what a user knows of the car.
pub fn recorded(effects: &str) -> (Vehicle, Recording) {
    recorded_as(effects, |_| {})
}

/// The same with something else about the scenario.
pub fn recorded_as(effects: &str, change: impl FnOnce(&mut Scenario)) -> (Vehicle, Recording) {
    let mut scenario = Scenario::parse(&format!("{DRIVE}\n{effects}")).unwrap();
    change(&mut scenario);
    let recording = Recording::simulated("bench", &scenario).unwrap();
    let mut vehicle = scenario.vehicle.clone();
    vehicle.mass_kg = Uncertain { value: 1560.0, std: 60.0 };
    vehicle.yaw_inertia_kgm2 = Some(Uncertain { value: 2450.0, std: 200.0 });
    vehicle.lateral_stiffness_front = Uncertain { value: 12.0, std: 1.5 };
    vehicle.lateral_stiffness_rear = Uncertain { value: 13.0, std: 1.5 };
    vehicle.longitudinal_stiffness = Uncertain { value: 28.0, std: 4.0 };
    (vehicle, recording)
}

/// The question what is missing in recordings of a car, of the whole library.
pub fn case<'a>(vehicle: &'a Vehicle, recordings: &'a [Recording]) -> Case<'a> {
    Case {
        vehicle,
        effects: &[],
        recordings,
        references: 0,
        in_order: false,
        held_out: 0,
        chain: &[],
        library: KINDS,
        seed: 1,
    }
}

/// The training part of drives.
pub fn training(drives: &[GriddedDrive]) -> Data<'_> {
    Data {
        drives,
        split: Split::new(drives, 0),
        part: Part::Train,
        own_noise: Noise::first(drives),
        share: 1.0,
    }
}

/// The plain model, fitted.
pub fn fitted<'a>(data: &Data<'_>, vehicle: &'a Vehicle) -> Fit<'a> {
    let plain = Model::plain(vehicle, Torque::Recorded);
    data.fit(&plain, &plain.ordinary(|_| true), &data.own_noise, 6)
}

/// What a drive with effects (TOML) says of a kind, which could have begun at certain moments, s: the candidate fitted with all
/// that is ordinary, beside the plain model without it.
pub fn refitted<T>(
    effects: &str,
    kind: &'static Kind,
    onsets: &[f64],
    then: impl for<'a> FnOnce(&Data<'_>, &Fit<'a>, Refitted<'a>) -> T,
) -> T {
    each_refitted(effects, &[kind], onsets, |data, plain, mut all| then(data, plain, all.remove(0)))
}

/// The same of several kinds, each alone.
pub fn each_refitted<T>(
    effects: &str,
    kinds: &[&'static Kind],
    onsets: &[f64],
    then: impl for<'a> FnOnce(&Data<'_>, &Fit<'a>, Vec<Refitted<'a>>) -> T,
) -> T {
    let (vehicle, recording) = recorded(effects);
    let drives = [GriddedDrive::new(&recording, &vehicle)];
    let data = training(&drives);
    let plain = fitted(&data, &vehicle);
    let all = kinds.iter().map(|kind| {
        let scanned = scan(&data, &plain, &library(&[*kind], &plain.model, |_| true, onsets));
        refit(&data, &plain, (&plain, Learn::Noise), &scanned[0], 4)
    });
    then(&data, &plain, all.collect())
}
