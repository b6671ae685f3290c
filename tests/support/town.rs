//! A drive with everything that the measurement chain shows itself by, as a scenario.

/// A drive through a town and its surroundings: lanes kept, bends, corners, starts and brakings.
pub const DRIVE: &str = r#"
    duration_s = 150.0
    initial_speed_mps = 12.0
    [vehicle]
    mass_kg = 1550.0
    wheelbase_m = 2.68
    cg_to_front_m = { value = 1.10, std = 0.03 }
    yaw_inertia_kgm2 = 2500.0
    track_front_m = 1.54
    track_rear_m = 1.52
    wheel_radius_m = 0.316
    wheel_inertia_kgm2 = 1.3
    steering_ratio = 15.5
    driven_axle = "front"
    drag_coefficient_kg_per_m = 0.42
    rolling_resistance = 0.011
    brake_torque_per_bar_front_nm = 22.0
    brake_torque_per_bar_rear_nm = 9.0
    tire = "brush"
    longitudinal_stiffness = 40.0
    lateral_stiffness_front = { value = 13.0, std = 3.0 }
    lateral_stiffness_rear = { value = 16.0, std = 3.0 }
    [driver]
    [[driver.speed_mps]]
    kind = "points"
    points = [[0, 12], [10, 20], [25, 20], [30, 8], [40, 6], [50, 14], [65, 24], [80, 24], [86, 10], [100, 7], [110, 16], [130, 22], [140, 8], [150, 8]]
    [[driver.speed_mps]]
    kind = "random"
    rms = 1.0
    correlation_time_s = 3.0
    [[brake_pressure]]
    kind = "points"
    points = [[25, 0], [25.5, 12], [29, 12], [29.5, 0], [80, 0], [80.5, 14], [85, 14], [85.5, 0], [130, 0], [131, 8], [138, 8], [139, 0]]
    [[steering_wheel_angle]]
    kind = "points"
    points = [[12, 0], [13.5, 0.5], [17, 0.5], [18, 0], [32, 0], [33, 3.0], [37, 3.0], [38.5, 0], [42, 0], [43, -2.5], [46, -2.5], [47.5, 0], [68, 0], [69, -0.35], [72, -0.35], [73, 0], [90, 0], [92, 2.0], [95, 2.0], [96, 0], [102, 0], [103, -2.0], [106, -2.0], [107.5, 0]]
    [[steering_wheel_angle]]
    kind = "random"
    rms = 0.15
    correlation_time_s = 0.8
    [sensors]
    wheel_speed = { period_ms = 10.0, phase_ms = 2.0, quantum = 0.01, tooth_wheel = { teeth = 48, pitch_error_std = 0.004, window_ms = 10.0 } }
    yaw_rate = { period_ms = 10.0, phase_ms = 5.0, noise_std = 0.003, quantum = 0.0005, offset = 0.002, delay_ms = 3.0 }
    lateral_acceleration = { period_ms = 10.0, phase_ms = 5.0, noise_std = 0.07, quantum = 0.01, offset = 0.04, delay_ms = 3.0 }
    longitudinal_acceleration = { period_ms = 10.0, phase_ms = 5.0, noise_std = 0.07, quantum = 0.01, offset = -0.03, delay_ms = 3.0 }
    steering_wheel_angle = { period_ms = 10.0, phase_ms = 7.0, noise_std = 0.001, quantum = 0.00175, offset = 0.005 }
    drive_torque = { period_ms = 10.0, phase_ms = 8.0, noise_std = 8.0, quantum = 2.0, delay_ms = 10.0 }
    brake_pressure = { period_ms = 20.0, phase_ms = 3.0, noise_std = 0.05, quantum = 0.1 }
"#;
