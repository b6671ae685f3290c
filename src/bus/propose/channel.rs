//! One signal of a recording: its values in tenths of a second, and its codes that may be no values.

use super::source::Place;
use crate::dbc::{Codec, Mux, ValueKind};

/// Raw values counted of a quality signal.
const CODES: usize = 16;

/// Its record.
pub(super) struct Channel {
    pub(super) place: Place,
    pub(super) codec: Codec,
    mux: Mux,
    /// Bit patterns that often mean "not available".
    pub(super) special: Option<[Special; 2]>,
    /// How often each raw value came, of signals of up to four bits.
    codes: [u64; CODES],
    pub(super) values: u64,
    pub(super) sum: f64,
    pub(super) count: u32,
    low: f64,
    high: f64,
    pub(super) bins: Vec<f32>,
}

/// A bit pattern that may be a measurement, too: it is one, if others come near it.
#[derive(Clone, Copy)]
pub(super) struct Special {
    pub(super) bits: u64,
    /// What it would be as a measurement, in the file's unit, and how near another one has to come.
    value: f64,
    near: f64,
    /// How often it came, and how often another near it.
    pub(super) times: u64,
    pub(super) neighbours: u64,
}

impl Channel {
    pub(super) fn new(place: Place, codec: Codec, mux: Mux) -> Self {
        let special = Special::of(&codec);
        Self {
            place,
            codec,
            mux,
            special,
            codes: [0; CODES],
            values: 0,
            sum: 0.0,
            count: 0,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            bins: Vec::new(),
        }
    }

    pub(super) fn take(&mut self, data: &[u8]) {
        if !self.mux.is_active(data) {
            return;
        }
        let Some(bits) = self.codec.bits(data) else { return };
        if let Some(special) = self.special.iter_mut().flatten().find(|special| special.bits == bits) {
            special.times += 1;
            return;
        }
        if let Some(code) = usize::try_from(bits).ok().and_then(|bits| self.codes.get_mut(bits)) {
            *code += 1;
        }
        let value = self.codec.physical(bits);
        if value.is_finite() {
            for special in self.special.iter_mut().flatten() {
                special.neighbours += u64::from((value - special.value).abs() < special.near);
            }
            self.values += 1;
            self.sum += value;
            self.count += 1;
            self.low = self.low.min(value);
            self.high = self.high.max(value);
        }
    }

    /// Has it more than one value?
    pub(super) fn varies(&self) -> bool {
        self.values > 1 && self.high > self.low
    }

    /// Lowest and highest value, in the file's unit.
    pub(super) fn range(&self) -> Option<[f64; 2]> {
        (self.values > 0).then_some([self.low, self.high])
    }

    /// The raw code that came while no other value came near it: it means "not available".
    pub(super) fn not_available(&self) -> Option<i64> {
        let alone = self.special.iter().flatten().filter(|special| special.neighbours == 0);
        let usual = alone.max_by_key(|special| special.times).filter(|special| special.times > 0)?;
        Some(self.codec.integer(usual.bits))
    }

    /// The raw value that nearly all frames have.
    pub(super) fn usual_code(&self) -> Option<u64> {
        let (code, count) = self.codes.iter().enumerate().max_by_key(|(_, count)| **count)?;
        (*count as f64 >= 0.9 * self.values as f64 && *count > 0).then_some(code as u64)
    }

    /// The share of frames that have the raw value.
    pub(super) fn share_of(&self, code: u64) -> f64 {
        let count = usize::try_from(code).ok().and_then(|code| self.codes.get(code)).copied().unwrap_or(0);
        if self.values > 0 { count as f64 / self.values as f64 } else { 0.0 }
    }
}

impl Special {
    /// The ends of what the bits can carry. Where they carry no sign, all ones, and the one that would be the lowest if
    /// they did: some programs write it for everything that they do not have.
    fn of(codec: &Codec) -> Option<[Self; 2]> {
        let (mask, size) = (codec.extractor.mask(), codec.extractor.size());
        let (low, high) = codec.range();
        let special = |bits: u64| Self {
            bits,
            value: codec.physical(bits),
            near: 0.1 * (high - low),
            times: 0,
            neighbours: 0,
        };
        match codec.kind {
            ValueKind::Signed if size >= 8 => Some([special(mask / 2 + 1), special(mask / 2)]),
            ValueKind::Unsigned if size >= 8 => {
                let middle = special(mask / 2 + 1);
                // Where the middle stands for zero, or steps are coarse, it is a measurement like others.
                let is_zero = middle.value.abs() < 0.25 * low.abs().max(high.abs());
                let lower = if size < 12 || is_zero { special(mask) } else { middle };
                Some([special(mask), lower])
            }
            _ => None,
        }
    }
}
