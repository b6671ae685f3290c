//! Means over short windows, with the yaw acceleration between the windows before and after.

use crate::estimate::kinematics::{Car, Cornering, Kinematics};
use crate::model::GRAVITY;

/// Length of a window, s. Tuned with the test `campaign`: shorter than a tire's answer to the steering.
const LENGTH_S: f64 = 0.05;

/// A window's means, sensor offsets taken off.
#[derive(Clone, Copy, Debug, Default)]
pub struct Window {
    /// Its length, s.
    pub elapsed_s: f64,
    /// Forward speed, m/s.
    pub speed: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Road wheel angle in front and that of the rear wheels, rad.
    pub angle: f64,
    pub rear_angle: f64,
    /// Longitudinal force / load of both axles.
    pub along: [f64; 2],
    /// Lateral force / load of both axles, as the sensors have it.
    pub force: [f64; 2],
    /// How fast these change, 1/s.
    pub force_rate: [f64; 2],
    /// Change of the lateral velocity by what was felt and turned, m/s.
    pub pushed: f64,
    /// Samples in it.
    pub samples: f64,
    across: f64,
}

/// Collects them.
#[derive(Clone, Debug, Default)]
pub struct Windows {
    sum: Window,
    /// The last two that ended.
    ended: [Option<Window>; 2],
}

impl Windows {
    /// Takes a sample. A window that ended before the last one is complete: its yaw acceleration is known.
    pub fn step(
        &mut self,
        car: &Car,
        now: &Cornering,
        &Kinematics { elapsed_s, rear_angle, .. }: &Kinematics,
        along: [f64; 2],
        [angle_offset, ay_offset, yaw_offset]: [f64; 3],
    ) -> Option<Window> {
        let sum = &mut self.sum;
        let (yaw_rate, across) = (now.yaw_rate - yaw_offset, now.lateral_acceleration - ay_offset);
        sum.elapsed_s += elapsed_s;
        sum.speed += now.speed;
        sum.yaw_rate += yaw_rate;
        sum.angle += now.road_angle - angle_offset;
        sum.rear_angle += rear_angle;
        sum.across += across;
        sum.along.iter_mut().zip(along).for_each(|(sum, along)| *sum += along);
        sum.samples += 1.0;
        sum.pushed += (across - now.speed * yaw_rate) * elapsed_s;
        if sum.elapsed_s < LENGTH_S - 1e-6 {
            return None;
        }
        let n = sum.samples;
        let mut ended = std::mem::take(sum);
        for mean in [
            &mut ended.speed,
            &mut ended.yaw_rate,
            &mut ended.angle,
            &mut ended.rear_angle,
            &mut ended.across,
        ] {
            *mean /= n;
        }
        ended.along = ended.along.map(|sum| sum / n);
        let [first, second] = self.ended;
        self.ended = [second, Some(ended)];
        let (first, mut middle) = (first?, second?);
        let between = 0.5 * (first.elapsed_s + ended.elapsed_s) + middle.elapsed_s;
        let yaw_acceleration = (ended.yaw_rate - first.yaw_rate) / between;
        middle.force = axle_forces(car, middle.across, yaw_acceleration);
        let rate = (ended.across - first.across) / between;
        middle.force_rate = axle_forces(car, rate, 0.0);
        Some(middle)
    }
}

/// Normalized forces of both axles from the acceleration across (m/s²) and the yaw acceleration (rad/s²).
pub fn axle_forces(car: &Car, across: f64, yaw_acceleration: f64) -> [f64; 2] {
    let turning = car.yaw_inertia / car.mass * yaw_acceleration;
    [(across + turning / car.b) / GRAVITY, (across - turning / car.a) / GRAVITY]
}
