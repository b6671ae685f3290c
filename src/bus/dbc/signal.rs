//! One signal of a message.

use super::codec::{ByteOrder, Codec};
use super::error::EncodeError;
use super::mux::Mux;

/// A validated signal, ready to decode and encode.
///
/// Names and texts are for set-up and messages; code that runs per frame keeps a copy of
/// [`Signal::codec`], which is small and `Copy`.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Name; the long one where the file gives one.
    pub name: String,
    /// Unit as written in the file.
    pub unit: String,
    /// Physical units per raw unit.
    pub factor: f64,
    /// Physical value of raw zero.
    pub offset: f64,
    /// Lower end of the range the file claims, often zero or wrong; no value is refused for it.
    pub min: f64,
    /// Upper end of the range the file claims, often zero or wrong; no value is refused for it.
    pub max: f64,
    /// Start bit as written in the file.
    pub start_bit: u16,
    /// Number of bits, 1–64.
    pub size: u8,
    /// Byte order.
    pub byte_order: ByteOrder,
    /// Line in the file, counted from 1.
    pub line: usize,
    /// Value table: raw value (sign extended for signed signals) and its name.
    pub values: Vec<(i64, String)>,
    /// What the file says about it in words (`CM_`); empty if nothing.
    pub comment: String,
    pub(super) codec: Codec,
    pub(super) mux: Mux,
}

impl Signal {
    /// Everything that decoding takes but the multiplexing.
    #[inline]
    pub fn codec(&self) -> Codec {
        self.codec
    }

    /// When the signal is in the frame.
    pub fn mux(&self) -> &Mux {
        &self.mux
    }

    /// Is the signal in this frame?
    #[inline]
    pub fn is_active(&self, data: &[u8]) -> bool {
        self.mux.is_active(data)
    }

    /// The bit pattern, whether or not the signal is active; `None` if the payload is too short.
    #[inline]
    pub fn bits(&self, data: &[u8]) -> Option<u64> {
        self.codec.bits(data)
    }

    /// The raw integer, sign extended for signed signals; `None` if the payload is too short.
    #[inline]
    pub fn raw(&self, data: &[u8]) -> Option<i64> {
        self.codec.bits(data).map(|bits| self.codec.integer(bits))
    }

    /// Physical value of a bit pattern, in the file's unit.
    #[inline]
    pub fn physical(&self, bits: u64) -> f64 {
        self.codec.physical(bits)
    }

    /// Physical value in the file's unit; `None` if the payload is too short or the signal is
    /// multiplexed and not in this frame.
    #[inline]
    pub fn decode(&self, data: &[u8]) -> Option<f64> {
        if self.mux.is_active(data) { self.codec.decode(data) } else { None }
    }

    /// The bit pattern whose physical value is nearest.
    ///
    /// # Errors
    /// If the value is not a number or beyond what the bits can carry.
    pub fn bits_from_physical(&self, value: f64) -> Result<u64, EncodeError> {
        self.codec.bits_from_physical(value)
    }

    /// Stores a bit pattern, touching no other bits. Selectors are the caller's business.
    ///
    /// # Errors
    /// If the payload is too short.
    #[inline]
    pub fn insert(&self, data: &mut [u8], bits: u64) -> Result<(), EncodeError> {
        self.codec.insert(data, bits)
    }

    /// Stores a physical value, touching no other bits. Selectors are the caller's business.
    ///
    /// # Errors
    /// If the value cannot be carried or the payload is too short.
    pub fn encode(&self, data: &mut [u8], value: f64) -> Result<(), EncodeError> {
        self.codec.insert(data, self.codec.bits_from_physical(value)?)
    }

    /// The bit pattern that the value table calls so.
    pub fn value_named(&self, name: &str) -> Option<u64> {
        let mask = self.codec.extractor.mask();
        let (value, _) = self.values.iter().find(|(_, text)| text == name)?;
        let bits = *value as u64 & mask;
        // A negative value of an unsigned signal, or one too large, would come back as another.
        let carried = self.codec.integer(bits) == *value || (*value >= 0 && bits == *value as u64);
        carried.then_some(bits)
    }

    /// What the value table calls this bit pattern.
    pub fn value_name(&self, bits: u64) -> Option<&str> {
        let mask = self.codec.extractor.mask();
        self.values.iter().find(|(value, _)| *value as u64 & mask == bits).map(|(_, text)| text.as_str())
    }
}
