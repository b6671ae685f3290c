//! What the noise of the inputs does to the result.
//!
//! A simulation takes a measured steering angle for the true one. Its noise then drives the simulated car
//! but not the real one, and the search makes the tires softer until that fits: on a straight road, with
//! nothing else to go by, to nearly nothing, and very surely so. How much of that is in a result shows
//! when the same noise is added once more (simulation and extrapolation, Cook and Stefanski 1994): as far
//! as the parameters move then, they have been moved already, and can be moved back.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::longitudinal_input::LongitudinalInput;
use super::record::{Record, Row};
use super::segment::Segment;

/// Standard deviation of the white noise of the inputs of one recording.
#[derive(Clone, Copy, Debug, Default)]
struct InputNoise {
    steering: f64,
    /// Of whatever is known of the wheels: speeds or slips.
    wheel: [f64; 4],
}

impl InputNoise {
    fn of(record: &Record, drive: LongitudinalInput) -> Self {
        let wheel = |row: &Row, i: usize| match drive {
            LongitudinalInput::Slips => row.slip[i],
            _ => row.wheel_speed[i],
        };
        Self {
            steering: white(&record.rows, |row| row.steering),
            wheel: std::array::from_fn(|i| white(&record.rows, |row| wheel(row, i))),
        }
    }
}

/// The white part of a signal: from its second differences, in which whatever moves slowly cancels, by
/// their median, which steps and spikes do not move.
fn white(rows: &[Row], value: impl Fn(&Row) -> f64) -> f64 {
    let differences = rows.windows(3).map(|row| value(&row[0]) - 2.0 * value(&row[1]) + value(&row[2]));
    let mut sizes: Vec<f64> = differences.filter(|d| d.is_finite()).map(f64::abs).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    // Of a normal distribution the median size is 0.6745 σ; the second difference has √6 times its σ.
    *median / (0.6745 * 6f64.sqrt())
}

/// The same segments with the noise of their inputs once more.
pub(super) fn noisier(
    segments: &[Segment],
    records: &[Record],
    drive: LongitudinalInput,
    seed: u64,
) -> Vec<Segment> {
    let noise: Vec<InputNoise> = records.iter().map(|record| InputNoise::of(record, drive)).collect();
    let mut segments = segments.to_vec();
    // Neighbours share a row, and so its noise.
    let mut shared = [0.0; 5];
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for segment in &mut segments {
        let noise = &noise[segment.record];
        let count = segment.inputs.len();
        for (place, input) in segment.inputs.iter_mut().enumerate() {
            let drawn = if place == 0 && segment.continues {
                shared
            } else {
                std::array::from_fn(|_| random.sample(StandardNormal))
            };
            input.steering += noise.steering * drawn[0];
            for (wheel, (std, drawn)) in input.wheel.iter_mut().zip(noise.wheel.iter().zip(&drawn[1..])) {
                *wheel += std * drawn;
            }
            if place + 1 == count {
                shared = drawn;
            }
        }
        for place in 1..count {
            let turned = segment.inputs[place].steering - segment.inputs[place - 1].steering;
            segment.inputs[place - 1].steering_rate = turned / segment.period_s;
        }
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::{Sample, Sensors};

    #[test]
    fn white_noise_is_told_from_what_moves() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut samples = Vec::new();
        for step in 0..5000 {
            let t = 0.01 * f64::from(step);
            let drawn: f64 = random.sample(StandardNormal);
            let mut sample = Sample::empty(physics::Micros::from_seconds(t), 0.01);
            sample.set(physics::Quantity::SteeringWheelAngle, 0.3 * (3.0 * t).sin() + 0.002 * drawn);
            samples.push(sample);
        }
        let record = Record::new("test", &samples, &Sensors::default());
        let std = InputNoise::of(&record, LongitudinalInput::WheelSpeeds).steering;
        assert!((std / 0.002 - 1.0).abs() < 0.1, "{std}");
    }
}
