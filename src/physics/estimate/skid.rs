//! Friction from a car that skids: its rear axle slides sideways, far beyond the slip angle of the greatest force.
//!
//! The lateral velocity at the rear axle is v_y − b r, with v̇_y = a_y − v r. What it has changed by within seconds needs no
//! model of tires. Where that is a large part of the speed, and the force works against it, the tires are beyond their
//! peaks, and the acceleration in the road's plane is what the road gives.

use super::kinematics::{Car, Cornering, Kinematics};
use crate::filter::Fading;
use crate::model::GRAVITY;

/// Tuned with the drives 9001 to 9060 of the test `campaign`: in 5,240 samples of 13 that skid the acceleration was 0.73 to
/// 1.02 of the friction (98 %), 0.87 in the median.
struct Tuning {
    /// What the lateral velocity has changed by is forgotten over this time, s, offsets and banks with it. Not in a skid.
    remembers_s: f64,
    /// It is a skid beyond this slip angle of the rear axle, rad, …
    angle: f64,
    /// … what offsets and banks can make, m/s, left aside, …
    drift: f64,
    /// … while a_y and v r disagree by this, m/s², in the mean over this time, s; once they hardly do, the car has caught
    /// itself.
    apart: (f64, f64),
    caught: f64,
    /// It begins while the car turns more than its front wheels ask for, rad at the front axle: on a banked curve it does not.
    oversteers: f64,
    /// This share of the acceleration is across the car, against the skid.
    across: f64,
    /// The acceleration is smoothed over this time, s.
    smoothing_s: f64,
    /// Tires beyond their peaks, unequally loaded, give this share of the friction.
    given: f64,
    /// Deviations of the friction, relative, downwards and upwards. Brush tires, which give all of it, lie at the lower end.
    std: [f64; 2],
    /// After a gap of so long nothing is known of the motion, s.
    gap_s: f64,
}

const TUNING: Tuning = Tuning {
    remembers_s: 2.0,
    angle: 0.15,
    drift: 1.0,
    apart: (1.0, 0.5),
    caught: 0.5,
    oversteers: 0.03,
    across: 0.8,
    smoothing_s: 0.15,
    given: 0.87,
    std: [0.08, 0.09],
    gap_s: 0.5,
};

/// Friction, as a skid showed it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkidFriction {
    /// Friction.
    pub mu: f64,
    /// Its standard deviations, downwards and upwards.
    pub std: [f64; 2],
}

/// Watches for skids.
#[derive(Clone, Debug)]
pub struct Skid {
    /// Centre of gravity to rear axle, m.
    to_rear: f64,
    wheelbase: f64,
    /// By how much the lateral velocity at the rear axle has changed, m/s.
    change: f64,
    forgets: Fading,
    skids: bool,
    /// The yaw rate before, rad/s.
    yaw_rate: Option<f64>,
    /// Acceleration along and across, smoothed, m/s².
    acceleration: [f64; 2],
    smoothing: Fading,
    /// |a_y − v r|, smoothed, m/s².
    apart: f64,
    apart_over: Fading,
}

impl Skid {
    /// Of this car.
    pub fn new(car: &Car) -> Self {
        Self {
            to_rear: car.b,
            wheelbase: car.wheelbase(),
            change: 0.0,
            forgets: Fading::over(TUNING.remembers_s),
            skids: false,
            yaw_rate: None,
            acceleration: [0.0; 2],
            smoothing: Fading::over(TUNING.smoothing_s),
            apart: 0.0,
            apart_over: Fading::over(TUNING.apart.1),
        }
    }

    /// Takes a sample; the friction, while the car skids.
    pub fn step(&mut self, now: &Kinematics) -> Option<SkidFriction> {
        let Some((Cornering { speed, yaw_rate, lateral_acceleration: across, road_angle }, along)) =
            now.cornering(0.0).zip(now.longitudinal_acceleration)
        else {
            self.yaw_rate = None;
            return None;
        };
        let before = self.yaw_rate.replace(yaw_rate).filter(|_| now.elapsed_s < TUNING.gap_s);
        let Some(before) = before else {
            (self.change, self.skids, self.apart) = (0.0, false, 0.0);
            self.acceleration = [along, across];
            return None;
        };
        let slides_by = across - speed * yaw_rate;
        if !self.skids {
            self.change *= self.forgets.left(now.elapsed_s);
        }
        self.change += slides_by * now.elapsed_s - self.to_rear * (yaw_rate - before);
        for (smoothed, now_is) in self.acceleration.iter_mut().zip([along, across]) {
            self.smoothing.smooth(smoothed, now_is, now.elapsed_s);
        }
        self.apart_over.smooth(&mut self.apart, slides_by.abs(), now.elapsed_s);
        let [along, across] = self.acceleration;
        let is_against = across * self.change < 0.0;
        if self.skids && (self.apart < TUNING.caught || !is_against) {
            self.change = 0.0;
        }
        let oversteers = (self.wheelbase * yaw_rate - road_angle * speed) * yaw_rate.signum();
        self.skids = self.change.abs() > TUNING.angle * speed + TUNING.drift
            && (self.skids || oversteers > TUNING.oversteers * speed);
        let total = along.hypot(across);
        let tells =
            self.skids && is_against && self.apart > TUNING.apart.0 && across.abs() > TUNING.across * total;
        let mu = total / (TUNING.given * GRAVITY);
        tells.then_some(SkidFriction { mu, std: TUNING.std.map(|std| std * mu) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;

    /// Drives at 15 m/s with what the sensors say at each moment, s: yaw rate, accelerations along and across, and the angle of
    /// the front wheels. What is told at last.
    fn driven(seconds: f64, says: impl Fn(f64) -> [f64; 4]) -> Option<SkidFriction> {
        let mut skid = Skid::new(&Car::new(&Vehicle::thesis()));
        let mut told = None;
        for i in 0..(100.0 * seconds) as u32 {
            let [yaw_rate, along, across, road_angle] = says(0.01 * f64::from(i));
            told = skid.step(&Kinematics {
                elapsed_s: 0.01,
                speed: Some(15.0),
                wheels: None,
                yaw_rate: Some(yaw_rate),
                lateral_acceleration: Some(across),
                longitudinal_acceleration: Some(along),
                road_angle: Some(road_angle),
                rear_angle: 0.0,
                axle_torque: None,
                braking: None,
                abs: None,
            });
        }
        told
    }

    #[test]
    fn a_car_that_turns_faster_than_it_is_pushed_across_skids() {
        let told = driven(1.5, |_| [0.8, 0.5, 5.0, 0.05]).unwrap();
        assert!((told.mu - 5.025 / 9.81 / 0.87).abs() < 0.01, "{told:?}");
        assert!(told.std[0] < told.std[1], "{told:?}");
    }

    #[test]
    fn a_curve_a_circle_a_bank_an_offset_and_a_dead_sensor_are_no_skids() {
        assert_eq!(driven(20.0, |_| [0.4, 0.0, 6.0, 0.09]), None);
        // Begun within a tenth of a second, a tight circle moves the centre of gravity's own velocity only.
        let begun = |t: f64| (10.0 * t).min(1.0);
        assert_eq!(driven(5.0, |t| [0.5 * begun(t), 0.0, 7.5 * begun(t), 0.12 * begun(t)]), None);
        assert_eq!(driven(20.0, |_| [0.0, 0.0, 0.7, 0.0]), None);
        // Steep enough to carry most of the curve.
        assert_eq!(driven(20.0, |_| [0.4, 0.2, 2.0, 0.08]), None);
        assert_eq!(driven(20.0, |_| [0.05, 1.0, 0.2, 0.01]), None);
        assert_eq!(driven(5.0, |_| [0.0, 0.0, 5.0, 0.06]), None);
        assert_eq!(driven(5.0, |_| [0.33, 0.0, 0.0, 0.06]), None);
    }

    #[test]
    fn after_the_skid_nothing_is_told_of_it() {
        let caught = |t: f64| if t < 1.5 { [0.8, 0.5, 5.0, 0.05] } else { [0.0, 2.0, 0.1, 0.0] };
        assert_eq!(driven(1.8, caught), None);
        // It has turned to the other side, and drives on in a curve.
        let turned = |t: f64| if t < 1.5 { [0.8, 0.5, 5.0, 0.05] } else { [-0.2, 0.0, -3.0, -0.05] };
        assert_eq!(driven(1.8, turned), None);
        assert_eq!(driven(9.0, turned), None);
    }
}
