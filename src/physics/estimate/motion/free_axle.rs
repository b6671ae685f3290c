//! The axle that rolls freely as a witness: its outer wheel turns faster, and its wheels roll at one speed.
//!
//! Wheels differ in radius, a little more so under load. That is learned, and only what changes within seconds is compared:
//! does it come later, and is it larger by a factor.

use super::lateness::Lateness;
use super::proportion::Proportion;
use crate::estimate::kinematics::{Car, Kinematics};
use crate::estimate::lasting::Lasting;
use crate::model::DrivenAxle;

/// Tuned with the tests `one_channel` and `real_cars`.
struct Tuning {
    /// What changes more slowly than within this time is not compared, s.
    level_s: f64,
    /// The difference of radii is the mean of so many seconds, s.
    radii_s: f64,
    /// Both wheels are compared over so many seconds: rough roads disturb each by itself.
    speeds_s: f64,
    /// Wheel speeds and yaw rate come with so different delays in sound cars, s.
    delays_s: f64,
    /// … and both wheels, as far as radii and offsets of the gyro feign it, s.
    wheels_s: f64,
    /// The yaw rate is smoothed over this time, s, before factors are compared; that is taken from so many seconds, and
    /// one error lasts so long.
    smooth_s: f64,
    memory_s: f64,
    error_lasts_s: f64,
    /// Beyond this lateral acceleration, m/s², an inner wheel hardly carries anything, and slips.
    most_lateral: f64,
    /// Geometry makes a factor of so much. In a curve the outer wheel is pressed smaller and turns still faster, by a share
    /// that grows with the square of the speed: at 1 m/s the gyro may show more and less than the wheels by these. So many
    /// deviations are chance.
    factor: f64,
    factor_of_load: [f64; 2],
    deviations: f64,
    /// … but only where there is that much turning to compare, rad/s (rms).
    least: f64,
    /// A doubt ends at this share of what it begins at.
    ends: f64,
}

const TUNING: Tuning = Tuning {
    level_s: 4.0,
    radii_s: 60.0,
    speeds_s: 25.0,
    delays_s: 0.03,
    wheels_s: 0.01,
    smooth_s: 0.3,
    memory_s: 20.0,
    error_lasts_s: 0.6,
    most_lateral: 5.0,
    factor: 0.1,
    factor_of_load: [1e-4, 4e-4],
    deviations: 3.0,
    least: 0.02,
    ends: 0.8,
};

/// What the axle says of the yaw rate, and its wheels of each other.
#[derive(Clone, Copy, Debug)]
pub struct FreeAxle {
    /// Its wheels in the order of [`Wheel::ALL`](crate::Wheel::ALL), and their distance, m; none where all are driven.
    wheels: Option<([usize; 2], f64)>,
    /// Yaw rate by gyro and wheels, and speed by both wheels: what of it is slow.
    slow: Option<[[f64; 2]; 2]>,
    /// What the wheels turn too fast for the gyro at 1 m/s, rad/s, and for how long it has been learned, s.
    radii: (f64, f64),
    yaw_rate: Lateness,
    speed: Lateness,
    factor: Factor,
}

/// Is the gyro's yaw rate that of the wheels times a factor?
#[derive(Clone, Copy, Debug, Default)]
struct Factor {
    smooth: [f64; 2],
    proportion: Proportion,
    /// Mean square of the speed, m²/s².
    speed_square: f64,
    seen_s: f64,
    doubt: Lasting,
}

impl FreeAxle {
    /// Of this car.
    pub fn new(car: &Car) -> Self {
        let wheels = match car.driven_axle {
            DrivenAxle::Front => Some(([2, 3], car.track[1])),
            DrivenAxle::Rear => Some(([0, 1], car.track[0])),
            DrivenAxle::All => None,
        };
        Self {
            wheels,
            slow: None,
            radii: (0.0, 0.0),
            yaw_rate: Lateness::default(),
            speed: Lateness::of_seconds(TUNING.speeds_s),
            factor: Factor::default(),
        }
    }

    /// Takes a sample and the yaw rate as the gyro has it: its offset is slow. A braked wheel slips.
    pub fn step(&mut self, now: &Kinematics, yaw_rate: f64) {
        let (Some(([left, right], track)), Some(wheels)) = (self.wheels, now.wheels) else { return };
        let is_sharp = (0.5 * (wheels[left] + wheels[right]) * yaw_rate).abs() > TUNING.most_lateral;
        if now.braking == Some(true) || is_sharp || wheels[left].is_nan() || wheels[right].is_nan() {
            self.slow = None;
            return;
        }
        let cosine = now.road_angle.filter(|_| left == 0).map_or(1.0, f64::cos);
        let speed = 0.5 * (wheels[left] + wheels[right]);
        let by_wheels = (wheels[right] - wheels[left]) / (track * cosine);
        let (by_radii, learned_s) = &mut self.radii;
        *learned_s += now.elapsed_s;
        let weight = now.elapsed_s / learned_s.min(TUNING.radii_s);
        *by_radii += weight.min(1.0) * ((by_wheels - yaw_rate) / speed - *by_radii);
        let by_wheels = by_wheels - *by_radii * speed;
        let turning = 0.5 * track * cosine * (yaw_rate + *by_radii * speed);
        let signals = [[yaw_rate, by_wheels], [wheels[left] + turning, wheels[right] - turning]];
        let slow = self.slow.get_or_insert(signals);
        let weight = (now.elapsed_s / TUNING.level_s).min(1.0);
        let mut quick = signals;
        for ((slow, quick), signal) in
            slow.iter_mut().flatten().zip(quick.iter_mut().flatten()).zip(signals.as_flattened())
        {
            *slow += weight * (signal - *slow);
            *quick -= *slow;
        }
        self.yaw_rate.step(quick[0], 0.0, TUNING.delays_s, now.elapsed_s);
        self.speed.step(quick[1], 0.0, TUNING.wheels_s, now.elapsed_s);
        self.factor.step(quick[0], speed, now.elapsed_s);
    }

    /// How much later than the wheels the yaw rate comes (s), and for how long it has been too much (s). Wheels that come
    /// late do no harm.
    pub fn yaw_rate_is_late(&self) -> Option<(f64, f64)> {
        Some((self.yaw_rate.late_s(), self.yaw_rate.doubt().lasts_s()?)).filter(|(by_s, _)| *by_s > 0.0)
    }

    /// How much later than the right wheel the left one comes (s), and for how long it has been too much (s).
    pub fn left_wheel_is_late(&self) -> Option<(f64, f64)> {
        Some((self.speed.late_s(), self.speed.doubt().lasts_s()?))
    }

    /// By how much the yaw rate differs from that of the wheels (rms, rad/s), of how much (rms), and for how long it has
    /// been too much (s).
    pub fn yaw_rate_is_scaled(&self) -> Option<(f64, f64, f64)> {
        let Factor { proportion, doubt, .. } = &self.factor;
        let of = proportion.square().sqrt();
        Some(((proportion.factor() - 1.0).abs() * of, of, doubt.lasts_s()?))
    }

    /// The car stood, or nothing was measured. Its wheels are the same.
    pub fn stop(&mut self) {
        (self.slow, self.factor) = (None, Factor::default());
        (self.yaw_rate, self.speed) = (Lateness::default(), Lateness::of_seconds(TUNING.speeds_s));
    }
}

impl Factor {
    fn step(&mut self, signals: [f64; 2], speed: f64, elapsed_s: f64) {
        let weight = (elapsed_s / TUNING.smooth_s).min(1.0);
        for (smooth, signal) in self.smooth.iter_mut().zip(signals) {
            *smooth += weight * (signal - *smooth);
        }
        self.seen_s += elapsed_s;
        let memory = (elapsed_s / self.seen_s.min(TUNING.memory_s)).min(1.0);
        self.proportion.step(self.smooth, memory);
        self.speed_square += memory * (speed * speed - self.speed_square);
        let (factor, square) = (self.proportion.factor(), self.proportion.square());
        let of_load = TUNING.factor_of_load[usize::from(factor < 1.0)];
        let allowed = TUNING.factor + of_load * self.speed_square;
        let worth = self.seen_s.min(TUNING.memory_s) / TUNING.error_lasts_s;
        let chance = TUNING.deviations * self.proportion.std(worth);
        let is_off = self.seen_s > TUNING.memory_s / 4.0
            && square > TUNING.least * TUNING.least
            && (factor - 1.0).abs() > self.doubt.limit(TUNING.ends) * (allowed + chance);
        self.doubt.step(is_off, elapsed_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;

    /// Winds along at changing speed; the gyro has a gain and comes late, and so does the rear left wheel, which is a bit
    /// small.
    fn drive(gain: f64, late_s: f64, wheel_late_s: f64) -> FreeAxle {
        let car = Car::new(&Vehicle { driven_axle: DrivenAxle::Front, ..Vehicle::thesis() });
        let mut axle = FreeAxle::new(&car);
        let yaw_rate = |t: f64| 0.2 * (0.9 * t).sin() + 0.05 * (2.3 * t).sin();
        let speed = |t: f64| 13.0 + 3.0 * (0.4 * t).sin();
        for i in 0..4000 {
            let t = 0.01 * f64::from(i);
            let left = |t: f64| 1.01 * (speed(t) - 0.5 * car.track[1] * yaw_rate(t));
            let right = speed(t) + 0.5 * car.track[1] * yaw_rate(t);
            let now = Kinematics {
                elapsed_s: 0.01,
                speed: Some(speed(t)),
                wheels: Some([speed(t), speed(t), left(t - wheel_late_s), right]),
                yaw_rate: None,
                lateral_acceleration: None,
                longitudinal_acceleration: None,
                road_angle: Some(0.0),
                rear_angle: 0.0,
                axle_torque: None,
                braking: Some(false),
                abs: None,
            };
            axle.step(&now, gain * yaw_rate(t - late_s));
        }
        axle
    }

    #[test]
    fn a_sound_gyro_and_wheels_are_not_doubted() {
        for (gain, late_s, wheel_late_s) in [(1.0, 0.0, 0.0), (1.05, 0.03, 0.0), (0.95, -0.2, 0.01)] {
            let axle = drive(gain, late_s, wheel_late_s);
            assert_eq!(axle.yaw_rate_is_late(), None, "{axle:?}");
            assert_eq!(axle.left_wheel_is_late(), None, "{axle:?}");
            assert_eq!(axle.yaw_rate_is_scaled(), None, "{axle:?}");
        }
    }

    #[test]
    fn what_is_late_or_scaled_is_told() {
        let (by_s, _) = drive(1.0, 0.1, 0.0).yaw_rate_is_late().unwrap();
        assert!((by_s - 0.1).abs() < 0.02, "{by_s}");
        let (by_s, _) = drive(1.0, 0.0, 0.1).left_wheel_is_late().unwrap();
        assert!((by_s - 0.1).abs() < 0.03, "{by_s}");
        for gain in [0.75, 1.25] {
            let (off, of, lasts_s) = drive(gain, 0.0, 0.0).yaw_rate_is_scaled().unwrap();
            assert!((off / of - 0.25).abs() < 0.05 && lasts_s > 10.0, "{gain}: {off} {of} {lasts_s}");
        }
    }
}
