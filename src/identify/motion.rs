//! The car's equations as identification integrates them: three states, wheels without delay.
//!
//! A wheel's speed is measured, so its rotation is no state ([`physics::model::force`]).

use super::car::PlainCar;
use super::longitudinal_input::LongitudinalInput;
use super::record::Row;
use physics::model::body::{Steer, Velocity};
use physics::model::force::{Carried, WheelMotion};
use physics::model::{GRAVITY, Plant, Real, wheel};

/// What is measured of the car, in the order of their places in a row of outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Front left wheel, rad/s.
    WheelFl,
    /// Front right wheel, rad/s.
    WheelFr,
    /// Rear left wheel, rad/s.
    WheelRl,
    /// Rear right wheel, rad/s.
    WheelRr,
    /// Yaw rate, rad/s.
    YawRate,
    /// Lateral acceleration, m/s².
    LateralAcceleration,
    /// Longitudinal acceleration, m/s².
    LongitudinalAcceleration,
    /// Speed, m/s.
    Speed,
}

impl Output {
    /// How many there are.
    pub const COUNT: usize = 8;

    /// All of them.
    pub const ALL: [Self; Self::COUNT] = [
        Self::WheelFl,
        Self::WheelFr,
        Self::WheelRl,
        Self::WheelRr,
        Self::YawRate,
        Self::LateralAcceleration,
        Self::LongitudinalAcceleration,
        Self::Speed,
    ];

    /// As in `[signals]`, but for the speed.
    pub const fn name(self) -> &'static str {
        match self {
            Self::WheelFl => "wheel_speed_fl",
            Self::WheelFr => "wheel_speed_fr",
            Self::WheelRl => "wheel_speed_rl",
            Self::WheelRr => "wheel_speed_rr",
            Self::YawRate => "yaw_rate",
            Self::LateralAcceleration => "lateral_acceleration",
            Self::LongitudinalAcceleration => "longitudinal_acceleration",
            Self::Speed => "speed",
        }
    }

    /// Its SI unit.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::WheelFl | Self::WheelFr | Self::WheelRl | Self::WheelRr | Self::YawRate => "rad/s",
            Self::LateralAcceleration | Self::LongitudinalAcceleration => "m/s²",
            Self::Speed => "m/s",
        }
    }
}

/// A number for each [`Output`].
pub(super) type Outputs<T> = [T; Output::COUNT];

/// What drives the equations between two rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Input {
    pub(super) steering: f64,
    /// Its rate, rad/s.
    pub(super) steering_rate: f64,
    /// Wheel speeds or slips, as [`LongitudinalInput`] says.
    pub(super) wheel: [f64; 4],
    pub(super) drive_torque: f64,
    pub(super) brake_pressure: f64,
    /// The measured speed, where it is an input, m/s.
    pub(super) speed: f64,
    /// Its rate, m/s².
    pub(super) acceleration: f64,
}

impl Input {
    pub(super) fn of(row: &Row, drive: LongitudinalInput) -> Self {
        let or_zero = |value: f64| if value.is_finite() { value } else { 0.0 };
        Self {
            steering: row.steering,
            steering_rate: 0.0,
            wheel: if drive == LongitudinalInput::Slips { row.slip } else { row.wheel_speed },
            drive_torque: or_zero(row.drive_torque),
            brake_pressure: or_zero(row.brake_pressure),
            speed: or_zero(row.vehicle_speed),
            acceleration: 0.0,
        }
    }

    /// At a share of the way to another.
    #[inline(always)]
    pub(super) fn towards(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        let mut mixed = Self {
            steering: mix(self.steering, other.steering),
            steering_rate: self.steering_rate,
            drive_torque: mix(self.drive_torque, other.drive_torque),
            brake_pressure: mix(self.brake_pressure, other.brake_pressure),
            speed: mix(self.speed, other.speed),
            acceleration: self.acceleration,
            wheel: self.wheel,
        };
        for (i, mixed) in mixed.wheel.iter_mut().enumerate() {
            *mixed = mix(*mixed, other.wheel[i]);
        }
        mixed
    }
}

/// State: velocity along and across, yaw rate.
pub(super) type State<T> = [T; 3];

/// All there is at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instant<T> {
    pub(super) rate: State<T>,
    /// Force along each axle's wheels, N, where it comes from outside.
    outside: [T; 2],
    motion: WheelMotion<T>,
    carried: Carried<T>,
}

impl<T: Real> PlainCar<T> {
    /// Forces and accelerations.
    #[inline(always)]
    pub(super) fn instant(&self, state: &State<T>, input: &Input, drive: LongitudinalInput) -> Instant<T> {
        let [mut vx, vy, yaw_rate] = *state;
        let moves_as_measured = drive == LongitudinalInput::Speed;
        if moves_as_measured {
            vx = T::constant(input.speed);
        }
        let velocity = Velocity { vx, vy, yaw_rate };
        let steer = Steer::new((-self.steering_offset + input.steering) / self.steering_ratio);
        let Plant { body, tire, radius, nominal, .. } = &self.plant;
        let motion = WheelMotion::new(body, velocity, steer, None);
        let zero = T::constant(0.0);
        let (mut fx, mut fy, mut outside) = ([zero; 4], [zero; 4], [zero; 2]);
        let taken = if moves_as_measured { self.taken(&velocity, input.acceleration) } else { [zero; 2] };
        for axle in 0..2 {
            let (left, right) = (2 * axle, 2 * axle + 1);
            let (contact, load) = (&nominal.contact[left], nominal.load[left]);
            let angle = motion.slip_angle[left];
            if self.from_outside[axle] {
                let mut x = zero;
                if drive == LongitudinalInput::Torque {
                    x = contact.transmitted(
                        self.drive_share[axle] * input.drive_torque
                            - self.brake_share[axle] * input.brake_pressure,
                    );
                } else if moves_as_measured {
                    x = contact.transmitted(taken[axle]);
                }
                let y = tire.across(tire, contact, x, angle) * load;
                let x = x * load;
                outside[axle] = x;
                (fx[left], fx[right]) = (x, x);
                (fy[left], fy[right]) = (y, y);
                continue;
            }
            for i in [left, right] {
                let slip = match drive {
                    LongitudinalInput::Slips => T::constant(input.wheel[i]),
                    _ => wheel::slip(radius[i] * input.wheel[i], motion.along[i]),
                };
                let [x, y] = tire.combined(contact, slip, angle);
                fx[i] = x * load;
                fy[i] = y * load;
            }
        }
        let bare = motion.accelerate(body, &fx, &fy, &nominal.external);
        let steer_rate = T::constant(input.steering_rate) / self.steering_ratio;
        let mut carried = self.added_mass.carried(body, &motion, &bare, steer_rate);
        let now = &mut carried.acceleration;
        if moves_as_measured {
            now.vx_rate = T::constant(input.acceleration);
            now.ax = now.vx_rate - vy * yaw_rate;
        }
        Instant { rate: [now.vx_rate, now.vy_rate, now.yaw], outside, motion, carried }
    }

    /// Force / load along each axle's wheels that an acceleration takes: driven wheels drive, all wheels brake.
    #[inline(always)]
    fn taken(&self, velocity: &Velocity<T>, acceleration: f64) -> [T; 2] {
        let Plant { body, nominal, .. } = &self.plant;
        let forward = T::constant(acceleration) - velocity.vy * velocity.yaw_rate;
        let force = forward * body.mass + velocity.vx * velocity.vx * body.drag;
        let all = force / (body.mass * GRAVITY);
        match self.driven {
            [true, false] if force.value() > 0.0 => [force / (nominal.load[0] * 2.0), T::constant(0.0)],
            [false, true] if force.value() > 0.0 => [T::constant(0.0), force / (nominal.load[2] * 2.0)],
            _ => [all; 2],
        }
    }

    /// What the sensors would say.
    #[inline(always)]
    pub(super) fn outputs(&self, state: &State<T>, now: &Instant<T>) -> Outputs<T> {
        let zero = T::constant(0.0);
        let felt = &now.carried.acceleration;
        let mut outputs = [
            zero,
            zero,
            zero,
            zero,
            state[2] + self.yaw_rate_offset,
            felt.ay + self.lateral_offset,
            felt.ax + self.longitudinal_offset,
            state[0],
        ];
        let Plant { body, tire, radius, nominal, .. } = &self.plant;
        for (i, output) in outputs.iter_mut().take(4).enumerate() {
            if !self.from_outside[i / 2] {
                continue;
            }
            let x = self.added_mass.on_road(body, &now.carried, i, now.outside[i / 2]) / nominal.load[i];
            let slip = tire.slip_at(&nominal.contact[i], x, now.motion.slip_angle[i]);
            *output = wheel::speed_of_slip(now.motion.along[i], slip, radius[i]);
        }
        outputs
    }
}
