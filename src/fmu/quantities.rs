//! Units and words of what a car's FMU gives, and of the numbers of its vehicle.

/// Columns of the truth: name (of four wheels, without the wheel), unit, words.
pub(crate) const OUTPUTS: &[(&str, &str, &str)] = &[
    ("speed", "m/s", "Speed of the centre of gravity, negative in reverse"),
    ("longitudinal_velocity", "m/s", "Velocity of the centre of gravity forward"),
    ("lateral_velocity", "m/s", "Velocity of the centre of gravity to the left"),
    ("yaw_rate", "rad/s", "Yaw rate, positive to the left"),
    ("longitudinal_acceleration", "m/s2", "Acceleration of the centre of gravity forward"),
    ("lateral_acceleration", "m/s2", "Acceleration of the centre of gravity to the left"),
    ("sideslip", "rad", "Sideslip angle at the centre of gravity"),
    ("slip_angle_front", "rad", "Slip angle of the front axle, positive when it gives a force to the left"),
    ("slip_angle_rear", "rad", "Slip angle of the rear axle"),
    ("cornering_front", "1/rad", "Cornering stiffness of the front axle at zero slip angle over its load"),
    ("cornering_rear", "1/rad", "Cornering stiffness of the rear axle at zero slip angle over its load"),
    ("mu_max", "1", "Friction available, mean over the wheels by load"),
    ("mu_used", "1", "Friction in use at the wheel that uses most"),
    ("x", "m", "Place from the start along the first heading"),
    ("y", "m", "Place from the start to the left of the first heading"),
    ("heading", "rad", "Heading from the first one to the left"),
    ("steering_wheel_angle", "rad", "Angle of the steering wheel now"),
    ("steer", "rad", "Angle of the front wheels"),
    ("drive_torque", "N.m", "Drive torque of all driven wheels together, the driver's included"),
    ("brake_torque", "N.m", "Brake torque of all wheels together"),
    ("wheel_speed", "rad/s", "Angular speed"),
    ("slip", "1", "Longitudinal slip"),
    ("friction", "1", "Friction available"),
    ("fx", "N", "Force along the wheel"),
    ("fy", "N", "Force across the wheel, to the left"),
    ("fz", "N", "Load"),
];

/// Numbers of `[vehicle]`: name, unit, words.
pub(crate) const VEHICLE: &[(&str, &str, &str)] = &[
    ("mass_kg", "kg", "Mass with driver and load"),
    ("wheelbase_m", "m", "Distance between the axles"),
    ("cg_to_front_m", "m", "Distance from the centre of gravity to the front axle"),
    ("wheel_radius_m", "m", "Effective rolling radius"),
    ("steering_ratio", "1", "Steering wheel angle over road wheel angle"),
    ("yaw_inertia_kgm2", "kg.m2", "Yaw inertia"),
    ("track_front_m", "m", "Track width of the front axle"),
    ("track_rear_m", "m", "Track width of the rear axle"),
    ("cg_height_m", "m", "Height of the centre of gravity"),
    ("wheel_inertia_kgm2", "kg.m2", "Inertia of one wheel with its share of the drive line"),
    ("drive_torque_ratio", "1", "Axle torque per unit of the measured drive torque"),
    ("brake_torque_per_bar_front_nm", "N.m/bar", "Brake torque of one front wheel per bar"),
    ("brake_torque_per_bar_rear_nm", "N.m/bar", "Brake torque of one rear wheel per bar"),
    ("drag_coefficient_kg_per_m", "kg/m", "Air drag: force over speed squared"),
    ("rolling_resistance", "1", "Rolling resistance: force over load"),
    ("friction", "1", "Friction of the surface, for tires that saturate"),
    ("magic_formula_shape", "1", "Shape factor C of the magic formula"),
    ("magic_formula_curvature", "1", "Curvature factor E of the magic formula"),
    ("lateral_stiffness_front", "1/rad", "Cornering stiffness of the front axle over its static load"),
    ("lateral_stiffness_rear", "1/rad", "Cornering stiffness of the rear axle over its static load"),
    ("longitudinal_stiffness", "1", "Longitudinal stiffness of a wheel over a quarter of the weight"),
];

/// A unit in powers of the base units: factor, then kg, m, s, rad.
pub(crate) type Base = (f64, [i8; 4]);

/// Units by name, as products of base units.
pub(crate) const UNITS: &[(&str, Base)] = &[
    ("1", (1.0, [0, 0, 0, 0])),
    ("s", (1.0, [0, 0, 1, 0])),
    ("m", (1.0, [0, 1, 0, 0])),
    ("rad", (1.0, [0, 0, 0, 1])),
    ("kg", (1.0, [1, 0, 0, 0])),
    ("N", (1.0, [1, 1, -2, 0])),
    ("N.m", (1.0, [1, 2, -2, 0])),
    ("bar", (1e5, [1, -1, -2, 0])),
    ("N.m/bar", (1e-5, [0, 3, 0, 0])),
    ("m/s", (1.0, [0, 1, -1, 0])),
    ("m/s2", (1.0, [0, 1, -2, 0])),
    ("rad/s", (1.0, [0, 0, -1, 1])),
    ("1/rad", (1.0, [0, 0, 0, -1])),
    ("1/rad2", (1.0, [0, 0, 0, -2])),
    ("kg.m2", (1.0, [1, 2, 0, 0])),
    ("kg/m", (1.0, [1, -1, 0, 0])),
    ("s2/m2", (1.0, [0, -2, 2, 0])),
    ("rad/(N.m)", (1.0, [-1, -2, 2, 1])),
    ("rad.s2/m", (1.0, [0, -1, 2, 1])),
    ("m/N", (1.0, [-1, 0, 2, 0])),
];
