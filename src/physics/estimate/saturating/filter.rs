//! One filter: lateral velocity, both stiffnesses and what disturbs them, for one friction and one shape of the curve.

use nalgebra::SVector;

use super::curve::Curves;
use super::window::Window;
use crate::estimate::kinematics::Car;
use crate::filter::{Gaussian, Innovation};

/// Components of the state.
pub const STATES: usize = 5;
/// Lateral velocity, m/s.
pub const VY: usize = 0;
/// Logarithm of the normalized cornering stiffness, 1/rad, front …
pub const FRONT: usize = 1;
/// … and rear.
pub const REAR: usize = 2;
/// What is left of the offset of the road wheel angle, rad.
pub const ANGLE: usize = 3;
/// Gravity's part along the cross slope, m/s².
pub const BANK: usize = 4;

/// Friction left across the car when all is used along it, of what there is. Tuned with the test `campaign`.
const LEAST_SHARE: f64 = 0.15;

/// What a filter takes for true.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Friction.
    pub friction: f64,
    /// Of the curve.
    pub shape: usize,
}

/// What to expect of the forces of both axles over their load (variances), and of the unmodelled lateral acceleration
/// (m/s²/√Hz).
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    pub variance: [f64; 2],
    pub unmodelled: f64,
}

/// The filter.
#[derive(Clone, Debug)]
pub struct Filter {
    /// What it knows.
    pub state: Gaussian<STATES>,
}

impl Filter {
    /// Corrects the state by the forces of both axles over their load; what they said, front and rear.
    pub fn update(
        &mut self,
        surface: Surface,
        now: &Window,
        car: &Car,
        curves: &Curves,
        noise: &Noise,
    ) -> [Innovation; 2] {
        [0, 1].map(|axle| {
            let x = &self.state.mean;
            let (across, alpha) = self.slip(axle, now, car);
            let along = now.along[axle];
            let least = LEAST_SHARE * surface.friction;
            let limit = (surface.friction * surface.friction - along * along).max(least * least).sqrt();
            let stiffness = x[FRONT + axle].exp();
            let (force, slope) = curves.at(surface.shape, stiffness * alpha / limit);
            let (sin, cos) = if axle == 0 { now.angle.sin_cos() } else { (0.0, 1.0) };
            let residual = now.force[axle] - along * sin - limit * force * cos;
            let mut h = SVector::<f64, STATES>::zeros();
            h[VY] = -slope * stiffness / (now.speed * (1.0 + across * across));
            h[FRONT + axle] = slope * stiffness * alpha;
            if axle == 0 {
                h[ANGLE] = -slope * stiffness;
            }
            self.state.update(&h, residual, noise.variance[axle])
        })
    }

    /// Lateral over forward velocity and slip angle (rad) of an axle (0 in front).
    pub fn slip(&self, axle: usize, now: &Window, car: &Car) -> (f64, f64) {
        let x = &self.state.mean;
        let lever = if axle == 0 { car.a } else { -car.b };
        let across = (x[VY] + lever * now.yaw_rate) / now.speed;
        let steered = if axle == 0 { now.angle - x[ANGLE] } else { now.rear_angle };
        (across, steered - across.atan())
    }

    /// Over a window.
    pub fn predict(&mut self, now: &Window, noise: &Noise) {
        let h = now.elapsed_s;
        self.state.mean[VY] += now.pushed - h * self.state.mean[BANK];
        let p = &mut self.state.covariance;
        for i in 0..STATES {
            p[(VY, i)] -= h * p[(BANK, i)];
        }
        for i in 0..STATES {
            p[(i, VY)] -= h * p[(i, BANK)];
        }
        p[(VY, VY)] += noise.unmodelled * noise.unmodelled * h;
    }
}
