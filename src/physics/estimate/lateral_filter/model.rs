//! The single-track car with saturating tires, and its derivatives.
//!
//! ```text
//! a_y = g [w_F (x_F sin δ + y_F cos δ) + w_R y_R]           what the accelerometer feels
//! v̇_y = a_y − bank − v_x r
//! ṙ   = (m g/J) [a w_F (x_F sin δ + y_F cos δ) − b w_R y_R]
//! ```
//!
//! w are the axles' shares of the weight, x and y axle forces / axle load. x is measured (torque), y is the
//! tire's curve at the slip angle (methods.md §2), limited by what the friction circle leaves: the wheel spins
//! up until its longitudinal force balances the torque, so a saturated axle has y = ±√(μ² − x²).

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

use crate::estimate::kinematics::Car;
use crate::model::GRAVITY;
use crate::model::tire::{Curve, Shape, Tire};

/// Components of the state.
pub const STATES: usize = 13;
/// Lateral velocity, m/s.
pub const VY: usize = 0;
/// Yaw rate, rad/s.
pub const YAW: usize = 1;
/// Road wheel angle, rad. A state, and its rate, too, because noise in the angle that multiplies a
/// stiffness would pull the stiffness down; a driver's hands are smoother than a sensor.
pub const ANGLE: usize = 2;
/// Its rate, rad/s.
pub const ANGLE_RATE: usize = 3;
/// Logarithm of the front axle's normalized cornering stiffness (1/rad). As logarithms stiffness and friction
/// stay positive, their walks are relative, and a surface's common factor is a common summand.
pub const FRONT: usize = 4;
/// … of the rear axle's.
pub const REAR: usize = 5;
/// Logarithm of the friction.
pub const FRICTION: usize = 6;
/// Offset of the lateral acceleration, m/s².
pub const AY_OFFSET: usize = 7;
/// Offset of the yaw rate, rad/s.
pub const YAW_OFFSET: usize = 8;
/// Offset of the road wheel angle, rad.
pub const ANGLE_OFFSET: usize = 9;
/// Gravity's part along the road's cross slope, m/s².
pub const BANK: usize = 10;
/// By how much the inertial sensors are ahead of the steering and the wheels, s; negative: behind.
pub const DELAY: usize = 11;
/// Relative error of the road wheel angle: steering ratio, and what the single track leaves out in tight curves.
pub const ANGLE_SCALE: usize = 12;

/// The state or a row of derivatives by it.
pub type Row = SVector<f64, STATES>;
/// Covariance of the state.
pub type Covariance = SMatrix<f64, STATES, STATES>;

/// What drives the model: measured, not estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Forward speed, m/s.
    pub speed: f64,
    /// Longitudinal force / load of the front and the rear axle.
    pub longitudinal: [f64; 2],
    /// Angle of the rear wheels, rad.
    pub rear_angle: f64,
}

impl Inputs {
    /// Half way to `other`.
    pub fn middle(&self, other: &Inputs) -> Inputs {
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        Inputs {
            speed: mean(self.speed, other.speed),
            longitudinal: [0, 1].map(|i| mean(self.longitudinal[i], other.longitudinal[i])),
            rear_angle: mean(self.rear_angle, other.rear_angle),
        }
    }
}

/// Force of an axle / its load, and its derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub struct AxleForce {
    /// Lateral force / load.
    pub lateral: f64,
    /// By the slip angle, 1/rad.
    pub by_angle: f64,
    /// By the logarithm of the stiffness.
    pub by_ln_stiffness: f64,
    /// By the logarithm of the friction.
    pub by_ln_friction: f64,
}

/// Rates of (v_y, r), the acceleration felt, and derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Rates {
    /// v̇_y and ṙ.
    pub rate: Vector2<f64>,
    /// By v_y and r.
    pub by_motion: Matrix2<f64>,
    /// By the road wheel angle.
    pub by_angle: Vector2<f64>,
    /// By ln C_F, ln C_R, ln μ.
    pub by_tires: SMatrix<f64, 2, 3>,
    /// Lateral acceleration, m/s².
    pub acceleration: f64,
    /// Its derivatives by v_y and r.
    pub acceleration_by_motion: [f64; 2],
    /// … by the road wheel angle.
    pub acceleration_by_angle: f64,
    /// … by ln C_F, ln C_R, ln μ.
    pub acceleration_by_tires: [f64; 3],
}

impl Rates {
    /// How fast the acceleration changes while the steering turns at this rate (rad/s), m/s³.
    pub fn jerk(&self, angle_rate: f64) -> f64 {
        let [by_vy, by_yaw] = self.acceleration_by_motion;
        by_vy * self.rate[0] + by_yaw * self.rate[1] + self.acceleration_by_angle * angle_rate
    }

    /// Yaw rate in the end for each road wheel angle, 1/s; infinite where the tires hold no such end.
    pub fn steady_yaw_gain(&self) -> f64 {
        let (m, b) = (&self.by_motion, &self.by_angle);
        let determinant = m.determinant();
        let gain = (m[(1, 0)] * b[0] - m[(0, 0)] * b[1]) / determinant;
        if determinant > 0.0 && gain > 0.0 { gain } else { f64::INFINITY }
    }
}

/// The car's numbers as the equations use them.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    a: f64,
    b: f64,
    /// Shares of the weight.
    share: [f64; 2],
    /// m g / J, 1/(m s²).
    turning: f64,
    tire: Tire,
    /// A kink is blurred by what is not known.
    blurs: bool,
}

impl Model {
    /// Friction left across the car when all is used along it, of what there is. Tuned with the test `sim2_joint`.
    const LEAST_SHARE: f64 = 0.05;

    /// For a car on tires of this kind.
    pub fn new(car: &Car, tire: Tire) -> Self {
        let wheelbase = car.wheelbase();
        Self {
            a: car.a,
            b: car.b,
            share: [car.b / wheelbase, car.a / wheelbase],
            turning: car.mass * GRAVITY / car.yaw_inertia,
            tire,
            blurs: true,
        }
    }

    /// Yaw rate for each road wheel angle of a car that neither under- nor oversteers, 1/s: the most there usually is.
    pub fn steady_gain(&self, speed: f64) -> f64 {
        speed / (self.a + self.b)
    }

    /// The same at a place that is known exactly.
    pub fn at_known_place(&self) -> Self {
        Self { blurs: false, ..*self }
    }

    /// Slip angles front and rear (positive when they give a positive force), and their derivatives by v_y.
    fn slip_angles(&self, vy: f64, yaw_rate: f64, inputs: &Inputs, angle: f64) -> [(f64, f64); 2] {
        let at = |across: f64| {
            let ratio = across / inputs.speed;
            (ratio.atan(), 1.0 / (inputs.speed * (1.0 + ratio * ratio)))
        };
        let (front, front_by) = at(vy + self.a * yaw_rate);
        let (rear, rear_by) = at(vy - self.b * yaw_rate);
        [(angle - front, -front_by), (inputs.rear_angle - rear, -rear_by)]
    }

    /// Everything at state `x` and road wheel angle `angle` (errors taken off).
    pub fn rates(&self, x: &Row, motion: Vector2<f64>, inputs: &Inputs, angle: f64, blur: [f64; 2]) -> Rates {
        let slip = self.slip_angles(motion[0], motion[1], inputs, angle);
        let friction = x[FRICTION].exp();
        let [front, rear] = [(FRONT, 0), (REAR, 1)].map(|(i, axle)| {
            self.axle(x[i].exp(), friction, inputs.longitudinal[axle], slip[axle].0, blur[axle])
        });
        let (sin, cos) = angle.sin_cos();
        let along = inputs.longitudinal[0];
        let front_weight = GRAVITY * self.share[0];
        let rear_weight = GRAVITY * self.share[1];
        let across = along * sin + front.lateral * cos;
        let acceleration = front_weight * across + rear_weight * rear.lateral;
        // Weights of the two axles' forces in ṙ.
        let front_turn = self.turning * self.a * self.share[0];
        let rear_turn = -self.turning * self.b * self.share[1];
        let front_by_vy = cos * front.by_angle * slip[0].1;
        let rear_by_vy = rear.by_angle * slip[1].1;
        let by_vy = [front_weight * front_by_vy, front_turn * front_by_vy];
        let by_vy_rear = [rear_weight * rear_by_vy, rear_turn * rear_by_vy];
        let by_angle = cos * front.by_angle + along * cos - front.lateral * sin;
        let a_by_motion = [by_vy[0] + by_vy_rear[0], self.a * by_vy[0] - self.b * by_vy_rear[0]];
        let tires = [cos * front.by_ln_stiffness, rear.by_ln_stiffness, 0.0];
        let limits = [cos * front.by_ln_friction, rear.by_ln_friction];
        let a_by_tires = [
            front_weight * tires[0],
            rear_weight * tires[1],
            front_weight * limits[0] + rear_weight * limits[1],
        ];
        Rates {
            rate: Vector2::new(
                acceleration - x[BANK] - inputs.speed * motion[1],
                front_turn * across + rear_turn * rear.lateral,
            ),
            by_motion: Matrix2::new(
                a_by_motion[0],
                a_by_motion[1] - inputs.speed,
                by_vy[1] + by_vy_rear[1],
                self.a * by_vy[1] - self.b * by_vy_rear[1],
            ),
            by_angle: Vector2::new(front_weight * by_angle, front_turn * by_angle),
            by_tires: SMatrix::<f64, 2, 3>::new(
                a_by_tires[0],
                a_by_tires[1],
                a_by_tires[2],
                front_turn * tires[0],
                rear_turn * tires[1],
                front_turn * limits[0] + rear_turn * limits[1],
            ),
            acceleration,
            acceleration_by_motion: a_by_motion,
            acceleration_by_angle: front_weight * by_angle,
            acceleration_by_tires: a_by_tires,
        }
    }

    /// How far each axle's force is from its limit, as derivatives by the state: those of
    /// C |α| − √(μ² − x²), by which the kink of a piecewise linear tire is blurred.
    pub fn margins(&self, x: &Row, inputs: &Inputs, angle: f64) -> [(f64, Row); 2] {
        let slip = self.slip_angles(x[VY], x[YAW], inputs, angle);
        let friction = x[FRICTION].exp();
        [(FRONT, 0, self.a), (REAR, 1, -self.b)].map(|(i, axle, lever)| {
            let stiffness = x[i].exp();
            let (alpha, by_vy) = slip[axle];
            let limit = limit(friction, inputs.longitudinal[axle]);
            let mut row = Row::zeros();
            let sign = alpha.signum();
            row[VY] = sign * stiffness * by_vy;
            row[YAW] = lever * row[VY];
            row[i] = stiffness * alpha.abs();
            row[FRICTION] = -friction * friction / limit;
            if axle == 0 {
                row[ANGLE] = sign * stiffness;
            }
            (stiffness * alpha.abs() - limit, row)
        })
    }

    /// One axle's force. All curves are of the form y = l f(C α/l) with the limit l, which gives their
    /// derivatives by C and l from the one by α.
    fn axle(&self, stiffness: f64, friction: f64, along: f64, alpha: f64, blur: f64) -> AxleForce {
        let limit = limit(friction, along);
        let (lateral, by_angle, by_limit) = match self.tire {
            Tire::PiecewiseLinear(_) => blurred(stiffness, limit, alpha, blur),
            Tire::Linear(_) => (stiffness * alpha, stiffness, 0.0),
            tire => {
                let lateral = tire.force(stiffness, limit, alpha);
                let by_angle = tire.slope(stiffness, limit, alpha);
                (lateral, by_angle, (lateral - alpha * by_angle) / limit)
            }
        };
        AxleForce {
            lateral,
            by_angle,
            by_ln_stiffness: alpha * by_angle,
            by_ln_friction: by_limit * friction * friction / limit,
        }
    }

    /// Does the tire saturate at all?
    pub fn saturates(&self) -> bool {
        !matches!(self.tire, Tire::Linear(_))
    }

    /// Has it a kink that must be blurred?
    pub fn has_kink(&self) -> bool {
        self.blurs && matches!(self.tire, Tire::PiecewiseLinear(_))
    }
}

/// What the friction circle leaves for the lateral force.
fn limit(friction: f64, along: f64) -> f64 {
    let least = Model::LEAST_SHARE * friction;
    (friction * friction - along * along).max(least * least).sqrt()
}

/// The piecewise linear tire at an uncertain place: the mean of min(C |α|, l) where the difference of the two is
/// normally distributed with standard deviation `blur` (Clark 1961), with its derivatives by α and l. These
/// are the probabilities of being on either side of the kink, the statistical linearization of the curve.
fn blurred(stiffness: f64, limit: f64, alpha: f64, blur: f64) -> (f64, f64, f64) {
    let linear = stiffness * alpha.abs();
    let margin = limit - linear;
    if margin.abs() >= 5.0 * blur {
        return if margin > 0.0 {
            (stiffness * alpha, stiffness, 0.0)
        } else {
            (limit.copysign(alpha), 0.0, 1.0_f64.copysign(alpha))
        };
    }
    let beta = margin / blur;
    let density = (-0.5 * beta * beta).exp() * 0.398_942_280_401_432_7;
    let sticking = normal_probability(beta, density);
    let mean = linear * sticking + limit * (1.0 - sticking) - blur * density;
    (mean.copysign(alpha), stiffness * sticking, (1.0 - sticking).copysign(alpha))
}

/// P(z < `beta`) of a standard normal variable whose density there is known: Abramowitz and Stegun 26.2.17,
/// error below 1e-7.
fn normal_probability(beta: f64, density: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * beta.abs());
    let series = t
        * (0.319_381_530
            + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = density * series;
    if beta > 0.0 { 1.0 - tail } else { tail }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::body::{External, Steer, Velocity};
    use crate::model::force::{AddedMass, WheelMotion};
    use crate::model::tire::{Brush, PiecewiseLinear};
    use crate::model::{Plant, Vehicle};

    fn model(tire: Tire) -> Model {
        let mut vehicle = Vehicle::thesis();
        vehicle.cg_to_front_m.value = 1.3;
        Model::new(&Car::new(&vehicle), tire)
    }

    fn state(friction: f64) -> Row {
        let mut x = Row::zeros();
        (x[VY], x[YAW], x[ANGLE]) = (-0.4, 0.3, 0.08);
        (x[FRONT], x[REAR], x[FRICTION]) = (11.0_f64.ln(), 13.0_f64.ln(), f64::ln(friction));
        x
    }

    /// Rates and acceleration at `x`, its own motion and angle.
    fn at(model: &Model, x: &Row, blur: f64) -> ([f64; 3], Rates) {
        let inputs = Inputs { speed: 21.0, longitudinal: [0.15, 0.0], rear_angle: 0.01 };
        let rates = model.rates(x, Vector2::new(x[VY], x[YAW]), &inputs, x[ANGLE], [blur; 2]);
        ([rates.rate[0], rates.rate[1], rates.acceleration], rates)
    }

    #[test]
    fn the_derivatives_are_those_of_the_rates() {
        let cases = [
            (Tire::Brush(Brush), 0.9, 0.0),
            (Tire::Brush(Brush), 0.4, 0.0),
            (Tire::PiecewiseLinear(PiecewiseLinear), 0.9, 0.001),
            // The front axle just at its limit: the kink's blur has its derivatives, too.
            (Tire::PiecewiseLinear(PiecewiseLinear), 0.78, 0.1),
        ];
        for (tire, friction, blur) in cases {
            let model = model(tire);
            let x = state(friction);
            let (_, rates) = at(&model, &x, blur);
            for i in [VY, YAW, ANGLE, FRONT, REAR, FRICTION] {
                let step = 1e-6;
                let (mut above, mut below) = (x, x);
                above[i] += step;
                below[i] -= step;
                let (above, below) = (at(&model, &above, blur).0, at(&model, &below, blur).0);
                let column = match i {
                    VY | YAW => {
                        [rates.by_motion[(0, i)], rates.by_motion[(1, i)], rates.acceleration_by_motion[i]]
                    }
                    ANGLE => [rates.by_angle[0], rates.by_angle[1], rates.acceleration_by_angle],
                    tire => {
                        let j = tire - FRONT;
                        [rates.by_tires[(0, j)], rates.by_tires[(1, j)], rates.acceleration_by_tires[j]]
                    }
                };
                for k in 0..3 {
                    let difference = (above[k] - below[k]) / (2.0 * step);
                    assert!(
                        (difference - column[k]).abs() < 1e-3 * (1.0 + difference.abs()),
                        "{tire:?} {friction} state {i} row {k}: {difference} {}",
                        column[k]
                    );
                }
            }
        }
    }

    /// With the same forces left and right the car is a single track: with a force along where the tire has an ellipse, and
    /// without where it has its own combined slip.
    #[test]
    fn it_is_the_core_with_both_sides_alike() {
        let mut vehicle = Vehicle::thesis();
        vehicle.cg_to_front_m.value = 1.3;
        let Plant { body, mut nominal, radius, wheel_inertia, .. } = Plant::new(&vehicle);
        let added = AddedMass::new(&body, radius.map(|radius| wheel_inertia / (radius * radius)));
        let cases = [
            (Tire::PiecewiseLinear(PiecewiseLinear), 0.9, 0.15),
            (Tire::PiecewiseLinear(PiecewiseLinear), 0.4, 0.15),
            (Tire::Brush(Brush), 0.9, 0.0),
        ];
        for (tire, friction, along) in cases {
            let x = state(friction);
            let inputs = Inputs { speed: 21.0, longitudinal: [along, 0.0], rear_angle: 0.01 };
            let reduced = model(tire).rates(&x, Vector2::new(x[VY], x[YAW]), &inputs, x[ANGLE], [0.0; 2]);
            let velocity = Velocity { vx: inputs.speed, vy: x[VY], yaw_rate: x[YAW] };
            let mut motion = WheelMotion::new(&body, velocity, Steer::new(x[ANGLE]), None);
            motion.slip_angle[2..].iter_mut().for_each(|angle| *angle += inputs.rear_angle);
            let used = [along, along, 0.0, 0.0];
            let fx = std::array::from_fn(|i| used[i] * nominal.load[i]);
            let fy = std::array::from_fn(|i| {
                let contact = &mut nominal.contact[i];
                (contact.friction_x, contact.friction_y) = (friction, friction);
                contact.stiffness_y = x[if i < 2 { FRONT } else { REAR }].exp();
                tire.across(&tire, contact, used[i], motion.slip_angle[i]) * nominal.load[i]
            });
            let bare = motion.accelerate(&body, &fx, &fy, &External::none());
            let core = added.carried(&body, &motion, &bare, 0.0).acceleration;
            assert!((core.ay - reduced.acceleration).abs() < 1e-9, "{tire:?} {core:?} {reduced:?}");
            assert!((core.vy_rate - reduced.rate[0]).abs() < 1e-9, "{tire:?} {core:?} {reduced:?}");
            assert!((core.yaw - reduced.rate[1]).abs() < 1e-9, "{tire:?} {core:?} {reduced:?}");
        }
    }

    #[test]
    fn what_is_used_along_the_car_is_not_there_across_it() {
        let tire = model(Tire::PiecewiseLinear(PiecewiseLinear));
        let force = tire.axle(12.0, 0.5, 0.3, -0.2, 1e-3);
        assert!((force.lateral + 0.4).abs() < 1e-12 && force.by_angle == 0.0);
        // dy/dμ = μ/√(μ² − x²), by ln μ times μ.
        assert!((force.by_ln_friction + 0.5 * 0.5 / 0.4).abs() < 1e-12);
    }

    #[test]
    fn the_blurred_kink_is_the_mean_of_the_curve_over_what_is_not_known() {
        let (stiffness, limit, alpha, blur) = (10.0, 0.5, 0.049, 0.02);
        let (mean, _, _) = blurred(stiffness, limit, alpha, blur);
        let n = 20_000;
        let numeric: f64 = (0..n)
            .map(|i| {
                let z = -6.0 + 12.0 * (f64::from(i) + 0.5) / f64::from(n);
                let density = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
                (stiffness * alpha + blur * z).min(limit) * density * 12.0 / f64::from(n)
            })
            .sum();
        assert!((mean - numeric).abs() < 1e-6, "{mean} {numeric}");
    }
}
