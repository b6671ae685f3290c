//! One drive as every peer sees it: the service, the thesis's own filters, and the learner, on the same samples.

use gripd::estimate::thesis::LateralVelocitySource;
use gripd::estimate::{Car, EstimatorsConfig, Kinematics, Pipeline};
use gripd::model::{Truth, Vehicle};
use gripd::signals::Inputs;
use gripd::{Config, Estimates, Sample, Sensors};

use super::drive::Drive;
use super::learner::{Learner, Said};
use testing::driven;

/// What all say at one instant.
pub struct Row {
    pub truth: Truth,
    pub ours: Estimates,
    /// The lateral regression on the lateral velocity of method 2, the brush without our compensation. Changes of
    /// surface and ABS brakings are told to it by the same detectors as to ours.
    pub thesis: Estimates,
    /// The learner's stiffness factor.
    pub factor: Option<Said>,
}

/// A drive as it was sampled, and what was said.
pub struct Driven {
    pub sheet: Vehicle,
    pub sensors: Sensors,
    pub samples: Vec<Sample>,
    pub rows: Vec<Row>,
}

/// The thesis as it stands, where the service deviates from it.
pub fn thesis_config() -> EstimatorsConfig {
    let mut config = EstimatorsConfig {
        lateral_slope_source: LateralVelocitySource::Kinematic,
        ..EstimatorsConfig::default()
    };
    config.brush.compensate = false;
    config
}

fn sensors(config: &Config) -> Sensors {
    let database = gripd::dbc::Database::parse(driven::CAR_DBC.as_bytes(), "demo.dbc").unwrap();
    let radius = config.vehicle.wheel_radius_m.value;
    gripd::service::sensors(&Inputs::compile(&config.signals, &database, radius).unwrap())
}

/// Drives.
pub fn drive(drive: &Drive) -> Driven {
    let sheet = drive.config.vehicle.clone();
    let sensors = sensors(&drive.config);
    let (car, mut learner) = (Car::new(&sheet), Learner::new(&sheet));
    let mut thesis = Pipeline::new(&sheet, &sensors, &thesis_config()).with_thesis();
    let (mut samples, mut rows) = (Vec::new(), Vec::new());
    drive.through_the_engine(|sample, truth, ours| {
        learner.step(&Kinematics::new(sample, &car));
        samples.push(*sample);
        rows.push(Row { truth: *truth, ours: *ours, thesis: *thesis.step(sample), factor: learner.factor() });
    });
    Driven { sheet, sensors, samples, rows }
}
