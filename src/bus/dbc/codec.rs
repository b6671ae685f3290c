//! Raw bits to a physical number and back.

use super::error::EncodeError;
use super::extract::Extractor;

/// Which way the bytes of a signal go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// Little endian; the start bit is the least significant bit.
    Intel,
    /// Big endian; the start bit is the most significant bit.
    Motorola,
}

/// What the bits of a signal mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// An unsigned integer.
    Unsigned,
    /// A two's complement integer.
    Signed,
    /// An IEEE 754 number of 32 bits.
    Float32,
    /// An IEEE 754 number of 64 bits.
    Float64,
}

/// Everything that decoding one signal takes, in one small copy: position, kind, factor and offset.
///
/// It knows nothing of multiplexing; for that see [`super::Signal::is_active`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Codec {
    /// Where the bits are.
    pub extractor: Extractor,
    /// What they mean.
    pub kind: ValueKind,
    /// Physical units per raw unit; never zero, always finite.
    pub factor: f64,
    /// Physical value of raw zero; always finite.
    pub offset: f64,
}

impl Codec {
    /// The bit pattern; `None` if the payload is too short.
    #[inline]
    pub fn bits(&self, data: &[u8]) -> Option<u64> {
        self.extractor.get(data)
    }

    /// The bit pattern read as an integer, sign extended for signed signals.
    ///
    /// An unsigned 64-bit pattern above `i64::MAX` wraps, as a float's pattern may; use the bits there.
    #[inline]
    pub fn integer(&self, bits: u64) -> i64 {
        match self.kind {
            ValueKind::Signed => {
                let unused = 64 - self.extractor.size();
                ((bits << unused) as i64) >> unused
            }
            _ => bits as i64,
        }
    }

    /// Raw times factor plus offset, in double precision.
    #[inline]
    pub fn physical(&self, bits: u64) -> f64 {
        let raw = match self.kind {
            ValueKind::Unsigned => bits as f64,
            ValueKind::Signed => self.integer(bits) as f64,
            ValueKind::Float32 => f64::from(f32::from_bits(bits as u32)),
            ValueKind::Float64 => f64::from_bits(bits),
        };
        raw * self.factor + self.offset
    }

    /// The physical value; `None` if the payload is too short.
    #[inline]
    pub fn decode(&self, data: &[u8]) -> Option<f64> {
        Some(self.physical(self.bits(data)?))
    }

    /// The bit pattern whose physical value is nearest.
    ///
    /// # Errors
    /// If the value is not a number or no bit pattern is within half a step of it.
    #[inline]
    pub fn bits_from_physical(&self, value: f64) -> Result<u64, EncodeError> {
        let raw = (value - self.offset) / self.factor;
        self.usual_bits(raw).map_or_else(|| self.bits_of_any(raw, value), Ok)
    }

    /// Those of an integer that is no larger than nearly all are.
    #[inline]
    fn usual_bits(&self, raw: f64) -> Option<u64> {
        let (code, mask) = (nearest(raw)?, self.extractor.mask());
        match self.kind {
            ValueKind::Unsigned if 0 <= code && code as u64 <= mask => Some(code as u64),
            ValueKind::Signed if self.integer(code as u64) == code => Some(code as u64 & mask),
            _ => None,
        }
    }

    /// The same for numbers of any kind and size.
    fn bits_of_any(&self, raw: f64, value: f64) -> Result<u64, EncodeError> {
        let size = self.extractor.size();
        // Powers of two are exact, also those that the greatest integers would be rounded to. Nothing is less than
        // what is not a number.
        let nearest = raw.round_ties_even();
        match self.kind {
            ValueKind::Unsigned if nearest >= 0.0 && nearest < power_of_two(size) => Ok(nearest as u64),
            ValueKind::Signed if nearest >= -power_of_two(size - 1) && nearest < power_of_two(size - 1) => {
                Ok(nearest as i64 as u64 & self.extractor.mask())
            }
            ValueKind::Float32 if (raw as f32).is_finite() => Ok(u64::from((raw as f32).to_bits())),
            ValueKind::Float64 if raw.is_finite() => Ok(raw.to_bits()),
            _ => Err(self.refusal(value, raw)),
        }
    }

    /// Why a value has no bits.
    #[cold]
    fn refusal(&self, value: f64, raw: f64) -> EncodeError {
        if raw.is_nan() {
            return EncodeError::NotANumber;
        }
        let (low, high) = self.range();
        EncodeError::OutOfRange { value, low, high }
    }

    /// Stores a bit pattern, touching no other bits.
    ///
    /// # Errors
    /// If the payload is too short.
    #[inline]
    pub fn insert(&self, data: &mut [u8], bits: u64) -> Result<(), EncodeError> {
        let length = data.len();
        if self.extractor.set(data, bits) {
            Ok(())
        } else {
            Err(EncodeError::TooShort { needed: self.extractor.needs_bytes(), length })
        }
    }

    /// Lowest and highest physical value that can be encoded.
    pub fn range(&self) -> (f64, f64) {
        let size = self.extractor.size();
        let (low, high) = match self.kind {
            ValueKind::Unsigned => (0.0, self.extractor.mask() as f64),
            ValueKind::Signed => (-power_of_two(size - 1), power_of_two(size - 1) - 1.0),
            ValueKind::Float32 => (f64::from(f32::MIN), f64::from(f32::MAX)),
            ValueKind::Float64 => (f64::MIN, f64::MAX),
        };
        let (a, b) = (low * self.factor + self.offset, high * self.factor + self.offset);
        (a.min(b), a.max(b))
    }
}

/// The nearest integer, of two the even one; `None` beyond 2⁵¹.
#[inline]
fn nearest(raw: f64) -> Option<i64> {
    // Between 2⁵² and 2⁵³ doubles lie one apart: what is added to this one is rounded as wanted, and stands in the
    // lowest bits then.
    const THERE: f64 = 1.5 * power_of_two(52);
    let bits = (raw + THERE).to_bits().wrapping_sub(THERE.to_bits());
    (raw.abs() < power_of_two(51)).then_some(bits as i64)
}

/// Two to the `exponent`, which is 64 or less.
const fn power_of_two(exponent: u32) -> f64 {
    const BIAS: u64 = 1023;
    const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;
    f64::from_bits((BIAS + exponent as u64) << MANTISSA)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codec(size: u64, kind: ValueKind, factor: f64, offset: f64) -> Codec {
        let extractor = Extractor::new(0, size, ByteOrder::Intel, 8).unwrap();
        Codec { extractor, kind, factor, offset }
    }

    #[test]
    fn limits_of_the_widest_integers() {
        let unsigned = codec(64, ValueKind::Unsigned, 1.0, 0.0);
        assert_eq!(unsigned.physical(u64::MAX), 18_446_744_073_709_551_615.0);
        assert!(unsigned.bits_from_physical(u64::MAX as f64).is_err(), "two to the 64 does not fit");
        assert_eq!(unsigned.bits_from_physical(2_f64.powi(63)), Ok(1 << 63));
        let signed = codec(64, ValueKind::Signed, 1.0, 0.0);
        assert_eq!(signed.bits_from_physical(i64::MIN as f64), Ok(1 << 63));
        assert!(signed.bits_from_physical(2_f64.powi(63)).is_err());
        assert_eq!(codec(1, ValueKind::Signed, 1.0, 0.0).physical(1), -1.0);
    }

    #[test]
    fn nearest_with_ties_to_even_and_nothing_beyond_half_a_step() {
        let c = codec(8, ValueKind::Unsigned, 0.5, -10.0);
        assert_eq!(c.bits_from_physical(-10.0 + 0.25), Ok(0));
        assert_eq!(c.bits_from_physical(-10.0 + 0.75), Ok(2));
        assert_eq!(c.bits_from_physical(-10.2), Ok(0));
        assert!(c.bits_from_physical(-10.3).is_err());
        assert_eq!(
            c.bits_from_physical(118.0),
            Err(EncodeError::OutOfRange { value: 118.0, low: -10.0, high: 117.5 })
        );
        assert_eq!(c.bits_from_physical(f64::NAN), Err(EncodeError::NotANumber));
        assert!(c.bits_from_physical(f64::INFINITY).is_err());
    }

    #[test]
    fn the_nearest_integer_is_the_one_of_the_library() {
        let near = (-4000..4000).map(|i| f64::from(i) / 16.0);
        let wide = (0..64).flat_map(|e| [-0.75, -0.5, 0.0, 0.5, 0.75].map(|x| 2_f64.powi(e) + x));
        for x in near.chain(wide).flat_map(|x| [x, -x, x.next_up(), x.next_down()]) {
            let whole = (x.abs() < 2_f64.powi(51)).then_some(x.round_ties_even() as i64);
            assert_eq!(nearest(x), whole, "{x}");
        }
        assert_eq!([f64::NAN, f64::INFINITY, -1e300].map(nearest), [None; 3]);
    }

    #[test]
    fn a_negative_factor_turns_the_range_round() {
        let c = codec(8, ValueKind::Unsigned, -1.0, 0.0);
        assert_eq!(c.range(), (-255.0, 0.0));
        assert_eq!(c.bits_from_physical(-255.0), Ok(255));
    }

    #[test]
    fn floats_keep_their_value_and_overflow_is_refused() {
        let single = codec(32, ValueKind::Float32, 1.0, 0.0);
        let bits = single.bits_from_physical(1.5).unwrap();
        assert_eq!((bits, single.physical(bits)), (0x3FC0_0000, 1.5));
        assert!(single.bits_from_physical(1e39).is_err());
    }
}
