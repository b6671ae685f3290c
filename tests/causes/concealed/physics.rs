//! The second vehicle simulator: a planar four-wheel car with spinning wheels, written in *momenta and ground axes*
//! (linear momentum in the ground frame, angular momentum about the vertical), integrated by the fifth-order
//! weights of Dormand and Prince (1980) at a fixed 1 ms. Sources: Guiggiani 2018 (ch. 3), Rajamani 2012 (chs. 2, 4,
//! 13), Pacejka 2012 (chs. 1, 4, 7), Milliken 1995.

use super::car::{Car, G};
use super::hidden::{Hidden, Patch, at};
use super::tire::{self, Grip};

/// Step of the integrator, s.
pub const STEP: f64 = 0.001;
/// Pneumatic trail the steering's compliance works with, m.
pub const TRAIL: f64 = 0.05;
const ROLL_FREQUENCY: f64 = 10.0;
const ROLL_DAMPING: f64 = 0.3;
const SLOSH_FREQUENCY: f64 = 3.2;
const SLOSH_DAMPING: f64 = 0.04;
const SHIMMY_FREQUENCY: f64 = 17.0;

const N: usize = 23;
const PX: usize = 3;
const PY: usize = 4;
const SPIN: usize = 5;
const OMEGA: usize = 6;
const ANGLE: usize = 10;
const ROLL: usize = 14;
const LAG: usize = 16;
const ALPHA: usize = 17;
const SLOSH: usize = 21;
type State = [f64; N];

/// What the driver does.
#[derive(Clone, Copy, Debug, Default)]
pub struct Input {
    /// Steering wheel, rad.
    pub steering: f64,
    /// Drive torque of the axle, N m.
    pub torque: f64,
    /// Brake pressure, bar.
    pub pressure: f64,
}

/// One millisecond of truth, body axes at the centre of gravity.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment {
    pub input: Input,
    /// Forward and leftward speed, m/s.
    pub u: f64,
    pub v: f64,
    pub r: f64,
    pub r_dot: f64,
    /// Specific force (what an ideal accelerometer reads), m/s².
    pub force: [f64; 2],
    pub omega: [f64; 4],
    /// Wheel rotation since the start, rad.
    pub angle: [f64; 4],
    /// Roll angle, rad.
    pub roll: f64,
    /// Heading, rad, and position, m.
    pub heading: f64,
    pub position: [f64; 2],
}

/// A start of a drive: straight or mid-corner.
#[derive(Clone, Copy, Debug, Default)]
pub struct Start {
    pub u: f64,
    pub v: f64,
    pub r: f64,
    pub omega: [f64; 4],
}

impl Start {
    /// Rolling straight ahead.
    pub fn straight(speed: f64, car: &Car) -> Self {
        Start { u: speed, v: 0.0, r: 0.0, omega: [speed / car.radius; 4] }
    }
}

/// Quantities held through a step: algebraic loops are closed over the millisecond before.
#[derive(Clone, Copy, Default)]
struct Memory {
    force: [f64; 2],
    front_lateral: f64,
    /// Steering wheel behind the free play, rad.
    behind_play: f64,
    shimmy: [f64; 2],
}

/// Everything that follows from a state at an instant.
struct Balance {
    body: [f64; 2],
    external: [f64; 2],
    yaw_moment: f64,
    wheel: [f64; 4],
    alpha_rate: [f64; 4],
    lag_rate: f64,
    front_lateral: f64,
    slosh: f64,
}

/// A simulation that is driven step by step.
pub struct Simulator<'a> {
    car: &'a Car,
    hidden: &'a Hidden,
    state: State,
    memory: Memory,
    t: f64,
    step: f64,
}

impl<'a> Simulator<'a> {
    /// At time `t`, in motion as `start` says; what only hidden physics has begins at rest.
    pub fn new(car: &'a Car, hidden: &'a Hidden, t: f64, start: &Start, step: f64) -> Self {
        let mut state = [0.0; N];
        let mass = car.mass + hidden.payload;
        state[PX] = mass * start.u;
        state[PY] = mass * start.v;
        state[SPIN] = yaw_inertia(car, hidden) * start.r;
        state[OMEGA..OMEGA + 4].copy_from_slice(&start.omega);
        let memory = Memory { shimmy: [0.01, 0.0], ..Memory::default() };
        Simulator { car, hidden, state, memory, t, step }
    }

    pub fn time(&self) -> f64 {
        self.t
    }

    /// Puts the body and the wheels into another motion; what only hidden physics has goes on.
    pub fn restart(&mut self, start: &Start) {
        let mass = self.car.mass + self.hidden.payload;
        let (sin, cos) = self.state[2].sin_cos();
        self.state[PX] = mass * (cos * start.u - sin * start.v);
        self.state[PY] = mass * (sin * start.u + cos * start.v);
        self.state[SPIN] = yaw_inertia(self.car, self.hidden) * start.r;
        self.state[OMEGA..OMEGA + 4].copy_from_slice(&start.omega);
    }

    /// The present moment under an input.
    fn moment(&self, input: &Input, balance: &Balance) -> Moment {
        let x = &self.state;
        let mass = self.car.mass + self.hidden.payload;
        let (u, v) = body_velocity(x, mass);
        Moment {
            input: *input,
            u,
            v,
            r: x[SPIN] / yaw_inertia(self.car, self.hidden),
            r_dot: balance.yaw_moment / yaw_inertia(self.car, self.hidden),
            force: [balance.body[0] / mass, balance.body[1] / mass],
            omega: std::array::from_fn(|i| x[OMEGA + i]),
            angle: std::array::from_fn(|i| x[ANGLE + i]),
            roll: x[ROLL],
            heading: x[2],
            position: [x[0], x[1]],
        }
    }

    /// One step with the input held.
    pub fn advance(&mut self, input: &Input) -> Moment {
        let play = self.hidden.freeplay;
        self.memory.behind_play = self.memory.behind_play.clamp(input.steering - play, input.steering + play);
        let balance = self.balance(&self.state, self.t, input);
        let now = self.moment(input, &balance);
        let first = self.slope(&self.state, &balance);
        self.state = self.dormand_prince(input, first);
        self.memory.force = now.force;
        self.memory.front_lateral = balance.front_lateral;
        self.shimmy(now.u);
        self.t += self.step;
        now
    }

    /// A van der Pol oscillator that lives above 17 m/s, advanced semi-implicitly.
    fn shimmy(&mut self, speed: f64) {
        let [q, rate] = self.memory.shimmy;
        let gain = if speed > 17.0 { 0.10 } else { -0.10 };
        let w = SHIMMY_FREQUENCY;
        let damped = if gain > 0.0 { 1.0 - q * q } else { 1.0 };
        let rate = rate + self.step * (2.0 * gain * w * damped * rate - w * w * q);
        let q = q + self.step * rate;
        self.memory.shimmy = [if q.abs() < 1e-3 && rate.abs() < 1e-2 { 1e-3 } else { q }, rate];
    }

    fn dormand_prince(&self, input: &Input, first: State) -> State {
        const A: [[f64; 5]; 5] = [
            [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0],
            [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0],
            [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0],
            [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0],
            [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
        ];
        const C: [f64; 5] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];
        const B: [f64; 6] = [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
        let h = self.step;
        let mut slopes = [[0.0; N]; 6];
        slopes[0] = first;
        for stage in 0..5 {
            let mut x = self.state;
            for (j, slope) in slopes.iter().enumerate().take(stage + 1) {
                let weight = h * A[stage][j];
                x.iter_mut().zip(slope).for_each(|(x, d)| *x += weight * d);
            }
            slopes[stage + 1] = self.slope(&x, &self.balance(&x, self.t + C[stage] * h, input));
        }
        let mut x = self.state;
        for (slope, weight) in slopes.iter().zip(B) {
            x.iter_mut().zip(slope).for_each(|(x, d)| *x += h * weight * d);
        }
        x
    }

    fn slope(&self, x: &State, balance: &Balance) -> State {
        let hidden = self.hidden;
        let mass = self.car.mass + hidden.payload;
        let (sin, cos) = x[2].sin_cos();
        let total = [balance.body[0] + balance.external[0], balance.body[1] + balance.external[1]];
        let lateral = balance.body[1] / mass;
        let mut d = [0.0; N];
        d[0] = x[PX] / mass;
        d[1] = x[PY] / mass;
        d[2] = x[SPIN] / yaw_inertia(self.car, hidden);
        d[PX] = cos * total[0] - sin * total[1];
        d[PY] = sin * total[0] + cos * total[1];
        d[SPIN] = balance.yaw_moment;
        for i in 0..4 {
            d[OMEGA + i] = balance.wheel[i] / self.car.wheel_inertia;
            d[ANGLE + i] = x[OMEGA + i];
            d[ALPHA + i] = balance.alpha_rate[i];
        }
        d[ROLL] = x[ROLL + 1];
        d[ROLL + 1] = ROLL_FREQUENCY * ROLL_FREQUENCY * (self.roll_gain() * lateral - x[ROLL])
            - 2.0 * ROLL_DAMPING * ROLL_FREQUENCY * x[ROLL + 1];
        d[LAG] = balance.lag_rate;
        d[SLOSH] = x[SLOSH + 1];
        d[SLOSH + 1] = balance.slosh;
        d
    }

    fn roll_gain(&self) -> f64 {
        if self.hidden.roll_steer != 0.0 { self.hidden.roll_gain } else { self.hidden.roll_leak }
    }

    /// Forces, moments and rates at a state.
    fn balance(&self, x: &State, t: f64, input: &Input) -> Balance {
        let (car, hidden) = (self.car, self.hidden);
        let mass = car.mass + hidden.payload;
        let shift = hidden.cg_shift.map_or(0.0, |(when, shift)| if t >= when { shift } else { 0.0 });
        let (a, b) = (car.a + shift, car.b - shift);
        let (u, v) = body_velocity(x, mass);
        let r = x[SPIN] / yaw_inertia(car, hidden);

        // Steering wheel to front wheels.
        let wheel = if hidden.freeplay > 0.0 { self.memory.behind_play } else { input.steering };
        let nonlinear = (1.0 - hidden.ratio_curvature * wheel * wheel).max(0.3);
        let commanded = wheel / (car.steering_ratio * nonlinear);
        let lag_rate =
            if hidden.steering_lag > 0.0 { (commanded - x[LAG]) / hidden.steering_lag } else { 0.0 };
        let steered = if hidden.steering_lag > 0.0 { x[LAG] } else { commanded };
        let front =
            steered - hidden.compliance * TRAIL * self.memory.front_lateral - hidden.roll_steer * x[ROLL];
        // Against the front wheels, then with them: (1 − x²)/(1 + x²) of the speed is the cosine of 2 atan x
        // (Furukawa et al. 1989, steering without sideslip of a car whose axles are alike).
        let rear = hidden
            .rear_steer
            .map_or(0.0, |(ratio, crossover)| -ratio * steered * (2.0 * u.atan2(crossover)).cos());

        let loads = self.loads(mass, a, b);
        let static_load = car.static_load();
        let driven = if car.front_driven { 0 } else { 2 };
        let given = 1.0 + hidden.road.as_ref().map_or(0.0, |road| road.engine.at(t));
        let torque = given * hidden.torque_limit.map_or(input.torque, |limit| input.torque.min(limit));
        let difference = x[OMEGA + driven] - x[OMEGA + driven + 1];
        let locked = hidden.lock * (difference / 0.4).tanh();

        let (mut body, mut yaw_moment, mut front_lateral) = ([0.0; 2], 0.0, 0.0);
        let (mut wheel_torque, mut alpha_rate) = ([0.0; 4], [0.0; 4]);
        for i in 0..4 {
            let (axle, left) = (i / 2, i % 2 == 0);
            let px = if axle == 0 { a } else { -b };
            let py = if left { 0.5 * car.track[axle] } else { -0.5 * car.track[axle] };
            let omega = x[OMEGA + i];
            let radius = car.radius * (1.0 + hidden.radius_error[i]);
            let radius = radius * (1.0 + hidden.radius_growth * (radius * omega).powi(2));
            let steer = if axle == 0 { front } else { rear } + hidden.toe[i];
            let (sin, cos) = steer.sin_cos();
            let (cu, cv) = (u - r * py, v + r * px);
            let along = cu * cos + cv * sin;
            let across = cv * cos - cu * sin;
            let rolling_speed = along.max(1.0);
            let slip = (radius * omega - along) / rolling_speed;
            let kinematic = -across.atan2(rolling_speed);
            let alpha = if hidden.relaxation > 0.0 {
                alpha_rate[i] = rolling_speed / hidden.relaxation * (kinematic - x[ALPHA + i]);
                x[ALPHA + i]
            } else {
                kinematic
            };
            // When this wheel meets a patch that the front axle met at its `start`.
            let met = t - if axle == 0 { 0.0 } else { (a + b) / u.max(1.0) };
            let grip = self.grip(i, met, loads[i], static_load[axle]);
            let [along_force, across_force] = tire::force(slip, alpha, &grip);
            let fx = along_force * cos - across_force * sin;
            let fy = along_force * sin + across_force * cos;
            body[0] += fx;
            body[1] += fy;
            yaw_moment += px * fy - py * fx;
            if axle == 0 {
                front_lateral += across_force;
            }
            let side = if left { -1.0 } else { 1.0 };
            let mut drive = 0.0;
            if i / 2 == driven / 2 {
                drive = 0.5 * torque + side * (0.5 * at(&hidden.vectoring, t) + locked);
            }
            let judder = if i == 1 { 1.0 + hidden.judder * x[ANGLE + i].sin() } else { 1.0 };
            let unseen: f64 =
                hidden.esp.iter().filter(|(w, _)| *w == i).map(|(_, bump)| at(&[*bump], t)).sum();
            let more = 1.0 - side * hidden.brake_imbalance[axle];
            let brake = car.brake_per_bar[axle] * input.pressure * judder * more + unseen;
            let resistance = hidden.rolling * loads[i] * radius;
            wheel_torque[i] = drive - (brake + resistance) * omega.clamp(-1.0, 1.0) - radius * along_force;
        }

        body[0] -= hidden.drag * u * u.abs();
        let wind = at(&hidden.wind, t);
        body[1] += wind;
        yaw_moment += wind * hidden.wind_at;
        if hidden.shimmy != 0.0 {
            yaw_moment += hidden.shimmy * self.memory.shimmy[0];
        }
        if let Some(road) = &hidden.road {
            let (front, rear) = (road.side.at(t), road.side.at(t - (a + b) / u.max(1.0)));
            body[0] += road.along.at(t);
            body[1] += front + rear;
            yaw_moment += a * front - b * rear;
        }
        let mut slosh = 0.0;
        if hidden.slosh > 0.0 {
            let spring = SLOSH_FREQUENCY * SLOSH_FREQUENCY * x[SLOSH]
                + 2.0 * SLOSH_DAMPING * SLOSH_FREQUENCY * x[SLOSH + 1];
            slosh = -spring - self.memory.force[1];
            let reaction = hidden.slosh * (spring + self.memory.force[1]);
            body[1] += reaction;
            yaw_moment -= 0.8 * reaction;
        }
        let external = [-mass * G * at(&hidden.grade, t).sin(), -mass * G * at(&hidden.bank, t).sin()];
        Balance {
            body,
            external,
            yaw_moment,
            wheel: wheel_torque,
            alpha_rate,
            lag_rate,
            front_lateral,
            slosh,
        }
    }

    /// Wheel loads, N: static, or with the transfer of the moment before.
    fn loads(&self, mass: f64, a: f64, b: f64) -> [f64; 4] {
        let half = mass * G / (2.0 * (a + b));
        let mut loads = [half * b, half * b, half * a, half * a];
        if let Some(transfer) = self.hidden.load_transfer {
            let [ax, ay] = self.memory.force;
            let pitch = mass * ax * transfer.height / (2.0 * (a + b));
            let roll = mass * ay * transfer.height;
            let front = roll * transfer.front_share / self.car.track[0];
            let rear = roll * (1.0 - transfer.front_share) / self.car.track[1];
            let change = [-pitch - front, -pitch + front, pitch - rear, pitch + rear];
            loads.iter_mut().zip(change).for_each(|(load, d)| *load = (*load + d).max(50.0));
        }
        loads
    }

    /// What the tire of a wheel can do there and then.
    fn grip(&self, wheel: usize, met: f64, load: f64, static_load: f64) -> Grip {
        let (car, hidden) = (self.car, self.hidden);
        let left = wheel.is_multiple_of(2);
        let side = |patch: &Patch| if left { patch.left } else { patch.right };
        let on = |patch: &&Patch| met >= patch.start && met < patch.end;
        let factor = hidden.stiffness_patches.iter().find(on).map_or(1.0, side);
        let by_load = hidden.load_transfer.map_or(1.0, |transfer| {
            let curve = |x: f64| (2.0 * (x / transfer.peak_load).atan()).sin();
            curve(load / static_load) / curve(1.0)
        });
        let usual = car.friction.or(hidden.saturation);
        let friction = match hidden.friction_patches.iter().find(on) {
            Some(patch) => Some(side(patch)).filter(|mu| mu.is_finite()).or(usual),
            None => usual,
        };
        Grip {
            longitudinal: car.slip_stiffness * factor * by_load,
            lateral: 0.5 * car.cornering[wheel / 2] * factor * by_load,
            load,
            friction,
            ellipse: hidden.ellipse.map(|(factor, mu)| (factor, car.friction.unwrap_or(mu))),
        }
    }
}

fn yaw_inertia(car: &Car, hidden: &Hidden) -> f64 {
    // Luggage sits within half a metre of the centre of gravity.
    car.yaw_inertia + 0.25 * hidden.payload
}

fn body_velocity(x: &State, mass: f64) -> (f64, f64) {
    let (sin, cos) = x[2].sin_cos();
    ((cos * x[PX] + sin * x[PY]) / mass, (cos * x[PY] - sin * x[PX]) / mass)
}
