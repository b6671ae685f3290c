//! Slip slope of all wheels together, where none rolls freely: with all wheels driven.
//!
//! No wheel tells the speed, so the accelerometer carries it on, while driving and while braking. The filter has five
//! states: the speed v; what the accelerometer does not feel, β (the grade and its own offset); its error of gain, γ
//! (the nose dives in braking); its delay against the wheel speeds, d; and the compliance c. With the wheels' mean
//! speed W, the measured acceleration a and the normalized force μ of all tires
//!
//! v' = (1 + γ) a + β,  W = v − d a + c (1 + μ / 3 mu_max) μ W
//!
//! A slip and a delay differ by the speed only: c μ W grows with it, d a does not. One braking says little, several
//! from different speeds say more; the covariance accounts for that. The force accelerates the car and overcomes the
//! air: an accelerometer feels it on any grade. The mean of four slips is the mean force over the stiffness, however
//! brakes and drive share it out, if the tires are alike.
//!
//! Two such filters run side by side. The compliance of the steady one hardly walks, that of the quick one walks
//! fast. When the quick one contradicts the steady one the surface has changed, and the steady one starts from the
//! quick one's state.
//!
//! (No source: the thesis's car has an undriven axle. The bend of the curve is its brush model's, thesis 4.2.)

use nalgebra::{SMatrix, SVector, vector};

use super::config::SlopeConfig;
use super::kinematics::{Car, Kinematics};
use super::learned::{Known, Learned};
use crate::estimates::Estimate;
use crate::filter::{Gaussian, LearnedNoise};
use crate::model::GRAVITY;
use crate::{Quantity, Sensors, Wheel};

/// Tuned with the test `all_driven`.
struct Tuning {
    /// Samples that the learned noise remembers.
    noise_memory: f64,
    /// What of a slope no filter knows, relative: how the curve bends, how tires differ, and what load makes of
    /// them.
    model_std: f64,
    /// Normalized force along the car from which a slope can be told, and up to which the curve is hardly bent.
    telling: (f64, f64),
    /// Friction that bends the curve.
    bending: f64,
    /// After a gap this long nobody knows the speed, s.
    gap_s: f64,
    /// How the compliances walk, as shares of themselves, 1/√s: the steady one's and the quick one's.
    walks: [f64; 2],
    /// The quick filter contradicts the steady one beyond so many deviations (by chance one sample in 2,000), for
    /// so long, s.
    contradiction: (f64, f64),
    /// Before anything is measured: speed, m/s, what is not felt, m/s², its gain, its delay, s.
    start_std: [f64; 4],
    /// How the grade walks, m/s² / √s: a hill within some seconds.
    grade_walk: f64,
    /// At a standstill or in a gap another grade may begin, m/s².
    other_grade_std: f64,
    /// The dive of a car that is loaded otherwise is another one, 1/√s.
    gain_walk: f64,
    /// Residuals count up to so many deviations.
    clip: f64,
    /// A compliance walks up to this uncertainty, relative, …
    walks_up_to: f64,
    /// … and as if it were no smaller than the stiffest tire's.
    stiffest: f64,
}

const TUNING: Tuning = Tuning {
    noise_memory: 1000.0,
    model_std: 0.1,
    telling: (0.08, 0.25),
    bending: 0.8,
    gap_s: 0.25,
    walks: [0.005, 0.06],
    contradiction: (3.5, 1.0),
    start_std: [1.0, 0.5, 0.03, 0.025],
    grade_walk: 0.05,
    other_grade_std: 0.3,
    gain_walk: 2e-4,
    clip: 3.0,
    walks_up_to: 0.5,
    stiffest: 1.0 / 200.0,
};

/// The filters of all wheels.
#[derive(Clone, Debug)]
pub struct OverallSlope {
    steady: Carried,
    quick: Carried,
    noise: LearnedNoise,
    car: Car,
    config: SlopeConfig,
    minimum_speed: f64,
    wheel_noise: f64,
    acceleration_noise: f64,
    /// The speed is one that is carried on.
    is_rolling: bool,
    age_s: f64,
    informed: bool,
    /// For how long the quick filter has contradicted the steady one, s.
    contradicted_s: f64,
    settled: Option<Known>,
}

impl OverallSlope {
    /// Starts from the vehicle's prior.
    pub fn new(car: &Car, sensors: &Sensors, config: &SlopeConfig, minimum_speed: f64) -> Self {
        let (slope, std) = Self::prior(car);
        let start = Carried::new(slope, (std / slope).max(SlopeConfig::SURFACE_STD));
        Self {
            steady: start,
            quick: start,
            noise: LearnedNoise::new(TUNING.noise_memory),
            // The mean of four.
            wheel_noise: 0.5 * car.radius * sensors.noise_std(Quantity::WheelSpeedFl),
            acceleration_noise: sensors.noise_std(Quantity::LongitudinalAcceleration),
            car: car.clone(),
            config: config.clone(),
            minimum_speed,
            is_rolling: false,
            age_s: 0.0,
            informed: false,
            contradicted_s: 0.0,
            settled: None,
        }
    }

    /// The data sheet's, of a wheel under a quarter of the car's weight.
    fn prior(car: &Car) -> (f64, f64) {
        let share = 0.25 * car.mass * GRAVITY / car.load(Wheel::Fl);
        let (slope, std) = car.slope_prior[0];
        (slope / share, std / share)
    }

    /// A wheel's slope over that of one under a quarter of the car's weight. The tires are alike, the loads are not;
    /// and stiffness grows with load, somewhere between not at all and as much.
    fn share(car: &Car, wheel: Wheel) -> f64 {
        (0.25 * car.mass * GRAVITY / car.load(wheel)).sqrt()
    }

    /// Takes up what an earlier drive learned, less surely. Before the first sample only.
    pub fn restore(&mut self, learned: &Learned) {
        let Some(known) = learned.slope[Wheel::Fl as usize] else { return };
        let share = Self::share(&self.car, Wheel::Fl);
        let slope = Known { value: known.value / share, std: known.std / share };
        let start = Carried::new(slope.value, self.config.earlier_std(slope));
        (self.steady, self.quick) = (start, start);
        self.settled = Some(slope);
    }

    /// Puts into `learned` what outlives the drive.
    pub fn learn(&self, learned: &mut Learned) {
        let Some(settled) = self.settled else { return };
        for (wheel, slope) in Wheel::ALL.into_iter().zip(&mut learned.slope) {
            let share = Self::share(&self.car, wheel);
            *slope = Some(Known { value: share * settled.value, std: share * settled.std });
        }
    }

    /// Takes a sample; returns whether the surface seems to have changed.
    pub fn step(&mut self, now: &Kinematics) -> bool {
        self.age_s += now.elapsed_s;
        let (Some(felt), Some(seen)) = (now.longitudinal_acceleration, self.mean_speed(now)) else {
            self.is_rolling = false;
            return false;
        };
        if !self.is_rolling || now.elapsed_s > TUNING.gap_s {
            self.is_rolling = true;
            self.steady.start_at(seen);
            self.quick.start_at(seen);
            return false;
        }
        let is_seen = self.age_s < self.config.unseen_after_s;
        let walk = if is_seen { TUNING.walks[0] } else { self.config.unseen_walk };
        let heard = (felt, self.acceleration_noise, now.elapsed_s);
        self.steady.predict(heard, walk);
        self.quick.predict(heard, TUNING.walks[1]);
        let lateral = now.lateral_acceleration.unwrap_or(0.0);
        let mu = self.car.longitudinal_force(felt, seen);
        let (least, most) = TUNING.telling;
        if lateral.abs() > self.config.max_lateral_acceleration_mps2
            || mu.abs() > most
            || now.abs == Some(true)
        {
            return false;
        }
        self.measure(seen, felt, mu, self.config.cornering_slip_std * lateral * seen);
        if mu.abs() > least {
            self.age_s = 0.0;
            self.informed = true;
        }
        let changed = self.is_contradicted(now.elapsed_s);
        if changed {
            self.steady = self.quick;
            self.contradicted_s = 0.0;
        }
        self.settle();
        changed
    }

    /// Speed of the car's middle, as the mean of the wheels has it, slipping as they do; none below the minimum.
    fn mean_speed(&self, now: &Kinematics) -> Option<f64> {
        let (wheels, yaw_rate, angle) = (now.wheels?, now.yaw_rate?, now.road_angle?);
        let speed = 0.25 * wheels.iter().sum::<f64>();
        let vy = self.car.steady_lateral_velocity(speed, yaw_rate, now.lateral_acceleration?);
        let at = |wheel: Wheel| self.car.forward_speed(wheel, wheels[wheel as usize], vy, yaw_rate, angle);
        let mean = 0.25 * Wheel::ALL.map(at).iter().sum::<f64>();
        (mean >= self.minimum_speed).then_some(mean)
    }

    /// Both filters look at the wheels; the steady one's surprise teaches the noise.
    fn measure(&mut self, seen: f64, felt: f64, mu: f64, cornering: f64) {
        let bent = 1.0 + mu.abs() / (3.0 * TUNING.bending);
        let h = vector![1.0, 0.0, 0.0, -felt, bent * mu * seen];
        let promised = self.wheel_noise * self.wheel_noise + cornering * cornering;
        let noise = self.noise.variance(promised);
        let residual = seen - h.dot(&self.steady.0.mean);
        self.noise.learn(&self.steady.0.innovation(&h, residual, noise), promised);
        let redundancy = self.noise.redundancy();
        for filter in [&mut self.steady, &mut self.quick] {
            filter.measure(seen, &h, noise, redundancy);
        }
    }

    fn is_contradicted(&mut self, elapsed_s: f64) -> bool {
        let (steady, quick) = (&self.steady.0, &self.quick.0);
        let differs = quick.mean[COMPLIANCE] - steady.mean[COMPLIANCE];
        // The quick one knows what the steady one knows, and forgets: the variances subtract.
        let variance =
            quick.covariance[(COMPLIANCE, COMPLIANCE)] - steady.covariance[(COMPLIANCE, COMPLIANCE)];
        let (deviations, lasting_s) = TUNING.contradiction;
        let contradicts = variance > 0.0 && differs * differs > deviations * deviations * variance;
        self.contradicted_s = if contradicts { self.contradicted_s + elapsed_s } else { 0.0 };
        self.contradicted_s > lasting_s
    }

    /// Remembers a slope that is known well.
    fn settle(&mut self) {
        if self.age_s == 0.0
            && let Some(slope) = self.overall().filter(|slope| self.config.is_known_well(slope))
        {
            self.settled = Some(Known { value: slope.value, std: slope.std });
        }
    }

    fn overall(&self) -> Option<Estimate> {
        let compliance = self.steady.0.mean[COMPLIANCE];
        let relative = (self.steady.0.std(COMPLIANCE) / compliance).hypot(TUNING.model_std);
        (self.informed && compliance > 0.0 && relative < SlopeConfig::UNKNOWN_STD).then(|| Estimate {
            value: 1.0 / compliance,
            std: relative / compliance,
            age_s: self.age_s,
        })
    }

    /// Slope per wheel, normalized by its static load: tires are taken for alike.
    pub fn slopes(&self) -> [Option<Estimate>; 4] {
        let overall = self.overall();
        Wheel::ALL.map(|wheel| {
            let share = Self::share(&self.car, wheel);
            overall.map(|slope| Estimate { value: share * slope.value, std: share * slope.std, ..slope })
        })
    }

    /// It is known well, and lately.
    pub fn is_valid(&self) -> bool {
        self.overall().is_some_and(|slope| self.config.is_valid(&slope))
    }
}

/// Speed (m/s), unfelt acceleration (m/s²), gain, delay (s) and compliance of one filter.
#[derive(Clone, Copy, Debug)]
struct Carried(Gaussian<5>);

const SPEED: usize = 0;
const UNFELT: usize = 1;
const GAIN: usize = 2;
const COMPLIANCE: usize = 4;

impl Carried {
    fn new(slope: f64, relative_std: f64) -> Self {
        let [speed, unfelt, gain, delay] = TUNING.start_std;
        let std = [speed, unfelt, gain, delay, relative_std / slope];
        Self(Gaussian::new([0.0, 0.0, 0.0, 0.0, 1.0 / slope], std))
    }

    /// The speed is that of the wheels, and nothing of what was known of it before counts.
    fn start_at(&mut self, speed: f64) {
        let Self(Gaussian { mean, covariance }) = self;
        covariance.row_mut(SPEED).fill(0.0);
        covariance.column_mut(SPEED).fill(0.0);
        mean[SPEED] = speed;
        covariance[(SPEED, SPEED)] = TUNING.start_std[SPEED].powi(2);
        let room = TUNING.start_std[UNFELT].powi(2) - covariance[(UNFELT, UNFELT)];
        covariance[(UNFELT, UNFELT)] += TUNING.other_grade_std.powi(2).min(room.max(0.0));
    }

    /// The accelerometer carries the speed on; `walk` is the compliance's, as a share of it.
    fn predict(&mut self, (felt, felt_noise, elapsed_s): (f64, f64, f64), walk: f64) {
        let filter = &mut self.0;
        let (unfelt, gain) = (filter.mean[UNFELT], filter.mean[GAIN]);
        filter.mean[SPEED] += elapsed_s * (felt * (1.0 + gain) + unfelt);
        let mut transition = SMatrix::<f64, 5, 5>::identity();
        transition[(SPEED, UNFELT)] = elapsed_s;
        transition[(SPEED, GAIN)] = elapsed_s * felt;
        let compliance = filter.mean[COMPLIANCE].abs().max(TUNING.stiffest);
        let walk =
            if filter.std(COMPLIANCE) < TUNING.walks_up_to * compliance { walk * compliance } else { 0.0 };
        let walks = SVector::from([0.0, TUNING.grade_walk, TUNING.gain_walk, 0.0, walk]);
        let mut noise = SMatrix::from_diagonal(&walks.map(|walk| walk * walk * elapsed_s));
        noise[(SPEED, SPEED)] = (felt_noise * elapsed_s).powi(2);
        filter.predict_covariance(&transition, &noise);
    }

    /// The wheels' mean speed. Noise that repeats itself counts as often as it does.
    fn measure(&mut self, seen: f64, h: &SVector<f64, 5>, noise: f64, redundancy: f64) {
        let residual = seen - h.dot(&self.0.mean);
        let expected = self.0.innovation(h, residual, noise);
        let limit = TUNING.clip * expected.variance.sqrt();
        self.0.update(h, residual.clamp(-limit, limit), noise * redundancy);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{DrivenAxle, Vehicle};
    use proptest::prelude::*;

    proptest! {
        /// Whatever the sensors say: covariances that are some, and no slope that is no number.
        #[test]
        fn it_stays_sound(
            inputs in proptest::collection::vec(
                (0.0..0.5_f64, 0.0..80.0_f64, -1.0..1.0_f64, -60.0..60.0_f64, -40.0..40.0_f64, any::<bool>()), 1..400,
            ),
        ) {
            let car = Car::new(&Vehicle { driven_axle: DrivenAxle::All, ..Vehicle::thesis() });
            let mut overall = OverallSlope::new(&car, &Sensors::default(), &SlopeConfig::default(), 3.0);
            for (elapsed_s, speed, slip, felt, lateral, abs) in inputs {
                overall.step(&Kinematics {
                    elapsed_s,
                    speed: Some(speed),
                    wheels: Some([speed, speed * (1.0 + slip), speed, speed]),
                    yaw_rate: Some(0.1 * slip),
                    lateral_acceleration: Some(lateral),
                    longitudinal_acceleration: Some(felt),
                    road_angle: Some(0.2 * slip),
                    rear_angle: 0.0,
                    axle_torque: None,
                    braking: None,
                    abs: Some(abs),
                });
                prop_assert!(overall.steady.0.is_sound() && overall.quick.0.is_sound());
                for slope in overall.slopes().into_iter().flatten() {
                    prop_assert!(slope.value > 0.0 && slope.value.is_finite() && slope.std.is_finite());
                }
                let mut learned = Learned::default();
                overall.learn(&mut learned);
                overall.restore(&learned.plausible());
                prop_assert!(overall.steady.0.is_sound());
            }
        }
    }
}
