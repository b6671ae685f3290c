//! The vehicle's parameters, as the `[vehicle]` table gives them.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Standard gravity as the thesis and all normalized quantities here use it, m/s².
pub const GRAVITY: f64 = 9.81;

/// A number that may be uncertain: `1700.0`, or `{ value = 1700.0, std = 100.0 }`.
///
/// Without a standard deviation it is taken as known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "UncertainToml", into = "UncertainToml")]
pub struct Uncertain {
    /// Best value.
    pub value: f64,
    /// Standard deviation of the prior, zero if known.
    pub std: f64,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(untagged, expecting = "a number or { value = …, std = … }")]
enum UncertainToml {
    Integer(i64),
    Known(f64),
    Prior(Prior),
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Prior {
    value: f64,
    #[serde(default)]
    std: f64,
}

impl From<UncertainToml> for Uncertain {
    fn from(toml: UncertainToml) -> Self {
        match toml {
            UncertainToml::Integer(value) => Self::known(value as f64),
            UncertainToml::Known(value) => Self::known(value),
            UncertainToml::Prior(Prior { value, std }) => Self { value, std },
        }
    }
}

impl From<Uncertain> for UncertainToml {
    fn from(u: Uncertain) -> Self {
        if u.std == 0.0 { Self::Known(u.value) } else { Self::Prior(Prior { value: u.value, std: u.std }) }
    }
}

impl Uncertain {
    /// A value without uncertainty.
    pub const fn known(value: f64) -> Self {
        Self { value, std: 0.0 }
    }
}

/// The axle (or both) that the drive torque goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DrivenAxle {
    /// Front-wheel drive.
    Front,
    /// Rear-wheel drive.
    Rear,
    /// All-wheel drive.
    All,
}

impl DrivenAxle {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Front, Self::Rear, Self::All];

    /// As a table has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Rear => "rear",
            Self::All => "all",
        }
    }

    /// The one of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|axle| axle.name() == name)
    }

    /// Is this wheel driven?
    pub const fn drives(self, wheel: crate::Wheel) -> bool {
        match self {
            Self::Front => wheel.is_front(),
            Self::Rear => !wheel.is_front(),
            Self::All => true,
        }
    }
}

/// The tire model of the plain vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TireKind {
    /// Force proportional to slip, unlimited.
    Linear,
    /// Proportional up to the friction, then constant (thesis 4.11, 4.14).
    #[default]
    Piecewise,
    /// Brush (thesis 4.12, 8.1).
    Brush,
    /// Magic formula (thesis 4.10).
    MagicFormula,
}

impl TireKind {
    /// As in a configuration.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Piecewise => "piecewise",
            Self::Brush => "brush",
            Self::MagicFormula => "magic_formula",
        }
    }
}

/// Names of tire property files: one for both axles, or the front axle's and the rear axle's.
///
/// Names only: nothing here opens files. Who reads a configuration reads them, and puts their numbers into the table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a file's name, or two: [\"front.tir\", \"rear.tir\"]")]
pub enum TireFiles {
    /// The same tires on both axles.
    Both(PathBuf),
    /// Front, rear.
    EachAxle([PathBuf; 2]),
}

impl TireFiles {
    /// Those of the front and the rear axle.
    pub fn axles(&self) -> [&PathBuf; 2] {
        match self {
            Self::Both(file) => [file, file],
            Self::EachAxle([front, rear]) => [front, rear],
        }
    }
}

/// The `[vehicle]` table. Keys carry their units; `config/demo.toml` explains each.
///
/// Only what differs from car to car beyond guessing is mandatory; the defaults of the rest are a
/// compact passenger car's and carry the standard deviation of not having been told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vehicle {
    /// Mass with driver and load, kg.
    pub mass_kg: Uncertain,
    /// Distance between the axles, m.
    pub wheelbase_m: Uncertain,
    /// Distance from the centre of gravity to the front axle, m.
    pub cg_to_front_m: Uncertain,
    /// Effective rolling radius, m.
    pub wheel_radius_m: Uncertain,
    /// Steering wheel angle / road wheel angle.
    pub steering_ratio: Uncertain,
    /// Which wheels are driven.
    pub driven_axle: DrivenAxle,
    /// Yaw inertia, kg m². Default: m a b, the value for which front and rear bounce independently.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_inertia_kgm2: Option<Uncertain>,
    /// Track width of the front axle, m.
    #[serde(default = "default_track")]
    pub track_front_m: Uncertain,
    /// Track width of the rear axle, m.
    #[serde(default = "default_track")]
    pub track_rear_m: Uncertain,
    /// Height of the centre of gravity, m.
    #[serde(default = "default_cg_height")]
    pub cg_height_m: Uncertain,
    /// Inertia of one wheel with its share of the drive line, kg m².
    #[serde(default = "default_wheel_inertia")]
    pub wheel_inertia_kgm2: Uncertain,
    /// Axle torque per unit of the `drive_torque` signal.
    #[serde(default = "default_one")]
    pub drive_torque_ratio: Uncertain,
    /// Brake torque of one front wheel per bar of brake pressure, N m/bar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brake_torque_per_bar_front_nm: Option<Uncertain>,
    /// Brake torque of one rear wheel per bar of brake pressure, N m/bar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brake_torque_per_bar_rear_nm: Option<Uncertain>,
    /// Air drag C_AIR: force / speed², kg/m.
    #[serde(default = "default_zero")]
    pub drag_coefficient_kg_per_m: Uncertain,
    /// Rolling resistance: force / load.
    #[serde(default = "default_zero")]
    pub rolling_resistance: Uncertain,
    /// Tire property files that give what the table leaves out of the tires; gone when they have been read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tire_file: Option<TireFiles>,
    /// Tire model.
    #[serde(default)]
    pub tire: TireKind,
    /// Friction of the surface, used by the saturating tire models.
    #[serde(default = "default_one")]
    pub friction: Uncertain,
    /// Shape factor C of the magic formula.
    #[serde(default = "default_shape")]
    pub magic_formula_shape: Uncertain,
    /// Curvature factor E of the magic formula.
    #[serde(default = "default_zero")]
    pub magic_formula_curvature: Uncertain,
    /// Front cornering stiffness of the axle / its static load, 1/rad.
    #[serde(default = "default_lateral")]
    pub lateral_stiffness_front: Uncertain,
    /// Rear cornering stiffness of the axle / its static load, 1/rad.
    #[serde(default = "default_lateral")]
    pub lateral_stiffness_rear: Uncertain,
    /// Longitudinal stiffness of a wheel / (m g / 4), per unit slip.
    #[serde(default = "default_longitudinal")]
    pub longitudinal_stiffness: Uncertain,
}

fn default_track() -> Uncertain {
    Uncertain { value: 1.52, std: 0.05 }
}
fn default_cg_height() -> Uncertain {
    Uncertain { value: 0.55, std: 0.08 }
}
fn default_wheel_inertia() -> Uncertain {
    Uncertain { value: 1.2, std: 0.4 }
}
fn default_one() -> Uncertain {
    Uncertain::known(1.0)
}
fn default_zero() -> Uncertain {
    Uncertain::known(0.0)
}
fn default_shape() -> Uncertain {
    Uncertain::known(1.3)
}
fn default_lateral() -> Uncertain {
    Uncertain { value: 12.0, std: 4.0 }
}
fn default_longitudinal() -> Uncertain {
    Uncertain { value: 30.0, std: 15.0 }
}

/// A `[vehicle]` value that cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("vehicle.{key} = {value}: {reason}")]
pub struct VehicleError {
    /// The key.
    pub key: &'static str,
    /// Its value.
    pub value: f64,
    /// What would be accepted.
    pub reason: &'static str,
}

impl Vehicle {
    /// Beyond these, in whatever unit, numbers are typing errors, and squares of them no numbers any more.
    const LARGEST: f64 = 1e7;
    const SMALLEST: f64 = 1e-7;

    /// The common vehicle of the thesis's simulations (App. B; methods.md §9).
    pub fn thesis() -> Self {
        let known = Uncertain::known;
        Self {
            mass_kg: known(1700.0),
            wheelbase_m: known(3.0),
            cg_to_front_m: known(1.5),
            wheel_radius_m: known(0.31),
            steering_ratio: known(1.0),
            driven_axle: DrivenAxle::Front,
            yaw_inertia_kgm2: Some(known(1700.0)),
            track_front_m: known(1.5),
            track_rear_m: known(1.5),
            cg_height_m: known(0.55),
            wheel_inertia_kgm2: known(2.65),
            drive_torque_ratio: known(1.0),
            brake_torque_per_bar_front_nm: None,
            brake_torque_per_bar_rear_nm: None,
            drag_coefficient_kg_per_m: known(0.5),
            rolling_resistance: known(0.0),
            tire_file: None,
            tire: TireKind::Piecewise,
            friction: known(1.0),
            magic_formula_shape: known(1.3),
            magic_formula_curvature: known(0.0),
            lateral_stiffness_front: known(11.5),
            lateral_stiffness_rear: known(11.5),
            longitudinal_stiffness: known(50.0),
        }
    }

    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass_kg.value
    }

    /// Centre of gravity to front axle, m.
    pub fn a(&self) -> f64 {
        self.cg_to_front_m.value
    }

    /// Centre of gravity to rear axle, m.
    pub fn b(&self) -> f64 {
        self.wheelbase_m.value - self.cg_to_front_m.value
    }

    /// Yaw inertia, kg m².
    pub fn yaw_inertia(&self) -> f64 {
        self.yaw_inertia_kgm2.map_or(self.mass() * self.a() * self.b(), |j| j.value)
    }

    /// What the wheels' spinning adds to the yaw inertia, kg m²: in a turn that tightens the outer ones
    /// must gain speed and the inner ones lose it, as if their inertia / radius² sat where they touch the
    /// ground.
    pub fn spinning_inertia(&self) -> f64 {
        let radius = self.wheel_radius_m.value;
        let mass = self.wheel_inertia_kgm2.value / (radius * radius);
        let squares = self.track_front_m.value.powi(2) + self.track_rear_m.value.powi(2);
        0.5 * mass * squares
    }

    /// Static load of one front or one rear wheel, N.
    pub fn static_wheel_load(&self, front: bool) -> f64 {
        let lever = if front { self.b() } else { self.a() };
        0.5 * self.mass() * GRAVITY * lever / self.wheelbase_m.value
    }

    /// Cornering stiffness of one front or one rear wheel, N/rad.
    pub fn wheel_cornering_stiffness(&self, front: bool) -> f64 {
        let normalized = if front { self.lateral_stiffness_front } else { self.lateral_stiffness_rear };
        normalized.value * self.static_wheel_load(front)
    }

    /// Longitudinal stiffness of one wheel, N per unit slip.
    pub fn wheel_longitudinal_stiffness(&self) -> f64 {
        self.longitudinal_stiffness.value * self.mass() * GRAVITY / 4.0
    }

    /// Every named number, for validation, printing and (later) identification.
    pub fn parameters(&self) -> Vec<(&'static str, Uncertain)> {
        let mut all = vec![
            ("mass_kg", self.mass_kg),
            ("wheelbase_m", self.wheelbase_m),
            ("cg_to_front_m", self.cg_to_front_m),
            ("wheel_radius_m", self.wheel_radius_m),
            ("steering_ratio", self.steering_ratio),
            ("track_front_m", self.track_front_m),
            ("track_rear_m", self.track_rear_m),
            ("cg_height_m", self.cg_height_m),
            ("wheel_inertia_kgm2", self.wheel_inertia_kgm2),
            ("drive_torque_ratio", self.drive_torque_ratio),
            ("drag_coefficient_kg_per_m", self.drag_coefficient_kg_per_m),
            ("rolling_resistance", self.rolling_resistance),
            ("friction", self.friction),
            ("magic_formula_shape", self.magic_formula_shape),
            ("magic_formula_curvature", self.magic_formula_curvature),
            ("lateral_stiffness_front", self.lateral_stiffness_front),
            ("lateral_stiffness_rear", self.lateral_stiffness_rear),
            ("longitudinal_stiffness", self.longitudinal_stiffness),
        ];
        let optional = [
            ("yaw_inertia_kgm2", self.yaw_inertia_kgm2),
            ("brake_torque_per_bar_front_nm", self.brake_torque_per_bar_front_nm),
            ("brake_torque_per_bar_rear_nm", self.brake_torque_per_bar_rear_nm),
        ];
        all.extend(optional.into_iter().filter_map(|(name, value)| value.map(|v| (name, v))));
        all
    }

    /// Checks every value against what a road vehicle can be.
    ///
    /// # Errors
    /// The first value that cannot be, by key.
    pub fn validate(&self) -> Result<(), VehicleError> {
        for (key, u) in self.parameters() {
            let fail = |value, reason| Err(VehicleError { key, value, reason });
            if !u.value.is_finite() {
                return fail(u.value, "must be a finite number");
            }
            if !(u.std.is_finite() && u.std >= 0.0) {
                return fail(u.std, "std must be zero or positive");
            }
            let may_be_zero = matches!(key, "drag_coefficient_kg_per_m" | "rolling_resistance");
            let may_be_negative = matches!(key, "drive_torque_ratio" | "magic_formula_curvature");
            if u.value < 0.0 && !may_be_negative {
                return fail(u.value, "must not be negative");
            }
            if u.value.abs() > Self::LARGEST || u.std > Self::LARGEST {
                return fail(u.value.max(u.std), "must be less than 1e7: no vehicle has that");
            }
            if u.value != 0.0 && u.value.abs() < Self::SMALLEST {
                return fail(u.value, "must be more than 1e-7: no vehicle has that");
            }
            if u.value == 0.0 && !may_be_zero && key != "magic_formula_curvature" {
                return fail(u.value, "must not be zero");
            }
        }
        if self.magic_formula_shape.value > 2.0 {
            return Err(VehicleError {
                key: "magic_formula_shape",
                value: self.magic_formula_shape.value,
                reason: "must be at most 2: beyond it the force changes sign at large slip",
            });
        }
        if self.magic_formula_curvature.value > 1.0 {
            return Err(VehicleError {
                key: "magic_formula_curvature",
                value: self.magic_formula_curvature.value,
                reason: "must be at most 1: beyond it the force changes sign at large slip",
            });
        }
        if self.b() <= 0.0 {
            return Err(VehicleError {
                key: "cg_to_front_m",
                value: self.a(),
                reason: "must be less than wheelbase_m",
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thesis_stiffnesses_come_out_in_newtons() {
        let vehicle = Vehicle::thesis();
        assert!((vehicle.wheel_longitudinal_stiffness() - 2.08e5).abs() < 1e3);
        assert!((vehicle.wheel_cornering_stiffness(true) - 4.79e4).abs() < 1e2);
        assert_eq!(vehicle.validate(), Ok(()));
    }

    #[test]
    fn a_torque_without_ratio_is_refused() {
        let mut vehicle = Vehicle::thesis();
        vehicle.drive_torque_ratio = Uncertain::known(0.0);
        assert_eq!(vehicle.validate().map_err(|e| e.key), Err("drive_torque_ratio"));
    }

    #[test]
    fn a_radius_beyond_all_cars_is_refused() {
        for radius in [1e308, 1e-300] {
            let mut vehicle = Vehicle::thesis();
            vehicle.wheel_radius_m = Uncertain::known(radius);
            assert_eq!(vehicle.validate().map_err(|e| e.key), Err("wheel_radius_m"));
        }
    }

    #[test]
    fn a_rear_distance_that_is_not_there_is_refused() {
        let mut vehicle = Vehicle::thesis();
        vehicle.cg_to_front_m = Uncertain::known(3.0);
        assert_eq!(vehicle.validate().map_err(|e| e.key), Err("cg_to_front_m"));
    }
}
