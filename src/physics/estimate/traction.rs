//! Slip and normalized traction force of the driven wheels, from a block of samples.

use super::block::Block;
use super::config::SlopeConfig;
use super::kinematics::Car;
use crate::model::{DrivenAxle, GRAVITY};
use crate::{Quantity, Sensors, Wheel};

/// One point of a wheel's slip curve, with what is not known of it.
#[derive(Clone, Copy, Debug)]
pub struct TractionPoint {
    /// Slip against the undriven wheel of the same side (thesis 5.1), SAE, driving positive.
    pub slip: f64,
    /// Standard deviation of the slip's noise.
    pub slip_std: f64,
    /// Traction force / static wheel load (thesis 5.2), less the same of the reference wheel: what the
    /// difference of their slips comes from.
    pub mu: f64,
    /// Standard deviation of `mu`'s noise.
    pub mu_std: f64,
    /// What the wheel's speed were without slip, m/s.
    pub rolling: f64,
}

/// Turns blocks into points of the slip curve.
#[derive(Clone, Debug)]
pub struct Traction {
    car: Car,
    wheel_noise: f64,
    torque_noise: f64,
    acceleration_noise: f64,
    minimum_speed: f64,
    max_lateral: f64,
    max_coasting: f64,
    cornering_slip_std: f64,
}

impl Traction {
    /// Share of the geometric correction for curves that is taken for uncertain. Tuned, no test on record.
    const GEOMETRY_STD: f64 = 0.05;
    /// More slip than this is not taken from geometry alone: in a tight circle its error is the same in all points, and
    /// looks like slip. Tuned with the test `one_channel`: half of the slip of ordinary driving.
    const GEOMETRY_SLIP: f64 = 5e-4;
    /// Beyond this difference of drive torque and acceleration, m/s², brakes are suspected where the bus does not
    /// report them: with an accelerometer, which feels no grade, and with the wheels' acceleration, which contains
    /// it. Tuned with the test `accuracy`.
    const UNEXPLAINED_DECELERATION: [f64; 2] = [0.4, 1.0];

    /// For this car and these sensors.
    pub fn new(car: &Car, sensors: &Sensors, config: &SlopeConfig, minimum_speed: f64) -> Self {
        Self {
            wheel_noise: car.radius * sensors.noise_std(Quantity::WheelSpeedFl),
            torque_noise: car.drive_torque_ratio.abs() * sensors.noise_std(Quantity::DriveTorque),
            acceleration_noise: sensors.noise_std(Quantity::LongitudinalAcceleration),
            minimum_speed,
            max_lateral: config.max_lateral_acceleration_mps2,
            max_coasting: config.max_coasting_deceleration_mps2,
            cornering_slip_std: config.cornering_slip_std,
            car: car.clone(),
        }
    }

    /// One point for each driven wheel; none with all wheels driven (no wheel tells the speed),
    /// while braking, in sharp curves and at low speed.
    pub fn points(&self, block: &Block) -> [Option<TractionPoint>; 4] {
        let mut points = [None; 4];
        if self.car.driven_axle == DrivenAxle::All
            || block.speed < self.minimum_speed
            || block.lateral_acceleration.abs() > self.max_lateral
            || self.is_braking(block)
        {
            return points;
        }
        for wheel in Wheel::ALL.into_iter().filter(|&wheel| self.car.driven_axle.drives(wheel)) {
            points[wheel as usize] = self.point(block, wheel);
        }
        points
    }

    fn point(&self, block: &Block, wheel: Wheel) -> Option<TractionPoint> {
        let car = &self.car;
        let vy = car.steady_lateral_velocity(block.speed, block.yaw_rate, block.lateral_acceleration);
        let reference = wheel.same_side();
        let measured = block.wheels[reference as usize];
        let vx = car.forward_speed(reference, measured, vy, block.yaw_rate, block.road_angle);
        let rolling = car.wheel_plane_speed(wheel, vx, vy, block.yaw_rate, block.road_angle);
        let slip = block.wheels[wheel as usize] / rolling - 1.0;
        // A wheel that is not on the bus has no slip, nor has one without a wheel to compare it with.
        if rolling < 0.5 * self.minimum_speed || slip.is_nan() {
            return None;
        }
        // What the sensors promise, or what the road adds to it.
        let side = usize::from(!wheel.is_left());
        let scatter = block.difference_std[side].max(self.wheel_noise * 2.0_f64.sqrt());
        let white = scatter / block.samples.sqrt() / rolling;
        let geometry = Self::GEOMETRY_STD * (rolling - measured) / rolling;
        if geometry.abs() > Self::GEOMETRY_SLIP {
            return None;
        }
        let cornering = self.cornering_slip_std * block.lateral_acceleration;
        let (force, force_std) = self.force(block, wheel);
        let load = car.load(wheel);
        // The reference wheel slips, too: the road has to turn its inertia.
        let spin = block.wheel_acceleration[reference as usize] / car.radius;
        let reference_mu = -car.wheel_inertia * spin / car.radius / car.load(reference);
        Some(TractionPoint {
            slip,
            slip_std: (white * white + geometry * geometry + cornering * cornering).sqrt(),
            mu: force / load - reference_mu,
            mu_std: force_std / load,
            rolling,
        })
    }

    /// Longitudinal tire force of one driven wheel and its noise, N: from the drive torque when the
    /// bus has it, else from the acceleration of the whole car.
    pub(super) fn force(&self, block: &Block, wheel: Wheel) -> (f64, f64) {
        let car = &self.car;
        if let Some(torque) = block.axle_torque {
            let spin = block.wheel_acceleration[wheel as usize] / car.radius;
            let force = (0.5 * torque - car.wheel_inertia * spin) / car.radius;
            let spin_std = self.rate_std(block) / car.radius;
            let torque_std = 0.5 * self.torque_noise / block.samples.sqrt();
            return (force, torque_std.hypot(car.wheel_inertia * spin_std) / car.radius);
        }
        let (acceleration, noise) = match block.longitudinal_acceleration {
            Some(measured) => {
                let scatter = block.longitudinal_acceleration_std.max(self.acceleration_noise);
                (measured, scatter / block.samples.sqrt())
            }
            None => (block.acceleration, self.rate_std(block)),
        };
        // What the driven axle carries: the body, the other axle's wheels, drag and rolling
        // resistance, and, with steered front wheels, the lateral force's part against the motion.
        let inertia = car.mass + 2.0 * car.wheel_inertia / (car.radius * car.radius);
        let front_lateral = car.mass * block.lateral_acceleration * car.b / car.wheelbase();
        let force = inertia * acceleration
            + car.drag * block.speed * block.speed
            + car.rolling_resistance * car.mass * GRAVITY
            + front_lateral * block.road_angle.sin();
        (0.5 * force, 0.5 * inertia * noise)
    }

    /// Noise of a rate of change fitted through a block, m/s².
    fn rate_std(&self, block: &Block) -> f64 {
        self.wheel_noise * 12.0_f64.sqrt() / (block.duration_s * block.samples.sqrt())
    }

    fn is_braking(&self, block: &Block) -> bool {
        if let Some(braking) = block.braking {
            return braking;
        }
        let [with_accelerometer, with_wheels] = Self::UNEXPLAINED_DECELERATION;
        let (acceleration, tolerance) = match block.longitudinal_acceleration {
            Some(measured) => (measured, with_accelerometer),
            None => (block.acceleration, with_wheels),
        };
        match self.driving(block) {
            Some(driving) => driving - acceleration > tolerance,
            None => -(acceleration + self.resisting(block)) > self.max_coasting,
        }
    }

    /// Deceleration by drag and rolling resistance, m/s².
    fn resisting(&self, block: &Block) -> f64 {
        self.car.drag * block.speed * block.speed / self.car.mass + self.car.rolling_resistance * GRAVITY
    }

    /// What the torque tells of the acceleration, m/s², where the bus has it.
    fn driving(&self, block: &Block) -> Option<f64> {
        let torque = block.axle_torque?;
        // A spinning wheel takes a part of the torque for itself.
        let spin: f64 = Wheel::ALL
            .into_iter()
            .filter(|&wheel| self.car.driven_axle.drives(wheel))
            .map(|wheel| block.wheel_acceleration[wheel as usize])
            // A wheel that is not on the bus turns as the car goes.
            .map(|rate| if rate.is_nan() { block.acceleration } else { rate })
            .map(|rate| self.car.wheel_inertia * rate / self.car.radius)
            .sum();
        Some((torque - spin) / self.car.radius / self.car.mass - self.resisting(block))
    }

    /// What the torque tells more than an accelerometer feels, and that, m/s². A car that is braked or turns sharply is held
    /// back by more than its resistance.
    pub fn torque_and_acceleration(&self, block: &Block) -> Option<(f64, f64)> {
        let felt = block.longitudinal_acceleration?;
        let is_free = block.speed > self.minimum_speed
            && block.lateral_acceleration.abs() < self.max_lateral
            && !self.is_braking(block);
        self.driving(block).filter(|_| is_free).map(|driving| (driving - felt, felt))
    }
}
