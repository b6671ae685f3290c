//! The car stands, and the yaw rate sensor shows its offset.
//!
//! Most wheel sensors send zero below a walking pace, too. So the readings of one second count only after the wheels
//! have stood for another.

use crate::estimate::kinematics::Kinematics;

/// Tuned with the test `long_drives`: wheels that creep.
struct Tuning {
    /// With all wheels slower than this the car stands or creeps, m/s.
    standing_below: f64,
    /// The car needs this time to swing back after a stop, s.
    swings_s: f64,
    /// Readings are averaged over this time, s.
    together_s: f64,
}

const TUNING: Tuning = Tuning { standing_below: 0.1, swings_s: 0.5, together_s: 1.0 };

/// Collects the yaw rate while the wheels stand.
#[derive(Clone, Copy, Debug, Default)]
pub struct Standstill {
    standing_s: f64,
    now: Readings,
    /// Those of the second before.
    before: Option<Readings>,
}

/// Yaw rates of a second.
#[derive(Clone, Copy, Debug, Default)]
struct Readings {
    seconds: f64,
    count: f64,
    sum: f64,
}

impl Standstill {
    /// Takes a sample; the mean yaw rate and the number of samples of a second in which the car stood.
    pub fn step(&mut self, now: &Kinematics) -> Option<(f64, f64)> {
        let wheels = now.wheels?;
        if wheels.iter().any(|wheel| wheel.abs() > TUNING.standing_below) {
            *self = Self::default();
            return None;
        }
        self.standing_s += now.elapsed_s;
        let yaw_rate = now.yaw_rate?;
        if self.standing_s <= TUNING.swings_s {
            return None;
        }
        self.now.seconds += now.elapsed_s;
        self.now.count += 1.0;
        self.now.sum += yaw_rate;
        if self.now.seconds < TUNING.together_s {
            return None;
        }
        let stood = self.before.replace(std::mem::take(&mut self.now))?;
        Some((stood.sum / stood.count, stood.count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(wheel: f64, yaw_rate: f64) -> Kinematics {
        Kinematics {
            elapsed_s: 0.01,
            speed: Some(wheel),
            wheels: Some([wheel; 4]),
            yaw_rate: Some(yaw_rate),
            lateral_acceleration: Some(0.0),
            longitudinal_acceleration: None,
            road_angle: Some(0.0),
            rear_angle: 0.0,
            axle_torque: None,
            braking: None,
            abs: None,
        }
    }

    #[test]
    fn a_second_counts_once_the_wheels_have_stood_for_another() {
        let mut standstill = Standstill::default();
        // Stands, then creeps off below what its wheels show.
        let yaw_rate = |i: u32| if i < 380 { 0.002 } else { 0.03 };
        let seen: Vec<_> = (0..430).filter_map(|i| standstill.step(&sample(0.0, yaw_rate(i)))).collect();
        assert!(
            seen.len() == 2 && seen.iter().all(|(mean, count)| (mean - 0.002).abs() < 1e-12 && *count > 90.0)
        );
        assert_eq!(standstill.step(&sample(0.4, 0.04)), None);
        assert!((0..230).all(|_| standstill.step(&sample(0.0, 0.002)).is_none()));
    }
}
