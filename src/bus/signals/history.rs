//! The last points of a quantity, and its value at an instant between them.

use physics::Micros;

/// A value and when it was true. Not a number marks that the value was not available from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) time: Micros,
    pub(super) value: f64,
}

/// A ring of the newest points in strictly increasing time.
#[derive(Clone, Debug)]
pub(super) struct History {
    points: Vec<Point>,
    /// Where the newest is.
    last: usize,
    length: usize,
    /// Points nearer than this to the one before the last take the last one's place, so that the ring
    /// reaches back far enough whatever the frame rate.
    spacing: Micros,
}

impl History {
    /// Room for points as far back as `reach`; memory is taken here, once.
    pub(super) fn reaching(reach: Micros) -> Self {
        let capacity = (reach.0 / 500).clamp(64, 4096);
        let spacing = Micros(reach.0 / (capacity - 8));
        let points = vec![Point { time: Micros(0), value: f64::NAN }; capacity as usize];
        Self { points, last: 0, length: 0, spacing }
    }

    /// The newest point.
    #[inline]
    pub(super) fn last(&self) -> Option<Point> {
        if self.length > 0 { Some(self.points[self.last]) } else { None }
    }

    /// From the newest back.
    #[inline]
    fn newest_first(&self) -> impl Iterator<Item = &Point> {
        let (behind, before) = self.points.split_at(self.last + 1);
        behind.iter().rev().chain(before.iter().rev()).take(self.length)
    }

    /// Adds the newest point. At the last one's time it takes that one's place; before it, it is refused.
    #[inline]
    pub(super) fn push(&mut self, point: Point) -> bool {
        if let Some(last) = self.last() {
            if point.time < last.time {
                return false;
            }
            let crowded = point.time - last.time < self.spacing
                && self.newest_first().nth(1).is_some_and(|before| point.time - before.time < self.spacing)
                // An end of availability must not vanish in a crowd.
                && last.value.is_nan() == point.value.is_nan();
            if point.time == last.time || crowded {
                self.points[self.last] = point;
                return true;
            }
        }
        let next = self.last + 1;
        self.last = if next < self.points.len() { next } else { 0 };
        self.length = self.points.len().min(self.length + 1);
        self.points[self.last] = point;
        true
    }

    pub(super) fn clear(&mut self) {
        self.length = 0;
    }

    /// The value at an instant: between two points on a straight line (or the older one's, if
    /// `interpolate` is off or they are more than `limit` apart), after the last one that one's, for as
    /// long as `limit`.
    #[inline]
    pub(super) fn at(&self, time: Micros, interpolate: bool, limit: Micros) -> At {
        let mut after: Option<Point> = None;
        for &point in self.newest_first() {
            if point.time > time {
                after = Some(point);
                continue;
            }
            if point.value.is_nan() {
                return At::NotAvailable;
            }
            let held = time - point.time;
            return match after {
                Some(next) if interpolate && !next.value.is_nan() && next.time - point.time <= limit => {
                    let share = held.0 as f64 / (next.time - point.time).0 as f64;
                    At::Value(point.value + share * (next.value - point.value))
                }
                _ if held <= limit => At::Value(point.value),
                _ => At::TooOld,
            };
        }
        At::TooOld
    }
}

/// What a history knows of an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum At {
    /// The value.
    Value(f64),
    /// The sender said that it has none.
    NotAvailable,
    /// Nothing was heard near that instant.
    TooOld,
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Micros = Micros::from_millis(100);

    fn history(points: &[(i64, f64)]) -> History {
        let mut history = History::reaching(Micros::from_millis(30));
        for &(ms, value) in points {
            history.push(Point { time: Micros::from_millis(ms), value });
        }
        history
    }

    fn at(history: &History, ms: i64) -> At {
        history.at(Micros::from_millis(ms), true, LIMIT)
    }

    #[test]
    fn between_points_on_the_line_after_them_held_then_too_old() {
        let history = history(&[(0, 1.0), (20, 3.0)]);
        assert_eq!(at(&history, -1), At::TooOld);
        assert_eq!(at(&history, 5), At::Value(1.5));
        assert_eq!(at(&history, 20), At::Value(3.0));
        assert_eq!(at(&history, 120), At::Value(3.0));
        assert_eq!(at(&history, 121), At::TooOld);
        assert_eq!(history.at(Micros::from_millis(19), false, LIMIT), At::Value(1.0));
    }

    #[test]
    fn no_line_is_drawn_across_a_gap_or_to_what_is_not_available() {
        let gap = history(&[(0, 1.0), (500, 3.0)]);
        assert_eq!(at(&gap, 90), At::Value(1.0));
        assert_eq!(at(&gap, 110), At::TooOld);
        let lost = history(&[(0, 1.0), (20, f64::NAN), (40, 5.0)]);
        assert_eq!(at(&lost, 19), At::Value(1.0));
        assert_eq!(at(&lost, 20), At::NotAvailable);
        assert_eq!(at(&lost, 39), At::NotAvailable);
        assert_eq!(at(&lost, 40), At::Value(5.0));
    }

    #[test]
    fn a_point_of_the_same_time_replaces_and_an_older_one_is_refused() {
        let mut history = history(&[(0, 1.0), (20, 3.0), (20, 4.0)]);
        assert_eq!(at(&history, 10), At::Value(2.5));
        assert!(!history.push(Point { time: Micros::from_millis(10), value: 9.0 }));
        assert_eq!(at(&history, 20), At::Value(4.0));
    }

    #[test]
    fn a_kilohertz_of_points_still_reaches_back_and_the_oldest_make_room() {
        let mut history = History::reaching(Micros::from_millis(30));
        for us in (0..5_000_000).step_by(100) {
            history.push(Point { time: Micros(us), value: us as f64 });
        }
        let At::Value(value) = history.at(Micros(4_970_000), true, LIMIT) else {
            panic!("the ring does not reach back 30 ms");
        };
        assert!((value - 4_970_000.0).abs() < 1e-6);
        assert_eq!(history.points.len(), 64);
    }
}
