//! The plant's physics: forces, energy, symmetry, steady states, standstill, convergence.

use gripd::model::body::Velocity;
use gripd::model::integrate::{advance, advance_in};
use gripd::model::{Conditions, Controls, DrivenAxle, GRAVITY, Plant, State, TireKind, Uncertain, Vehicle};
use proptest::prelude::*;

const KINDS: [TireKind; 4] = [TireKind::Linear, TireKind::Piecewise, TireKind::Brush, TireKind::MagicFormula];

fn vehicle(tire: TireKind) -> Vehicle {
    Vehicle { tire, ..Vehicle::thesis() }
}

fn run(plant: &Plant, mut state: State, controls: &Controls, seconds: f64) -> State {
    for _ in 0..(seconds * 1e3).round() as usize {
        state = advance(plant, &state, controls, controls, &plant.nominal, 1e-3);
    }
    state
}

fn energy(plant: &Plant, state: &State) -> f64 {
    let Velocity { vx, vy, yaw_rate } = state.velocity;
    let wheels: f64 = state.wheel_speed.iter().map(|w| w * w).sum();
    0.5 * (plant.body.mass * (vx * vx + vy * vy)
        + plant.body.yaw_inertia * yaw_rate * yaw_rate
        + plant.wheel_inertia * wheels)
}

fn distance(one: &State, other: &State) -> f64 {
    let pairs = one.to_array().into_iter().zip(other.to_array());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn halving_the_step_divides_the_error_by_sixteen() {
    // A curve smooth to all orders, used within the ellipse.
    let plant = Plant::new(&vehicle(TireKind::MagicFormula));
    let end = |substeps: u32| {
        let mut state = State::rolling(&plant, 20.0);
        for i in 0..200 {
            let at = |i: i32| {
                let t = f64::from(i) * 4e-3;
                let torque = 300.0 * (2.0 * t).sin();
                Controls {
                    steer: 0.02 * (4.0 * t).sin(),
                    drive_torque: [torque, torque, 0.0, 0.0],
                    brake_torque: [0.0; 4],
                }
            };
            state = advance_in(&plant, &state, &at(i), &at(i + 1), &plant.nominal, 4e-3, substeps);
        }
        state
    };
    let exact = end(64);
    let errors = [2, 4, 8].map(|substeps| distance(&end(substeps), &exact));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((3.6..4.6).contains(&order), "order {order}, errors {errors:?}");
    }
}

#[test]
fn the_chosen_substeps_are_accurate_at_every_speed() {
    // Worst at low speed, where the wheels are fastest; braking into the limit and out again.
    for speed in [30.0, 8.0, 2.0, 0.7] {
        for kind in KINDS {
            let plant = Plant::new(&vehicle(kind));
            let drive = |finer: u32| {
                let mut state = State::rolling(&plant, speed);
                for i in 0..400 {
                    let at = |i: i32| {
                        let torque = 400.0 * (f64::from(i) * 1e-3 * 30.0).sin();
                        Controls {
                            steer: 0.02,
                            drive_torque: [torque, torque, 0.0, 0.0],
                            brake_torque: [0.0; 4],
                        }
                    };
                    let substeps = gripd::model::integrate::substeps(&plant, &state, &plant.nominal, 1e-3);
                    let (from, to) = (at(i), at(i + 1));
                    state = advance_in(&plant, &state, &from, &to, &plant.nominal, 1e-3, finer * substeps);
                }
                state
            };
            let error = distance(&drive(1), &drive(8));
            assert!(error < 1e-4, "{kind:?} at {speed} m/s: {error}");
        }
    }
}

/// Torque steps excite every wheel's own fast motion at each speed. The tire is smooth, the steps fall on the
/// ends of integration steps, and the reference is a hundred times finer.
#[test]
fn the_stated_step_converges_with_order_four_through_wheel_transients() {
    let h = 1e-3;
    for (axle, driven) in [(DrivenAxle::Front, 2.0), (DrivenAxle::Rear, 2.0), (DrivenAxle::All, 4.0)] {
        let plant = Plant::new(&vehicle(TireKind::MagicFormula));
        for speed in [2.0, 5.0, 10.0, 20.0, 40.0] {
            let drive = |finer: u32| {
                let mut state = State::rolling(&plant, speed);
                for i in 0..300 {
                    let torque = [800.0, -400.0, 0.0][i / 100] / driven;
                    let controls = Controls {
                        steer: 0.01,
                        drive_torque: gripd::Wheel::ALL.map(|it| if axle.drives(it) { torque } else { 0.0 }),
                        brake_torque: [0.0; 4],
                    };
                    let substeps = gripd::model::integrate::substeps(&plant, &state, &plant.nominal, h);
                    state =
                        advance_in(&plant, &state, &controls, &controls, &plant.nominal, h, finer * substeps);
                }
                state
            };
            let exact = drive(100);
            let errors = [1, 2, 4].map(|finer| distance(&drive(finer), &exact));
            assert!(errors[0] < 1e-4, "{axle:?} at {speed} m/s: {errors:?}");
            for pair in errors.windows(2).filter(|pair| pair[1] > 1e-11) {
                let order = (pair[0] / pair[1]).log2();
                assert!((3.5..5.2).contains(&order), "{axle:?} at {speed} m/s: order {order}, {errors:?}");
            }
        }
    }
}

#[test]
fn drive_torque_accelerates_mass_and_wheels() {
    for (axle, driven) in [(DrivenAxle::Front, 2.0), (DrivenAxle::Rear, 2.0), (DrivenAxle::All, 4.0)] {
        let mut car = vehicle(TireKind::Linear);
        car.driven_axle = axle;
        car.drag_coefficient_kg_per_m = Uncertain::known(0.0);
        let plant = Plant::new(&car);
        let torque = gripd::Wheel::ALL.map(|wheel| if axle.drives(wheel) { 600.0 / driven } else { 0.0 });
        let controls = Controls { drive_torque: torque, ..Controls::default() };
        let settled = run(&plant, State::rolling(&plant, 20.0), &controls, 0.5);
        let after = run(&plant, settled, &controls, 1.0);
        let radius = car.wheel_radius_m.value;
        let inertia = car.mass() + 4.0 * car.wheel_inertia_kgm2.value / (radius * radius);
        let expected = 600.0 / radius / inertia;
        let got = after.velocity.vx - settled.velocity.vx;
        // The slip of the driven wheels (0.5 %) turns them a little faster than the car goes.
        assert!((got / expected - 1.0).abs() < 2e-3, "{axle:?}: {got} against {expected}");
    }
}

#[test]
fn steady_cornering_is_that_of_the_bicycle() {
    let mut car = vehicle(TireKind::Linear);
    car.drag_coefficient_kg_per_m = Uncertain::known(0.0);
    car.cg_to_front_m = Uncertain::known(1.3);
    car.lateral_stiffness_rear = Uncertain::known(14.0);
    let plant = Plant::new(&car);
    let (a, b, mass, length) = (car.a(), car.b(), car.mass(), car.wheelbase_m.value);
    let front = 2.0 * car.wheel_cornering_stiffness(true);
    let rear = 2.0 * car.wheel_cornering_stiffness(false);
    for speed in [8.0, 15.0, 30.0] {
        let controls = Controls { steer: 1e-3, ..Controls::default() };
        let state = run(&plant, State::rolling(&plant, speed), &controls, 4.0);
        let vx = state.velocity.vx;
        let understeer = mass / length * (b / front - a / rear);
        let gain = vx / (length + understeer * vx * vx);
        let got = state.velocity.yaw_rate / controls.steer;
        assert!((got / gain - 1.0).abs() < 1e-3, "{speed} m/s: {got} against {gain}");
        let sideslip = (b - mass * a * vx * vx / (rear * length)) / (length + understeer * vx * vx) * 1e-3;
        let got = state.velocity.vy / vx;
        assert!((got - sideslip).abs() < 2e-3 * 1e-3, "{got} against {sideslip}");
    }
}

#[test]
fn full_braking_with_locked_wheels_is_mu_g() {
    for kind in [TireKind::Piecewise, TireKind::Brush] {
        let mut car = vehicle(kind);
        car.friction = Uncertain::known(0.6);
        car.drag_coefficient_kg_per_m = Uncertain::known(0.0);
        let plant = Plant::new(&car);
        let controls = Controls { brake_torque: [5000.0; 4], ..Controls::default() };
        let locked = run(&plant, State::rolling(&plant, 20.0), &controls, 0.5);
        assert_eq!(locked.wheel_speed, [0.0; 4]);
        let after = run(&plant, locked, &controls, 1.0);
        let deceleration = locked.velocity.vx - after.velocity.vx;
        assert!((deceleration / (0.6 * GRAVITY) - 1.0).abs() < 1e-6, "{deceleration}");
    }
}

#[test]
fn brakes_stop_the_car_and_hold_it() {
    for kind in KINDS {
        let plant = Plant::new(&vehicle(kind));
        for speed in [5.0, -5.0] {
            let mut state = State::rolling(&plant, speed);
            let controls = Controls { brake_torque: [600.0; 4], ..Controls::default() };
            for _ in 0..4000 {
                state = advance(&plant, &state, &controls, &controls, &plant.nominal, 1e-3);
                for wheel in state.wheel_speed {
                    assert!(wheel * speed.signum() >= 0.0, "{kind:?}: a brake turned a wheel backwards");
                }
            }
            assert!(state.velocity.vx.abs() < 1e-6, "{kind:?}: {state:?}");
            // Held against a drive torque below the brakes', released by one above.
            let mut held = controls;
            held.drive_torque = [500.0, 500.0, 0.0, 0.0];
            let still = run(&plant, State::default(), &held, 1.0);
            assert_eq!(still, State::default());
            held.drive_torque = [-900.0, -900.0, 0.0, 0.0];
            held.brake_torque = [300.0, 300.0, 0.0, 0.0];
            assert!(run(&plant, State::default(), &held, 1.0).velocity.vx < -1.0);
        }
    }
}

#[test]
fn what_stands_stays() {
    for kind in KINDS {
        let plant = Plant::new(&vehicle(kind));
        let turned = Controls { steer: 0.5, ..Controls::default() };
        assert_eq!(run(&plant, State::default(), &turned, 2.0), State::default());
    }
}

#[test]
fn rolling_resistance_and_drag_slow_a_car_but_do_not_push_it_back() {
    let mut car = vehicle(TireKind::Brush);
    car.rolling_resistance = Uncertain::known(0.012);
    let plant = Plant::new(&car);
    let controls = Controls::default();
    let state = run(&plant, State::rolling(&plant, 20.0), &controls, 1.0);
    let inertia = car.mass() + 4.0 * 2.65 / (0.31 * 0.31);
    let expected = (0.5 * 19.95f64.powi(2) + 0.012 * 1700.0 * GRAVITY) / inertia;
    assert!((20.0 - state.velocity.vx - expected).abs() < 2e-3, "{}", 20.0 - state.velocity.vx);
    let slow = run(&plant, State::rolling(&plant, 0.3), &controls, 60.0);
    assert!((0.0..1e-3).contains(&slow.velocity.vx), "{slow:?}");
}

fn any_state() -> impl Strategy<Value = State> {
    let wheel = || -150.0..150.0f64;
    let speed = prop_oneof![-40.0..40.0f64, -1.0..1.0f64, Just(0.0)];
    (speed, -10.0..10.0f64, -3.0..3.0f64, [wheel(), wheel(), wheel(), wheel()]).prop_map(
        |(vx, vy, yaw_rate, wheel_speed)| State { velocity: Velocity { vx, vy, yaw_rate }, wheel_speed },
    )
}

fn any_controls() -> impl Strategy<Value = Controls> {
    let drive = || -3000.0..3000.0f64;
    let brake = || prop_oneof![Just(0.0), 0.0..4000.0f64];
    (-0.7..0.7f64, [drive(), drive(), drive(), drive()], [brake(), brake(), brake(), brake()])
        .prop_map(|(steer, drive_torque, brake_torque)| Controls { steer, drive_torque, brake_torque })
}

fn any_conditions(plant: &Plant, friction: f64, factor: f64) -> Conditions {
    let mut conditions = plant.nominal;
    for contact in &mut conditions.contact {
        contact.friction_x = friction;
        contact.friction_y = friction;
        contact.stiffness_x *= factor;
        contact.stiffness_y *= factor;
    }
    conditions
}

fn mirrored(state: &State) -> State {
    let [fl, fr, rl, rr] = state.wheel_speed;
    let Velocity { vx, vy, yaw_rate } = state.velocity;
    State { velocity: Velocity { vx, vy: -vy, yaw_rate: -yaw_rate }, wheel_speed: [fr, fl, rr, rl] }
}

fn swapped([fl, fr, rl, rr]: [f64; 4]) -> [f64; 4] {
    [fr, fl, rr, rl]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn nothing_blows_up_and_no_tire_exceeds_its_friction(
        index in 0..KINDS.len(), start in any_state(), controls in any_controls(),
        friction in 0.05..1.2f64, factor in 0.2..2.0f64,
    ) {
        let plant = Plant::new(&vehicle(KINDS[index]));
        let conditions = any_conditions(&plant, friction, factor);
        let mut state = start;
        for _ in 0..100 {
            let response = plant.respond(&state, &controls, &conditions);
            for i in 0..4 {
                let used = response.fx[i].hypot(response.fy[i]) / conditions.load[i];
                prop_assert!(KINDS[index] == TireKind::Linear || used <= friction * (1.0 + 1e-9));
            }
            state = advance(&plant, &state, &controls, &controls, &conditions, 1e-3);
            prop_assert!(state.to_array().iter().all(|value| value.is_finite()), "{state:?}");
        }
    }

    #[test]
    fn tires_only_take_energy(index in 0..KINDS.len(), start in any_state(), friction in 0.05..1.2f64) {
        let mut car = vehicle(KINDS[index]);
        car.friction = Uncertain::known(friction);
        let plant = Plant::new(&car);
        let controls = Controls::default();
        let mut state = start;
        for _ in 0..100 {
            let next = advance(&plant, &state, &controls, &controls, &plant.nominal, 1e-3);
            let (before, after) = (energy(&plant, &state), energy(&plant, &next));
            prop_assert!(after <= before * (1.0 + 1e-9) + 1e-9, "{before} J, then {after} J");
            state = next;
        }
    }

    #[test]
    fn left_and_right_are_alike(
        index in 0..KINDS.len(), start in any_state(), controls in any_controls(),
    ) {
        let plant = Plant::new(&vehicle(KINDS[index]));
        let other = Controls {
            steer: -controls.steer,
            drive_torque: swapped(controls.drive_torque),
            brake_torque: swapped(controls.brake_torque),
        };
        let here = plant.respond(&start, &controls, &plant.nominal).rate;
        let there = plant.respond(&mirrored(&start), &other, &plant.nominal).rate;
        let scale = here.to_array().iter().fold(1.0, |most: f64, value| most.max(value.abs()));
        prop_assert!(distance(&mirrored(&there), &here) <= 1e-9 * scale);
    }
}
