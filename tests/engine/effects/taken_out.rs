//! Effects of `[[effect]]` tables, as the live estimators take them out of the readings.

use gripd::estimate::{EstimatorsConfig, Pipeline, PlainReadings};
use gripd::model::{Scenario, Simulation, Uncertain};
use gripd::{Micros, Sample};

const SCENARIO: &str = include_str!("../../../config/scenarios/asphalt_gravel.toml");

/// Errors of the valid estimates of a lively drive of two minutes, rms.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    /// Share of the samples with valid motion, and with valid stiffness.
    valid: [f64; 2],
    /// Sideslip, °.
    sideslip: f64,
    /// Rear slip angle as published, °.
    rear_slip_angle: f64,
    /// Relative, of both axles' cornering stiffness.
    stiffness: [f64; 2],
}

/// The car has the effect; does the service know?
fn drive(effect: &str, is_told: bool) -> Errors {
    let mut table: toml::Table = SCENARIO.parse().unwrap();
    table.insert("duration_s".into(), 120.0.into());
    table["steering_wheel_angle"][0].as_table_mut().unwrap().insert("rms".into(), 0.6.into());
    let text = toml::to_string(&table).unwrap() + effect;
    let scenario = Scenario::parse(&text).unwrap();
    let mut vehicle = scenario.vehicle.clone();
    vehicle.lateral_stiffness_front = Uncertain { value: 12.0, std: 3.0 };
    vehicle.lateral_stiffness_rear = Uncertain { value: 13.0, std: 3.0 };
    let mut pipeline = Pipeline::new(&vehicle, &scenario.sensors.promised(), &EstimatorsConfig::default());
    if is_told {
        pipeline = pipeline.with_effects(&vehicle, &scenario.effect);
    }
    let mut simulation = Simulation::new(&scenario, 3).unwrap();
    let mut sample = Sample::empty(Micros(0), 0.01);
    let (mut samples, mut motions, mut stiffnesses) = (0.0, 0.0, 0.0);
    let mut errors = Errors::default();
    while let Some(tick) = simulation.next_tick() {
        for reading in tick.readings {
            sample.set(reading.quantity, reading.value);
        }
        sample.time = tick.truth.time;
        let estimates = pipeline.step(&sample);
        if sample.time.seconds() < 20.0 {
            continue;
        }
        samples += 1.0;
        let (motion, truth) = (&estimates.motion, tick.truth);
        if let (true, Some(sideslip), Some(rear)) = (motion.valid, motion.sideslip, motion.slip_angle_rear) {
            motions += 1.0;
            errors.sideslip += (sideslip - truth.sideslip).to_degrees().powi(2);
            errors.rear_slip_angle += (rear - truth.slip_angle_rear).to_degrees().powi(2);
        }
        if let (true, [Some(front), Some(rear)]) = (estimates.cornering_valid, estimates.cornering) {
            stiffnesses += 1.0;
            errors.stiffness[0] += (front.value / truth.cornering_front - 1.0).powi(2);
            errors.stiffness[1] += (rear.value / truth.cornering_rear - 1.0).powi(2);
        }
    }
    Errors {
        valid: [motions, stiffnesses].map(|count: f64| count / samples),
        sideslip: (errors.sideslip / motions).sqrt(),
        rear_slip_angle: (errors.rear_slip_angle / motions).sqrt(),
        stiffness: errors.stiffness.map(|square| (square / stiffnesses).sqrt()),
    }
}

impl Errors {
    /// Of `other`, how much larger the worst of these is.
    fn over(&self, other: &Self) -> f64 {
        let pairs = [
            (self.sideslip, other.sideslip),
            (self.rear_slip_angle, other.rear_slip_angle),
            (self.stiffness[0], other.stiffness[0]),
            (self.stiffness[1], other.stiffness[1]),
        ];
        pairs.into_iter().map(|(own, other)| own / other).fold(0.0, f64::max)
    }

    /// The smaller share that is valid.
    fn least_valid(&self) -> f64 {
        self.valid[0].min(self.valid[1])
    }
}

/// As good as those of the plain car, whatever the car has.
fn taken_out(effects: &[(&str, bool)]) {
    let plain = drive("", false);
    assert!(plain.least_valid() > 0.9, "{plain:?}");
    for (effect, matters) in effects {
        let table = format!("\n[[effect]]\nkind = \"{effect}\n");
        let told = drive(&table, true);
        let is_as_valid = told.least_valid() > 0.95 * plain.least_valid();
        assert!(told.over(&plain) < 1.4 && is_as_valid, "{effect}: {told:?}, {plain:?}");
        let untold = drive(&table, false);
        let is_worse = untold.over(&plain) > 1.7 || untold.least_valid() < 0.9 * plain.least_valid();
        assert_eq!(is_worse, *matters, "{effect} not told: {untold:?}, {plain:?}");
    }
}

/// What turns the wheels against the road. Some of it soft tires make up for, where one does not know.
#[test]
fn axles_stand_as_effects_turn_them() {
    taken_out(&[
        ("steering_lag\"\ntime_constant_s = 0.1", true),
        ("steering_ratio\"\ncurvature_per_rad2 = 0.1", true),
        ("steering_compliance\"\ncompliance_rad_per_nm = 1e-4", true),
        ("rear_steer\"\nlow_speed_ratio = 0.3", true),
        ("roll_steer\"\nroll_steer_rad_per_rad = 0.15", false),
        ("relaxation_length\"\nlength_m = 0.8", false),
    ]);
}

#[test]
fn sensors_say_what_is_so() {
    let drift = "sensor_drift\"\nchannel = \"steering_wheel_angle\"\n\
                 series = { t = [1, 30, 100], value = [0, 0.2, -0.3] }";
    taken_out(&[
        ("accelerometer_position\"\nforward_of_cg_m = 1.2", true),
        ("body_roll\"\nroll_gain_rad_per_mps2 = 0.01", true),
        ("sensor_bias\"\nchannel = \"yaw_rate\"\nbias = 0.03\nat_s = 60", true),
        (drift, true),
        ("radius_growth\"\nrelative_per_mps_squared = 2e-5", false),
    ]);
}

/// Tires, loads, mass and road are what the service finds out.
#[test]
fn what_is_estimated_is_not_taken_out() {
    let parse =
        |effect: &str| Scenario::parse(&format!("{SCENARIO}\n[[effect]]\nkind = \"{effect}\n")).unwrap();
    for (effect, is_taken) in [
        ("tire_saturation\"\nfriction = 0.6", false),
        ("friction_change\"\nfriction = 0.4\nintervals = [[10, 20]]", false),
        ("road_bank\"\nseries = { t = [1, 3], value = [0, 0.05] }", false),
        ("cg_shift\"\nshift_m = 0.2\nat_s = 30", false),
        ("steering_lag\"\ntime_constant_s = 0.1", true),
        ("sensor_drift\"\nchannel = \"yaw_rate\"\nseries = { t = [1, 3], value = [0, 0.01] }", true),
    ] {
        let scenario = parse(effect);
        assert_eq!(PlainReadings::takes(&scenario.vehicle, &scenario.effect[0]), is_taken, "{effect}");
    }
}
