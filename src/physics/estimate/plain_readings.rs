//! What the sensors would say of the plain car.
//!
//! The estimators' equations are those of a plain car. A car has `[[effect]]` tables beside: its steering yields, its rear
//! wheels are steered, its accelerometer leans with the body. At each sample the same effects that act in a simulation
//! act here, around the motion as it is measured, and what they change is taken out of the readings before anybody uses
//! them: sensors' errors, the steering wheel's way to the road wheels, radii, and the slip angles that tires answer to late.
//! What an effect changes of tires, loads, mass or road is not taken out: those are what the estimators find out.

use std::sync::Arc;

use super::kinematics::{Car, Heard, Kinematics, Turning};
use crate::model::body::{Steer, Velocity};
use crate::model::effect::{Acting, Before, EffectConfig, EffectList, Felt, Now, Readings, Recorded};
use crate::model::force::WheelMotion;
use crate::model::{Plant, Vehicle};
use crate::{Micros, Quantity, Sample, Wheel};

/// Physical, as far as it is not said otherwise.
struct Tuning {
    /// A car that rolls more slowly stands: the effects begin anew when it drives, m/s.
    stands: f64,
    /// Without a sample for this long they begin anew, too, s.
    gap_s: f64,
    /// Their states are integrated in steps of this at most, s, …
    step_s: f64,
    /// … which times the fastest rate is this at most, …
    rate_times_step: f64,
    /// … and no more of them than this.
    most_steps: u32,
    /// The yaw rate is differentiated over this time, s. Tuned with the test `effects::taken_out`.
    yaw_acceleration_s: f64,
}

const TUNING: Tuning = Tuning {
    stands: 0.5,
    gap_s: 0.5,
    step_s: 0.01,
    rate_times_step: 0.5,
    most_steps: 100,
    yaw_acceleration_s: 0.05,
};

/// The inputs that effects undo as a whole ([`EffectList::undo`]); all others are put right by what is sensed of them.
const INPUTS: [Quantity; 3] = [Quantity::SteeringWheelAngle, Quantity::DriveTorque, Quantity::BrakePressure];

/// A sample of the plain car that moves in the same way.
#[derive(Clone, Copy, Debug)]
pub struct Plain {
    /// Its readings; the steering wheel stands so that the front tires have the slip angles that they answer to.
    pub sample: Sample,
    /// How far its rear wheels are turned to the left, rad.
    pub rear_angle: f64,
    /// How far the slip angles that the tires answer to are ahead of those of the motion, front and rear, rad.
    pub answered: [f64; 2],
}

impl Plain {
    /// Of a car without effects.
    pub fn of(sample: &Sample) -> Self {
        Self { sample: *sample, rear_angle: 0.0, answered: [0.0; 2] }
    }
}

/// Takes effects out of readings. Never allocates after construction.
#[derive(Clone, Debug)]
pub struct PlainReadings {
    effects: Arc<EffectList>,
    plant: Plant,
    car: Car,
    states: States,
    /// When the first sample was.
    start: Option<Micros>,
    /// The effects' states are those of the car as it moves.
    has_begun: bool,
    yaw_rate: f64,
    yaw_acceleration: f64,
    /// What was taken out of the last lateral acceleration, m/s².
    leaning: f64,
}

impl PlainReadings {
    /// For a car with these effects; `None`, if none of them is taken out.
    pub fn new(vehicle: &Vehicle, effects: &[EffectConfig]) -> Option<Self> {
        let taken: Vec<_> = effects.iter().filter(|effect| Self::takes(vehicle, effect)).cloned().collect();
        if taken.is_empty() {
            return None;
        }
        let effects = EffectList::new(EffectConfig::effects(&taken));
        Some(Self {
            plant: Plant::new(vehicle),
            car: Car::new(vehicle),
            states: States::of(&effects),
            effects: Arc::new(effects),
            start: None,
            has_begun: false,
            yaw_rate: 0.0,
            yaw_acceleration: 0.0,
            leaning: 0.0,
        })
    }

    /// Is all that this effect changes taken out? It is tried in a curve.
    pub fn takes(vehicle: &Vehicle, effect: &EffectConfig) -> bool {
        if effect.kind().course.is_some() {
            // Wind and slopes are the road's; what a sensor's course was is known.
            return effect.kind().is_of_measurement();
        }
        let (plant, ratio) = (Plant::new(vehicle), vehicle.steering_ratio.value);
        let velocity = Velocity { vx: 15.0, vy: -0.5, yaw_rate: 0.4 };
        let now = Now {
            ax: -2.0,
            ay: 6.0,
            front_force: 5000.0,
            is_force_measured: true,
            steering_wheel: 0.5,
            ..Now::new(&plant, ratio, f64::MAX, velocity, &Before::default())
        };
        let made = EffectList::new([effect.effect()]);
        let mut states = States::of(&made);
        made.begin(&now, &mut states.values);
        let plain = Acting::plain(&plant, now.steering_wheel, ratio);
        let on = states.act(&made, &plant, &now);
        let Acting { steering_wheel, steering_ratio, toe, radius, .. } = on;
        on == Acting { steering_wheel, steering_ratio, toe, radius, ..plain }
    }

    /// Takes a sample, and the lateral velocity as it was known last, m/s.
    pub fn step(&mut self, sample: &Sample, heard: Heard, lateral_velocity: Option<f64>) -> Plain {
        let t = (sample.time - *self.start.get_or_insert(sample.time)).seconds();
        let mut plain = Plain::of(sample);
        self.undo_inputs(t, &mut plain.sample);
        let said = Kinematics::of(&plain.sample, &self.car, heard);
        let turning = said.turning(TUNING.stands).filter(|_| sample.elapsed_s <= TUNING.gap_s);
        let Some(Turning { speed, yaw_rate, road_angle, lateral_acceleration }) = turning else {
            self.has_begun = false;
            return plain;
        };
        self.differentiate(yaw_rate, sample.elapsed_s);
        let plant = self.plant;
        let ay = lateral_acceleration.map_or(speed * yaw_rate, |said| said - self.leaning);
        let vy = lateral_velocity.unwrap_or_else(|| self.car.steady_lateral_velocity(speed, yaw_rate, ay));
        let velocity = Velocity { vx: speed, vy, yaw_rate };
        let [front, rear] = self.axle_forces(ay);
        let now = Now {
            ax: said.longitudinal_acceleration.unwrap_or(0.0),
            ay,
            front_force: front,
            is_force_measured: true,
            steering_wheel: road_angle * self.car.steering_ratio,
            ..Now::new(&plant, self.car.steering_ratio, t, velocity, &Before::default())
        };
        let Self { effects, states, .. } = self;
        let mut felt = Felt {
            ax: now.ax,
            ay,
            yaw_acceleration: self.yaw_acceleration,
            fy: [front, front, rear, rear].map(|force| 0.5 * force),
            ..Felt::default()
        };
        if std::mem::replace(&mut self.has_begun, true) {
            felt.slip_angle = slip_angles(&now, &states.act(effects, &plant, &now));
            states.advance(effects, &now, &felt, sample.elapsed_s);
        } else {
            effects.begin(&now, &mut states.values);
        }
        let on = states.act(effects, &plant, &now);
        felt.slip_angle = slip_angles(&now, &on);
        self.take_out_sensed(&now, &felt, &mut plain.sample);
        self.turn_axles(&now, &on, &felt, &mut plain);
        for wheel in Wheel::ALL {
            let (quantity, i) = (Quantity::wheel_speed(wheel), wheel as usize);
            if let Some(turning) = plain.sample.get(quantity) {
                plain.sample.set(quantity, turning * on.radius[i] / plant.radius[i]);
            }
        }
        plain
    }

    /// All that turns a tire against the road, and how much later it answers, is an angle of its axle.
    fn turn_axles(&self, now: &Now<'_>, on: &Acting, felt: &Felt, plain: &mut Plain) {
        let mut answered = felt.slip_angle;
        self.effects.slip_angles(now, &self.states.values, &mut answered);
        let mean = |of: &[f64; 4], left: usize| 0.5 * (of[left] + of[left + 1]);
        plain.answered = [0, 2].map(|left| mean(&answered, left) - mean(&felt.slip_angle, left));
        let turned = [0, 2].map(|left| mean(&on.toe, left) - mean(&self.plant.nominal.toe, left));
        plain.rear_angle = turned[1] + plain.answered[1];
        let road_angle = on.steer() + turned[0] + plain.answered[0];
        plain.sample.set(Quantity::SteeringWheelAngle, self.car.steering_ratio * road_angle);
    }

    /// Errors of the inputs' sensors.
    fn undo_inputs(&self, t: f64, sample: &mut Sample) {
        let [steering_wheel, drive_torque, brake_pressure] =
            INPUTS.map(|input| sample.get(input).unwrap_or(0.0));
        let mut recorded = Recorded { steering_wheel, drive_torque, brake_pressure };
        self.effects.undo(t, &mut recorded);
        for input in INPUTS {
            if let (Some(_), Some(value)) = (sample.get(input), recorded.get_mut(input)) {
                sample.set(input, *value);
            }
        }
    }

    /// Errors of all other sensors: what the effects would add to such readings.
    fn take_out_sensed(&mut self, now: &Now<'_>, felt: &Felt, sample: &mut Sample) {
        let said: Readings = Quantity::ALL.map(|quantity| sample.get(quantity).unwrap_or(0.0));
        let mut sensed = said;
        self.effects.sense(now, felt, &self.states.values, &mut sensed);
        let added = |quantity: Quantity| sensed[quantity as usize] - said[quantity as usize];
        for quantity in Quantity::ALL.into_iter().filter(|quantity| !INPUTS.contains(quantity)) {
            if let Some(said) = sample.get(quantity).filter(|_| added(quantity) != 0.0) {
                sample.set(quantity, said - added(quantity));
            }
        }
        self.leaning = added(Quantity::LateralAcceleration);
    }

    /// Lateral force of the front and the rear axle, N, by what the body's sensors feel.
    fn axle_forces(&self, ay: f64) -> [f64; 2] {
        let Car { mass, a, b, yaw_inertia, .. } = self.car;
        let turned = yaw_inertia * self.yaw_acceleration;
        [mass * ay * b + turned, mass * ay * a - turned].map(|moment| moment / (a + b))
    }

    fn differentiate(&mut self, yaw_rate: f64, elapsed_s: f64) {
        let before = std::mem::replace(&mut self.yaw_rate, yaw_rate);
        if !self.has_begun {
            self.yaw_acceleration = 0.0;
        } else if elapsed_s > 0.0 {
            let share = elapsed_s / (elapsed_s + TUNING.yaw_acceleration_s);
            self.yaw_acceleration += share * ((yaw_rate - before) / elapsed_s - self.yaw_acceleration);
        }
    }
}

/// Of all effects together.
#[derive(Clone, Debug)]
struct States {
    values: Vec<f64>,
    rates: Vec<f64>,
}

impl States {
    fn of(effects: &EffectList) -> Self {
        let count = effects.places().last().map_or(0, |place| place.end);
        Self { values: vec![0.0; count], rates: vec![0.0; count] }
    }

    fn act(&self, effects: &EffectList, plant: &Plant, now: &Now<'_>) -> Acting {
        let mut on = Acting::plain(plant, now.steering_wheel, now.steering_ratio);
        effects.act(now, &self.values, &mut on);
        on
    }

    /// Over a sample's time, the car moving as it does.
    fn advance(&mut self, effects: &EffectList, now: &Now<'_>, felt: &Felt, elapsed_s: f64) {
        let longest = TUNING.step_s.min(TUNING.rate_times_step / effects.fastest_rate(now.velocity.vx));
        let steps = ((elapsed_s / longest).ceil() as u32).clamp(1, TUNING.most_steps);
        let h = elapsed_s / f64::from(steps);
        for _ in 0..steps {
            effects.rates(now, felt, &self.values, &mut self.rates);
            self.values.iter_mut().zip(&self.rates).for_each(|(state, rate)| *state += h * rate);
        }
    }
}

/// As the motion gives them, rad.
fn slip_angles(now: &Now<'_>, on: &Acting) -> [f64; 4] {
    WheelMotion::new(&on.body, now.velocity, Steer::new(on.steer()), on.turned()).slip_angle
}
