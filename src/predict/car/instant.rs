//! Forces, accelerations and readings of one instant.

use super::lookup::LookedUp;
use super::{ExtendedCar, State, Torque};
use physics::Quantity;
use physics::model::body::Steer;
use physics::model::effect::{Acting, Before, Felt, Readings, Recorded};
use physics::model::force::{AddedMass, WheelMotion};
use physics::model::tire::{Contact, Curve, Tire};
use physics::model::{Plant, wheel};

/// Everything at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Derivatives of the state.
    pub rate: State,
    /// What the sensors say.
    pub readings: Readings,
    /// How much faster each wheel turns than it would roll, rad/s.
    pub slipping: [f64; 4],
    /// Accelerations and forces.
    pub felt: Felt,
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

/// About so much of its friction a driven wheel transmits along before others drive for it. Tuned: of 0.5 to 1, sideslip
/// of the GTI's drives that was not fitted to (`free_runs`).
const MOST_ALONG: f64 = 0.9;

impl Instant {
    /// What the next instant may look back at.
    pub fn before(&self) -> Before {
        Before::of(&self.felt)
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
        let mut on = Acting::plain(&self.plant, input.steering_wheel, self.steering_ratio);
        self.effects.act(&now, &state.own, &mut on);
        let body = &on.body;
        let motion = WheelMotion::new(body, now.velocity, Steer::new(on.steer()), on.turned());
        let mut angle = motion.slip_angle;
        self.effects.slip_angles(&now, &state.own, &mut angle);

        // Forces as if the wheels had no inertia.
        let torque = self.torques(input, state, &on);
        let (mut fx, mut fy) = ([0.0; 4], [0.0; 4]);
        for i in 0..4 {
            let x = on.contact[i].transmitted((torque[i] / on.radius[i] - on.brake[i]) / on.load[i]);
            fx[i] = x * on.load[i];
            fy[i] = self.across(&on, i, x, angle[i]) * on.load[i];
        }
        let bare = motion.accelerate(body, &fx, &fy, &on.external());
        let added =
            AddedMass::new(body, on.radius.map(|radius| self.plant.wheel_inertia / (radius * radius)));
        let carried = added.carried(body, &motion, &bare, steering_rate / on.steering_ratio);
        let mut readings = [f64::NAN; Quantity::COUNT];
        let mut slipping = [0.0; 4];
        for i in 0..4 {
            fx[i] = added.on_road(body, &carried, i, fx[i]);
            if ask == Compute::Readings {
                let slip = self.slip_of(&on, i, fx[i] / on.load[i], angle[i]);
                readings[i] = wheel::speed_of_slip(motion.along[i], slip, on.radius[i]);
                slipping[i] = readings[i] - motion.along[i] / on.radius[i];
            }
        }
        let now_moves = &carried.acceleration;
        let felt = Felt::new(now_moves, on.gravity, motion.slip_angle, fx, fy);
        let body_rate = [now_moves.vx_rate, now_moves.vy_rate, now_moves.yaw];
        let mut rate = State { body: body_rate, ..State::default() };
        readings[Quantity::VehicleSpeed as usize] = now.velocity.vx;
        readings[Quantity::YawRate as usize] = now.velocity.yaw_rate;
        readings[Quantity::LateralAcceleration as usize] = felt.ay;
        readings[Quantity::LongitudinalAcceleration as usize] = felt.ax;
        readings[Quantity::SteeringWheelAngle as usize] = input.steering_wheel;
        self.effects.rates(&now, &felt, &state.own, &mut rate.own);
        if ask != Compute::Rates {
            self.effects.sense(&now, &felt, &state.own, &mut readings);
        }
        for (reading, offset) in readings.iter_mut().zip(self.offset) {
            *reading += offset;
        }
        let drive_force = (0..4).map(|i| torque[i] / on.radius[i]).sum();
        Instant { rate, readings, slipping, felt, drive_force, mass: body.mass, turning_mass: added.all }
    }

    /// Torque at each wheel, N m.
    fn torques(&self, input: &Recorded, state: &State, on: &Acting) -> [f64; 4] {
        if self.torque.is_known() {
            let (torque, pressure) = (input.drive_torque, input.brake_pressure);
            let brake = |i: usize| on.brake_gain[i] * self.brake_share[i] * pressure;
            let recorded: [f64; 4] = std::array::from_fn(|i| self.torque_share[i] * torque - brake(i));
            if self.torque == Torque::Recorded {
                return recorded;
            }
            // It errs where it acts: at the brakes, or at the driven wheels.
            let brakes: f64 = self.brake_share.iter().sum();
            let is_braking = pressure > 0.0 && brakes > 0.0;
            let share = if is_braking { &self.brake_share } else { &self.torque_share };
            let each = on.body.mass * state.live[0] / share.iter().sum::<f64>();
            return std::array::from_fn(|i| recorded[i] + each * share[i] * on.radius[i]);
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
            if self.driven[i] { (1.0 + (force / driven / most).powi(4)).sqrt().sqrt().recip() } else { 0.0 }
        });
        let all: f64 = weight.iter().sum();
        weight.map(|weight| force * weight / all)
    }

    /// Lateral force / load of a tire that transmits `x` along, too.
    fn across(&self, on: &Acting, i: usize, x: f64, angle: f64) -> f64 {
        let contact = &on.contact[i];
        let y = on.tire.across(&self.curve(&on.tire), contact, x, angle);
        y * on.ellipse.left_across(&on.tire, contact, x)
    }

    /// Lateral force over load of an axle's tires (0 front, 1 rear) at their static load, at a slip angle, rad.
    pub fn force_at_rest(&self, axle: usize, angle: f64) -> f64 {
        let Plant { tire, nominal, .. } = &self.plant;
        tire.across(&self.curve(tire), &nominal.contact[2 * axle], 0.0, angle)
    }

    /// The slip at which a tire at this slip angle transmits `x` along, its curve as bent as is known.
    fn slip_of(&self, on: &Acting, i: usize, x: f64, angle: f64) -> f64 {
        let contact = &on.contact[i];
        let curve = self.curve(&on.tire);
        let x = x / on.ellipse.left_along(&on.tire, &curve, contact, angle);
        if matches!(on.tire, Tire::Linear(_)) || self.bend_along <= 1e-3 {
            return x / contact.stiffness_x;
        }
        let friction_x = contact.friction_x / self.bend_along;
        if let Tire::Brush(brush) = &on.tire {
            return brush.slip_at(&Contact { friction_x, ..*contact }, x, angle);
        }
        let most = 0.995 * friction_x;
        curve.slip(contact.stiffness_x, friction_x, x.clamp(-most, most))
    }

    /// A tire at pure slip, looked up where it is the car's own.
    fn curve<'a>(&'a self, tire: &'a Tire) -> LookedUp<'a> {
        LookedUp { tire, lookup: self.lookup.as_ref() }
    }
}

/// All wheels brake by what they carry at the moment, and by what their brake gives. Axles do so by the distribution of brake
/// force; wheels of one axle with the same pressure do not, but the drives in `free_runs` ask for it (sideslip of a GTI 0.76° for
/// 0.44°).
fn braking(force: f64, on: &Acting) -> [f64; 4] {
    let weight: [f64; 4] = std::array::from_fn(|i| on.brake_gain[i] * on.load[i]);
    let all: f64 = weight.iter().sum();
    weight.map(|weight| force * weight / all)
}

#[cfg(test)]
mod tests {
    use super::super::{Before, MOST_LIVE, Settings};
    use super::*;
    use crate::delay::Delays;
    use identify::Values;
    use physics::model::Scenario;

    /// GIVEN torques that are known roughly WHEN they err while the engine drives, and while the brakes are on THEN the car is faster
    /// by that, and the wheels slip at which it acts.
    #[test]
    fn what_torques_err_by_acts_where_they_do() {
        let scenario = Scenario::parse(include_str!("../../../tests/data/steered.toml")).unwrap();
        let vehicle = scenario.vehicle;
        let at = |torque: Torque, input: &Recorded| {
            let car = ExtendedCar::new(Settings {
                vehicle: &vehicle,
                values: &Values::of(&vehicle),
                torque,
                bend_along: 1.0,
                delays: Delays::default(),
                effects: Vec::new(),
            });
            let mut live = [0.0; MOST_LIVE];
            live[0] = 0.5;
            let state = State { body: [20.0, 0.0, 0.0], live, ..State::default() };
            car.instant(0.0, &state, input, 0.0, &Before::default(), Compute::Readings)
        };
        let driving = Recorded { drive_torque: 300.0, ..Recorded::default() };
        let braking = Recorded { brake_pressure: 20.0, ..Recorded::default() };
        for (input, rear_slips) in [(driving, false), (braking, true)] {
            let [roughly, recorded] = [Torque::Roughly, Torque::Recorded].map(|torque| at(torque, &input));
            // A part of the force turns the wheels.
            let faster = roughly.rate.body[0] - recorded.rate.body[0];
            assert!((0.45..0.5).contains(&faster), "{faster}");
            let slips = |i: usize| roughly.slipping[i] - recorded.slipping[i] > 1e-3;
            assert!(slips(0) && slips(1));
            assert_eq!((slips(2), slips(3)), (rear_slips, rear_slips));
        }
    }
}
