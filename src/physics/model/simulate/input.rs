//! The inputs of a scenario, evaluated at any time.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::given::Line;
use crate::model::scenario::Piece;

/// The pieces of one input, ready to be evaluated.
#[derive(Clone, Debug)]
pub(super) struct Input {
    pieces: Vec<Part>,
}

#[derive(Clone, Debug)]
enum Part {
    Deterministic(Piece),
    Random {
        process: SmoothRandom,
        from_s: f64,
        to_s: f64,
    },
    /// From outside, at a time.
    Given(f64, Line),
}

impl Input {
    /// `rng` gives the generator of each piece by its place in the list.
    pub(super) fn new(pieces: &[Piece], duration_s: f64, rng: impl Fn(usize) -> ChaCha8Rng) -> Self {
        let part = |(i, piece): (usize, &Piece)| match piece {
            Piece::Random { rms, correlation_time_s, from_s, to_s } => Part::Random {
                process: SmoothRandom::new(*rms, *correlation_time_s, duration_s, &mut rng(i)),
                from_s: *from_s,
                to_s: *to_s,
            },
            other => Part::Deterministic(other.clone()),
        };
        Self { pieces: pieces.iter().enumerate().map(part).collect() }
    }

    /// From `t` on, what is given instead of the pieces.
    pub(super) fn give(&mut self, t: f64, line: Line) {
        self.pieces.clear();
        self.pieces.push(Part::Given(t, line));
    }

    /// The sum of the pieces at `t` seconds.
    pub(super) fn at(&self, t: f64) -> f64 {
        let part = |part: &Part| match part {
            Part::Deterministic(piece) => deterministic(piece, t),
            Part::Random { process, from_s, to_s } => {
                let fade = process.correlation_time_s;
                let share = if *from_s > 0.0 { smooth_share((t - from_s) / fade) } else { 1.0 };
                share * smooth_share((to_s - t) / fade) * process.at(t)
            }
            Part::Given(from_s, line) => line.value + line.rate * (t - from_s),
        };
        self.pieces.iter().map(part).sum()
    }
}

/// 0 before 0, 1 after 1, smooth between.
fn smooth_share(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

fn deterministic(piece: &Piece, t: f64) -> f64 {
    match piece {
        Piece::Constant { value } => *value,
        Piece::Points { points } => interpolate(points, t),
        Piece::Step { at_s, value } => {
            if t >= *at_s {
                *value
            } else {
                0.0
            }
        }
        Piece::Ramp { from_s, to_s, value } => value * ((t - from_s) / (to_s - from_s)).clamp(0.0, 1.0),
        Piece::Sine { amplitude, frequency_hz, phase_rad, offset, from_s, to_s } => {
            if t < *from_s || t > *to_s {
                return 0.0;
            }
            offset + amplitude * (TAU * frequency_hz * (t - from_s) + phase_rad).sin()
        }
        Piece::Chirp { amplitude, from_hz, to_hz, from_s, to_s } => {
            if t < *from_s || t > *to_s {
                return 0.0;
            }
            let elapsed = t - from_s;
            let rising = 0.5 * (to_hz - from_hz) / (to_s - from_s);
            amplitude * (TAU * (from_hz + rising * elapsed) * elapsed).sin()
        }
        Piece::Random { .. } => 0.0,
    }
}

/// Straight lines between points; constant outside.
fn interpolate(points: &[[f64; 2]], t: f64) -> f64 {
    let after = points.partition_point(|point| point[0] <= t);
    match (after.checked_sub(1).and_then(|i| points.get(i)), points.get(after)) {
        (Some([t0, v0]), Some([t1, v1])) => v0 + (v1 - v0) * (t - t0) / (t1 - t0),
        (Some([_, value]), None) | (None, Some([_, value])) => *value,
        (None, None) => 0.0,
    }
}

/// A Gaussian process of covariance rms² (1 + |τ|/τ_c) exp(−|τ|/τ_c): value and rate of change are
/// drawn exactly on a grid and joined by cubics, so that it can be evaluated anywhere.
#[derive(Clone, Debug)]
struct SmoothRandom {
    correlation_time_s: f64,
    spacing: f64,
    knots: Vec<[f64; 2]>,
}

/// Knots per correlation time: the cubics are then indistinguishable from the process.
const KNOTS_PER_CORRELATION_TIME: f64 = 8.0;

impl SmoothRandom {
    fn new(rms: f64, correlation_time_s: f64, duration_s: f64, rng: &mut ChaCha8Rng) -> Self {
        let spacing = correlation_time_s / KNOTS_PER_CORRELATION_TIME;
        let count = (duration_s / spacing).ceil() as usize + 2;
        // In units of rms and τ_c: stationary covariance I, transition over d = spacing/τ_c below,
        // and the covariance of the innovation, I − Φ Φᵀ, by its Cholesky factor.
        let d = 1.0 / KNOTS_PER_CORRELATION_TIME;
        let decay = (-d).exp();
        let phi = [[decay * (1.0 + d), decay * d], [-decay * d, decay * (1.0 - d)]];
        let q =
            |i: usize, j: usize| f64::from(u8::from(i == j)) - phi[i][0] * phi[j][0] - phi[i][1] * phi[j][1];
        let l00 = q(0, 0).sqrt();
        let l10 = q(1, 0) / l00;
        let l11 = (q(1, 1) - l10 * l10).max(0.0).sqrt();
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let mut knot = [normal(), normal()];
        let knots = (0..count)
            .map(|_| {
                let now = knot;
                let (n0, n1) = (normal(), normal());
                knot = [
                    phi[0][0] * now[0] + phi[0][1] * now[1] + l00 * n0,
                    phi[1][0] * now[0] + phi[1][1] * now[1] + l10 * n0 + l11 * n1,
                ];
                [rms * now[0], rms / correlation_time_s * now[1]]
            })
            .collect();
        Self { correlation_time_s, spacing, knots }
    }

    fn at(&self, t: f64) -> f64 {
        let place = (t / self.spacing).max(0.0);
        let i = place as usize;
        let (Some([v0, r0]), Some([v1, r1])) = (self.knots.get(i), self.knots.get(i + 1)) else {
            return self.knots.last().map_or(0.0, |knot| knot[0]);
        };
        let x = place - i as f64;
        let (x2, x3) = (x * x, x * x * x);
        let h = self.spacing;
        v0 * (2.0 * x3 - 3.0 * x2 + 1.0)
            + r0 * h * (x3 - 2.0 * x2 + x)
            + v1 * (3.0 * x2 - 2.0 * x3)
            + r1 * h * (x3 - x2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn smooth_random_has_the_rms_and_correlation_it_says() {
        let process = SmoothRandom::new(2.0, 0.5, 20_000.0, &mut ChaCha8Rng::seed_from_u64(1));
        let n = 200_000;
        let at = |i: usize| process.at(i as f64 * 0.1);
        let mean_of = |lag: usize| (0..n - lag).map(|i| at(i) * at(i + lag)).sum::<f64>() / (n - lag) as f64;
        assert!((mean_of(0).sqrt() - 2.0).abs() < 0.05, "{}", mean_of(0).sqrt());
        // One correlation time: (1 + 1)/e = 0.736.
        assert!((mean_of(5) / mean_of(0) - 2.0 / 1f64.exp()).abs() < 0.02);
        let rate = (0..n)
            .map(|i| (process.at(i as f64 * 0.1 + 1e-3) - process.at(i as f64 * 0.1)) / 1e-3)
            .map(|r| r * r)
            .sum::<f64>()
            / n as f64;
        assert!((rate.sqrt() - 4.0).abs() < 0.1, "{}", rate.sqrt());
    }

    #[test]
    fn points_are_joined_by_lines() {
        let points = [[1.0, 0.0], [2.0, 10.0], [2.0, 20.0], [4.0, 0.0]];
        let values = [0.0, 1.5, 2.0, 3.0, 9.0].map(|t| interpolate(&points, t));
        assert_eq!(values, [0.0, 5.0, 20.0, 10.0, 0.0]);
    }

    #[test]
    fn a_chirp_passes_its_frequencies() {
        let chirp = Piece::Chirp { amplitude: 1.0, from_hz: 1.0, to_hz: 3.0, from_s: 0.0, to_s: 10.0 };
        let crossings = (0..100_000)
            .filter(|i| {
                let t = f64::from(*i) * 1e-4;
                deterministic(&chirp, t) <= 0.0 && deterministic(&chirp, t + 1e-4) > 0.0
            })
            .count();
        assert_eq!(crossings, 20, "mean frequency 2 Hz over 10 s");
    }
}
