//! The bars below a plot.

use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Area, Drawn, Plot, said};
use crate::report::Color;

impl Plot {
    pub(super) fn draw_bars(&self, area: &Area) -> Drawn {
        let fine = f64::from(Self::FINE);
        let left = fine * f64::from(Self::MARGIN + Self::Y_LABELS);
        let right = fine * f64::from(Self::WIDTH - Self::RIGHT);
        let at = |x: f64| {
            let share = (self.clip_x(x) - self.x.start) / (self.x.end - self.x.start);
            (left + share * (right - left)).round() as i32
        };
        let text = Self::text(Color::Ink).pos(Pos::new(HPos::Right, VPos::Center));
        for (row, (name, segments)) in self.bars.iter().enumerate() {
            let top = fine * Self::BAR * row as f64;
            let (from, to) = ((top + 4.0 * fine) as i32, (top + fine * (Self::BAR - 6.0)) as i32);
            let frame =
                Rectangle::new([(at(self.x.start), from), (at(self.x.end), to)], Color::Grid.placeholder());
            area.draw(&frame).map_err(said)?;
            for segment in segments {
                let corners = [(at(segment.from), from), (at(segment.to), to)];
                area.draw(&Rectangle::new(corners, segment.color.placeholder().filled())).map_err(said)?;
            }
            let place = (left as i32 - 6 * Self::FINE as i32, (from + to) / 2);
            area.draw(&Text::new(name.clone(), place, text.clone())).map_err(said)?;
        }
        Ok(())
    }

    pub(super) fn clip_x(&self, x: f64) -> f64 {
        x.clamp(self.x.start, self.x.end)
    }
}
