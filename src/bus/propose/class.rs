//! Classes of cars: what a car is like of which nobody told more. Wide: two of three cars of a class are within.

use std::fmt;
use std::str::FromStr;

use physics::model::{DrivenAxle, Uncertain};

/// A class of cars.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CarClass {
    /// Small cars and those of the lower middle class.
    Compact,
    /// Saloons and estates.
    #[default]
    Midsize,
    /// Tall ones.
    Suv,
    /// Vans and minibuses, empty or loaded.
    Van,
    /// Race cars with an engine behind the driver.
    Race,
}

impl CarClass {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Compact, Self::Midsize, Self::Suv, Self::Van, Self::Race];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Compact => "compact",
            Self::Midsize => "midsize",
            Self::Suv => "suv",
            Self::Van => "van",
            Self::Race => "race",
        }
    }

    /// The axle that is driven in most of them.
    pub const fn driven(self) -> DrivenAxle {
        match self {
            Self::Race => DrivenAxle::Rear,
            _ => DrivenAxle::Front,
        }
    }

    /// Where the centre of gravity is, as a share of the wheelbase behind the front axle.
    pub(super) const fn balance(self, driven: DrivenAxle) -> Uncertain {
        match (self, driven) {
            (Self::Race, _) => about(0.57, 0.03),
            (Self::Van, _) => about(0.46, 0.07),
            (_, DrivenAxle::Rear) => about(0.49, 0.03),
            _ => about(0.43, 0.03),
        }
    }

    /// Yaw inertia over mass × both distances of the axles from the centre of gravity.
    pub(super) const fn inertia_share(self) -> Uncertain {
        match self {
            Self::Race => about(0.65, 0.15),
            _ => about(0.93, 0.14),
        }
    }

    /// What does not depend on anything else, by its key in `[vehicle]`.
    pub(super) const fn numbers(self) -> [(&'static str, Uncertain); 15] {
        // In the order of the keys below.
        let [m, l, track, height, radius, wheel, ratio, front, rear, drag, friction] = match self {
            Self::Compact => [
                about(1300.0, 150.0),
                about(2.58, 0.08),
                about(1.50, 0.04),
                about(0.52, 0.05),
                about(0.305, 0.015),
                about(1.0, 0.3),
                about(15.0, 1.8),
                about(12.0, 4.0),
                about(15.0, 5.0),
                about(0.40, 0.08),
                about(1.0, 0.2),
            ],
            Self::Midsize => [
                about(1600.0, 180.0),
                about(2.70, 0.09),
                about(1.55, 0.04),
                about(0.54, 0.05),
                about(0.32, 0.015),
                about(1.2, 0.4),
                about(15.5, 2.0),
                about(12.0, 4.0),
                about(15.0, 5.0),
                about(0.40, 0.08),
                about(1.0, 0.2),
            ],
            Self::Suv => [
                about(1750.0, 220.0),
                about(2.68, 0.09),
                about(1.58, 0.05),
                about(0.64, 0.06),
                about(0.345, 0.02),
                about(1.6, 0.5),
                about(16.0, 2.0),
                about(11.0, 4.0),
                about(13.0, 4.0),
                about(0.52, 0.1),
                about(1.0, 0.2),
            ],
            Self::Van => [
                about(2200.0, 400.0),
                about(3.20, 0.35),
                about(1.66, 0.08),
                about(0.75, 0.12),
                about(0.34, 0.02),
                about(1.8, 0.6),
                about(16.5, 2.5),
                about(10.0, 4.0),
                about(12.0, 4.0),
                about(0.80, 0.2),
                about(0.95, 0.2),
            ],
            Self::Race => [
                about(850.0, 200.0),
                about(2.80, 0.25),
                about(1.58, 0.08),
                about(0.30, 0.06),
                about(0.31, 0.02),
                about(1.0, 0.4),
                about(13.0, 3.5),
                about(25.0, 10.0),
                about(30.0, 12.0),
                about(0.90, 0.35),
                about(1.4, 0.3),
            ],
        };
        [
            ("mass_kg", m),
            ("wheelbase_m", l),
            ("track_front_m", track),
            ("track_rear_m", track),
            ("cg_height_m", height),
            ("wheel_radius_m", radius),
            ("wheel_inertia_kgm2", wheel),
            ("steering_ratio", ratio),
            ("lateral_stiffness_front", front),
            ("lateral_stiffness_rear", rear),
            ("longitudinal_stiffness", about(25.0, 10.0)),
            ("drag_coefficient_kg_per_m", drag),
            ("rolling_resistance", about(0.012, 0.004)),
            ("friction", friction),
            // The axle's torque, or that of an engine in front of gears that nobody knows.
            ("drive_torque_ratio", about(1.0, 0.5)),
        ]
    }
}

const fn about(value: f64, std: f64) -> Uncertain {
    Uncertain { value, std }
}

impl fmt::Display for CarClass {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for CarClass {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = || Self::ALL.map(Self::name).join(", ");
        Self::ALL
            .into_iter()
            .find(|class| class.name() == text)
            .ok_or_else(|| format!("there is no class `{text}`; the classes are {}", names()))
    }
}
