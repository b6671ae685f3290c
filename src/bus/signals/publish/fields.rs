//! What is published: every message and signal by name, and where in the estimates its value is.

use physics::Estimates;
use physics::estimates::{Estimate, MuSource, State};

/// A message of the published interface.
pub(super) struct MessageFields {
    pub name: &'static str,
    pub fields: &'static [Field],
}

/// A signal of the published interface.
pub(super) struct Field {
    pub name: &'static str,
    pub quantity: Quantity,
    pub source: Source,
}

/// What a number measures; tells which units a DBC may give it in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// No dimension.
    Ratio,
    /// Seconds.
    Time,
    /// Metres per second.
    Speed,
    /// Radians.
    Angle,
    /// One per radian.
    PerAngle,
}

/// Where a value comes from and what becomes of one that does not fit.
#[derive(Clone, Copy)]
pub(super) enum Source {
    /// Absent, not finite or beyond what the bits can carry: not available.
    Number(fn(&Estimates) -> Option<f64>),
    /// An age: as a number, but the highest code stands for that or older.
    Age(fn(&Estimates) -> Option<f64>),
    /// A count that is always known: the highest code stands for that or more.
    Count(fn(&Estimates) -> u64),
    /// Leave to act upon the named signals of the same message; withheld while one of them is not
    /// available.
    Flag(fn(&Estimates) -> bool, Needs),
    /// One of the names that the signal's value table must have.
    Choice(&'static [&'static str], fn(&Estimates) -> usize),
    /// A bit field.
    Bits(fn(&Estimates) -> u64),
}

/// What a flag vouches for.
#[derive(Clone, Copy)]
pub(super) enum Needs {
    /// All of these signals.
    All(&'static [&'static str]),
    /// At least one of these signals.
    Any(&'static [&'static str]),
}

impl Quantity {
    /// Factor from SI to a DBC's unit; `None` if the unit is not one of this quantity. No unit means SI.
    pub fn factor_to(self, unit: &str) -> Option<f64> {
        let degrees = 180.0 / std::f64::consts::PI;
        Some(match (self, unit.trim()) {
            (_, "") => 1.0,
            (Self::Ratio, "-" | "1") => 1.0,
            (Self::Ratio, "%") => 100.0,
            (Self::Time, "s") => 1.0,
            (Self::Time, "ms") => 1000.0,
            (Self::Speed, "m/s") => 1.0,
            (Self::Speed, "km/h") => 3.6,
            (Self::Speed, "mph") => 1.0 / 0.44704,
            (Self::Angle, "rad") => 1.0,
            (Self::Angle, "deg" | "°") => degrees,
            (Self::PerAngle, "1/rad") => 1.0,
            (Self::PerAngle, "1/deg" | "1/°") => 1.0 / degrees,
            _ => return None,
        })
    }

    /// The units that [`Quantity::factor_to`] knows, for messages.
    pub fn units(self) -> &'static str {
        match self {
            Self::Ratio => "none or %",
            Self::Time => "s or ms",
            Self::Speed => "m/s, km/h or mph",
            Self::Angle => "rad or deg",
            Self::PerAngle => "1/rad or 1/deg",
        }
    }
}

use Quantity::{Angle, PerAngle, Ratio, Speed, Time};

const fn field(name: &'static str, quantity: Quantity, source: Source) -> Field {
    Field { name, quantity, source }
}

const fn number(name: &'static str, quantity: Quantity, value: fn(&Estimates) -> Option<f64>) -> Field {
    field(name, quantity, Source::Number(value))
}

const SOURCES: [&str; 7] = {
    let [none, bound, map, brush, joint, abs, limit] = MuSource::ALL;
    [none.name(), bound.name(), map.name(), brush.name(), joint.name(), abs.name(), limit.name()]
};

const STATES: [&str; 4] = {
    let [starting, running, degraded, no_input] = State::ALL;
    [starting.name(), running.name(), degraded.name(), no_input.name()]
};

fn value(estimate: Option<Estimate>) -> Option<f64> {
    estimate.map(|e| e.value)
}

/// The greatest of a number of those estimates that there are; not a number wins over all.
fn greatest(estimates: &[Option<Estimate>], of: fn(&Estimate) -> f64) -> Option<f64> {
    let greater = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    estimates.iter().flatten().map(of).reduce(greater)
}

/// The published interface, in the order the frames are sent.
pub(super) const MESSAGES: [MessageFields; 7] = [
    MessageFields {
        name: "GRIP_FRICTION",
        fields: &[
            number("MuMax", Ratio, |e| e.friction.max),
            number("MuMaxLow", Ratio, |e| e.friction.low),
            number("MuMaxHigh", Ratio, |e| e.friction.high),
            number("MuUsed", Ratio, |e| e.friction.used),
            field("MuSource", Ratio, Source::Choice(&SOURCES, |e| e.friction.source as usize)),
            field("MuValid", Ratio, Source::Flag(|e| e.friction.valid, Needs::All(&["MuMax"]))),
            field("MuAge", Time, Source::Age(|e| e.friction.age_s)),
        ],
    },
    MessageFields {
        name: "GRIP_STIFFNESS_LONG",
        fields: &[
            number("SlopeFL", Ratio, |e| value(e.slope[0])),
            number("SlopeFR", Ratio, |e| value(e.slope[1])),
            number("SlopeRL", Ratio, |e| value(e.slope[2])),
            number("SlopeRR", Ratio, |e| value(e.slope[3])),
            number("SlopeStd", Ratio, |e| greatest(&e.slope, |s| s.std)),
            field(
                "SlopeValid",
                Ratio,
                Source::Flag(|e| e.slope_valid, Needs::Any(&["SlopeFL", "SlopeFR", "SlopeRL", "SlopeRR"])),
            ),
        ],
    },
    MessageFields {
        name: "GRIP_SLIP_OFFSET",
        fields: &[
            number("OffsetFL", Ratio, |e| value(e.slip_offset[0])),
            number("OffsetFR", Ratio, |e| value(e.slip_offset[1])),
            number("OffsetRL", Ratio, |e| value(e.slip_offset[2])),
            number("OffsetRR", Ratio, |e| value(e.slip_offset[3])),
            number("OffsetStd", Ratio, |e| greatest(&e.slip_offset, |s| s.std)),
            field("SlopeAge", Time, Source::Age(|e| greatest(&e.slope, |s| s.age_s))),
        ],
    },
    MessageFields {
        name: "GRIP_STIFFNESS_LAT",
        fields: &[
            number("CorneringFront", PerAngle, |e| value(e.cornering[0])),
            number("CorneringRear", PerAngle, |e| value(e.cornering[1])),
            number("CorneringStdFront", PerAngle, |e| e.cornering[0].map(|c| c.std)),
            number("CorneringStdRear", PerAngle, |e| e.cornering[1].map(|c| c.std)),
            field(
                "CorneringValid",
                Ratio,
                Source::Flag(|e| e.cornering_valid, Needs::All(&["CorneringFront", "CorneringRear"])),
            ),
            field("CorneringAge", Time, Source::Age(|e| greatest(&e.cornering, |c| c.age_s))),
        ],
    },
    MessageFields {
        name: "GRIP_MOTION",
        fields: &[
            number("Speed", Speed, |e| e.motion.speed),
            number("LateralVelocity", Speed, |e| e.motion.lateral_velocity),
            number("Sideslip", Angle, |e| e.motion.sideslip),
            number("SlipAngleFront", Angle, |e| e.motion.slip_angle_front),
            number("SlipAngleRear", Angle, |e| e.motion.slip_angle_rear),
            field(
                "MotionValid",
                Ratio,
                Source::Flag(|e| e.motion.valid, Needs::All(&["Speed", "LateralVelocity", "Sideslip"])),
            ),
        ],
    },
    MessageFields {
        name: "GRIP_STATUS",
        fields: &[
            field("State", Ratio, Source::Choice(&STATES, |e| e.state as usize)),
            number("ExcitationLong", Ratio, |e| Some(e.excitation_long)),
            number("ExcitationLat", Ratio, |e| Some(e.excitation_lat)),
            field("SurfaceChanges", Ratio, Source::Count(|e| u64::from(e.surface_changes))),
            field("Faults", Ratio, Source::Bits(|e| u64::from(e.faults.bits() & 0xFFFF))),
            field("DroppedFrames", Ratio, Source::Count(|e| e.dropped_frames)),
        ],
    },
    MessageFields {
        name: "GRIP_STATUS_2",
        fields: &[field("Faults", Ratio, Source::Bits(|e| u64::from(e.faults.bits() >> 16)))],
    },
];
