//! One extended Kalman filter on the model: a hypothesis of how fast the surface may change.

use nalgebra::{Matrix2, SMatrix, Vector2};

use super::model::{
    ANGLE_ERROR, ANGLE_OFFSET, AY_OFFSET, BANK, Covariance, FRICTION, FRONT, Inputs, Model, REAR, Row, STATES,
    VY, YAW, YAW_OFFSET,
};
use crate::filter::{Gaussian, Innovation};

/// Noise of single samples and of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Variances of a reading: yaw rate, lateral acceleration, road wheel angle.
    pub yaw_rate: f64,
    pub acceleration: f64,
    pub angle: f64,
    /// Unmodelled lateral force, m/s²/√Hz, and moment, rad/s²/√Hz; spectral densities squared.
    pub lateral: f64,
    pub moment: f64,
}

/// Relative walks of the tires' parameters, variance per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk {
    /// Common to both stiffnesses and the friction: the surface.
    pub common: f64,
    /// Of each stiffness on its own.
    pub stiffness: f64,
    /// Of the friction on its own.
    pub friction: f64,
}

/// What a sample said to a hypothesis.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// Yaw rate and lateral acceleration against what was expected.
    pub innovations: [Innovation; 2],
    /// Logarithm of the sample's likelihood (without constants).
    pub ln_likelihood: f64,
}

/// State and covariance under one assumption on the surface.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    pub state: Gaussian<STATES>,
}

impl Hypothesis {
    /// Standard deviations of the kink's place stay above this, in units of normalized force.
    const LEAST_BLUR: f64 = 1e-3;
    /// Stiffnesses (1/rad) and friction stay within these.
    const STIFFNESS_LIMITS: (f64, f64) = (0.3, 100.0);
    const FRICTION_LIMITS: (f64, f64) = (0.02, 2.0);

    /// Width of the kink by what is not known, front and rear.
    fn blur(&self, model: &Model, inputs: &Inputs, angle: f64) -> [f64; 2] {
        if !model.has_kink() {
            return [0.0; 2];
        }
        let p = &self.state.covariance;
        model.margins(&self.state.mean, inputs, angle).map(|(_, row)| {
            const ACTIVE: [usize; 7] = [VY, YAW, ANGLE_ERROR, FRONT, REAR, FRICTION, ANGLE_OFFSET];
            let mut variance = 0.0;
            for i in ACTIVE {
                for j in ACTIVE {
                    variance += row[i] * p[(i, j)] * row[j];
                }
            }
            variance.max(Self::LEAST_BLUR * Self::LEAST_BLUR).sqrt()
        })
    }

    /// From the last sample to this one.
    pub fn predict(&mut self, model: &Model, before: &Inputs, now: &Inputs, elapsed_s: f64, noise: &Noise) {
        let h = elapsed_s;
        let middle = before.middle(now);
        let x = self.state.mean;
        // Of the mean angle's error half was in the last reading, half is in this one, still unknown.
        let angle = middle.angle - x[ANGLE_OFFSET] - 0.5 * x[ANGLE_ERROR];
        let blur = self.blur(model, &middle, angle);
        let motion = Vector2::new(x[VY], x[YAW]);
        let first = model.rates(&x, motion, &middle, angle, blur);
        let rates = model.rates(&x, motion + 0.5 * h * first.rate, &middle, angle, blur);
        let next = motion + h * rates.rate;
        self.state.mean[VY] = next[0];
        self.state.mean[YAW] = next[1];
        self.state.mean[ANGLE_ERROR] = 0.0;

        let integral = (Matrix2::identity() + 0.5 * h * rates.by_motion) * h;
        let transition = Matrix2::identity() + rates.by_motion * integral;
        let by_angle = integral * rates.by_angle;
        let by_tires = integral * rates.by_tires;
        let mut rows = SMatrix::<f64, 2, STATES>::zeros();
        rows.fixed_view_mut::<2, 2>(0, 0).copy_from(&transition);
        rows.set_column(ANGLE_ERROR, &(-0.5 * by_angle));
        rows.fixed_view_mut::<2, 3>(0, FRONT).copy_from(&by_tires);
        rows.set_column(ANGLE_OFFSET, &-by_angle);
        rows.set_column(BANK, &Vector2::new(-integral[(0, 0)], -integral[(1, 0)]));
        propagate(&mut self.state.covariance, &rows);
        // This reading's error, fresh, in motion and reading alike.
        let half = -0.5 * by_angle;
        let p = &mut self.state.covariance;
        for i in 0..STATES {
            p[(ANGLE_ERROR, i)] = 0.0;
            p[(i, ANGLE_ERROR)] = 0.0;
        }
        p[(ANGLE_ERROR, ANGLE_ERROR)] = noise.angle;
        for i in 0..2 {
            p[(i, ANGLE_ERROR)] = half[i] * noise.angle;
            p[(ANGLE_ERROR, i)] = half[i] * noise.angle;
            for j in 0..2 {
                p[(i, j)] += half[i] * half[j] * noise.angle;
            }
        }
        p[(VY, VY)] += noise.lateral * h;
        p[(YAW, YAW)] += noise.moment * h;
    }

    /// Surface and tires change on their own.
    pub fn walk(&mut self, walk: &Walk, elapsed_s: f64) {
        let p = &mut self.state.covariance;
        for i in [FRONT, REAR, FRICTION] {
            for j in [FRONT, REAR, FRICTION] {
                p[(i, j)] += walk.common * elapsed_s;
            }
            p[(i, i)] += elapsed_s * if i == FRICTION { walk.friction } else { walk.stiffness };
        }
    }

    /// The bank comes and goes: first-order, of this variance and time constant.
    pub fn fade_bank(&mut self, variance: f64, time_s: f64, elapsed_s: f64) {
        let kept = 1.0 - elapsed_s / time_s;
        self.state.mean[BANK] *= kept;
        let p = &mut self.state.covariance;
        for i in 0..STATES {
            p[(BANK, i)] *= kept;
            p[(i, BANK)] *= kept;
        }
        p[(BANK, BANK)] += variance * (1.0 - kept * kept);
    }

    /// Takes the readings of this sample.
    pub fn update(&mut self, model: &Model, now: &Inputs, readings: [f64; 2], noise: &Noise) -> Verdict {
        let x = self.state.mean;
        let angle = now.angle - x[ANGLE_OFFSET] - x[ANGLE_ERROR];
        let blur = self.blur(model, now, angle);
        let rates = model.rates(&x, Vector2::new(x[VY], x[YAW]), now, angle, blur);
        let mut row = Row::zeros();
        row[YAW] = 1.0;
        row[YAW_OFFSET] = 1.0;
        let yaw = self.state.update(&row, readings[0] - x[YAW] - x[YAW_OFFSET], noise.yaw_rate);
        let row = acceleration_row(&rates);
        let moved = row.dot(&(self.state.mean - x));
        let residual = readings[1] - rates.acceleration - x[AY_OFFSET] - moved;
        let acceleration = self.state.update(&row, residual, noise.acceleration);
        self.keep_within_limits();
        let ln = |i: &Innovation| -0.5 * (i.nis() + i.variance.ln());
        Verdict { innovations: [yaw, acceleration], ln_likelihood: ln(&yaw) + ln(&acceleration) }
    }

    fn keep_within_limits(&mut self) {
        let limits = |(low, high): (f64, f64)| (low.ln(), high.ln());
        for (i, (low, high)) in [
            (FRONT, limits(Self::STIFFNESS_LIMITS)),
            (REAR, limits(Self::STIFFNESS_LIMITS)),
            (FRICTION, limits(Self::FRICTION_LIMITS)),
        ] {
            self.state.mean[i] = self.state.mean[i].clamp(low, high);
        }
    }
}

/// Derivatives of the accelerometer's reading by the state.
pub fn acceleration_row(rates: &super::model::Rates) -> Row {
    let mut row = Row::zeros();
    row[VY] = rates.acceleration_by_motion[0];
    row[YAW] = rates.acceleration_by_motion[1];
    row[ANGLE_ERROR] = -rates.acceleration_by_angle;
    row[ANGLE_OFFSET] = -rates.acceleration_by_angle;
    row[FRONT] = rates.acceleration_by_tires[0];
    row[REAR] = rates.acceleration_by_tires[1];
    row[FRICTION] = rates.acceleration_by_tires[2];
    row[AY_OFFSET] = 1.0;
    row
}

/// P ← F P Fᵀ where only the first two rows of F differ from the identity's.
pub fn propagate(p: &mut Covariance, rows: &SMatrix<f64, 2, STATES>) {
    let moved = rows * *p;
    let motion = moved * rows.transpose();
    for i in 0..2 {
        for j in 2..STATES {
            p[(i, j)] = moved[(i, j)];
            p[(j, i)] = moved[(i, j)];
        }
    }
    p[(0, 0)] = motion[(0, 0)];
    p[(1, 1)] = motion[(1, 1)];
    let cross = 0.5 * (motion[(0, 1)] + motion[(1, 0)]);
    p[(0, 1)] = cross;
    p[(1, 0)] = cross;
}
