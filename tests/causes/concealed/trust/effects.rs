//! Hidden effects against closed forms, one number each.

use super::super::car::G;
use super::super::hidden::{Bump, LoadTransfer, Patch, at};
use super::super::physics::TRAIL;
use super::super::sensors::Chain;
use super::*;

/// The corner of a car with something hidden is the single-track corner of another car.
#[track_caller]
fn is_the_corner_of(car: &Car, hidden: &Hidden, other: &Car, steering: f64) {
    let end = corner(car, hidden, 22.0, steering);
    let (yaw, lateral) = single_track(other, end.u, steering / other.steering_ratio);
    close(end.r, yaw, 1e-2, "yaw rate");
    assert!((end.v - lateral).abs() < 1e-2 * end.u * steering / other.steering_ratio, "{end:?}: {lateral}");
    // And not of the car itself.
    let plain = single_track(car, end.u, steering / car.steering_ratio).0;
    assert!((plain / yaw - 1.0).abs() > 0.03, "too weak to be seen: {plain} {yaw}");
}

#[test]
fn steering_compliance_softens_the_front_axle() {
    let car = car(10);
    let compliance = 0.3 / (TRAIL * car.cornering[0]);
    let mut other = car.clone();
    other.cornering[0] /= 1.3;
    is_the_corner_of(&car, &Hidden { compliance, ..Hidden::default() }, &other, 0.08);
}

#[test]
fn a_shifted_centre_of_gravity_understeers_less() {
    let car = car(11);
    let other = Car { a: car.a + 0.08, b: car.b - 0.08, ..car.clone() };
    is_the_corner_of(&car, &Hidden { cg_shift: Some((0.0, 0.08)), ..Hidden::default() }, &other, 0.08);
}

#[test]
fn payload_is_mass() {
    let car = car(12);
    let other = Car { mass: car.mass + 400.0, ..car.clone() };
    is_the_corner_of(&car, &Hidden { payload: 400.0, ..Hidden::default() }, &other, 0.08);
}

#[test]
fn a_softer_surface_is_a_softer_car() {
    let car = car(13);
    let other = Car { cornering: car.cornering.map(|c| 0.6 * c), ..car.clone() };
    let patch = Patch { start: -10.0, end: 100.0, left: 0.6, right: 0.6 };
    is_the_corner_of(&car, &Hidden { stiffness_patches: vec![patch], ..Hidden::default() }, &other, 0.08);
}

#[test]
fn a_varying_ratio_is_another_ratio_at_each_angle() {
    let car = car(14);
    let steering = 0.6;
    let other = Car { steering_ratio: car.steering_ratio * (1.0 - 0.2 * steering * steering), ..car.clone() };
    is_the_corner_of(&car, &Hidden { ratio_curvature: 0.2, ..Hidden::default() }, &other, steering);
}

#[test]
fn steered_rear_wheels_turn_the_car_about_another_point() {
    // Beside a single-track model whose axles are both steered: it turns by the difference, and slips by the rear angle.
    let car = car(23);
    let steering = 0.08;
    let hidden = Hidden { rear_steer: Some((0.2, 16.0)), ..Hidden::default() };
    for speed in [8.0, 16.0, 27.0] {
        let end = corner(&car, &hidden, speed, steering);
        let front = steering / car.steering_ratio;
        let square = (end.u / 16.0).powi(2);
        let rear = -0.2 * front * (1.0 - square) / (1.0 + square);
        let (yaw, lateral) = single_track(&car, end.u, front - rear);
        close(end.r, yaw, 1e-2, "yaw rate");
        assert!((end.v - lateral - end.u * rear).abs() < 1e-2 * end.u * front, "{end:?}: {lateral} {rear}");
        let plain = single_track(&car, end.u, front).0;
        assert!((plain / yaw - 1.0).abs() > 0.03 || speed == 16.0, "too weak to be seen: {plain} {yaw}");
    }
}

#[test]
fn load_transfer_costs_each_axle_what_the_curve_says() {
    let car = car(15);
    let (height, front_share) = (0.6, 0.75);
    let hidden = Hidden {
        load_transfer: Some(LoadTransfer { height, front_share, peak_load: 2.0 }),
        ..Hidden::default()
    };
    // The lateral acceleration of the corner it ends in; loads are then known.
    let lateral = corner(&car, &hidden, 22.0, 0.5).force[1];
    let mut other = car.clone();
    for axle in 0..2 {
        let share = if axle == 0 { front_share } else { 1.0 - front_share };
        let moved = share * car.mass * lateral * height / car.track[axle] / car.static_load()[axle];
        let curve = |x: f64| (2.0 * (x / 2.0).atan()).sin() / (2.0f64 * 0.5f64.atan()).sin();
        other.cornering[axle] *= 0.5 * (curve(1.0 - moved) + curve(1.0 + moved));
    }
    is_the_corner_of(&car, &hidden, &other, 0.5);
}

/// Forward speed after coasting straight ahead.
fn coast(car: &Car, hidden: &Hidden, seconds: f64) -> f64 {
    let path = run(car, hidden, 30.0, seconds + STEP, |_| Input::default());
    path[path.len() - 1].u
}

#[test]
fn coasting_follows_drag_rolling_resistance_and_grade() {
    let car = car(16);
    let inertia = car.mass + 4.0 * car.wheel_inertia / (car.radius * car.radius);
    let t = 10.0;
    let drag = coast(&car, &Hidden { drag: 0.5, ..Hidden::default() }, t);
    close(drag, 1.0 / (1.0 / 30.0 + 0.5 * t / inertia), 1e-4, "air drag");
    let rolling = coast(&car, &Hidden { rolling: 0.012, ..Hidden::default() }, t);
    close(rolling, 30.0 - 0.012 * car.mass * G / inertia * t, 1e-4, "rolling resistance");
    let grade = vec![Bump { start: 0.0, end: 10.0, amplitude: 0.02 }];
    // The mean of sin² is a half.
    let climbed = coast(&car, &Hidden { grade, ..Hidden::default() }, t);
    close(climbed, 30.0 - 0.01 * G * car.mass / inertia * t, 1e-3, "road grade");
}

#[test]
fn an_accelerometer_feels_no_gravity_on_a_road_that_slides_sideways() {
    // Without tires the car falls down the bank, and its accelerometer reads nothing.
    let mut car = car(17);
    (car.cornering, car.slip_stiffness) = ([0.0; 2], 0.0);
    let bank = vec![Bump { start: 0.0, end: 4.0, amplitude: 0.05 }];
    let path = run(&car, &Hidden { bank, ..Hidden::default() }, 20.0, 4.0, |_| Input::default());
    let end = path[path.len() - 1];
    close(end.v, -0.5 * 0.05 * G * 4.0, 2e-3, "sideways");
    assert!(path.iter().all(|m| m.force[1] == 0.0));
}

#[test]
fn roll_leaks_gravity_by_its_gain() {
    let car = car(18);
    let hidden = Hidden { roll_leak: 0.006, ..Hidden::default() };
    let end = corner(&car, &hidden, 20.0, 0.3);
    close(end.roll, 0.006 * end.force[1], 1e-3, "roll angle");
    let shown = Chain::default().shows(&[end, end], STEP, &hidden, 5, 0.0);
    close(shown / end.force[1], 1.0 + 0.006 * G, 1e-3, "accelerometer");
}

#[test]
fn a_lagging_steering_is_a_steering_wheel_turned_later() {
    let car = car(19);
    let turn = |t: f64| 0.3 * (3.0 * t).sin();
    let tau = 0.08;
    let lagging = run(&car, &Hidden { steering_lag: tau, ..Hidden::default() }, 20.0, 6.0, |t| Input {
        steering: turn(t),
        ..Input::default()
    });
    // The exact answer of a first-order lag to a sine that starts at rest.
    let (w, q) = (3.0, 1.0 + 9.0 * tau * tau);
    let late = |t: f64| 0.3 / q * ((w * t).sin() - w * tau * (w * t).cos() + w * tau * (-t / tau).exp());
    let plain = run(&car, &Hidden::default(), 20.0, 6.0, |t| Input { steering: late(t), ..Input::default() });
    let most = plain.iter().fold(0.0f64, |m, x| m.max(x.r.abs()));
    for (x, y) in lagging.iter().zip(&plain) {
        assert!((x.r - y.r).abs() < 3e-3 * most, "{} {}", x.r, y.r);
    }
}

#[test]
fn relaxation_delays_the_front_force_by_its_length() {
    // A step of the steering, at first without yaw: the lateral force rises as 1 − exp(−s/σ).
    let car = car(20);
    let (length, speed) = (0.5, 20.0);
    let path = run(&car, &Hidden { relaxation: length, ..Hidden::default() }, speed, 0.03, |_| Input {
        steering: 0.1,
        ..Input::default()
    });
    let steer = 0.1 / car.steering_ratio;
    for m in &path[2..12] {
        let s = m.position[0];
        let expected = car.cornering[0] * steer * (1.0 - (-s / length).exp()) / car.mass;
        close(m.force[1], expected, 0.08, "lateral force");
    }
}

#[test]
fn torque_vectoring_and_a_single_brake_turn_the_car_by_their_moment() {
    let car = car(21);
    let bump = Bump { start: 0.0, end: 2.0, amplitude: 100.0 };
    for hidden in [
        Hidden { vectoring: vec![bump], ..Hidden::default() },
        Hidden { esp: vec![(0, bump)], ..Hidden::default() },
    ] {
        // Without side forces nothing resists; ten milliseconds of wheel spin do not matter after 2 s.
        let mut free = car.clone();
        free.cornering = [0.0; 2];
        let path = run(&free, &hidden, 20.0, 2.0, |_| Input::default());
        let axle = if hidden.esp.is_empty() && !car.front_driven { 1 } else { 0 };
        // M = T t/(2 R) for a brake on one wheel and for ±T/2 on two, over 2 s at a mean of a half.
        let moment = 100.0 * car.track[axle] / (2.0 * car.radius);
        let resisted = path[path.len() - 1].r * car.yaw_inertia;
        // Yaw makes the other wheels slip: they hold against it.
        assert!(resisted > 0.0 && resisted < moment, "{resisted} {moment}");
        let early = path[300].r_dot;
        let driving = 100.0 * (std::f64::consts::PI * 0.3 / 2.0).sin().powi(2) / 100.0 * moment;
        assert!(early > 0.2 * driving / car.yaw_inertia && early < driving / car.yaw_inertia, "{early}");
    }
}

#[test]
fn a_brake_that_gives_more_turns_the_car_to_its_side() {
    let mut car = car(24);
    // Without side forces nothing but the other wheels' slip resists.
    car.cornering = [0.0; 2];
    for axle in 0..2 {
        let mut hidden = Hidden::default();
        hidden.brake_imbalance[axle] = 0.2;
        let brake = |pressure| run(&car, &hidden, 25.0, 0.3, |_| Input { pressure, ..Input::default() });
        let path = brake(10.0);
        let early = path[path.len() - 1].r_dot * car.yaw_inertia;
        // Twice 0.2 of a brake's torque, half a track from the middle.
        let moment = 0.2 * 10.0 * car.brake_per_bar[axle] * car.track[axle] / car.radius;
        assert!(early > 0.5 * moment && early < moment, "{early} {moment}");
        assert_eq!(brake(0.0).pop().unwrap().r, 0.0, "it pulls while rolling");
    }
}

#[test]
fn a_toed_wheel_and_a_small_one_show_where_they_are() {
    let car = car(22);
    let toe = 0.014;
    let path = run(&car, &Hidden { toe: [-toe, toe, 0.0, 0.0], ..Hidden::default() }, 20.0, 3.0, |_| {
        Input::default()
    });
    let end = path[path.len() - 1];
    assert!(end.r.abs() < 1e-9 && end.v.abs() < 1e-9, "toe-in alone turns nothing");
    // Both front tires push inwards and a little backwards: −2 C/2 toe · sin(toe).
    close(end.force[0] * car.mass, -car.cornering[0] * toe * toe, 0.08, "drag of toe");
    let small = Hidden { radius_error: [0.0, 0.0, -0.006, 0.0], ..Hidden::default() };
    let path = run(&car, &small, 20.0, 3.0, |_| Input::default());
    let end = path[path.len() - 1];
    close(end.omega[2] / end.omega[3], 1.0 / (1.0 - 0.006), 1e-4, "small wheel");
}

#[test]
fn a_bump_is_a_sine_squared() {
    let bump = Bump { start: 1.0, end: 3.0, amplitude: 5.0 };
    assert_eq!(at(&[bump], 1.0), 0.0);
    close(at(&[bump], 2.0), 5.0, 1e-12, "middle");
    close(at(&[bump, bump], 1.5), 5.0, 1e-12, "two of them, a quarter in");
}
