//! What lies under the wheels.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A kind of road.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Surface {
    Dry,
    Wet,
    Gravel,
    Snow,
    Ice,
}

impl Surface {
    pub const ALL: [Self; 5] = [Self::Dry, Self::Wet, Self::Gravel, Self::Snow, Self::Ice];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Dry => "dry",
            Self::Wet => "wet",
            Self::Gravel => "gravel",
            Self::Snow => "snow",
            Self::Ice => "ice",
        }
    }

    /// Friction, drawn.
    pub fn friction(self, random: &mut ChaCha8Rng) -> f64 {
        let (low, high) = match self {
            Self::Dry => (0.9, 1.1),
            Self::Wet => (0.6, 0.8),
            Self::Gravel => (0.5, 0.65),
            Self::Snow => (0.25, 0.4),
            Self::Ice => (0.08, 0.2),
        };
        random.random_range(low..high)
    }

    /// How stiff the tires are on it, along and across, against an asphalt's: loose ones give way; ice is hard, and
    /// what slides on it is not stiff.
    pub fn stiffness(self, random: &mut ChaCha8Rng) -> [f64; 2] {
        let [along, across] = match self {
            Self::Dry => [1.0, 1.0],
            Self::Wet => [0.95, 0.95],
            Self::Gravel => [0.5, 0.65],
            Self::Snow => [0.5, 0.6],
            Self::Ice => [0.6, 0.6],
        };
        [along * random.random_range(0.9..1.1), across * random.random_range(0.9..1.1)]
    }

    /// At which speeds one drives on it, m/s.
    pub const fn speeds(self) -> (f64, f64) {
        match self {
            Self::Dry => (13.0, 28.0),
            Self::Wet => (12.0, 24.0),
            Self::Gravel => (9.0, 16.0),
            Self::Snow => (8.0, 15.0),
            Self::Ice => (6.0, 11.0),
        }
    }
}
