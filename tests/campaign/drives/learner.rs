//! A parameter learner in the manner of openpilot's, as an anchor to be compared with.
//!
//! From what is publicly said of it (commaai/openpilot, `paramsd`): an extended Kalman filter on the linear
//! single-track model learns the steering ratio, one stiffness factor on both axles' cornering stiffness of the data
//! sheet, a slow and a fast offset of the steering angle and the road's roll, with lateral velocity and yaw rate as
//! states; yaw rate and roll are what it observes, twenty times a second, speed and steering angle what drives it.
//! Parameters walk at random, a little. It learns only above walking pace, at small steering angles and while there is
//! a yaw rate; the factor may be 0.2 to 5, the ratio half to twice the data sheet's.
//!
//! The rest is ours: the equations are written down from the textbook's single-track model; every noise below; the fast
//! offset forgets itself; the roll is read off the lateral accelerometer (a_y − v r over g, the lateral velocity taken
//! for steady), where theirs has a localizer with a camera; a gyroscope's offset, which their localizer removes, is left
//! in. Nothing is given out before a curve was driven.

use gripd::estimate::{Car, Kinematics};
use gripd::filter::Gaussian;
use gripd::model::{GRAVITY, Vehicle};
use nalgebra::{SMatrix, SVector};

const STATES: usize = 7;
const RATIO: usize = 0;
const FACTOR: usize = 1;
/// Of the steering wheel angle, rad.
const SLOW_OFFSET: usize = 2;
const FAST_OFFSET: usize = 3;
/// Of the road, rad, positive where it pulls the car to the right.
const ROLL: usize = 4;
const LATERAL: usize = 5;
const YAW: usize = 6;

type State = SVector<f64, STATES>;
type Jacobian = SMatrix<f64, STATES, STATES>;

/// A number with its standard deviation.
#[derive(Clone, Copy, Debug)]
pub struct Said {
    pub value: f64,
    pub std: f64,
}

/// The learner of one car.
#[derive(Clone, Debug)]
pub struct Learner {
    car: Car,
    /// Of the data sheet, N/rad.
    axles: [f64; 2],
    filter: Gaussian<STATES>,
    /// Since the last observation.
    unobserved_s: f64,
    is_running: bool,
    is_informed: bool,
}

impl Learner {
    const SLOWEST_MPS: f64 = 5.0;
    const STEERING_LIMIT: f64 = std::f64::consts::FRAC_PI_4;
    /// A longer gap, s, is no drive.
    const GAP_S: f64 = 0.1;
    const OBSERVES_EVERY_S: f64 = 0.05;
    const FACTOR_LIMITS: (f64, f64) = (0.2, 5.0);
    const RATIO_LIMITS: (f64, f64) = (0.5, 2.0);
    /// v r from which a curve tells something, m/s², as with the other anchors.
    const INFORMATIVE: f64 = 0.3;

    /// Before anything is learned: of ratio (relative), factor, offsets, roll, lateral velocity and yaw rate.
    const START_STD: [f64; STATES] = [0.1, 0.3, 0.03, 0.01, 0.02, 0.3, 0.05];
    /// Walks of the same, per √s. Of two tried for the factor, 0.01 and 0.03, the one that does better.
    const WALK: [f64; STATES] = [5e-4, 0.03, 3e-4, 3e-3, 0.005, 0.1, 0.05];
    const FAST_OFFSET_LASTS_S: f64 = 5.0;
    /// Of an observation: what the sensor and the single-track model miss.
    const YAW_RATE_STD: f64 = 0.01;
    const ROLL_STD: f64 = 0.1;

    /// Knows what the data sheet says.
    pub fn new(sheet: &Vehicle) -> Self {
        let car = Car::new(sheet);
        let [front, rear] = car.cornering_prior.map(|(value, _)| value);
        let axles = [2.0 * front * car.wheel_load[0], 2.0 * rear * car.wheel_load[1]];
        let filter = Self::at_first(car.steering_ratio);
        Self { car, axles, filter, unobserved_s: 0.0, is_running: false, is_informed: false }
    }

    fn at_first(ratio: f64) -> Gaussian<STATES> {
        let mut std = Self::START_STD;
        std[RATIO] *= ratio;
        let mut mean = State::zeros();
        mean[RATIO] = ratio;
        mean[FACTOR] = 1.0;
        Gaussian::new(mean.into(), std)
    }

    /// Factor on the data sheet's cornering stiffnesses.
    pub fn factor(&self) -> Option<Said> {
        self.said(FACTOR)
    }

    /// Steering wheel angle per road wheel angle.
    pub fn steer_ratio(&self) -> Option<Said> {
        self.said(RATIO)
    }

    fn said(&self, i: usize) -> Option<Said> {
        self.is_informed.then(|| Said { value: self.filter.mean[i], std: self.filter.std(i) })
    }

    /// Takes a sample.
    pub fn step(&mut self, now: &Kinematics) {
        let Some(cornering) = now.cornering(Self::SLOWEST_MPS).filter(|_| now.elapsed_s < Self::GAP_S) else {
            self.is_running = false;
            return;
        };
        let angle = cornering.road_angle * self.car.steering_ratio;
        if angle.abs() > Self::STEERING_LIMIT {
            self.is_running = false;
            return;
        }
        let (speed, yaw_rate) = (cornering.speed, cornering.yaw_rate);
        if !self.is_running {
            self.set_off(yaw_rate);
        }
        self.predict(speed, angle, now.elapsed_s);
        self.unobserved_s += now.elapsed_s;
        // Half a sample less: sums of periods are not exact.
        if self.unobserved_s > Self::OBSERVES_EVERY_S - 0.5 * now.elapsed_s {
            self.unobserved_s = 0.0;
            self.observe(yaw_rate, (cornering.lateral_acceleration - speed * yaw_rate) / GRAVITY);
            self.is_informed |= (speed * yaw_rate).abs() > Self::INFORMATIVE;
        }
    }

    /// How the car moves is not known after a pause; what was learned stays.
    fn set_off(&mut self, yaw_rate: f64) {
        self.is_running = true;
        self.unobserved_s = 0.0;
        for (state, mean) in [(LATERAL, self.car.b * yaw_rate), (YAW, yaw_rate)] {
            self.filter.mean[state] = mean;
            self.filter.covariance.row_mut(state).fill(0.0);
            self.filter.covariance.column_mut(state).fill(0.0);
            self.filter.inflate(state, Self::START_STD[state].powi(2));
        }
    }

    /// The single-track model, linearized where it is, one Euler step: at these speeds and steps it is stable.
    fn predict(&mut self, v: f64, angle: f64, dt: f64) {
        let x = self.filter.mean;
        let (a, b, mass, inertia) = (self.car.a, self.car.b, self.car.mass, self.car.yaw_inertia);
        let [front, rear] = self.axles.map(|stiffness| stiffness * x[FACTOR]);
        let steer = (angle - x[SLOW_OFFSET] - x[FAST_OFFSET]) / x[RATIO];
        let front_force = front * (steer - (x[LATERAL] + a * x[YAW]) / v);
        let rear_force = -rear * (x[LATERAL] - b * x[YAW]) / v;
        let (force, moment) = (front_force + rear_force, a * front_force - b * rear_force);

        let mut rates = State::zeros();
        rates[FAST_OFFSET] = -x[FAST_OFFSET] / Self::FAST_OFFSET_LASTS_S;
        rates[LATERAL] = force / mass - v * x[YAW] - GRAVITY * x[ROLL];
        rates[YAW] = moment / inertia;

        let mut by = Jacobian::zeros();
        by[(FAST_OFFSET, FAST_OFFSET)] = -1.0 / Self::FAST_OFFSET_LASTS_S;
        by[(LATERAL, ROLL)] = -GRAVITY;
        // How force (lever 1) and moment (levers of the axles) answer to each state.
        for (row, inverse, [front_lever, rear_lever], whole) in
            [(LATERAL, 1.0 / mass, [1.0, 1.0], force), (YAW, 1.0 / inertia, [a, -b], moment)]
        {
            by[(row, RATIO)] = -inverse * front_lever * front * steer / x[RATIO];
            by[(row, FACTOR)] = inverse * whole / x[FACTOR];
            by[(row, SLOW_OFFSET)] = -inverse * front_lever * front / x[RATIO];
            by[(row, FAST_OFFSET)] = by[(row, SLOW_OFFSET)];
            by[(row, LATERAL)] = -inverse * (front_lever * front + rear_lever * rear) / v;
            by[(row, YAW)] = -inverse * (front_lever * a * front - rear_lever * b * rear) / v;
        }
        by[(LATERAL, YAW)] -= v;

        self.filter.mean = x + rates * dt;
        let mut walk = Self::WALK;
        walk[RATIO] *= self.car.steering_ratio;
        let noise = Jacobian::from_diagonal(&State::from(walk).map(|walk| walk * walk * dt));
        self.filter.predict_covariance(&(Jacobian::identity() + by * dt), &noise);
    }

    fn observe(&mut self, yaw_rate: f64, roll: f64) {
        for (state, value, std) in [(YAW, yaw_rate, Self::YAW_RATE_STD), (ROLL, roll, Self::ROLL_STD)] {
            let mut h = State::zeros();
            h[state] = 1.0;
            self.filter.update(&h, value - self.filter.mean[state], std * std);
        }
        let ratio = self.car.steering_ratio;
        let (low, high) = Self::RATIO_LIMITS;
        self.filter.mean[RATIO] = self.filter.mean[RATIO].clamp(low * ratio, high * ratio);
        let (low, high) = Self::FACTOR_LIMITS;
        self.filter.mean[FACTOR] = self.filter.mean[FACTOR].clamp(low, high);
        if !self.filter.is_sound() {
            self.filter = Self::at_first(ratio);
            self.is_informed = false;
        }
    }
}

/// A drive on which all of it can be told apart: slow, where the ratio alone decides how much the car turns, and fast,
/// where understeer does; quick steering besides.
#[test]
fn the_learner_finds_the_stiffness_factor_and_the_steering_ratio_of_a_car_with_linear_tires() {
    use std::path::Path;

    use gripd::Config;
    use gripd::model::Scenario;

    const DRIVE: &str = r#"
        duration_s = 400.0
        initial_speed_mps = 9.0
        seed = 3
        [driver]
        speed_mps = [{ kind = "points", points = [[0, 9], [90, 9], [110, 28], [220, 28], [240, 12], [300, 12], [320, 28], [400, 28]] }]
        [[steering_wheel_angle]]
        kind = "random"
        rms = 0.25
        correlation_time_s = 0.8
        to_s = 110.0
        [[steering_wheel_angle]]
        kind = "random"
        rms = 0.12
        correlation_time_s = 0.6
        from_s = 110.0
        [vehicle]
        mass_kg = 1400.0
        wheelbase_m = 2.7
        cg_to_front_m = 1.15
        yaw_inertia_kgm2 = 2300.0
        wheel_radius_m = 0.31
        wheel_inertia_kgm2 = 1.2
        steering_ratio = 15.0
        driven_axle = "front"
        brake_torque_per_bar_front_nm = 20.0
        brake_torque_per_bar_rear_nm = 8.0
        tire = "linear"
        lateral_stiffness_front = 12.0
        lateral_stiffness_rear = 15.0
    "#;
    const SENSORS: &str = include_str!("../../../config/scenarios/demo.toml");
    let sensors = &SENSORS[SENSORS.find("[sensors.wheel_speed]").unwrap()..];
    let mut scenario = Scenario::parse(&format!("{DRIVE}\n{sensors}")).unwrap();
    for sensor in scenario.sensors.by_name.values_mut() {
        sensor.offset = 0.0;
    }
    let service = include_str!("../../../config/demo.toml");
    let mut config = Config::parse(service, Path::new("demo.toml")).unwrap();
    config.vehicle = scenario.vehicle.clone();

    for (factor, ratio) in [(1.18, 0.85), (0.82, 1.18)] {
        let mut sheet = scenario.vehicle.clone();
        sheet.lateral_stiffness_front.value /= factor;
        sheet.lateral_stiffness_rear.value /= factor;
        sheet.steering_ratio.value *= ratio;
        let (car, mut learner) = (Car::new(&sheet), Learner::new(&sheet));
        super::driven::drive(
            &scenario,
            3,
            config.clone(),
            &[],
            |reading| *reading,
            |sample, _, _| {
                learner.step(&Kinematics::new(sample, &car));
            },
        );
        let (found, steer) = (learner.factor().unwrap(), learner.steer_ratio().unwrap());
        println!("factor {found:?} for {factor}, ratio {steer:?} for 15");
        assert!((found.value / factor - 1.0).abs() < 0.1, "{found:?} for {factor}");
        assert!((steer.value / 15.0 - 1.0).abs() < 0.05, "{steer:?} for 15");
    }
}
