//! Does a single wheel brake, and turn the car?
//!
//! ESP turns a car by braking single wheels. The axles' equations know no such moment and take it for a lateral
//! force: a stiffness comes out several times too high. But a braked wheel slips. Once the difference of the radii is
//! known, the curve gives the speed of both wheels of an axle; a wheel that is slower, though neither driver nor
//! engine brakes or drives it, is braked alone. The driver's own braking in a curve, where the loads differ, looks
//! the same and is left to the equations; so does the engine's drag, of which the inner wheel, that carries less, takes
//! more slip. What else an axle's wheels differ by in curves (camber, soft tires, unequal roads) is learned as noise.

use nalgebra::vector;

use crate::estimate::kinematics::{Car, Kinematics};
use crate::filter::{Gaussian, LearnedNoise};
use crate::model::{DrivenAxle, GRAVITY};

/// Tuned with the tests `long_drives` (hours of motorway) and `campaign`.
struct Tuning {
    /// How much two tires of an axle may differ in radius, relative, and by how much more as time goes, 1/√s.
    radii: (f64, f64),
    /// How much the loads of a curve may change that, relative for each g.
    pressed: f64,
    /// How well track width and yaw rate tell the difference that a curve makes, relative.
    geometry_std: f64,
    /// So little slip of one wheel alone turns no car.
    hardly: f64,
    /// With this force along the car, over its weight, or more, its driven wheels drive.
    driving: f64,
    /// No brake turns a car for longer, s: it is something else.
    longest_s: f64,
    /// What a force makes of unequal loads is uncertain by this share of itself.
    loads_std: f64,
    /// Windows that the learned noise remembers.
    noise_memory: f64,
}

const TUNING: Tuning = Tuning {
    radii: (0.004, 2e-4),
    pressed: 0.01,
    geometry_std: 0.03,
    hardly: 1e-3,
    driving: 0.01,
    longest_s: 3.0,
    loads_std: 0.5,
    noise_memory: 100.0,
};

/// Watches the difference between left and right of both axles.
#[derive(Clone, Debug)]
pub struct SingleBrake {
    car: Car,
    /// By how much more the left wheel turns than the right one, relative, of each axle: on a straight road, by how
    /// much more for each g sideways, and for each g sideways times force along the axle over its load. The outer tire
    /// is pressed flatter and turns faster; the inner one slips more.
    radii: [Gaussian<3>; 2],
    /// How much more than the rest they differ.
    noise: [LearnedNoise; 2],
    is_driven: [bool; 2],
    /// Of one wheel's speed, m/s.
    wheel_noise: f64,
    sums: Sums,
    /// For how long one has been seen, s.
    lasting_s: f64,
}

/// Sums over a window.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    /// Speed of the left wheels less that of the right ones, less what the curve makes of it, relative.
    excess: [f64; 2],
    /// Curvature of the path, 1/m.
    turning: f64,
    /// Normalized force along the car, and acceleration across it, g.
    along: f64,
    across: f64,
    is_braking: bool,
}

impl SingleBrake {
    /// So many deviations are no chance. Statistical: one healthy window of an axle in 16,000.
    const CLEAR: f64 = 4.0;

    /// For this car; `wheel_noise` is that of one wheel's speed, m/s.
    pub fn new(car: &Car, wheel_noise: f64) -> Self {
        Self {
            radii: std::array::from_fn(|axle| {
                // Of two wheels with the same force: ± 2 h a_y / (g track) of the load.
                let loads = 4.0 * car.cg_height / (car.track[axle] * car.slope_prior[axle].0);
                let std = [TUNING.radii.0, TUNING.pressed, TUNING.loads_std * loads];
                Gaussian::new([0.0, 0.0, loads], std)
            }),
            noise: [LearnedNoise::new(TUNING.noise_memory); 2],
            car: car.clone(),
            is_driven: [car.driven_axle != DrivenAxle::Rear, car.driven_axle != DrivenAxle::Front],
            wheel_noise,
            sums: Sums::default(),
            lasting_s: 0.0,
        }
    }

    /// Takes a sample; `along` is the normalized force along the car.
    pub fn add(&mut self, now: &Kinematics, along: f64) {
        let (Some([fl, fr, rl, rr]), Some(yaw_rate), Some(speed), Some(angle), Some(across)) =
            (now.wheels, now.yaw_rate, now.speed, now.road_angle, now.lateral_acceleration)
        else {
            return;
        };
        let turning = yaw_rate / speed;
        let sums = &mut self.sums;
        sums.count += 1.0;
        sums.excess[0] += (fl - fr) / speed + turning * self.car.track[0] * angle.cos();
        sums.excess[1] += (rl - rr) / speed + turning * self.car.track[1];
        sums.turning += turning;
        sums.along += along;
        sums.across += across / GRAVITY;
        sums.is_braking |= now.braking == Some(true);
    }

    /// At a window's end: was a single wheel braked in it? Learns the radii where not.
    pub fn end(&mut self, speed: f64, elapsed_s: f64) -> bool {
        let sums = std::mem::take(&mut self.sums);
        if sums.count == 0.0 {
            return false;
        }
        let drives = sums.along > TUNING.driving * sums.count;
        let white = std::f64::consts::SQRT_2 * self.wheel_noise / speed / sums.count.sqrt();
        let (across, forces) = (sums.across / sums.count, self.car.axle_forces(sums.along / sums.count));
        let mut is_braked = false;
        let mut seen = [None; 2];
        for (axle, radii) in self.radii.iter_mut().enumerate() {
            let geometry = TUNING.geometry_std * self.car.track[axle] * sums.turning / sums.count;
            let promised = white * white + geometry * geometry + TUNING.hardly * TUNING.hardly;
            radii.inflate(0, TUNING.radii.1 * TUNING.radii.1 * elapsed_s);
            let h = vector![1.0, across, across * forces[axle]];
            let residual = sums.excess[axle] / sums.count - h.dot(&radii.mean);
            let variance = self.noise[axle].variance(promised);
            let innovation = radii.innovation(&h, residual, variance);
            let differs = innovation.normalized().abs() > Self::CLEAR;
            seen[axle] = Some((innovation, promised));
            if !differs {
                radii.update(&h, residual, variance);
            }
            is_braked |= differs && !sums.is_braking && !(drives && self.is_driven[axle]);
        }
        self.lasting_s = if is_braked { self.lasting_s + elapsed_s } else { 0.0 };
        let is_braked = is_braked && self.lasting_s < TUNING.longest_s;
        if !is_braked {
            for (noise, seen) in self.noise.iter_mut().zip(seen) {
                if let Some((innovation, promised)) = seen {
                    noise.learn(&innovation, promised);
                }
            }
        }
        is_braked
    }

    /// The window has no end.
    pub fn stop(&mut self) {
        self.sums = Sums::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Wheel;
    use crate::model::Vehicle;

    const WINDOW_S: f64 = 0.4;

    /// A window of driving at 20 m/s with this yaw rate, the left front wheel slipping by so much.
    fn window(
        single: &mut SingleBrake,
        car: &Car,
        yaw_rate: f64,
        slip: f64,
        along: f64,
        pedal: bool,
    ) -> bool {
        let mut wheels = Wheel::ALL.map(|wheel| car.wheel_plane_speed(wheel, 20.0, 0.0, yaw_rate, 0.0));
        // Its tire is larger than the other.
        wheels[0] *= 1.002 * (1.0 - slip);
        let now = Kinematics {
            elapsed_s: 0.01,
            speed: Some(20.0),
            wheels: Some(wheels),
            yaw_rate: Some(yaw_rate),
            lateral_acceleration: Some(20.0 * yaw_rate),
            longitudinal_acceleration: None,
            road_angle: Some(0.0),
            rear_angle: 0.0,
            axle_torque: None,
            braking: Some(pedal),
            abs: None,
        };
        for _ in 0..40 {
            single.add(&now, along);
        }
        single.end(20.0, WINDOW_S)
    }

    fn familiar(car: &Car) -> SingleBrake {
        let mut single = SingleBrake::new(car, 0.03);
        for i in 0..50 {
            let yaw_rate = 0.2 * (f64::from(i) * 0.3).sin();
            assert!(!window(&mut single, car, yaw_rate, 0.0, 0.0, false));
        }
        single
    }

    #[test]
    fn a_wheel_braked_alone_is_seen_in_a_curve_too_until_it_lasts_too_long() {
        let car = Car::new(&Vehicle::thesis());
        for yaw_rate in [0.0, 0.2] {
            let mut single = familiar(&car);
            let seen = (0..20).take_while(|_| window(&mut single, &car, yaw_rate, 0.01, -0.2, false)).count();
            assert!((5..=8).contains(&seen), "{seen} windows");
            assert!(!window(&mut single, &car, yaw_rate, 0.0, 0.0, false));
        }
    }

    #[test]
    fn engine_and_driver_make_wheels_slip_as_well() {
        let car = Car::new(&Vehicle::thesis());
        assert_eq!(car.driven_axle, DrivenAxle::Front);
        let mut single = familiar(&car);
        assert!(!window(&mut single, &car, 0.1, -0.01, 0.2, false));
        assert!(!window(&mut single, &car, 0.1, 0.01, -0.2, true));
        assert!(window(&mut single, &car, 0.1, 0.01, -0.2, false));
    }
}
