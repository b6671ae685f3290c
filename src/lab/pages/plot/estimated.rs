//! Panels of what gripd makes of the measurements, and when it may be acted upon.

use super::drive::{Flags, Interval};
use super::measured::corner;
use super::scene::{Scene, most};
use crate::report::Color;
use crate::report::interactive::{Panel, Source, Span, spans};
use physics::{Faults, Quantity, Wheel};

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

impl Scene<'_> {
    /// All of them.
    pub fn estimated(&self) -> Vec<Panel> {
        vec![self.sideslip(), self.cornering(), self.slope(), self.friction(), self.validity()]
    }

    fn sideslip(&self) -> Panel {
        let mut panel = Panel::new("Sideslip and slip angles", "angle, °");
        let [front, rear] = &self.drive.slip_angle;
        panel.series = vec![
            self.line("front slip angle", Source::Estimated, Color::Second, front, DEGREES),
            self.line("rear slip angle", Source::Estimated, Color::Third, rear, DEGREES),
            self.line("sideslip", Source::Estimated, Color::First, &self.drive.sideslip, DEGREES),
        ];
        panel.shades = self.shade("sideslip is valid", |it| it.motion);
        panel.reach = Some((-0.5, 0.5));
        panel.caption = "Sideslip is positive when the car moves to the left of where it points; a slip angle is positive when \
                         the tire pushes to the left."
            .into();
        panel
    }

    fn cornering(&self) -> Panel {
        let mut panel =
            Panel::new("Cornering stiffness", "side force / static axle load, per radian of slip angle");
        let [front, rear] = &self.drive.cornering;
        panel.series = vec![
            self.interval("front axle", Color::First, front),
            self.interval("rear axle", Color::Second, rear),
        ];
        panel.limits = limits(&[front, rear]);
        panel.shades = self.shade("cornering stiffness is valid", |it| it.cornering);
        panel
    }

    fn slope(&self) -> Panel {
        let mut panel = Panel::new("Slip slope of the driven wheels", "force / static wheel load, per slip");
        let colors = [Color::First, Color::Second, Color::Third, Color::Notice];
        let driven: Vec<_> =
            Wheel::ALL.into_iter().filter(|it| self.vehicle.driven_axle.drives(*it)).collect();
        for (wheel, color) in driven.iter().zip(colors) {
            let column = &self.drive.slope[*wheel as usize];
            if column.value.iter().any(|it| it.is_finite()) {
                panel.series.push(self.interval(corner(*wheel), color, column));
            }
        }
        let columns: Vec<_> = driven.iter().map(|wheel| &self.drive.slope[*wheel as usize]).collect();
        panel.limits = limits(&columns);
        panel.shades = self.shade("slip slope is valid", |it| it.slope);
        if panel.series.is_empty() {
            panel.empty = "This drive told no slip slope: the driven wheels never pulled or braked enough for it, or what \
                           it takes (wheel speeds, a drive torque or an acceleration) is not on the bus."
                .into();
        }
        panel
    }

    fn friction(&self) -> Panel {
        let mut panel = Panel::new("Friction, used and available", "friction coefficient");
        let column = &self.drive.friction;
        panel.series = vec![
            self.line("used", Source::Estimated, Color::First, &self.drive.friction_used, 1.0),
            self.line("at least available", Source::Bound, Color::Second, &column.low, 1.0),
            self.interval("available", Color::Third, column),
        ];
        panel.limits = Some((0.0, 1.6));
        panel.reach = Some((0.0, 1.0));
        panel.shades = self.shade("friction is valid", |it| it.friction);
        panel.caption = "Far below the limit nothing tells how much there is: only a lower bound, which sinks while nothing \
                         is used."
            .into();
        panel
    }

    /// When each answer was valid, what the driver did, and what was wrong.
    fn validity(&self) -> Panel {
        let mut panel = Panel::new("What was valid, and what was wrong", "");
        let mut lane = |name: &str, color: Color, holds: &dyn Fn(usize) -> bool| {
            panel.lanes.push(Span::new(name, color, &spans(&self.drive.times, holds)));
        };
        let flag = |of: fn(&Flags) -> bool| move |place: usize| self.drive.flags.get(place).is_some_and(of);
        lane("sideslip is valid", Color::Third, &flag(|it| it.motion));
        lane("cornering stiffness is valid", Color::Third, &flag(|it| it.cornering));
        lane("slip slope is valid", Color::Third, &flag(|it| it.slope));
        lane("friction is valid", Color::Third, &flag(|it| it.friction));
        for (quantity, name) in
            [(Quantity::BrakeActive, "brake applied"), (Quantity::AbsActive, "ABS at work")]
        {
            if let Some(column) = self.drive.signal(quantity) {
                lane(name, Color::First, &|place| column.get(place).is_some_and(|it| *it > 0.5));
            }
        }
        let all = self.drive.faults.iter().fold(Faults::empty(), |all, faults| all | *faults);
        for fault in all.iter() {
            let name: String = fault.names().collect();
            let name = format!("fault: {}", name.replace('_', " "));
            let holds =
                |place: usize| self.drive.faults.get(place).is_some_and(|faults| faults.contains(fault));
            lane(&name, Color::Notice, &holds);
        }
        if all.is_empty() {
            panel.caption = "No fault.".into();
        }
        panel
    }

    fn shade(&self, name: &str, of: fn(&Flags) -> bool) -> Vec<Span> {
        let holds = |place: usize| self.drive.flags.get(place).is_some_and(of);
        vec![Span::new(name, Color::Third, &spans(&self.drive.times, holds))]
    }
}

/// An interval that is not yet narrow does not decide the axis.
fn limits(columns: &[&Interval]) -> Option<(f64, f64)> {
    let top = columns.iter().filter_map(|column| most(column.value.iter().copied())).reduce(f32::max)?;
    Some((0.0, f64::from(1.7 * top)))
}
