//! The constants of the filter's equations, and its time update.

use nalgebra::SMatrix;

use super::bend::Bend;
use super::config::CorneringConfig;
use super::state::{ANGLE_OFFSET, AY_OFFSET, BANK, FRONT, REAR, SPEED_SCALE, STATES, State, VY, YAW_OFFSET};
use super::window::{Means, Path};
use crate::estimate::kinematics::Car;
use crate::{Quantity, Sensors};

/// Tuned with the tests `campaign` (`model_std` by the stiffness on the drives 7001 to 7060 of `drives`) and `long_drives`.
struct Tuning {
    /// What the equations leave out (timing of the sensors, relaxation, load transfer), relative: no amount of data
    /// takes it away.
    model_std: f64,
    /// Process noise while an axle slides, m/s²/√Hz: at large slip angles the wheels measure the speed badly.
    sliding_noise: f64,
    /// Correlation of both stiffnesses' walks: it is the same surface.
    walks_together: f64,
    /// A stiffness of which nothing was learned for long is no less known than this, relative.
    unknown_std: f64,
    /// Errors of sensors move by this share of what they may be at all, 1/√s: a tenth in an hour.
    errors_walk: f64,
}

const TUNING: Tuning = Tuning {
    model_std: 0.05,
    sliding_noise: 0.1,
    walks_together: 0.8,
    unknown_std: 0.5,
    errors_walk: 0.1 / 60.0,
};

/// The car, its sensors and its tires: all that stays the same while it drives.
#[derive(Clone, Debug)]
pub struct Model {
    /// The car.
    pub car: Car,
    /// Its tuning numbers.
    pub config: CorneringConfig,
    /// As the data sheets promise it.
    pub noise: SensorNoise,
    /// How tires bend.
    pub tires: Bend,
    /// Systematic deviation of the stiffnesses, relative, front and rear: no amount of data reduces it.
    pub systematic_std: [f64; 2],
}

/// Standard deviations of single samples.
#[derive(Clone, Copy, Debug)]
pub struct SensorNoise {
    /// Of the yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Of the lateral acceleration, m/s².
    pub acceleration: f64,
    /// Of the road wheel angle, rad.
    pub road_angle: f64,
}

/// How the stiffnesses walk.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// Relative, 1/√s.
    pub relative: f64,
    /// Correlation of both axles'.
    pub together: f64,
}

impl Model {
    /// For this car and these sensors.
    pub fn new(car: &Car, sensors: &Sensors, config: &CorneringConfig) -> Self {
        Self {
            noise: SensorNoise {
                yaw_rate: sensors.noise_std(Quantity::YawRate),
                acceleration: sensors.noise_std(Quantity::LateralAcceleration),
                road_angle: sensors.noise_std(Quantity::SteeringWheelAngle) / car.steering_ratio,
            },
            tires: Bend::new(),
            systematic_std: car.cornering_scale_std.map(|std| TUNING.model_std.hypot(std)),
            car: car.clone(),
            config: config.clone(),
        }
    }

    /// v̇_y = a_y − v_x r from window to window, with the sensors' errors and the bank taken off; the stiffnesses walk.
    pub fn predict(&self, state: &mut State, now: &Means, is_sliding: bool, stiffness_walk: Walk) {
        let path = now.path;
        let turned = path.turned - state.mean[YAW_OFFSET] * path.distance;
        state.mean[VY] += along(state, &path);
        let mut transition = SMatrix::<f64, STATES, STATES>::identity();
        transition[(VY, AY_OFFSET)] = -path.time;
        transition[(VY, BANK)] = -path.time;
        transition[(VY, YAW_OFFSET)] = path.distance;
        transition[(VY, SPEED_SCALE)] = -turned;
        let white =
            self.noise.acceleration.hypot(now.speed * self.noise.yaw_rate) * path.time / now.samples.sqrt();
        let unmodelled = if is_sliding { TUNING.sliding_noise } else { self.config.acceleration_noise };
        let unmodelled = unmodelled * path.time.sqrt();
        let mut noise = SMatrix::<f64, STATES, STATES>::zeros();
        noise[(VY, VY)] = white * white + unmodelled * unmodelled;
        state.predict_covariance(&transition, &noise);
        self.walk(state, path.time, stiffness_walk);
    }

    /// How the stiffnesses walk on the same road.
    pub fn ordinary_walk(&self) -> Walk {
        Walk { relative: self.config.stiffness_walk, together: TUNING.walks_together }
    }

    /// Random walks of what changes on its own, and the bank, which comes and goes.
    pub fn walk(&self, state: &mut State, elapsed_s: f64, stiffness_walk: Walk) {
        let config = &self.config;
        let walk = [FRONT, REAR].map(|i| stiffness_walk.relative * state.mean[i]);
        let common = stiffness_walk.together * walk[0] * walk[1] * elapsed_s;
        state.covariance[(FRONT, REAR)] += common;
        state.covariance[(REAR, FRONT)] += common;
        for (i, walk) in [FRONT, REAR].into_iter().zip(walk) {
            state.inflate(i, walk * walk * elapsed_s);
            let most = TUNING.unknown_std * state.mean[i];
            let shrink = most / state.std(i).max(most);
            state.covariance.row_mut(i).scale_mut(shrink);
            state.covariance.column_mut(i).scale_mut(shrink);
        }
        let step = TUNING.errors_walk * elapsed_s.sqrt();
        for (i, most) in [
            (ANGLE_OFFSET, config.steering_offset_std),
            (AY_OFFSET, config.acceleration_offset_std),
            (YAW_OFFSET, config.yaw_rate_offset_std),
        ] {
            state.inflate(i, (step * most).powi(2));
        }
        let kept = (-elapsed_s / config.bank_time_s).exp();
        state.mean[BANK] *= kept;
        state.covariance.row_mut(BANK).scale_mut(kept);
        state.covariance.column_mut(BANK).scale_mut(kept);
        state.inflate(BANK, config.bank_std.powi(2) * (1.0 - kept * kept));
    }
}

/// Change of v_y along a path, m/s.
fn along(state: &State, path: &Path) -> f64 {
    let x = &state.mean;
    let turned = path.turned - x[YAW_OFFSET] * path.distance;
    path.pushed - (x[AY_OFFSET] + x[BANK]) * path.time - (1.0 + x[SPEED_SCALE]) * turned
}
