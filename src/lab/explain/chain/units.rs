//! Factors between units that are mistaken for each other.

use std::f64::consts::PI;

use super::sensor_group::SensorGroup;
use physics::model::Vehicle;

/// A factor nearer than this (logarithmic) is that of the mistake. Tuned, no test on record.
const NEAR: f64 = 0.1;

/// The mistake that makes a channel's values `factor` times too large, if there is a known one.
pub(super) fn mistake(
    channel: SensorGroup,
    factor: f64,
    std: f64,
    vehicle: &Vehicle,
) -> Option<&'static str> {
    let degree = 180.0 / PI;
    let known: Vec<(f64, &'static str)> = match channel {
        SensorGroup::Wheels => {
            let radius = vehicle.wheel_radius_m.value;
            vec![
                (3.6, "the speed is in km/h but taken for m/s (or rad/s from it)"),
                (1.0 / 3.6, "the speed is in m/s but taken for km/h"),
                (radius, "the values are in m/s but taken for rad/s: unit = \"m/s\""),
                (1.0 / radius, "the values are in rad/s but taken for m/s: unit = \"rad/s\""),
                (3.6 * radius, "the values are in km/h but taken for rad/s: unit = \"km/h\""),
                (30.0 / PI, "the values are in rpm but taken for rad/s: unit = \"rpm\""),
                (PI / 30.0, "the values are in rad/s but taken for rpm: unit = \"rad/s\""),
                (
                    1.0 / (2.0 * PI),
                    "the values are in revolutions per second but taken for rad/s: unit = \"1/s\"",
                ),
                (1.609_344, "the speed is in km/h but taken for mph: unit = \"km/h\""),
                (1.0 / 1.609_344, "the speed is in mph but taken for km/h: unit = \"mph\""),
            ]
        }
        SensorGroup::Yaw => vec![
            (degree, "the values are in deg/s but taken for rad/s: unit = \"deg/s\""),
            (1.0 / degree, "the values are in rad/s but taken for deg/s: unit = \"rad/s\""),
        ],
        SensorGroup::Lateral | SensorGroup::Longitudinal => vec![
            (9.81, "the values are in m/s^2 but taken for g: unit = \"m/s^2\""),
            (1.0 / 9.81, "the values are in g but taken for m/s^2: unit = \"g\""),
        ],
        SensorGroup::Steering => vec![
            (degree, "the values are in deg but taken for rad: unit = \"deg\""),
            (1.0 / degree, "the values are in rad but taken for deg: unit = \"rad\""),
            (
                1.0 / vehicle.steering_ratio.value,
                "it is the angle of the road wheels, not of the steering wheel",
            ),
        ],
    };
    nearest(&known, factor, std)
}

/// The same of the vehicle's speed.
pub(super) fn mistaken_speed(factor: f64, std: f64) -> Option<&'static str> {
    let known = [
        (3.6, "the speed is in km/h but taken for m/s: unit = \"km/h\""),
        (1.0 / 3.6, "the speed is in m/s but taken for km/h: unit = \"m/s\""),
        (1.609_344, "the speed is in km/h but taken for mph: unit = \"km/h\""),
        (1.0 / 1.609_344, "the speed is in mph but taken for km/h: unit = \"mph\""),
    ];
    nearest(&known, factor, std)
}

fn nearest(known: &[(f64, &'static str)], factor: f64, std: f64) -> Option<&'static str> {
    let near = (3.0 * std).clamp(NEAR, 2.0 * NEAR);
    known.iter().find(|(known, _)| (factor / known).ln().abs() < near).map(|(_, words)| *words)
}
