//! Several effects at once, and what is written of them.

use gripd::Quantity::{self, LateralAcceleration, LongitudinalAcceleration, YawRate};
use gripd::model::effect::{Course, EffectConfig, KINDS, Kind, Spec};
use gripd::model::{Simulation, TruthWriter, Uncertain};

use super::support::*;

pub const MANY: &str = "
    [[effect]]
    kind = \"body_roll\"
    roll_gain_rad_per_mps2 = 0.006
    [[effect]]
    kind = \"relaxation_length\"
    length_m = 0.4
    [[effect]]
    kind = \"steering_lag\"
    time_constant_s = 0.05
    [[effect]]
    kind = \"load_transfer\"
    cg_height_m = 0.6
    [[effect]]
    kind = \"roll_steer\"
    roll_steer_rad_per_rad = 0.1
    [[effect]]
    kind = \"steering_compliance\"
    compliance_rad_per_nm = 5e-5
    [[effect]]
    kind = \"crosswind\"
    series = { t = [1, 2, 3], value = [0, 400, 0] }
";

/// Millisecond steps are short enough: steps of a tenth give the same.
#[test]
fn shorter_steps_change_nothing() {
    let top = format!(
        "{AT_20} steering_wheel_angle = [{{ kind = \"sine\", amplitude = 0.4, frequency_hz = 1.5 }}]\n\
         brake_pressure = [{{ kind = \"ramp\", from_s = 2, to_s = 3, value = 20 }}]"
    );
    let drives = [1000, 100]
        .map(|step| driven(&scenario(4.0, 20.0, "magic_formula", &format!("step_us = {step}\n{top}"), MANY)));
    for (quantity, most) in [(YawRate, 5e-5), (LateralAcceleration, 2e-3), (LongitudinalAcceleration, 2e-3)] {
        let [coarse, fine] = drives.each_ref().map(|drive| drive.of(quantity));
        assert!(amplitude(fine) > 0.05);
        all_close(coarse.iter().copied().zip(fine.iter().copied()), most);
    }
}

/// Where they have nothing to say, all effects of the car together leave the plain drive.
#[test]
fn effects_of_no_size_leave_the_plain_drive() {
    let of_the_car = KINDS.iter().filter(|kind| kind.channels.is_empty());
    let effect = |kind: &&'static Kind| {
        // A friction without limit cannot be said; a share of zero of any friction can.
        let value = |spec: &Spec| spec.value(spec.mean).clamp(-1e3, 1e3);
        let numbers = kind.parameters.iter().map(|spec| Uncertain::known(value(spec))).collect();
        let course = kind.course.map_or(Course::None, |_| Course::Constant(0.0));
        EffectConfig::new(kind, None, numbers, course).unwrap()
    };
    let effects: Vec<_> = of_the_car.map(effect).collect();
    let top =
        format!("{AT_20} steering_wheel_angle = [{{ kind = \"sine\", amplitude = 0.3, frequency_hz = 1 }}]");
    let mut scenario = scenario(3.0, 20.0, "magic_formula", &top, "");
    let plain = driven(&scenario);
    scenario.effect = effects;
    let with = driven(&scenario);
    for quantity in Quantity::ALL {
        all_close(with.of(quantity).iter().copied().zip(plain.of(quantity).iter().copied()), 1e-7);
    }
}

/// Every kind at the ends of what its numbers can be, from speed through braking in turns to standstill: all
/// that is true and all that is read stays a number, and no car takes off. (On tires without a limit an unstable
/// car has none either.)
#[test]
fn effects_of_any_size_leave_a_car() {
    let top = "driver = { speed_mps = [{ kind = \"points\", points = [[0, 25], [2, 25], [5, 0]] }] }\n\
               steering_wheel_angle = [{ kind = \"sine\", amplitude = 0.5, frequency_hz = 0.7 }]";
    for tire in ["piecewise", "magic_formula", "brush"] {
        let mut scenario = scenario(6.0, 25.0, tire, top, "");
        for (kind, high) in KINDS.iter().flat_map(|kind| [(kind, false), (kind, true)]) {
            let channel = kind.channels.first().copied();
            let course = kind.disturbance(channel).map_or(Course::None, |course| Course::Stretches {
                intervals: vec![[1.0, 4.0]],
                value: if course.sign > 0.0 { 1.0 } else { 3.0 * course.size },
            });
            let number = |spec: Spec| {
                let (low, most) = spec.range();
                // A sensor cannot be early in a simulation.
                let low = if spec.name == "delay_s" { 0.0 } else { low };
                Uncertain::known(if high { most.min(1e6) } else { low })
            };
            let specs = (0..kind.parameters.len()).filter_map(|place| kind.spec(place, channel));
            let numbers = specs.map(number).collect();
            scenario.effect = vec![EffectConfig::new(kind, channel, numbers, course).unwrap()];
            let drive = driven(&scenario);
            let fastest = drive.truth.iter().map(|row| row.speed.abs()).fold(0.0, f64::max);
            assert!(fastest < 60.0, "{} {tire}: {fastest} m/s", kind.name);
            let count = |quantity: Quantity| drive.of(quantity).len();
            assert!(Quantity::ALL.iter().all(|quantity| count(*quantity) == 601), "{} {tire}", kind.name);
        }
    }
}

#[test]
fn the_table_of_truth_has_their_series() {
    let scenario = scenario(1.0, 20.0, "linear", "", MANY);
    let mut simulation = Simulation::new(&scenario, 1).unwrap();
    let columns = simulation.effect_columns().to_vec();
    let expected = "steering_lag_angle relaxation_length_front relaxation_length_rear roll_steer_angle roll_steer_rate \
                    crosswind body_roll_angle body_roll_rate";
    assert_eq!(columns, expected.split_whitespace().collect::<Vec<_>>());
    let mut writer = TruthWriter::with_effects(Vec::new(), &columns).unwrap();
    let mut rows = Vec::new();
    while let Some(tick) = simulation.next_tick() {
        rows.push(tick.effects.to_vec());
        writer.write_with(tick.truth, tick.effects).unwrap();
    }
    let text = writer.into_inner().unwrap();
    let mut reader = csv::Reader::from_reader(&*text);
    let place = reader.headers().unwrap().iter().position(|name| name == "crosswind").unwrap();
    for (row, expected) in reader.records().zip(&rows) {
        let value: f64 = row.unwrap()[place].parse().unwrap();
        assert!((value - expected[5]).abs() < 1e-8);
    }
    assert_eq!(rows.len(), 101);
}
