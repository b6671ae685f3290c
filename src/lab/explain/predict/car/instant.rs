//! Forces, accelerations and readings of one instant.

use super::{ExtendedCar, State};
use physics::Quantity;
use physics::model::body::{External, Steer};
use physics::model::effect::{Acting, Felt, Readings, Recorded};
use physics::model::tire::{Brush, Contact, Curve, Tire};
use physics::model::wheel;

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
    /// What drive and brakes give along the wheels, all together, N.
    pub drive_force: f64,
    /// The car's mass, kg.
    pub mass: f64,
    /// What the turning of the wheels adds to it, kg.
    pub turning_mass: f64,
}

/// What an instant shall say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compute {
    /// How the state changes.
    Rates,
    /// What the body's sensors say, too.
    Motion,
    /// What the wheels' sensors say, too: slips from forces are the costly part.
    Readings,
}

/// What was a moment ago, for effects that need the outcome to say what it is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before {
    pub(super) ax: f64,
    pub(super) ay: f64,
    pub(super) front_force: f64,
}

/// About so much of its friction a driven wheel transmits along before others drive for it. Tuned: of 0.5 to 1, sideslip
/// of the GTI's drives that was not fitted to (`free_runs`).
const MOST_ALONG: f64 = 0.9;

impl Instant {
    /// What the next instant may look back at.
    pub fn before(&self) -> Before {
        let (ax, ay) = (self.felt.ax, self.felt.ay);
        Before { ax, ay, front_force: self.front_force }
    }
}

impl ExtendedCar {
    /// Forces, accelerations and readings. `steering_rate` is that of the steering wheel, rad/s; the
    /// input is what truly was ([`Self::undo`]). Where no torque is known, the first course that is
    /// estimated is the acceleration it gives.
    pub fn instant(
        &self,
        t: f64,
        state: &State,
        input: &Recorded,
        steering_rate: f64,
        before: &Before,
        ask: Compute,
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
            external: External::none(),
            gravity: [0.0; 2],
        };
        for (effect, own) in &self.effects {
            effect.act(&now, &state.own[own.clone()], &mut on);
        }
        let velocity = now.velocity;
        let body = &on.body;
        let steer = Steer::new(on.steering_wheel / on.steering_ratio);
        let mut along = body.contact_speeds(&velocity, steer);
        let [front_along, front_across] = body.front_axle_velocity(&velocity, steer);
        let [rear_along, rear_across] = body.rear_axle_velocity(&velocity);
        let front = wheel::slip_angle(front_along, front_across);
        let rear = wheel::slip_angle(rear_along, rear_across);
        let kinematic = [front + on.toe[0], front + on.toe[1], rear + on.toe[2], rear + on.toe[3]];
        for (i, across) in [front_across, front_across, rear_across, rear_across].into_iter().enumerate() {
            [along[i], _] = wheel::turned([along[i], across], on.toe[i]);
        }
        let mut angle = kinematic;
        for (effect, own) in &self.effects {
            effect.slip_angles(&now, &state.own[own.clone()], &mut angle);
        }

        // Forces as if the wheels had no inertia.
        let torque = self.torques(input, state, &on);
        let mut x = [0.0; 4];
        let (mut fx, mut fy) = ([0.0; 4], [0.0; 4]);
        let (mut on_body_x, mut on_body_y) = ([0.0; 4], [0.0; 4]);
        for i in 0..4 {
            let most = on.contact[i].friction_x * 0.99;
            x[i] = ((torque[i] / on.radius[i] - on.brake[i]) / on.load[i]).clamp(-most, most);
            fx[i] = x[i] * on.load[i];
            fy[i] = self.across(&on, i, x[i], angle[i]) * on.load[i];
            [on_body_x[i], on_body_y[i]] = wheel::turned([fx[i], fy[i]], -on.toe[i]);
        }
        let mut external = on.external;
        external.fx += body.mass * on.gravity[0];
        external.fy += body.mass * on.gravity[1];
        let bare = body.accelerate(&velocity, steer, &on_body_x, &on_body_y, &external);

        // The wheels' inertia.
        let mass_of = |i: usize| self.wheel_inertia / (on.radius[i] * on.radius[i]);
        let at_front = mass_of(0) + mass_of(1);
        let all = at_front + mass_of(2) + mass_of(3);
        let squares =
            body.half_track_front.powi(2) * at_front + body.half_track_rear.powi(2) * (all - at_front);
        let turning =
            (bare.vy_rate + body.a * bare.yaw) * steer.sin + front_across * steering_rate / on.steering_ratio;
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
            if ask != Compute::Readings {
                continue;
            }
            let slip = self.slip_of(&on, i, fx[i] / on.load[i], angle[i], self.bend_along);
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
        readings[Quantity::VehicleSpeed as usize] = velocity.vx;
        readings[Quantity::YawRate as usize] = yaw_rate;
        readings[Quantity::LateralAcceleration as usize] = felt.ay;
        readings[Quantity::LongitudinalAcceleration as usize] = felt.ax;
        readings[Quantity::SteeringWheelAngle as usize] = input.steering_wheel;
        for (effect, own) in &self.effects {
            let states = &state.own[own.clone()];
            effect.rates(&now, &felt, states, &mut rate.own[own.clone()]);
            if ask != Compute::Rates {
                effect.sense(&now, &felt, states, &mut readings);
            }
        }
        for (reading, offset) in readings.iter_mut().zip(self.offset) {
            *reading += offset;
        }
        let front_force = fy[0] + fy[1];
        let drive_force = (0..4).map(|i| torque[i] / on.radius[i]).sum();
        Instant { rate, readings, felt, front_force, drive_force, mass: body.mass, turning_mass: all }
    }

    /// Torque at each wheel, N m.
    fn torques(&self, input: &Recorded, state: &State, on: &Acting) -> [f64; 4] {
        if self.knows_torque {
            let (torque, pressure) = (input.drive_torque, input.brake_pressure);
            return std::array::from_fn(|i| self.torque_share[i] * torque - self.brake_share[i] * pressure);
        }
        let force = on.body.mass * state.live[0];
        let forces = if force > 0.0 { self.driving(force, on) } else { braking(force, on) };
        std::array::from_fn(|i| forces[i] * on.radius[i])
    }

    /// Forces of the driven wheels, N: the same at all of them, as a differential gives it, and less the nearer a wheel is
    /// to what it can bear; that goes to the others, as a brake on the spinning wheel sends it there.
    fn driving(&self, force: f64, on: &Acting) -> [f64; 4] {
        let driven = self.driven.iter().filter(|driven| **driven).count() as f64;
        let weight: [f64; 4] = std::array::from_fn(|i| {
            let most = MOST_ALONG * on.contact[i].friction_x * on.load[i];
            if self.driven[i] { (1.0 + (force / driven / most).powi(4)).powf(-0.25) } else { 0.0 }
        });
        let all: f64 = weight.iter().sum();
        weight.map(|weight| force * weight / all)
    }

    /// Lateral force / load of a tire that transmits `x` along, too.
    fn across(&self, on: &Acting, i: usize, x: f64, angle: f64) -> f64 {
        let contact = &on.contact[i];
        let y = match &on.tire {
            Tire::Linear(_) => contact.stiffness_y * angle,
            Tire::Brush(brush) if x != 0.0 => {
                brush.combined(contact, self.slip_of(on, i, x, angle, 1.0), angle)[1]
            }
            tire => {
                let y = self.force(tire, contact.stiffness_y, contact.friction_y, angle);
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

    /// The slip at which a tire at this slip angle transmits `x` along.
    fn slip_of(&self, on: &Acting, i: usize, x: f64, angle: f64, bend: f64) -> f64 {
        let contact = &on.contact[i];
        match &on.tire {
            Tire::Linear(_) => x / contact.stiffness_x,
            tire => {
                if bend <= 1e-3 {
                    return x / contact.stiffness_x;
                }
                let friction = contact.friction_x / bend;
                let most = 0.995 * friction;
                if let Tire::Brush(brush) = tire {
                    return slip_of_brush(brush, &Contact { friction_x: friction, ..*contact }, x, angle);
                }
                self.slip(tire, contact.stiffness_x, friction, x.clamp(-most, most))
            }
        }
    }

    /// [`Curve::force`], looked up where the tire is the car's own.
    fn force(&self, tire: &Tire, stiffness: f64, friction: f64, slip: f64) -> f64 {
        match (tire, &self.lookup) {
            (Tire::MagicFormula(own), Some(lookup)) if lookup.is_of(own) => {
                lookup.force(stiffness, friction, slip)
            }
            _ => tire.force(stiffness, friction, slip),
        }
    }

    /// [`Curve::slip`], looked up where the tire is the car's own.
    fn slip(&self, tire: &Tire, stiffness: f64, friction: f64, force: f64) -> f64 {
        match (tire, &self.lookup) {
            (Tire::MagicFormula(own), Some(lookup)) if lookup.is_of(own) => {
                lookup.slip(stiffness, friction, force)
            }
            _ => tire.slip(stiffness, friction, force),
        }
    }
}

/// All wheels brake by what they carry at the moment. Axles do so by the distribution of brake force; wheels of one axle
/// with the same pressure do not, but the drives in `free_runs` ask for it (sideslip of a GTI 0.76° for 0.44°).
fn braking(force: f64, on: &Acting) -> [f64; 4] {
    let all: f64 = on.load.iter().sum();
    on.load.map(|load| force * load / all)
}

/// The slip at which a brush tire at this slip angle transmits `x` along: x divided by the secant stiffness
/// there, again and again, the way it goes extrapolated (Aitken).
fn slip_of_brush(brush: &Brush, contact: &Contact, x: f64, angle: f64) -> f64 {
    let next = |slip: f64| {
        let slip = slip.abs().clamp(1e-6, 1.0).copysign(slip);
        let [along, _] = brush.combined(contact, slip, angle);
        x * slip / along
    };
    let first = x / contact.stiffness_x;
    let second = next(first);
    let third = next(second);
    let (one, two) = (second - first, third - second);
    let limit = if (two - one).abs() > 1e-12 { third - two * two / (two - one) } else { third };
    next(limit).clamp(-1.0, 1.0)
}

/// The friction ellipse: what is left across at `x` along.
fn left_across(contact: &Contact, x: f64, factor: f64) -> f64 {
    let used = factor * x / contact.friction_x;
    (1.0 - used * used).max(1e-4).sqrt() * contact.friction_y
}
