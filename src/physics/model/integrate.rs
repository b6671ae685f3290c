//! Integration of the plant: classical Runge–Kutta of fourth order, in as many substeps as the
//! wheels need.
//!
//! A wheel on its tire is a fast first-order system of rate λ = k N r² / (J v): 400 1/s for the
//! thesis's car at 20 m/s, 30 times that at walking pace; everything else in the plane is slower
//! than 100 1/s. RK4 is stable up to λ h = 2.78 and its error in a decaying mode is
//! (λ h)⁵/120 per step; the substep is therefore chosen with λ h ≤ 1 ([`Plant::fastest_rate`]), from
//! the state at the start of each step, so that the number of substeps is deterministic. At
//! ordinary speeds this means one to a few substeps per millisecond. An implicit method would save
//! work below 5 m/s only, where little time is spent, and would cost accuracy in ABS cycles.
//!
//! Brakes keep their direction through a substep and a wheel that crosses zero under its brake is
//! stopped there: an error of at most one substep of that wheel's own motion.

use super::Real;
use super::plant::{Conditions, Controls, Plainly, Plant, State};

/// λ h that a substep may reach.
const RATE_TIMES_STEP: f64 = 1.0;

/// Substeps of one step, at most: what a scenario may ask for is checked against it.
pub const MAX_SUBSTEPS: u32 = 2000;

/// Substeps that a step of `h` seconds from this state needs.
#[inline]
pub fn substeps(plant: &Plant, state: &State, conditions: &Conditions, h: f64) -> u32 {
    let wanted = plant.fastest_rate(&state.velocity, conditions) * h / RATE_TIMES_STEP;
    // The cast saturates, and turns not-a-number into zero.
    (wanted.ceil() as u32).clamp(1, MAX_SUBSTEPS)
}

/// The state after `h` seconds, with the controls going linearly from `from` to `to`, in as many
/// substeps as the wheels need.
#[inline]
pub fn advance(
    plant: &Plant,
    state: &State,
    from: &Controls,
    to: &Controls,
    conditions: &Conditions,
    h: f64,
) -> State {
    advance_in(plant, state, from, to, conditions, h, substeps(plant, state, conditions, h))
}

/// The same in a given number of substeps, for tests of convergence.
#[inline(always)]
pub fn advance_in<T: Real>(
    plant: &Plant<T>,
    state: &State<T>,
    from: &Controls<T>,
    to: &Controls<T>,
    conditions: &Conditions<T>,
    h: f64,
    substeps: u32,
) -> State<T> {
    let share = 1.0 / f64::from(substeps);
    let mut state = *state;
    let mut start = *from;
    for i in 0..substeps {
        let middle = from.towards(to, share * (f64::from(i) + 0.5));
        let end = from.towards(to, share * f64::from(i + 1));
        state = runge_kutta(plant, &state, [&start, &middle, &end], conditions, h * share);
        start = end;
    }
    state
}

/// One step, with the controls at its start, middle and end.
#[inline(always)]
fn runge_kutta<T: Real>(
    plant: &Plant<T>,
    state: &State<T>,
    [start, middle, end]: [&Controls<T>; 3],
    conditions: &Conditions<T>,
    h: f64,
) -> State<T> {
    let braking = plant.braking(state, start, conditions, &Plainly);
    let stages =
        [(start, h / 6.0, 0.5 * h), (middle, h / 3.0, 0.5 * h), (middle, h / 3.0, h), (end, h / 6.0, 0.0)];
    let (mut next, mut probe) = (*state, *state);
    // As a loop: the equations are long, one copy of them is enough.
    for (controls, weight, ahead) in stages {
        let k = plant.braked(&probe, controls, conditions, &braking, &Plainly).rate;
        next = next.advanced(&k, weight);
        probe = state.advanced(&k, ahead);
    }
    for (i, brake) in braking.iter().enumerate() {
        next.wheel_speed[i] = brake.stopped(next.wheel_speed[i], end.brake_torque[i]);
    }
    next
}
