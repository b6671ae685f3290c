//! One published signal, compiled: from a value to the bits that go on the bus.

use super::PublishProblem as Problem;
use super::fields::{Field, Source};
use crate::dbc::{Codec, Message, Signal, ValueKind};
use physics::Estimates;

/// The name in the value tables of the code that stands for no value.
pub(super) const NOT_AVAILABLE: &str = "not_available";

/// How a signal's bits come about.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    pub codec: Codec,
    coding: Coding,
}

#[derive(Clone, Debug)]
enum Coding {
    Number { value: fn(&Estimates) -> Option<f64>, factor: f64, not_available: u64, last: Option<Last> },
    Count { value: fn(&Estimates) -> u64, last: Last },
    Flag { value: fn(&Estimates) -> bool },
    Choice { index: fn(&Estimates) -> usize, codes: Vec<u64> },
    Bits { value: fn(&Estimates) -> u64 },
}

/// The code that stands for its value or more.
#[derive(Clone, Copy, Debug)]
struct Last {
    bits: u64,
    value: f64,
}

impl Slot {
    /// Fits a field of the interface to a signal of the output DBC.
    ///
    /// # Errors
    /// If the signal cannot carry the field honestly.
    pub fn new(message: &Message, signal: &Signal, field: &Field) -> Result<Self, Problem> {
        let codec = signal.codec();
        let fail = |reason: String| Problem::Signal {
            place: format!("{}:{}", message.file, signal.line),
            signal: format!("{}.{}", message.name, signal.name),
            reason,
        };
        if !signal.mux().is_always() {
            return Err(fail("is multiplexed; published signals must be in every frame".to_owned()));
        }
        let is_float = matches!(codec.kind, ValueKind::Float32 | ValueKind::Float64);
        let factor = || {
            field.quantity.factor_to(&signal.unit).ok_or_else(|| {
                fail(format!("has the unit `{}`; understood are {}", signal.unit, field.quantity.units()))
            })
        };
        let not_available = || match signal.value_named(NOT_AVAILABLE) {
            Some(code) => Ok(code),
            None if is_float => Ok(not_a_number(codec.kind)),
            None => {
                let name = NOT_AVAILABLE;
                Err(fail(format!("has no code for a missing value; add a VAL_ entry named `{name}`")))
            }
        };
        let integer = |coding| {
            if is_float {
                Err(fail("is a float, but carries no number; make it an integer".to_owned()))
            } else {
                Ok(coding)
            }
        };
        let coding = match field.source {
            Source::Number(value) => {
                let not_available = not_available()?;
                Coding::Number { value, factor: factor()?, not_available, last: None }
            }
            Source::Age(value) => {
                let last = if is_float { None } else { Some(last_code(signal)) };
                Coding::Number { value, factor: factor()?, not_available: not_available()?, last }
            }
            Source::Count(value) => integer(Coding::Count { value, last: last_code(signal) })?,
            Source::Flag(value, _) => integer(Coding::Flag { value })?,
            Source::Bits(value) => integer(Coding::Bits { value })?,
            Source::Choice(names, index) => {
                let code = |name: &&str| {
                    signal.value_named(name).ok_or_else(|| {
                        fail(format!("has no code for `{name}`; add a VAL_ entry of this name"))
                    })
                };
                let codes = names.iter().map(code).collect::<Result<Vec<_>, _>>()?;
                integer(Coding::Choice { index, codes })?
            }
        };
        if matches!(field.source, Source::Bits(_)) && signal.size < 16 {
            return Err(fail(format!("has {} bits; the bit field needs 16", signal.size)));
        }
        Ok(Self { codec, coding })
    }

    /// The bits to send, and whether they stand for a value.
    #[inline]
    pub fn bits(&self, estimates: &Estimates) -> (u64, bool) {
        match &self.coding {
            Coding::Number { value, factor, not_available, last } => {
                let bits = value(estimates).and_then(|v| self.number(v * factor, *last));
                match bits {
                    Some(bits) if bits != *not_available => (bits, true),
                    _ => (*not_available, false),
                }
            }
            Coding::Count { value, last } => {
                let value = value(estimates) as f64;
                let fits = value < last.value;
                let bits = if fits { self.codec.bits_from_physical(value).ok() } else { None };
                (bits.unwrap_or(last.bits), true)
            }
            Coding::Flag { value } => (u64::from(value(estimates)), true),
            Coding::Choice { index, codes } => {
                (codes.get(index(estimates)).copied().unwrap_or_default(), true)
            }
            Coding::Bits { value } => (value(estimates), true),
        }
    }

    #[inline]
    fn number(&self, value: f64, last: Option<Last>) -> Option<u64> {
        match last {
            _ if !value.is_finite() => None,
            Some(last) if value >= last.value => Some(last.bits),
            _ => self.codec.bits_from_physical(value).ok(),
        }
    }
}

/// The code of the highest value that does not stand for a missing one.
fn last_code(signal: &Signal) -> Last {
    let codec = signal.codec();
    let mask = codec.extractor.mask();
    // Codes in the order of the numbers they stand for.
    let (lowest, highest) = match codec.kind {
        ValueKind::Signed => ((mask >> 1) + 1, mask >> 1),
        _ => (0, mask),
    };
    let falling = codec.factor < 0.0;
    let top = if falling { lowest } else { highest };
    let below = if falling { top.wrapping_add(1) } else { top.wrapping_sub(1) } & mask;
    let bits = if signal.value_named(NOT_AVAILABLE) == Some(top) { below } else { top };
    Last { bits, value: codec.physical(bits) }
}

fn not_a_number(kind: ValueKind) -> u64 {
    match kind {
        ValueKind::Float32 => u64::from(f32::NAN.to_bits()),
        _ => f64::NAN.to_bits(),
    }
}
