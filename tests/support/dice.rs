//! Chance that can be repeated: SplitMix64 (Steele, Lea, Flood 2014), a few operations a number.

pub struct Dice(u64);

impl Dice {
    /// Another sequence for each target, seed and run.
    pub fn new(name: &str, seed: u64, run: u64) -> Self {
        let name = name.bytes().fold(0, |sum: u64, byte| sum.wrapping_mul(31).wrapping_add(byte.into()));
        let mut dice = Self(name ^ seed.rotate_left(32));
        Self(dice.draw().wrapping_add(run.wrapping_mul(0xD129_0D3B_2B6E_8F15)))
    }

    pub fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Below `end`; 0 if that is 0.
    pub fn below(&mut self, end: usize) -> usize {
        self.draw().checked_rem(end as u64).unwrap_or(0) as usize
    }

    /// Once in so many times.
    pub fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    pub fn of<'a, T>(&mut self, some: &'a [T]) -> &'a T {
        &some[self.below(some.len())]
    }

    /// Small mostly, large now and then.
    pub fn length(&mut self, most: usize) -> usize {
        let bits = self.below(64 - (most as u64).leading_zeros() as usize + 1);
        self.below((1 << bits).min(most) + 1)
    }

    /// A number as sensors, clocks and people make them up: ordinary, extreme, none.
    pub fn number(&mut self) -> f64 {
        match self.below(8) {
            0 => f64::from_bits(self.draw()),
            1 => *self.of(&[
                0.0,
                -0.0,
                f64::NAN,
                f64::INFINITY,
                f64::NEG_INFINITY,
                f64::MAX,
                f64::MIN_POSITIVE,
            ]),
            2 => 10f64.powi(self.below(60) as i32 - 30),
            _ => (self.draw() as i64 as f64) / (i64::MAX as f64) * 10f64.powi(self.below(8) as i32 - 4),
        }
    }
}
