//! One time axis for all panels, with no more rows than a page can carry and no peak lost.

use std::ops::Range;

use super::Numbers;

/// Which samples each row of the page stands for.
///
/// Where there are more samples than rows, each stretch of time has two: a line's lowest and highest value in it, in
/// the order in which they came. So every peak is drawn with its own height, and at most a stretch beside its time.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Of the rows, s.
    times: Vec<f64>,
    pieces: Vec<Piece>,
    stretch_s: f64,
}

#[derive(Clone, Debug)]
enum Piece {
    /// One row.
    Sample(usize),
    /// Two rows.
    Stretch(Range<usize>),
    /// A row of gaps.
    Gap,
}

impl Grid {
    /// Samples further apart than this are not joined by a line, s.
    pub const LONGEST_STEP_S: f64 = 0.5;

    /// So many numbers of all lines together are 2.2 MB as text.
    const MOST_NUMBERS: usize = 380_000;

    /// For samples at these times (s, in order), of which a page has so many lines, the time itself counted, and so many
    /// numbers beside them.
    pub fn of_page(times: &[f64], lines: usize, others: usize) -> Self {
        Self::new(times, Self::MOST_NUMBERS.saturating_sub(others) / lines.max(1))
    }

    /// For samples at these times (s, in order), with so many rows (and one for each gap).
    pub fn new(times: &[f64], rows: usize) -> Self {
        let duration = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
        let stretches = (rows / 2).max(1);
        let stretch_s = if times.len() <= rows { 0.0 } else { duration / stretches as f64 };
        let mut grid = Self { times: Vec::new(), pieces: Vec::new(), stretch_s };
        let mut start = 0;
        for (place, time) in times.iter().enumerate() {
            let Some(before) = place.checked_sub(1).and_then(|before| times.get(before)) else { continue };
            let is_gap = time - before > Self::LONGEST_STEP_S;
            if is_gap || grid.stretch(*time) != grid.stretch(*before) || stretch_s == 0.0 {
                grid.add(times, start..place);
                start = place;
            }
            if is_gap {
                grid.pieces.push(Piece::Gap);
                grid.times.push((time + before) / 2.0);
            }
        }
        grid.add(times, start..times.len());
        grid
    }

    fn stretch(&self, time: f64) -> f64 {
        if self.stretch_s > 0.0 { (time / self.stretch_s).floor() } else { 0.0 }
    }

    fn add(&mut self, times: &[f64], samples: Range<usize>) {
        let ends = times.get(samples.start).zip(times.get(samples.end.saturating_sub(1)));
        let Some((first, last)) = ends.filter(|_| !samples.is_empty()) else { return };
        if samples.len() == 1 {
            self.pieces.push(Piece::Sample(samples.start));
            self.times.push(*first);
        } else {
            self.times.extend([first + 0.25 * (last - first), first + 0.75 * (last - first)]);
            self.pieces.push(Piece::Stretch(samples));
        }
    }

    /// Times of the rows, s.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// How long a stretch is of which only the extremes are kept, s; `None` where every sample is there.
    pub fn stretch_s(&self) -> Option<f64> {
        (self.stretch_s > 0.0).then_some(self.stretch_s)
    }

    /// A line: not-a-number where a whole stretch has no value.
    pub fn line(&self, values: &[f32]) -> Numbers {
        self.rows(values, |samples| {
            let finite = || samples.iter().enumerate().filter(|(_, value)| value.is_finite());
            let low = finite().min_by(|one, other| one.1.total_cmp(other.1));
            let high = finite().max_by(|one, other| one.1.total_cmp(other.1));
            match (low, high) {
                (Some(low), Some(high)) if low.0 <= high.0 => [*low.1, *high.1],
                (Some(low), Some(high)) => [*high.1, *low.1],
                _ => [f32::NAN; 2],
            }
        })
    }

    /// The lower edge of an interval: the lowest of each stretch.
    pub fn lower(&self, values: &[f32]) -> Numbers {
        self.rows(values, |samples| [samples.iter().copied().fold(f32::NAN, f32::min); 2])
    }

    /// The upper edge of an interval: the highest of each stretch.
    pub fn upper(&self, values: &[f32]) -> Numbers {
        self.rows(values, |samples| [samples.iter().copied().fold(f32::NAN, f32::max); 2])
    }

    fn rows(&self, values: &[f32], of_stretch: impl Fn(&[f32]) -> [f32; 2]) -> Numbers {
        let mut rows = Vec::with_capacity(self.times.len());
        for piece in &self.pieces {
            match piece {
                Piece::Gap => rows.push(f64::NAN),
                Piece::Sample(place) => rows.push(values.get(*place).map_or(f64::NAN, |v| f64::from(*v))),
                Piece::Stretch(samples) => {
                    let pair = values.get(samples.clone()).map_or([f32::NAN; 2], &of_stretch);
                    rows.extend(pair.map(f64::from));
                }
            }
        }
        Numbers::new(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(count: u32) -> Vec<f64> {
        (0..count).map(|place| f64::from(place) * 0.01).collect()
    }

    #[test]
    fn extremes_survive_with_their_height_and_nearly_their_time() {
        let times = times(360_000);
        let mut values: Vec<f32> = (0..360_000).map(|place| (place as f32 * 0.01).sin()).collect();
        values[123_456] = 9.0;
        values[123_460] = -7.0;
        let grid = Grid::new(&times, 10_000);
        let rows = grid.line(&values);
        assert_eq!(rows.len(), grid.times().len());
        assert!((9_000..=10_002).contains(&rows.len()), "{}", rows.len());
        let at = |wanted: f64| grid.times()[rows.values().iter().position(|v| *v == wanted).unwrap()];
        let stretch = grid.stretch_s().unwrap();
        assert!((at(9.0) - 1234.56).abs() < stretch && (at(-7.0) - 1234.60).abs() < stretch);
        assert!(at(9.0) < at(-7.0), "in the order in which they came");
        assert!(grid.times().windows(2).all(|pair| pair[0] < pair[1]));
        let edges = (grid.lower(&values), grid.upper(&values));
        assert!(edges.0.values().contains(&-7.0) && edges.1.values().contains(&9.0));
    }

    #[test]
    fn a_short_recording_is_there_as_it_is() {
        let grid = Grid::new(&times(5), 100);
        assert_eq!(grid.stretch_s(), None);
        assert_eq!(grid.times(), times(5));
        let values = [1.0, f32::NAN, 3.0, 4.0, 5.0];
        let rows = grid.line(&values);
        assert!(rows.values()[1].is_nan());
        assert_eq!((rows.values()[0], rows.values()[4]), (1.0, 5.0));
    }

    #[test]
    fn a_pause_is_a_gap_however_many_rows_there_are() {
        let mut times = times(100);
        times.extend((0..100).map(|place| 5.0 + f64::from(place) * 0.01));
        for rows in [4, 20, 1000] {
            let grid = Grid::new(&times, rows);
            let line = grid.line(&vec![1.0; 200]);
            let gaps: Vec<_> = (0..line.len()).filter(|row| line.values()[*row].is_nan()).collect();
            assert_eq!(gaps.len(), 1, "{rows} rows");
            assert!((1.0..5.0).contains(&grid.times()[gaps[0]]));
        }
        assert_eq!(Grid::new(&[], 10).times(), [0.0; 0]);
    }
}
