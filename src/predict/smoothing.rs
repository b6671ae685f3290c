//! Inputs on a grid, smoothed. Noise of an input would act on the car as a force. The window is as long as the
//! input's own movement allows.

use super::grid::STEP_S;

/// An input, or all wheels, missing for so long ends a run, s. Tuned, no test on record.
const LONGEST_GAP_S: f64 = 0.3;

/// Beyond its first and its last reading a track goes on for so long, s. Tuned, no test on record.
const BEYOND_S: f64 = 0.05;

/// An input is smoothed over one of these to each side, s. Nobody turns a wheel or a pedal faster than the
/// first; the last is half a second in all.
const WINDOWS_S: [f64; 5] = [0.055, 0.08, 0.115, 0.165, 0.24];

/// The smoothed value may leave the intervals of shorter windows by nothing; they are so many standard
/// deviations wide to each side. Statistical: intervals of 95 %.
const WIDTH_STDS: f64 = 2.0;

/// Each grid point by the longest window whose parabola agrees with those of all shorter ones (the
/// intersection of confidence intervals, Goldenshluger & Nemirovski 1997); not-a-number in gaps.
pub fn smooth_on_grid(track: &[(f64, f64)], points: usize) -> Vec<f64> {
    let values: Vec<f64> = track.iter().map(|(_, value)| *value).collect();
    let noise = white_std([values.as_slice()].into_iter()).unwrap_or(0.0);
    let mut windows = WINDOWS_S.map(|half| Window { half, from: 0, to: 0 });
    let smooth = |(k, plain): (usize, f64)| {
        let t = k as f64 * STEP_S;
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut smoothed = plain;
        for window in &mut windows {
            window.move_to(track, t);
            if !plain.is_finite() {
                continue;
            }
            let Some((value, gain)) = window.parabola(track, t) else { break };
            let wide = WIDTH_STDS * noise * gain;
            (least, most) = (least.max(value - wide), most.min(value + wide));
            if least > most && window.half > WINDOWS_S[0] {
                break;
            }
            smoothed = value;
        }
        smoothed
    };
    on_grid(track, points).into_iter().enumerate().map(smooth).collect()
}

/// The readings around a grid point.
struct Window {
    half: f64,
    from: usize,
    to: usize,
}

impl Window {
    fn move_to(&mut self, track: &[(f64, f64)], t: f64) {
        while self.from < track.len() && track[self.from].0 < t - self.half {
            self.from += 1;
        }
        while self.to < track.len() && track[self.to].0 <= t + self.half {
            self.to += 1;
        }
    }

    /// The value at `t` of the parabola through the readings, and its standard deviation where theirs is 1.
    fn parabola(&self, track: &[(f64, f64)], t: f64) -> Option<(f64, f64)> {
        let around = &track[self.from..self.to.max(self.from)];
        let (first, last) = (around.first()?, around.last()?);
        if around.len() < 4 || first.0 > t || last.0 < t {
            return None;
        }
        // Moments of the times, scaled, and of the values.
        let mut m = [0.0; 5];
        let mut y = [0.0; 3];
        for (other, value) in around {
            let x = (other - t) / self.half;
            let mut power = 1.0;
            for (i, moment) in m.iter_mut().enumerate() {
                *moment += power;
                if i < 3 {
                    y[i] += power * value;
                }
                power *= x;
            }
        }
        let normal = nalgebra::Matrix3::new(m[0], m[1], m[2], m[1], m[2], m[3], m[2], m[3], m[4]);
        let inverse = normal.try_inverse()?;
        let value = inverse.row(0).transpose().dot(&nalgebra::Vector3::from(y));
        Some((value, inverse[(0, 0)].max(0.0).sqrt()))
    }
}

/// Linear between readings; not-a-number in gaps.
pub fn on_grid(track: &[(f64, f64)], points: usize) -> Vec<f64> {
    let mut after = 0;
    let at = |k: usize| {
        let t = k as f64 * STEP_S;
        while after < track.len() && track[after].0 < t {
            after += 1;
        }
        let before = after.checked_sub(1).map(|before| track[before]);
        match (before, track.get(after)) {
            (Some((t0, a)), Some((t1, b))) if t1 - t0 <= LONGEST_GAP_S => {
                if *t1 > t0 {
                    a + (b - a) * (t - t0) / (t1 - t0)
                } else {
                    a
                }
            }
            (None, Some((t1, b))) if t1 - t <= BEYOND_S => *b,
            (Some((t0, a)), None) if t - t0 <= BEYOND_S => a,
            _ => f64::NAN,
        }
    };
    (0..points).map(at).collect()
}

/// Standard deviation of the white noise in some tracks. Second differences leave of a smooth signal
/// nothing, of white noise six times its variance.
pub fn white_std<'t>(tracks: impl Iterator<Item = &'t [f64]>) -> Option<f64> {
    let mut squares: Vec<f64> =
        tracks.flat_map(|track| track.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2) / 6.0)).collect();
    let middle = squares.len() / 2;
    if squares.is_empty() {
        return None;
    }
    let (_, median, _) = squares.select_nth_unstable_by(middle, f64::total_cmp);
    // The median of a squared normal number is 0.455 of its variance.
    Some((*median / 0.455).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings every 20 ms of something, with noise that a fixed sequence makes.
    fn track(of: impl Fn(f64) -> f64, noise: f64) -> Vec<(f64, f64)> {
        let mut state = 1_u32;
        let mut dice = move || {
            let mut sum = 0.0;
            for _ in 0..12 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum += f64::from(state) / f64::from(u32::MAX);
            }
            sum - 6.0
        };
        (0..1000).map(|i| 0.02 * f64::from(i)).map(|t| (t, of(t) + noise * dice())).collect()
    }

    fn rms_error(smoothed: &[f64], of: impl Fn(f64) -> f64, between: (f64, f64)) -> f64 {
        let at = |k: usize| k as f64 * STEP_S;
        let inside = (0..smoothed.len()).filter(|k| (between.0..between.1).contains(&at(*k)));
        let squares: Vec<f64> = inside.map(|k| (smoothed[k] - of(at(k))).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    #[test]
    fn what_hardly_moves_loses_most_of_its_noise() {
        let slow = |t: f64| 100.0 * (0.5 * t).sin();
        let smoothed = smooth_on_grid(&track(slow, 8.0), 990);
        let error = rms_error(&smoothed, slow, (1.0, 19.0));
        assert!(error < 3.5, "{error}");
    }

    #[test]
    fn what_moves_quickly_is_not_smoothed_away() {
        // A pedal that goes down within a quarter of a second.
        let quick = |t: f64| 1000.0 / (1.0 + (-(t - 10.0) / 0.04).exp());
        let smoothed = smooth_on_grid(&track(quick, 8.0), 990);
        let error = rms_error(&smoothed, quick, (9.7, 10.3));
        assert!(error < 15.0, "{error}");
    }

    #[test]
    fn gaps_stay_gaps() {
        let track: Vec<(f64, f64)> =
            track(|t| t, 0.0).into_iter().filter(|(t, _)| !(5.0..6.0).contains(t)).collect();
        let smoothed = smooth_on_grid(&track, 990);
        let at = |t: f64| smoothed[(t / STEP_S).round() as usize];
        assert!(at(5.5).is_nan() && (at(4.9) - 4.9).abs() < 1e-9 && (at(6.1) - 6.1).abs() < 1e-9);
    }
}
