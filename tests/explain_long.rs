//! `explain` of a recording that is longer than what it searches: what shows in a few seconds of it is found.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // Tests.

use gripd::explain::{Case, Explanation, Recording, Verdict};
use gripd::model::{Scenario, Simulation, Uncertain, Vehicle};

/// Steering, driving and braking, the same over and over, for five minutes.
const DRIVE: &str = r#"
    duration_s = 306
    initial_speed_mps = 20
    seed = 11
    [vehicle]
    mass_kg = 1500
    wheelbase_m = 2.7
    cg_to_front_m = 1.2
    yaw_inertia_kgm2 = 2600
    track_front_m = 1.5
    track_rear_m = 1.5
    wheel_radius_m = 0.31
    wheel_inertia_kgm2 = 1.2
    steering_ratio = 15
    driven_axle = "front"
    drag_coefficient_kg_per_m = 0.4
    lateral_stiffness_front = 11
    lateral_stiffness_rear = 14
    longitudinal_stiffness = 30
    brake_torque_per_bar_front_nm = 20
    brake_torque_per_bar_rear_nm = 10
    tire = "linear"
    [[steering_wheel_angle]]
    kind = "sine"
    amplitude = 0.5
    frequency_hz = 0.31
    [[steering_wheel_angle]]
    kind = "sine"
    amplitude = 0.2
    frequency_hz = 0.83
    [[drive_torque]]
    kind = "sine"
    amplitude = 500
    offset = 50
    frequency_hz = 0.13
    [sensors]
    wheel_speed = { period_ms = 40.0, noise_std = 0.05 }
    yaw_rate = { period_ms = 20.0, noise_std = 0.003 }
    lateral_acceleration = { period_ms = 20.0, noise_std = 0.07 }
    steering_wheel_angle = { period_ms = 20.0, noise_std = 0.001 }
    drive_torque = { period_ms = 20.0, noise_std = 8.0 }
    brake_pressure = { period_ms = 40.0 }
"#;

/// Where the wind blows, s: eight seconds in five minutes, in the one that is not searched for its kind of driving (an
/// excerpt chosen by that alone has the others).
const GUST: [f64; 2] = [186.0, 194.0];

fn driven(effect: &str) -> (Vehicle, Recording) {
    let scenario = Scenario::parse(&format!("{DRIVE}\n{effect}")).unwrap();
    let mut recording = Recording { name: "drive".into(), ..Recording::default() };
    let mut simulation = Simulation::new(&scenario, scenario.seed).unwrap();
    while let Some(tick) = simulation.next_tick() {
        for reading in tick.readings {
            recording.tracks[reading.quantity as usize].push((reading.time.seconds(), reading.value));
        }
    }
    let mut vehicle = scenario.vehicle.clone();
    vehicle.lateral_stiffness_front = Uncertain { value: 12.0, std: 1.5 };
    vehicle.lateral_stiffness_rear = Uncertain { value: 13.0, std: 1.5 };
    (vehicle, recording)
}

fn explained(effect: &str) -> Explanation {
    let (vehicle, recording) = driven(effect);
    let recordings = [recording];
    let case =
        Case { vehicle: &vehicle, effects: &[], recordings: &recordings, held_out: 0, chain: &[], seed: 1 };
    case.explain(&|_, _| {}).explanation
}

#[test]
fn a_gust_of_eight_seconds_in_five_minutes_is_found_where_it_is() {
    let [from, to] = GUST;
    let wind = format!("[[effect]]\nkind = \"crosswind\"\nvalue = 1200.0\nintervals = [[{from}, {to}]]");
    let explanation = explained(&wind);
    assert_eq!(explanation.verdict, Verdict::MissingPhysics, "{:?}", explanation.ranking);
    let first = &explanation.findings[0];
    assert_eq!(first.effect, "crosswind");
    let inside = |[begin, end]: &[f64; 2]| *begin > from - 3.0 && *end < to + 3.0;
    assert!(
        !first.place.intervals.is_empty() && first.place.intervals.iter().all(inside),
        "{:?}",
        first.place
    );
    // Judged by all of the recording, not by what was searched.
    assert!(explanation.seconds > 300.0);
    let held: f64 = explanation.split.iter().filter(|b| b.is_holdout).map(|b| b.t[1] - b.t[0]).sum();
    assert!(held > 90.0, "{held}");
}
