//! Messages and the quantities in them, compiled: from the bits of a frame to SI and back.

use super::checks::{Checksum, Counter};
use crate::can::CanId;
use crate::dbc::{Codec, Mux, ValueKind};
use physics::{Micros, Quantity};

/// A message that carries configured quantities.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MessageInput {
    pub(super) id: CanId,
    pub(super) name: String,
    /// Bytes that a frame must have.
    pub(super) length: usize,
    pub(super) is_fd: bool,
    /// Time between two frames as the DBC has it.
    pub(super) cycle: Option<Micros>,
    pub(super) counter: Option<Counter>,
    pub(super) checksum: Option<Checksum>,
    pub(super) mappings: Vec<Mapping>,
    pub(super) gates: Vec<Gate>,
}

/// A quantity in a message.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mapping {
    pub(super) quantity: Quantity,
    /// Added up; the first is the coarsest, and the one that codes for "not available" are looked for in.
    pub(super) parts: Vec<Part>,
    /// One bit, set where the value is negative.
    pub(super) sign: Option<Codec>,
    /// Signals of the same message that must all allow the value.
    pub(super) valid: Vec<Quality>,
    /// Numbers of the [`Gate`]s in other messages that must be open.
    pub(super) gates: Vec<usize>,
    /// Bit patterns of the first part that mean "not available".
    pub(super) not_available: Vec<u64>,
    pub(super) gain: f64,
    /// SI, after the gain.
    pub(super) offset: f64,
}

/// One of the signals that a quantity is the sum of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) codec: Codec,
    pub(super) mux: Mux,
    /// From the DBC's unit to SI.
    pub(super) to_si: f64,
}

/// A signal that says whether the value may be used.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Quality {
    pub(super) codec: Codec,
    pub(super) mux: Mux,
    /// Bit patterns at which it may.
    pub(super) allowing: Vec<u64>,
}

/// A quality signal that comes in another message than the value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Gate {
    /// Counted through all messages.
    pub(super) number: usize,
    /// Whose quality it tells.
    pub(super) quantity: Quantity,
    pub(super) quality: Quality,
}

/// What a frame says of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reading {
    /// It is multiplexed and not in this frame.
    NotInThisFrame,
    /// The frame says that it is not available.
    NotAvailable,
    /// SI.
    Value(f64),
}

impl Mapping {
    /// Is it a flag, 0 or 1?
    pub(super) fn is_flag(&self) -> bool {
        matches!(self.quantity, Quantity::BrakeActive | Quantity::AbsActive)
    }

    /// Reads the quantity from a payload at least as long as the message.
    #[inline]
    pub(super) fn read(&self, data: &[u8]) -> Reading {
        let mut value = 0.0;
        for (index, part) in self.parts.iter().enumerate() {
            if !part.mux.is_active(data) {
                return Reading::NotInThisFrame;
            }
            let Some(bits) = part.codec.bits(data) else { return Reading::NotInThisFrame };
            if index == 0 && self.not_available.contains(&bits) {
                return Reading::NotAvailable;
            }
            value += part.to_si * part.codec.physical(bits);
        }
        let allowed =
            |quality: &Quality| quality.codec.bits(data).is_some_and(|bits| quality.allowing.contains(&bits));
        if !self.valid.iter().all(allowed) {
            return Reading::NotAvailable;
        }
        if self.sign.is_some_and(|sign| sign.bits(data) == Some(1)) {
            value = -value;
        }
        value = self.gain * value + self.offset;
        if !value.is_finite() {
            return Reading::NotAvailable;
        }
        Reading::Value(if self.is_flag() { f64::from(u8::from(value >= 0.5)) } else { value })
    }

    /// Writes the quantity into a payload, the inverse of [`Mapping::read`]; what the bits cannot carry
    /// becomes the nearest that they can. `None` writes "not available".
    ///
    /// Returns whether the payload now says so: a quantity without a code, without a quality signal and
    /// without a value cannot be written.
    pub(super) fn write(&self, data: &mut [u8], value: Option<f64>) -> bool {
        for part in &self.parts {
            part.select(data);
        }
        let value = value.filter(|value| value.is_finite());
        let mut sayable = value.is_some();
        // A gate in another message tells it too.
        sayable |= !self.gates.is_empty();
        for quality in &self.valid {
            sayable |= quality.write(data, value.is_some());
        }
        let Some(value) = value else {
            if let (Some(part), Some(code)) = (self.parts.first(), self.not_available.first()) {
                put(part.codec, data, *code);
                sayable = true;
            }
            return sayable;
        };
        self.put(data, value);
        sayable
    }

    /// Writes the quantity and nothing else: selectors and quality stay as they are. What the bits cannot carry becomes
    /// the nearest that they can.
    pub(super) fn put(&self, data: &mut [u8], value: f64) {
        let mut rest = (value - self.offset) / self.gain;
        if let Some(sign) = self.sign {
            put(sign, data, u64::from(rest < 0.0));
            rest = rest.abs();
        }
        for (index, part) in self.parts.iter().enumerate() {
            let codes: &[u64] = if index == 0 { &self.not_available } else { &[] };
            let bits = nearest(part.codec, rest / part.to_si, codes);
            put(part.codec, data, bits);
            rest -= part.to_si * part.codec.physical(bits);
        }
    }

    /// The least by which its value can change, SI; 0 of floating point.
    pub(super) fn step(&self) -> f64 {
        let is_float = |part: &Part| matches!(part.codec.kind, ValueKind::Float32 | ValueKind::Float64);
        if self.parts.iter().any(is_float) { 0.0 } else { self.resolution() }
    }

    /// The step of the finest part, SI.
    pub(super) fn resolution(&self) -> f64 {
        let steps = self.parts.iter().map(|part| (part.codec.factor * part.to_si * self.gain).abs());
        steps.fold(f64::INFINITY, f64::min)
    }
}

impl Part {
    /// Sets the selectors so that this part is in the frame.
    fn select(&self, data: &mut [u8]) {
        select(&self.mux, data);
    }
}

impl Quality {
    /// What the payload says; `None` if it does not carry the signal.
    #[inline]
    pub(super) fn allows(&self, data: &[u8]) -> Option<bool> {
        if !self.mux.is_active(data) {
            return None;
        }
        self.codec.bits(data).map(|bits| self.allowing.contains(&bits))
    }

    /// Writes that the value may be used, or may not. Returns whether the signal can say so.
    pub(super) fn write(&self, data: &mut [u8], allowed: bool) -> bool {
        let bits = if allowed {
            self.allowing.first().copied()
        } else {
            (0..=self.codec.extractor.mask()).take(64).find(|bits| !self.allowing.contains(bits))
        };
        if let Some(bits) = bits {
            select(&self.mux, data);
            put(self.codec, data, bits);
        }
        bits.is_some()
    }
}

/// Sets the selectors so that a signal is in the frame.
fn select(mux: &Mux, data: &mut [u8]) {
    if mux.is_active(data) {
        return;
    }
    for condition in mux.conditions() {
        if let Some((low, _)) = condition.ranges.first() {
            // The selector fits the message, as every signal does.
            let _ = condition.selector.set(data, *low);
        }
    }
}

fn put(codec: Codec, data: &mut [u8], bits: u64) {
    // Every signal fits its message: this was checked when the DBC was loaded.
    let _ = codec.insert(data, bits);
}

/// The bit pattern nearest to a physical value that is not one of the codes.
fn nearest(codec: Codec, physical: f64, codes: &[u64]) -> u64 {
    let (low, high) = codec.range();
    let mut wanted = physical.clamp(low, high);
    // Codes stand at the ends of the range, a few in a row at most.
    for _ in 0..=codes.len() {
        match codec.bits_from_physical(wanted) {
            Ok(bits) if !codes.contains(&bits) => return bits,
            _ => wanted -= codec.factor.abs() * if wanted > 0.5 * (low + high) { 1.0 } else { -1.0 },
        }
    }
    0
}
