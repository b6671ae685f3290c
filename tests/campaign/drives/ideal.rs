//! What could be known at best: an observer beside the service to whom nearly everything is told.
//!
//! It is given the true slips, slip angles and wheel loads, the force of each axle but for a small white error, what
//! share of the road's friction each wheel has, how stiffness goes with load, when another road begins, and the equations
//! of the plant's tires: the magic formula, both forces on the friction ellipse (thesis 4.10 and 4.15). Left to find out
//! are the friction, the shape and the curvature of the tires, and their three stiffnesses, from what the data sheet says
//! of them. No sensor gives as much, so what it cannot bound nobody can.
//!
//! A grid of frictions, shapes and curvatures, each with an extended Kalman filter on the logarithms of the stiffnesses.

use gripd::filter::Gaussian;
use gripd::model::tire::{Contact, MagicFormula, Tire};
use gripd::model::{Truth, Vehicle};
use nalgebra::SVector;

/// From ice that is wet to more than any asphalt, each by so much more than the last.
const LOWEST_FRICTION: f64 = 0.04;
const HIGHEST_FRICTION: f64 = 1.4;
const FRICTIONS: usize = 56;

/// Of the magic formula, from the lowest to the highest that a drive may have.
const SHAPES: [f64; 6] = [1.28, 1.34, 1.40, 1.45, 1.51, 1.57];
const CURVATURES: [f64; 4] = [-0.83, -0.48, -0.13, 0.23];

/// Kinds of tires.
const KINDS: usize = SHAPES.len() * CURVATURES.len();

/// Of an axle's force / load: a sensor's share, and a share of the force that covers the steps of the grid.
const FORCE_STD: f64 = 0.01;
const STEP_STD: f64 = 0.04;

/// The grid's errors last: what twenty looks a second say is worth that of ten.
const NEW: f64 = 0.5;

/// What the road makes of the stiffnesses of the data sheet: loose ones take half, std of the logarithm beside the tire's.
const ROAD_STD: f64 = 0.3;

/// A wheel's load that leaves its stiffness as it is.
const ORDINARY_LOAD_N: f64 = 4000.0;

/// Hypotheses less likely than the best by this, in ln, are not followed.
const HOPELESS: f64 = 20.0;

/// Outside the 95 % interval on each side.
const TAIL: f64 = 0.025;

/// The friction of the better side of the road.
fn best_side(truth: &Truth) -> f64 {
    truth.friction.into_iter().fold(0.0, f64::max)
}

/// One friction with one kind of tire, and how likely it is, ln.
#[derive(Clone)]
struct Hypothesis {
    /// Of the better side of the road.
    friction: f64,
    tire: Tire,
    /// ln of the stiffness along, and across front and rear.
    stiffness: Gaussian<3>,
    likelihood: f64,
}

/// The observer of one drive.
pub struct Ideal {
    /// With which power of the load each tire's stiffness / load falls.
    load_sensitivity: f64,
    sheet: Gaussian<3>,
    hypotheses: Vec<Hypothesis>,
}

impl Ideal {
    pub fn new(sheet: &Vehicle, load_sensitivity: f64) -> Self {
        let numbers =
            [&sheet.longitudinal_stiffness, &sheet.lateral_stiffness_front, &sheet.lateral_stiffness_rear];
        // On a loose road they are two thirds in the middle.
        let sheet = Gaussian::new(
            numbers.map(|number| (0.8 * number.value).ln()),
            numbers.map(|number| (number.std / number.value).hypot(ROAD_STD)),
        );
        let step = (HIGHEST_FRICTION / LOWEST_FRICTION).powf(1.0 / (FRICTIONS - 1) as f64);
        let mut hypotheses = Vec::new();
        for number in 0..FRICTIONS {
            for shape in SHAPES {
                for curvature in CURVATURES {
                    hypotheses.push(Hypothesis {
                        friction: LOWEST_FRICTION * step.powi(number as i32),
                        tire: Tire::MagicFormula(MagicFormula { shape, curvature }),
                        stiffness: sheet,
                        likelihood: 0.0,
                    });
                }
            }
        }
        Self { load_sensitivity, sheet, hypotheses }
    }

    /// Another road begins. The tires stay what they are.
    pub fn change(&mut self) {
        let of_kind = |kind: usize| {
            let best = self.of_kind(kind).fold(f64::NEG_INFINITY, f64::max);
            best + self.of_kind(kind).map(|one| (one - best).exp()).sum::<f64>().ln()
        };
        let kept: Vec<f64> = (0..KINDS).map(of_kind).collect();
        for (place, hypothesis) in self.hypotheses.iter_mut().enumerate() {
            hypothesis.stiffness = self.sheet;
            // A kind of tire that was given up may have been so for the stiffness.
            hypothesis.likelihood = kept[place % KINDS].max(-HOPELESS);
        }
    }

    fn of_kind(&self, kind: usize) -> impl Iterator<Item = f64> {
        self.hypotheses.iter().skip(kind).step_by(KINDS).map(|hypothesis| hypothesis.likelihood)
    }

    /// Looks at one instant; `noise` is standard normal, for the forces along and across, front and rear.
    pub fn look(&mut self, truth: &Truth, noise: [[f64; 2]; 2]) {
        let softer = truth.fz.map(|load| (load / ORDINARY_LOAD_N).powf(-self.load_sensitivity));
        for hypothesis in &mut self.hypotheses {
            if hypothesis.likelihood > -HOPELESS {
                hypothesis.look(truth, softer, noise);
            }
        }
        let best = self.hypotheses.iter().map(|one| one.likelihood).fold(f64::NEG_INFINITY, f64::max);
        self.hypotheses
            .iter_mut()
            .for_each(|one| one.likelihood = (one.likelihood - best).max(-2.0 * HOPELESS));
    }

    /// The 95 % interval of the friction that the car has at this instant.
    pub fn interval(&self, truth: &Truth) -> [f64; 2] {
        let weights: Vec<f64> = self
            .hypotheses
            .chunks(KINDS)
            .map(|of_friction| of_friction.iter().map(|one| one.likelihood.exp()).sum())
            .collect();
        let all: f64 = weights.iter().sum();
        // Each friction stands for the half step on both its sides.
        let half = (HIGHEST_FRICTION / LOWEST_FRICTION).powf(0.5 / (FRICTIONS - 1) as f64);
        let friction = |place: usize| self.hypotheses[place * KINDS].friction;
        let first = |mut places: Box<dyn Iterator<Item = usize>>| {
            let mut sum = 0.0;
            places
                .find(|place| {
                    sum += weights[*place];
                    sum > TAIL * all
                })
                .expect("the weights add up to all")
        };
        let low = first(Box::new(0..FRICTIONS));
        let high = first(Box::new((0..FRICTIONS).rev()));
        let of_best = truth.mu_max / best_side(truth);
        [of_best * friction(low) / half, of_best * friction(high) * half]
    }
}

impl Hypothesis {
    fn look(&mut self, truth: &Truth, softer: [f64; 4], noise: [[f64; 2]; 2]) {
        for (axle, noise) in noise.into_iter().enumerate() {
            let wheels = [2 * axle, 2 * axle + 1];
            let load: f64 = wheels.iter().map(|wheel| truth.fz[*wheel]).sum();
            for across in [false, true] {
                let forces = if across { &truth.fy } else { &truth.fx };
                let force = wheels.iter().map(|wheel| forces[*wheel]).sum::<f64>() / load;
                let seen = force + FORCE_STD * noise[usize::from(across)];
                let expected = self.force(truth, softer, axle, across, [0.0; 3]);
                let mut slope = SVector::<f64, 3>::zeros();
                for of in [0, 1 + axle] {
                    let mut little = [0.0; 3];
                    little[of] = 0.01;
                    slope[of] = (self.force(truth, softer, axle, across, little) - expected) / 0.01;
                }
                let variance = FORCE_STD.powi(2) + (STEP_STD * force).powi(2);
                let innovation = self.stiffness.update(&slope, seen - expected, variance);
                self.likelihood -= 0.5 * NEW * (innovation.nis() + innovation.variance.ln());
            }
        }
    }

    /// An axle's force / load, with the logarithms of the stiffnesses higher by `more`.
    fn force(&self, truth: &Truth, softer: [f64; 4], axle: usize, across: bool, more: [f64; 3]) -> f64 {
        let stiffness = |of: usize| (self.stiffness.mean[of] + more[of]).exp();
        let slip_angle = [truth.slip_angle_front, truth.slip_angle_rear][axle];
        let of_wheel = |wheel: usize| {
            let friction = self.friction * truth.friction[wheel] / best_side(truth);
            let contact = Contact {
                stiffness_x: softer[wheel] * stiffness(0),
                stiffness_y: softer[wheel] * stiffness(1 + axle),
                friction_x: friction,
                friction_y: friction,
            };
            truth.fz[wheel] * self.tire.combined(&contact, truth.slip[wheel], slip_angle)[usize::from(across)]
        };
        let wheels = [2 * axle, 2 * axle + 1];
        wheels.iter().map(|wheel| of_wheel(*wheel)).sum::<f64>()
            / wheels.iter().map(|wheel| truth.fz[*wheel]).sum::<f64>()
    }
}
