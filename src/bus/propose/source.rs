//! Where a value comes from in a database: a signal, with the parts it is made of.

use super::vocabulary::Spoken;
use super::words::Words;
use crate::dbc::{Database, Message, Signal, ValueKind};
use crate::signals::{UnitError, to_si};
use physics::Quantity;

/// A wheel radius to compare speeds of circumferences with those of turning, m: any car's, to 15 %.
pub(super) const RADIUS_M: f64 = 0.31;

/// A signal by its place: message and signal in the database.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Place {
    /// Place of the message in [`Database::messages`].
    pub message: usize,
    /// Place of the signal in [`Message::signals`].
    pub signal: usize,
}

impl Place {
    /// All signals, in file order.
    pub(super) fn all(database: &Database) -> impl Iterator<Item = Place> {
        database.messages().iter().enumerate().flat_map(|(message, content)| {
            (0..content.signals.len()).map(move |signal| Place { message, signal })
        })
    }

    /// The message and the signal; `None` only for a place of another database.
    pub(super) fn find(self, database: &Database) -> Option<(&Message, &Signal)> {
        let message = database.messages().get(self.message)?;
        Some((message, message.signals.get(self.signal)?))
    }

    /// The place of `MESSAGE.Signal`, if the database has one of that name.
    pub fn of(database: &Database, name: &str) -> Option<Self> {
        Self::all(database).find(|place| place.name(database) == name)
    }

    /// `MESSAGE.Signal`.
    pub fn name(self, database: &Database) -> String {
        self.find(database)
            .map(|(message, signal)| format!("{}.{}", message.name, signal.name))
            .unwrap_or_default()
    }

    /// What is said of it.
    pub(super) fn spoken(self, database: &Database) -> Option<Spoken> {
        let (message, signal) = self.find(database)?;
        Some(Spoken {
            signal: Words::of(&signal.name),
            comment: Words::of(&signal.comment),
            message: Words::of(&message.name),
        })
    }
}

/// A signal's unit, for a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Unit {
    /// The file has it: SI per unit.
    Known(f64),
    /// The file has none; the range or the data suggest one: SI per unit and the unit.
    Guessed(f64, &'static str),
    /// There is none, or none that is known.
    Unknown,
    /// It measures something else.
    Unfitting,
}

impl Unit {
    /// Of a signal as a quantity.
    pub(super) fn of(quantity: Quantity, signal: &Signal) -> Self {
        match to_si(quantity, &signal.unit, RADIUS_M) {
            Ok(to_si) => Self::Known(to_si),
            Err(UnitError::Missing { .. }) => Self::by_range(quantity, signal),
            Err(UnitError::Unknown { .. }) => Self::Unknown,
            Err(UnitError::Unfitting { .. }) => Self::Unfitting,
        }
    }

    /// A yaw rate that can be 100 is not one in rad/s.
    fn by_range(quantity: Quantity, signal: &Signal) -> Self {
        let most = greatest(signal);
        let unit = match quantity {
            Quantity::YawRate if (20.0..2000.0).contains(&most) => "deg/s",
            Quantity::YawRate if (1.0..12.0).contains(&most) => "rad/s",
            Quantity::SteeringWheelAngle if (100.0..10_000.0).contains(&most) => "deg",
            Quantity::SteeringWheelAngle if (5.0..40.0).contains(&most) => "rad",
            Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration => match most {
                m if (8.0..100.0).contains(&m) => "m/s^2",
                m if (1.0..5.0).contains(&m) => "g",
                _ => return Self::Unknown,
            },
            _ => return Self::Unknown,
        };
        Self::guessed(quantity, unit)
    }

    /// This unit.
    pub(super) fn guessed(quantity: Quantity, unit: &'static str) -> Self {
        to_si(quantity, unit, RADIUS_M).map_or(Self::Unknown, |to_si| Self::Guessed(to_si, unit))
    }

    /// SI per unit, if it is known or guessed.
    pub(super) fn to_si(&self) -> Option<f64> {
        match self {
            Self::Known(to_si) | Self::Guessed(to_si, _) => Some(*to_si),
            Self::Unknown | Self::Unfitting => None,
        }
    }
}

/// The largest amount that the bits can carry, in the file's unit.
pub(super) fn greatest(signal: &Signal) -> f64 {
    let (low, high) = signal.codec().range();
    low.abs().max(high.abs())
}

/// Can a number that varies be in it?
pub(super) fn is_number(signal: &Signal) -> bool {
    let float = matches!(signal.codec().kind, ValueKind::Float32 | ValueKind::Float64);
    float || (6..=32).contains(&signal.size)
}

/// Is it one for flags?
pub(super) fn is_flag(quantity: Quantity) -> bool {
    matches!(quantity, Quantity::BrakeActive | Quantity::AbsActive)
}
