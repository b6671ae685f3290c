//! One extended Kalman filter on the model: a hypothesis of how fast the surface may change.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

use super::config::{LateralFilterConfig, Walk};
use super::model::{
    ANGLE, ANGLE_OFFSET, ANGLE_RATE, ANGLE_SCALE, AY_OFFSET, BANK, Covariance, DELAY, FRICTION, FRONT,
    Inputs, Model, REAR, Rates, Row, STATES, VY, YAW, YAW_OFFSET,
};
use crate::estimate::kinematics::Car;
use crate::filter::{Gaussian, Innovation};
use crate::{Quantity, Sensors};

/// Tuned with the test `sim2_joint`.
struct Tuning {
    /// Widths of the kink, in units of normalized force. Not wider: what is not known of the friction is the same
    /// at each sample and no noise; far from the kink it must not look like softness.
    blur: (f64, f64),
    /// Logarithms this uncertain are not known at all; more is no more.
    unknown: f64,
    /// Logarithms of the stiffnesses (0.3 to 100 per rad) stay within these, …
    stiffness_limits: (f64, f64),
    /// … and that of the friction (0.02 to 2) within these.
    friction_limits: (f64, f64),
}

const TUNING: Tuning =
    Tuning { blur: (1e-3, 0.03), unknown: 0.5, stiffness_limits: (-1.2, 4.6), friction_limits: (-3.9, 0.7) };

/// Noise of single samples and of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Variance of a yaw rate's reading, rad²/s².
    pub yaw_rate: f64,
    /// … of a lateral acceleration's, m²/s⁴.
    pub acceleration: f64,
    /// … of a road wheel angle's, rad².
    pub angle: f64,
    /// Spectral density of the unmodelled lateral acceleration, m²/s³.
    pub lateral: f64,
    /// … of the unmodelled yaw acceleration, rad²/s³.
    pub moment: f64,
}

impl Noise {
    /// As the data sheets promise the readings, and the configuration the rest.
    pub fn promised(car: &Car, sensors: &Sensors, config: &LateralFilterConfig) -> Self {
        let variance = |quantity| sensors.noise_std(quantity).powi(2);
        Self {
            yaw_rate: variance(Quantity::YawRate),
            acceleration: variance(Quantity::LateralAcceleration),
            angle: variance(Quantity::SteeringWheelAngle) / car.steering_ratio.powi(2),
            lateral: config.acceleration_noise.powi(2),
            moment: config.yaw_noise.powi(2),
        }
    }
}

/// What the sensors of a sample say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// Road wheel angle, rad.
    pub angle: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Lateral acceleration, m/s², where one is measured and believed.
    pub acceleration: Option<f64>,
}

/// What a sample said to a hypothesis.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// Road wheel angle against what was expected.
    pub angle: Innovation,
    /// The same of the yaw rate, …
    pub yaw_rate: Innovation,
    /// … and of the lateral acceleration.
    pub acceleration: Option<Innovation>,
    /// Logarithm of the sample's likelihood (without constants).
    pub ln_likelihood: f64,
}

/// State and covariance under one assumption on the surface.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// See [`super::model`] for its components.
    pub state: Gaussian<STATES>,
}

impl Hypothesis {
    /// Width of the kink by what is not known, front and rear.
    fn blur(&self, model: &Model, inputs: &Inputs, angle: f64) -> [f64; 2] {
        if !model.has_kink() {
            return [0.0; 2];
        }
        let p = &self.state.covariance;
        model.margins(&self.state.mean, inputs, angle).map(|(_, row)| {
            const ACTIVE: [usize; 6] = [VY, YAW, ANGLE, FRONT, REAR, FRICTION];
            let mut variance = 0.0;
            for i in ACTIVE {
                for j in ACTIVE {
                    variance += row[i] * p[(i, j)] * row[j];
                }
            }
            variance.sqrt().clamp(TUNING.blur.0, TUNING.blur.1)
        })
    }

    /// From the last sample to this one. `steering` is the spectral density of the steering's angular
    /// acceleration, rad²/s³.
    pub fn predict(
        &mut self,
        model: &Model,
        before: &Inputs,
        now: &Inputs,
        elapsed_s: f64,
        noise: &Noise,
        steering: f64,
    ) {
        let h = elapsed_s;
        let middle = before.middle(now);
        let x = self.state.mean;
        // One evaluation, inputs at the step's middle, integrated exactly as a linear system.
        let angle = x[ANGLE] + 0.5 * h * x[ANGLE_RATE];
        let blur = self.blur(model, &middle, angle);
        let rates = model.rates(&x, Vector2::new(x[VY], x[YAW]), &middle, angle, blur);
        let scaled = h * rates.by_motion;
        let integral = h
            * (Matrix2::identity()
                + 0.5
                    * scaled
                    * (Matrix2::identity() + scaled * (Matrix2::identity() + 0.25 * scaled) / 3.0));
        let moved = integral * rates.rate;
        self.state.mean[VY] += moved[0];
        self.state.mean[YAW] += moved[1];
        self.state.mean[ANGLE] += h * x[ANGLE_RATE];
        let transition = Matrix2::identity() + rates.by_motion * integral;
        let by_angle = integral * rates.by_angle;
        let by_tires = integral * rates.by_tires;
        let mut rows = SMatrix::<f64, MOVING, STATES>::zeros();
        rows.fixed_view_mut::<2, 2>(0, 0).copy_from(&transition);
        for i in 0..2 {
            rows[(i, ANGLE)] = by_angle[i];
            rows[(i, ANGLE_RATE)] = 0.5 * h * by_angle[i];
            rows[(i, BANK)] = -integral[(i, 0)];
            for (j, tire) in [FRONT, REAR, FRICTION].into_iter().enumerate() {
                rows[(i, tire)] = by_tires[(i, j)];
            }
        }
        rows[(ANGLE, ANGLE)] = 1.0;
        rows[(ANGLE, ANGLE_RATE)] = h;
        propagate(&mut self.state.covariance, &rows);
        // The hands' acceleration, constant during the step, moves angle, rate, and thereby the car.
        let hands =
            SVector::<f64, 4>::new(h * h / 6.0 * by_angle[0], h * h / 6.0 * by_angle[1], 0.5 * h * h, h);
        let p = &mut self.state.covariance;
        let density = steering / h;
        for i in 0..4 {
            for j in 0..4 {
                p[(i, j)] += density * hands[i] * hands[j];
            }
        }
        p[(VY, VY)] += noise.lateral * h;
        p[(YAW, YAW)] += noise.moment * h;
    }

    /// Surface and tires change on their own.
    pub fn walk(&mut self, walk: &Walk, elapsed_s: f64) {
        let unknown = TUNING.unknown * TUNING.unknown;
        let p = &self.state.covariance;
        let common =
            p[(FRONT, FRONT)] < unknown && p[(REAR, REAR)] < unknown && p[(FRICTION, FRICTION)] < unknown;
        self.open(if common { walk.common * elapsed_s } else { 0.0 }, [0.0; 3]);
        let p = &mut self.state.covariance;
        for (i, own) in [(FRONT, walk.stiffness), (REAR, walk.stiffness), (FRICTION, walk.friction)] {
            if p[(i, i)] < unknown {
                p[(i, i)] += own * elapsed_s;
            }
        }
    }

    /// Stiffnesses and friction may have changed: variances of a common factor, and of each one's own.
    pub fn open(&mut self, common: f64, own: [f64; 3]) {
        let p = &mut self.state.covariance;
        for (i, own) in [FRONT, REAR, FRICTION].into_iter().zip(own) {
            for j in [FRONT, REAR, FRICTION] {
                p[(i, j)] += common;
            }
            p[(i, i)] += own;
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
    pub fn update(&mut self, model: &Model, now: &Inputs, readings: &Readings, noise: &Noise) -> Verdict {
        let x = &self.state.mean;
        let (shown, scale) = (x[ANGLE], 1.0 + x[ANGLE_SCALE]);
        let residual = readings.angle - scale * shown - x[ANGLE_OFFSET];
        let row = [(ANGLE, scale), (ANGLE_OFFSET, 1.0), (ANGLE_SCALE, shown)];
        let angle = self.correct(row, residual, noise.angle);
        let yaw_rate = self.correct_yaw_rate(model, now, readings.yaw_rate, noise.yaw_rate);
        let acceleration = readings
            .acceleration
            .map(|reading| self.correct_acceleration(model, now, reading, noise.acceleration));
        self.keep_within_limits();
        let ln = |i: &Innovation| -0.5 * (i.nis() + i.variance.ln());
        let ln_likelihood = ln(&angle) + ln(&yaw_rate) + acceleration.as_ref().map_or(0.0, ln);
        Verdict { angle, yaw_rate, acceleration, ln_likelihood }
    }

    /// The accelerometer's reading; where its time is not that of the steering, as much of the jerk is in it.
    fn correct_acceleration(
        &mut self,
        model: &Model,
        now: &Inputs,
        reading: f64,
        variance: f64,
    ) -> Innovation {
        let x = self.state.mean;
        let blur = self.blur(model, now, x[ANGLE]);
        let rates = model.rates(&x, Vector2::new(x[VY], x[YAW]), now, x[ANGLE], blur);
        let jerk = rates.jerk(x[ANGLE_RATE]);
        let residual = reading - rates.acceleration - x[AY_OFFSET] - x[DELAY] * jerk;
        self.correct(acceleration_row(&rates, jerk), residual, variance)
    }

    /// The yaw rate's reading; where its time is not that of the steering, as much of the yaw acceleration is in it.
    fn correct_yaw_rate(&mut self, model: &Model, now: &Inputs, reading: f64, variance: f64) -> Innovation {
        let x = self.state.mean;
        if self.state.covariance[(DELAY, DELAY)] == 0.0 {
            let residual = reading - x[YAW] - x[YAW_OFFSET];
            return self.correct([(YAW, 1.0), (YAW_OFFSET, 1.0)], residual, variance);
        }
        let rates = model.rates(&x, Vector2::new(x[VY], x[YAW]), now, x[ANGLE], [0.0; 2]);
        let rate = rates.rate[1];
        let residual = reading - x[YAW] - x[YAW_OFFSET] - x[DELAY] * rate;
        self.correct([(YAW, 1.0), (YAW_OFFSET, 1.0), (DELAY, rate)], residual, variance)
    }

    /// Measurement update with a scalar of sparse sensitivity. With noise in every reading and in every
    /// component that moves, P − k kᵀ s is as good as Joseph's form and a third of its work; it is symmetric
    /// to the last bit.
    fn correct<const M: usize>(
        &mut self,
        row: [(usize, f64); M],
        residual: f64,
        variance: f64,
    ) -> Innovation {
        let p = &mut self.state.covariance;
        let mut ph = Row::zeros();
        for (i, sensitivity) in row {
            ph += p.column(i) * sensitivity;
        }
        let total = row.iter().map(|(i, sensitivity)| ph[*i] * sensitivity).sum::<f64>() + variance;
        let innovation = Innovation { residual, variance: total };
        if !(residual.is_finite() && total.is_finite() && total > 0.0) {
            return innovation;
        }
        self.state.mean += ph * (residual / total);
        for j in 0..STATES {
            let share = ph[j] / total;
            for i in 0..STATES {
                p[(i, j)] -= ph[i] * share;
            }
        }
        for j in 0..STATES {
            for i in 0..j {
                p[(i, j)] = p[(j, i)];
            }
        }
        innovation
    }

    fn keep_within_limits(&mut self) {
        let x = &mut self.state.mean;
        for (i, (low, high)) in [
            (FRONT, TUNING.stiffness_limits),
            (REAR, TUNING.stiffness_limits),
            (FRICTION, TUNING.friction_limits),
        ] {
            x[i] = x[i].clamp(low, high);
        }
    }
}

/// Derivatives of the accelerometer's reading by the state.
fn acceleration_row(rates: &Rates, jerk: f64) -> [(usize, f64); 8] {
    [
        (VY, rates.acceleration_by_motion[0]),
        (YAW, rates.acceleration_by_motion[1]),
        (ANGLE, rates.acceleration_by_angle),
        (FRONT, rates.acceleration_by_tires[0]),
        (REAR, rates.acceleration_by_tires[1]),
        (FRICTION, rates.acceleration_by_tires[2]),
        (AY_OFFSET, 1.0),
        (DELAY, jerk),
    ]
}

/// Components that the prediction moves; the others stay.
const MOVING: usize = 3;

/// P ← F P Fᵀ where only the first rows of F differ from the identity's.
fn propagate(p: &mut Covariance, rows: &SMatrix<f64, MOVING, STATES>) {
    let moved = rows * *p;
    let square = moved * rows.transpose();
    for i in 0..MOVING {
        for j in MOVING..STATES {
            p[(i, j)] = moved[(i, j)];
            p[(j, i)] = moved[(i, j)];
        }
        for j in 0..=i {
            let mean = 0.5 * (square[(i, j)] + square[(j, i)]);
            p[(i, j)] = mean;
            p[(j, i)] = mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;
    use crate::model::tire::{PiecewiseLinear, Tire};

    /// Half an hour at 100 Hz, six hours in the release profile.
    #[test]
    fn the_covariance_stays_positive_for_hours() {
        let car = Car::new(&Vehicle::thesis());
        let model = Model::new(&car, Tire::PiecewiseLinear(PiecewiseLinear));
        let noise = Noise::promised(&car, &Sensors::default(), &LateralFilterConfig::default());
        let std = [0.5, 0.1, 0.1, 0.5, 0.3, 0.3, 0.3, 0.1, 0.01, 0.01, 0.15, 0.02, 0.02];
        let mut mean = [0.0; STATES];
        (mean[FRONT], mean[REAR]) = (2.4, 2.4);
        let mut hypothesis = Hypothesis { state: Gaussian::new(mean, std) };
        let walk = LateralFilterConfig::default().steady();
        let samples = if cfg!(debug_assertions) { 200_000 } else { 2_000_000 };
        for i in 0..samples {
            let speed = 20.0 + 10.0 * f64::sin(i as f64 * 1e-4);
            let inputs = Inputs { speed, longitudinal: [0.1, 0.0], rear_angle: 0.0 };
            let [angle, yaw_rate, acceleration] =
                [0.0, 1.0, 2.0].map(|j| 0.01 * f64::sin(i as f64 * (0.03 + 0.01 * j)));
            let readings = Readings { angle, yaw_rate, acceleration: Some(acceleration) };
            hypothesis.predict(&model, &inputs, &inputs, 0.01, &noise, 0.01);
            hypothesis.walk(&walk, 0.01);
            hypothesis.fade_bank(0.02, 20.0, 0.01);
            hypothesis.update(&model, &inputs, &readings, &noise);
        }
        assert!(hypothesis.state.is_sound());
        let p = &hypothesis.state.covariance;
        assert_eq!(*p, p.transpose());
        // Scaled to ones on the diagonal: the units must not decide.
        let scale = p.diagonal().map(|v| v.sqrt().recip());
        let correlation = Covariance::from_fn(|i, j| p[(i, j)] * scale[i] * scale[j]);
        assert!(correlation.symmetric_eigenvalues().min() > 0.0, "{}", correlation.symmetric_eigenvalues());
    }
}
