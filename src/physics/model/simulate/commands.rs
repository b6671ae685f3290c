//! What is commanded: the scenario's inputs, the driver, and what the anti-lock brake makes of it.

use super::driver::{Abs, Demand, Driver};
use super::given::Given;
use super::input::Input;
use super::random::{Stream, random};
use crate::Wheel;
use crate::model::scenario::{Piece, Scenario};
use crate::model::{Conditions, Controls, Plant, Response, State};

/// How torques reach the wheels: a share of the total for each wheel.
#[derive(Clone, Copy, Debug)]
struct Shares {
    drive: [f64; 4],
    brake: [f64; 4],
    /// Brake torque of all wheels per bar, N m; none without the vehicle's figures.
    brake_nm_per_bar: Option<f64>,
}

/// All that commands the car.
#[derive(Clone, Debug)]
pub(super) struct Commands {
    shares: Shares,
    steering_ratio: f64,
    steering: Input,
    drive: Input,
    brake: Input,
    pressure: Input,
    driver: Option<Driver>,
    /// What the driver asked for last.
    demand: Demand,
    abs: Option<Abs>,
    /// Brake pressure asked for, bar; not a number without the vehicle's figures.
    pub(super) pressure_bar: f64,
    /// The anti-lock brake intervenes.
    pub(super) abs_active: bool,
}

/// The car as those who command it know it.
pub(super) struct Known<'a> {
    pub(super) state: &'a State,
    pub(super) response: &'a Response,
    /// As the driver knows it: without effects.
    pub(super) plant: &'a Plant,
    /// As it is.
    pub(super) car: &'a Plant,
    pub(super) conditions: &'a Conditions,
}

impl Commands {
    pub(super) fn new(scenario: &Scenario, seed: u64, plant: &Plant) -> Self {
        let input = |pieces: &[Piece], stream: Stream| {
            Input::new(pieces, scenario.duration_s, |piece| random(seed, stream, piece as u64))
        };
        let driver = scenario.driver.as_ref();
        Self {
            shares: Shares::new(scenario, plant),
            steering_ratio: scenario.vehicle.steering_ratio.value,
            steering: input(&scenario.steering_wheel_angle, Stream::Steering),
            drive: input(&scenario.drive_torque, Stream::Drive),
            brake: input(&scenario.brake_torque, Stream::Brake),
            pressure: input(&scenario.brake_pressure, Stream::Pressure),
            driver: driver.map(|config| Driver::new(config, input(&config.speed_mps, Stream::Speed))),
            demand: Demand::default(),
            abs: scenario.abs.as_ref().map(Abs::new),
            pressure_bar: 0.0,
            abs_active: false,
        }
    }

    /// Angle of the steering wheel at `t`, rad.
    pub(super) fn steering_wheel_angle(&self, t: f64) -> f64 {
        self.steering.at(t)
    }

    /// Is the wheel driven?
    pub(super) fn drives(&self, wheel: Wheel) -> bool {
        self.shares.drive[wheel as usize] != 0.0
    }

    /// What is commanded for the step of `h` seconds that begins at `t`.
    pub(super) fn at(&mut self, t: f64, h: f64, known: &Known<'_>) -> Controls {
        let vx = known.state.velocity.vx;
        let pedal = self.pressed(t) > 0.0;
        if let Some(driver) = &mut self.driver {
            let wheels = self.shares.drive.iter().zip(known.response.slip);
            let driven = wheels.filter(|(share, _)| **share != 0.0).map(|(_, slip)| slip);
            driver.feel(driven.fold(0.0, f64::max), h);
            self.demand = driver.step(t, h, vx, pedal, known.plant);
        }
        let mut controls = self.again(t);
        if let Some(abs) = &mut self.abs {
            let now = (known.state, known.response);
            self.abs_active = abs.step(t, h, now, known.car, known.conditions, &mut controls.brake_torque);
        }
        controls
    }

    /// Brake torque of all wheels that the pedal asks for, N m.
    fn pressed(&self, t: f64) -> f64 {
        let per_bar = self.shares.brake_nm_per_bar.unwrap_or(0.0);
        self.brake.at(t).max(0.0) + per_bar * self.pressure.at(t).max(0.0)
    }

    /// The same without a step of driver and anti-lock brake: the driver goes on asking for what he asked for last, and
    /// nothing limits the brakes until the next step.
    pub(super) fn again(&mut self, t: f64) -> Controls {
        let drive = self.demand.drive_nm + self.drive.at(t);
        let brake = self.demand.brake_nm + self.pressed(t);
        self.pressure_bar = self.shares.brake_nm_per_bar.map_or(f64::NAN, |per_bar| brake / per_bar);
        Controls {
            steer: self.steering.at(t) / self.steering_ratio,
            drive_torque: self.shares.drive.map(|share| share * drive),
            brake_torque: self.shares.brake.map(|share| share * brake),
        }
    }

    /// From `t` on, these inputs instead of the scenario's.
    pub(super) fn give(&mut self, t: f64, given: &Given) {
        self.steering.give(t, given.steering_wheel_angle);
        self.drive.give(t, given.drive_torque);
        self.brake.give(t, given.brake_torque);
        self.pressure.give(t, given.brake_pressure);
        if let Some(driver) = &mut self.driver {
            driver.give(t, given.speed);
        }
    }

    /// Torques and steering as another car of the same kind takes them.
    pub(super) fn retune(&mut self, scenario: &Scenario, plant: &Plant) {
        self.shares = Shares::new(scenario, plant);
        self.steering_ratio = scenario.vehicle.steering_ratio.value;
    }
}

impl Shares {
    fn new(scenario: &Scenario, plant: &Plant) -> Self {
        let vehicle = &scenario.vehicle;
        let driven = Wheel::ALL.map(|wheel| f64::from(u8::from(vehicle.driven_axle.drives(wheel))));
        let count: f64 = driven.iter().sum();
        let per_bar = vehicle.brake_torque_per_bar_front_nm.zip(vehicle.brake_torque_per_bar_rear_nm);
        let brake = per_bar.map_or(plant.nominal.load, |(front, rear)| {
            Wheel::ALL.map(|wheel| if wheel.is_front() { front.value } else { rear.value })
        });
        let total: f64 = brake.iter().sum();
        Self {
            drive: driven.map(|driven| driven / count),
            brake: brake.map(|brake| brake / total),
            brake_nm_per_bar: per_bar.map(|_| total),
        }
    }
}
