//! The measurement chain before physics: signs, swaps, units and scales, delays, offsets, radii.
//!
//! Every check compares two channels by an equation that holds whatever the tires do (kinematics of a
//! rigid body), or nearly so (Newton's law with the data-sheet mass):
//!
//! | relation | equation |
//! |---|---|
//! | all that turns, among itself | correlated at some delay |
//! | wheels of an axle, yaw rate | (ω_R − ω_L) r0 / track = r |
//! | lateral acceleration, yaw rate | a_y = v r + v̇y,  vy = b r − v F_R/C_R |
//! | steering, yaw rate | δ v / L = r (1 + K v²) + … |
//! | longitudinal acceleration, wheels | a_x = v̇ − vy r |
//! | drive torque, brake | m v̇ = T/r0 − … |
//!
//! A relation alone does not tell which of its channels is wrong; all of them together do, if one cause
//! is more likely than two. So each kind of error (sign, scale, delay) is attributed by comparing single
//! causes over all relations. What is found is put right before the next kind is looked for.
//!
//! Significance: standard deviations are the larger of a jackknife over blocks of seconds and of least
//! squares with the residuals' autocorrelation counted in; thresholds are Student's for the number of
//! blocks. Where the drive did not excite a relation the answer is "unclear", with what to drive.

mod attribution;
mod bank;
mod car;
mod delays;
mod foreign;
mod gains;
mod longitudinal;
mod offsets;
mod regression;
mod relations;
mod report;
mod sensor_group;
mod series;
mod signs;
mod standing;
mod tuning;
mod units;
mod wheel_model;
mod wheels;

use physics::model::Vehicle;
use physics::{Quantity, Sample, Sensors};

pub use car::{driven_axle, steering_ratio};
pub use report::{AuditFinding, ChainReport, Confidence, Offset, RelationReport, Unclear};
pub use standing::{Standing, ZeroCourse};
pub(super) use wheels::certain_radius;

use self::series::Series;

/// Compares all channels of a drive with each other.
///
/// The samples must be uniform but for gaps, with nothing taken out for being implausible: a wrong unit
/// would be hidden. What is found is only reported; the samples are not changed.
pub fn audit(samples: &[Sample], vehicle: &Vehicle, sensors: &Sensors) -> ChainReport {
    let mut report = ChainReport::default();
    let Some(mut series) = Series::new(samples, vehicle) else {
        report.unclear("everything", "no samples: the required quantities do not come");
        return report;
    };
    for quantity in
        Quantity::ALL.into_iter().filter(|quantity| sensors.has(*quantity) && !series.has(*quantity))
    {
        report.unclear(
            format!("{quantity}: configured, but it never has a value"),
            "check its message and quality signals",
        );
    }
    report.seconds = series.seconds();
    wheels::unit_factors(&mut series, &mut report);
    series.refresh();
    standing::drift(&mut series, &mut report);
    report.moving_seconds = series.moving_seconds();
    if report.moving_seconds < series::LEAST_MOVING_S {
        report.unclear(
            "everything but offsets at standstill",
            "drive for a minute, with curves of both directions",
        );
        offsets::at_standstill(&series, &mut report);
        return report;
    }
    longitudinal::swapped_accelerations(&mut series, &mut report);
    foreign::signals(&mut series, &mut report);
    if series.moving_seconds() < series::LEAST_MOVING_S {
        report.unclear("everything else", "record what belongs together");
        report.sort();
        return report;
    }
    signs::lateral(&mut series, &mut report);
    longitudinal::signs(&mut series, &mut report);
    wheels::swaps(&mut series, &mut report);
    offsets::take_zeros(&mut series);
    gains::scales(&mut series, &mut report);
    let delays = delays::delays(&series, &mut report);
    offsets::offsets(&series, &delays, &mut report);
    wheels::radii(&series, &mut report);
    longitudinal::torques(&series, &mut report);
    report.compared = report.relations.iter().any(|relation| relation.delay_s.is_some());
    report.sort();
    report
}
