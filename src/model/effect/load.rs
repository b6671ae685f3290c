//! Wheel loads and how the tires' stiffness goes with them.

use super::{Acting, Scale, Spec};

/// Smallest share of its load that a wheel keeps: the model ends where wheels lift.
const SMALLEST_SHARE: f64 = 0.05;

/// Smallest distance of the centre of gravity to an axle, m.
const SMALLEST_LEVER_M: f64 = 0.05;

/// Of the tires' stiffness to what the wheels carry, where load is moved or added.
pub(super) const SENSITIVITY: Spec = Spec {
    name: "load_sensitivity",
    unit: "1",
    scale: Scale::Linear,
    mean: 0.6,
    std: 0.25,
    bounds: (0.0, 1.0),
    step: 0.1,
    is_main: false,
};

/// Multiplies a wheel's load. Its stiffness in N grows less than in proportion, with the load to the
/// power 1 − `sensitivity` (along, across); the normalized stiffness falls accordingly.
pub(super) fn change(on: &mut Acting, wheel: usize, share: f64, sensitivity: [f64; 2]) {
    let share = share.max(SMALLEST_SHARE);
    on.load[wheel] *= share;
    on.contact[wheel].stiffness_x *= share.powf(-sensitivity[0]);
    on.contact[wheel].stiffness_y *= share.powf(-sensitivity[1]);
}

/// Moves the centre of gravity rearwards, m, and adds mass, kg, with what the axles then carry.
pub(super) fn shift(on: &mut Acting, rearwards: f64, mass: f64, sensitivity: f64) {
    let (a, b) = (on.body.a, on.body.b);
    let rearwards = rearwards.clamp(SMALLEST_LEVER_M - a, b - SMALLEST_LEVER_M);
    let heavier = 1.0 + mass / on.body.mass;
    on.body.mass += mass;
    on.body.a += rearwards;
    on.body.b -= rearwards;
    for wheel in 0..4 {
        let share = if wheel < 2 { (b - rearwards) / b } else { (a + rearwards) / a };
        change(on, wheel, heavier * share, [sensitivity; 2]);
    }
}
