//! Pictures of one line: a curve, and an interval on a scale.

use bus::watch::{Column, Series};
use physics::Quantity;

/// Heights of a curve.
const STEPS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// The last minute of a column, `width` letters; blank where there was nothing. Changes smaller than `least` look
/// flat.
pub fn curve(series: &Series, column: Column, width: usize, least: f64) -> String {
    const ROWS: usize = 600;
    let Some(place) = column.place() else { return String::new() };
    let newest = series.rows().back().map_or(0, |row| row.time.0);
    let span = ROWS as i64 * Series::STEP.0;
    let mut sums = vec![(0.0, 0u32); width];
    for row in series.rows().iter().rev().take(ROWS) {
        let back = newest - row.time.0;
        let bin = (back.max(0) * width as i64).checked_div(span).unwrap_or(0) as usize;
        let value = f64::from(row.values.get(place).copied().unwrap_or(f32::NAN));
        if let (true, Some(sum)) =
            (value.is_finite(), width.checked_sub(1 + bin).and_then(|at| sums.get_mut(at)))
        {
            *sum = (sum.0 + value, sum.1 + 1);
        }
    }
    let means: Vec<Option<f64>> =
        sums.iter().map(|(sum, count)| (*count > 0).then(|| sum / f64::from(*count))).collect();
    let low = means.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    let high = means.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
    let (middle, half) = match column {
        // These have but two values: which of them it is must be seen where nothing changes.
        Column::Input(Quantity::BrakeActive | Quantity::AbsActive) => (0.5, 0.5),
        _ => (0.5 * (low + high), 0.5 * (high - low).max(least)),
    };
    let letter = |mean: &Option<f64>| {
        mean.map_or(' ', |mean| {
            let share = 0.5 + 0.5 * (mean - middle) / half.max(f64::MIN_POSITIVE);
            let step = (share * (STEPS.len() - 1) as f64).round().clamp(0.0, 7.0) as usize;
            STEPS.get(step).copied().unwrap_or(' ')
        })
    };
    means.iter().map(letter).collect()
}

/// Below this a change of the column is noise to a reader, in its unit.
pub fn least(column: Column) -> f64 {
    match column {
        Column::Estimate("sideslip" | "slip_angle_front" | "slip_angle_rear") => 0.005,
        Column::Estimate("speed") => 0.5,
        Column::Estimate(name) if name.starts_with("mu_") => 0.05,
        Column::Estimate(name) if name.starts_with("slope_") => 2.0,
        Column::Estimate(_) => 0.5,
        Column::Input(Quantity::YawRate | Quantity::SteeringWheelAngle) => 0.05,
        Column::Input(Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration) => 0.5,
        Column::Input(Quantity::DriveTorque | Quantity::BrakeTorque) => 50.0,
        Column::Input(_) => 1.0,
    }
}

/// Where the friction is, on a scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// In use.
    pub used: f64,
    /// Lower end of what there is.
    pub low: f64,
    /// Best value.
    pub best: f64,
    /// Upper end; not a number: open.
    pub high: f64,
}

impl Scale {
    /// The scale ends here: what is above is drawn at the end.
    pub const END: f64 = 1.2;

    /// `━` what is in use, `▒` where the friction may be (`░`: or any more), `┃` the best value.
    pub fn letters(&self, width: usize) -> String {
        let cell = |value: f64| ((value / Self::END).clamp(0.0, 1.0) * width as f64) as usize;
        let known = self.low.is_finite() || self.best.is_finite();
        let from = if self.low.is_finite() { cell(self.low) } else { 0 };
        let is_open = !self.high.is_finite();
        let to = if is_open { width } else { cell(self.high).max(from + 1) };
        let best = self.best.is_finite().then(|| cell(self.best).min(width.saturating_sub(1)));
        let letter = |place: usize| match place {
            place if Some(place) == best => '┃',
            place if self.used.is_finite() && place < cell(self.used) => '━',
            place if known && (from..to).contains(&place) => {
                if is_open {
                    '░'
                } else {
                    '▒'
                }
            }
            _ => '·',
        };
        (0..width).map(letter).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_where_it_is() {
        let scale = Scale { used: 0.3, low: 0.6, best: 0.75, high: 0.9 };
        assert_eq!(scale.letters(12), "━━━···▒┃▒···");
        let open = Scale { best: f64::NAN, high: f64::NAN, ..scale };
        assert_eq!(open.letters(12), "━━━···░░░░░░");
        let nothing = Scale { used: f64::NAN, low: f64::NAN, best: f64::NAN, high: f64::NAN };
        assert_eq!(nothing.letters(4), "····");
        let beyond = Scale { used: 9.0, low: 5.0, best: 6.0, high: 7.0 };
        assert_eq!(beyond.letters(4), "━━━┃");
        assert_eq!(beyond.letters(0), "");
    }
}
