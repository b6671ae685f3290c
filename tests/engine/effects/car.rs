//! Effects of steering, body and wheels.

use gripd::Quantity::{
    self, LateralAcceleration, LongitudinalAcceleration, SteeringWheelAngle, WheelSpeedFl, WheelSpeedFr,
    WheelSpeedRl, YawRate,
};
use gripd::model::GRAVITY;

use super::support::*;

#[test]
fn the_plain_car_is_what_the_numbers_below_take_it_for() {
    let plain = turn("");
    close(plain.last(YawRate), steady_yaw_rate(20.0, 0.02, A, AXLES), 3e-3);
    close(plain.last(YawRate), 20.0 * 0.02 / WHEELBASE, 3e-3);
}

#[test]
fn steering_lag_takes_from_quick_steering() {
    let (plain, late) = (slalom(""), slalom("[[effect]]\nkind = \"steering_lag\"\ntime_constant_s = 0.1"));
    let gain = amplitude(late.of(YawRate)) / amplitude(plain.of(YawRate));
    let omega = std::f64::consts::TAU;
    close(gain, (1.0 + (omega * 0.1).powi(2)).sqrt().recip(), 2e-3);
    assert_eq!(late.of(SteeringWheelAngle), plain.of(SteeringWheelAngle));
    close(amplitude(&late.column("steering_lag_angle")), 0.3 * gain, 2e-3);
}

#[test]
fn steering_ratio_goes_with_the_square_of_the_angle() {
    let top = "steering_wheel_angle = [{ kind = \"ramp\", from_s = 0, to_s = 2, value = 0.9 }]";
    let yaw_rate_by_speed = |effect: &str| {
        let drive = drive(5.0, 5.0, top, effect);
        drive.last(YawRate) / drive.end().longitudinal_velocity
    };
    let gain = yaw_rate_by_speed("[[effect]]\nkind = \"steering_ratio\"\ncurvature_per_rad2 = 0.15")
        / yaw_rate_by_speed("");
    close(gain, 1.0 / (1.0 - 0.15 * 0.81), 3e-3);
}

#[test]
fn rear_steer_turns_more_at_low_speed_and_less_at_high_speed() {
    let effect = "[[effect]]\nkind = \"rear_steer\"\nlow_speed_ratio = 0.2\ncrossover_speed_mps = 16";
    for speed in [8.0, 16.0, 25.0] {
        let top = format!(
            "driver = {{ speed_mps = [{{ kind = \"constant\", value = {speed} }}] }}\n\
             steering_wheel_angle = [{{ kind = \"ramp\", from_s = 0, to_s = 2, value = 0.15 }}]"
        );
        let (plain, steered) = (drive(8.0, speed, &top, ""), drive(8.0, speed, &top, effect));
        let square = (speed / 16.0_f64).powi(2);
        let share = 0.2 * (1.0 - square) / (1.0 + square);
        close(steered.last(YawRate) / plain.last(YawRate), 1.0 + share, 5e-3);
        // The car is the one whose rear wheels point elsewhere: its sideslip changes by their angle besides.
        let sideslip = |drive: &Drive| drive.end().lateral_velocity / drive.end().longitudinal_velocity;
        let turned = sideslip(&steered) - (1.0 + share) * sideslip(&plain);
        assert!((turned + share * 0.01).abs() < 5e-5, "{speed}: {turned}");
    }
}

#[test]
fn steering_compliance_turns_the_wheels_back() {
    let soft = turn("[[effect]]\nkind = \"steering_compliance\"\ncompliance_rad_per_nm = 1e-4");
    let front = MASS * soft.last(LateralAcceleration) * B / WHEELBASE;
    close(soft.last(YawRate), 20.0 * (0.02 - 1e-4 * 0.05 * front) / WHEELBASE, 5e-3);
    assert!(soft.last(YawRate) < 0.75 * 20.0 * 0.02 / WHEELBASE);
}

#[test]
fn roll_steer_turns_the_front_wheels_out_of_the_bend() {
    let drive = turn(
        "[[effect]]\nkind = \"roll_steer\"\nroll_steer_rad_per_rad = 0.2\nroll_gain_rad_per_mps2 = 0.01",
    );
    let roll = 0.01 * drive.last(LateralAcceleration);
    close(*drive.column("roll_steer_angle").last().unwrap(), roll, 2e-3);
    close(drive.last(YawRate), 20.0 * (0.02 - 0.2 * roll) / WHEELBASE, 5e-3);
}

#[test]
fn wheel_alignment_drags() {
    let drive = drive(2.0, 20.0, "", "[[effect]]\nkind = \"wheel_alignment\"\ntoe_rad = 0.03");
    let drag = 2.0 * 0.03 * LATERAL * 0.03 * LOAD[0];
    close(drive.last(LongitudinalAcceleration), -drag / INERT_MASS, 3e-3);
    assert!(drive.last(LateralAcceleration).abs() < 1e-9);
}

#[test]
fn payload_makes_the_car_heavier_from_its_time_on() {
    let top = "drive_torque = [{ kind = \"constant\", value = 450 }]";
    let drive = drive(8.0, 10.0, top, "[[effect]]\nkind = \"payload\"\nmass_kg = 300\nat_s = 4");
    let acceleration = drive.of(LongitudinalAcceleration);
    close(acceleration[390], 450.0 / RADIUS / INERT_MASS, 2e-3);
    close(acceleration[790], 450.0 / RADIUS / (INERT_MASS + 300.0), 2e-3);
}

#[test]
fn cg_shift_changes_the_balance_from_its_time_on() {
    let effect = "[[effect]]\nkind = \"cg_shift\"\nshift_m = 0.2\nat_s = 4.5\nload_sensitivity = 1";
    let drive = turn(effect);
    close(drive.of(YawRate)[440], steady_yaw_rate(20.0, 0.02, A, AXLES), 5e-3);
    close(
        drive.last(YawRate),
        steady_yaw_rate(drive.end().longitudinal_velocity, 0.02, A + 0.2, AXLES),
        1e-2,
    );
    let loads = drive.end().fz;
    close(loads[0] / loads[2], (B - 0.2) / (A + 0.2), 1e-9);
}

#[test]
fn air_drag_slows_with_the_square_of_the_speed() {
    let drive = drive(5.0, 30.0, "", "[[effect]]\nkind = \"air_drag\"\ndrag_coefficient_kg_per_m = 0.9");
    let expected = drive.truth.iter().map(|row| -0.9 * row.longitudinal_velocity.powi(2) / INERT_MASS);
    all_close(drive.of(LongitudinalAcceleration).iter().copied().zip(expected).skip(50), 1e-3);
}

#[test]
fn rolling_resistance_slows_alike_at_every_speed() {
    for speed in [10.0, 40.0] {
        let drive = drive(2.0, speed, "", "[[effect]]\nkind = \"rolling_resistance\"\ncoefficient = 0.015");
        close(drive.last(LongitudinalAcceleration), -0.015 * MASS * GRAVITY / INERT_MASS, 1e-3);
    }
}

#[test]
fn load_transfer_loads_outer_and_front_wheels_and_softens_axles() {
    let (height, sensitivity, front_share) = (0.6, 0.45, 0.8);
    let effect = "[[effect]]\nkind = \"load_transfer\"\ncg_height_m = 0.6\nfront_roll_share = 0.8";
    let top =
        format!("{AT_20} steering_wheel_angle = [{{ kind = \"ramp\", from_s = 0, to_s = 2, value = 0.6 }}]");
    let turning = drive(8.0, 20.0, &top, effect);
    let lateral = turning.last(LateralAcceleration);
    assert!(lateral > 5.0);
    let [fl, fr, rl, rr] = turning.end().fz;
    let front = front_share * MASS * height * lateral / TRACK;
    let rear = (1.0 - front_share) * MASS * height * lateral / TRACK;
    close(0.5 * (fr - fl), front, 1e-2);
    close(0.5 * (rr - rl), rear, 1e-2);
    // What the axle keeps of its stiffness; forward, −v_y r is an acceleration, too.
    let backwards = 0.5 * MASS * height * turning.last(LongitudinalAcceleration) / WHEELBASE;
    let kept = |load: f64, along: f64, across: f64| {
        let power = |more: f64| (1.0 + more / load).powf(1.0 - sensitivity);
        0.5 * (power(along + across) + power(along - across))
    };
    let axles = [AXLES[0] * kept(LOAD[0], -backwards, front), AXLES[1] * kept(LOAD[1], backwards, rear)];
    // Beside the car without it: the formula is for small angles. It also leaves out that the outer front
    // wheel's larger force, turned with the wheel, holds the car back on that side.
    let plain = drive(8.0, 20.0, &top, "");
    let gain = |drive: &Drive, axles: [f64; 2]| {
        drive.last(YawRate) / steady_yaw_rate(drive.end().longitudinal_velocity, 0.04, A, axles)
    };
    close(gain(&turning, axles), gain(&plain, AXLES), 1.5e-2);
    assert!(gain(&turning, AXLES) < 0.93 * gain(&plain, AXLES));

    let braking = drive(1.0, 20.0, "brake_pressure = [{ kind = \"constant\", value = 20 }]", effect);
    let forward = -MASS * height * braking.last(LongitudinalAcceleration) / WHEELBASE;
    let [fl, fr, ..] = braking.end().fz;
    assert!(forward > 500.0);
    close(fl + fr - 2.0 * LOAD[0], forward, 1e-2);
}

#[test]
fn downforce_presses_all_wheels_and_makes_the_axles_stiffer() {
    let effect = "[[effect]]\nkind = \"downforce\"\ndownforce_area_m2 = 3\nload_sensitivity = 0";
    for speed in [20.0, 40.0] {
        let drive = drive(1.0, speed, "", effect);
        let more = drive.end().fz.iter().sum::<f64>() - MASS * GRAVITY;
        close(more, 0.5 * 1.225 * 3.0 * drive.end().longitudinal_velocity.powi(2), 1e-6);
    }
    // Shared as the weight is, it makes both axles stiffer by the same.
    let stiffer = 1.0 + 0.5 * 1.225 * 3.0 * 400.0 / (MASS * GRAVITY);
    close(turn(effect).last(YawRate), steady_yaw_rate(20.0, 0.02, A, AXLES.map(|axle| stiffer * axle)), 3e-3);
}

#[test]
fn tire_radius_is_seen_in_its_wheel_speed() {
    let drive = drive(2.0, 20.0, "", "[[effect]]\nkind = \"tire_radius\"\nrelative_difference_fl = 0.02");
    let ratio = |of: Quantity| drive.of(of).iter().map(|speed| speed * RADIUS).collect::<Vec<_>>();
    all_close(ratio(WheelSpeedFl).into_iter().zip(ratio(WheelSpeedFr).into_iter().map(|v| v / 1.02)), 1e-6);
    close(drive.end().slip_offset[0], 1.0 / 1.02 - 1.0, 1e-9);
}

#[test]
fn radius_growth_is_seen_at_speed() {
    for speed in [10.0, 40.0] {
        let drive =
            drive(1.0, speed, "", "[[effect]]\nkind = \"radius_growth\"\nrelative_per_mps_squared = 2e-5");
        let turning = drive.last(WheelSpeedRl);
        close(speed / (RADIUS * turning), 1.0 + 2e-5 * (RADIUS * turning).powi(2), 2e-5);
    }
}
