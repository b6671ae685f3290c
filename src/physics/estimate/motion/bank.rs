//! The filters, one for each friction.

use crate::estimate::kinematics::{Car, Turning};
use crate::estimate::lateral_filter::hypothesis::{Hypothesis, Noise, Readings};
use crate::estimate::lateral_filter::model::{
    ANGLE, ANGLE_OFFSET, ANGLE_RATE, AY_OFFSET, BANK, FRICTION, FRONT, Inputs, Model, REAR, STATES, VY, YAW,
    YAW_OFFSET,
};
use crate::estimate::motion::LateralMotion;
use crate::estimates::Estimate;
use crate::filter::{Gaussian, LearnedNoise, likeliest};
use crate::model::tire::{Brush, Tire};

/// How many.
const COUNT: usize = 5;

/// Tuned with the tests `motion` (noisy, late and offset sensors) and `long_drives` (banks, single brakes). What sensors and roads are at all is as in
/// [`CorneringConfig`](crate::estimate::CorneringConfig).
struct Tuning {
    /// The frictions: each from the one before by a factor within which a filter follows on its own, …
    frictions: [f64; COUNT],
    /// … by this standard deviation of its logarithm.
    friction_std: f64,
    /// How likely each is where nothing is known: most driving is on dry or wet asphalt. A car that turns steadily and
    /// slides is rarer than one that turns.
    prior: [f64; COUNT],
    /// How long a surface lasts, s.
    lasts_s: f64,
    /// Samples whose errors are one and the same: of yaw rate and lateral acceleration.
    repeated: [f64; 2],
    /// What a single track leaves out of a yaw rate, rad/s, and of a lateral acceleration, m/s².
    crude: [f64; 2],
    /// Stiffnesses and friction tend to what else is known of them within this time, s.
    tends_s: f64,
    /// That is uncertain by this at least, and a data sheet's by that at most, relative.
    stiffness_std: (f64, f64),
    /// Unmodelled lateral acceleration, m/s²/√Hz, and yaw acceleration, rad/s²/√Hz.
    unmodelled: [f64; 2],
    /// … while a single wheel is braked.
    braked: f64,
    /// Offsets before anything is measured: road wheel angle rad, lateral acceleration m/s², yaw rate rad/s.
    offsets: [f64; 3],
    /// What else is known of them is uncertain by this share of that at least.
    offset_trust: f64,
    /// Gravity's part along the cross slope, m/s², and how long it lasts, s.
    bank: (f64, f64),
    /// Motion of which nothing is known yet: lateral velocity m/s, yaw rate rad/s, angle rad, its rate rad/s.
    unknown_motion: [f64; 4],
    /// A filter with less of its prior weight than this starts again from the likeliest one.
    hopeless: f64,
    /// NIS of a sample counts up to this.
    clip: f64,
    /// Samples that the learned noise remembers.
    noise_memory: f64,
    /// A correlation of innovations that white noise shows by chance is none.
    by_chance: f64,
}

const TUNING: Tuning = Tuning {
    frictions: [0.25, 0.4, 0.6, 0.85, 1.1],
    friction_std: 0.15,
    prior: [0.05, 0.1, 0.2, 0.3, 0.35],
    lasts_s: 150.0,
    repeated: [6.0, 3.0],
    crude: [0.01, 1.0],
    tends_s: 8.0,
    stiffness_std: (0.1, 0.25),
    unmodelled: [0.1, 0.1],
    braked: 1.0,
    offsets: [0.01, 0.1, 0.01],
    offset_trust: 0.2,
    bank: (0.4, 20.0),
    unknown_motion: [0.5, 0.1, 0.1, 0.5],
    hopeless: 5e-4,
    clip: 16.0,
    noise_memory: 1000.0,
    by_chance: 1.15,
};

/// What the windowed estimator knows.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Normalized cornering stiffness front and rear, 1/rad, if it knows more than the data sheet.
    pub stiffness: [Option<Estimate>; 2],
    /// Offsets of road wheel angle (rad), lateral acceleration (m/s²) and yaw rate (rad/s).
    pub offsets: [Estimate; 3],
    /// A single wheel is braked and turns the car.
    pub is_braked: bool,
}

/// Filters with their weights.
#[derive(Clone, Debug)]
pub struct Bank {
    car: Car,
    model: Model,
    filters: [Hypothesis; COUNT],
    weights: [f64; COUNT],
    /// Nothing was measured yet.
    is_fresh: bool,
    /// Of yaw rate and lateral acceleration, by the innovations of the likeliest filter.
    learned: [LearnedNoise; 2],
}

impl Bank {
    /// Nothing is known but the data sheet.
    pub fn new(car: &Car) -> Self {
        Self {
            model: Model::new(car, Tire::Brush(Brush)),
            filters: TUNING.frictions.map(|friction| Hypothesis { state: prior(car, friction) }),
            weights: TUNING.prior,
            is_fresh: true,
            learned: [LearnedNoise::new(TUNING.noise_memory); 2],
            car: car.clone(),
        }
    }

    /// The car's equations.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The state of the likeliest filter.
    pub fn likeliest(&self) -> &Gaussian<STATES> {
        &self.filters[self.best()].state
    }

    /// What to expect of the readings, by their white noise (variances), and of the road.
    pub fn noise(&self, white: [f64; 2], angle: f64, is_braked: bool) -> Noise {
        let [yaw_rate, acceleration] = std::array::from_fn(|i| {
            let learned = &self.learned[i];
            let redundancy = learned.redundancy();
            let repeated = if redundancy < TUNING.by_chance { 1.0 } else { redundancy };
            let white = learned.variance(white[i]).max(white[i]) * repeated * TUNING.repeated[i];
            white + TUNING.crude[i].powi(2)
        });
        let [lateral, mut moment] = TUNING.unmodelled.map(|density| density * density);
        if is_braked {
            moment = TUNING.braked.powi(2);
        }
        Noise { yaw_rate, acceleration, angle, lateral, moment }
    }

    /// The motion is not known, tires and sensors are.
    pub fn start(&mut self, now: &Turning, known: &Known) {
        let fresh = std::mem::take(&mut self.is_fresh);
        let acceleration = now.lateral_acceleration.unwrap_or(now.speed * now.yaw_rate);
        let vy = self.car.steady_lateral_velocity(now.speed, now.yaw_rate, acceleration);
        let means = [vy, now.yaw_rate, now.road_angle, 0.0];
        for filter in &mut self.filters {
            let places = [VY, YAW, ANGLE, ANGLE_RATE].into_iter();
            for ((i, mean), std) in places.zip(means).zip(TUNING.unknown_motion) {
                filter.state.forget(i, mean, std);
            }
            if fresh {
                let tires = [FRONT, REAR].into_iter().zip(tires(&self.car, known));
                for (i, (mean, std)) in tires.chain(OFFSETS.into_iter().zip(offsets(known))) {
                    filter.state.forget(i, mean, std);
                }
            }
        }
    }

    /// From the last sample to this one. `steering`: spectral density of the steering's angular acceleration,
    /// rad²/s³.
    pub fn predict(
        &mut self,
        before: &Inputs,
        now: &Inputs,
        elapsed_s: f64,
        noise: &Noise,
        steering: f64,
        known: &Known,
    ) {
        let share = elapsed_s / TUNING.tends_s;
        let (bank_std, bank_s) = TUNING.bank;
        let (tires, offsets) = (tires(&self.car, known), offsets(known));
        for (filter, friction) in self.filters.iter_mut().zip(TUNING.frictions) {
            filter.predict(&self.model, before, now, elapsed_s, noise, steering);
            filter.fade_bank(bank_std * bank_std, bank_s, elapsed_s);
            let state = &mut filter.state;
            for (i, (mean, std)) in [FRONT, REAR].into_iter().zip(tires) {
                state.tend(i, mean, std, share);
            }
            state.tend(FRICTION, friction.ln(), TUNING.friction_std, share);
            for (i, (mean, std)) in OFFSETS.into_iter().zip(offsets) {
                state.tend(i, mean, std, share);
            }
        }
    }

    /// Takes a sample's readings; `white`: white noise of yaw rate and lateral acceleration.
    pub fn update(
        &mut self,
        now: &Inputs,
        readings: &Readings,
        noise: &Noise,
        white: [f64; 2],
        elapsed_s: f64,
    ) {
        let best = self.best();
        let mut ln = [0.0; COUNT];
        for (place, (filter, ln)) in self.filters.iter_mut().zip(&mut ln).enumerate() {
            let verdict = filter.update(&self.model, now, readings, noise);
            for (i, innovation) in [Some(verdict.yaw_rate), verdict.acceleration].into_iter().enumerate() {
                let Some(innovation) = innovation else { continue };
                *ln -= 0.5 * (innovation.nis().min(TUNING.clip) + innovation.variance.ln());
                if place == best {
                    self.learned[i].learn(&innovation, white[i]);
                }
            }
        }
        self.weigh(&ln, elapsed_s);
    }

    /// Bayes's rule; and the road may have become another one.
    fn weigh(&mut self, ln: &[f64; COUNT], elapsed_s: f64) {
        let most = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for (weight, ln) in self.weights.iter_mut().zip(ln) {
            *weight *= (ln - most).exp();
        }
        let sum: f64 = self.weights.iter().sum();
        let changed = (elapsed_s / TUNING.lasts_s).min(1.0);
        for (weight, prior) in self.weights.iter_mut().zip(TUNING.prior) {
            *weight = (1.0 - changed) * *weight / sum + changed * prior;
        }
        let state = *self.likeliest();
        for ((filter, friction), (weight, prior)) in
            self.filters.iter_mut().zip(TUNING.frictions).zip(self.weights.iter().zip(TUNING.prior))
        {
            if *weight < TUNING.hopeless * prior {
                filter.state = state;
                filter.state.forget(FRICTION, friction.ln(), TUNING.friction_std);
            }
        }
    }

    /// The mixture's motion.
    pub fn motion(&self, inputs: &Inputs) -> LateralMotion {
        let mut vy = 0.0;
        let mut slip_angles = [0.0; 2];
        for (weight, filter) in self.weights.iter().zip(&self.filters) {
            let x = &filter.state.mean;
            vy += weight * x[VY];
            let angles = [x[ANGLE], inputs.rear_angle];
            let slips = self.car.slip_angles(inputs.speed, x[VY], x[YAW], angles);
            slip_angles.iter_mut().zip(slips).for_each(|(sum, slip)| *sum += weight * slip);
        }
        let mut variance = 0.0;
        for (weight, filter) in self.weights.iter().zip(&self.filters) {
            let own = filter.state.std(VY);
            variance += weight * (own * own + (filter.state.mean[VY] - vy).powi(2));
        }
        LateralMotion { lateral_velocity: vy, lateral_velocity_std: variance.sqrt(), slip_angles }
    }

    /// Numbers are numbers.
    pub fn is_sound(&self) -> bool {
        self.filters.iter().all(|filter| filter.state.is_sound())
            && self.weights.iter().all(|weight| weight.is_finite())
    }

    fn best(&self) -> usize {
        likeliest(&self.weights)
    }
}

fn prior(car: &Car, friction: f64) -> Gaussian<STATES> {
    let (mut mean, mut std) = ([0.0; STATES], [0.0; STATES]);
    for (known, i) in car.cornering_prior.into_iter().zip([FRONT, REAR]) {
        (mean[i], std[i]) = tire(known);
    }
    (mean[FRICTION], std[FRICTION]) = (friction.ln(), TUNING.friction_std);
    for (i, offset) in OFFSETS.into_iter().zip(TUNING.offsets) {
        std[i] = offset;
    }
    std[BANK] = TUNING.bank.0;
    Gaussian::new(mean, std)
}

/// Their places in the state.
const OFFSETS: [usize; 3] = [ANGLE_OFFSET, AY_OFFSET, YAW_OFFSET];

/// The logarithms of both axles' stiffnesses and their deviations, by what was measured or else by the data sheet.
fn tires(car: &Car, known: &Known) -> [(f64, f64); 2] {
    std::array::from_fn(|axle| {
        tire(known.stiffness[axle].map_or(car.cornering_prior[axle], |known| (known.value, known.std)))
    })
}

fn tire((value, std): (f64, f64)) -> (f64, f64) {
    let (least, most) = TUNING.stiffness_std;
    (value.ln(), (std / value).clamp(least, most))
}

/// The sensors' offsets and their deviations.
fn offsets(known: &Known) -> [(f64, f64); 3] {
    std::array::from_fn(|sensor| {
        let Estimate { value, std, .. } = known.offsets[sensor];
        let most = TUNING.offsets[sensor];
        (value, std.clamp(TUNING.offset_trust * most, most))
    })
}
