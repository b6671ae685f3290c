//! Real cars: what comes out, and what must not be claimed. Skipped without the recordings.

use std::path::Path;

use gripd::can::Frame;
use gripd::can::candump::Reader;
use gripd::estimates::MuSource;
use gripd::identify::{Identifier, IdentifyConfig, LongitudinalInput};
use gripd::service::{Engine, Sink, sensors};
use gripd::signals::{Inputs, Sampler};
use gripd::{Config, Estimates, Sample};
use testing::results::Section;

#[derive(Default)]
struct Record(Vec<Estimates>);

impl Sink for Record {
    fn estimates(&mut self, _sample: &Sample, estimates: &Estimates) {
        self.0.push(*estimates);
    }

    fn publish(&mut self, _frame: &Frame) {}
}

fn replay(config: &Config, log: &Path) -> Vec<Estimates> {
    let mut engine = Engine::new(config).unwrap();
    let mut reader = Reader::open(log).unwrap();
    let mut record = Record::default();
    while let Some(frame) = reader.next_frame().unwrap() {
        engine.frame(&frame, &mut record);
    }
    engine.finish(&mut record);
    record.0
}

/// The Zoe as its user would map it. The accelerometer reads 5.17 m/s² too little in every scene.
const ZOE: &str = r#"
[dbc]
input = ["recording.dbc"]
[signals]
wheel_speed_fl = "WHEEL_SPEEDS.WheelSpeedFL"
wheel_speed_fr = "WHEEL_SPEEDS.WheelSpeedFR"
wheel_speed_rl = "WHEEL_SPEEDS.WheelSpeedRL"
wheel_speed_rr = "WHEEL_SPEEDS.WheelSpeedRR"
yaw_rate = "INERTIAL.YawRate"
lateral_acceleration = { signal = "INERTIAL.LateralAcceleration", not_available = [-32768], offset = 5.17 }
longitudinal_acceleration = { signal = "INERTIAL.LongitudinalAcceleration", not_available = [-32768] }
steering_wheel_angle = "STEERING.SteeringWheelAngle"
drive_torque = { signal = "POWERTRAIN.DriveTorque", not_available = [-32768] }
[vehicle]
mass_kg = { value = 1550.0, std = 60.0 }
wheelbase_m = 2.588
cg_to_front_m = { value = 1.10, std = 0.05 }
wheel_radius_m = { value = 0.31, std = 0.005 }
steering_ratio = { value = 15.0, std = 1.0 }
track_front_m = 1.51
track_rear_m = 1.51
wheel_inertia_kgm2 = 2.0
driven_axle = "front"
drive_torque_ratio = 9.3
drag_coefficient_kg_per_m = 0.45
rolling_resistance = 0.01
longitudinal_stiffness = { value = 30.0, std = 15.0 }
"#;

#[test]
fn the_zoe_scenes_agree_on_the_slope() {
    let Some(folder) = testing::shared("recordings") else { return };
    let config = Config::parse(ZOE, &folder.join("zoe.toml")).unwrap();
    let scenes = testing::recordings_in(&folder.join("zoe"));
    let mut slopes = Vec::new();
    for scene in &scenes {
        let rows = replay(&config, scene);
        let last = rows.last().unwrap();
        let name = scene.file_name().unwrap().to_string_lossy().into_owned();
        for (wheel, (slope, offset)) in last.slope.iter().zip(last.slip_offset).take(2).enumerate() {
            let (Some(slope), Some(offset)) = (slope, offset) else { continue };
            println!(
                "{name} {}: slope {:5.1} ± {:4.1}, offset {:+.4} ± {:.4}",
                ["FL", "FR"][wheel],
                slope.value,
                slope.std,
                offset.value,
                offset.std
            );
            slopes.push(*slope);
        }
        assert_eq!(last.surface_changes, 0, "{name}");
    }
    assert!(slopes.len() >= 12, "{}", slopes.len());
    let weight: f64 = slopes.iter().map(|s| s.std.powi(-2)).sum();
    let mean = slopes.iter().map(|s| s.value * s.std.powi(-2)).sum::<f64>() / weight;
    let chi = slopes.iter().map(|s| ((s.value - mean) / s.std).powi(2)).sum::<f64>();
    let section = Section {
        name: "zoe",
        seed: "recorded",
        tolerance: 0.01,
        header: "Renault Zoe, city scenes | slopes | weighted mean | χ²",
    };
    let std = weight.powf(-0.5);
    section.check(&[format!("{} scenes | {} | {mean:.1} ± {std:.1} | {chi:.1}", scenes.len(), slopes.len())]);
    assert!((40.0..80.0).contains(&mean));
    assert!(chi < 3.0 * slopes.len() as f64);
}

#[test]
fn nothing_unknowable_is_claimed_of_the_cruising_rav4() {
    let Some(folder) = testing::shared("recordings") else { return };
    let config = Config::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("config/rav4.toml")).unwrap();
    let rows = replay(&config, &folder.join("rav4/bus0.log.gz"));
    assert!(rows.len() > 5900);
    for row in &rows {
        assert!(!row.cornering_valid, "{row:?}");
        assert!(!row.friction.valid && row.friction.max.is_none() && row.friction.high.is_none());
        assert!(matches!(row.friction.source, MuSource::None | MuSource::LowerBound));
    }
    let last = rows.last().unwrap();
    assert_eq!(last.surface_changes, 0);
    let [Some(fl), Some(fr), None, None] = last.slope else { panic!("{:?}", last.slope) };
    println!("RAV4: slope {:.1} ± {:.1} and {:.1} ± {:.1}", fl.value, fl.std, fr.value, fr.std);
}

/// GIVEN a minute of hardly any curves, with a yaw rate in steps THEN no car is proposed that cannot be, and the table's numbers
/// count: once its centre of gravity was told at 81 % of the wheelbase.
#[test]
fn no_impossible_rav4_is_identified() {
    let Some(folder) = testing::shared("recordings") else { return };
    let config = Config::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("config/rav4.toml")).unwrap();
    let record = recorded(&folder.join("rav4/bus0.log.gz"), &config);
    let settings = IdentifyConfig { starts: 2, profile: false, ..IdentifyConfig::default() };
    let records = [record];
    let found = Identifier::new(&records, &config.vehicle, &settings).unwrap().run(|_, _| ()).unwrap();
    assert!(found.weight < 0.2, "{}", found.weight);
    for parameter in &found.parameters {
        let (mean, std) = parameter.prior;
        let is_proposed = parameter.identifiable && !parameter.name.contains("_offset");
        assert!(!is_proposed || (parameter.value - mean).abs() < 3.0 * std, "{parameter}");
    }
    let place = found.parameters.iter().find(|it| it.name == "cg_to_front_m").unwrap();
    assert!((1.0..1.6).contains(&place.value) && !place.identifiable, "{place}");
}

/// The two Zoes: their wheels' radii differ, right rear against left by 1.9 % and by −0.2 %.
const ZOES: [&[&str]; 2] = [&["0103", "0655", "0757"], &["0061", "0796", "0916", "1077", "1094", "1100"]];

/// GIVEN a car on one road WHEN it uses more of the friction within ten seconds THEN no interval excluded that before.
#[test]
fn no_interval_excludes_what_a_gti_uses_next() {
    let Some(folder) = testing::shared("recordings/gti") else { return };
    let config = Config::load(&folder.join("drives.toml")).unwrap();
    for drive in ["group1controller", "group5controller", "group7lookahead", "group10controller"] {
        let all = replay(&config, &folder.join(format!("{drive}.log.gz")));
        let moving: Vec<_> = all.iter().filter(|e| e.motion.speed.is_some_and(|speed| speed > 5.0)).collect();
        let excludes = |(place, now): (usize, &&Estimates)| {
            let until = now.time.seconds() + 10.0;
            let next = moving[place..].iter().take_while(|later| later.time.seconds() < until);
            let used = next.filter_map(|later| later.friction.used).fold(0.0, f64::max);
            now.friction.high.is_some_and(|high| high < used - 0.05)
        };
        let excluding = moving.iter().enumerate().filter(|at| excludes((at.0, at.1))).count();
        assert!(moving.len() > 2000, "{drive}: {}", moving.len());
        assert!(excluding * 200 < moving.len(), "{drive}: {excluding} of {}", moving.len());
    }
}

/// GIVEN a lap whose steering belongs to another lap, and now and then agrees with the yaw rate THEN no friction is told.
#[test]
fn a_foreign_steering_tells_no_friction() {
    let Some(folder) = testing::shared("recordings/gti") else { return };
    let config = Config::load(&folder.join("laps.toml")).unwrap();
    let rows = replay(&config, &folder.join("dry1.log.gz"));
    let told = rows.iter().filter(|row| row.friction.valid || row.friction.high.is_some()).count();
    assert!(rows.len() > 5000 && told == 0, "{told} of {}", rows.len());
}

/// Scenes as records, 50 Hz as they were recorded.
fn zoe_records(folder: &Path, config: &Config, scenes: &[&str]) -> Vec<gripd::identify::Record> {
    let log = |scene: &&str| folder.join(format!("zoe/scene-{scene}.log.gz"));
    scenes.iter().map(|scene| recorded(&log(scene), config)).collect()
}

/// A recording as a record.
fn recorded(log: &Path, config: &Config) -> gripd::identify::Record {
    let radius = config.vehicle.wheel_radius_m.value;
    let inputs = Inputs::compile(&config.signals, &config.input_database().unwrap(), radius).unwrap();
    let mut sampler = Sampler::new(inputs.clone(), &config.signals.sampling);
    let mut reader = Reader::open(log).unwrap();
    let mut samples = Vec::new();
    while let Some(frame) = reader.next_frame().unwrap() {
        sampler.push(&frame);
        samples.extend(std::iter::from_fn(|| sampler.next_sample()));
    }
    let name = log.file_name().unwrap().to_string_lossy();
    gripd::identify::Record::new(&name, &samples, &sensors(&inputs))
}

#[test]
fn both_zoes_have_the_same_tires_as_far_as_they_tell() {
    let Some(folder) = testing::shared("recordings") else { return };
    let text = ZOE.replace("[vehicle]", "[signals.sampling]\nperiod_ms = 20\n[vehicle]");
    let config = Config::parse(&text, &folder.join("zoe.toml")).unwrap();
    let names = "longitudinal_stiffness lateral_stiffness_front lateral_stiffness_rear steering_ratio \
        yaw_rate_offset lateral_acceleration_offset steering_wheel_angle_offset slip_offset_fl slip_offset_fr \
        slip_offset_rr";
    let settings = IdentifyConfig {
        parameters: names.split_whitespace().map(str::to_owned).collect(),
        drive: Some(LongitudinalInput::WheelSpeeds),
        starts: 1,
        profile: false,
        ..IdentifyConfig::default()
    };
    let cars = ZOES.map(|scenes| {
        let records = zoe_records(&folder, &config, scenes);
        let found = Identifier::new(&records, &config.vehicle, &settings).unwrap().run(|_, _| ()).unwrap();
        for parameter in &found.parameters {
            println!("{parameter} {:?} {}", parameter.ci95, parameter.reason);
        }
        println!("{:.0} s in {} segments, fit {:?}", found.seconds, found.segments, found.after.percent);
        found
    });
    for (one, other) in cars[0].parameters.iter().zip(&cars[1].parameters).take(4) {
        let apart = (one.value - other.value) / one.std.hypot(other.std);
        println!("{}: {apart:+.1} standard deviations apart", one.name);
        assert!(apart.abs() < 3.5, "{}", one.name);
    }
    let by_name = |car: usize, name| cars[car].parameters.iter().find(|it| it.name == name).unwrap();
    let radius = |car| by_name(car, "slip_offset_rr").value;
    assert!((radius(0) - 0.019).abs() < 0.004 && radius(1).abs() < 0.006, "{} {}", radius(0), radius(1));
    let slope = by_name(1, "longitudinal_stiffness");
    assert!(slope.identifiable && (25.0..75.0).contains(&slope.value), "{slope}");
}

/// GIVEN a lap of a wet track with a rear left wheel that is put 1.5 % too small WHEN it is checked THEN the rear wheels'
/// radii differ for certain, which of them does not show, and the gyroscope has no zero of it.
#[test]
fn a_small_rear_wheel_on_a_lap_is_no_zero_of_the_gyroscope() {
    let Some(folder) = testing::shared("recordings") else { return };
    let (config, log) = (folder.join("gti/laps.toml"), folder.join("gti/wet1.log.gz"));
    let scratch = tempfile::tempdir().unwrap();
    let changed = scratch.path().join("changed.log");
    let effect = "kind = 'tire_radius', relative_difference_rl = -0.015";
    let mut conceal = testing::program::gripd();
    conceal.args(["-q", "conceal", "--effect", effect, "-c"]).arg(&config).arg(&log).arg("-o").arg(&changed);
    assert!(conceal.status().unwrap().success());
    let mut check = testing::program::gripd();
    let output =
        check.args(["-q", "check", "--json", "-", "-c"]).arg(&config).arg(&changed).output().unwrap();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let findings = report["chain"]["findings"].as_array().unwrap();
    let of = |effect: &str| findings.iter().find(|finding| finding["effect"] == effect);
    assert!(of("sensor_bias").is_none(), "{findings:?}");
    let radius = of("tire_radius").unwrap();
    assert_eq!(radius["confidence"], "certain", "{radius}");
    let (value, std) = (radius["value"].as_f64().unwrap(), radius["std"].as_f64().unwrap());
    assert!((value.abs() - 0.015).abs() < 3.0 * std && std < 0.002, "{radius}");
    assert!(radius["channel"].as_str().unwrap().starts_with("wheel_speed_r"), "{radius}");
}
