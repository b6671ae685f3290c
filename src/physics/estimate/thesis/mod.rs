//! The thesis's estimators that no frame is made of, kept to be compared with those that are.
//!
//! They run only where somebody asks for them ([`Pipeline::with_thesis`](super::Pipeline::with_thesis)):
//! a table of estimates, an experiment, a benchmark. Nothing that is published depends on them.
//!
//! * lateral velocity by methods 1 to 3 of thesis 5.2.2 ([`LateralVelocityEstimator`]), and the slip angles
//!   each of them gives ([`SlipAngles`]);
//! * cornering stiffness by regression, eq. 5.20 ([`LateralSlopeEstimator`]), and by the joint EKF, eq. 5.21
//!   ([`JointEkf`]);
//! * friction by the Dahl EKF on one wheel, thesis 8.2 ([`DahlEkf`]);
//! * [`lateral_filter`]: our own filter on a tire that saturates, for the experiments beside the thesis.

mod bicycle_filter;
pub(super) mod config;
mod dahl_ekf;
mod joint_ekf;
mod kinematic_observer;
pub use super::lateral_filter;
mod lateral_slope;
mod lateral_velocity;
mod slip_angles;

pub use bicycle_filter::BicycleFilter;
pub use config::{JointEkfConfig, LateralVelocitySource};
pub use dahl_ekf::{DahlEkf, DahlWheel};
pub use joint_ekf::JointEkf;
pub use kinematic_observer::{KinematicObserver, SpeedDerivative};
pub use lateral_slope::LateralSlopeEstimator;
pub use lateral_velocity::LateralVelocityEstimator;
pub use slip_angles::SlipAngles;

use super::config::EstimatorsConfig;
use super::kinematics::{Car, Kinematics};
use crate::Sensors;
use crate::estimates::{LateralVelocities, ThesisEstimates};

/// The thesis's estimators side by side. Never allocates after construction.
#[derive(Clone, Debug)]
pub struct Thesis {
    car: Car,
    lateral_velocity: LateralVelocityEstimator,
    /// Which lateral velocity the regression stands on.
    slope_source: LateralVelocitySource,
    lateral_slope: LateralSlopeEstimator,
    joint_ekf: JointEkf,
    dahl: DahlEkf,
}

impl Thesis {
    /// For this car and these sensors.
    pub fn new(car: &Car, sensors: &Sensors, config: &EstimatorsConfig) -> Self {
        let slow = config.minimum_speed_mps;
        Self {
            lateral_velocity: LateralVelocityEstimator::new(car, sensors, slow),
            slope_source: config.lateral_slope_source,
            lateral_slope: LateralSlopeEstimator::new(car, slow),
            joint_ekf: JointEkf::new(car, sensors, &config.joint_ekf, slow),
            dahl: DahlEkf::new(car, sensors, slow),
            car: car.clone(),
        }
    }

    /// Takes a sample, and the lateral velocity (m/s) that is published after it.
    pub fn step(&mut self, now: &Kinematics, published: Option<f64>) -> ThesisEstimates {
        let velocities = LateralVelocities { joint: published, ..self.lateral_velocity.step(now) };
        self.joint_ekf.step(now);
        self.lateral_slope.step(now, self.slope_source.of(&velocities));
        self.dahl.step(now, &self.car);
        ThesisEstimates {
            lateral_velocities: velocities,
            cornering_regression: self.lateral_slope.slopes(),
            cornering_ekf: self.joint_ekf.stiffness(),
            friction_dahl: self.dahl.friction(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Pipeline;
    use crate::model::Vehicle;
    use crate::{Estimates, Micros, Quantity, Sample};

    /// Gentle slalom at 20 m/s: what any bus tells of it.
    fn sample(number: i32) -> Sample {
        let mut sample = Sample::empty(Micros(i64::from(number) * 10_000), 0.01);
        let steer = 0.02 * (f64::from(number) * 0.03).sin();
        for wheel in
            [Quantity::WheelSpeedFl, Quantity::WheelSpeedFr, Quantity::WheelSpeedRl, Quantity::WheelSpeedRr]
        {
            sample.set(wheel, 65.0 + 0.05 * (f64::from(number) * (2.0 + wheel as u8 as f64)).sin());
        }
        sample.set(Quantity::SteeringWheelAngle, steer);
        sample.set(Quantity::YawRate, 5.0 * steer);
        sample.set(Quantity::LateralAcceleration, 100.0 * steer);
        sample.set(Quantity::DriveTorque, 200.0);
        sample
    }

    #[test]
    fn they_run_only_where_asked_for_and_change_nothing_else() {
        let mut sensors = Sensors::default();
        Quantity::ALL.into_iter().for_each(|quantity| sensors.add(quantity, None));
        let new = || Pipeline::new(&Vehicle::thesis(), &sensors, &EstimatorsConfig::default());
        let (mut without, mut with) = (new(), new().with_thesis());
        for number in 0..2_000 {
            let (plain, beside) = (*without.step(&sample(number)), *with.step(&sample(number)));
            assert_eq!(plain.thesis, ThesisEstimates::default());
            assert_eq!(plain, Estimates { thesis: ThesisEstimates::default(), ..beside });
        }
        let ThesisEstimates { lateral_velocities: v, cornering_regression, cornering_ekf, friction_dahl } =
            with.latest().thesis;
        assert!(
            [v.zero, v.integration, v.kinematic, v.bicycle, v.joint].iter().all(Option::is_some),
            "{v:?}"
        );
        assert!(cornering_regression.iter().all(Option::is_some) && cornering_ekf.is_some());
        assert!(friction_dahl.is_some());
        assert_eq!(without.learned(), with.learned());
    }
}
