//! How visible a hidden cause is: the likelihood ratio of the truth against the plain model with its ordinary
//! parameters refitted, on the very drive, without noise.
//!
//! The plain model is this simulator with nothing hidden, driven by the steering, torque and pressure *as the sensors
//! show them*, restarted every second near the true motion (a test that sees only a second ahead, so that what is
//! found stays where it arises instead of drifting to the end of a long run). Its ordinary parameters, the sensors'
//! offsets and every restart's motion are fitted to what the sensors show of the true drive (Gauss–Newton, finite
//! differences of this simulator, weights the channels' noise, priors what the user states). The squared norm that
//! stays is 2 ln LR of the truth, but for the noise's own contribution.

mod normal;

use normal::reduce;

use super::alternatives::{ALTERNATIVES, Alternative};
use super::car::{Car, DOUBT};
use super::hidden::Hidden;
use super::physics::{Input, Moment, STEP, Simulator, Start};
use super::recipe::Made;
use super::sensors::{Chain, NOISE};

/// Seconds between restarts.
const BLOCK: f64 = 1.0;
/// Seconds between the rows that are compared.
const ROW: f64 = 0.01;
/// Channels compared: four wheels, yaw rate, two accelerations.
const OUTPUTS: usize = 7;
/// Ordinary parameters of the car, then offsets of yaw rate, two accelerations and steering.
const PARAMETERS: usize = 14;
/// Forward speed, lateral speed and yaw rate of each restart, and how far from the truth they may be.
const RESTART: usize = 3;
const RESTART_DOUBT: [f64; RESTART] = [1.0, 1.0, 0.1];
/// Step of the fitted model, s.
const STRIDE: usize = 2;
const MODEL_STEP: f64 = STEP * STRIDE as f64;
/// Rows at the start of a block that are left out: the wheels' averages reach back behind the restart.
const BLIND: usize = 5;

/// Two ln of the likelihood ratio at which a cause counts as findable.
pub const DETECTABLE: f64 = 50.0;

/// What was found out about one recording.
#[derive(Clone, Debug)]
pub struct Visibility {
    /// 2 ln LR of the truth against the refitted plain model.
    pub likelihood_ratio: f64,
    /// When most of it arises.
    pub intervals: Vec<(f64, f64)>,
    /// What stays of it when one effect of the library is fitted beside the ordinary parameters (to first order, and
    /// refitted in full for the few that come nearest), with its strength.
    pub left_by: Vec<(&'static str, f64, f64)>,
}

/// One row: outputs over their noise.
type Row = [f64; OUTPUTS];
type Rows = Vec<Row>;

struct Problem<'a> {
    car: &'a Car,
    moments: &'a [Moment],
    /// Inputs each model step, as shown.
    inputs: Vec<Input>,
    data: Rows,
}

/// A parameter vector: the car's, and the motion of every restart relative to the truth.
#[derive(Clone)]
struct Theta {
    car: [f64; PARAMETERS],
    restart: Vec<[f64; RESTART]>,
    /// Strength of the alternative, where one is fitted.
    strength: f64,
}

fn weight(channel: usize) -> f64 {
    // Wheels come at half the rate of the rows: half their information for each row.
    if channel < 4 { 1.0 / (NOISE[channel] * 2.0f64.sqrt()) } else { 1.0 / NOISE[channel] }
}

impl<'a> Problem<'a> {
    fn new(car: &'a Car, moments: &'a [Moment], hidden: &Hidden) -> Self {
        let chain = Chain::default();
        let per_block = (BLOCK / ROW).round() as usize;
        let rows = ((moments.len() as f64 * STEP - 0.05) / ROW) as usize / per_block * per_block;
        let shown = |channel: usize, t: f64| chain.shows(moments, STEP, hidden, channel, t);
        let data = (0..rows).map(|k| std::array::from_fn(|c| shown(c, k as f64 * ROW) * weight(c))).collect();
        let inputs = (0..moments.len() / STRIDE)
            .map(|k| {
                // Held over a step: its middle.
                let t = (k as f64 + 0.5) * MODEL_STEP;
                Input { steering: shown(7, t), torque: shown(8, t), pressure: shown(9, t) }
            })
            .collect();
        Problem { car, moments, inputs, data }
    }

    fn per_block() -> usize {
        (BLOCK / ROW).round() as usize
    }

    fn blocks(&self) -> usize {
        self.data.len() / Self::per_block()
    }

    /// The plain model, or one with an alternative in it. A delay of the steering sensor acts on the input.
    fn simulate(&self, theta: &Theta, hidden: &Hidden) -> Rows {
        let car = moved(self.car, &theta.car);
        let chain = Chain::default();
        let steps = (BLOCK / MODEL_STEP).round() as usize;
        let last = self.inputs.len() - 1;
        let ahead = (hidden.faults[7].delay / MODEL_STEP).max(0.0);
        let (whole, part) = (ahead as usize, ahead.fract());
        let mut moments: Vec<Moment> = Vec::with_capacity(steps * self.blocks() + steps);
        let start = |block: usize| {
            let truth = &self.moments[(block as f64 * BLOCK / STEP).round() as usize];
            let [u, v, r] = theta.restart[block];
            let speed = truth.u + u;
            let stretch = speed / truth.u * self.car.radius / car.radius;
            Start { u: speed, v: truth.v + v, r: truth.r + r, omega: truth.omega.map(|w| w * stretch) }
        };
        let mut simulator = Simulator::new(&car, hidden, 0.0, &start(0), MODEL_STEP);
        for block in 0..self.blocks() {
            simulator.restart(&start(block));
            for k in block * steps..(block + 1) * steps {
                let mut input = self.inputs[k];
                let early = |n: usize| self.inputs[(k + whole + n).min(last)].steering;
                input.steering = early(0) * (1.0 - part) + early(1) * part - theta.car[13];
                moments.push(simulator.advance(&input));
            }
        }
        let offset = |c: usize| if c < 4 { 0.0 } else { theta.car[c + 6] };
        (0..self.data.len())
            .map(|k| {
                let since = k % Self::per_block();
                std::array::from_fn(|c| {
                    if since < BLIND {
                        0.0
                    } else {
                        let t = k as f64 * ROW;
                        (chain.shows(&moments, MODEL_STEP, hidden, c, t) + offset(c)) * weight(c)
                    }
                })
            })
            .collect()
    }

    fn residual(&self, model: &Rows) -> Rows {
        let rest = |(k, (y, m)): (usize, (&Row, &Row))| {
            if k % Self::per_block() < BLIND { [0.0; OUTPUTS] } else { std::array::from_fn(|c| y[c] - m[c]) }
        };
        self.data.iter().zip(model).enumerate().map(rest).collect()
    }

    /// The derivative of the model in one parameter of the car, or in one of every restart's motion.
    fn derivative(&self, theta: &Theta, hidden: &Hidden, model: &Rows, which: usize, step: f64) -> Rows {
        let mut other = theta.clone();
        if which < PARAMETERS {
            other.car[which] += step;
        } else {
            // All restarts at once: they do not touch each other.
            other.restart.iter_mut().for_each(|r| r[which - PARAMETERS] += step);
        }
        difference(&self.simulate(&other, hidden), model, step)
    }
}

/// The car with its ordinary parameters moved by relative amounts.
fn moved(car: &Car, theta: &[f64; PARAMETERS]) -> Car {
    let mut moved = car.clone();
    let wheelbase = car.wheelbase();
    moved.mass *= 1.0 + theta[0];
    moved.a *= 1.0 + theta[1];
    moved.b = wheelbase - moved.a;
    moved.yaw_inertia *= 1.0 + theta[2];
    moved.radius *= 1.0 + theta[3];
    moved.wheel_inertia *= 1.0 + theta[4];
    moved.steering_ratio *= 1.0 + theta[5];
    moved.slip_stiffness *= 1.0 + theta[6];
    moved.cornering[0] *= 1.0 + theta[7];
    moved.cornering[1] *= 1.0 + theta[8];
    moved.friction = car.friction.map(|mu| mu * (1.0 + theta[9]));
    moved
}

fn doubts() -> [f64; PARAMETERS] {
    let d = DOUBT;
    [
        d.mass,
        d.a,
        d.yaw_inertia,
        d.radius,
        d.wheel_inertia,
        d.steering_ratio,
        d.slip_stiffness,
        d.cornering,
        d.cornering,
        d.friction,
        0.02,
        0.2,
        0.2,
        0.05,
    ]
}

fn square(rows: &[Row]) -> f64 {
    rows.iter().flatten().map(|x| x * x).sum()
}

fn penalty(theta: &Theta) -> f64 {
    let car: f64 = theta.car.iter().zip(doubts()).map(|(t, s)| (t / s).powi(2)).sum();
    let restart: f64 =
        theta.restart.iter().flat_map(|r| r.iter().zip(RESTART_DOUBT)).map(|(t, s)| (t / s).powi(2)).sum();
    car + restart
}

fn difference(other: &Rows, model: &Rows, step: f64) -> Rows {
    other.iter().zip(model).map(|(a, b)| std::array::from_fn(|c| (a[c] - b[c]) / step)).collect()
}

/// Steps of the finite differences in the car's parameters and in a restart's motion.
const CAR_STEPS: [f64; PARAMETERS] =
    [1e-3, 1e-3, 1e-2, 1e-4, 1e-2, 1e-3, 1e-2, 1e-2, 1e-2, 1e-2, 1e-3, 1e-3, 1e-3, 1e-3];
const RESTART_STEPS: [f64; RESTART] = [0.01, 0.01, 0.001];

/// A point of the search: where it is, and what it costs.
#[derive(Clone)]
struct Fit {
    theta: Theta,
    model: Rows,
    residual: Rows,
    cost: f64,
}

impl Problem<'_> {
    fn fit(&self, theta: Theta, alternative: Option<&Alternative>) -> Fit {
        let model = self.simulate(&theta, &added(alternative, theta.strength));
        let residual = self.residual(&model);
        let cost = square(&residual) + penalty(&theta);
        Fit { theta, model, residual, cost }
    }

    /// The derivatives at a fit: of the car's parameters (and the alternative's strength), and of the restarts.
    fn columns(&self, fit: &Fit, alternative: Option<&Alternative>) -> (Vec<Rows>, Vec<Rows>) {
        let hidden = added(alternative, fit.theta.strength);
        let one = |j: usize, step: f64| self.derivative(&fit.theta, &hidden, &fit.model, j, step);
        let mut columns: Vec<Rows> = (0..PARAMETERS).map(|j| one(j, CAR_STEPS[j])).collect();
        if let Some(other) = alternative {
            let stronger = self.simulate(&fit.theta, &other.at(fit.theta.strength + other.step()));
            columns.push(difference(&stronger, &fit.model, other.step()));
        }
        let restarts = (0..RESTART).map(|j| one(PARAMETERS + j, RESTART_STEPS[j])).collect();
        (columns, restarts)
    }

    /// Gauss–Newton with a backtracking step.
    fn minimize(&self, mut fit: Fit, alternative: Option<&Alternative>, iterations: usize) -> Fit {
        for _ in 0..iterations {
            let (columns, restarts) = self.columns(&fit, alternative);
            let step = reduce(&fit.theta, &columns, &restarts, &fit.residual).step(columns.len());
            let (mut length, before) = (1.0, fit.cost);
            while length > 0.02 {
                let mut trial = fit.theta.clone();
                trial.car.iter_mut().zip(step.car).for_each(|(t, s)| *t += length * s);
                for (t, s) in trial.restart.iter_mut().zip(&step.restart) {
                    t.iter_mut().zip(s).for_each(|(t, s)| *t += length * s);
                }
                trial.strength += length * step.strength;
                if alternative.is_some_and(|a| a.positive) {
                    trial.strength = trial.strength.max(0.0);
                }
                if trial.car[..10].iter().all(|t| *t > -0.7 && *t < 3.0)
                    && trial.restart.iter().all(|r| r[0].abs() < 4.0)
                {
                    let trial = self.fit(trial, alternative);
                    if trial.cost < fit.cost {
                        fit = trial;
                        break;
                    }
                }
                length *= 0.4;
            }
            if before - fit.cost < 0.01 * fit.cost || fit.cost < 2.0 {
                break;
            }
        }
        fit
    }

    /// What each alternative leaves: all to first order, the nearest ones fitted in full.
    fn left_by_others(&self, fit: &Fit, own: &str) -> Vec<(&'static str, f64, f64)> {
        let (mut columns, restarts) = self.columns(fit, None);
        for other in ALTERNATIVES {
            let with = self.simulate(&fit.theta, &other.at(other.step()));
            columns.push(difference(&with, &fit.model, other.step()));
        }
        let gains = reduce(&fit.theta, &columns, &restarts, &fit.residual).gains();
        let mut left: Vec<(usize, f64, f64)> = gains
            .into_iter()
            .enumerate()
            .map(|(i, (gain, strength))| {
                let wrong_way = ALTERNATIVES[i].positive && strength < 0.0;
                if wrong_way { (i, fit.cost, 0.0) } else { (i, (fit.cost - gain).max(0.0), strength) }
            })
            .collect();
        left.sort_by(|x, y| x.1.total_cmp(&y.1));
        let near =
            left.iter_mut().filter(|(i, rest, _)| ALTERNATIVES[*i].name != own && *rest < 0.6 * fit.cost);
        for (i, rest, strength) in near.take(NEAREST) {
            let other = &ALTERNATIVES[*i];
            let start = Theta { strength: 0.0, ..fit.theta.clone() };
            let refitted = self.minimize(self.fit(start, Some(other)), Some(other), 3);
            (*rest, *strength) = (refitted.cost.min(fit.cost), refitted.theta.strength);
        }
        left.into_iter().map(|(i, rest, strength)| (ALTERNATIVES[i].name, rest, strength)).collect()
    }
}

/// How many of the alternatives are fitted in full.
const NEAREST: usize = 2;

fn added(alternative: Option<&Alternative>, strength: f64) -> Hidden {
    alternative.map_or_else(Hidden::default, |a| a.at(strength))
}

/// The visibility of what is hidden in a drive.
/// `own` is its name among the alternatives, which are left out where it is `None`.
pub fn visibility(car: &Car, moments: &[Moment], made: &Made, own: Option<&str>) -> Visibility {
    let problem = Problem::new(car, moments, &made.hidden);
    let truth =
        Theta { car: [0.0; PARAMETERS], restart: vec![[0.0; RESTART]; problem.blocks()], strength: 0.0 };
    let fit = problem.minimize(problem.fit(truth, None), None, 3);
    let intervals = densest(&problem, &fit.residual);
    let left_by = own.map(|own| problem.left_by_others(&fit, own)).unwrap_or_default();
    Visibility { likelihood_ratio: fit.cost, intervals, left_by }
}

/// The smallest set of half seconds that holds four fifths of what is visible, gaps below half a second closed.
fn densest(problem: &Problem, residual: &Rows) -> Vec<(f64, f64)> {
    let per = (0.5 / ROW).round() as usize;
    let energy: Vec<f64> =
        residual.chunks(per).map(|rows| rows.iter().flatten().map(|x| x * x).sum()).collect();
    let total: f64 = energy.iter().sum();
    if total < 10.0 {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..energy.len()).collect();
    order.sort_by(|x, y| energy[*y].total_cmp(&energy[*x]));
    let (mut chosen, mut held) = (vec![false; energy.len()], 0.0);
    for k in order {
        if held > 0.8 * total {
            break;
        }
        chosen[k] = true;
        held += energy[k];
    }
    let end = problem.data.len() as f64 * ROW;
    let mut list: Vec<(f64, f64)> = Vec::new();
    for (k, _) in chosen.iter().enumerate().filter(|(_, c)| **c) {
        let (from, to) = (k as f64 * 0.5, ((k + 1) as f64 * 0.5).min(end));
        match list.last_mut() {
            Some(last) if from - last.1 < 0.51 => last.1 = to,
            _ => list.push((from, to)),
        }
    }
    list
}
