//! The bit work: where a signal's bits lie in the payload, fetched and stored with one load each.
//!
//! DBC numbers bits in two ways. Intel: bit `n` is bit `n % 8` of byte `n / 8`, and the start bit is
//! the least significant one. Motorola: the same ("sawtooth") numbers, but the start bit is the most
//! significant one, and the signal goes on towards bit 0 of its byte, then at bit 7 of the next.

use super::ByteOrder;

/// Fetches and stores the bits of one signal. Made once, when the file is loaded; no branch on the
/// layout is left but the byte order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extractor {
    /// First byte of the window of 8 (or, if `wide`, 16) bytes that is loaded.
    window: u8,
    /// How far the window is to be shifted right.
    shift: u8,
    /// Number of bits, 1–64.
    size: u8,
    /// Bytes of payload that must be there.
    end: u8,
    big_endian: bool,
    /// The bits touch nine bytes.
    wide: bool,
}

impl Extractor {
    /// For `size` bits at `start_bit`, as written in a DBC file, of a message of `length` bytes.
    ///
    /// `None` if the size is not 1–64, the length more than 64, or the bits are not within the message.
    pub fn new(start_bit: u64, size: u64, order: ByteOrder, length: usize) -> Option<Self> {
        if !(1..=64).contains(&size) || length > 64 || start_bit >= 8 * length as u64 {
            return None;
        }
        let (start_bit, size) = (start_bit as usize, size as usize);
        let big_endian = order == ByteOrder::Motorola;
        // Position of the first bit when bits are counted along the payload.
        let first_bit = if big_endian { 8 * (start_bit / 8) + 7 - start_bit % 8 } else { start_bit };
        let end_bit = first_bit + size;
        if end_bit > 8 * length {
            return None;
        }
        let (first, end) = (first_bit / 8, end_bit.div_ceil(8));
        let wide = end - first > 8;
        let width = if wide { 16 } else { 8 };
        // Where the message allows it the window lies within the message, so that a complete frame
        // never takes the detour over a copy.
        let window = first.min(length.saturating_sub(width));
        let shift = if big_endian { 8 * (window + width) - end_bit } else { first_bit - 8 * window };
        Some(Self {
            window: window as u8,
            shift: shift as u8,
            size: size as u8,
            end: end as u8,
            big_endian,
            wide,
        })
    }

    /// Number of bits.
    pub const fn size(self) -> u32 {
        self.size as u32
    }

    /// Number of payload bytes that a frame must have to carry the signal.
    pub const fn needs_bytes(self) -> usize {
        self.end as usize
    }

    /// One bits, as many as the signal has.
    #[inline]
    pub const fn mask(self) -> u64 {
        u64::MAX >> (64 - self.size as u32)
    }

    /// The bits, not extended; `None` if the payload is too short.
    #[inline]
    pub fn get(self, data: &[u8]) -> Option<u64> {
        if data.len() < usize::from(self.end) {
            return None;
        }
        if self.wide {
            return Some(self.get_wide(data));
        }
        let bytes: [u8; 8] = window(data, usize::from(self.window));
        let word = if self.big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) };
        Some((word >> self.shift) & self.mask())
    }

    /// Stores the bits (those beyond the size are ignored) and touches no other; false, and nothing
    /// stored, if the payload is too short.
    #[inline]
    #[must_use]
    pub fn set(self, data: &mut [u8], bits: u64) -> bool {
        if data.len() < usize::from(self.end) {
            return false;
        }
        if self.wide {
            self.set_wide(data, bits);
            return true;
        }
        let at = usize::from(self.window);
        let bytes: [u8; 8] = window(data, at);
        let word = if self.big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) };
        let mask = self.mask();
        let word = (word & !(mask << self.shift)) | ((bits & mask) << self.shift);
        let bytes = if self.big_endian { word.to_be_bytes() } else { word.to_le_bytes() };
        store(data, at, &bytes);
        true
    }

    /// Stores the bits likewise in a payload held as one little-endian word; `word` as it is then. For signals of
    /// messages of at most eight bytes.
    #[inline]
    #[must_use]
    pub fn set_in_word(self, word: u64, bits: u64) -> u64 {
        let mask = self.mask();
        let (mut place, mut bits) = (mask << self.shift, (bits & mask) << self.shift);
        if self.big_endian {
            (place, bits) = (place.swap_bytes(), bits.swap_bytes());
        }
        word & !place | bits
    }

    #[cold]
    fn get_wide(self, data: &[u8]) -> u64 {
        let bytes: [u8; 16] = window(data, usize::from(self.window));
        let word = if self.big_endian { u128::from_be_bytes(bytes) } else { u128::from_le_bytes(bytes) };
        (word >> self.shift) as u64 & self.mask()
    }

    #[cold]
    fn set_wide(self, data: &mut [u8], bits: u64) {
        let at = usize::from(self.window);
        let bytes: [u8; 16] = window(data, at);
        let word = if self.big_endian { u128::from_be_bytes(bytes) } else { u128::from_le_bytes(bytes) };
        let mask = u128::from(self.mask());
        let word = (word & !(mask << self.shift)) | ((u128::from(bits) & mask) << self.shift);
        store(data, at, &if self.big_endian { word.to_be_bytes() } else { word.to_le_bytes() });
    }
}

/// The `N` bytes from `at`; what lies beyond the payload counts as zero.
#[inline]
fn window<const N: usize>(data: &[u8], at: usize) -> [u8; N] {
    match data.get(at..at + N).and_then(|window| window.first_chunk()) {
        Some(bytes) => *bytes,
        None => {
            let rest = data.get(at..).unwrap_or_default();
            let mut bytes = [0; N];
            bytes.iter_mut().zip(rest).for_each(|(to, from)| *to = *from);
            bytes
        }
    }
}

/// Puts the window back, as far as there is payload.
#[inline]
fn store<const N: usize>(data: &mut [u8], at: usize, bytes: &[u8; N]) {
    let rest = data.get_mut(at..).unwrap_or_default();
    match rest.first_chunk_mut::<N>() {
        Some(all) => *all = *bytes,
        None => rest.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ByteOrder::{Intel, Motorola};

    #[test]
    fn motorola_starts_at_its_most_significant_bit() {
        let bits = Extractor::new(3, 12, Motorola, 2).unwrap();
        assert_eq!(bits.get(&[0xFA, 0xBC]), Some(0xABC));
        let byte = Extractor::new(15, 8, Motorola, 2).unwrap();
        assert_eq!(byte.get(&[0x12, 0x34]), Some(0x34));
    }

    #[test]
    fn nine_bytes_are_reached() {
        let data = [0x80, 1, 2, 3, 4, 5, 6, 7, 0x7F];
        let intel = Extractor::new(7, 64, Intel, 9).unwrap();
        assert_eq!(intel.get(&data), Some(0xFE0E_0C0A_0806_0403));
        let motorola = Extractor::new(0, 64, Motorola, 9).unwrap();
        assert_eq!(motorola.get(&data), Some(0x0081_0182_0283_03BF));
    }

    #[test]
    fn a_short_payload_is_noticed_only_where_it_matters() {
        let second = Extractor::new(8, 8, Intel, 8).unwrap();
        assert_eq!(second.get(&[1]), None);
        assert_eq!(second.get(&[1, 2]), Some(2));
        assert!(!second.set(&mut [0], 1));
    }

    #[test]
    fn a_word_holds_what_eight_bytes_do() {
        for order in [Intel, Motorola] {
            for length in 1..=8 {
                let all = (0..64).flat_map(|start| (1..=64).map(move |size| (start, size)));
                for bits in all.filter_map(|(start, size)| Extractor::new(start, size, order, length)) {
                    for (before, value) in
                        [(0, u64::MAX), (u64::MAX, 0), (0x0123_4567_89AB_CDEF, 0x5A5A_A5A5_1234_5678)]
                    {
                        let mut data = u64::to_le_bytes(before);
                        assert!(bits.set(&mut data[..length], value));
                        let word = bits.set_in_word(before, value);
                        assert_eq!(word.to_le_bytes()[..length], data[..length], "{bits:?}");
                    }
                }
            }
        }
    }

    /// Where the bits lie as the DBC format walks them: (byte, bit of it), the least significant one first. None if that
    /// leaves the message.
    fn walked(start: usize, size: usize, order: ByteOrder, length: usize) -> Option<Vec<(usize, usize)>> {
        let (mut byte, mut bit) = (start / 8, start % 8);
        let mut places = Vec::with_capacity(size);
        for _ in 0..size {
            if byte >= length {
                return None;
            }
            places.push((byte, bit));
            (byte, bit) = match (order, bit) {
                (Intel, 7) => (byte + 1, 0),
                (Intel, _) => (byte, bit + 1),
                (Motorola, 0) => (byte + 1, 7),
                (Motorola, _) => (byte, bit - 1),
            };
        }
        if order == Motorola {
            places.reverse();
        }
        Some(places)
    }

    /// A proof for every layout of every length that a CAN frame has, and every payload. Fetching is shifts, masks and swaps,
    /// so the result for a payload is the XOR of those for its single ones, and these are all tried. Storing takes each bit of
    /// the result either from the payload or from the value; a payload of zeros and one of ones, each with every single
    /// one and with none, tell which.
    #[test]
    fn every_layout_fetches_and_stores_the_bits_that_the_format_walks() {
        let mut layouts = 0;
        for length in (1..=8).chain([12, 16, 20, 24, 32, 48, 64]) {
            let all = (0..8 * length).flat_map(|start| (1..=64).map(move |size| (start, size)));
            for ((start, size), order) in all.flat_map(|layout| [(layout, Intel), (layout, Motorola)]) {
                let bits = Extractor::new(start as u64, size as u64, order, length);
                let places = walked(start, size, order, length);
                assert_eq!(bits.is_some(), places.is_some(), "{start}|{size} {order:?} of {length}");
                let (Some(bits), Some(places)) = (bits, places) else { continue };
                layouts += 1;
                let mut expected = [[0; 8]; 64];
                for (n, (byte, bit)) in places.iter().enumerate() {
                    expected[*byte][*bit] = 1_u64 << n;
                }
                let mut data = [0; 64];
                let data = &mut data[..length];
                assert_eq!(bits.get(data), Some(0));
                for (byte, expected) in expected.iter().enumerate().take(length) {
                    for (bit, expected) in expected.iter().enumerate() {
                        data[byte] = 1 << bit;
                        assert_eq!(bits.get(data), Some(*expected), "{bits:?}");
                    }
                    data[byte] = 0;
                }
                for before in [0, 0xFF] {
                    for value in (0..64).map(|n| 1_u64 << n).chain([0]) {
                        data.fill(before);
                        assert!(bits.set(data, value));
                        for (n, (byte, bit)) in places.iter().enumerate() {
                            assert_eq!(u64::from(data[*byte] >> bit & 1), value >> n & 1, "{bits:?}");
                            data[*byte] = data[*byte] & !(1 << bit) | (before & 1 << bit);
                        }
                        assert!(data.iter().all(|byte| *byte == before), "{bits:?}");
                    }
                }
            }
        }
        // Of n bits n (n + 1)/2 up to 64, then 64 n − 2016; in both orders.
        assert_eq!(layouts, 2 * 103_152);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert_eq!(Extractor::new(60, 5, Intel, 8), None);
        assert_eq!(Extractor::new(56, 2, Motorola, 8), None);
        assert_eq!(Extractor::new(0, 0, Intel, 8), None);
        assert_eq!(Extractor::new(0, 65, Intel, 64), None);
        assert_eq!(Extractor::new(u64::MAX, 1, Intel, 64), None);
        assert_eq!(Extractor::new(0, 1, Intel, 0), None);
    }
}
