//! The car's equations with any effects: three states and the effects' own, wheels without delay.
//!
//! A wheel's rotation is fifty times faster than anything else in the plane, and its speed is measured;
//! so it is no state. What turns it is missing at the body: its inertia adds to the car's (methods.md
//! §2 with r ω̇ the acceleration of its contact point).

use crate::identify::{Parameter, Values};
use crate::model::body::{Body, Steer, Velocity};
use crate::model::effect::{Acting, Effect, Felt, MOST_STATES, Now, Readings, Recorded};
use crate::model::tire::{Brush, Contact, Curve, Linear, MagicFormula, PiecewiseLinear, Tire};
use crate::model::{GRAVITY, TireKind, Vehicle, wheel};
use crate::{Quantity, Wheel};

/// States of the body: vx, vy, yaw rate.
pub const BODY_STATES: usize = 3;

/// States of all effects together.
pub const EFFECT_STATES: usize = 3 * MOST_STATES;

/// Most courses that a filter estimates while it runs.
pub const MOST_LIVE: usize = 4;

/// The inertial sensors.
pub const INERTIAL: [Quantity; 3] =
    [Quantity::YawRate, Quantity::LateralAcceleration, Quantity::LongitudinalAcceleration];

/// What a car is made of.
#[derive(Debug)]
pub struct Settings<'a> {
    /// What does not change: tire model, driven axle.
    pub vehicle: &'a Vehicle,
    /// The numbers.
    pub values: &'a Values,
    /// Is the drive torque on the bus?
    pub knows_torque: bool,
    /// How late the wheel speeds are, front and rear, s: tooth wheels are read over some time.
    pub wheel_delay: [f64; 2],
    /// How much of the lateral curve's bend the longitudinal one has: 0 straight, 1 the same.
    pub bend_along: f64,
    /// How late drive and brake torque act, s.
    pub torque_delay: f64,
    /// How late yaw rate, lateral and longitudinal acceleration are, s.
    pub inertial_delay: [f64; 3],
    /// Physics beyond the plain model.
    pub effects: Vec<Box<dyn Effect>>,
}

/// A car.
#[derive(Debug)]
pub struct Car {
    body: Body,
    tire: Tire,
    contact: [Contact; 4],
    load: [f64; 4],
    radius: [f64; 4],
    wheel_inertia: f64,
    steering_ratio: f64,
    /// N m per unit of drive torque, and per bar.
    torque_share: [f64; 4],
    brake_share: [f64; 4],
    driven: [bool; 4],
    knows_torque: bool,
    bend_along: f64,
    torque_delay: f64,
    steering_offset: f64,
    offset: Readings,
    delay: Readings,
    steering_delay: f64,
    effects: Vec<(Box<dyn Effect>, std::ops::Range<usize>)>,
}

/// Where the car is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// vx, vy, yaw rate.
    pub body: [f64; BODY_STATES],
    /// The effects' own.
    pub own: [f64; EFFECT_STATES],
    /// Courses that are estimated.
    pub live: [f64; MOST_LIVE],
}

/// Everything at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Derivatives of the state.
    pub rate: State,
    /// What the sensors say.
    pub readings: Readings,
    /// Accelerations and forces.
    pub felt: Felt,
    /// Lateral force of the front axle, N.
    pub front_force: f64,
}

/// What an instant shall say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// How the state changes.
    Rates,
    /// What the sensors say, too: slips from forces are the costly part.
    Readings,
}

/// What was a moment ago, for effects that need the outcome to say what it is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before {
    ax: f64,
    ay: f64,
    front_force: f64,
}

impl Instant {
    /// What the next instant may look back at.
    pub fn before(&self) -> Before {
        let (ax, ay) = (self.felt.ax, self.felt.ay);
        Before { ax, ay, front_force: self.front_force }
    }
}

impl Car {
    /// From its numbers and effects.
    pub fn new(settings: Settings<'_>) -> Self {
        let Settings {
            vehicle,
            values,
            knows_torque,
            wheel_delay,
            bend_along,
            torque_delay,
            inertial_delay,
            effects,
        } = settings;
        let get = |parameter| values.get(parameter);
        let (mass, a) = (get(Parameter::Mass), get(Parameter::CgToFront));
        let wheelbase = get(Parameter::Wheelbase);
        let b = wheelbase - a;
        let load = Wheel::ALL.map(|w| 0.5 * mass * GRAVITY * if w.is_front() { b } else { a } / wheelbase);
        let radius = get(Parameter::WheelRadius);
        let along = get(Parameter::Longitudinal) * mass * GRAVITY / 4.0;
        let friction =
            if vehicle.tire == TireKind::Linear { f64::INFINITY } else { get(Parameter::Friction) };
        let contact = Wheel::ALL.map(|w| Contact {
            stiffness_x: along / load[w as usize],
            stiffness_y: get(if w.is_front() { Parameter::LateralFront } else { Parameter::LateralRear }),
            friction_x: friction,
            friction_y: friction,
        });
        let driven = Wheel::ALL.map(|w| vehicle.driven_axle.drives(w));
        let count = driven.iter().filter(|driven| **driven).count() as f64;
        let share = get(Parameter::DriveTorqueRatio) / count;
        let or_zero = |value: f64| if value.is_nan() { 0.0 } else { value };
        let mut offset = [0.0; Quantity::COUNT];
        offset[Quantity::YawRate as usize] = get(Parameter::YawRateOffset);
        offset[Quantity::LateralAcceleration as usize] = get(Parameter::LateralAccelerationOffset);
        offset[Quantity::LongitudinalAcceleration as usize] = get(Parameter::LongitudinalAccelerationOffset);
        let mut delay = [0.0; Quantity::COUNT];
        for w in Wheel::ALL {
            delay[Quantity::wheel_speed(w) as usize] = wheel_delay[usize::from(!w.is_front())];
        }
        for (quantity, by) in INERTIAL.into_iter().zip(inertial_delay) {
            delay[quantity as usize] = by;
        }
        let mut steering_delay = 0.0;
        for (quantity, by) in effects.iter().filter_map(|effect| effect.delay()) {
            match quantity {
                Quantity::SteeringWheelAngle => steering_delay += by,
                _ => delay[quantity as usize] += by,
            }
        }
        let mut first = 0;
        let effects = effects.into_iter().map(|effect| {
            let own = first..first + effect.states();
            first = own.end;
            (effect, own)
        });
        Self {
            body: Body {
                mass,
                yaw_inertia: get(Parameter::YawInertia),
                a,
                b,
                half_track_front: 0.5 * get(Parameter::TrackFront),
                half_track_rear: 0.5 * get(Parameter::TrackRear),
                drag: get(Parameter::Drag),
                rolling_resistance: get(Parameter::RollingResistance),
            },
            tire: match vehicle.tire {
                TireKind::Linear => Tire::Linear(Linear),
                TireKind::Piecewise => Tire::PiecewiseLinear(PiecewiseLinear),
                TireKind::Brush => Tire::Brush(Brush),
                TireKind::MagicFormula => Tire::MagicFormula(MagicFormula {
                    shape: get(Parameter::MagicShape),
                    curvature: get(Parameter::MagicCurvature),
                }),
            },
            contact,
            load,
            radius: [
                Parameter::SlipOffsetFl,
                Parameter::SlipOffsetFr,
                Parameter::SlipOffsetRl,
                Parameter::SlipOffsetRr,
            ]
            .map(|offset| radius / (1.0 + get(offset))),
            wheel_inertia: get(Parameter::WheelInertia),
            steering_ratio: get(Parameter::SteeringRatio),
            torque_share: driven.map(|driven| if driven { share } else { 0.0 }),
            brake_share: Wheel::ALL.map(|w| {
                or_zero(get(if w.is_front() {
                    Parameter::BrakePerBarFront
                } else {
                    Parameter::BrakePerBarRear
                }))
            }),
            driven,
            knows_torque,
            bend_along,
            torque_delay,
            steering_offset: get(Parameter::SteeringOffset),
            offset,
            delay,
            steering_delay,
            effects: effects.collect(),
        }
    }

    /// How late a sensor is, s.
    pub fn delay(&self, channel: usize) -> f64 {
        self.delay[channel]
    }

    /// Is the drive torque known?
    pub fn knows_torque(&self) -> bool {
        self.knows_torque
    }

    /// How late the recorded steering wheel angle is, s.
    pub fn steering_delay(&self) -> f64 {
        self.steering_delay
    }

    /// What was, from what was recorded.
    pub fn undo(&self, t: f64, mut recorded: Recorded) -> Recorded {
        recorded.steering_wheel -= self.steering_offset;
        // The last thing that happened to a reading is undone first.
        for (effect, _) in self.effects.iter().rev() {
            effect.undo(t, &mut recorded);
        }
        recorded
    }

    /// Rolling free at a speed, m/s.
    pub fn rolling(&self, t: f64, speed: f64, yaw_rate: f64, input: &Recorded) -> State {
        let mut state = State { body: [speed, 0.0, yaw_rate], ..State::default() };
        let now = self.now(t, &state, input, &Before::default());
        let mut own = [0.0; EFFECT_STATES];
        for (effect, place) in &self.effects {
            effect.begin(&now, &mut own[place.clone()]);
        }
        state.own = own;
        state
    }

    /// The same with the effects' own states where they would settle: what the filter takes for their
    /// answer to a small change, for it does not correct them.
    pub fn settled(&self, t: f64, state: &State, input: &Recorded, before: &Before) -> State {
        let mut settled = *state;
        let now = self.now(t, state, input, before);
        for (effect, place) in &self.effects {
            effect.begin(&now, &mut settled.own[place.clone()]);
        }
        settled
    }

    fn now<'a>(&'a self, t: f64, state: &'a State, input: &Recorded, before: &Before) -> Now<'a> {
        let [vx, vy, yaw_rate] = state.body;
        Now {
            t,
            velocity: Velocity { vx, vy, yaw_rate },
            ax: before.ax,
            ay: before.ay,
            front_force: before.front_force,
            steering_wheel: input.steering_wheel,
            steering_ratio: self.steering_ratio,
            body: &self.body,
            static_load: &self.load,
            live: &state.live,
        }
    }

    /// An upper bound of the fastest rate in the plane at a speed, 1/s.
    pub fn fastest_rate(&self, vx: f64) -> f64 {
        let lateral = |axle: usize| 2.0 * self.contact[2 * axle].stiffness_y * self.load[2 * axle];
        let (front, rear) = (lateral(0), lateral(1));
        let body = &self.body;
        let yaw = (body.a * body.a * front + body.b * body.b * rear) / body.yaw_inertia;
        ((front + rear) / body.mass + yaw) / vx.max(1.0)
    }

    /// Forces, accelerations and readings. `rates` are those of the inputs, per second; the
    /// input is what truly was ([`Self::undo`]). Where no torque is known, the first course that is
    /// estimated is the acceleration it gives.
    pub fn instant(
        &self,
        t: f64,
        state: &State,
        input: &Recorded,
        rates: &Recorded,
        before: &Before,
        ask: Ask,
    ) -> Instant {
        let now = self.now(t, state, input, before);
        let mut on = Acting {
            body: self.body,
            steering_wheel: input.steering_wheel,
            steering_ratio: self.steering_ratio,
            toe: [0.0; 4],
            load: self.load,
            contact: self.contact,
            tire: self.tire,
            ellipse_factor: 0.0,
            radius: self.radius,
            brake: [0.0; 4],
            external: crate::model::body::External::none(),
            gravity: [0.0; 2],
        };
        for (effect, own) in &self.effects {
            effect.act(&now, &state.own[own.clone()], &mut on);
        }
        let velocity = now.velocity;
        let body = &on.body;
        let steer = Steer::new(on.steering_wheel / on.steering_ratio);
        let along = body.contact_speeds(&velocity, steer);
        let [front_along, front_across] = body.front_axle_velocity(&velocity, steer);
        let [rear_along, rear_across] = body.rear_axle_velocity(&velocity);
        let front = wheel::slip_angle(front_along, front_across);
        let rear = wheel::slip_angle(rear_along, rear_across);
        let kinematic = [front + on.toe[0], front + on.toe[1], rear + on.toe[2], rear + on.toe[3]];
        let mut angle = kinematic;
        for (effect, own) in &self.effects {
            effect.slip_angles(&now, &state.own[own.clone()], &mut angle);
        }

        // Forces as if the wheels had no inertia.
        let torque = self.torques(input, rates, state, &on);
        let mut x = [0.0; 4];
        let (mut fx, mut fy) = ([0.0; 4], [0.0; 4]);
        for i in 0..4 {
            let most = on.contact[i].friction_x * 0.99;
            x[i] = ((torque[i] / on.radius[i] - on.brake[i]) / on.load[i]).clamp(-most, most);
            fx[i] = x[i] * on.load[i];
            fy[i] = across(&on, i, x[i], angle[i]) * on.load[i];
        }
        let mut external = on.external;
        external.fx += body.mass * on.gravity[0];
        external.fy += body.mass * on.gravity[1];
        let bare = body.accelerate(&velocity, steer, &fx, &fy, &external);

        // The wheels' inertia.
        let mass_of = |i: usize| self.wheel_inertia / (on.radius[i] * on.radius[i]);
        let at_front = mass_of(0) + mass_of(1);
        let all = at_front + mass_of(2) + mass_of(3);
        let squares =
            body.half_track_front.powi(2) * at_front + body.half_track_rear.powi(2) * (all - at_front);
        let turning = (bare.vy_rate + body.a * bare.yaw) * steer.sin
            + front_across * rates.steering_wheel / on.steering_ratio;
        let yaw_rate = velocity.yaw_rate;
        let total =
            (bare.ax * body.mass - all * (velocity.vy * yaw_rate) - at_front * turning) / (body.mass + all);
        let vx_rate = total + velocity.vy * yaw_rate;
        let yaw = bare.yaw * body.yaw_inertia / (body.yaw_inertia + squares);
        let mut readings = [f64::NAN; Quantity::COUNT];
        for i in 0..4 {
            let half = if i < 2 { body.half_track_front } else { body.half_track_rear };
            let side = if i % 2 == 0 { -half } else { half };
            let faster = vx_rate + side * yaw + if i < 2 { turning } else { 0.0 };
            fx[i] -= mass_of(i) * faster;
            if ask == Ask::Rates {
                continue;
            }
            let slip = slip_of(&on, i, fx[i] / on.load[i], angle[i], self.bend_along);
            readings[i] = along[i] * (1.0 + slip) / on.radius[i];
        }
        // An accelerometer does not feel gravity in the road's plane.
        let felt = Felt {
            ax: total - on.gravity[0],
            ay: bare.ay - on.gravity[1],
            yaw_acceleration: yaw,
            slip_angle: kinematic,
            fx,
            fy,
        };
        let mut rate = State { body: [vx_rate, bare.vy_rate, yaw], ..State::default() };
        readings[Quantity::YawRate as usize] = yaw_rate;
        readings[Quantity::LateralAcceleration as usize] = felt.ay;
        readings[Quantity::LongitudinalAcceleration as usize] = felt.ax;
        readings[Quantity::SteeringWheelAngle as usize] = input.steering_wheel;
        for (effect, own) in &self.effects {
            let states = &state.own[own.clone()];
            effect.rates(&now, &felt, states, &mut rate.own[own.clone()]);
            if ask == Ask::Readings {
                effect.sense(&now, &felt, states, &mut readings);
            }
        }
        for (reading, offset) in readings.iter_mut().zip(self.offset) {
            *reading += offset;
        }
        let front_force = fy[0] + fy[1];
        Instant { rate, readings, felt, front_force }
    }

    /// Torque at each wheel, N m. Slip takes some milliseconds to build up (J v/(r² C_x)), as does the way
    /// from the torque's frame to the wheel: both are in `torque_delay`.
    fn torques(&self, input: &Recorded, rates: &Recorded, state: &State, on: &Acting) -> [f64; 4] {
        if self.knows_torque {
            let torque = input.drive_torque - self.torque_delay * rates.drive_torque;
            let pressure = input.brake_pressure - self.torque_delay * rates.brake_pressure;
            return std::array::from_fn(|i| self.torque_share[i] * torque - self.brake_share[i] * pressure);
        }
        // Driving comes from the driven wheels, braking from all by their load.
        let force = on.body.mass * state.live[0];
        let driven = self.driven.iter().filter(|driven| **driven).count() as f64;
        let all: f64 = self.load.iter().sum();
        std::array::from_fn(|i| {
            let share = match (force > 0.0, self.driven[i]) {
                (true, true) => 1.0 / driven,
                (true, false) => 0.0,
                (false, _) => self.load[i] / all,
            };
            share * force * on.radius[i]
        })
    }

    /// One Runge–Kutta step of `h` seconds from an instant already known. `input` gives what truly was.
    pub fn step(&self, from: &State, first: &Instant, t: f64, h: f64, ends: &Ends) -> State {
        let before = first.before();
        let stage = |share: f64, rate: &State| {
            let state = from.advanced(rate, share * h);
            let input = ends.at(share);
            self.instant(t + share * h, &state, &input, &ends.rates, &before, Ask::Rates).rate
        };
        let k2 = stage(0.5, &first.rate);
        let k3 = stage(0.5, &k2);
        let k4 = stage(1.0, &k3);
        from.advanced(&first.rate, h / 6.0)
            .advanced(&k2, h / 3.0)
            .advanced(&k3, h / 3.0)
            .advanced(&k4, h / 6.0)
    }
}

/// The inputs at both ends of a step.
#[derive(Clone, Copy, Debug)]
pub struct Ends {
    /// At its beginning and its end.
    pub input: [Recorded; 2],
    /// Their rates, per second.
    pub rates: Recorded,
}

impl Ends {
    /// Inputs that go evenly from one to the other in `h` seconds.
    pub fn new(input: [Recorded; 2], h: f64) -> Self {
        let [from, to] = &input;
        let rates = Recorded {
            steering_wheel: (to.steering_wheel - from.steering_wheel) / h,
            drive_torque: (to.drive_torque - from.drive_torque) / h,
            brake_pressure: (to.brake_pressure - from.brake_pressure) / h,
        };
        Self { input, rates }
    }

    /// At a share of the way.
    pub fn at(&self, share: f64) -> Recorded {
        let [from, to] = &self.input;
        let mix = |a: f64, b: f64| a + share * (b - a);
        Recorded {
            steering_wheel: mix(from.steering_wheel, to.steering_wheel),
            drive_torque: mix(from.drive_torque, to.drive_torque),
            brake_pressure: mix(from.brake_pressure, to.brake_pressure),
        }
    }
}

impl State {
    fn advanced(&self, rate: &State, h: f64) -> Self {
        let mut next = *self;
        for (value, rate) in next.body.iter_mut().zip(rate.body) {
            *value += h * rate;
        }
        for (value, rate) in next.own.iter_mut().zip(rate.own) {
            *value += h * rate;
        }
        // The equations guard against standing still, not against going through it.
        next.body[0] = next.body[0].max(0.1);
        next
    }
}

/// Lateral force / load of a tire that transmits `x` along, too.
fn across(on: &Acting, i: usize, x: f64, angle: f64) -> f64 {
    let contact = &on.contact[i];
    let y = match &on.tire {
        Tire::Linear(_) => contact.stiffness_y * angle,
        Tire::Brush(brush) if x != 0.0 => brush.combined(contact, slip_of(on, i, x, angle, 1.0), angle)[1],
        tire => {
            let y = tire.lateral(contact, angle);
            let left = left_across(contact, x, 1.0);
            y.clamp(-left, left)
        }
    };
    if on.ellipse_factor == 0.0 {
        return y;
    }
    let friction = if contact.friction_x.is_finite() { contact.friction_x } else { 1.0 };
    let used = on.ellipse_factor * x / friction;
    y * (1.0 - used * used).max(1e-4).sqrt()
}

/// The friction ellipse: what is left across at `x` along.
fn left_across(contact: &Contact, x: f64, factor: f64) -> f64 {
    let used = factor * x / contact.friction_x;
    (1.0 - used * used).max(1e-4).sqrt() * contact.friction_y
}

/// The slip at which a tire at this slip angle transmits `x` along.
fn slip_of(on: &Acting, i: usize, x: f64, angle: f64, bend: f64) -> f64 {
    let contact = &on.contact[i];
    match &on.tire {
        Tire::Linear(_) => x / contact.stiffness_x,
        tire => {
            if bend <= 1e-3 {
                return x / contact.stiffness_x;
            }
            let friction = contact.friction_x / bend;
            let most = 0.995 * friction;
            let alone = tire.slip(contact.stiffness_x, friction, x.clamp(-most, most));
            let Tire::Brush(_) = tire else { return alone };
            let lateral = contact.stiffness_y * angle / contact.friction_y;
            let mut slip = alone;
            for _ in 0..3 {
                let along = contact.stiffness_x * slip / contact.friction_x;
                let total = along.hypot(lateral);
                if total < 1e-6 {
                    return alone;
                }
                slip = x / contact.stiffness_x * total / tire.force(1.0, 1.0, total);
            }
            slip
        }
    }
}
