//! The suite's cars: what is true of one, and what its user believes.

use super::dice::Dice;

/// Gravity, m/s².
pub const G: f64 = 9.81;

/// What is true of a car. Stiffnesses are of the axle (lateral, N/rad) and of the wheel (longitudinal, N per unit slip).
#[derive(Clone, Debug)]
pub struct Car {
    pub mass: f64,
    pub yaw_inertia: f64,
    /// Centre of gravity to the front axle, m.
    pub a: f64,
    /// Centre of gravity to the rear axle, m.
    pub b: f64,
    pub track: [f64; 2],
    /// Cornering stiffness of the front and the rear axle, N/rad.
    pub cornering: [f64; 2],
    /// Longitudinal stiffness of one wheel, N per unit slip.
    pub slip_stiffness: f64,
    pub radius: f64,
    pub wheel_inertia: f64,
    pub steering_ratio: f64,
    pub front_driven: bool,
    /// Brake torque of one wheel per bar, N m, front and rear.
    pub brake_per_bar: [f64; 2],
    /// Friction of a magic-formula tire; a linear tire has none.
    pub friction: Option<f64>,
}

/// Shape factor C and curvature factor E of every magic formula here (Pacejka 2012, ch. 4: typical lateral values).
pub const SHAPE: f64 = 1.35;
pub const CURVATURE: f64 = -0.3;

/// Relative standard deviations of what a user believes: data sheet against weighbridge; stiffness guessed.
pub struct Doubt {
    pub mass: f64,
    pub a: f64,
    pub yaw_inertia: f64,
    pub radius: f64,
    pub wheel_inertia: f64,
    pub steering_ratio: f64,
    pub slip_stiffness: f64,
    pub cornering: f64,
    pub friction: f64,
}
pub const DOUBT: Doubt = Doubt {
    mass: 0.03,
    a: 0.02,
    yaw_inertia: 0.08,
    radius: 0.008,
    wheel_inertia: 0.05,
    steering_ratio: 0.01,
    slip_stiffness: 0.10,
    cornering: 0.15,
    friction: 0.05,
};

impl Car {
    /// A random passenger car: understeering, 1200 to 1900 kg.
    pub fn random(dice: &mut Dice, magic: bool) -> Self {
        let mass = dice.between(1200.0, 1900.0);
        let wheelbase = dice.between(2.5, 2.9);
        let front_driven = dice.chance(0.7);
        let a = wheelbase * if front_driven { dice.between(0.40, 0.46) } else { dice.between(0.45, 0.50) };
        let b = wheelbase - a;
        // Axle stiffness over static axle load: a softer front axle makes the car understeer (Milliken 1995, ch. 5).
        let front = dice.between(6.5, 11.0);
        let rear = front * dice.between(1.12, 1.40);
        let load = [mass * G * b / wheelbase, mass * G * a / wheelbase];
        let mean_load = mass * G / 4.0;
        Car {
            mass,
            yaw_inertia: mass * a * b * dice.between(0.98, 1.15),
            a,
            b,
            track: [dice.between(1.48, 1.60), dice.between(1.48, 1.60)],
            cornering: [front * load[0], rear * load[1]],
            slip_stiffness: mean_load * dice.between(9.0, 16.0),
            radius: dice.between(0.295, 0.335),
            wheel_inertia: dice.between(0.9, 1.6),
            steering_ratio: dice.between(14.0, 17.5),
            front_driven,
            brake_per_bar: [dice.between(18.0, 24.0).round(), dice.between(8.0, 12.0).round()],
            friction: magic.then(|| dice.between(0.88, 1.05)),
        }
    }

    pub fn wheelbase(&self) -> f64 {
        self.a + self.b
    }

    /// Static load of one wheel of the front and of the rear axle, N.
    pub fn static_load(&self) -> [f64; 2] {
        let half = self.mass * G / (2.0 * self.wheelbase());
        [half * self.b, half * self.a]
    }

    /// Understeer gradient, rad per m/s² (Milliken 1995, eq. 5.13, linear tires).
    pub fn understeer(&self) -> f64 {
        let l = self.wheelbase();
        self.mass / l * (self.b / self.cornering[0] - self.a / self.cornering[1])
    }

    /// The car file of its user: every uncertain number is off by a draw of its own stated uncertainty.
    pub fn user_toml(&self, dice: &mut Dice) -> String {
        let mut off = |value: f64, relative: f64| {
            let z = dice.normal().clamp(-2.0, 2.0);
            let believed = value * (1.0 + relative * z);
            format!("{{ value = {believed:.6}, std = {:.3e} }}", believed * relative)
        };
        let [load_front, load_rear] = self.static_load();
        let d = DOUBT;
        let mut text = String::from(
            "# What a user knows of this car: data-sheet values with their uncertainty, tire stiffness guessed.\n\
             [dbc]\ninput = [\"trial.dbc\"]\n\n[signals]\n\
             wheel_speed_fl = \"WHEELS.WS_FL\"\nwheel_speed_fr = \"WHEELS.WS_FR\"\n\
             wheel_speed_rl = \"WHEELS.WS_RL\"\nwheel_speed_rr = \"WHEELS.WS_RR\"\n\
             yaw_rate = \"INERTIAL.YAW_RATE\"\nlateral_acceleration = \"INERTIAL.ACC_LAT\"\n\
             longitudinal_acceleration = \"INERTIAL.ACC_LON\"\nsteering_wheel_angle = \"STEERING.SW_ANGLE\"\n\
             drive_torque = \"DRIVE.DRIVE_TORQUE\"\nbrake_pressure = \"DRIVE.BRAKE_PRESSURE\"\n\n[vehicle]\n",
        );
        let mut line = |key: &str, value: String| text.push_str(&format!("{key} = {value}\n"));
        line("mass_kg", off(self.mass, d.mass));
        line("cg_to_front_m", off(self.a, d.a));
        line("wheelbase_m", format!("{:.6}", self.wheelbase()));
        line("yaw_inertia_kgm2", off(self.yaw_inertia, d.yaw_inertia));
        line("track_front_m", format!("{:.6}", self.track[0]));
        line("track_rear_m", format!("{:.6}", self.track[1]));
        line("wheel_radius_m", off(self.radius, d.radius));
        line("wheel_inertia_kgm2", off(self.wheel_inertia, d.wheel_inertia));
        line("steering_ratio", off(self.steering_ratio, d.steering_ratio));
        line("driven_axle", format!("\"{}\"", if self.front_driven { "front" } else { "rear" }));
        line("drive_torque_ratio", "1.0".into());
        line("brake_torque_per_bar_front_nm", format!("{:.1}", self.brake_per_bar[0]));
        line("brake_torque_per_bar_rear_nm", format!("{:.1}", self.brake_per_bar[1]));
        line("longitudinal_stiffness", off(self.slip_stiffness / (self.mass * G / 4.0), d.slip_stiffness));
        line("lateral_stiffness_front", off(self.cornering[0] / (2.0 * load_front), d.cornering));
        line("lateral_stiffness_rear", off(self.cornering[1] / (2.0 * load_rear), d.cornering));
        match self.friction {
            None => line("tire", "\"linear\"".into()),
            Some(friction) => {
                line("tire", "\"magic_formula\"".into());
                line("friction", off(friction, d.friction));
                line("magic_formula_shape", SHAPE.to_string());
                line("magic_formula_curvature", CURVATURE.to_string());
            }
        }
        text
    }
}
