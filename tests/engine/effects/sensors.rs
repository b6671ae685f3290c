//! Effects of sensors.

use gripd::Quantity::{
    BrakePressure, DriveTorque, LateralAcceleration, LongitudinalAcceleration, SteeringWheelAngle,
    WheelSpeedFl, WheelSpeedFr, WheelSpeedRl, YawRate,
};
use gripd::model::GRAVITY;

use super::support::*;

#[test]
fn accelerometer_position_adds_what_turning_gives_there() {
    let drive = slalom("[[effect]]\nkind = \"accelerometer_position\"\nforward_of_cg_m = 0.8");
    let yaw: Vec<f64> = drive.truth.iter().map(|row| row.yaw_rate).collect();
    let across = drive.of(LateralAcceleration).iter().zip(&drive.truth);
    let across = across.map(|(reading, row)| reading - row.lateral_acceleration).skip(1);
    all_close(across.zip(yaw.windows(3).map(|yaw| 0.8 * (yaw[2] - yaw[0]) / 0.02)).skip(10), 2e-3);
    let along = drive.of(LongitudinalAcceleration).iter().zip(&drive.truth);
    let along = along.map(|(reading, row)| reading - row.longitudinal_acceleration);
    all_close(along.zip(yaw.iter().map(|yaw| -0.8 * yaw * yaw)), 1e-9);
    assert!(amplitude(&yaw) > 0.1);
}

#[test]
fn body_roll_leaks_gravity_into_the_accelerometer() {
    let drive = turn("[[effect]]\nkind = \"body_roll\"\nroll_gain_rad_per_mps2 = 0.006");
    let more =
        drive.of(LateralAcceleration).iter().zip(&drive.truth).map(|(a, row)| a - row.lateral_acceleration);
    let roll = drive.column("body_roll_angle");
    all_close(more.zip(roll.iter().map(|roll| GRAVITY * roll)), 1e-9);
    close(*roll.last().unwrap(), 0.006 * drive.end().lateral_acceleration, 2e-3);
    assert!(*roll.last().unwrap() > 0.017);
}

#[test]
fn sensor_delay_is_late() {
    let drive = slalom("[[effect]]\nkind = \"sensor_delay\"\nchannel = \"yaw_rate\"\ndelay_s = 0.05");
    let late = drive.of(YawRate)[5..].iter().copied();
    all_close(late.zip(drive.truth.iter().map(|row| row.yaw_rate)), 1e-12);
    let others = drive.of(LateralAcceleration).iter().copied();
    all_close(others.zip(drive.truth.iter().map(|row| row.lateral_acceleration)), 1e-12);
}

#[test]
fn sensor_scale_is_in_proportion() {
    let effect = |channel: &str| {
        format!("[[effect]]\nkind = \"sensor_scale\"\nchannel = \"{channel}\"\nrelative_error = 0.06")
    };
    let drive = slalom(&effect("steering_wheel_angle"));
    let angle = drive.of(SteeringWheelAngle).iter().copied();
    all_close(angle.zip(drive.truth.iter().map(|row| 1.06 * row.steering_wheel_angle)), 1e-12);
    // The car turns as the true angle says.
    all_close(drive.of(YawRate).iter().copied().zip(slalom("").of(YawRate).iter().copied()), 1e-9);
    let drive = slalom(&effect("drive_torque"));
    let torque = drive.of(DriveTorque).iter().copied();
    all_close(torque.zip(drive.truth.iter().map(|row| 1.06 * row.drive_torque)), 1e-9);
}

#[test]
fn sensor_bias_begins_at_its_time() {
    let braking = "brake_pressure = [{ kind = \"constant\", value = 10 }]";
    let effect = "[[effect]]\nkind = \"sensor_bias\"\nchannel = \"brake_pressure\"\nbias = 1.5\nat_s = 1.5";
    let drive = drive(3.0, 20.0, braking, effect);
    let pressure = drive.of(BrakePressure);
    close(pressure[149], 10.0, 1e-12);
    close(pressure[150], 11.5, 1e-12);
    close(drive.end().brake_pressure, 10.0, 1e-12);
}

#[test]
fn sensor_drift_follows_its_course() {
    let effect = "[[effect]]\nkind = \"sensor_drift\"\nchannel = \"yaw_rate\"\n\
                  series = { t = [1, 3, 6], value = [0, 0.02, -0.01] }";
    let drive = slalom(effect);
    let course = drive.column("sensor_drift_yaw_rate");
    let readings = drive.of(YawRate).iter().zip(&drive.truth).map(|(reading, row)| reading - row.yaw_rate);
    all_close(readings.zip(course.iter().copied()), 1e-12);
    all_close(course[100..300].iter().enumerate().map(|(i, v)| (*v, 1e-4 * i as f64)), 1e-9);
    assert_eq!(course[700], 0.0);
}

#[test]
fn sensor_sign_turns_the_reading_round() {
    let drive = slalom("[[effect]]\nkind = \"sensor_sign\"\nchannel = \"lateral_acceleration\"");
    let readings = drive.of(LateralAcceleration).iter().map(|reading| -reading);
    all_close(readings.zip(drive.truth.iter().map(|row| row.lateral_acceleration)), 1e-12);
}

/// Tooth wheels turn with their wheels; what the units make of them is scaled, shifted and swapped.
#[test]
fn wheel_speeds_from_tooth_wheels_have_their_effects() {
    let with = |effect: &str| {
        let mut scenario = scenario(4.0, 20.0, "linear", AT_20, effect);
        let steering = "steering_wheel_angle = [{ kind = \"constant\", value = 0.3 }]";
        #[derive(serde::Deserialize)]
        struct Inputs {
            steering_wheel_angle: Vec<gripd::model::Piece>,
        }
        scenario.steering_wheel_angle = toml::from_str::<Inputs>(steering).unwrap().steering_wheel_angle;
        for wheel in ["wheel_speed_fl", "wheel_speed_fr", "wheel_speed_rl"] {
            let sensor = scenario.sensors.by_name.get_mut(wheel).unwrap();
            sensor.tooth_wheel = Some(toml::from_str("pitch_error_std = 0.02").unwrap());
        }
        driven(&scenario)
    };
    let plain = with("");
    let jitter = plain.of(WheelSpeedFl).iter().zip(&plain.truth).map(|(v, row)| v - row.wheel_speed[0]);
    assert!(amplitude(&jitter.collect::<Vec<_>>()) > 0.1, "teeth are not perfect");
    let swapped = with("[[effect]]\nkind = \"channel_swap\"\nchannel = \"wheel_speed_fr/wheel_speed_fl\"");
    assert_eq!(swapped.of(WheelSpeedFl), plain.of(WheelSpeedFr));
    assert_eq!(swapped.of(WheelSpeedFr), plain.of(WheelSpeedFl));
    assert_eq!(swapped.of(WheelSpeedRl), plain.of(WheelSpeedRl));
    let scaled =
        with("[[effect]]\nkind = \"sensor_scale\"\nchannel = \"wheel_speed_fl\"\nrelative_error = 0.1");
    let scale = scaled.of(WheelSpeedFl).iter().zip(plain.of(WheelSpeedFl));
    all_close(scale.map(|(with, without)| (*with, 1.1 * without)), 1e-9);
    let late = with("[[effect]]\nkind = \"sensor_delay\"\nchannel = \"wheel_speed_rl\"\ndelay_s = 0.1");
    all_close(late.of(WheelSpeedRl)[10..].iter().copied().zip(plain.of(WheelSpeedRl).iter().copied()), 1e-9);
}
