//! One wheel with the Dahl tire as an EKF (thesis 8.2, eqs. 8.6 and 8.7): kept for comparison.
//!
//! ```text
//! ż  = v_r − |v_r| σ₀ z/μ       v_r = r ω − v            z   deflection, m
//! v̇  = (F_N σ₀ z − F_D/n)/m     m = mass per driven wheel σ₀  stiffness / load, 1/m
//! ω̇  = (τ − r F_N σ₀ z)/J       σ̇₀ = μ̇ = 0               μ   friction
//! ```
//!
//! (8.6) leaves out F_N. Here z stays a length, σ₀ is the stiffness divided by the wheel load, and F_N
//! stands where a force is needed; σ₀ z is then the normalized force, and the scales of σ₀ and μ are
//! those of Fig. 8.3. The air drag F_D is added to (8.6b): at 40 m/s it is as large as the traction.
//!
//! It cannot do what it was meant for, and the reason is in the model, not in the tuning. In steady slip
//! ż = 0 means σ₀ z = μ whatever the slip: the model has no creep below its limit, so that its μ is the
//! friction *used*. Linearized there, d/dt δ(σ₀ z) = (v_r σ₀/μ) (δμ − δ(σ₀ z)) + ż δσ₀ with ż = 0: z and
//! σ₀ only act through their product, and σ₀ alone is not observable ([`DahlWheel::observability`] has rank
//! 4 of 5). What tells σ₀, and a μ that is not used, are transients in which z builds up.
//! `mu_dahl` is therefore published as a column for comparison, and never as mu_max.

use nalgebra::{Matrix3, SMatrix, SVector, vector};

use crate::estimate::kinematics::{Car, Kinematics};
use crate::filter::discretize::{zero_order_hold, zero_order_hold_space};
use crate::filter::{Gaussian, Observability};
use crate::model::{DrivenAxle, GRAVITY};
use crate::{Quantity, Sensors, Wheel};

/// Tuned with `gripd reproduce`, thesis 8.2.
struct Tuning {
    /// Start of σ₀ (1/m) and μ, with standard deviations: of the order of Fig. 8.3.
    start: [(f64, f64); 2],
    /// Process noises of z (m/√s), v (m/s/√s), ω (rad/s/√s), σ₀ and μ (1/√s).
    walk: [f64; 5],
    /// σ₀ and μ stay within these.
    limits: [(f64, f64); 2],
    /// Standard deviation of the deflection at the start, m.
    deflection_std: f64,
    /// After a gap this long the motion is another one, s.
    gap_s: f64,
}

const TUNING: Tuning = Tuning {
    start: [(50.0, 30.0), (0.5, 0.3)],
    walk: [1e-4, 0.05, 0.5, 1.0, 0.02],
    limits: [(1.0, 1e3), (0.01, 2.0)],
    deflection_std: 1e-3,
    gap_s: 0.5,
};

/// z, v, ω, σ₀, μ.
type State = SVector<f64, 5>;
type Jacobian = SMatrix<f64, 5, 5>;

const Z: usize = 0;
const V: usize = 1;
const OMEGA: usize = 2;
const SIGMA: usize = 3;
const MU: usize = 4;

/// The wheel's own numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DahlWheel {
    /// Wheel radius, m.
    pub radius: f64,
    /// Wheel inertia, kg m².
    pub inertia: f64,
    /// Vehicle mass per driven wheel, kg.
    pub mass: f64,
    /// Load of the wheel, N.
    pub load: f64,
    /// Air drag per driven wheel, kg/m.
    pub drag: f64,
}

impl DahlWheel {
    /// Of a driven wheel of this car.
    pub fn new(car: &Car) -> Self {
        let driven = if car.driven_axle == DrivenAxle::All { 4.0 } else { 2.0 };
        let load = match car.driven_axle {
            DrivenAxle::Front => car.wheel_load[0],
            DrivenAxle::Rear => car.wheel_load[1],
            DrivenAxle::All => 0.25 * car.mass * GRAVITY,
        };
        Self {
            radius: car.radius,
            inertia: car.wheel_inertia,
            mass: car.mass / driven,
            load,
            drag: car.drag / driven,
        }
    }

    /// The right-hand side of (8.7) under a torque, N m.
    pub fn rate(&self, x: &State, torque: f64) -> State {
        let sliding = self.radius * x[OMEGA] - x[V];
        let force = self.load * x[SIGMA] * x[Z];
        vector![
            sliding - sliding.abs() * x[SIGMA] * x[Z] / x[MU],
            (force - self.drag * x[V] * x[V].abs()) / self.mass,
            (torque - self.radius * force) / self.inertia,
            0.0,
            0.0
        ]
    }

    /// Its derivative by the state.
    pub fn jacobian(&self, x: &State) -> Jacobian {
        let sliding = self.radius * x[OMEGA] - x[V];
        let share = x[SIGMA] * x[Z] / x[MU];
        let by_sliding = 1.0 - sliding.signum() * share;
        let mut a = Jacobian::zeros();
        a[(Z, Z)] = -sliding.abs() * x[SIGMA] / x[MU];
        a[(Z, V)] = -by_sliding;
        a[(Z, OMEGA)] = self.radius * by_sliding;
        a[(Z, SIGMA)] = -sliding.abs() * x[Z] / x[MU];
        a[(Z, MU)] = sliding.abs() * share / x[MU];
        let (by_z, by_sigma) = (self.load * x[SIGMA], self.load * x[Z]);
        a[(V, Z)] = by_z / self.mass;
        a[(V, SIGMA)] = by_sigma / self.mass;
        a[(V, V)] = -2.0 * self.drag * x[V].abs() / self.mass;
        a[(OMEGA, Z)] = -self.radius * by_z / self.inertia;
        a[(OMEGA, SIGMA)] = -self.radius * by_sigma / self.inertia;
        a
    }

    /// One step of `step_s` seconds (Runge–Kutta of fourth order).
    pub fn advance(&self, x: &State, torque: f64, step_s: f64) -> State {
        let k1 = self.rate(x, torque);
        let k2 = self.rate(&(x + 0.5 * step_s * k1), torque);
        let k3 = self.rate(&(x + 0.5 * step_s * k2), torque);
        let k4 = self.rate(&(x + step_s * k3), torque);
        x + step_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    }

    /// What v and ω, measured with variances `noise`, tell of the first state of a drive from `x` under
    /// these torques (N m), one each `step_s`.
    pub fn observability(
        &self,
        mut x: State,
        torques: &[f64],
        step_s: f64,
        noise: [f64; 2],
    ) -> Observability<5> {
        let mut seen = Observability::new();
        for torque in torques {
            let transition = zero_order_hold(&self.jacobian(&x), step_s).0;
            x = self.advance(&x, *torque, step_s);
            seen.advance(&transition);
            for (state, noise) in [V, OMEGA].into_iter().zip(noise) {
                let mut h = State::zeros();
                h[state] = 1.0;
                seen.measure(&h, noise);
            }
        }
        seen
    }
}

/// The filter on the mean of the driven wheels.
#[derive(Clone, Debug)]
pub struct DahlEkf {
    wheel: DahlWheel,
    filter: Gaussian<5>,
    /// σ₀ and μ to begin with.
    start: [f64; 2],
    started: bool,
    minimum_speed: f64,
    /// Variances of the measured v and ω.
    noise: [f64; 2],
}

impl DahlEkf {
    /// For this car and these sensors.
    pub fn new(car: &Car, sensors: &Sensors, minimum_speed: f64) -> Self {
        let omega = sensors.noise_std(Quantity::WheelSpeedFl);
        // Each is a mean of two wheels.
        let noise = [0.5 * (car.radius * omega).powi(2), 0.5 * omega * omega];
        Self::with(DahlWheel::new(car), noise, minimum_speed)
    }

    /// For this wheel; `noise` are the variances of v and ω, `minimum_speed` that below which nothing is
    /// estimated, m/s.
    pub fn with(wheel: DahlWheel, noise: [f64; 2], minimum_speed: f64) -> Self {
        let filter = Gaussian::new([0.0; 5], [1.0; 5]);
        Self {
            wheel,
            filter,
            start: TUNING.start.map(|(value, _)| value),
            started: false,
            minimum_speed,
            noise,
        }
    }

    /// Begins with this σ₀ (1/m) and μ instead of the usual ones.
    #[must_use]
    pub fn starting_from(mut self, stiffness: f64, friction: f64) -> Self {
        self.start = [stiffness, friction];
        self
    }

    /// Takes a sample. Without drive torque, with all wheels driven, while braking and at low speed the
    /// filter starts anew: its model knows no such thing.
    pub fn step(&mut self, now: &Kinematics, car: &Car) {
        let (Some(wheels), Some(speed), Some(torque)) = (now.wheels, now.speed, now.axle_torque) else {
            self.started = false;
            return;
        };
        if car.driven_axle == DrivenAxle::All || speed < self.minimum_speed || now.braking == Some(true) {
            self.started = false;
            return;
        }
        let driven = Wheel::ALL.into_iter().filter(|&wheel| car.driven_axle.drives(wheel));
        let omega = driven.map(|wheel| 0.5 * wheels[wheel as usize] / car.radius).sum();
        self.observe(0.5 * torque, speed, omega, now.elapsed_s);
    }

    /// Takes the torque of one wheel (N m), the speed (m/s) and the wheel's (rad/s), `elapsed_s` after the
    /// last ones.
    pub fn observe(&mut self, torque: f64, speed: f64, omega: f64, elapsed_s: f64) {
        let [sigma_std, mu_std] = TUNING.start.map(|(_, std)| std);
        let [sigma, mu] = self.start;
        if !self.started || elapsed_s > TUNING.gap_s || !self.filter.is_sound() {
            let std = [TUNING.deflection_std, self.noise[0].sqrt(), self.noise[1].sqrt(), sigma_std, mu_std];
            self.filter = Gaussian::new([0.0, speed, omega, sigma, mu], std);
            self.started = true;
            return;
        }
        self.predict(torque, elapsed_s);
        for (state, measured, noise) in [(V, speed, self.noise[0]), (OMEGA, omega, self.noise[1])] {
            self.filter.update_component(state, measured - self.filter.mean[state], noise);
        }
        for (state, (low, high)) in [SIGMA, MU].into_iter().zip(TUNING.limits) {
            self.filter.mean[state] = self.filter.mean[state].clamp(low, high);
        }
    }

    /// Discretized linearization (2.17–2.22): linearized at the mean, then stepped exactly.
    fn predict(&mut self, torque: f64, elapsed_s: f64) {
        let x = self.filter.mean;
        let jacobian = self.wheel.jacobian(&x);
        // In metres z is some thousand times smaller than what it acts on; in this unit it is of one size with ω,
        // and the exponential needs fewer doublings.
        let unit = (self.wheel.inertia / (self.wheel.load * x[SIGMA])).sqrt();
        let mut motion = jacobian.fixed_view::<3, 3>(0, 0).into_owned();
        scale(&mut motion, 1.0 / unit);
        let (mut turned, mut integral) = zero_order_hold_space(&motion, elapsed_s);
        scale(&mut turned, unit);
        scale(&mut integral, unit);
        // σ₀ and μ stay: they only act on the motion, as inputs that are held do.
        let mut transition = SMatrix::<f64, 3, 5>::zeros();
        transition.fixed_view_mut::<3, 3>(0, 0).copy_from(&turned);
        transition.fixed_view_mut::<3, 2>(0, 3).copy_from(&(integral * jacobian.fixed_view::<3, 2>(0, 3)));
        let moved = integral * self.wheel.rate(&x, torque).fixed_rows::<3>(0);
        for (mean, moved) in self.filter.mean.iter_mut().zip(&moved) {
            *mean += moved;
        }
        let noise = TUNING.walk.map(|walk| walk * walk * elapsed_s);
        self.filter.predict_covariance_of_moving(&transition, &noise);
    }

    /// μ of (8.7e): the friction used, whatever it was meant to be.
    pub fn friction(&self) -> Option<f64> {
        self.started.then(|| self.filter.mean[MU]).filter(|mu| mu.is_finite())
    }

    /// σ₀ of (8.7d), stiffness / load, 1/m.
    pub fn stiffness(&self) -> Option<f64> {
        self.started.then(|| self.filter.mean[SIGMA]).filter(|sigma| sigma.is_finite())
    }
}

/// The first of three states in a unit that is smaller by this factor.
fn scale(matrix: &mut Matrix3<f64>, factor: f64) {
    for i in 1..3 {
        matrix[(0, i)] *= factor;
        matrix[(i, 0)] /= factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;

    fn wheel() -> DahlWheel {
        DahlWheel { drag: 0.0, ..DahlWheel::new(&Car::new(&Vehicle::thesis())) }
    }

    #[test]
    fn the_jacobian_is_the_derivative() {
        let wheel = DahlWheel::new(&Car::new(&Vehicle::thesis()));
        let x = vector![0.003, 20.0, 64.9, 60.0, 0.5];
        let a = wheel.jacobian(&x);
        for i in 0..5 {
            let mut h = State::zeros();
            h[i] = 1e-6 * x[i];
            let difference = (wheel.rate(&(x + h), 300.0) - wheel.rate(&(x - h), 300.0)) / (2.0 * h[i]);
            assert!((difference - a.column(i)).norm() < 1e-5 * (1.0 + a.column(i).norm()), "state {i}");
        }
    }

    /// Relative standard deviations of σ₀ and μ that one second of a drive allows at best.
    fn best(wheel: &DahlWheel, x: State, torque: impl Fn(f64) -> f64) -> [f64; 2] {
        let torques: Vec<f64> = (0..1000).map(|i| torque(f64::from(i) * 1e-3)).collect();
        let spectrum = wheel.observability(x, &torques, 1e-3, [1e-3, 1e-2]).spectrum(&x.map(f64::abs));
        [SIGMA, MU].map(|i| spectrum.bound(i))
    }

    #[test]
    fn steady_slip_tells_the_friction_used_and_nothing_of_the_stiffness() {
        let wheel = wheel();
        let used = 0.2;
        let sliding = |sigma: f64| vector![used / sigma, 20.0, 20.1 / wheel.radius, sigma, used];
        let v_rate = used * wheel.load / wheel.mass;
        let steady = wheel.radius * used * wheel.load + wheel.inertia * v_rate / wheel.radius;
        let [sigma, mu] = best(&wheel, sliding(60.0), |_| steady);
        assert!(sigma > 300.0 && mu < 0.05, "{sigma} {mu}");
        // A wheel that is pushed to and fro below its limit tells both.
        let sticking = vector![1e-6, 20.0, 20.0 / wheel.radius, 60.0, 0.3];
        let [sigma, mu] = best(&wheel, sticking, |t| 300.0 * (12.0 * t).sin());
        assert!(sigma < 0.2 && mu < 0.2, "{sigma} {mu}");
    }

    /// The tire of the filter's own model, driven to and fro below its limit: then it can.
    #[test]
    fn fast_transients_of_a_true_dahl_tire_give_both() {
        let wheel = wheel();
        let mut filter = DahlEkf::with(wheel, [1e-6, 1e-5], 1.0);
        let mut x = vector![0.0, 20.0, 20.0 / wheel.radius, 80.0, 0.35];
        for i in 0..60_000 {
            let torque = 340.0 * (f64::from(i) * 1e-3 * 9.0).sin();
            x = wheel.advance(&x, torque, 1e-3);
            if i % 10 == 9 {
                filter.observe(torque, x[V], x[OMEGA], 0.01);
            }
        }
        let (sigma, mu) = (filter.stiffness().unwrap(), filter.friction().unwrap());
        assert!((sigma / 80.0 - 1.0).abs() < 0.15 && (mu / 0.35 - 1.0).abs() < 0.15, "{sigma} {mu}");
    }
}
