//! Lines cut off where they leave the axes.

use super::Plot;

type Point = (f64, f64);

impl Plot {
    /// The pieces of a line that are within the axes, up to their very edge. What is not finite is a gap.
    pub(super) fn inside(&self, points: &[Point]) -> Vec<Vec<Point>> {
        let mut pieces: Vec<Vec<Point>> = Vec::new();
        for ends in points.windows(2) {
            let &[from, to] = ends else { continue };
            let Some((a, b)) = self.cut(from, to) else { continue };
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&a) => piece.push(b),
                _ => pieces.push(vec![a, b]),
            }
        }
        pieces
    }

    /// The part of a straight line that is within the axes (Liang and Barsky 1984).
    fn cut(&self, from: Point, to: Point) -> Option<(Point, Point)> {
        if ![from.0, from.1, to.0, to.1].iter().all(|it| it.is_finite()) {
            return None;
        }
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for (by, room) in [
            (-dx, from.0 - self.x.start),
            (dx, self.x.end - from.0),
            (-dy, from.1 - self.y.start),
            (dy, self.y.end - from.1),
        ] {
            if by == 0.0 && room < 0.0 {
                return None;
            } else if by < 0.0 {
                first = first.max(room / by);
            } else if by > 0.0 {
                last = last.min(room / by);
            }
        }
        // An end that is inside stays what it was, so that pieces meet.
        let at = |share: f64| match share {
            0.0 => from,
            1.0 => to,
            share => (from.0 + share * dx, from.1 + share * dy),
        };
        (first <= last).then(|| (at(first), at(last)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_at_the_edge_and_goes_on_where_it_comes_back() {
        let plot = Plot::new("", "", 0.0..10.0, 0.0..10.0);
        let line = [(0.0, 0.0), (2.0, 8.0), (4.0, 16.0), (6.0, 8.0), (6.0, 2.0), (f64::NAN, 0.0), (7.0, 1.0)];
        let pieces = plot.inside(&line);
        assert_eq!(
            pieces,
            [vec![(0.0, 0.0), (2.0, 8.0), (2.5, 10.0)], vec![(5.5, 10.0), (6.0, 8.0), (6.0, 2.0)]]
        );
        assert!(plot.inside(&[(20.0, 1.0), (20.0, 2.0), (30.0, 20.0)]).is_empty());
        // From outside to outside, through it.
        assert_eq!(plot.inside(&[(-5.0, 5.0), (15.0, 5.0)]), [vec![(0.0, 5.0), (10.0, 5.0)]]);
    }
}
