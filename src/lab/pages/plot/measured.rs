//! Panels of what was measured.

use super::scene::Scene;
use crate::report::Color;
use crate::report::interactive::{Panel, Series, Source};
use identify::understeer;
use physics::{Quantity, Wheel};

/// m/s to km/h.
const KMH: f64 = 3.6;
/// rad to degrees.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// A panel with one measured line: quantity, title, axis, line, and what an SI unit is in the axis's.
type Single = (Quantity, &'static str, &'static str, &'static str, f64);

const STEERING: Single =
    (Quantity::SteeringWheelAngle, "Steering wheel", "angle, °, positive to the left", "angle", DEGREES);
const YAW_RATE: Single =
    (Quantity::YawRate, "Yaw rate", "yaw rate, °/s, positive to the left", "sensor", DEGREES);

const DRIVE_AND_BRAKE: [Single; 3] = [
    (Quantity::DriveTorque, "Drive torque", "torque as the bus has it, N m", "drive torque", 1.0),
    (Quantity::BrakeTorque, "Brake torque", "torque of all wheels, N m", "brake torque", 1.0),
    (Quantity::BrakePressure, "Brake pressure", "pressure, bar", "brake pressure", 1.0),
];

impl Scene<'_> {
    /// All of them that the configuration has.
    pub fn measured(&self) -> Vec<Panel> {
        let mut panels = vec![self.speeds()];
        panels.extend(self.single(&STEERING));
        panels.extend(self.yaw_rate());
        panels.push(self.lateral());
        panels.extend(self.longitudinal());
        panels.extend(DRIVE_AND_BRAKE.iter().filter_map(|single| self.single(single)));
        panels
    }

    fn speeds(&self) -> Panel {
        let mut panel = Panel::new("Speed", "speed, km/h");
        panel.reach = Some((0.0, 10.0));
        panel.series.push(self.line("speed", Source::Estimated, Color::Ink, &self.drive.speed, KMH));
        let radius = self.vehicle.wheel_radius_m.value;
        let colors = [Color::First, Color::Second, Color::Third, Color::Notice];
        for (wheel, color) in Wheel::ALL.into_iter().zip(colors) {
            let words = format!("{} wheel", corner(wheel));
            panel.series.extend(self.quantity(Quantity::wheel_speed(wheel), &words, color, radius * KMH));
        }
        panel.series.extend(self.quantity(Quantity::VehicleSpeed, "speed on the bus", Color::Muted, KMH));
        if self.drive.quantities.iter().any(|it| it.wheel().is_some()) {
            panel.caption = format!("Wheels: turning times the rolling radius of {radius} m.");
        }
        panel
    }

    /// Beside what the configured car would turn with, were it in steady state at every moment.
    fn yaw_rate(&self) -> Option<Panel> {
        let mut panel = self.single(&YAW_RATE)?;
        let steering = self.drive.signal(Quantity::SteeringWheelAngle).unwrap_or_default();
        let gradient = understeer::of_vehicle(self.vehicle).value;
        let (wheelbase, ratio) = (self.vehicle.wheelbase_m.value, self.vehicle.steering_ratio.value);
        let steady = |(speed, angle): (&f32, &f32)| {
            let (speed, angle) = (f64::from(*speed), f64::from(*angle) / ratio);
            let base = wheelbase + gradient * speed * speed;
            // A car that oversteers has no steady state above some speed.
            if base > 0.3 * wheelbase { (speed * angle / base) as f32 } else { f32::NAN }
        };
        let steady: Vec<f32> = self.drive.speed.iter().zip(steering).map(steady).collect();
        panel.series.push(self.line(
            "the configured car, in steady state",
            Source::Expected,
            Color::Second,
            &steady,
            DEGREES,
        ));
        panel.caption = "Expected: steering and speed, with the configured wheelbase, steering ratio and cornering stiffness. It has \
                         no lag, and knows no offset of the steering."
            .into();
        Some(panel)
    }

    fn lateral(&self) -> Panel {
        let mut panel =
            Panel::new("Lateral acceleration", "lateral acceleration, m/s², positive to the left");
        panel.series.extend(self.quantity(Quantity::LateralAcceleration, "accelerometer", Color::First, 1.0));
        let expected = self.speed_by_yaw_rate();
        panel.series.push(self.line("speed × yaw rate", Source::Expected, Color::Second, &expected, 1.0));
        if panel.series.len() > 1 {
            panel.caption = "Where the two part for long, the car slides, the road is banked, the body rolls, or a sensor errs."
                .into();
        }
        panel
    }

    fn longitudinal(&self) -> Option<Panel> {
        let quantity = Quantity::LongitudinalAcceleration;
        self.drive.quantities.contains(&quantity).then(|| {
            let mut panel =
                Panel::new("Longitudinal acceleration", "longitudinal acceleration, m/s², positive forward");
            panel.series.extend(self.quantity(quantity, "accelerometer", Color::First, 1.0));
            panel.empty = self.never(quantity);
            panel
        })
    }

    fn single(&self, (quantity, title, axis, name, factor): &Single) -> Option<Panel> {
        self.drive.quantities.contains(quantity).then(|| {
            let mut panel = Panel::new(title, axis);
            panel.series.extend(self.quantity(*quantity, name, Color::First, *factor));
            panel.empty = self.never(*quantity);
            panel
        })
    }

    /// The line of a quantity, where it has any value.
    fn quantity(&self, quantity: Quantity, name: &str, color: Color, factor: f64) -> Option<Series> {
        let column = self.drive.signal(quantity)?;
        Some(self.line(name, Source::Measured, color, column, factor))
    }

    /// What there is to say of a quantity that never has a value; nothing, if it has.
    fn never(&self, quantity: Quantity) -> String {
        match self.drive.signal(quantity) {
            Some(_) => String::new(),
            None => format!(
                "{quantity} is configured and never has a value here; gripd check on this recording tells why."
            ),
        }
    }
}

/// A wheel in words.
pub fn corner(wheel: Wheel) -> &'static str {
    match wheel {
        Wheel::Fl => "front left",
        Wheel::Fr => "front right",
        Wheel::Rl => "rear left",
        Wheel::Rr => "rear right",
    }
}
