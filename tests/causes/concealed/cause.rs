//! The causes that can be hidden, and in which tires and drives.

use super::drive::Kind;

/// What sort of truth a recording has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    Control,
    Library,
    Everything,
    Unknown,
    Absorbable,
}

impl Sort {
    pub fn name(self) -> &'static str {
        match self {
            Sort::Control => "control",
            Sort::Library => "library",
            Sort::Everything => "everything",
            Sort::Unknown => "unknown",
            Sort::Absorbable => "absorbable",
        }
    }
}

/// Which tires a cause is hidden in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tires {
    Linear,
    Magic,
    Either,
}

/// One cause: the name of the answer (`effect` or `effect:channel`), where it is made, and its strength.
pub struct Cause {
    pub key: &'static str,
    pub sort: Sort,
    pub tires: Tires,
    pub drives: &'static [Kind],
}

const fn cause(key: &'static str, sort: Sort, tires: Tires, drives: &'static [Kind]) -> Cause {
    Cause { key, sort, tires, drives }
}

use Kind::{AccBrake, Hard, Highway, Mixed, Slalom};
use Sort::{Absorbable, Control, Everything, Library, Unknown};
use Tires::{Either, Linear, Magic};

const ANY: &[Kind] = &[Mixed, Highway, Slalom, AccBrake, Hard];
const TURNS: &[Kind] = &[Mixed, Slalom];
const FEET: &[Kind] = &[Mixed, AccBrake];

/// All causes.
pub const CAUSES: &[Cause] = &[
    cause("control", Control, Either, ANY),
    cause("load_transfer", Library, Either, &[Mixed, Slalom, Hard]),
    cause("body_roll", Library, Either, &[Mixed, Slalom, Highway]),
    cause("roll_steer", Library, Either, TURNS),
    cause("road_bank", Library, Either, &[Mixed, Highway]),
    cause("road_grade", Library, Either, &[Mixed, Highway]),
    cause("air_drag", Library, Either, &[Mixed, Highway, AccBrake]),
    cause("rolling_resistance", Library, Either, &[Mixed, Highway, AccBrake]),
    cause("relaxation_length", Library, Either, TURNS),
    cause("steering_lag", Library, Either, &[Mixed, Slalom, Highway]),
    cause("steering_compliance", Library, Magic, &[Hard]),
    cause("steering_ratio", Library, Either, TURNS),
    cause("rear_steer", Library, Either, &[Mixed]),
    cause("sensor_delay:yaw_rate", Library, Either, &[Mixed, Slalom, Highway]),
    cause("sensor_delay:lateral_acceleration", Library, Either, TURNS),
    cause("sensor_delay:longitudinal_acceleration", Library, Either, FEET),
    cause("sensor_delay:steering_wheel_angle", Library, Either, TURNS),
    cause("sensor_scale:yaw_rate", Library, Either, &[Mixed, Slalom]),
    cause("sensor_scale:lateral_acceleration", Library, Either, TURNS),
    cause("sensor_scale:longitudinal_acceleration", Library, Either, FEET),
    cause("sensor_drift:yaw_rate", Library, Either, ANY),
    cause("sensor_drift:lateral_acceleration", Library, Either, ANY),
    cause("sensor_drift:steering_wheel_angle", Library, Either, ANY),
    cause("sensor_bias:yaw_rate", Library, Either, ANY),
    cause("sensor_bias:lateral_acceleration", Library, Either, ANY),
    cause("sensor_bias:longitudinal_acceleration", Library, Either, ANY),
    cause("sensor_bias:steering_wheel_angle", Library, Either, ANY),
    cause("sensor_sign:yaw_rate", Library, Either, ANY),
    cause("sensor_sign:lateral_acceleration", Library, Either, ANY),
    cause("sensor_sign:longitudinal_acceleration", Library, Either, FEET),
    cause("sensor_sign:steering_wheel_angle", Library, Either, ANY),
    cause("channel_swap", Library, Either, &[Mixed, Slalom]),
    cause("tire_radius", Library, Either, ANY),
    cause("radius_growth", Library, Either, FEET),
    cause("cg_shift", Library, Either, TURNS),
    cause("payload", Library, Either, FEET),
    cause("friction_change", Library, Either, &[Slalom, Hard]),
    cause("friction_split", Library, Either, &[Mixed, Slalom]),
    cause("tire_saturation", Library, Linear, &[Hard]),
    cause("combined_slip", Library, Either, &[Mixed, Hard]),
    cause("surface_stiffness", Library, Either, &[Mixed, Slalom]),
    cause("brake_yaw_moment", Library, Either, &[Mixed, Highway]),
    cause("brake_imbalance", Library, Either, FEET),
    cause("accelerometer_position", Library, Either, TURNS),
    cause("crosswind", Library, Either, &[Mixed, Highway]),
    cause("wheel_alignment", Library, Either, &[Mixed, Hard]),
    cause("everything", Everything, Magic, &[Mixed, Slalom, Hard]),
    cause("freeplay", Unknown, Either, &[Mixed, Highway]),
    cause("slosh", Unknown, Either, TURNS),
    cause("shimmy", Unknown, Either, &[Mixed, Highway]),
    cause("brake_judder", Unknown, Either, FEET),
    cause("differential_lock", Unknown, Either, TURNS),
    cause("sensor_clip", Unknown, Either, TURNS),
    cause("torque_limit", Unknown, Either, FEET),
    cause("payload_within_doubt", Absorbable, Either, ANY),
    cause("radius_within_doubt", Absorbable, Either, ANY),
];

impl Cause {
    pub fn find(key: &str) -> &'static Cause {
        CAUSES.iter().find(|c| c.key == key).unwrap_or_else(|| panic!("no cause named {key}"))
    }

    /// Whether it can be stronger or weaker.
    pub fn has_strength(&self) -> bool {
        !matches!(self.sort, Control | Absorbable) && !matches!(self.effect(), "sensor_sign" | "channel_swap")
    }

    /// The effect's name without its channel.
    pub fn effect(&self) -> &'static str {
        self.key.split(':').next().unwrap_or(self.key)
    }
}
