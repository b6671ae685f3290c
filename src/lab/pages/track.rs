//! Where a car went, by dead reckoning, coloured by something.

use crate::report::Color;
use crate::report::interactive::{Grid, Numbers, Points, Shade, Shape, Source};

/// A place, m.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    x: f64,
    y: f64,
}

/// What a track is made of, sample by sample. Not-a-number: not available.
pub struct Track<'a> {
    /// s.
    pub times: &'a [f64],
    /// m/s.
    pub speed: &'a [f32],
    /// rad/s.
    pub yaw_rate: &'a [f32],
    /// Zero of the yaw rate's sensor, rad/s.
    pub offset: f64,
    /// What colours it.
    pub shade: &'a [f32],
}

impl Track<'_> {
    /// Are speed and yaw rate there at all?
    pub fn is_known(&self) -> bool {
        [self.speed, self.yaw_rate].iter().all(|column| column.iter().any(|it| it.is_finite()))
    }

    /// Is there a stretch that is too long to be bridged, and is not drawn?
    pub fn has_gaps(&self) -> bool {
        self.unknown().contains(&true)
    }

    /// As points of a figure, no more than so many; the scale of the colours has this name and goes so far.
    pub fn points(&self, (shade, most): (&str, f64), most_points: usize) -> Points {
        let mut places = self.reckoned();
        for (place, _) in places.iter_mut().zip(self.unknown()).filter(|(_, is_unknown)| *is_unknown) {
            *place = Place { x: f64::NAN, y: f64::NAN };
        }
        let step = places.len().div_ceil(most_points).max(1);
        let thinned = |of: &dyn Fn(usize) -> f64| (0..places.len()).step_by(step).map(of).collect::<Vec<_>>();
        let of_place =
            |of: fn(&Place) -> f64| Numbers::new(thinned(&|it| places.get(it).map_or(f64::NAN, of)));
        // The one that is largest until the next point: nothing short is lost.
        let largest = |it: usize| {
            let part = self.shade.get(it..(it + step).min(self.shade.len())).unwrap_or_default();
            let finite = part.iter().copied().filter(|it| it.is_finite());
            finite.max_by(|one, other| one.abs().total_cmp(&other.abs())).map_or(f64::NAN, f64::from)
        };
        Points {
            name: "track".into(),
            source: Source::Estimated,
            color: Color::First,
            shape: Shape::Path,
            times: Numbers::rounded(thinned(&|it| self.times.get(it).copied().unwrap_or(f64::NAN)), 2),
            x: of_place(|it| it.x),
            y: of_place(|it| it.y),
            shade: Some(Shade { name: shade.into(), values: Numbers::new(thinned(&largest)), most }),
        }
    }

    /// Which samples are of a stretch without speed or yaw rate that is longer than what lines bridge: where the car went is
    /// not known there.
    fn unknown(&self) -> Vec<bool> {
        let mut unknown = vec![false; self.times.len()];
        let is_missing = |(speed, rate): (&f32, &f32)| !(speed.is_finite() && rate.is_finite());
        let missing: Vec<bool> = self.speed.iter().zip(self.yaw_rate).map(is_missing).collect();
        let mut begin = 0;
        for stretch in missing.chunk_by(|one, other| one == other) {
            let end = (begin + stretch.len()).min(unknown.len());
            let seconds = self.times.get(end).or(self.times.last()).zip(self.times.get(begin));
            if stretch[0] && seconds.is_some_and(|(to, from)| to - from > Grid::LONGEST_STEP_S) {
                unknown[begin..end].fill(true);
            }
            begin = end;
        }
        // Behind a pause another line begins.
        for (place, pair) in self.times.windows(2).enumerate() {
            unknown[place + 1] |= pair[1] - pair[0] > Grid::LONGEST_STEP_S;
        }
        unknown
    }

    /// Follows speed and yaw rate from the origin, first along x. Where one of them is missing the car is taken to go on as
    /// before; over a short pause, in which somebody has left out what it braked, it goes on evenly; a long one counts as nothing.
    fn reckoned(&self) -> Vec<Place> {
        /// Slower than this the car stands, and an offset would turn it, m/s.
        const STANDING: f64 = 0.1;
        /// A pause that is longer is the recording's, s.
        const LONGEST_PAUSE_S: f64 = 10.0;
        let (mut place, mut course) = (Place { x: 0.0, y: 0.0 }, 0.0_f64);
        let (mut last_speed, mut last_rate) = (0.0, 0.0);
        let mut before = None;
        let known = |value: f32, last: f64| if value.is_finite() { f64::from(value) } else { last };
        let all = self.times.iter().zip(self.speed.iter().zip(self.yaw_rate));
        all.map(|(time, (speed, rate))| {
            let step = before.replace(*time).map_or(0.0, |before| time - before);
            let step = if step <= LONGEST_PAUSE_S { step } else { 0.0 };
            let now = known(*speed, last_speed);
            let turning =
                if now > STANDING { known(*rate, last_rate + self.offset) - self.offset } else { 0.0 };
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reckoned(step: f64, speed: &[f32], rate: f32, offset: f64) -> Vec<Place> {
        let times: Vec<f64> = (0..speed.len()).map(|place| place as f64 * step).collect();
        let yaw_rate = vec![rate; speed.len()];
        Track { times: &times, speed, yaw_rate: &yaw_rate, offset, shade: &[] }.reckoned()
    }

    #[test]
    fn a_circle_comes_back_to_its_start() {
        // 20 m/s on a radius of 50 m, with an offset of the yaw rate.
        let places = reckoned(0.01, &[20.0; 1571], 0.41, 0.01);
        let last = places.last().unwrap();
        assert!(last.x.hypot(last.y) < 0.3, "{last:?}");
        let top = places.iter().map(|it| it.y).fold(0.0, f64::max);
        assert!((top - 100.0).abs() < 0.3, "twice the radius, to the left: {top}");
    }

    #[test]
    fn a_long_stretch_without_a_reading_is_a_gap() {
        let times: Vec<f64> = (0..100).map(|place| f64::from(place) * 0.1).collect();
        let mut rate = vec![0.1_f32; 100];
        rate[20..23].fill(f32::NAN);
        rate[40..60].fill(f32::NAN);
        let track = Track { times: &times, speed: &[10.0; 100], yaw_rate: &rate, offset: 0.0, shade: &[] };
        let unknown = track.unknown();
        assert!((0..100).all(|place| unknown[place] == (40..60).contains(&place)), "{unknown:?}");
        assert!(track.has_gaps());
        let points = track.points(("error", 1.0), 1000);
        let gaps = points.x.values().iter().filter(|x| x.is_nan()).count();
        assert_eq!((gaps, points.y.values().len()), (20, 100));
        // Two seconds that are left out as a whole are a gap, too, and the way goes on behind them.
        let [times, rate]: [Vec<f64>; 2] = [times, vec![0.0; 100]].map(|mut all| {
            all.drain(40..60);
            all
        });
        let rate: Vec<f32> = rate.iter().map(|it| *it as f32).collect();
        let track = Track { times: &times, speed: &[10.0; 80], yaw_rate: &rate, offset: 0.0, shade: &[] };
        assert!((0..80).all(|place| track.unknown()[place] == (place == 40)));
        let end = track.reckoned().pop().unwrap();
        assert!((end.x - 98.5).abs() < 1.0 && end.y == 0.0, "{end:?}");
    }

    #[test]
    fn a_straight_line_is_straight_and_standing_turns_nothing() {
        let speed: Vec<f32> = (0..300).map(|it| if it < 100 { 10.0 } else { 0.0 }).collect();
        let places = reckoned(0.1, &speed, 0.002, 0.002);
        let last = places.last().unwrap();
        assert!((last.x - 100.0).abs() < 1.1 && last.y.abs() < 1e-3, "{last:?}");
        // A missing reading of either is bridged.
        let mut gap = speed;
        gap[50] = f32::NAN;
        let bridged = reckoned(0.1, &gap, 0.0, 0.0);
        assert_eq!(bridged.last().map(|it| it.x), Some(last.x));
    }
}
