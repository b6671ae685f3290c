//! The drives: the demo's car and sensors on asphalt, with what the test wants of road, driver and load.

use std::fmt::Write as _;
use std::path::Path;

use gripd::Config;
use gripd::model::Scenario;

const SERVICE: &str = include_str!("../../../config/demo.toml");
const CAR: &str = include_str!("../../../config/scenarios/demo.toml");

/// Friction of the asphalt.
pub const FRICTION: f64 = 1.0;

/// What the service is told: the data sheet.
pub fn config() -> Config {
    Config::parse(SERVICE, Path::new("demo.toml")).unwrap()
}

/// A drive of the demo's car; `inputs` are the driver's, `effects` what else there is.
pub fn scenario(seconds: f64, initial_speed: f64, inputs: &str, effects: &str) -> Scenario {
    let vehicle = &CAR[CAR.find("[vehicle]").unwrap()..CAR.find("[[road]]").unwrap()];
    let sensors = &CAR[CAR.find("[sensors.wheel_speed]").unwrap()..];
    let text = format!(
        "duration_s = {seconds}\ninitial_speed_mps = {initial_speed}\nseed = 5\n{inputs}\n{vehicle}\n\
         [[road]]\nname = \"asphalt\"\nfriction = {FRICTION}\nslope = 95.0\n[abs]\n{effects}\n{sensors}"
    );
    Scenario::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A driver who holds the speed through these points, and wavers by `rms` (m/s).
pub fn holding(points: &[[f64; 2]], rms: f64) -> String {
    format!(
        "[driver]\n[[driver.speed_mps]]\nkind = \"points\"\npoints = {points:?}\n\
         [[driver.speed_mps]]\nkind = \"random\"\nrms = {rms}\ncorrelation_time_s = 20.0\n"
    )
}

/// Steering at random, rms of the steering wheel angle, rad, until a time.
pub fn wavering(rms: f64, correlation_s: f64, until_s: f64) -> String {
    format!(
        "[[steering_wheel_angle]]\nkind = \"random\"\nrms = {rms}\ncorrelation_time_s = {correlation_s}\nto_s = {until_s}\n"
    )
}

/// An input through points.
pub fn through(input: &str, points: &[[f64; 2]]) -> String {
    format!("[[{input}]]\nkind = \"points\"\npoints = {points:?}\n")
}

/// An effect whose course goes through points.
pub fn course(kind: &str, points: &[[f64; 2]]) -> String {
    let [t, value] = [0, 1].map(|i| points.iter().map(|point| point[i]).collect::<Vec<_>>());
    format!("[[effect]]\nkind = \"{kind}\"\nseries = {{ t = {t:?}, value = {value:?} }}\n")
}

/// A straight motorway, the lane kept with fractions of a degree.
pub fn motorway(seconds: f64) -> Scenario {
    let inputs = holding(&[[0.0, 33.0]], 0.7) + &wavering(0.006, 2.0, seconds);
    scenario(seconds, 33.0, &inputs, "")
}

/// Country road, then standing with the engine running, then driving off.
pub fn traffic_jam(standing_from: f64, standing_to: f64) -> Scenario {
    let stop = [[0.0, 15.0], [standing_from - 15.0, 15.0], [standing_from - 5.0, 0.0]];
    let go = [[standing_to, 0.0], [standing_to + 8.0, 12.0]];
    let speed = [stop.as_slice(), &go].concat();
    let driver = format!("[driver]\nspeed_mps = [{{ kind = \"points\", points = {speed:?} }}]\n");
    let inputs = driver + &wavering(0.3, 1.0, standing_from - 15.0);
    scenario(standing_to + 20.0, 15.0, &inputs, "")
}

/// Three minutes of country road, until the offsets and stiffnesses are known; then `turns` times back and forth with
/// the wheels turned, at walking pace. No driver of the simulator's goes backwards: torques do it.
pub fn parking(turns: u32) -> Scenario {
    let begin = 200.0;
    let (mut drive, mut brake, mut steer) = (vec![[0.0, 0.0]], vec![[0.0, 0.0]], vec![[begin - 5.0, 0.0]]);
    for turn in 0..turns {
        let from = begin + 20.0 * f64::from(turn);
        let way = if turn % 2 == 0 { -1.0 } else { 1.0 };
        // Lock to lock while standing, then move for ten seconds, then brake.
        steer.extend([[from, 0.0], [from + 2.0, way * 7.0], [from + 14.0, way * 7.0], [from + 16.0, 0.0]]);
        drive.extend([[from + 3.0, 0.0], [from + 3.5, way * 350.0], [from + 6.0, way * 60.0]]);
        drive.extend([[from + 12.0, way * 60.0], [from + 12.2, 0.0]]);
        brake.extend([[from + 12.5, 0.0], [from + 13.0, 1500.0], [from + 19.0, 1500.0], [from + 19.5, 0.0]]);
    }
    let country = [[0.0, 90.0], [begin - 30.0, 90.0], [begin - 29.0, 0.0]];
    let gas = format!(
        "[[drive_torque]]\nkind = \"sine\"\namplitude = 200.0\nfrequency_hz = 0.1\nto_s = {}\n",
        begin - 30.0
    );
    let stop = [[begin - 29.0, 0.0], [begin - 28.0, 1500.0], [begin - 1.0, 1500.0], [begin - 0.5, 0.0]];
    let inputs = through("drive_torque", &country)
        + &gas
        + &through("drive_torque", &drive)
        + &through("brake_torque", &stop)
        + &through("brake_torque", &brake)
        + &wavering(0.3, 1.0, begin - 30.0)
        + &through("steering_wheel_angle", &steer);
    scenario(begin + 20.0 * f64::from(turns), 15.0, &inputs, "")
}

/// Reversing a long way, faster than one should, and winding.
pub fn reverse(seconds: f64) -> Scenario {
    let inputs = through("drive_torque", &[[0.0, -62.0]]) + &wavering(0.5, 1.5, seconds);
    scenario(seconds, -7.0, &inputs, "")
}

/// Curves to the left and to the right, the road banked into each by 0.08 rad.
pub fn banked_curves(curves: u32) -> Scenario {
    let (mut steer, mut bank) = (vec![[0.0, 0.0]], vec![[0.0, 0.0]]);
    for curve in 0..curves {
        let from = 60.0 + 40.0 * f64::from(curve);
        let way = if curve % 2 == 0 { 1.0 } else { -1.0 };
        let (angle, slope) = (way * 0.22, way * 0.08);
        steer.extend([[from, 0.0], [from + 3.0, angle], [from + 20.0, angle], [from + 23.0, 0.0]]);
        bank.extend([[from, 0.0], [from + 3.0, slope], [from + 20.0, slope], [from + 23.0, 0.0]]);
    }
    let seconds = 80.0 + 40.0 * f64::from(curves);
    let inputs = holding(&[[0.0, 25.0]], 0.7)
        + &wavering(0.1, 1.0, seconds)
        + &through("steering_wheel_angle", &steer);
    scenario(seconds, 25.0, &inputs, &course("road_bank", &bank))
}

/// A caravan over the hills, which the simulator does not have: its load on the hitch, its drag, its rolling
/// resistance; and grades twice as steep as they are, because they pull at twice the mass.
pub fn trailer(hills: u32) -> Scenario {
    let (mut grade, mut speed) = (vec![[0.0, 0.0]], vec![[0.0, 22.0]]);
    for hill in 0..hills {
        let from = 40.0 + 80.0 * f64::from(hill);
        grade.extend([[from, 0.0], [from + 8.0, 0.1], [from + 30.0, 0.1], [from + 38.0, -0.08]]);
        grade.extend([[from + 60.0, -0.08], [from + 68.0, 0.0]]);
        speed.extend([[from, 22.0], [from + 20.0, 15.0], [from + 40.0, 15.0], [from + 70.0, 22.0]]);
    }
    let seconds = 60.0 + 80.0 * f64::from(hills);
    let mut effects = course("road_grade", &grade);
    write!(
        effects,
        "[[effect]]\nkind = \"payload\"\nmass_kg = 75.0\nposition_behind_cg_m = 2.4\n\
         [[effect]]\nkind = \"air_drag\"\ndrag_coefficient_kg_per_m = 0.9\n\
         [[effect]]\nkind = \"rolling_resistance\"\ncoefficient = 0.01\n"
    )
    .unwrap();
    scenario(seconds, 22.0, &(holding(&speed, 0.3) + &wavering(0.08, 1.0, seconds)), &effects)
}

/// A winding road driven so that ESP brakes single wheels, half a second each time.
pub fn interventions(count: u32) -> Scenario {
    let mut moment = vec![[0.0, 0.0]];
    for intervention in 0..count {
        let from = 30.0 + 15.0 * f64::from(intervention);
        let size = if intervention % 2 == 0 { 3000.0 } else { -3000.0 };
        moment.extend([[from, 0.0], [from + 0.1, size], [from + 0.5, size], [from + 0.6, 0.0]]);
    }
    let seconds = 40.0 + 15.0 * f64::from(count);
    let inputs = holding(&[[0.0, 20.0]], 1.5) + &wavering(0.25, 1.0, seconds);
    scenario(seconds, 20.0, &inputs, &course("brake_yaw_moment", &moment))
}

/// Winding roads; from a minute on a sensor drifts to `size` within so many seconds, and stays there.
pub fn drifting(channel: &str, size: f64, within_s: f64) -> Scenario {
    let inputs = holding(&[[0.0, 20.0]], 1.0) + &wavering(0.25, 1.0, 400.0);
    let effect = format!(
        "[[effect]]\nkind = \"sensor_drift\"\nchannel = \"{channel}\"\n\
         series = {{ t = [60.0, {}, 400.0], value = [0.0, {size}, {size}] }}\n",
        60.0 + within_s
    );
    scenario(400.0, 20.0, &inputs, &effect)
}
