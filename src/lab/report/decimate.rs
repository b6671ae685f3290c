//! No more points than pixels, and no peak lost.

/// Points in order of x, of which each column of pixels keeps the first, the lowest, the highest and
/// the last. A y that is not finite is a gap.
///
/// Returns the pieces between the gaps.
pub fn lines(points: impl Iterator<Item = (f64, f64)>, column: f64) -> Vec<Vec<(f64, f64)>> {
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64)> = Vec::new();
    let mut bin: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if !point.1.is_finite() {
            end_column(&mut bin, &mut piece);
            pieces.extend((!piece.is_empty()).then(|| std::mem::take(&mut piece)));
            continue;
        }
        if bin.first().is_some_and(|first| (first.0 / column).floor() != (point.0 / column).floor()) {
            end_column(&mut bin, &mut piece);
        }
        bin.push(point);
    }
    end_column(&mut bin, &mut piece);
    pieces.extend((!piece.is_empty()).then_some(piece));
    pieces
}

fn end_column(bin: &mut Vec<(f64, f64)>, piece: &mut Vec<(f64, f64)>) {
    let count = bin.len();
    let by_y = |a: &usize, b: &usize| bin[*a].1.total_cmp(&bin[*b].1);
    let mut keep = [Some(0), (0..count).min_by(by_y), (0..count).max_by(by_y), count.checked_sub(1)];
    keep.sort_unstable();
    let mut last = None;
    for index in keep.into_iter().flatten() {
        if last != Some(index)
            && let Some(point) = bin.get(index)
        {
            piece.push(*point);
            last = Some(index);
        }
    }
    bin.clear();
}

/// A band (x, low, high) in order of x, of which each column keeps the lowest low and the highest
/// high. A row with a number that is not finite is a gap.
pub fn bands(rows: impl Iterator<Item = (f64, f64, f64)>, column: f64) -> Vec<Vec<(f64, f64, f64)>> {
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64, f64)> = Vec::new();
    for (x, low, high) in rows {
        if !(low.is_finite() && high.is_finite()) {
            pieces.extend((!piece.is_empty()).then(|| std::mem::take(&mut piece)));
            continue;
        }
        match piece.last_mut() {
            Some(last) if (last.0 / column).floor() == (x / column).floor() => {
                last.1 = last.1.min(low);
                last.2 = last.2.max(high);
            }
            _ => piece.push((x, low, high)),
        }
    }
    pieces.extend((!piece.is_empty()).then_some(piece));
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_survive_and_points_are_few() {
        let wave = (0..10_000)
            .map(|i| (f64::from(i) * 0.01, if i == 4321 { 9.0 } else { (f64::from(i) * 0.7).sin() }));
        let pieces = lines(wave, 1.0);
        assert_eq!(pieces.len(), 1);
        assert!(pieces[0].len() <= 400, "{}", pieces[0].len());
        assert!(pieces[0].contains(&(43.21, 9.0)));
        assert!(pieces[0].windows(2).all(|pair| pair[0].0 < pair[1].0), "in order");
    }

    #[test]
    fn gaps_stay_gaps() {
        let points = [(0.0, 1.0), (0.1, f64::NAN), (0.2, 2.0), (0.3, 3.0)];
        assert_eq!(lines(points.into_iter(), 1.0), [vec![(0.0, 1.0)], vec![(0.2, 2.0), (0.3, 3.0)]]);
        let rows = [(0.0, 1.0, 2.0), (0.1, 0.5, f64::NAN), (0.2, 0.5, 3.0), (0.3, 0.0, 2.0)];
        assert_eq!(bands(rows.into_iter(), 1.0), [vec![(0.0, 1.0, 2.0)], vec![(0.2, 0.0, 3.0)]]);
    }
}
