//! The car's motion against closed forms and balances.

use super::super::hidden::Bump;
use super::super::tire::{self, Grip};
use super::*;

#[test]
fn a_steady_corner_is_the_single_track_models() {
    for number in 0..4 {
        let car = car(number);
        for speed in [10.0, 20.0, 30.0] {
            let end = corner(&car, &Hidden::default(), speed, 0.05);
            let (yaw, lateral) = single_track(&car, end.u, 0.05 / car.steering_ratio);
            close(end.r, yaw, 5e-3, "yaw rate");
            assert!((end.v - lateral).abs() < 5e-3 * end.u * 0.05 / car.steering_ratio, "{end:?}: {lateral}");
            close(end.force[1], end.u * end.r, 1e-4, "lateral acceleration");
        }
    }
}

#[test]
fn wheels_in_a_circle_turn_as_their_hubs_travel() {
    let car = car(1);
    let end = corner(&car, &Hidden::default(), 9.0, 2.0);
    let steer = 2.0 / car.steering_ratio;
    let undriven = if car.front_driven { [2, 3] } else { [0, 1] };
    for wheel in 0..4 {
        let (x, angle) = if wheel < 2 { (car.a, steer) } else { (-car.b, 0.0) };
        let y = if wheel % 2 == 0 { 0.5 } else { -0.5 } * car.track[wheel / 2];
        let (hub_u, hub_v) = (end.u - y * end.r, end.v + x * end.r);
        let along = hub_u * angle.cos() + hub_v * angle.sin();
        // Nothing drives or brakes the other axle: its wheels roll without slip.
        let tolerance = if undriven.contains(&wheel) { 1e-5 } else { 0.02 };
        close(end.omega[wheel] * car.radius, along, tolerance, "wheel speed");
    }
    assert!(end.omega[1] > 1.03 * end.omega[0] && end.omega[3] > 1.03 * end.omega[2], "{:?}", end.omega);
}

#[test]
fn a_circle_is_a_circle_on_the_ground() {
    let car = car(2);
    let input = |t: f64| Input { steering: 1.5 * t.min(1.0), ..Input::default() };
    let path = run(&car, &Hidden::default(), 10.0, 8.0, input);
    for pair in path[2000..].windows(2) {
        let (p, q) = (pair[0], pair[1]);
        let heading = 0.5 * (p.heading + q.heading);
        let (u, v) = (0.5 * (p.u + q.u), 0.5 * (p.v + q.v));
        let (sin, cos) = heading.sin_cos();
        let travelled = [q.position[0] - p.position[0], q.position[1] - p.position[1]];
        assert!((travelled[0] - (u * cos - v * sin) * STEP).abs() < 1e-7);
        assert!((travelled[1] - (u * sin + v * cos) * STEP).abs() < 1e-7);
        assert!((q.heading - p.heading - 0.5 * (p.r + q.r) * STEP).abs() < 1e-9);
    }
}

/// A drive torque and a brake pressure that come and go.
fn feet(t: f64) -> Input {
    let torque = 900.0 * (0.8 * t).sin().max(0.0);
    Input { steering: 0.0, torque, pressure: 25.0 * (0.8 * t).sin().min(0.0).abs() }
}

fn energy(car: &Car, m: &Moment) -> f64 {
    let spin: f64 = m.omega.iter().map(|w| w * w).sum();
    0.5 * (car.mass * (m.u * m.u + m.v * m.v) + car.yaw_inertia * m.r * m.r + car.wheel_inertia * spin)
}

#[test]
fn straight_ahead_the_momentum_is_what_the_feet_gave() {
    let car = car(3);
    let path = run(&car, &Hidden::default(), 20.0, 10.0, feet);
    let momentum = |m: &Moment| car.mass * m.u + car.wheel_inertia * m.omega.iter().sum::<f64>() / car.radius;
    let brakes = 2.0 * (car.brake_per_bar[0] + car.brake_per_bar[1]);
    let mut given = momentum(&path[0]);
    for pair in path.windows(2) {
        given += (pair[0].input.torque - brakes * pair[0].input.pressure) / car.radius * STEP;
        close(momentum(&pair[1]), given, 1e-9, "momentum");
    }
}

#[test]
fn straight_ahead_the_energy_goes_where_it_must() {
    let car = car(4);
    let path = run(&car, &Hidden::default(), 20.0, 10.0, feet);
    let brakes = [car.brake_per_bar[0], car.brake_per_bar[1]];
    let driven = if car.front_driven { 0 } else { 2 };
    // Power of engine and brakes, and what the tires turn into heat.
    let power = |m: &Moment| {
        let engine = m.input.torque * 0.5 * (m.omega[driven] + m.omega[driven + 1]);
        let braking: f64 = (0..4).map(|i| brakes[i / 2] * m.input.pressure * m.omega[i]).sum();
        let heat: f64 =
            m.omega.iter().map(|w| car.slip_stiffness * (car.radius * w - m.u).powi(2) / m.u).sum();
        engine - braking - heat
    };
    let mut expected = energy(&car, &path[0]);
    for pair in path.windows(2) {
        // The inputs are held from the first of the two.
        let later = Moment { input: pair[0].input, ..pair[1] };
        expected += 0.5 * (power(&pair[0]) + power(&later)) * STEP;
    }
    close(energy(&car, &path[path.len() - 1]), expected, 2e-6, "energy");
}

#[test]
fn a_car_left_to_itself_never_gains_energy() {
    for hidden in [Hidden::default(), Hidden { drag: 0.4, rolling: 0.012, ..Hidden::default() }] {
        let car = car(5);
        let input = |t: f64| Input { steering: 0.8 * (2.0 * t).sin(), ..Input::default() };
        let path = run(&car, &hidden, 25.0, 12.0, input);
        for pair in path.windows(2) {
            let gain = energy(&car, &pair[1]) / energy(&car, &pair[0]) - 1.0;
            assert!(gain < 1e-12, "{gain:e}");
        }
    }
}

#[test]
fn a_body_without_tires_obeys_newton_in_ground_axes() {
    let mut car = car(6);
    (car.cornering, car.slip_stiffness) = ([0.0; 2], 0.0);
    let bump = Bump { start: 0.5, end: 2.5, amplitude: 800.0 };
    let hidden = Hidden { wind: vec![bump], wind_at: 0.3, ..Hidden::default() };
    let start = Start { r: 0.4, v: 1.0, ..Start::straight(20.0, &car) };
    for hidden in [Hidden::default(), hidden] {
        let mut simulator = Simulator::new(&car, &hidden, 0.0, &start, STEP);
        let (mut ground, mut yaw) = ([20.0, 1.0], 0.4);
        for _ in 0..4000 {
            let m = simulator.advance(&Input::default());
            let (sin, cos) = m.heading.sin_cos();
            assert!((m.u * cos - m.v * sin - ground[0]).abs() < 1e-5, "{m:?}");
            assert!((m.u * sin + m.v * cos - ground[1]).abs() < 1e-5, "{m:?}");
            assert!((m.r - yaw).abs() < 1e-5, "{m:?}");
            // The wind pushes along the body's own lateral axis; by the trapezoidal rule, half a step on.
            let force = super::super::hidden::at(&hidden.wind, simulator.time() - 0.5 * STEP);
            let middle = m.heading + 0.5 * STEP * m.r;
            ground[0] -= force / car.mass * middle.sin() * STEP;
            ground[1] += force / car.mass * middle.cos() * STEP;
            yaw += force * 0.3 / car.yaw_inertia * STEP;
        }
        assert!(hidden.wind.is_empty() || yaw > 0.45, "the wind turned nothing");
    }
}

#[test]
fn half_the_step_changes_nothing_that_matters() {
    let car = Car::random(&mut Dice::new(17, 7), true);
    let end = |step: f64| {
        let hidden = Hidden::default();
        let mut simulator = Simulator::new(&car, &hidden, 0.0, &Start::straight(20.0, &car), step);
        let mut last = Moment::default();
        // Inputs held a millisecond either way.
        for k in 0..6000 {
            let t = k as f64 * STEP;
            let input = Input { steering: 0.9 * (2.5 * t).sin(), ..feet(t) };
            for _ in 0..(STEP / step).round() as usize {
                last = simulator.advance(&input);
            }
        }
        let m = simulator.advance(&Input::default());
        (m.u, m.v, m.r, last.force[1])
    };
    let (coarse, fine) = (end(STEP), end(0.5 * STEP));
    assert!((coarse.0 - fine.0).abs() < 1e-8 && (coarse.1 - fine.1).abs() < 1e-8, "{coarse:?} {fine:?}");
    assert!((coarse.2 - fine.2).abs() < 1e-8, "{coarse:?} {fine:?}");
}

#[test]
fn a_tire_starts_at_its_stiffness_peaks_at_its_friction_and_stays_in_the_circle() {
    let (stiffness, load, friction) = (50_000.0, 4000.0, 0.9);
    close(tire::magic_formula(1e-6, stiffness, friction * load), 0.05, 1e-4, "slope");
    let peak = (0..2000)
        .map(|k| tire::magic_formula(k as f64 * 1e-3, stiffness, friction * load))
        .fold(0.0, f64::max);
    close(peak, friction * load, 1e-4, "peak");
    let grip =
        Grip { longitudinal: stiffness, lateral: stiffness, load, friction: Some(friction), ellipse: None };
    for (slip, angle) in [(0.0, 0.5), (0.1, 0.1), (-0.3, 0.2), (1.0, -1.0)] {
        let [along, across] = tire::force(slip, angle, &grip);
        assert!(along.hypot(across) <= friction * load * (1.0 + 1e-12));
        assert!(along * slip >= 0.0 && across * angle >= 0.0);
    }
    // A linear tire with the ellipse alone: half of the friction used along leaves √(1 − ¼) across.
    let linear = Grip { friction: None, ellipse: Some((1.0, friction)), ..grip };
    let slip = 0.5 * friction * load / stiffness;
    close(tire::force(slip, 0.02, &linear)[1], 1000.0 * 0.75f64.sqrt(), 1e-12, "ellipse");
}
