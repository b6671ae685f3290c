//! The search: Levenberg–Marquardt, from segments on their own to segments that are tied.
//!
//! On its own, a segment of two seconds forgets what a wrong parameter did before, so that its residuals
//! stay small and nearly linear in the parameters: the search comes home from far away. Then the noise of
//! each channel is known from what is left, the jumps between segments tell how much the equations lose
//! in a segment (process noise), and the segments are tied as tightly as that allows: nothing that the
//! recording says is given away, and nothing is asked of a simulation over 200 s that slides.

use nalgebra::{DVector, Vector3};

use super::free::Free;
use super::longitudinal_input::LongitudinalInput;
use super::motion::Output;
use super::normal_equations::{Linearized, Point};
use super::parameter::Values;
use super::segment::Segment;
use super::shooting::{Problem, Tie};
use physics::model::Vehicle;

/// How segments are tied in the end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// As the jumps between them say.
    #[default]
    Auto,
    /// As one simulation without feedback (output error).
    FreeRun,
    /// Not at all (multiple shooting).
    Segments,
    /// One free run over each recording, the measured speed an input, with what every car has and with delays and
    /// offsets of each recording (`explain::ordinary` in `lab`).
    Ordinary,
}

/// Standard deviation of the noise of each channel.
pub(super) type Noise = [f64; Output::COUNT];

/// Where a search came to its end.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) point: Point,
    pub(super) all: Linearized,
    pub(super) noise: Noise,
    pub(super) tie: Tie,
    pub(super) iterations: u32,
    pub(super) converged: bool,
    /// By so much the variances of noise and jumps are more than what is left of the channels.
    pub(super) counts_less_by: f64,
}

impl Fit {
    /// Noise that is left, by channel.
    pub(super) fn left(&self) -> Noise {
        self.noise.map(|std| std / self.counts_less_by.sqrt())
    }
}

/// Where a part of the segments led to.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    pub(super) theta: DVector<f64>,
    noise: Noise,
    pub(super) iterations: u32,
}

impl Ahead {
    /// Has another search come to the same place? From there on both are one: nothing else of the way is
    /// remembered.
    pub(super) fn meets(&self, other: &Self) -> bool {
        (&self.theta - &other.theta).amax() < 0.01
    }
}

/// What is searched, and how.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search<'a> {
    pub(super) vehicle: &'a Vehicle,
    pub(super) values: &'a Values,
    pub(super) free: &'a [Free],
    pub(super) segments: &'a [Segment],
    pub(super) drive: LongitudinalInput,
    pub(super) method: Method,
}

/// The cost is in units of the noise: a step that gains less than this moves no parameter by more than a
/// thirtieth of its standard deviation.
const ENOUGH: f64 = 1e-3;
/// Where the cost itself is wanted, or a difference that is averaged.
const ENOUGH_FOR_COSTS: f64 = 0.02;
const MOST_ITERATIONS: u32 = 60;
/// What kinks of the tires may make a step promise and not keep.
const KINKS: f64 = 0.1;
/// How far a logarithmic coordinate goes in one step at most: threefold. What is added (offsets) is nearly linear.
const FARTHEST: f64 = 1.1;
/// So often a step is shortened before another one is looked for.
const SHORTENED: usize = 3;
/// Noise below this share of the usual one is that of arithmetic.
const LEAST_NOISE: f64 = 1e-5;

impl<'a> Search<'a> {
    fn problem(&self, noise: &Noise, tie: Tie) -> Problem<'a> {
        let mut weight = noise.map(|std| 1.0 / (std * std));
        if self.drive.prescribes_acceleration() {
            // The noise of a driven wheel's speed is at once in the simulated acceleration and in its
            // derivative by the stiffness: fitting it would make every tire too soft.
            weight[Output::LongitudinalAcceleration as usize] = 0.0;
        }
        let Search { vehicle, values, free, segments, drive, .. } = *self;
        Problem { vehicle, values, free, segments, drive, weight, tie }
    }

    /// From the coordinates of a start to the end; `noise` is a first guess. `None` if nothing could be
    /// simulated from there.
    pub(super) fn run(&self, theta: DVector<f64>, noise: &Noise) -> Option<Fit> {
        self.finish(&self.ahead(theta, noise)?, noise)
    }

    /// The first part of the way: a part of the segments shows it, all of them decide.
    pub(super) fn ahead(&self, theta: DVector<f64>, noise: &Noise) -> Option<Ahead> {
        let some: Vec<Segment> = self.sparse();
        let few = Search { segments: &some, ..*self };
        let fit = few.descend(few.begin(theta), noise, noise, Tie::NONE, 1.0)?;
        Some(Ahead { theta: fit.point.theta, noise: fit.noise, iterations: fit.iterations })
    }

    /// And the last.
    pub(super) fn finish(&self, ahead: &Ahead, noise: &Noise) -> Option<Fit> {
        let begin = self.begin(ahead.theta.clone());
        // Even for a free run: tied at once, segments that begin as measured would pull the parameters.
        let alone = self.descend(begin, &ahead.noise, noise, Tie::NONE, 5.0)?;
        let tie = match self.method {
            Method::Segments => Tie::NONE,
            Method::FreeRun => Tie::TIGHT,
            Method::Auto | Method::Ordinary => tie(&alone.all),
        };
        let mut fit = self.go_on(alone.point, Some(alone.all), &alone.noise, noise, tie, ENOUGH)?;
        fit.iterations += ahead.iterations + alone.iterations;
        Some(fit)
    }

    /// The same end where the recordings count for so much less beside the priors: as if noise and jumps had `by` times the
    /// variance. `None` if nothing can be simulated on the way.
    pub(super) fn counting_less(&self, end: &Fit, by: f64) -> Option<Fit> {
        let noise = end.noise.map(|std| by.sqrt() * std);
        let fixed = self.problem(&noise, Tie(end.tie.0.map(|std| by.sqrt() * std)));
        let fit = self.levenberg_marquardt(fixed, end.point.clone(), None, noise, None, ENOUGH)?;
        Some(Fit { iterations: end.iterations + fit.iterations, counts_less_by: by, ..fit })
    }

    /// The end with more that is free, whose coordinates begin here; ties stay, noise is learned anew. `None` if nothing can be
    /// simulated on the way.
    pub(super) fn with_more(&self, end: &Fit, more: impl Iterator<Item = f64>, usual: &Noise) -> Option<Fit> {
        let theta: Vec<f64> = end.point.theta.iter().copied().chain(more).collect();
        let point = Point { theta: DVector::from_vec(theta), starts: end.point.starts.clone() };
        self.go_on(
            point,
            None,
            &end.left(),
            usual,
            Tie(end.tie.0.map(|std| std / end.counts_less_by.sqrt())),
            ENOUGH,
        )
    }

    /// Where another search's end moves to with these segments; noise and ties stay.
    pub(super) fn shifted(&self, end: &Fit) -> Option<DVector<f64>> {
        let fixed = self.problem(&end.noise, end.tie);
        let moved =
            self.levenberg_marquardt(fixed, end.point.clone(), None, end.noise, None, ENOUGH_FOR_COSTS)?;
        Some(moved.point.theta - &end.point.theta)
    }

    /// Every segment's start as measured.
    fn begin(&self, theta: DVector<f64>) -> Point {
        Point { theta, starts: self.segments.iter().map(|segment| Vector3::from(segment.start)).collect() }
    }

    /// Twelve segments or more, spread over everything, none tied to another.
    fn sparse(&self) -> Vec<Segment> {
        let every = (self.segments.len() / 12).max(1);
        let some = self.segments.iter().step_by(every);
        some.map(|segment| Segment { continues: false, ..segment.clone() }).collect()
    }

    /// The values of all parameters at a point.
    pub(super) fn values_at(&self, theta: &DVector<f64>) -> Values {
        self.problem(&[1.0; Output::COUNT], Tie::NONE).values_at(theta)
    }

    /// The lowest cost with another search's noise and tie, and where it is, beginning at `point`.
    pub(super) fn lowest_cost(&self, end: &Fit, point: Point) -> Option<(f64, Point)> {
        let fixed = self.problem(&end.noise, end.tie);
        let point = self.within_bounds(point);
        let fit = self.levenberg_marquardt(fixed, point, None, end.noise, None, ENOUGH_FOR_COSTS)?;
        Some((fit.all.cost, fit.point))
    }

    /// The noise that is left.
    fn noise(&self, all: &Linearized, usual: &Noise) -> Noise {
        let mut counts = [0.0; Output::COUNT];
        for segment in self.segments {
            for row in &segment.measured[..segment.len()] {
                for (count, value) in counts.iter_mut().zip(row) {
                    *count += f64::from(u8::from(!value.is_nan()));
                }
            }
        }
        let total: f64 = counts.iter().sum();
        let spent = (3 * self.segments.len() + self.free.len()) as f64;
        let left = (1.0 - spent / total).max(0.1);
        let mut noise = *usual;
        for (channel, std) in noise.iter_mut().enumerate() {
            if counts[channel] > 0.0 {
                *std = (all.squares[channel] / (counts[channel] * left)).sqrt().max(LEAST_NOISE * *std);
            }
        }
        noise
    }

    /// Searches, and learns the noise on the way. Ends where a step would gain less than `enough`.
    fn descend(&self, point: Point, noise: &Noise, usual: &Noise, tie: Tie, enough: f64) -> Option<Fit> {
        self.go_on(point, None, noise, usual, tie, enough)
    }

    fn go_on(
        &self,
        point: Point,
        known: Option<Linearized>,
        noise: &Noise,
        usual: &Noise,
        tie: Tie,
        enough: f64,
    ) -> Option<Fit> {
        self.levenberg_marquardt(self.problem(noise, tie), point, known, *noise, Some(usual), enough)
    }

    /// Levenberg–Marquardt; with `usual`, the noise is learned on the way (iterative reweighting).
    fn levenberg_marquardt(
        &self,
        mut problem: Problem<'a>,
        mut point: Point,
        known: Option<Linearized>,
        mut noise: Noise,
        usual: Option<&Noise>,
        enough: f64,
    ) -> Option<Fit> {
        let mut all = match known {
            Some(known) => problem.weigh_anew(&point, known),
            None => problem.linearize(&point),
        };
        if !all.cost.is_finite() {
            return None;
        }
        let (mut damping, mut iterations, mut idle) = (1e-4, 0, 0);
        let mut converged = false;
        while iterations < MOST_ITERATIONS && !converged && damping < 1e9 {
            let limits = self.limits(&point);
            let Some((step, gain)) = all.eliminate(damping).and_then(|equations| equations.step(&limits))
            else {
                iterations += 1;
                damping = (damping * 10.0).max(1e-9);
                continue;
            };
            if gain < enough {
                iterations += 1;
                let learned = usual.map_or(noise, |usual| self.noise(&all, usual));
                if steady(&learned, &noise) {
                    converged = true;
                    break;
                }
                noise = learned;
                problem = self.problem(&noise, problem.tie);
                all = problem.weigh_anew(&point, all);
                continue;
            }
            let Some(lower) = self.lower(&problem, (&point, all.cost), &step, gain, &mut iterations) else {
                // At kinks of the tire a step may promise for ever what it does not keep.
                idle += u32::from(gain < KINKS);
                converged = idle > 1;
                damping = (damping * 100.0).max(1e-4);
                continue;
            };
            let gained = all.cost - lower.all.cost;
            damping *= match lower.share {
                1.0 if gained > 0.7 * gain => 0.1,
                1.0 => 0.5,
                _ => 2.0,
            };
            (point, all) = (lower.point, lower.all);
            let learned = usual.map_or(noise, |usual| self.noise(&all, usual));
            let is_steady = steady(&learned, &noise);
            if !is_steady {
                noise = learned;
                problem = self.problem(&noise, problem.tie);
                all = problem.weigh_anew(&point, all);
            }
            idle = if gained < enough && is_steady { idle + 1 } else { 0 };
            converged = idle > 1;
        }
        Some(Fit { point, all, noise, tie: problem.tie, iterations, converged, counts_less_by: 1.0 })
    }

    /// How far each parameter may go in one step.
    fn limits(&self, point: &Point) -> Vec<(f64, f64)> {
        let each = self.free.iter().zip(point.theta.iter()).map(|(free, at)| {
            let (low, high) = free.coordinate_bounds();
            let farthest = if free.parameters.first().is_logarithmic() { FARTHEST } else { f64::INFINITY };
            ((low - at).max(-farthest), (high - at).min(farthest))
        });
        each.collect()
    }

    /// As far along a step as lowers the cost, if it does anywhere near.
    fn lower(
        &self,
        problem: &Problem<'_>,
        (point, cost): (&Point, f64),
        step: &Point,
        gain: f64,
        tried: &mut u32,
    ) -> Option<Lower> {
        let mut share = 1.0;
        for _ in 0..SHORTENED {
            *tried += 1;
            let trial = self.within_bounds(point.moved(step, share));
            let all = problem.linearize(&trial);
            if all.cost <= cost {
                return Some(Lower { point: trial, all, share });
            }
            // A parabola falls as was promised, and goes through here: at its bottom, or thereabouts.
            let bottom = gain * share * share / (all.cost - cost + 2.0 * gain * share);
            share = bottom.max(0.1 * share).min(0.5 * share);
        }
        None
    }

    fn within_bounds(&self, mut point: Point) -> Point {
        for (coordinate, free) in point.theta.iter_mut().zip(self.free) {
            let (low, high) = free.coordinate_bounds();
            *coordinate = coordinate.clamp(low, high);
        }
        point
    }
}

/// Where a step led to.
struct Lower {
    point: Point,
    all: Linearized,
    /// So much of it.
    share: f64,
}

/// Is the noise known to some per cent?
fn steady(learned: &Noise, noise: &Noise) -> bool {
    learned.iter().zip(noise).all(|(new, old)| (new / old - 1.0).abs() < 0.02)
}

/// How much comes in between segments, beyond what their noise lets one know: by moments.
fn tie(all: &Linearized) -> Tie {
    let mut std = [0.0; 3];
    for (i, std) in std.iter_mut().enumerate() {
        let jumps = all.jumps.iter().zip(&all.jump_covariance);
        let known = jumps.filter_map(|(jump, covariance)| Some((jump[i], covariance.as_ref()?[(i, i)])));
        let mut excess: Vec<f64> = known.map(|(jump, variance)| jump * jump - variance).collect();
        // A single wheel over a kerb must not loosen everything: the largest tenth does not count.
        excess.sort_by(f64::total_cmp);
        excess.truncate(excess.len() - excess.len() / 10);
        let mean = excess.iter().sum::<f64>() / excess.len().max(1) as f64;
        *std = mean.max(0.0).sqrt().max(LEAST_JUMP[i]);
    }
    Tie(std)
}

/// Jumps that do no harm, m/s, m/s, rad/s: below them a tie is as good as tight.
const LEAST_JUMP: [f64; 3] = [1e-3, 1e-3, 1e-4];
