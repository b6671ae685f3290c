//! What the tires of each axle gave at which slip angle: by the sensors along the ordinary car's free run, and as curves.

use super::fit::FreeFit;
use super::grid::{STEP_S, slope};
use super::inputs::{FreeDrive, compared_mean};
use super::numbers::placed;
use super::run::{Predicted, along};
use super::scores::TRACED_EVERY;
use crate::explain::model::Model;
use identify::Parameter;
use physics::Quantity;
use physics::model::GRAVITY;
use predict::car::{Compute, ExtendedCar};

/// One moment of an axle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxleForce {
    /// When, s from the recording's start.
    pub t: f64,
    /// Mean slip angle of its wheels, rad.
    pub slip_angle: f64,
    /// Lateral force of both over the axle's static load.
    pub force: f64,
}

/// Force over static load at slip angles, rad.
pub type TireCurve = Vec<[f64; 2]>;

/// An axle: front or rear.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxleTires {
    /// By recording, what the sensors say; empty without lateral acceleration.
    pub measured: Vec<(String, Vec<AxleForce>)>,
    /// The fitted tire at static load.
    pub fitted: TireCurve,
    /// The configured one.
    pub configured: TireCurve,
}

/// Curves have so many points. Numerical.
const CURVE_POINTS: u32 = 41;

/// They reach so far at least, rad: half a degree.
const LEAST_REACH: f64 = 0.0087;

/// Front and rear axle of a fitted car on its drives; `configured` is what it was before.
pub fn of(found: &FreeFit<'_>, configured: &Model<'_>, drives: &[FreeDrive]) -> [AxleTires; 2] {
    let mut both = [AxleTires::default(), AxleTires::default()];
    for (place, (drive, said)) in drives.iter().zip(&found.predicted).enumerate() {
        for (axle, forces) in both.iter_mut().zip(measured(found, place, drive, said)) {
            axle.measured.push((drive.name.clone(), forces));
        }
    }
    let (fitted, _) = placed(&found.model, &found.free, &found.at, 0);
    let fitted = fitted.car();
    let configured = configured.car();
    for (place, axle) in both.iter_mut().enumerate() {
        let all = axle.measured.iter().flat_map(|(_, forces)| forces);
        let reach = all.map(|it| it.slip_angle.abs()).fold(LEAST_REACH, f64::max);
        let curve = |car: &ExtendedCar| -> TireCurve {
            let angle = |i: u32| reach * (2.0 * f64::from(i) / f64::from(CURVE_POINTS - 1) - 1.0);
            (0..CURVE_POINTS).map(angle).map(|angle| [angle, car.force_at_rest(place, angle)]).collect()
        };
        (axle.fitted, axle.configured) = (curve(&fitted), curve(&configured));
    }
    both
}

/// Slip angles are the run's. Forces are the run's, too, and what the sensors say beyond its readings: so zeros, delays and
/// roll in the sensors are out of them, as far as they were fitted.
fn measured(found: &FreeFit<'_>, place: usize, drive: &FreeDrive, said: &Predicted) -> [Vec<AxleForce>; 2] {
    let Some(lateral) = &drive.lateral else { return Default::default() };
    let (model, sensing) = placed(&found.model, &found.free, &found.at, place);
    let car = model.car();
    let (mut angles, mut forces) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
    along(drive, &car, sensing, Compute::Rates, |point| {
        let felt = &point.now.felt;
        for axle in 0..2 {
            let [left, right] = [2 * axle, 2 * axle + 1];
            angles[axle].push(0.5 * (felt.slip_angle[left] + felt.slip_angle[right]));
            forces[axle].push(felt.fy[left] + felt.fy[right]);
        }
    });
    // As the accelerations are compared.
    let [angles, forces] = [angles, forces].map(|both| both.map(|values| compared_mean(&values)));
    let beyond = |measured: &[f64], said: &[f64]| -> Vec<f64> {
        measured.iter().zip(said).map(|(measured, said)| measured - said).collect()
    };
    let lateral = beyond(lateral, &said.lateral);
    let turning = slope(&compared_mean(&beyond(&drive.yaw_rate, &said.yaw_rate)));
    let get = |parameter| model.values.get(parameter);
    let (mass, inertia) = (get(Parameter::Mass), get(Parameter::YawInertia));
    let wheelbase = model.vehicle.wheelbase_m.value;
    let to_front = get(Parameter::CgToFront);
    // What a late sensor says of a moment it says later.
    let of = |values: &[f64], i: usize, quantity: Quantity| {
        let late = (car.delay(quantity as usize) / STEP_S).round() as isize;
        i.checked_add_signed(late).and_then(|i| values.get(i)).copied().unwrap_or(f64::NAN)
    };
    std::array::from_fn(|axle| {
        let (lever, sign) = [(wheelbase - to_front, 1.0), (to_front, -1.0)][axle];
        let load = mass * GRAVITY * lever / wheelbase;
        let at = |i: usize| {
            let push = mass * of(&lateral, i, Quantity::LateralAcceleration) * lever;
            let turn = sign * inertia * of(&turning, i, Quantity::YawRate);
            let force = (forces[axle][i] + (push + turn) / wheelbase) / load;
            AxleForce { t: drive.time(i), slip_angle: angles[axle][i], force }
        };
        let some = (0..drive.points()).step_by(TRACED_EVERY).filter(|i| drive.counts[*i]);
        some.map(at).filter(|it| it.force.is_finite() && it.slip_angle.is_finite()).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::bench::recorded;
    use super::super::{Asked, Ordinary};
    use physics::model::Uncertain;

    /// The points lie on the tire that was fitted, whatever the table says.
    #[test]
    fn the_sensors_forces_lie_on_the_fitted_tire() {
        let (mut vehicle, recording) = recorded("");
        vehicle.lateral_stiffness_front = Uncertain { value: 16.0, std: 6.0 };
        vehicle.lateral_stiffness_rear = Uncertain { value: 9.0, std: 4.0 };
        let found = Ordinary::of(&vehicle, &[], &[recording], Asked::CAR).unwrap();
        for axle in &found.tires {
            let forces = &axle.measured[0].1;
            assert!(forces.len() > 200, "{}", forces.len());
            let fitted = |angle: f64| {
                let next = axle.fitted.partition_point(|it| it[0] < angle).clamp(1, axle.fitted.len() - 1);
                let ([x0, y0], [x1, y1]) = (axle.fitted[next - 1], axle.fitted[next]);
                y0 + (angle - x0) / (x1 - x0) * (y1 - y0)
            };
            let square = |off: &dyn Fn(f64, f64) -> f64| {
                forces.iter().map(|it| off(it.slip_angle, it.force).powi(2)).sum::<f64>()
            };
            let (off, all) = (square(&|angle, force| force - fitted(angle)), square(&|_, force| force));
            assert!(off < 0.03 * all, "{off} of {all}");
            // A slip angle to the left gives a force to the left.
            assert!(axle.fitted.windows(2).all(|pair| pair[1][1] > pair[0][1]));
        }
    }
}
