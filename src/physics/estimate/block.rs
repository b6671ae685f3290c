//! Averages of a few samples: what the slip estimators work on.
//!
//! Wheel-speed noise is as large as the slip of normal driving. Averaging slip and force over the
//! same quarter of a second costs nothing that a tire's slope would notice, keeps the noise in the
//! regressor small (it would bias the slope), and gives the acceleration as the slope of a line
//! through all samples rather than as a difference of two.

use super::kinematics::Kinematics;

/// Means over a block, and least-squares rates of change.
#[derive(Clone, Copy, Debug, Default)]
pub struct Block {
    /// Samples in it.
    pub samples: f64,
    /// Its length, s.
    pub duration_s: f64,
    /// Forward speed, m/s.
    pub speed: f64,
    /// Rate of change of the forward speed, m/s².
    pub acceleration: f64,
    /// Circumferential speed of each wheel, m/s; not-a-number where the car does not tell.
    pub wheels: [f64; 4],
    /// Its rate of change, m/s².
    pub wheel_acceleration: [f64; 4],
    /// Standard deviation of one sample's difference between front and rear wheel, left and right,
    /// around its trend, m/s: sensor noise, and the roughness of the road.
    pub difference_std: [f64; 2],
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Lateral acceleration, m/s².
    pub lateral_acceleration: f64,
    /// Road wheel angle, rad.
    pub road_angle: f64,
    /// Longitudinal acceleration as measured, m/s².
    pub longitudinal_acceleration: Option<f64>,
    /// Standard deviation of one sample of it, around its trend, m/s².
    pub longitudinal_acceleration_std: f64,
    /// Axle torque, N m.
    pub axle_torque: Option<f64>,
    /// Did the driver brake at any time? `None` where the bus does not tell.
    pub braking: Option<bool>,
}

/// Sums from which a [`Block`] is made.
#[derive(Clone, Debug)]
pub struct BlockBuilder {
    length_s: f64,
    time: f64,
    sums: Sums,
}

#[derive(Clone, Debug, Default)]
struct Sums {
    count: f64,
    time: f64,
    time_square: f64,
    lines: Lines,
    yaw_rate: f64,
    lateral_acceleration: f64,
    road_angle: f64,
    longitudinal_acceleration: Optional,
    axle_torque: Optional,
    braking: Option<bool>,
}

/// Sums of the quantities, of their squares, and of their products with time, side by side for vector instructions.
#[derive(Clone, Copy, Debug, Default)]
struct Lines {
    sum: [f64; LINES],
    square: [f64; LINES],
    product: [f64; LINES],
}

/// Where each quantity is: the speed, the wheels, front less rear on both sides, and the longitudinal acceleration.
const SPEED: usize = 0;
const WHEELS: [usize; 4] = [1, 2, 3, 4];
const DIFFERENCES: [usize; 2] = [5, 6];
const LONGITUDINAL: usize = 7;
const LINES: usize = 8;

impl Lines {
    fn add(&mut self, time: f64, values: [f64; LINES]) {
        for (i, value) in values.into_iter().enumerate() {
            self.sum[i] += value;
            self.square[i] += value * value;
            self.product[i] += time * value;
        }
    }
}

/// A sum that is only good if no sample lacked the quantity.
#[derive(Clone, Copy, Debug, Default)]
struct Optional {
    sum: f64,
    count: f64,
}

impl Optional {
    fn add(&mut self, value: Option<f64>) {
        if let Some(value) = value {
            self.sum += value;
            self.count += 1.0;
        }
    }

    fn mean(&self, needed: f64) -> Option<f64> {
        (self.count == needed && needed > 0.0).then(|| self.sum / self.count)
    }
}

impl BlockBuilder {
    /// Blocks of `length_s` seconds.
    pub fn new(length_s: f64) -> Self {
        Self { length_s, time: 0.0, sums: Sums::default() }
    }

    /// Takes a sample; gives a block when one is complete. A sample without wheel speeds, yaw rate
    /// or steering angle, and a gap in time, end the block without a result.
    pub fn step(&mut self, now: &Kinematics) -> Option<Block> {
        let (Some(speed), Some(wheels), Some(yaw_rate), Some(lateral), Some(angle)) =
            (now.speed, now.wheels, now.yaw_rate, now.lateral_acceleration, now.road_angle)
        else {
            self.reset();
            return None;
        };
        if now.elapsed_s > 0.5 * self.length_s {
            self.reset();
        }
        let sums = &mut self.sums;
        let time = self.time;
        sums.count += 1.0;
        sums.time += time;
        sums.time_square += time * time;
        let [fl, fr, rl, rr] = wheels;
        let acceleration = now.longitudinal_acceleration.unwrap_or(0.0);
        sums.lines.add(time, [speed, fl, fr, rl, rr, fl - rl, fr - rr, acceleration]);
        sums.yaw_rate += yaw_rate;
        sums.lateral_acceleration += lateral;
        sums.road_angle += angle;
        sums.longitudinal_acceleration.add(now.longitudinal_acceleration);
        sums.axle_torque.add(now.axle_torque);
        if let Some(braking) = now.braking {
            sums.braking = Some(sums.braking.unwrap_or(false) || braking);
        }
        self.time += now.elapsed_s;
        // Half a sample of tolerance: the sum of many periods is not exactly the block's length.
        if self.time + 0.5 * now.elapsed_s < self.length_s {
            return None;
        }
        let block = sums.block(self.time);
        self.reset();
        block
    }

    fn reset(&mut self) {
        self.time = 0.0;
        self.sums = Sums::default();
    }
}

impl Sums {
    fn block(&self, duration_s: f64) -> Option<Block> {
        let n = self.count;
        let spread = self.time_square - self.time * self.time / n;
        if n < 3.0 || spread <= 0.0 {
            return None;
        }
        let Lines { sum, square, product } = &self.lines;
        let rate = |line: usize| (product[line] - self.time * sum[line] / n) / spread;
        let scatter = |line: usize| {
            let around_mean = square[line] - sum[line] * sum[line] / n;
            if around_mean.is_nan() {
                return f64::NAN;
            }
            let explained = rate(line).powi(2) * spread;
            ((around_mean - explained).max(0.0) / (n - 2.0)).sqrt()
        };
        Some(Block {
            samples: n,
            duration_s,
            speed: sum[SPEED] / n,
            acceleration: rate(SPEED),
            wheels: WHEELS.map(|line| sum[line] / n),
            wheel_acceleration: WHEELS.map(rate),
            difference_std: DIFFERENCES.map(scatter),
            longitudinal_acceleration_std: scatter(LONGITUDINAL),
            yaw_rate: self.yaw_rate / n,
            lateral_acceleration: self.lateral_acceleration / n,
            road_angle: self.road_angle / n,
            longitudinal_acceleration: self.longitudinal_acceleration.mean(n),
            axle_torque: self.axle_torque.mean(n),
            braking: self.braking,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Car;
    use crate::model::Vehicle;
    use crate::{Micros, Quantity, Sample};

    #[test]
    fn a_block_of_steady_acceleration_gives_that_acceleration() {
        let car = Car::new(&Vehicle::thesis());
        let mut builder = BlockBuilder::new(0.25);
        let mut blocks = Vec::new();
        for i in 0..50 {
            let mut sample = Sample::empty(Micros(i * 10_000), 0.01);
            let speed = 10.0 + 2.0 * 0.01 * i as f64;
            for quantity in &Quantity::ALL[..4] {
                sample.set(*quantity, speed / car.radius);
            }
            for quantity in [Quantity::YawRate, Quantity::LateralAcceleration, Quantity::SteeringWheelAngle] {
                sample.set(quantity, 0.0);
            }
            blocks.extend(builder.step(&Kinematics::new(&sample, &car)));
        }
        assert_eq!(blocks.len(), 2);
        assert!((blocks[1].acceleration - 2.0).abs() < 1e-9);
        assert!((blocks[1].speed - (10.0 + 0.02 * 37.0)).abs() < 1e-9);
        assert_eq!(blocks[1].axle_torque, None);
    }
}
