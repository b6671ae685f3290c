//! What forces and slip angles of both axles say of the friction.
//!
//! A tire bends away from its tangent, the sooner the less friction there is. A bank of filters, one for each friction and
//! shape of the curve, has that written into it: each has a lateral velocity and stiffnesses of its own and predicts both
//! axles' forces. How well it did in the last seconds is the evidence for its friction (dynamic model averaging with
//! forgetting: Raftery, Kárný and Ettler 2010). Forgetting keeps small errors that every model has from adding up
//! over minutes, and a long steady curve from counting more than once; [`Belief`](super::belief::Belief) remembers longer.
//!
//! Only the upper end of the friction is told by it. What a road gives at least is what was used of it.

mod curve;
mod filter;
#[cfg(all(test, feature = "simulation"))]
#[cfg(test)]
mod tests;
mod window;

use self::curve::{Curves, SHAPES};
use self::filter::{ANGLE, BANK, FRONT, Filter, Noise, REAR, STATES, Surface, VY};
use self::window::{Window, Windows};
use super::kinematics::{Car, Kinematics};
use super::motion::{Known, LateralMotion};
use crate::filter::{Gaussian, LearnedNoise, likeliest};
use crate::model::GRAVITY;

/// How many frictions.
const FRICTIONS: usize = 26;
/// The lowest and the highest of them; each is larger by the same factor than the one before.
const LOWEST: f64 = 0.06;
const HIGHEST: f64 = 1.35;

/// Tuned with eighty drives of the test `campaign`, of other seeds than those of its table. Most numbers may be halved or
/// doubled without much change; `unmodelled` may not: with five times as much, ice is seen on dry roads. `fit` and `apart` were
/// set by recorded drives of a Golf GTI, on which no interval excludes what the car uses in the next ten seconds (test
/// `real_cars`), and with `unbraked_s` and `used` by the test `long_drives`.
struct Tuning {
    /// The evidence is that of so many seconds.
    memory_s: f64,
    /// Windows whose errors are one and the same: what a model has wrong repeats itself.
    repeated: f64,
    /// What two axles leave out of a car: normalized force at least, …
    crude: f64,
    /// … share of the force, …
    crude_share: f64,
    /// … and by how much sensors and tires may be late, s.
    late_s: f64,
    /// Unmodelled lateral acceleration, m/s²/√Hz. With more, a car that slides could have any slip angle.
    unmodelled: f64,
    /// Stiffnesses are known from the data sheet to these shares of themselves: at least, at most.
    stiffness_std: (f64, f64),
    /// Stiffnesses and the angle's offset tend to what is known of them within this time, s.
    tends_s: f64,
    /// What is left of the offset of the road wheel angle, rad.
    angle_std: f64,
    /// Gravity's part along the cross slope, m/s², and how long it lasts, s.
    bank: (f64, f64),
    /// Lateral velocity of which nothing is known yet, m/s.
    unknown_vy: f64,
    /// Deviation of a longitudinal force, over the load and as a share of itself: no friction is below it.
    along_std: (f64, f64),
    /// NIS counts up to this.
    clip: f64,
    /// A filter less likely than the likeliest by this logarithm starts again from that one.
    hopeless: f64,
    /// Windows that the learned noise remembers.
    noise_memory: f64,
    /// Evidence counts when the car has been driving for so long, s, …
    starts_s: f64,
    /// … when the likeliest filter's NIS has this mean at most, over this time, s, …
    fit: (f64, f64),
    /// … or this mean while both axles slide, …
    sliding_fit: f64,
    /// … when no single wheel was braked for so long, s, which turns the car without any slip angle, …
    unbraked_s: f64,
    /// … when an axle used this much lately: curves that are hardly begun say nothing, …
    used: f64,
    /// … while its motion is not this many deviations apart from the one that is published, …
    apart: f64,
    /// … which has this deviation at least, as a share of the speed, …
    motion_std: f64,
    /// … and the stiffnesses are so many deviations from the data sheet at most.
    implausible: f64,
    /// Beyond this slip angle any tire slides, rad. Physical: twice that of the greatest force.
    slides: f64,
    /// With a mean NIS beyond this the bank has lost the motion, and starts again.
    lost: f64,
    /// A window after a longer gap starts the motion again, s.
    gap_s: f64,
}

const TUNING: Tuning = Tuning {
    memory_s: 5.0,
    repeated: 5.0,
    crude: 0.02,
    crude_share: 0.1,
    late_s: 0.05,
    unmodelled: 0.02,
    stiffness_std: (0.1, 0.18),
    tends_s: 200.0,
    angle_std: 0.003,
    bank: (0.3, 20.0),
    unknown_vy: 0.5,
    along_std: (0.03, 0.05),
    clip: 16.0,
    hopeless: 12.0,
    noise_memory: 400.0,
    starts_s: 1.0,
    fit: (0.1, 1.0),
    sliding_fit: 0.2,
    unbraked_s: 4.0,
    used: 0.1,
    apart: 1.0,
    motion_std: 0.01,
    implausible: 3.5,
    slides: 0.2,
    lost: 0.4,
    gap_s: 0.1,
};

/// How likely each friction made the last seconds, against the likeliest; all below that one are as likely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Likelihood {
    ln: [f64; FRICTIONS],
}

impl Likelihood {
    /// Of this friction.
    pub fn of(&self, friction: f64) -> f64 {
        let steps = (FRICTIONS - 1) as f64;
        let place = (friction / LOWEST).ln() / (HIGHEST / LOWEST).ln() * steps;
        let place = place.clamp(0.0, steps);
        let step = (place as usize).min(FRICTIONS - 2);
        let beyond = place - step as f64;
        (self.ln[step] + beyond * (self.ln[step + 1] - self.ln[step])).exp()
    }
}

/// The bank. Never allocates after construction.
#[derive(Clone, Debug)]
pub struct SaturatingTires {
    car: Car,
    /// What is known before anything is measured.
    prior: Gaussian<STATES>,
    curves: Curves,
    frictions: [f64; FRICTIONS],
    filters: Box<[[Filter; SHAPES]; FRICTIONS]>,
    /// Logarithms of the likelihoods of the last seconds; that of the likeliest is zero.
    evidence: [[f64; SHAPES]; FRICTIONS],
    /// Of front and rear force, by the innovations of the likeliest filter.
    learned: [LearnedNoise; 2],
    /// The largest force of an axle over its load in these seconds.
    used: f64,
    /// Mean NIS of the likeliest filter.
    fit: f64,
    /// By the likeliest filter, both axles slide.
    slides: bool,
    windows: Windows,
    minimum_speed: f64,
    /// For how long the car has been driving, s.
    driving_s: f64,
    /// Since a single wheel was last braked, s.
    unbraked_s: f64,
    likelihood: Option<Likelihood>,
}

impl SaturatingTires {
    /// Nothing is known but the data sheet; below `minimum_speed` (m/s) nothing is learned.
    pub fn new(car: &Car, minimum_speed: f64) -> Self {
        let ratio = (HIGHEST / LOWEST).ln() / (FRICTIONS - 1) as f64;
        let prior = prior(car);
        let filter = Filter { state: prior };
        Self {
            frictions: std::array::from_fn(|i| LOWEST * (ratio * i as f64).exp()),
            filters: Box::new(std::array::from_fn(|_| std::array::from_fn(|_| filter.clone()))),
            evidence: [[0.0; SHAPES]; FRICTIONS],
            learned: [LearnedNoise::new(TUNING.noise_memory); 2],
            used: 0.0,
            fit: 0.0,
            slides: false,
            windows: Windows::default(),
            minimum_speed,
            driving_s: 0.0,
            unbraked_s: f64::INFINITY,
            likelihood: None,
            curves: Curves::new(),
            prior,
            car: car.clone(),
        }
    }

    /// Takes a sample, the acceleration along the car (m/s²) where it is known, the motion that is published, what is known of
    /// the sensors' offsets, and the noise of single readings of yaw rate (rad/s) and lateral acceleration (m/s²).
    pub fn step(
        &mut self,
        now: &Kinematics,
        along: Option<f64>,
        motion: Option<LateralMotion>,
        known: &Known,
        white: [f64; 2],
    ) {
        self.likelihood = None;
        let Some(cornering) = now.cornering(self.minimum_speed).filter(|_| now.elapsed_s < TUNING.gap_s)
        else {
            self.stop();
            return;
        };
        let along = along.map_or(0.0, |a| self.car.longitudinal_force(a, cornering.speed));
        let along = self.car.axle_forces(along);
        let offsets = known.offsets.map(|offset| offset.value);
        self.unbraked_s = if known.is_braked { 0.0 } else { self.unbraked_s + now.elapsed_s };
        let ended = self.windows.step(&self.car, &cornering, now, along, offsets);
        let Some(window) = ended else { return };
        if self.driving_s == 0.0 || self.fit > TUNING.lost {
            self.driving_s = 0.0;
            self.surface_changed();
            self.start(&window, motion);
        }
        self.driving_s += window.elapsed_s;
        self.update(&window, white);
        let likeliest = &self.filters.as_flattened()[self.best()];
        let slides = |axle| likeliest.slip(axle, &window, &self.car).1.abs() > TUNING.slides;
        self.slides = slides(0) && slides(1);
        if self.unbraked_s < TUNING.unbraked_s {
            self.surface_changed();
        } else if self.tells(&window, &likeliest.state, motion) {
            self.likelihood = Some(self.of_frictions());
        }
    }

    /// What the last seconds say, at a sample that ends a window.
    pub fn likelihood(&self) -> Option<Likelihood> {
        self.likelihood
    }

    /// Do both axles slide? Then sensors seem to contradict each other, for no wheel rolls where it points.
    pub fn slides(&self) -> bool {
        self.slides
    }

    /// The road is another one: the last seconds say nothing of it.
    pub fn surface_changed(&mut self) {
        self.evidence = [[0.0; SHAPES]; FRICTIONS];
        self.likelihood = None;
    }

    /// The car stands, or a sensor is not to be believed: the motion is unknown.
    pub fn stop(&mut self) {
        self.windows = Windows::default();
        self.driving_s = 0.0;
        self.slides = false;
        self.surface_changed();
    }

    fn start(&mut self, now: &Window, motion: Option<LateralMotion>) {
        self.fit = 0.0;
        let vy = self.car.steady_lateral_velocity(now.speed, now.yaw_rate, now.force[1] * GRAVITY);
        let (vy, std) = motion.map_or((vy, TUNING.unknown_vy), |motion| published(motion, now));
        for filter in self.filters.as_flattened_mut() {
            filter.state.forget(VY, vy, std);
        }
    }

    fn update(&mut self, now: &Window, white: [f64; 2]) {
        let promised = self.promised(now, white);
        let repeated = |axle: usize| {
            let learned = self.learned[axle].variance(promised[axle]);
            learned.max(promised[axle]) * TUNING.repeated
        };
        let noise = Noise { variance: [repeated(0), repeated(1)], unmodelled: TUNING.unmodelled };
        let kept = (-now.elapsed_s / TUNING.memory_s).exp();
        self.used = now.force.into_iter().fold(kept * self.used, |most, force| most.max(force.abs()));
        let best = self.best();
        let prior = self.prior;
        let share = now.elapsed_s / TUNING.tends_s;
        let filters = self.filters.as_flattened_mut().iter_mut().zip(self.evidence.as_flattened_mut());
        for (place, (filter, evidence)) in filters.enumerate() {
            let surface = Surface { friction: self.frictions[place / SHAPES], shape: place % SHAPES };
            filter.predict(now, &noise);
            for i in [FRONT, REAR, ANGLE] {
                filter.state.tend(i, prior.mean[i], prior.std(i), share);
            }
            filter.state.tend(BANK, 0.0, TUNING.bank.0, now.elapsed_s / TUNING.bank.1);
            let innovations = filter.update(surface, now, &self.car, &self.curves, &noise);
            *evidence = kept * *evidence - beyond(now, surface.friction);
            for (axle, innovation) in innovations.iter().enumerate() {
                let variance = innovation.variance / promised[axle];
                *evidence -= 0.5 * (innovation.nis().min(TUNING.clip) + variance.ln());
                if place == best {
                    self.learned[axle].learn(innovation, promised[axle]);
                }
            }
            if place == best {
                let nis = 0.5 * (innovations[0].nis() + innovations[1].nis());
                self.fit += (nis - self.fit) * (now.elapsed_s / TUNING.fit.1);
            }
        }
        self.begin_again();
    }

    /// Evidence against the likeliest; and who is far behind that one begins again with its motion.
    fn begin_again(&mut self) {
        let prior = self.prior;
        let best = self.best();
        let (most, state) = (self.evidence.as_flattened()[best], self.filters.as_flattened()[best].state);
        let filters = self.filters.as_flattened_mut().iter_mut().zip(self.evidence.as_flattened_mut());
        for (filter, evidence) in filters {
            *evidence -= most;
            // Not a number is hopeless, too.
            if !(*evidence >= -TUNING.hopeless && filter.state.is_sound()) {
                *evidence = -TUNING.hopeless;
                filter.state = if state.is_sound() { state } else { prior };
                for i in [FRONT, REAR] {
                    filter.state.forget(i, prior.mean[i], prior.std(i));
                }
            }
        }
    }

    /// Variance of the normalized forces in a window: of the sensors, and of what two axles leave out.
    fn promised(&self, now: &Window, white: [f64; 2]) -> [f64; 2] {
        let yaw_acceleration = white[0] * (2.0 / now.samples).sqrt() / (2.0 * now.elapsed_s);
        let [across, turning] =
            [window::axle_forces(&self.car, 1.0, 0.0), window::axle_forces(&self.car, 0.0, 1.0)];
        std::array::from_fn(|axle| {
            let model = TUNING
                .crude
                .hypot(TUNING.crude_share * now.force[axle])
                .hypot(TUNING.late_s * now.force_rate[axle]);
            let sensors =
                (across[axle] * white[1] / now.samples.sqrt()).hypot(turning[axle] * yaw_acceleration);
            sensors.hypot(model).powi(2)
        })
    }

    /// Does the likeliest filter describe this car at all?
    fn tells(&self, now: &Window, state: &Gaussian<STATES>, motion: Option<LateralMotion>) -> bool {
        let agrees = |motion| {
            let (vy, std) = published(motion, now);
            (state.mean[VY] - vy).abs() < TUNING.apart * std
        };
        let prior = &self.prior;
        let is_plausible =
            |i: usize| (state.mean[i] - prior.mean[i]).abs() < TUNING.implausible * prior.std(i);
        self.driving_s > TUNING.starts_s
            && self.used > TUNING.used
            && motion.is_some_and(agrees)
            && self.fit < if self.slides { TUNING.sliding_fit } else { TUNING.fit.0 }
            && [FRONT, REAR].into_iter().all(is_plausible)
    }

    /// All shapes of a friction together.
    fn of_frictions(&self) -> Likelihood {
        let mut ln = self.evidence.map(|shapes| shapes.map(f64::exp).iter().sum::<f64>().ln());
        let best = likeliest(&ln);
        let most = ln[best];
        for (i, ln) in ln.iter_mut().enumerate() {
            *ln = if i < best { 0.0 } else { *ln - most };
        }
        Likelihood { ln }
    }

    fn best(&self) -> usize {
        likeliest(self.evidence.as_flattened())
    }
}

/// The lateral velocity that is published, and how far it may be off, m/s.
fn published(motion: LateralMotion, now: &Window) -> (f64, f64) {
    (motion.lateral_velocity, motion.lateral_velocity_std.hypot(TUNING.motion_std * now.speed))
}

/// What speaks against a friction by longitudinal forces beyond it.
fn beyond(now: &Window, friction: f64) -> f64 {
    let of = |along: f64| {
        let std = TUNING.along_std.0.hypot(TUNING.along_std.1 * along);
        ((along.abs() - friction).max(0.0) / std).powi(2).min(TUNING.clip)
    };
    0.5 * (of(now.along[0]) + of(now.along[1])) / TUNING.repeated
}

/// What is known before anything is measured.
fn prior(car: &Car) -> Gaussian<STATES> {
    let (mut mean, mut std) = ([0.0; STATES], [0.0; STATES]);
    let (least, most) = TUNING.stiffness_std;
    for ((value, deviation), i) in car.cornering_prior.into_iter().zip([FRONT, REAR]) {
        (mean[i], std[i]) = (value.ln(), (deviation / value).clamp(least, most));
    }
    std[VY] = TUNING.unknown_vy;
    std[ANGLE] = TUNING.angle_std;
    std[BANK] = TUNING.bank.0;
    Gaussian::new(mean, std)
}
