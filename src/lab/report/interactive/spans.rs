//! When something was so.

use super::Grid;

/// More of them in a row are no longer told apart.
const MOST: usize = 1500;

/// The stretches of time (s) of the samples for which something holds. A pause of the recording ends one. Where there are
/// too many for a page, those with the shortest pauses between them become one.
pub fn spans(times: &[f64], holds: impl Fn(usize) -> bool) -> Vec<(f64, f64)> {
    let mut spans = Vec::new();
    let mut open: Option<(f64, f64)> = None;
    let mut before = f64::NEG_INFINITY;
    for (place, time) in times.iter().copied().enumerate() {
        if time - before > Grid::LONGEST_STEP_S {
            spans.extend(open.take());
        }
        match &mut open {
            Some(span) => {
                // Up to the sample that says otherwise.
                span.1 = time;
                if !holds(place) {
                    spans.extend(open.take());
                }
            }
            None => open = holds(place).then_some((time, time)),
        }
        before = time;
    }
    spans.extend(open);
    let mut shortest = 0.02;
    while spans.len() > MOST {
        spans = joined(&spans, shortest);
        shortest *= 2.0;
    }
    spans
}

fn joined(spans: &[(f64, f64)], pause: f64) -> Vec<(f64, f64)> {
    let mut joined: Vec<(f64, f64)> = Vec::new();
    for span in spans {
        match joined.last_mut() {
            Some(last) if span.0 - last.1 < pause => last.1 = span.1,
            _ => joined.push(*span),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_begin_and_end_where_they_do() {
        let times = [0.0, 0.1, 0.2, 0.3, 5.0, 5.1];
        let of = |flags: [bool; 6]| spans(&times, |place| flags[place]);
        assert_eq!(of([false, true, true, false, false, false]), [(0.1, 0.3)]);
        assert_eq!(of([true, true, true, true, true, false]), [(0.0, 0.3), (5.0, 5.1)]);
        assert_eq!(of([false; 6]), []);
    }

    #[test]
    fn what_flickers_for_hours_becomes_few() {
        let times: Vec<f64> = (0..100_000).map(|place| f64::from(place) * 0.01).collect();
        let few = spans(&times, |place| place % 3 == 0);
        assert!(few.len() <= MOST && !few.is_empty());
        assert_eq!(few[0].0, 0.0);
    }
}
