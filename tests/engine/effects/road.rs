//! Effects of tires, road and wind.

use gripd::Quantity::{LateralAcceleration, LongitudinalAcceleration, WheelSpeedFl, WheelSpeedRl, YawRate};
use gripd::model::{GRAVITY, Truth};

use super::support::*;

#[test]
fn tire_saturation_limits_the_lateral_acceleration() {
    let top =
        format!("{AT_20} steering_wheel_angle = [{{ kind = \"ramp\", from_s = 0, to_s = 20, value = 3 }}]");
    let most = |effect: &str| {
        let drive = drive(20.0, 20.0, &top, effect);
        drive.of(LateralAcceleration).iter().fold(0.0f64, |most, a| a.max(most))
    };
    let limited = most("[[effect]]\nkind = \"tire_saturation\"\nfriction = 0.5");
    assert!(limited <= 0.5 * GRAVITY, "{limited}");
    close(limited, 0.5 * GRAVITY, 0.02);
    assert!(most("") > 10.0);
}

#[test]
fn friction_change_limits_the_braking_on_its_patch() {
    let top = "brake_pressure = [{ kind = \"constant\", value = 38.8333 }]";
    let effect = "[[effect]]\nkind = \"friction_change\"\nfriction = 0.3\nintervals = [[3, 5]]";
    let drive = driven(&scenario(5.7, 30.0, "piecewise", top, effect));
    let acceleration = drive.of(LongitudinalAcceleration);
    let wanted = -60.0 * 38.8333 / RADIUS / INERT_MASS;
    close(acceleration[290], wanted, 1e-2);
    close(acceleration[450], -0.3 * GRAVITY, 1e-3);
    close(acceleration[560], wanted, 1e-2);
    let share = drive.column("friction_change");
    assert_eq!([share[299], share[300], share[499], share[500]], [0.0, 1.0, 1.0, 0.0]);
}

#[test]
fn friction_split_turns_the_braking_car() {
    let top = "brake_pressure = [{ kind = \"constant\", value = 150 }]";
    let effect = "[[effect]]\nkind = \"friction_split\"\nfriction_left = 0.2\nfriction_right = 0.8\nvalue = 1\n\
                  intervals = [[1, 3]]";
    let drive = driven(&scenario(1.5, 30.0, "piecewise", top, effect));
    close(drive.of(LongitudinalAcceleration)[90], -GRAVITY, 1e-3);
    close(drive.of(LongitudinalAcceleration)[105], -0.5 * GRAVITY, 1e-2);
    let moment = -0.6 * (LOAD[0] + LOAD[1]) * 0.5 * TRACK;
    close(drive.of(YawRate)[102], 0.02 * moment / YAW_INERTIA, 8e-2);
}

#[test]
fn surface_stiffness_is_seen_in_the_slip() {
    let top = "drive_torque = [{ kind = \"constant\", value = 450 }]";
    let effect = "[[effect]]\nkind = \"surface_stiffness\"\nstiffness_factor = 0.5\n\
                  series = { t = [0, 2, 4], value = [0, 0, 1] }";
    let drive = drive(4.0, 20.0, top, effect);
    for (row, factor) in [(190, 1.0), (300, 0.75), (400, 0.5)] {
        let truth = &drive.truth[row];
        let slip = drive.of(WheelSpeedFl)[row] * RADIUS / truth.longitudinal_velocity - 1.0;
        close(slip, truth.fx[0] / (factor * ALONG * MASS * GRAVITY / 4.0), 1e-6);
        close(truth.slope[0], factor * ALONG * 0.25 * MASS * GRAVITY / LOAD[0], 1e-9);
    }
    close(drive.column("surface_stiffness")[300], 0.5, 1e-9);
}

/// Lateral acceleration by the front wheels' and rear axle's forces.
fn lateral_acceleration(row: &Truth, front: f64, rear: f64) -> f64 {
    let (sin, cos) = row.steer.sin_cos();
    ((row.fx[0] + row.fx[1]) * sin + front * cos + rear) / MASS
}

#[test]
fn combined_slip_takes_lateral_force_from_driven_wheels() {
    let top = "drive_torque = [{ kind = \"constant\", value = 900 }]\n\
               steering_wheel_angle = [{ kind = \"ramp\", from_s = 0, to_s = 1, value = 0.3 }]";
    let drive = drive(3.0, 15.0, top, "[[effect]]\nkind = \"combined_slip\"\nellipse_factor = 0.8");
    let left = |fx: f64, load: f64| (1.0 - (0.8 * fx / load).powi(2)).sqrt();
    assert!(left(drive.end().fx[0], LOAD[0]) < 0.96);
    let expected = drive.truth.iter().map(|row| {
        let both = |axle: usize| left(row.fx[2 * axle], LOAD[axle]) + left(row.fx[2 * axle + 1], LOAD[axle]);
        let front = LATERAL * LOAD[0] * row.slip_angle_front * both(0);
        let rear = LATERAL * LOAD[1] * row.slip_angle_rear * both(1);
        lateral_acceleration(row, front, rear)
    });
    all_close(drive.of(LateralAcceleration).iter().copied().zip(expected), 1e-6);
}

#[test]
fn combined_slip_takes_longitudinal_force_from_wheels_at_a_slip_angle() {
    let top = "brake_pressure = [{ kind = \"constant\", value = 20 }]\n\
               steering_wheel_angle = [{ kind = \"ramp\", from_s = 0, to_s = 1, value = 1 }]";
    let drive = drive(3.0, 25.0, top, "[[effect]]\nkind = \"combined_slip\"\nellipse_factor_along = 0.8");
    let left = |row: &Truth| (1.0 - (0.8 * LATERAL * row.slip_angle_rear).powi(2)).sqrt();
    assert!(left(drive.end()) < 0.96);
    let slip = |(row, wheel): (&Truth, &f64)| {
        let along = row.longitudinal_velocity - 0.5 * TRACK * row.yaw_rate;
        wheel * RADIUS / along - 1.0
    };
    let expected = drive.truth.iter().map(|row| row.fx[2] / (ALONG * 0.25 * MASS * GRAVITY * left(row)));
    all_close(drive.truth.iter().zip(drive.of(WheelSpeedRl)).map(slip).zip(expected), 1e-4);
}

#[test]
fn combined_slip_keeps_tires_with_a_limit_within_it() {
    let top = "brake_pressure = [{ kind = \"constant\", value = 60 }]\n\
               steering_wheel_angle = [{ kind = \"ramp\", from_s = 0, to_s = 0.5, value = 2 }]";
    for tire in ["piecewise", "brush", "magic_formula"] {
        let effect = "[[effect]]\nkind = \"combined_slip\"\nellipse_factor = 1";
        let drive = driven(&scenario(1.5, 30.0, tire, top, effect));
        let most = drive.truth.iter().map(|row| row.mu_used).fold(0.0, f64::max);
        assert!((0.7..=1.0 + 1e-9).contains(&most), "{tire}: {most}");
    }
}

#[test]
fn a_limited_slip_differential_drives_the_wheel_inside_of_the_curve() {
    let top = "drive_torque = [{ kind = \"constant\", value = 900 }]\n\
               steering_wheel_angle = [{ kind = \"ramp\", from_s = 0, to_s = 1, value = 0.3 }]";
    let of = |locking: &str| {
        let effect = "[[effect]]\nkind = \"limited_slip_differential\"\nlocking_value";
        drive(3.0, 15.0, top, &format!("{effect} = {locking}"))
    };
    let (open, locking) = (of("0"), of("0.4"));
    close(open.end().fx[0], open.end().fx[1], 1e-2);
    // To the left: the left wheel is inside, and held together they slip by half the difference of their speeds.
    let most = 0.5 * 0.4 * MASS * locking.last(LongitudinalAcceleration);
    let slip = 0.5 * TRACK * locking.last(YawRate) / locking.end().longitudinal_velocity;
    let held = most * (ALONG * MASS * GRAVITY / 4.0 * slip / most).tanh();
    close(locking.end().fx[0] - locking.end().fx[1], 2.0 * held, 2e-2);
    close(locking.end().fx.iter().sum::<f64>(), open.end().fx.iter().sum(), 1e-2);
    assert!(locking.last(YawRate) < 0.99 * open.last(YawRate), "it turns the car out of the curve");
}

#[test]
fn relaxation_length_is_a_way_that_lateral_force_needs() {
    let top = "truth_period_ms = 1\n\
               steering_wheel_angle = [{ kind = \"step\", at_s = 0.1, value = 0.3 }]";
    let drive = drive(0.5, 20.0, top, "[[effect]]\nkind = \"relaxation_length\"\nlength_m = 0.6");
    let (front, rear) = (drive.column("relaxation_length_front"), drive.column("relaxation_length_rear"));
    // σ α̇' = v (α − α').
    let mut followed = 0.0;
    for (rows, state) in drive.truth.windows(2).zip(&front[1..]) {
        let rate = rows[1].longitudinal_velocity / 0.6;
        let angle = 0.5 * (rows[0].slip_angle_front + rows[1].slip_angle_front);
        // A step within a millisecond is half a millisecond uncertain.
        followed = angle + (followed - angle) * (-rate * 1e-3).exp();
        assert!((followed - state).abs() < 4e-4, "{followed} {state}");
    }
    assert!(amplitude(&front) > 0.01);
    let rows = drive.truth.iter().zip(front.iter().zip(&rear)).step_by(10);
    let expected =
        rows.map(|(row, (front, rear))| lateral_acceleration(row, AXLES[0] * front, AXLES[1] * rear));
    all_close(drive.of(LateralAcceleration).iter().copied().zip(expected), 1e-6);
}

#[test]
fn road_bank_pulls_and_the_accelerometer_feels_the_tires_against_it() {
    let drive = drive(4.0, 20.0, "", "[[effect]]\nkind = \"road_bank\"\nvalue = 0.05");
    let pull = GRAVITY * 0.05f64.sin();
    assert!(drive.of(LateralAcceleration)[0].abs() < 1e-9, "at first nothing but gravity acts");
    close(drive.truth[0].lateral_acceleration, pull, 1e-9);
    close(drive.last(LateralAcceleration), -pull, 1e-3);
    close(drive.end().sideslip, 0.05f64.sin() / LATERAL, 1e-2);
    assert!(drive.end().lateral_acceleration.abs() < 1e-3 && drive.last(YawRate).abs() < 1e-3);
    assert_eq!(drive.column("road_bank")[100], 0.05);
}

#[test]
fn road_grade_slows_and_the_accelerometer_does_not_feel_it() {
    let drive = drive(4.0, 20.0, "", "[[effect]]\nkind = \"road_grade\"\nvalue = 0.05");
    let pull = GRAVITY * 0.05f64.sin();
    let slower = (drive.of(WheelSpeedRl)[100] - drive.of(WheelSpeedRl)[400]) * RADIUS / 3.0;
    close(slower, pull * MASS / INERT_MASS, 2e-3);
    // Only the wheels, which must be slowed, push.
    close(drive.last(LongitudinalAcceleration), pull - slower, 2e-2);
}

#[test]
fn crosswind_pushes_and_turns() {
    let effect =
        "[[effect]]\nkind = \"crosswind\"\ncentre_of_pressure_m = 0.4\nvalue = 500\nintervals = [[1, 3]]";
    let drive = drive(1.1, 20.0, "", effect);
    assert_eq!(drive.of(LateralAcceleration)[99], 0.0);
    close(drive.of(LateralAcceleration)[100], 500.0 / MASS, 2e-3);
    close(drive.of(YawRate)[102], 0.02 * 0.4 * 500.0 / YAW_INERTIA, 0.1);
}

#[test]
fn unequal_brakes_turn_by_the_pressure() {
    let effect = "[[effect]]\nkind = \"brake_imbalance\"\nleft_more_front = 0.25\n";
    let turned = |bar: f64| {
        let top = format!("brake_pressure = [{{ kind = \"constant\", value = {bar} }}]");
        drive(0.2, 20.0, &top, effect).of(YawRate)[5]
    };
    // Left 1.25 and right 0.75 times 20 N m/bar, at half a track of 1.5 m from the middle.
    let moment = |bar: f64| 0.5 * 20.0 * bar / RADIUS * 0.5 * TRACK;
    close(turned(10.0), 0.05 * moment(10.0) / YAW_INERTIA, 0.25);
    close(turned(20.0) / turned(10.0), 2.0, 0.02);
    assert_eq!(turned(0.0), 0.0);
}

#[test]
fn brake_yaw_moment_turns() {
    // A brake on the left front wheel alone turns the car to the left, once its slip has built up.
    let effect = "[[effect]]\nkind = \"brake_yaw_moment\"\nvalue = 800\nfront_share = 1.0\nvectoring = 0.0\n\
                  intervals = [[1, 1.5], [2, 3]]";
    let drive = drive(2.1, 20.0, "", effect);
    assert_eq!(drive.of(YawRate)[99], 0.0);
    close(drive.of(YawRate)[105], 0.05 * 800.0 / YAW_INERTIA, 0.25);
    assert_eq!([149, 150, 200].map(|row| drive.column("brake_yaw_moment")[row]), [800.0, 0.0, 800.0]);
}
