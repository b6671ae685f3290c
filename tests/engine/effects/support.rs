//! A simulated car for the tests of effects.

use gripd::Quantity;
use gripd::model::{GRAVITY, Scenario, Simulation, Truth};

// A car that steers neither under nor over, with linear tires, without drag.
pub const MASS: f64 = 1500.0;
pub const WHEELBASE: f64 = 2.7;
pub const A: f64 = 1.2;
pub const B: f64 = WHEELBASE - A;
pub const YAW_INERTIA: f64 = 2700.0;
pub const TRACK: f64 = 1.5;
pub const RADIUS: f64 = 0.3;
pub const WHEEL_INERTIA: f64 = 1.2;
/// Lateral and longitudinal stiffness / load.
pub const LATERAL: f64 = 12.0;
pub const ALONG: f64 = 30.0;
/// Load of a front wheel, N, and of a rear one.
pub const LOAD: [f64; 2] = [0.5 * MASS * GRAVITY * B / WHEELBASE, 0.5 * MASS * GRAVITY * A / WHEELBASE];
/// What accelerates: the wheels must be spun up, too.
pub const INERT_MASS: f64 = MASS + 4.0 * WHEEL_INERTIA / (RADIUS * RADIUS);

pub const CAR: &str = r#"
    seed = 1
    [vehicle]
    mass_kg = 1500
    wheelbase_m = 2.7
    cg_to_front_m = 1.2
    yaw_inertia_kgm2 = 2700
    track_front_m = 1.5
    track_rear_m = 1.5
    wheel_radius_m = 0.3
    wheel_inertia_kgm2 = 1.2
    steering_ratio = 15
    driven_axle = "front"
    lateral_stiffness_front = 12
    lateral_stiffness_rear = 12
    longitudinal_stiffness = 30
    brake_torque_per_bar_front_nm = 20
    brake_torque_per_bar_rear_nm = 10
"#;

/// A drive with perfect sensors, read every 10 ms with each row of truth.
pub struct Drive {
    pub truth: Vec<Truth>,
    pub readings: Vec<Vec<f64>>,
    pub columns: Vec<String>,
    pub series: Vec<Vec<f64>>,
}

/// `top` are keys of the scenario, `rest` are tables.
pub fn scenario(duration_s: f64, speed: f64, tire: &str, top: &str, rest: &str) -> Scenario {
    let sensors: String = Quantity::ALL.iter().map(|q| format!("sensors.{q}.period_ms = 10\n")).collect();
    let text = format!(
        "duration_s = {duration_s}\ninitial_speed_mps = {speed}\n{sensors}\n{top}\n{CAR}\ntire = \"{tire}\"\n{rest}"
    );
    Scenario::parse(&text).unwrap_or_else(|e| panic!("{e}"))
}

pub fn driven(scenario: &Scenario) -> Drive {
    let mut simulation = Simulation::new(scenario, 1).unwrap();
    let columns = simulation.effect_columns().to_vec();
    let mut drive =
        Drive { truth: Vec::new(), readings: vec![Vec::new(); Quantity::COUNT], columns, series: Vec::new() };
    while let Some(tick) = simulation.next_tick() {
        assert!(tick.truth.is_finite(), "{:?}", tick.truth);
        drive.truth.push(*tick.truth);
        drive.series.push(tick.effects.to_vec());
        for reading in tick.readings {
            drive.readings[reading.quantity as usize].push(reading.value);
        }
    }
    drive
}

/// On linear tires.
pub fn drive(duration_s: f64, speed: f64, top: &str, rest: &str) -> Drive {
    driven(&scenario(duration_s, speed, "linear", top, rest))
}

impl Drive {
    pub fn of(&self, quantity: Quantity) -> &[f64] {
        &self.readings[quantity as usize]
    }

    pub fn column(&self, name: &str) -> Vec<f64> {
        let place = self.columns.iter().position(|column| column == name);
        let place = place.unwrap_or_else(|| panic!("{name} is none of {:?}", self.columns));
        self.series.iter().map(|row| row[place]).collect()
    }

    pub fn last(&self, quantity: Quantity) -> f64 {
        *self.of(quantity).last().unwrap()
    }

    pub fn end(&self) -> &Truth {
        self.truth.last().unwrap()
    }
}

/// Largest value in the second half.
pub fn amplitude(values: &[f64]) -> f64 {
    values[values.len() / 2..].iter().fold(0.0, |most, value| value.abs().max(most))
}

#[track_caller]
pub fn close(value: f64, expected: f64, relative: f64) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{value}, expected {expected}");
}

#[track_caller]
pub fn all_close(values: impl IntoIterator<Item = (f64, f64)>, absolute: f64) {
    let mut count = 0;
    for (i, (value, expected)) in values.into_iter().enumerate() {
        assert!((value - expected).abs() <= absolute, "row {i}: {value}, expected {expected}");
        count += 1;
    }
    assert!(count > 50, "{count} rows");
}

pub const AT_20: &str = "driver = { speed_mps = [{ kind = \"constant\", value = 20 }] }\n";

/// A steady turn at 20 m/s with a road wheel angle of 0.02 rad.
pub fn turn(effect: &str) -> Drive {
    let top =
        format!("{AT_20} steering_wheel_angle = [{{ kind = \"ramp\", from_s = 0, to_s = 2, value = 0.3 }}]");
    drive(8.0, 20.0, &top, effect)
}

/// Sine steering of 1 Hz at 20 m/s.
pub fn slalom(effect: &str) -> Drive {
    let top =
        format!("{AT_20} steering_wheel_angle = [{{ kind = \"sine\", amplitude = 0.3, frequency_hz = 1 }}]");
    drive(8.0, 20.0, &top, effect)
}

/// Yaw rate of a steady turn with axles of these cornering stiffnesses, N/rad, the centre of gravity `a` behind
/// the front axle (bicycle model).
pub fn steady_yaw_rate(speed: f64, steer: f64, a: f64, [front, rear]: [f64; 2]) -> f64 {
    let b = WHEELBASE - a;
    let gradient = MASS * (b * rear - a * front) / (WHEELBASE * front * rear);
    speed * steer / (WHEELBASE + gradient * speed * speed)
}

pub const AXLES: [f64; 2] = [2.0 * LATERAL * LOAD[0], 2.0 * LATERAL * LOAD[1]];
