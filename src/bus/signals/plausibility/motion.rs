//! Yaw rate, wheel speeds, lateral acceleration and steering against each other.

use super::{Contradiction, Kinematics};
use physics::{Faults, Quantity, Sample};

/// Reversing turns all signs about; it is slower than this, m/s.
const FAST: f64 = 8.0;
/// How long the past counts, s.
const MEMORY_S: f64 = 5.0;
/// Least movement (standard deviation) from which signs can be told, rad/s.
const MOVEMENT: f64 = 0.03;
/// Correlation below which two witnesses contradict each other.
const CONTRADICTION: f64 = -0.5;
/// How long kinematic witnesses must contradict each other, s.
const KINEMATIC_S: f64 = 3.0;
/// How long steering must contradict: a drift with opposite lock ends sooner, s.
const STEERING_S: f64 = 8.0;

/// Finds signs that contradict each other: a sensor mounted upside down, or mapped with a wrong sign.
///
/// Only movements count, so constant offsets do not matter. Nothing is taken out of the sample: which of
/// two witnesses lies is for `check` and `explain` to find.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MotionCheck {
    /// Yaw rate from the sensor, from the wheels, from the lateral acceleration, from the steering.
    witnesses: [Moments; 4],
    /// In the order of [`PAIRS`].
    products: [f64; PAIRS.len()],
    /// Seconds that contribute.
    weight: f64,
    contradicting_s: [f64; PAIRS.len()],
}

#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    mean: f64,
    square: f64,
}

/// What the witnesses are called.
const NAMES: [&str; 4] = ["yaw_rate", "wheel speeds", "lateral_acceleration", "steering_wheel_angle"];

/// Which are compared. Steering is compared with both sensors, and believed to lie only if both say so.
const PAIRS: [(usize, usize); 5] = [(0, 1), (0, 2), (1, 2), (0, 3), (2, 3)];

impl MotionCheck {
    pub(super) fn check(&mut self, sample: &Sample, wheels: &Kinematics) -> Faults {
        if let Some(values) = witnesses(sample, wheels) {
            self.update(values, sample.elapsed_s.min(0.1));
        }
        if self.contradicting().is_some() { Faults::MOTION_MISMATCH } else { Faults::empty() }
    }

    /// The pair that has contradicted each other for longest, if that is long enough.
    fn contradicting(&self) -> Option<usize> {
        let [.., yaw_steering, lateral_steering] = self.contradicting_s;
        let kinematic = (0..3).max_by(|a, b| self.contradicting_s[*a].total_cmp(&self.contradicting_s[*b]));
        kinematic
            .filter(|pair| self.contradicting_s[*pair] > KINEMATIC_S)
            .or((yaw_steering.min(lateral_steering) > STEERING_S).then_some(3))
    }

    /// Who contradicts whom, and how much.
    pub(super) fn reason(&self) -> Option<Contradiction> {
        let pair = self.contradicting()?;
        let (a, b) = PAIRS[pair];
        let size = (self.witnesses[a].square * self.witnesses[b].square).sqrt();
        Some(Contradiction::Motion { between: [NAMES[a], NAMES[b]], correlation: self.products[pair] / size })
    }

    fn update(&mut self, values: [f64; 4], elapsed_s: f64) {
        let keep = (-elapsed_s / MEMORY_S).exp();
        self.weight = keep * self.weight + elapsed_s;
        let mut movement = [0.0; 4];
        for ((witness, value), movement) in self.witnesses.iter_mut().zip(values).zip(&mut movement) {
            // A mean over the time known so far, later over the memory.
            witness.mean += (value - witness.mean) * elapsed_s / self.weight.max(elapsed_s);
            *movement = value - witness.mean;
            witness.square = keep * witness.square + elapsed_s * *movement * *movement;
        }
        let floor = MOVEMENT * MOVEMENT * self.weight;
        for (index, (a, b)) in PAIRS.into_iter().enumerate() {
            let product = keep * self.products[index] + elapsed_s * movement[a] * movement[b];
            self.products[index] = product;
            let (a, b) = (self.witnesses[a].square, self.witnesses[b].square);
            let moving = a > floor && b > floor && self.weight > 2.0;
            let contradicting = moving && product < CONTRADICTION * (a * b).sqrt();
            self.contradicting_s[index] =
                if contradicting { self.contradicting_s[index] + elapsed_s } else { 0.0 };
        }
    }
}

/// The yaw rate as four witnesses have it, rad/s, if all of them speak and the car is fast enough.
fn witnesses(sample: &Sample, wheels: &Kinematics) -> Option<[f64; 4]> {
    // Any passenger car's steering: only signs are compared, and movements with their floor.
    const WHEELBASE_TIMES_RATIO: f64 = 2.7 * 16.0;
    let speed = wheels.speed.filter(|speed| *speed > FAST)?;
    let steering = sample.get(Quantity::SteeringWheelAngle)? / WHEELBASE_TIMES_RATIO;
    Some([
        sample.get(Quantity::YawRate)?,
        wheels.yaw_rate?,
        sample.get(Quantity::LateralAcceleration)? / speed,
        steering * speed / (1.0 + 0.0025 * speed * speed),
    ])
}
