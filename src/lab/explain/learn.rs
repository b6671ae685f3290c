//! Noise of sensors and equations, by maximum likelihood.

use rayon::prelude::*;

use super::fit::Data;
use super::model::Model;
use physics::Quantity;
use predict::noise::{Noise, floor};
use predict::sums::BlockSums;

impl Data<'_> {
    /// The noise with the sensors' as the innovations have it, or as their readings look, if either is more
    /// probable, and −2 ln likelihood with it; both are known as they are now.
    pub fn with_sensors(
        &self,
        model: &Model<'_>,
        sums: &[BlockSums],
        (noise, value): (&Noise, f64),
    ) -> (Noise, f64) {
        let looks = Noise { sensor: self.own_noise.sensor, ..noise.clone() };
        let tried: Vec<(Noise, f64)> = [self.sensor_noise(sums, noise), looks]
            .into_par_iter()
            .map(|noise| {
                let value = self.minus_two_ln(&self.pass(model, &[], &noise));
                (noise, value)
            })
            .collect();
        let now = (noise.clone(), value);
        tried.into_iter().chain([now.clone()]).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(now)
    }

    /// Noise of the sensors as the innovations have it.
    fn sensor_noise(&self, sums: &[BlockSums], noise: &Noise) -> Noise {
        let mut new = noise.clone();
        for channel in Quantity::ALL {
            let place = channel as usize;
            let (mut excess, mut count) = (0.0, 0);
            for sum in self.counted(sums) {
                excess += sum.excess[place];
                count += sum.of[place];
            }
            if count > 0 {
                // What readings jump from one to the next is their noise, whatever the model says.
                let own = self.own_noise.sensor[place];
                let variance = (excess / count as f64).clamp(0.8 * own * own, 2.0 * own * own);
                new.sensor[place] = variance.sqrt().max(floor(channel));
            }
        }
        new
    }

    /// Diffusion of each equation, size and length of each course, one after the other, by factors, as
    /// long as it helps; −2 ln likelihood is known, and told again.
    pub fn diffusion(
        &self,
        model: &Model<'_>,
        (noise, value): (&Noise, f64),
        factors: &[f64],
    ) -> (Noise, f64) {
        let (mut best, mut lowest) = (noise.clone(), value);
        let value = |noise: &Noise| self.minus_two_ln(&self.pass(model, &[], noise));
        for factor in factors.iter().copied() {
            for place in 0..best.scales() {
                let tried: Vec<(f64, Noise, f64)> = [1.0 / factor, factor]
                    .into_par_iter()
                    .filter_map(|by: f64| {
                        let noise = best.scaled(place, by)?;
                        let value = value(&noise);
                        Some((by, noise, value))
                    })
                    .collect();
                let best_of = tried.into_iter().min_by(|a, b| a.2.total_cmp(&b.2));
                let Some((by, mut noise, mut found)) = best_of else { continue };
                let mut left = 6;
                while found < lowest - 0.5 {
                    (best, lowest) = (noise, found);
                    // Go on in that direction.
                    let Some(further) = best.scaled(place, by).filter(|_| left > 0) else { break };
                    left -= 1;
                    found = value(&further);
                    noise = further;
                }
            }
        }
        (best, lowest)
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{fitted, recorded, training};
    use super::*;
    use predict::GriddedDrive;

    /// What tires' slips err by in a drive with an effect.
    fn slip(effect: &str) -> f64 {
        let (vehicle, recording) = recorded(effect);
        let drives = [GriddedDrive::new(&recording, &vehicle)];
        fitted(&training(&drives), &vehicle).noise.slip
    }

    #[test]
    #[ignore = "long: two cars fitted"]
    fn slips_err_where_wheels_turn_otherwise_than_the_model_has_it() {
        let plain = slip("");
        let loaded = slip("[[effect]]\nkind = \"load_transfer\"\ncg_height_m = 0.6\n");
        assert!(plain < 4.0 * Noise::LEAST_SLIP, "{plain}");
        assert!(loaded > 10.0 * plain, "{loaded} for {plain}");
    }
}
