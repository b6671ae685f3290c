//! A drive of the project's own simulator for the tests of the engine. (The proof has another: tests/concealed.)

use super::fit::{Data, Fit};
use super::model::Model;
use super::predict::noise::Noise;
use super::predict::{Drive, Recording};
use super::split::{Part, Split};
use crate::model::{Scenario, Simulation, Uncertain, Vehicle};

/// Steering, driving and braking, for forty-five seconds.
const DRIVE: &str = r#"
    duration_s = 45
    initial_speed_mps = 18
    seed = 3
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
    tire = "brush"
    [[steering_wheel_angle]]
    kind = "sine"
    amplitude = 0.7
    frequency_hz = 0.31
    [[steering_wheel_angle]]
    kind = "sine"
    amplitude = 0.3
    frequency_hz = 0.83
    [[drive_torque]]
    kind = "sine"
    amplitude = 500
    offset = 300
    frequency_hz = 0.13
    [[brake_pressure]]
    kind = "points"
    points = [[0, 0], [20, 0], [20.4, 25], [21.5, 25], [22, 0], [33, 0], [33.4, 15], [34.5, 15], [35, 0]]
    [sensors]
    wheel_speed = { period_ms = 20.0, noise_std = 0.05 }
    yaw_rate = { period_ms = 10.0, noise_std = 0.003 }
    lateral_acceleration = { period_ms = 10.0, noise_std = 0.07 }
    longitudinal_acceleration = { period_ms = 10.0, noise_std = 0.07 }
    steering_wheel_angle = { period_ms = 10.0, noise_std = 0.001 }
    drive_torque = { period_ms = 20.0, noise_std = 8.0 }
    brake_pressure = { period_ms = 20.0 }
"#;

/// The recording of that drive with effects (TOML), and what a user knows of the car.
pub fn recorded(effects: &str) -> (Vehicle, Recording) {
    let scenario = Scenario::parse(&format!("{DRIVE}\n{effects}")).unwrap();
    let mut recording = Recording { name: "bench".into(), ..Recording::default() };
    let mut simulation = Simulation::new(&scenario, scenario.seed).unwrap();
    while let Some(tick) = simulation.next_tick() {
        for reading in tick.readings {
            recording.tracks[reading.quantity as usize].push((reading.time.seconds(), reading.value));
        }
    }
    let mut vehicle = scenario.vehicle.clone();
    vehicle.mass_kg = Uncertain { value: 1560.0, std: 60.0 };
    vehicle.yaw_inertia_kgm2 = Some(Uncertain { value: 2450.0, std: 200.0 });
    vehicle.lateral_stiffness_front = Uncertain { value: 12.0, std: 1.5 };
    vehicle.lateral_stiffness_rear = Uncertain { value: 13.0, std: 1.5 };
    vehicle.longitudinal_stiffness = Uncertain { value: 28.0, std: 4.0 };
    (vehicle, recording)
}

/// The training part of drives.
pub fn training(drives: &[Drive]) -> Data<'_> {
    Data {
        drives,
        split: Split::new(drives, 0),
        part: Part::Train,
        own_noise: Noise::first(drives),
        share: 1.0,
    }
}

/// The plain model, fitted.
pub fn fitted<'a>(data: &Data<'_>, vehicle: &'a Vehicle) -> Fit<'a> {
    let plain = Model::plain(vehicle, true);
    data.fit(&plain, &plain.ordinary(|_| true), &data.own_noise, 6)
}
