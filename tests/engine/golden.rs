//! Golden series: what the estimators say of three drives, at 1 Hz. Any change of behaviour shows as a diff of these
//! files in the commit that makes it:
//!
//! ```text
//! GRIPD_RENEW=1 cargo test --test engine golden
//! ```

use gripd::model::{Scenario, Uncertain};
use gripd::{Config, Estimates};
use testing::fault::{Fault, sensor};
use testing::heard::Heard;
use testing::program::project;
use testing::{demo_car, driven, golden};

const COLUMNS: &str = "t_s,speed_mps,sideslip_rad,motion_valid,slope_fl,slope_fr,slope_valid,cornering_front,\
                       cornering_rear,cornering_valid,mu_low,mu_max,mu_high,mu_used,mu_source,mu_valid,changes,faults";

/// The first estimates of each second.
#[derive(Default)]
struct Series(Vec<Vec<String>>);

impl Series {
    fn take(&mut self, estimates: &Estimates) {
        if estimates.time.seconds() < self.0.len() as f64 {
            return;
        }
        let number =
            |value: Option<f64>, digits: usize| value.map_or(String::new(), |v| format!("{v:.digits$}"));
        let flag = |valid: bool| u8::from(valid).to_string();
        let Estimates { motion, slope, cornering, friction: mu, .. } = estimates;
        let value = |of: usize| number(slope[of].map(|slope| slope.value), 1);
        let stiffness = |of: usize| number(cornering[of].map(|cornering| cornering.value), 2);
        let faults: Vec<&str> = estimates.faults.iter_names().map(|(name, _)| name).collect();
        self.0.push(vec![
            format!("{:.2}", estimates.time.seconds()),
            number(motion.speed, 2),
            number(motion.sideslip, 4),
            flag(motion.valid),
            value(0),
            value(1),
            flag(estimates.slope_valid),
            stiffness(0),
            stiffness(1),
            flag(estimates.cornering_valid),
            number(mu.low, 3),
            number(mu.max, 3),
            number(mu.high, 3),
            number(mu.used, 3),
            mu.source.name().to_owned(),
            flag(mu.valid),
            estimates.surface_changes.to_string(),
            faults.join(" "),
        ]);
    }

    #[track_caller]
    fn compare(&self, name: &str) {
        let file = format!("tests/engine/golden/{name}.csv");
        golden::compare(&file, COLUMNS, &self.0, "cargo test --test engine golden");
    }
}

fn demo() -> Scenario {
    Scenario::parse(&std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap()).unwrap()
}

#[test]
fn the_demo_drive() {
    let mut series = Series::default();
    driven::drive(
        &demo(),
        1,
        demo_car::config(),
        &[],
        |reading| *reading,
        |_, _, estimates| series.take(estimates),
    );
    series.compare("demo");
}

/// The demo's drive in a heavier car with less of a bus: neither torque nor brakes are told, steps are coarse.
#[test]
fn a_drive_of_a_rav4() {
    let config = Config::load(&project("config/rav4.toml")).unwrap();
    let mut scenario = demo();
    let exactly = |known: Uncertain| Uncertain { std: 0.0, ..known };
    let (car, sheet) = (&mut scenario.vehicle, &config.vehicle);
    car.mass_kg = exactly(sheet.mass_kg);
    car.wheelbase_m = exactly(sheet.wheelbase_m);
    car.cg_to_front_m = exactly(sheet.cg_to_front_m);
    car.track_front_m = exactly(sheet.track_front_m);
    car.track_rear_m = exactly(sheet.track_rear_m);
    car.cg_height_m = exactly(sheet.cg_height_m);
    car.wheel_radius_m = exactly(sheet.wheel_radius_m);
    car.steering_ratio = exactly(sheet.steering_ratio);
    let database = config.input_database().unwrap();
    let mut series = Series::default();
    driven::drive_on(&database, &scenario, 1, config, &[], |reading| *reading, |_, _, e| series.take(e));
    series.compare("rav4");
}

#[test]
fn a_drive_with_a_fault() {
    let stands_still =
        sensor::cases().into_iter().find(|case| case.name == "a yaw rate that stands still").unwrap();
    let Fault::Sensors(spoil) = stands_still.fault else { panic!("not a sensor's") };
    let mut readings = demo_car::readings().to_vec();
    spoil(&mut readings);
    readings.sort_by_key(|reading| reading.time);
    let config = demo_car::config();
    let (mut engine, mut heard) = (demo_car::engine(&config), Heard::default());
    for frame in demo_car::frames_of(&config, &readings) {
        engine.frame(&frame, &mut heard);
    }
    engine.finish(&mut heard);
    let mut series = Series::default();
    heard.estimates.iter().for_each(|estimates| series.take(estimates));
    series.compare("fault");
}
