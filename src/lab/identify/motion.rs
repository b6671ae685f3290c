//! The car's equations as identification integrates them: three states, wheels without delay.
//!
//! A wheel's rotation is fifty times faster than anything else in the plane, and its speed is
//! measured; so it is no state. Its inertia still counts: what turns it is missing at the body
//! (methods.md §2 with r ω̇ the acceleration of its contact point). So it adds to the car's mass, and,
//! at half a track from the middle, some per cent to its yaw inertia.

use super::car::PlainCar;
use super::longitudinal_input::LongitudinalInput;
use super::record::Row;
use physics::model::body::{External, Steer, Velocity};
use physics::model::tire::{Curve, Tire};
use physics::model::wheel;
use physics::model::{GRAVITY, Real};

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
    /// Force along each axle's wheels / load, where it comes from outside.
    share: [T; 2],
    /// Slip angles, front and rear.
    slip_angle: [T; 2],
    /// Speed of each contact point along its wheel.
    along: [T; 4],
    /// How fast the front wheels' speed grows for their turning into the axle's motion across.
    turning: T,
    ax: T,
    ay: T,
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
        let body = &self.body;
        let along = body.contact_speeds(&velocity, steer);
        let [front_along, front_across] = body.front_axle_velocity(&velocity, steer);
        let [rear_along, rear_across] = body.rear_axle_velocity(&velocity);
        let slip_angle =
            [wheel::slip_angle(front_along, front_across), wheel::slip_angle(rear_along, rear_across)];
        let zero = T::constant(0.0);
        let (mut fx, mut fy, mut share) = ([zero; 4], [zero; 4], [zero; 2]);
        let taken = if moves_as_measured { self.taken(&velocity, input.acceleration) } else { [zero; 2] };
        for axle in 0..2 {
            let (contact, load, angle) = (&self.contact[axle], self.load[axle], slip_angle[axle]);
            if self.from_outside[axle] {
                let mut x = zero;
                if drive == LongitudinalInput::Torque {
                    let most = contact.friction_x * 0.99;
                    let torques = self.drive_share[axle] * input.drive_torque
                        - self.brake_share[axle] * input.brake_pressure;
                    x = torques.at_most(most).at_least(-most);
                } else if moves_as_measured {
                    let most = contact.friction_x * 0.99;
                    x = taken[axle].at_most(most).at_least(-most);
                }
                share[axle] = x;
                let y = self.across(axle, x, angle) * load;
                let x = x * load;
                (fx[2 * axle], fx[2 * axle + 1]) = (x, x);
                (fy[2 * axle], fy[2 * axle + 1]) = (y, y);
                continue;
            }
            for i in [2 * axle, 2 * axle + 1] {
                let slip = match drive {
                    LongitudinalInput::Slips => T::constant(input.wheel[i]),
                    _ => wheel::slip(self.radius[i] * input.wheel[i], along[i]),
                };
                let [x, y] = self.tire.combined(contact, slip, angle);
                fx[i] = x * load;
                fy[i] = y * load;
            }
        }
        let bare = body.accelerate(&velocity, steer, &fx, &fy, &External::none());
        // A steered wheel's own direction turns, and has the front axle's motion across in it.
        let turning = (bare.vy_rate + body.a * bare.yaw) * steer.sin
            + front_across * (T::constant(input.steering_rate) / self.steering_ratio);
        let [all, front] = self.added_mass;
        let ax = (bare.ax * body.mass - all * (vy * yaw_rate) - front * turning) / (body.mass + all);
        let (ax, vx_rate) = if moves_as_measured {
            let rate = T::constant(input.acceleration);
            (rate - vy * yaw_rate, rate)
        } else {
            (ax, ax + vy * yaw_rate)
        };
        let yaw = bare.yaw * self.yaw_share;
        Instant { rate: [vx_rate, bare.vy_rate, yaw], share, slip_angle, along, turning, ax, ay: bare.ay }
    }

    /// Force / load along each axle's wheels that an acceleration takes: driven wheels drive, all wheels brake.
    #[inline(always)]
    fn taken(&self, velocity: &Velocity<T>, acceleration: f64) -> [T; 2] {
        let body = &self.body;
        let forward = T::constant(acceleration) - velocity.vy * velocity.yaw_rate;
        let force = forward * body.mass + velocity.vx * velocity.vx * body.drag;
        let all = force / (body.mass * GRAVITY);
        match self.driven {
            [true, false] if force.value() > 0.0 => [force / (self.load[0] * 2.0), T::constant(0.0)],
            [false, true] if force.value() > 0.0 => [T::constant(0.0), force / (self.load[1] * 2.0)],
            _ => [all; 2],
        }
    }

    /// What the sensors would say.
    #[inline(always)]
    pub(super) fn outputs(&self, state: &State<T>, now: &Instant<T>) -> Outputs<T> {
        let zero = T::constant(0.0);
        let mut outputs = [
            zero,
            zero,
            zero,
            zero,
            state[2] + self.yaw_rate_offset,
            now.ay + self.lateral_offset,
            now.ax + self.longitudinal_offset,
            state[0],
        ];
        for (i, output) in outputs.iter_mut().take(4).enumerate() {
            let axle = i / 2;
            if !self.from_outside[axle] {
                continue;
            }
            // A part of the torque turns the wheel itself.
            let side = if i % 2 == 0 { -self.half_track[axle] } else { self.half_track[axle] };
            let turning = if axle == 0 { now.turning } else { zero };
            let faster = now.rate[0] + side * now.rate[2] + turning;
            let share = now.share[axle] - self.wheel_mass * faster / self.load[axle];
            let slip = self.slip_of(axle, share, now.slip_angle[axle]);
            *output = now.along[i] * (slip + 1.0) / self.radius[i];
        }
        outputs
    }

    /// Lateral force / load of a tire that transmits `x` along, too.
    #[inline(always)]
    fn across(&self, axle: usize, x: T, angle: T) -> T {
        let contact = &self.contact[axle];
        match &self.tire {
            Tire::Linear(_) => self.tire.lateral(contact, angle),
            Tire::Brush(brush) => {
                let slip = self.slip_of(axle, x, angle);
                brush.combined(contact, slip, angle)[1]
            }
            Tire::PiecewiseLinear(_) | Tire::MagicFormula(_) => {
                let y = self.tire.lateral(contact, angle);
                let left = self.left_across(axle, x);
                y.at_most(left).at_least(-left)
            }
        }
    }

    /// The friction ellipse: what is left across at `x` along.
    #[inline(always)]
    fn left_across(&self, axle: usize, x: T) -> T {
        let contact = &self.contact[axle];
        let used = x / contact.friction_x;
        (-(used * used) + 1.0).at_least(T::constant(1e-4)).sqrt() * contact.friction_y
    }

    /// The slip at which a tire at this slip angle transmits `x` along: [`Tire::combined`] the other way
    /// round.
    #[inline(always)]
    fn slip_of(&self, axle: usize, x: T, angle: T) -> T {
        let contact = &self.contact[axle];
        let alone = self.tire.slip(contact.stiffness_x, contact.friction_x, x);
        match &self.tire {
            Tire::Linear(_) => alone,
            Tire::PiecewiseLinear(_) | Tire::MagicFormula(_) => {
                let y = self.tire.lateral(contact, angle).abs();
                let left = self.left_across(axle, x);
                if y.value() <= left.value() {
                    return alone;
                }
                // Both were scaled back onto the ellipse: so much it was before.
                self.tire.slip(contact.stiffness_x, contact.friction_x, x * y / left)
            }
            Tire::Brush(_) => {
                // Bristles bend along the total deflection: σ f(|σ|)/|σ| has this x. Three rounds of
                // substitution are exact to a per mille below 90 % use.
                let across = contact.stiffness_y * angle / contact.friction_y;
                let mut slip = alone;
                for _ in 0..3 {
                    let along = contact.stiffness_x * slip / contact.friction_x;
                    let square = along * along + across * across;
                    if square.value() < 1e-12 {
                        return alone;
                    }
                    let total = square.sqrt();
                    let one = T::constant(1.0);
                    let force = self.tire.force(one, one, total);
                    slip = x / contact.stiffness_x * total / force;
                }
                slip
            }
        }
    }
}
