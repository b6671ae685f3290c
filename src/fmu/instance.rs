//! A car in an FMU: parameters and inputs go in by value reference, steps are made, outputs come out.

use std::sync::Arc;

use physics::model::body::Velocity;
use physics::model::{Given, Line, Simulation, State};
use physics::{Micros, Quantity};
use thiserror::Error;

use crate::car::{Car, CarError, LONGEST_S, Part, Setting};
use crate::variables::{ADDED, Causality, Input, Place, Setting as Fixed, Variable, variables};

/// Why a call cannot be obeyed.
#[derive(Debug, Error)]
pub enum Refused {
    /// No such variable, or none of this type.
    #[error("there is no {0} variable with the value reference {1}")]
    NoVariable(&'static str, u32),
    /// It cannot be set, or not any more.
    #[error("{0} cannot be set{1}")]
    NotSettable(String, &'static str),
    /// A value that cannot be.
    #[error("{0} = {1}: a finite number is needed")]
    NotFinite(String, f64),
    /// Numbers of the car that cannot be.
    #[error(transparent)]
    Car(#[from] CarError),
    /// A step that does not fit.
    #[error(
        "a communication step of {0} s is no multiple of the internal step of {1} s; set the parameter internal_step to a \
         whole number of microseconds that divides it"
    )]
    Step(f64, f64),
    /// A step from another time than that of the car.
    #[error("the step begins at {0} s, and the car is at {1} s")]
    Time(f64, f64),
    /// The drive is too long.
    #[error("the drive is longer than {LONGEST_S} s")]
    TooLong,
    /// The motion has become one of no numbers.
    #[error("at {0} s the motion is no longer a number; are inputs and parameters those of a car?")]
    Diverged(f64),
}

/// How far times may be apart for rounding, s.
const ROUNDING_S: f64 = 1e-7;

/// A car being driven.
#[derive(Clone, Debug)]
pub struct Instance {
    car: Arc<Car>,
    variables: Arc<[Variable]>,
    /// What has been set, by value reference.
    values: Vec<f64>,
    /// Rates of the inputs until the end of the next step, per second.
    rates: Inputs,
    /// Inputs at the end of the last step.
    last: Inputs,
    start_s: f64,
    /// From the first question on, or the end of the initialization.
    simulation: Option<Box<Simulation>>,
    /// The initialization is over.
    is_running: bool,
    /// Parameters have changed since the last step.
    is_retuned: bool,
    /// The columns of the truth now, and what the sensors say.
    truth: Vec<f64>,
    measured: [f64; Quantity::COUNT],
    /// What perfect sensors would say, and what effects add to a plain car: of a correction.
    perfect: [f64; Quantity::COUNT],
    added: [f64; ADDED.len()],
}

impl Instance {
    /// A car with its own numbers, standing.
    pub fn new(car: Car) -> Self {
        let variables: Arc<[Variable]> = variables(&car).into();
        let values = variables.iter().map(|variable| variable.start).collect();
        Self {
            car: Arc::new(car),
            variables,
            values,
            rates: NO_RATES,
            last: NO_RATES,
            start_s: 0.0,
            simulation: None,
            is_running: false,
            is_retuned: false,
            truth: vec![],
            measured: [f64::NAN; Quantity::COUNT],
            perfect: [f64::NAN; Quantity::COUNT],
            added: [0.0; ADDED.len()],
        }
    }

    /// As at the beginning.
    pub fn reset(&mut self) {
        *self = Self::new(Car::clone(&self.car));
    }

    /// The time at which it starts, s.
    pub fn start_at(&mut self, start_s: f64) {
        self.start_s = start_s;
    }

    /// Ends the initialization.
    ///
    /// # Errors
    /// Parameters that cannot be.
    pub fn initialize(&mut self) -> Result<(), Refused> {
        self.ready()?;
        self.is_running = true;
        Ok(())
    }

    fn variable(&self, reference: u32, is_switch: bool) -> Result<&Variable, Refused> {
        let found = self.variables.get(reference as usize);
        let kind = if is_switch { "Boolean" } else { "real" };
        found.filter(|variable| variable.is_switch() == is_switch).ok_or(Refused::NoVariable(kind, reference))
    }

    /// Sets a variable.
    ///
    /// # Errors
    /// If there is none, it cannot be set now, or the value is no number.
    pub fn set(&mut self, reference: u32, is_switch: bool, value: f64) -> Result<(), Refused> {
        let variable = self.variable(reference, is_switch)?;
        let refused = |why| Err(Refused::NotSettable(variable.name.clone(), why));
        match variable.causality {
            Causality::Input | Causality::Tunable => {}
            Causality::Fixed if !self.is_running => {}
            Causality::Fixed => return refused(" after the initialization"),
            Causality::Independent | Causality::Output => return refused(": it is calculated"),
        }
        if !value.is_finite() {
            return Err(Refused::NotFinite(variable.name.clone(), value));
        }
        if self.is_running {
            self.is_retuned |= variable.causality == Causality::Tunable;
        } else {
            self.simulation = None;
        }
        if let Some(of) = self.values.get_mut(reference as usize) {
            *of = value;
        }
        Ok(())
    }

    /// Sets the rate of an input until the end of the next step, per second.
    ///
    /// # Errors
    /// If it is no input, or the rate is no number.
    pub fn set_rate(&mut self, reference: u32, rate: f64) -> Result<(), Refused> {
        let variable = self.variable(reference, false)?;
        let Place::Input(input) = variable.place else {
            return Err(Refused::NotSettable(variable.name.clone(), " by a derivative: it is no input"));
        };
        if !rate.is_finite() {
            return Err(Refused::NotFinite(format!("the derivative of {}", variable.name), rate));
        }
        self.rates[input as usize] = rate;
        Ok(())
    }

    /// The value of a variable.
    ///
    /// # Errors
    /// If there is none, or parameters cannot be.
    pub fn get(&mut self, reference: u32, is_switch: bool) -> Result<f64, Refused> {
        let place = self.variable(reference, is_switch)?.place;
        match place {
            Place::Time => Ok(self.seconds()),
            Place::Truth(column) => {
                self.ready()?;
                Ok(self.truth.get(column).copied().unwrap_or(f64::NAN))
            }
            Place::Measured(quantity) => {
                self.ready()?;
                Ok(self.measured[quantity as usize])
            }
            Place::Error(quantity) => {
                self.ready()?;
                Ok(self.measured[quantity as usize] - self.perfect[quantity as usize])
            }
            Place::Added(place) => {
                self.ready()?;
                Ok(self.added.get(place).copied().unwrap_or(f64::NAN))
            }
            _ => Ok(self.values.get(reference as usize).copied().unwrap_or(f64::NAN)),
        }
    }

    /// The time, s.
    pub fn seconds(&self) -> f64 {
        self.start_s + self.simulation.as_ref().map_or(0.0, |simulation| simulation.seconds())
    }

    fn value(&self, place: Place) -> f64 {
        let found = self.variables.iter().position(|variable| variable.place == place);
        found.and_then(|reference| self.values.get(reference).copied()).unwrap_or(0.0)
    }

    fn setting(&self) -> Setting {
        let value = |of| self.value(Place::Setting(of));
        let inputs = self.inputs();
        Setting {
            initial_speed_mps: match self.car.part {
                Part::Car => value(Fixed::InitialSpeed),
                Part::Correction => inputs[Input::VelocityForward as usize],
            },
            initial_steering_rad: inputs[Input::SteeringWheelAngle as usize],
            step_us: (value(Fixed::Step) * 1e6).round() as u32,
            holds_speed: value(Fixed::HoldsSpeed) != 0.0,
        }
    }

    fn inputs(&self) -> Inputs {
        Input::ALL.map(|input| self.value(Place::Input(input)))
    }

    /// The car with the numbers that it has now.
    fn tuned(&self) -> Result<Car, CarError> {
        let changed = self
            .variables
            .iter()
            .zip(&self.values)
            .filter(|(variable, value)| **value != variable.start)
            .map(|(variable, value)| (variable.place, *value));
        let (mut vehicle, mut effects) = (vec![], vec![]);
        for (place, value) in changed {
            match place {
                Place::Vehicle(name) => vehicle.push((name, value)),
                Place::Effect(effect, number) => effects.push((effect, number, value)),
                _ => {}
            }
        }
        self.car.with_numbers(&vehicle, &effects)
    }

    /// The drive has begun.
    fn ready(&mut self) -> Result<(), Refused> {
        if self.simulation.is_none() {
            let scenario = self.tuned()?.scenario(&self.setting())?;
            let mut simulation = Simulation::new(&scenario, 0).map_err(CarError::from)?;
            self.last = self.inputs();
            simulation.give(&given(&self.last, &NO_RATES));
            self.simulation = Some(Box::new(simulation));
            let last = self.last;
            self.go_on(0, &last, &NO_RATES)?;
        }
        Ok(())
    }

    /// Goes from `from` on by `seconds`.
    ///
    /// # Errors
    /// A step that does not fit, parameters that cannot be, or a motion that is no number any more.
    pub fn step(&mut self, from: f64, seconds: f64) -> Result<(), Refused> {
        self.ready()?;
        let now = self.seconds();
        if (from - now).is_nan() || (from - now).abs() > ROUNDING_S {
            return Err(Refused::Time(from, now));
        }
        let setting = self.setting();
        let step_s = f64::from(setting.step_us) * 1e-6;
        let steps = (seconds / step_s).round();
        if !(steps >= 1.0 && (steps * step_s - seconds).abs() < ROUNDING_S) {
            return Err(Refused::Step(seconds, step_s));
        }
        if now - self.start_s + seconds > LONGEST_S + 0.5 * step_s {
            return Err(Refused::TooLong);
        }
        let retuned = if self.is_retuned { Some(self.tuned()?.scenario(&setting)?) } else { None };
        let inputs = self.inputs();
        let (from, rates) = if self.value(Place::Setting(Fixed::InputsAreOfTheEnd)) != 0.0 {
            (self.last, std::array::from_fn(|i| (inputs[i] - self.last[i]) / (steps * step_s)))
        } else {
            (inputs, self.rates)
        };
        if let Some(simulation) = &mut self.simulation {
            if let Some(scenario) = retuned {
                simulation.retune(&scenario).map_err(CarError::from)?;
            }
            simulation.give(&given(&from, &rates));
        }
        self.is_retuned = false;
        self.rates = NO_RATES;
        self.last = inputs;
        self.go_on(steps as u32, &from, &rates)
    }

    /// So many steps, with the inputs going on as they are said.
    fn go_on(&mut self, steps: u32, from: &Inputs, rates: &Inputs) -> Result<(), Refused> {
        let has_wheels = self.value(Place::Setting(Fixed::HasWheels)) != 0.0;
        let Some(simulation) = &mut self.simulation else { return Ok(()) };
        let is_led = self.car.part == Part::Correction;
        let tick = if is_led {
            let radius = simulation.plant().radius;
            let freely_on = (!has_wheels).then_some(radius);
            let motion = |of: &Inputs| motion(of, freely_on);
            simulation.led_along(&motion(from), &motion(rates), steps)
        } else {
            simulation.go_on(steps)
        };
        let is_finite = tick.truth.is_finite();
        self.truth = tick.truth.values();
        for reading in tick.readings {
            self.measured[reading.quantity as usize] = reading.value;
        }
        let Micros(now) = tick.truth.time;
        if is_led {
            let added = simulation.added();
            let [fl, fr, rl, rr] = added.wheel_torque;
            self.added = [added.fx, added.fy, added.moment, fl, fr, rl, rr];
            self.perfect = simulation.perfect_readings();
        }
        if is_finite { Ok(()) } else { Err(Refused::Diverged(self.start_s + now as f64 * 1e-6)) }
    }
}

/// A number for each input.
type Inputs = [f64; Input::COUNT];

const NO_RATES: Inputs = [0.0; Input::COUNT];

/// The motion that is said, or its rate; wheels of these radii roll freely, if they are given.
fn motion(of: &Inputs, freely_on: Option<[f64; 4]>) -> State {
    let forward = of[Input::VelocityForward as usize];
    let wheels = [Input::WheelFl, Input::WheelFr, Input::WheelRl, Input::WheelRr];
    State {
        velocity: Velocity {
            vx: forward,
            vy: of[Input::VelocityLeft as usize],
            yaw_rate: of[Input::YawRate as usize],
        },
        wheel_speed: freely_on.map_or_else(
            || wheels.map(|input| of[input as usize]),
            |radius| radius.map(|radius| forward / radius),
        ),
    }
}

fn given(values: &Inputs, rates: &Inputs) -> Given {
    let line = |input: Input| Line { value: values[input as usize], rate: rates[input as usize] };
    Given {
        steering_wheel_angle: line(Input::SteeringWheelAngle),
        drive_torque: line(Input::DriveTorque),
        brake_torque: line(Input::BrakeTorque),
        brake_pressure: line(Input::BrakePressure),
        speed: line(Input::Speed),
    }
}

#[cfg(test)]
mod tests;
