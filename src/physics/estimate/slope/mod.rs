//! Longitudinal slip slope and slip offset of each driven wheel (thesis 5.2.1, eqs. 5.3–5.5).
//!
//! s = μ/k + δ₀ + e: a Kalman filter on (1/k, δ₀), and a CUSUM detector that multiplies the process
//! noise of 1/k for one block when the surface changes. Beyond the thesis the noise of e is learned
//! from the innovations (size and correlation), so that the interval is as wide as the car's wheel
//! speeds deserve, and noise in μ is accounted for.

mod wheel;

use self::wheel::WheelSlope;
use super::config::SlopeConfig;
use super::kinematics::Car;
use super::learned::Learned;
use super::traction::TractionPoint;
use crate::estimates::Estimate;
use crate::filter::{Cusum, Innovation, InnovationMonitor};
use crate::{Quantity, Sensors, Wheel};

/// Tuned with the test `accuracy`.
struct Tuning {
    /// Evidence teaches what is usual while the change detector is calmer than this, …
    suspicious: f64,
    /// … and the evidence itself is below this many standard deviations.
    unusual: f64,
    /// Blocks that the learned noise remembers.
    noise_memory: f64,
}

const TUNING: Tuning = Tuning { suspicious: 0.3, unusual: 3.0, noise_memory: 120.0 };

/// The slope filters of all driven wheels.
#[derive(Clone, Debug)]
pub struct SlopeEstimator {
    wheels: [Option<WheelSlope>; 4],
    /// Watches all driven wheels together: a surface changes under both, and two tell sooner than one.
    cusum: Cusum,
    /// How the evidence of an unchanged surface scatters.
    usual: InnovationMonitor,
    config: SlopeConfig,
    /// Relative standard deviation of all forces together: the data sheet's, not a noise.
    force_scale_std: f64,
}

impl SlopeEstimator {
    /// Starts from the vehicle's prior.
    pub fn new(car: &Car, sensors: &Sensors, config: &SlopeConfig) -> Self {
        let wheels = Wheel::ALL.map(|wheel| {
            let prior = car.slope_prior[usize::from(!wheel.is_front())];
            car.driven_axle.drives(wheel).then(|| WheelSlope::new(prior, config))
        });
        let cusum = Cusum::new(config.cusum_drift, config.cusum_threshold);
        let usual = InnovationMonitor::new(TUNING.noise_memory);
        let force_scale_std = if sensors.has(Quantity::DriveTorque) {
            car.torque_scale_std
        } else {
            car.acceleration_scale_std
        };
        Self { wheels, cusum, usual, config: config.clone(), force_scale_std }
    }

    /// Starts from what an earlier drive learned, less sure of it. Before the first sample only.
    pub fn restore(&mut self, learned: &Learned) {
        for (place, wheel) in Wheel::ALL.into_iter().zip(&mut self.wheels) {
            if let Some(wheel) = wheel {
                let (slope, offset) = learned.of_wheel(place);
                wheel.restore(slope, offset, &self.config);
            }
        }
    }

    /// Puts into `learned` what outlives the drive.
    pub fn learn(&self, learned: &mut Learned) {
        for (place, wheel) in self.wheels.iter().enumerate() {
            let Some(wheel) = wheel else { continue };
            learned.slope[place] = wheel.settled;
            learned.slip_offset[place] = wheel.learned_offset(&self.config);
        }
    }

    /// Time passes; nothing was measured.
    pub fn age(&mut self, elapsed_s: f64) {
        for wheel in self.wheels.iter_mut().flatten() {
            wheel.age(elapsed_s, &self.config);
        }
    }

    /// Takes a block's points of the slip curve; returns whether the surface seems to have changed.
    pub fn step(&mut self, points: &[Option<TractionPoint>; 4], duration_s: f64) -> bool {
        let mut evidence = 0.0;
        let mut count = 0.0_f64;
        for (wheel, point) in self.wheels.iter_mut().zip(points) {
            if let (Some(wheel), Some(point)) = (wheel, point)
                && let Some(of_wheel) = wheel.step(point, duration_s, &self.config)
            {
                evidence += of_wheel;
                count += 1.0;
            }
        }
        if count == 0.0 {
            return false;
        }
        let evidence = self.calibrated(evidence / count.sqrt());
        let alarm = self.cusum.step(evidence).is_some();
        if alarm {
            self.surface_changed();
        }
        alarm
    }

    /// Evidence in standard deviations of what the evidence usually is: the wheels share the noise of
    /// the force, and blocks follow each other. What already looks like a change is not usual.
    fn calibrated(&mut self, evidence: f64) -> f64 {
        let calibrated = evidence / (self.usual.nis().max(1.0) * self.usual.redundancy()).sqrt();
        if self.cusum.suspicion() < TUNING.suspicious && calibrated.abs() < TUNING.unusual {
            self.usual.step(&Innovation { residual: evidence, variance: 1.0 });
        }
        calibrated
    }

    /// The surface changed: the slopes may be anything near.
    fn surface_changed(&mut self) {
        for wheel in self.wheels.iter_mut().flatten() {
            wheel.boost(&self.config);
        }
    }

    /// Slope per wheel, normalized by the static wheel load.
    pub fn slopes(&self) -> [Option<Estimate>; 4] {
        self.wheels.each_ref().map(|wheel| {
            let slope = wheel.as_ref().and_then(WheelSlope::slope)?;
            let of_force = self.force_scale_std * slope.value;
            Some(Estimate { std: (slope.std * slope.std + of_force * of_force).sqrt(), ..slope })
        })
    }

    /// Slip offset per wheel.
    pub fn offsets(&self) -> [Option<Estimate>; 4] {
        self.wheels.each_ref().map(|wheel| wheel.as_ref().and_then(WheelSlope::offset))
    }

    /// Every driven wheel's slope, of these that it has ([`slopes`](Self::slopes)), is known well, and lately.
    pub fn are_valid(&self, slopes: &[Option<Estimate>; 4]) -> bool {
        let mut driven = self.wheels.iter().zip(slopes).filter(|(wheel, _)| wheel.is_some()).peekable();
        driven.peek().is_some()
            && driven.all(|(_, slope)| slope.is_some_and(|slope| self.config.is_valid(&slope)))
    }
}

#[cfg(test)]
mod tests;
