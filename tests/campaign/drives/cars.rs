//! Three cars as their data sheets have them.

/// The `[vehicle]` tables that the service is told.
pub const CARS: [&str; 3] = [COMPACT, SALOON, VAN];

/// Front-wheel drive, light.
const COMPACT: &str = r#"
mass_kg = { value = 1350.0, std = 60.0 }
wheelbase_m = 2.62
cg_to_front_m = { value = 1.08, std = 0.05 }
yaw_inertia_kgm2 = { value = 2100.0, std = 200.0 }
track_front_m = 1.53
track_rear_m = 1.52
cg_height_m = { value = 0.54, std = 0.04 }
wheel_radius_m = { value = 0.31, std = 0.004 }
wheel_inertia_kgm2 = { value = 1.2, std = 0.15 }
steering_ratio = { value = 15.2, std = 0.4 }
driven_axle = "front"
drive_torque_ratio = 1.0
brake_torque_per_bar_front_nm = { value = 20.0, std = 2.0 }
brake_torque_per_bar_rear_nm = { value = 8.0, std = 1.0 }
drag_coefficient_kg_per_m = { value = 0.38, std = 0.05 }
rolling_resistance = { value = 0.010, std = 0.002 }
longitudinal_stiffness = { value = 105.0, std = 30.0 }
lateral_stiffness_front = { value = 13.0, std = 3.0 }
lateral_stiffness_rear = { value = 16.0, std = 3.0 }
"#;

/// Rear-wheel drive.
const SALOON: &str = r#"
mass_kg = { value = 1720.0, std = 70.0 }
wheelbase_m = 2.90
cg_to_front_m = { value = 1.42, std = 0.05 }
yaw_inertia_kgm2 = { value = 3200.0, std = 300.0 }
track_front_m = 1.59
track_rear_m = 1.60
cg_height_m = { value = 0.55, std = 0.04 }
wheel_radius_m = { value = 0.325, std = 0.004 }
wheel_inertia_kgm2 = { value = 1.5, std = 0.2 }
steering_ratio = { value = 14.5, std = 0.4 }
driven_axle = "rear"
drive_torque_ratio = 1.0
brake_torque_per_bar_front_nm = { value = 24.0, std = 2.0 }
brake_torque_per_bar_rear_nm = { value = 12.0, std = 1.0 }
drag_coefficient_kg_per_m = { value = 0.37, std = 0.05 }
rolling_resistance = { value = 0.010, std = 0.002 }
longitudinal_stiffness = { value = 110.0, std = 30.0 }
lateral_stiffness_front = { value = 14.0, std = 3.0 }
lateral_stiffness_rear = { value = 17.0, std = 3.0 }
"#;

/// Front-wheel drive, tall, seldom empty.
const VAN: &str = r#"
mass_kg = { value = 2150.0, std = 120.0 }
wheelbase_m = 3.10
cg_to_front_m = { value = 1.38, std = 0.07 }
yaw_inertia_kgm2 = { value = 4400.0, std = 500.0 }
track_front_m = 1.63
track_rear_m = 1.62
cg_height_m = { value = 0.72, std = 0.06 }
wheel_radius_m = { value = 0.335, std = 0.004 }
wheel_inertia_kgm2 = { value = 1.9, std = 0.2 }
steering_ratio = { value = 16.5, std = 0.5 }
driven_axle = "front"
drive_torque_ratio = 1.0
brake_torque_per_bar_front_nm = { value = 28.0, std = 2.5 }
brake_torque_per_bar_rear_nm = { value = 13.0, std = 1.5 }
drag_coefficient_kg_per_m = { value = 0.62, std = 0.08 }
rolling_resistance = { value = 0.011, std = 0.002 }
longitudinal_stiffness = { value = 90.0, std = 30.0 }
lateral_stiffness_front = { value = 11.0, std = 3.0 }
lateral_stiffness_rear = { value = 13.0, std = 3.0 }
"#;
