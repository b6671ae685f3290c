//! Numbers written as text, eight characters at once: a machine word is eight characters side by side.

use physics::Micros;

/// The same byte in all eight places.
#[inline]
pub(in crate::can) const fn all(byte: u8) -> u64 {
    u64::from_le_bytes([byte; 8])
}

/// The highest bit of each byte.
pub(in crate::can) const TOP: u64 = all(0x80);

/// The eight decimal digits of a number below 10⁸.
#[inline]
pub(in crate::can) fn to_decimal(number: u32) -> [u8; 8] {
    let (upper, lower) = (u64::from(number / 10_000), u64::from(number % 10_000));
    // Fours to pairs to digits, the first in the lowest place; 5243/2¹⁹ and 103/2¹⁰ are a hundredth and a tenth.
    let fours = upper | lower << 32;
    let hundreds = ((fours * 5243) >> 19) & 0x0000_007F_0000_007F;
    let pairs = hundreds | (fours - 100 * hundreds) << 16;
    let tens = ((pairs * 103) >> 10) & 0x000F_000F_000F_000F;
    let digits = tens | (pairs - 10 * tens) << 8;
    (digits | all(b'0')).to_le_bytes()
}

/// Four bytes as eight hexadecimal digits, upper case.
#[inline]
pub(in crate::can) fn to_hexadecimal(bytes: [u8; 4]) -> [u8; 8] {
    let bytes = u64::from(u32::from_le_bytes(bytes));
    let twos = (bytes | bytes << 16) & 0x0000_FFFF_0000_FFFF;
    let bytes = (twos | twos << 8) & 0x00FF_00FF_00FF_00FF;
    let halves = (bytes >> 4 | bytes << 8) & all(0x0F);
    // From 10 on letters, which lie 7 further.
    let letters = ((halves + all(0x7F - 9)) & TOP) >> 7;
    (halves + all(b'0') + 7 * letters).to_le_bytes()
}

/// A short text, put together word by word in one place and handed on as a whole.
#[derive(Default)]
pub(in crate::can) struct Words {
    /// What is behind the text is overwritten by the next word.
    text: [[u8; 8]; 5],
    length: usize,
}

impl Words {
    /// Adds the first so many characters of a word. What does not fit is left out.
    #[inline]
    pub fn word(&mut self, word: [u8; 8], count: usize) -> &mut Self {
        if let Some(place) = self.text.as_flattened_mut()[self.length..].first_chunk_mut() {
            *place = word;
            self.length += count;
        }
        self
    }

    /// Adds a character.
    #[inline]
    pub fn one(&mut self, character: u8) -> &mut Self {
        self.word([character; 8], 1)
    }

    /// Adds so many hexadecimal digits, upper case; eight at most.
    #[inline]
    pub fn hexadecimal(&mut self, value: u32, digits: usize) -> &mut Self {
        let text = u64::from_le_bytes(to_hexadecimal(value.to_be_bytes()));
        self.word((text >> (8 * (8 - digits))).to_le_bytes(), digits)
    }

    /// Adds a number's decimal digits.
    #[inline]
    pub fn decimal(&mut self, number: u64) -> &mut Self {
        let digits = to_decimal((number % 100_000_000) as u32);
        match number / 100_000_000 {
            0 => {
                let text = u64::from_le_bytes(digits);
                let zeros = ((text ^ all(b'0')).trailing_zeros() / 8).min(7);
                return self.word((text >> (8 * zeros)).to_le_bytes(), 8 - zeros as usize);
            }
            // A day of this century has ten digits.
            above @ 10..100 => {
                let pair = [b'0' + (above / 10) as u8, b'0' + (above % 10) as u8];
                self.word([pair[0], pair[1], 0, 0, 0, 0, 0, 0], 2)
            }
            above => self.one_by_one(above),
        };
        self.word(digits, 8)
    }

    #[cold]
    fn one_by_one(&mut self, number: u64) -> &mut Self {
        let mut power = 10_u64.pow(number.checked_ilog10().unwrap_or(0));
        while power > 0 {
            self.one(b'0' + (number / power % 10) as u8);
            power /= 10;
        }
        self
    }

    /// Adds `seconds.micros`, six digits of them.
    #[inline]
    pub fn seconds(&mut self, time: Micros) -> &mut Self {
        if time.0 < 0 {
            self.one(b'-');
        }
        let micros = time.0.unsigned_abs();
        // The point takes the place of the second of two leading zeros.
        let digits = u64::from_le_bytes(to_decimal((micros % 1_000_000) as u32));
        let fraction = digits >> 8 & !0xFF | u64::from(b'.');
        self.decimal(micros / 1_000_000).word(fraction.to_le_bytes(), 7)
    }

    /// All of it.
    #[inline]
    pub fn text(&self) -> &[u8] {
        &self.text.as_flattened()[..self.length]
    }
}
