//! What drives would tell with one more that nobody has driven yet.

use super::super::fit::FreeFit;
use super::super::inputs::{FreeDrive, turning};
use super::super::numbers::{Free, Scope, placed};
use super::super::run::run;
use super::climb::State;
use super::colour::{CHANNELS, Series};
use super::rows::EVERY;
use physics::model::Vehicle;
use predict::car::Compute;

/// The drives with one more, as the fitted car would drive it: its sensors read what a free run says, with the errors that
/// the last drive left, over and over. It is measured as that drive was. None where the car would not get through it.
pub(super) fn with_planned<'a>(
    found: &FreeFit<'a>,
    (state, vehicle): (&State<'_>, &Vehicle),
    drives: &[FreeDrive],
    mut planned: FreeDrive,
) -> Option<(FreeFit<'a>, Vec<FreeDrive>)> {
    let (last, number) = (drives.len().checked_sub(1)?, drives.len());
    let also = |free: &mut Vec<Free>, at: &mut Vec<f64>| {
        let of_last = |(free, _): &(&Free, &f64)| free.of == Scope::Recording(last);
        let own: Vec<(Free, f64)> =
            free.iter().zip(at.iter()).filter(of_last).map(|(free, at)| (*free, *at)).collect();
        for (own, value) in own {
            free.push(Free { of: Scope::Recording(number), ..own });
            at.push(value);
        }
    };
    let (mut free, mut at) = (state.free.clone(), state.at.clone());
    also(&mut free, &mut at);
    let (model, sensing) = placed(&state.model, &free, &at, number);
    let read = run(&planned, &model.car(), sensing, Compute::Readings);
    let drives_through = read.yaw_rate.iter().all(|rate| rate.abs() < FASTEST_TURN);
    if !drives_through {
        return None;
    }
    let [yaw_rate, lateral, front, rear] = left_over(&state.errors[last], planned.points());
    let with =
        |read: &[f64], error: &[f64]| read.iter().zip(error).map(|(read, error)| read + error).collect();
    planned.yaw_rate = with(&read.yaw_rate, &yaw_rate);
    planned.lateral = drives[last].lateral.as_ref().map(|_| with(&read.lateral, &lateral));
    for (axle, error) in [front, rear].iter().enumerate() {
        let by_wheels = || turning(vehicle, axle, &read.wheels[2 * axle], &read.wheels[2 * axle + 1]);
        planned.axles[axle] = drives[last].axles[axle].as_ref().map(|_| with(&by_wheels(), error));
    }
    let mut fit = found.clone();
    also(&mut fit.free, &mut fit.at);
    Some((fit, drives.iter().cloned().chain([planned]).collect()))
}

/// A car that turns faster spins, rad/s.
const FASTEST_TURN: f64 = 2.0;

/// Errors of a drive for so many grid points. What is not known counts as none.
fn left_over(errors: &Series, points: usize) -> [Vec<f64>; CHANNELS] {
    errors.each_ref().map(|errors| {
        let error = |i: usize| errors.get(i / EVERY % errors.len().max(1)).copied();
        (0..points).map(|i| error(i).filter(|error| error.is_finite()).unwrap_or(0.0)).collect()
    })
}
