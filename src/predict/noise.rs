//! The noise of sensors and equations.

use super::car::{BODY_STATES, MOST_LIVE};
use super::drive::GriddedDrive;
use super::grid::{COMPARED, SPEED, STEP_S};
use super::smoothing::white_std;
use physics::Quantity;

/// A course that is estimated while the filter runs: an Ornstein–Uhlenbeck process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Live {
    /// Standard deviation, in the course's unit.
    pub size: f64,
    /// Correlation length, s.
    pub length_s: f64,
    /// Shortest correlation length that makes sense, s.
    pub least_s: f64,
    /// Over which difference the filter takes its influence to be linear. That of a slippery patch is
    /// none at all at first.
    pub difference: f64,
}

impl Live {
    /// What is left of it after a step of the grid.
    pub fn keeps(&self) -> f64 {
        (-STEP_S / self.length_s).exp()
    }
}

/// Standard deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// What the equations miss of vx, vy and yaw rate: diffusion, per √s.
    pub diffusion: [f64; BODY_STATES],
    /// What tires' slips err by beside the model's, relative: a wheel's speed shows it.
    pub slip: f64,
    /// Of a reading, by quantity.
    pub sensor: [f64; Quantity::COUNT],
    /// Courses that are estimated.
    pub live: Vec<Live>,
}

impl Noise {
    /// A first guess: sensors from the differences of their readings, equations nearly right.
    pub fn first(drives: &[GriddedDrive]) -> Self {
        let mut sensor = [f64::NAN; Quantity::COUNT];
        for channel in COMPARED.into_iter().chain([SPEED]) {
            let of_drive = |drive: &GriddedDrive| -> Vec<f64> {
                drive.measured.iter().filter(|m| m.channel == channel as u8).map(|m| m.value).collect()
            };
            let tracks: Vec<Vec<f64>> = drives.iter().map(of_drive).collect();
            if let Some(std) = white_std(tracks.iter().map(Vec::as_slice)) {
                sensor[channel as usize] = std.max(floor(channel));
            }
        }
        Self { diffusion: Self::LEAST_DIFFUSION, slip: Self::LEAST_SLIP, sensor, live: Vec::new() }
    }

    /// No car and no steering sensor is better than this, per √s.
    pub const LEAST_DIFFUSION: [f64; BODY_STATES] = [1e-3, 1e-3, 5e-4];

    /// No tire's slip is known better than this. Numerical: a search by factors begins there.
    pub const LEAST_SLIP: f64 = 5e-3;

    /// How many numbers there are that a search may scale: diffusions, the slips' error, size and length of each course;
    /// the last one stands for all diffusions together.
    pub fn scales(&self) -> usize {
        BODY_STATES + 1 + 2 * self.live.len() + 1
    }

    /// The same with one of those scaled, if that changes anything and can be.
    pub fn scaled(&self, place: usize, by: f64) -> Option<Self> {
        let mut noise = self.clone();
        match place.checked_sub(BODY_STATES) {
            Some(place) if place == 2 * self.live.len() + 1 => {
                for (diffusion, least) in noise.diffusion.iter_mut().zip(Self::LEAST_DIFFUSION) {
                    *diffusion = (*diffusion * by).clamp(least, 3000.0 * least);
                }
            }
            None => {
                let least = Self::LEAST_DIFFUSION[place];
                noise.diffusion[place] = (noise.diffusion[place] * by).clamp(least, 3000.0 * least);
            }
            Some(0) => noise.slip = (noise.slip * by).clamp(Self::LEAST_SLIP, 1.0),
            Some(place) => {
                let place = place - 1;
                let live = noise.live.get_mut(place / 2)?;
                if place % 2 == 0 {
                    live.size *= by;
                } else {
                    live.length_s = (live.length_s * by).clamp(live.least_s, 60.0);
                }
            }
        }
        (noise != *self).then_some(noise)
    }

    /// The same with another course to estimate.
    pub fn with(&self, live: Live) -> Self {
        let mut noise = self.clone();
        if noise.live.len() < MOST_LIVE {
            noise.live.push(live);
        }
        noise
    }
}

/// No sensor of a car is better than this.
pub fn floor(channel: Quantity) -> f64 {
    match channel {
        Quantity::YawRate => 2e-4,
        Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration => 5e-3,
        _ => 5e-3,
    }
}
