//! The g-g diagram: how hard the tires were used, and how hard they could be.

use super::scene::Scene;
use crate::report::Color;
use crate::report::interactive::{Figure, Numbers, Points, Ring, Shape, Source};
use physics::model::GRAVITY;

/// Accelerations are means over so long, s: without the shaking of the road.
pub(super) const MEAN_S: f64 = 0.1;
/// More points than these say nothing more.
const MOST_POINTS: usize = 4000;
/// Of that many surfaces the friction is drawn.
const MOST_RINGS: usize = 3;

/// Means over a tenth of a second: when, across, along.
pub(super) type Use = (f64, f64, f64);

impl Scene<'_> {
    /// The figure.
    pub fn accelerations(&self) -> Figure {
        let ((across, is_across), (along, is_along)) =
            (self.lateral_acceleration(), self.longitudinal_acceleration());
        let axis = |words: &str, from: &str, is_sensor: bool| {
            if is_sensor { format!("{words}, m/s²") } else { format!("{words} ({from}), m/s²") }
        };
        let mut figure = Figure::new(
            "Use of the tires: g-g diagram",
            &axis("lateral acceleration", "speed × yaw rate", is_across),
            &axis("longitudinal acceleration", "change of the speed", is_along),
        );
        figure.is_equal = true;
        let uses = hardest(self.means(&across, &along));
        figure.points.push(Points {
            name: format!("the hardest {MEAN_S} s of each stretch"),
            source: Source::Measured,
            color: Color::First,
            shape: Shape::Dots,
            times: Numbers::rounded(uses.iter().map(|it| it.0).collect(), 1),
            x: Numbers::rounded(uses.iter().map(|it| it.1).collect(), 2),
            y: Numbers::rounded(uses.iter().map(|it| it.2).collect(), 2),
            shade: None,
        });
        figure.rings = self.rings();
        figure.answer = match uses.iter().map(|it| it.1.hypot(it.2)).reduce(f64::max) {
            Some(most) => format!("At most {most:.1} m/s² ({:.2} g) were used.", most / GRAVITY),
            None => String::new(),
        };
        figure.caption = match figure.rings.len() {
            0 => "No circle: the friction was never valid in this drive; the tires were not used enough to tell it.".into(),
            _ => "Ring: the 95 % interval of the friction, times g. A hill or a bank is in the accelerometers, too."
                .into(),
        };
        figure
    }

    /// Means of both accelerations.
    pub(super) fn means(&self, across: &[f32], along: &[f32]) -> Vec<Use> {
        let mut means = Vec::new();
        let mut sum = (0.0, 0.0, 0.0, 0_u32);
        for ((time, across), along) in self.drive.times.iter().zip(across).zip(along) {
            let (across, along) = (f64::from(*across), f64::from(*along));
            if !(across.is_finite() && along.is_finite()) {
                continue;
            }
            let start = if sum.3 > 0 { sum.0 / f64::from(sum.3) } else { *time };
            if sum.3 > 0 && time - start > MEAN_S / 2.0 {
                let count = f64::from(sum.3);
                means.push((sum.0 / count, sum.1 / count, sum.2 / count));
                sum = (0.0, 0.0, 0.0, 0);
            }
            sum = (sum.0 + time, sum.1 + across, sum.2 + along, sum.3 + 1);
        }
        means
    }

    /// The last valid interval on each surface; of the surfaces that are known best.
    fn rings(&self) -> Vec<Ring> {
        let mut last: Vec<(u32, f64, f64, f64)> = Vec::new();
        let friction = &self.drive.friction;
        for (place, _) in self.drive.flags.iter().enumerate().filter(|(_, flags)| flags.friction) {
            let of = |column: &[f32]| column.get(place).map_or(f64::NAN, |it| f64::from(*it));
            let (low, high) = (of(&friction.low), of(&friction.high));
            let (Some(surface), Some(time)) = (self.drive.changes.get(place), self.drive.times.get(place))
            else {
                continue;
            };
            if !(low.is_finite() && high.is_finite()) {
                continue;
            }
            match last.last_mut() {
                Some(it) if it.0 == *surface => *it = (*surface, *time, low, high),
                _ => last.push((*surface, *time, low, high)),
            }
        }
        last.sort_by(|one, other| (one.3 - one.2).total_cmp(&(other.3 - other.2)));
        last.truncate(MOST_RINGS);
        last.sort_by(|one, other| one.1.total_cmp(&other.1));
        let colors = [Color::Second, Color::Third, Color::Notice];
        let ring = |((_, time, low, high), color): (&(u32, f64, f64, f64), Color)| Ring {
            name: format!("friction {low:.2} to {high:.2}, found at {time:.0} s"),
            color,
            radii: (low * GRAVITY, high * GRAVITY),
        };
        last.iter().zip(colors).map(ring).collect()
    }
}

/// Few enough to be drawn: of each stretch the hardest.
fn hardest(uses: Vec<Use>) -> Vec<Use> {
    let stretch = uses.len().div_ceil(MOST_POINTS).max(1);
    let hard = |it: &Use| it.1.hypot(it.2);
    uses.chunks(stretch)
        .filter_map(|part| part.iter().copied().max_by(|one, other| hard(one).total_cmp(&hard(other))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hardest_use_is_kept_of_however_many() {
        let mut uses: Vec<Use> = (0..100_000).map(|place| (f64::from(place), 1.0, 0.0)).collect();
        uses[77_777] = (77_777.0, -9.0, -3.0);
        let few = hardest(uses);
        assert!(few.len() <= MOST_POINTS && few.contains(&(77_777.0, -9.0, -3.0)));
    }
}
