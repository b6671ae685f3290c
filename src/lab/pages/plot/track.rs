//! Where the car went, by dead reckoning.

use super::scene::{Scene, most};
use crate::report::Color;
use crate::report::interactive::{Figure, Numbers, Points, Shade, Shape, Source};
use physics::Quantity;

/// More points than these are closer together than pixels.
const MOST_POINTS: usize = 5000;

/// A place, m.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    x: f64,
    y: f64,
}

impl Scene<'_> {
    /// The track, coloured by the lateral acceleration.
    pub fn track(&self) -> Figure {
        let mut figure = Figure::new("Track", "metres ahead of the start", "metres to the left of the start");
        figure.is_equal = true;
        let drift = self.drive.last.offsets.yaw_rate.map(|it| it.value);
        let yaw_rate = self.drive.signal(Quantity::YawRate).unwrap_or_default();
        let places = reckon(
            (0..self.drive.times.len()).map(|it| self.drive.step_s(it)),
            &self.drive.speed,
            yaw_rate,
            drift.unwrap_or(0.0),
        );
        let (lateral, _) = self.lateral_acceleration();
        let step = places.len().div_ceil(MOST_POINTS).max(1);
        let thinned = |of: &dyn Fn(usize) -> f64| (0..places.len()).step_by(step).map(of).collect::<Vec<_>>();
        let of_place =
            |of: fn(&Place) -> f64| Numbers::new(thinned(&|it| places.get(it).map_or(f64::NAN, of)));
        // The one that is largest until the next point: no short bend is lost.
        let largest = |it: usize| {
            let part = lateral.get(it..(it + step).min(lateral.len())).unwrap_or_default();
            part.iter()
                .copied()
                .max_by(|one, other| one.abs().total_cmp(&other.abs()))
                .map_or(f64::NAN, f64::from)
        };
        let shade = Shade {
            name: "lateral acceleration, m/s²".into(),
            values: Numbers::rounded(thinned(&largest), 1),
            most: f64::from(most(lateral.iter().map(|it| it.abs())).unwrap_or(1.0)).max(1.0),
        };
        figure.points.push(Points {
            name: "track".into(),
            source: Source::Estimated,
            color: Color::First,
            shape: Shape::Path,
            times: Numbers::rounded(thinned(&|it| self.drive.times.get(it).copied().unwrap_or(f64::NAN)), 2),
            x: of_place(|it| it.x),
            y: of_place(|it| it.y),
            shade: Some(shade),
        });
        let corrected = match drift {
            Some(drift) => format!(
                " The yaw rate's offset of {:.2} °/s that was learned is taken off.",
                drift.to_degrees()
            ),
            None => String::new(),
        };
        figure.caption = format!(
            "From speed and yaw rate alone: it drifts by some per cent of the way. Wider where it was faster round the bend.{corrected}"
        );
        figure
    }
}

/// Follows speed (m/s) and yaw rate (rad/s, less its offset) from the origin, first along x. Where one of them is missing the
/// car is taken to go on as before.
fn reckon(steps: impl Iterator<Item = f64>, speed: &[f32], yaw_rate: &[f32], offset: f64) -> Vec<Place> {
    /// Slower than this the car stands, and an offset would turn it, m/s.
    const STANDING: f64 = 0.1;
    let (mut place, mut course) = (Place { x: 0.0, y: 0.0 }, 0.0_f64);
    let (mut last_speed, mut last_rate) = (0.0, 0.0);
    let known = |value: f32, last: f64| if value.is_finite() { f64::from(value) } else { last };
    steps
        .zip(speed.iter().zip(yaw_rate))
        .map(|(step, (speed, rate))| {
            let now = known(*speed, last_speed);
            let turning = if now > STANDING { known(*rate, last_rate + offset) - offset } else { 0.0 };
            // The middle of the step: exact to the third order.
            let mean = 0.5 * (now + last_speed);
            let middle = course + 0.25 * step * (turning + last_rate);
            place.x += step * mean * middle.cos();
            place.y += step * mean * middle.sin();
            course += 0.5 * step * (turning + last_rate);
            (last_speed, last_rate) = (now, turning);
            place
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_comes_back_to_its_start() {
        // 20 m/s on a radius of 50 m, with an offset of the yaw rate.
        let (count, step) = (1571, 0.01);
        let places = reckon(std::iter::repeat_n(step, count), &vec![20.0; count], &vec![0.41; count], 0.01);
        let last = places.last().unwrap();
        assert!(last.x.hypot(last.y) < 0.3, "{last:?}");
        let top = places.iter().map(|it| it.y).fold(0.0, f64::max);
        assert!((top - 100.0).abs() < 0.3, "twice the radius, to the left: {top}");
    }

    #[test]
    fn a_straight_line_is_straight_and_standing_turns_nothing() {
        let speed: Vec<f32> = (0..300).map(|it| if it < 100 { 10.0 } else { 0.0 }).collect();
        let places = reckon(std::iter::repeat_n(0.1, 300), &speed, &vec![0.002; 300], 0.002);
        let last = places.last().unwrap();
        assert!((last.x - 100.0).abs() < 1.1 && last.y.abs() < 1e-3, "{last:?}");
        // A missing reading of either is bridged.
        let mut gap = speed;
        gap[50] = f32::NAN;
        let bridged = reckon(std::iter::repeat_n(0.1, 300), &gap, &vec![0.0; 300], 0.0);
        assert_eq!(bridged.last().map(|it| it.x), Some(last.x));
    }
}
