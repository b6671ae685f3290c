//! Why the suite's simulator can be believed: closed forms, balances, and that a cause at no strength changes nothing.

mod chain;
mod effects;
mod motion;
mod road;

use super::car::Car;
use super::dice::Dice;
use super::hidden::Hidden;
use super::physics::{Input, Moment, STEP, Simulator, Start};

fn car(number: u64) -> Car {
    Car::random(&mut Dice::new(17, number), false)
}

/// A drive with given steering, torque and pressure, from straight ahead.
fn run(car: &Car, hidden: &Hidden, speed: f64, seconds: f64, input: impl Fn(f64) -> Input) -> Vec<Moment> {
    let mut simulator = Simulator::new(car, hidden, 0.0, &Start::straight(speed, car), STEP);
    (0..(seconds / STEP).round() as usize).map(|k| simulator.advance(&input(k as f64 * STEP))).collect()
}

/// A corner with the steering wheel held and the speed kept; the last moment of it.
fn corner(car: &Car, hidden: &Hidden, speed: f64, steering: f64) -> Moment {
    let mut simulator = Simulator::new(car, hidden, 0.0, &Start::straight(speed, car), STEP);
    let (mut torque, mut last) = (0.0, Moment::default());
    for k in 0..12_000 {
        let steering = steering * (k as f64 * STEP).min(1.0);
        last = simulator.advance(&Input { steering, torque, pressure: 0.0 });
        torque = 4.0 * car.mass * car.radius * (speed - last.u);
    }
    last
}

/// Yaw rate and lateral velocity of the single-track model in a steady corner (Milliken 1995, eqs. 5.9 to 5.13;
/// Rajamani 2012, §3.1): linear tires, small angles. `steer` at the road wheels, rad.
fn single_track(car: &Car, speed: f64, steer: f64) -> (f64, f64) {
    let length = car.wheelbase();
    let yaw = speed * steer / (length + car.understeer() * speed * speed);
    let rear_slip = car.mass * car.a * speed * yaw / (length * car.cornering[1]);
    (yaw, yaw * car.b - speed * rear_slip)
}

fn close(found: f64, expected: f64, relative: f64, what: &str) {
    let error = (found - expected).abs() / expected.abs().max(1e-12);
    assert!(error < relative, "{what}: {found} instead of {expected} ({error:.1e})");
}
