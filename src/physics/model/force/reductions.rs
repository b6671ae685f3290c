//! The core in its limits: the linear bicycle, and wheels that have settled.

use super::{AddedMass, WheelMotion};
use crate::model::body::{Body, External, Steer, Velocity};
use crate::model::integrate::advance;
use crate::model::{Bicycle, Controls, Plant, State, TireKind, Vehicle, wheel};

fn plant(tire: TireKind) -> Plant {
    let mut vehicle = Vehicle { tire, ..Vehicle::thesis() };
    vehicle.cg_to_front_m.value = 1.2;
    Plant::new(&vehicle)
}

#[test]
fn small_angles_on_linear_tires_are_the_linear_bicycle() {
    let plant = plant(TireKind::Linear);
    let Body { mass, yaw_inertia, a, b, .. } = plant.body;
    let axle = |i: usize| 2.0 * plant.nominal.contact[i].stiffness_y * plant.nominal.load[i];
    let bicycle = Bicycle { mass, yaw_inertia, a, b, front: axle(0), rear: axle(2) };
    let (by_state, by_angle) = bicycle.dynamics(20.0);
    for (vy, yaw_rate, steer) in [(1e-4, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 1e-4), (3e-4, -1e-4, 2e-4)] {
        let velocity = Velocity { vx: 20.0, vy, yaw_rate };
        let motion = WheelMotion::new(&plant.body, velocity, Steer::new(steer), None);
        // Every wheel rolls freely.
        let wheel_speed = std::array::from_fn(|i| motion.along[i] / plant.radius[i]);
        let controls = Controls { steer, ..Controls::default() };
        let rate = plant.respond(&State { velocity, wheel_speed }, &controls, &plant.nominal).rate;
        let linear = by_state * nalgebra::Vector2::new(vy, yaw_rate) + by_angle * steer;
        let size = linear.norm();
        assert!((rate.velocity.vy - linear[0]).abs() < 1e-6 * size, "{rate:?} {linear}");
        assert!((rate.velocity.yaw_rate - linear[1]).abs() < 1e-6 * size, "{rate:?} {linear}");
    }
}

#[test]
fn a_wheel_that_has_settled_needs_no_state() {
    for kind in [TireKind::Linear, TireKind::Piecewise, TireKind::Brush, TireKind::MagicFormula] {
        let plant = plant(kind);
        let controls = Controls {
            steer: 0.015,
            drive_torque: [250.0, 250.0, 0.0, 0.0],
            brake_torque: [0.0, 0.0, 40.0, 40.0],
        };
        let mut state = State::rolling(&plant, 20.0);
        for _ in 0..1500 {
            state = advance(&plant, &state, &controls, &controls, &plant.nominal, 1e-3);
        }
        let integrated = plant.respond(&state, &controls, &plant.nominal).acceleration;

        let Plant { body, tire, radius, nominal, .. } = &plant;
        let motion = WheelMotion::new(body, state.velocity, Steer::new(controls.steer), None);
        let torque = |i: usize| controls.drive_torque[i] - controls.brake_torque[i];
        let fx: [f64; 4] = std::array::from_fn(|i| torque(i) / radius[i]);
        let fy = std::array::from_fn(|i| {
            let (contact, load) = (&nominal.contact[i], nominal.load[i]);
            tire.across(tire, contact, fx[i] / load, motion.slip_angle[i]) * load
        });
        let bare = motion.accelerate(body, &fx, &fy, &External::none());
        let added = AddedMass::new(body, radius.map(|radius| plant.wheel_inertia / (radius * radius)));
        let carried = added.carried(body, &motion, &bare, 0.0);
        let eliminated = carried.acceleration;
        assert!((eliminated.ax - integrated.ax).abs() < 0.01, "{kind:?} {eliminated:?} {integrated:?}");
        assert!((eliminated.ay - integrated.ay).abs() < 0.01, "{kind:?} {eliminated:?} {integrated:?}");
        assert!((eliminated.yaw - integrated.yaw).abs() < 0.01, "{kind:?} {eliminated:?} {integrated:?}");
        for i in 0..4 {
            let x = added.on_road(body, &carried, i, fx[i]) / nominal.load[i];
            let slip = tire.slip_at(&nominal.contact[i], x, motion.slip_angle[i]);
            let said = wheel::speed_of_slip(motion.along[i], slip, radius[i]);
            assert!((said / state.wheel_speed[i] - 1.0).abs() < 1e-4, "{kind:?} {i}");
        }
    }
}
