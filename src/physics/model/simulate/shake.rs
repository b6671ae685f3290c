//! A rough road shakes the wheels: their axles hop, and they turn a little faster and slower.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::model::scenario::Stretch;

/// The four wheels on the rough stretches of a road: oscillators that the road's noise drives.
#[derive(Clone, Debug)]
pub(super) struct Shake {
    /// Where each stretch begins, s, and how rough it is, m/s.
    stretches: Vec<(f64, f64)>,
    /// Place and velocity of each, in units of its own standard deviation.
    hop: [[f64; 2]; 4],
    noise: ChaCha8Rng,
}

impl Shake {
    /// An axle hops so often a second, and so damped: usual numbers of passenger cars.
    const HOP_HZ: f64 = 12.0;
    const DAMPING: f64 = 0.3;

    /// `None` where the road is smooth all along.
    pub(super) fn new(road: &[Stretch], noise: ChaCha8Rng) -> Option<Self> {
        let stretches: Vec<_> = road.iter().map(|stretch| (stretch.from_s, stretch.roughness_mps)).collect();
        let is_rough = stretches.iter().any(|(_, roughness)| *roughness > 0.0);
        is_rough.then_some(Self { stretches, hop: [[0.0; 2]; 4], noise })
    }

    /// Goes on by `h` seconds, until `t`: by how much the rim of each wheel is faster than it rolls, m/s.
    pub(super) fn step(&mut self, t: f64, h: f64) -> [f64; 4] {
        let omega = TAU * Self::HOP_HZ;
        // White noise of this intensity keeps an oscillator's variance at one.
        let driven = (4.0 * Self::DAMPING * omega.powi(3) * h).sqrt();
        for [place, velocity] in &mut self.hop {
            let pushed: f64 = StandardNormal.sample(&mut self.noise);
            *velocity -= h * (omega * omega * *place + 2.0 * Self::DAMPING * omega * *velocity);
            *velocity += driven * pushed;
            *place += h * *velocity;
        }
        let now = self.stretches.iter().rev().find(|(from_s, _)| *from_s <= t);
        let roughness = now.map_or(0.0, |(_, roughness)| *roughness);
        self.hop.map(|[place, _]| roughness * place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn the_rim_shakes_by_what_the_road_is_said_to() {
        let rough = Stretch { from_s: 5.0, roughness_mps: 0.2, ..Stretch::default() };
        let mut shake =
            Shake::new(&[Stretch::default(), rough], ChaCha8Rng::seed_from_u64(1)).expect("it is rough");
        let (mut before, mut squares, mut count) = (0.0, 0.0, 0.0);
        for i in 1..=65_000 {
            let t = f64::from(i) * 1e-3;
            let faster = shake.step(t, 1e-3);
            if t < 5.0 {
                before += faster.iter().map(|v| v.abs()).sum::<f64>();
            } else {
                squares += faster.iter().map(|v| v * v).sum::<f64>();
                count += 4.0;
            }
        }
        assert_eq!(before, 0.0);
        let rms = f64::sqrt(squares / count);
        assert!((rms - 0.2).abs() < 0.02, "{rms}");
        assert!(Shake::new(&[Stretch::default()], ChaCha8Rng::seed_from_u64(1)).is_none());
    }
}
