//! Manoeuvres that anybody can drive on a road or a lot without traffic.

use physics::Quantity;
use physics::model::scenario::{ClockConfig, DriverConfig, SensorConfig, SensorsConfig, WheelNumbers};
use physics::model::{GRAVITY, Piece, Scenario, Vehicle};

use crate::explain::Recording;

/// One of them, as one car drives it.
pub struct Manoeuvre {
    /// A word for it, as part of a file's name.
    pub name: &'static str,
    /// What to do.
    pub words: String,
    /// The same for the simulation.
    pub scenario: Scenario,
}

/// Seconds of driving straight on before it begins.
const BEGIN_S: f64 = 3.0;

/// What most tires on a dry road give without sliding, m/s², and what a slippery road leaves of that: a share of its limit.
const LATERAL_MPS2: f64 = 4.0;
const OF_LIMIT: f64 = 0.45;

/// All of them for a car, its sensors those that a recording has.
pub fn manoeuvres(vehicle: &Vehicle, recording: &Recording) -> Vec<Manoeuvre> {
    let most = LATERAL_MPS2.min(OF_LIMIT * vehicle.friction.value * GRAVITY);
    // Angle at the steering wheel for a lateral acceleration at a speed, in a steady turn.
    let angle = |lateral: f64, speed: f64| {
        let understeer = (vehicle.lateral_stiffness_front.value.recip()
            - vehicle.lateral_stiffness_rear.value.recip())
            / GRAVITY;
        let road_wheel = lateral * (vehicle.wheelbase_m.value / (speed * speed) + understeer);
        vehicle.steering_ratio.value * road_wheel.max(0.0)
    };
    let sine = |lateral: f64, speed: f64, frequency_hz: f64, [from_s, to_s]: [f64; 2]| Piece::Sine {
        amplitude: angle(lateral, speed),
        frequency_hz,
        phase_rad: 0.0,
        offset: 0.0,
        from_s,
        to_s,
    };
    let sweep = |lateral: f64, speed: f64, [from_s, to_s]: [f64; 2]| Piece::Chirp {
        amplitude: angle(lateral, speed),
        from_hz: 0.2,
        to_hz: 2.5,
        from_s,
        to_s,
    };
    // To one side, straight on, to the other side, and straight on again.
    let turns = |turn: f64, hold: f64, every: f64, seconds: f64| {
        let count = ((seconds - BEGIN_S) / every) as usize;
        let turn = |number: usize| {
            let from = BEGIN_S + number as f64 * every;
            let angle = if number.is_multiple_of(2) { turn } else { -turn };
            [[from, 0.0], [from + 0.5, angle], [from + hold - 0.5, angle], [from + hold, 0.0]]
        };
        Piece::Points { points: (0..count).flat_map(turn).collect() }
    };
    let radius = 30.0;
    let fastest = (most * radius).sqrt();
    let slow = (most * 8.0).sqrt();
    let with = |name, words: String, speeds: Vec<[f64; 2]>, steering: Vec<Piece>, seconds: f64| {
        let scenario = scenario(vehicle, recording, (&words, seconds), speeds, steering);
        Manoeuvre { name, words, scenario }
    };
    vec![
        with(
            "slalom",
            format!("two minutes of slalom at 15 m/s, to {most:.1} m/s²"),
            vec![[0.0, 15.0]],
            vec![sine(most, 15.0, 0.4, [BEGIN_S, 120.0])],
            120.0,
        ),
        with(
            "sweep",
            format!(
                "a minute at 15 m/s with small steering, slow at first and then ever quicker to 2.5 Hz, twice, to {:.1} m/s²",
                0.5 * most
            ),
            vec![[0.0, 15.0]],
            vec![sweep(0.5 * most, 15.0, [BEGIN_S, 33.0]), sweep(0.5 * most, 15.0, [33.0, 63.0])],
            63.0,
        ),
        with(
            "turns",
            format!(
                "a minute and a half at 17 m/s with quick turns of 4 s to both sides, to {:.1} m/s²",
                0.8 * most
            ),
            vec![[0.0, 17.0]],
            vec![turns(angle(0.8 * most, 17.0), 4.0, 6.0, 90.0)],
            90.0,
        ),
        with(
            "circles",
            format!(
                "two minutes of circles of {radius:.0} m, first left, then right, each from walking pace to {fastest:.0} m/s"
            ),
            vec![[0.0, 5.0], [5.0, 5.0], [58.0, fastest], [62.0, 5.0], [65.0, 5.0], [118.0, fastest]],
            vec![turns(vehicle.steering_ratio.value * vehicle.wheelbase_m.value / radius, 56.0, 60.0, 123.0)],
            123.0,
        ),
        with(
            "three_speeds",
            format!("two minutes of slow slalom, 40 s each at 8, 14 and 20 m/s, to {:.1} m/s²", 0.85 * most),
            vec![[0.0, 8.0], [40.0, 8.0], [46.0, 14.0], [83.0, 14.0], [89.0, 20.0], [126.0, 20.0]],
            vec![
                sine(0.85 * most, 8.0, 0.3, [BEGIN_S, 40.0]),
                sine(0.85 * most, 14.0, 0.3, [46.0, 83.0]),
                sine(0.85 * most, 20.0, 0.3, [89.0, 126.0]),
            ],
            126.0,
        ),
        with(
            "brake_in_curves",
            format!(
                "a minute and a half of gentle winding at {:.1} m/s², speeding up to 20 m/s and braking to 8 m/s on the way",
                0.5 * most
            ),
            (0..6).flat_map(|i| [[15.0 * f64::from(i), 8.0], [15.0 * f64::from(i) + 9.0, 20.0]]).collect(),
            vec![sine(0.5 * most, 14.0, 0.2, [BEGIN_S, 90.0])],
            90.0,
        ),
        with(
            "tight_turns",
            format!("a minute and a half of tight turns to both sides at {slow:.0} m/s, 8 m around"),
            vec![[0.0, slow]],
            vec![turns(vehicle.steering_ratio.value * vehicle.wheelbase_m.value / 8.0, 8.0, 10.0, 90.0)],
            90.0,
        ),
    ]
}

fn scenario(
    vehicle: &Vehicle,
    recording: &Recording,
    (words, seconds): (&str, f64),
    speeds: Vec<[f64; 2]>,
    steering: Vec<Piece>,
) -> Scenario {
    let sensor = SensorConfig {
        period_ms: 10.0,
        phase_ms: 0.0,
        noise_std: 0.0,
        quantum: 0.0,
        offset: 0.0,
        gain: 1.0,
        delay_ms: 0.0,
        tooth_wheel: None,
    };
    let is_there = |quantity: &Quantity| recording.has(*quantity);
    let by_name = Quantity::ALL
        .into_iter()
        .filter(is_there)
        .map(|quantity| (quantity.name().to_owned(), sensor.clone()));
    Scenario {
        description: words.to_owned(),
        duration_s: seconds,
        initial_speed_mps: speeds[0][1],
        seed: 0,
        step_us: 1000,
        truth_period_ms: 10,
        vehicle: vehicle.clone(),
        radius_difference: WheelNumbers::default(),
        steering_wheel_angle: steering,
        drive_torque: Vec::new(),
        brake_torque: Vec::new(),
        brake_pressure: Vec::new(),
        driver: Some(DriverConfig::holding(vec![Piece::Points { points: speeds }])),
        abs: None,
        road: Vec::new(),
        effect: Vec::new(),
        sensors: SensorsConfig { by_name: by_name.collect() },
        clock: ClockConfig::default(),
    }
}
