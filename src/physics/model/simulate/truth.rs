//! What really happens in the plant, row by row.

use std::fmt::Write as _;
use std::io;

use crate::{Micros, Wheel};

/// The plant at one instant. What the estimates have, too, has the same name; not-a-number means
/// not available and is written as an empty field. Arrays follow [`Wheel::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// The instant, by the clock that stamps the readings.
    pub time: Micros,
    /// Speed of the centre of gravity, m/s, negative in reverse.
    pub speed: f64,
    /// Slip slope of each wheel at zero slip: longitudinal stiffness / static wheel load.
    pub slope: [f64; 4],
    /// Slip that a driven wheel shows against the other axle's wheel of its side (of nominal radius
    /// both) when no force acts: ratio of the true radii. Not available for wheels not driven.
    pub slip_offset: [f64; 4],
    /// Lateral velocity at the centre of gravity, m/s, to the left.
    pub lateral_velocity: f64,
    /// atan(v_y / v_x), rad.
    pub sideslip: f64,
    /// Slip angle of the front axle, rad, positive when it gives a force to the left.
    pub slip_angle_front: f64,
    /// Slip angle of the rear axle, rad.
    pub slip_angle_rear: f64,
    /// Cornering stiffness of the front axle at zero slip angle / its load, 1/rad.
    pub cornering_front: f64,
    /// Cornering stiffness of the rear axle at zero slip angle / its load, 1/rad.
    pub cornering_rear: f64,
    /// Friction available: load-weighted mean over the wheels.
    pub mu_max: f64,
    /// Friction in use at the wheel that uses most: √(F_x² + F_y²)/F_z.
    pub mu_used: f64,
    /// The same of the left wheels.
    pub mu_max_left: f64,
    /// The same of the right wheels.
    pub mu_max_right: f64,
    /// Friction available at each wheel.
    pub friction: [f64; 4],
    /// Longitudinal velocity, m/s.
    pub longitudinal_velocity: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Acceleration of the centre of gravity forward, m/s².
    pub longitudinal_acceleration: f64,
    /// Acceleration of the centre of gravity to the left, m/s².
    pub lateral_acceleration: f64,
    /// Place, m, from the start along the first heading.
    pub x: f64,
    /// Place, m, from the start to the left of the first heading.
    pub y: f64,
    /// Heading, rad, from the first one to the left.
    pub heading: f64,
    /// Angle at the steering wheel, rad.
    pub steering_wheel_angle: f64,
    /// Angle of the front wheels, rad.
    pub steer: f64,
    /// Drive torque of all driven wheels together, N m.
    pub drive_torque: f64,
    /// Brake torque of all wheels together as it acts, anti-lock brake included, N m.
    pub brake_torque: f64,
    /// Brake pressure that the driver asks for, bar; not available if the vehicle has no torque per
    /// bar.
    pub brake_pressure: f64,
    /// The brake is applied: 1, else 0.
    pub brake_active: f64,
    /// The anti-lock brake intervenes: 1, else 0.
    pub abs_active: f64,
    /// Angular speed of each wheel, rad/s.
    pub wheel_speed: [f64; 4],
    /// Slip of each wheel.
    pub slip: [f64; 4],
    /// Force along each wheel, N.
    pub fx: [f64; 4],
    /// Force across each wheel, N, to the left.
    pub fy: [f64; 4],
    /// Load of each wheel, N.
    pub fz: [f64; 4],
}

/// Receives the fields of a row one after the other: a name, the wheel for what each wheel has,
/// and the value.
type Visit<'a> = &'a mut dyn FnMut(&str, Option<Wheel>, f64);

impl Truth {
    /// All fields in the order of the columns.
    fn visit(&self, visit: Visit) {
        fn wheels(visit: Visit, name: &str, values: &[f64; 4]) {
            for wheel in Wheel::ALL {
                visit(name, Some(wheel), values[wheel as usize]);
            }
        }
        visit("t", None, self.time.seconds());
        visit("speed", None, self.speed);
        wheels(visit, "slope", &self.slope);
        wheels(visit, "slip_offset", &self.slip_offset);
        for (name, value) in [
            ("lateral_velocity", self.lateral_velocity),
            ("sideslip", self.sideslip),
            ("slip_angle_front", self.slip_angle_front),
            ("slip_angle_rear", self.slip_angle_rear),
            ("cornering_front", self.cornering_front),
            ("cornering_rear", self.cornering_rear),
            ("mu_max", self.mu_max),
            ("mu_used", self.mu_used),
            ("mu_max_left", self.mu_max_left),
            ("mu_max_right", self.mu_max_right),
        ] {
            visit(name, None, value);
        }
        wheels(visit, "friction", &self.friction);
        for (name, value) in [
            ("longitudinal_velocity", self.longitudinal_velocity),
            ("yaw_rate", self.yaw_rate),
            ("longitudinal_acceleration", self.longitudinal_acceleration),
            ("lateral_acceleration", self.lateral_acceleration),
            ("x", self.x),
            ("y", self.y),
            ("heading", self.heading),
            ("steering_wheel_angle", self.steering_wheel_angle),
            ("steer", self.steer),
            ("drive_torque", self.drive_torque),
            ("brake_torque", self.brake_torque),
            ("brake_pressure", self.brake_pressure),
            ("brake_active", self.brake_active),
            ("abs_active", self.abs_active),
        ] {
            visit(name, None, value);
        }
        wheels(visit, "wheel_speed", &self.wheel_speed);
        wheels(visit, "slip", &self.slip);
        wheels(visit, "fx", &self.fx);
        wheels(visit, "fy", &self.fy);
        wheels(visit, "fz", &self.fz);
    }

    /// The names of the columns, in order.
    pub fn columns() -> Vec<String> {
        let mut columns = Vec::new();
        Self::default().visit(&mut |name, wheel, _| {
            columns.push(wheel.map_or_else(|| name.to_owned(), |wheel| format!("{name}_{}", wheel.name())));
        });
        columns
    }

    /// The values, in the order of the columns.
    pub fn values(&self) -> Vec<f64> {
        let mut values = Vec::new();
        self.visit(&mut |_, _, value| values.push(value));
        values
    }

    /// A value as it is written: rounded to 9 decimals, none where it is not available.
    pub fn written(value: f64) -> Option<f64> {
        // Adding zero turns −0 into 0.
        value.is_finite().then(|| (value * 1e9).round() / 1e9 + 0.0)
    }

    /// Every value is a number where it is available at all.
    pub fn is_finite(&self) -> bool {
        let mut finite = true;
        self.visit(&mut |name, _, value| {
            finite &= value.is_finite() || matches!(name, "slip_offset" | "brake_pressure");
        });
        finite
    }
}

/// Writes rows of truth as CSV.
#[derive(Debug)]
pub struct TruthWriter<W: io::Write> {
    csv: csv::Writer<W>,
    /// Columns of effects.
    further: usize,
    /// Reused, so that a row does not allocate.
    text: String,
}

impl<W: io::Write> TruthWriter<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn new(writer: W) -> csv::Result<Self> {
        Self::with_effects(writer, &[])
    }

    /// Writes the header with the columns of effects ([`super::Simulation::effect_columns`]) at its end.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn with_effects(writer: W, columns: &[String]) -> csv::Result<Self> {
        let mut csv = csv::Writer::from_writer(writer);
        csv.write_record(Truth::columns().iter().chain(columns))?;
        Ok(Self { csv, further: columns.len(), text: String::new() })
    }

    /// Writes one row, the columns of effects empty; numbers are rounded to 9 decimals.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write(&mut self, truth: &Truth) -> csv::Result<()> {
        self.write_with(truth, &[])
    }

    /// Writes one row with what effects have ([`super::Tick::effects`]).
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write_with(&mut self, truth: &Truth, effects: &[f64]) -> csv::Result<()> {
        let (csv, text) = (&mut self.csv, &mut self.text);
        let mut result = Ok(());
        let mut write = |value: f64| {
            text.clear();
            if let Some(value) = Truth::written(value) {
                // Writing to a string does not fail.
                let _ = write!(text, "{value}");
            }
            if result.is_ok() {
                result = csv.write_field(text.as_bytes());
            }
        };
        truth.visit(&mut |_, _, value| write(value));
        let missing = std::iter::repeat(f64::NAN);
        effects.iter().copied().chain(missing).take(self.further).for_each(write);
        result?;
        csv.write_record(None::<&[u8]>)
    }

    /// Flushes what is buffered and gives the writer back.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn into_inner(self) -> io::Result<W> {
        self.csv.into_inner().map_err(csv::IntoInnerError::into_error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_and_values_agree() {
        let columns = Truth::columns();
        assert_eq!(columns.len(), Truth::default().values().len());
        let mut unique = columns.clone();
        unique.sort();
        unique.dedup();
        assert_eq!(unique.len(), columns.len());
        let shared = "t speed slope_fl slope_fr slope_rl slope_rr slip_offset_fl lateral_velocity sideslip \
                      slip_angle_front slip_angle_rear cornering_front cornering_rear mu_max mu_used";
        for name in shared.split_whitespace() {
            assert!(columns.iter().any(|column| column == name), "{name}");
        }
    }

    #[test]
    fn what_is_not_available_is_an_empty_field() {
        let mut out = Vec::new();
        let mut writer = TruthWriter::new(&mut out).unwrap();
        let truth =
            Truth { time: Micros(30_000), speed: -0.0, slip_offset: [f64::NAN; 4], ..Truth::default() };
        writer.write(&truth).unwrap();
        drop(writer);
        let text = String::from_utf8(out).unwrap();
        let row = text.lines().nth(1).unwrap();
        assert!(row.starts_with("0.03,0,0,0,0,0,,,,,0"), "{row}");
    }
}
