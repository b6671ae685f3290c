//! Wheel loads and how the tires' stiffness goes with them.

use super::{Acting, Scale, Spec};

/// Smallest share of its load that a wheel keeps: the model ends where wheels lift.
const SMALLEST_SHARE: f64 = 0.05;

/// Smallest distance of the centre of gravity to an axle, m.
const SMALLEST_LEVER_M: f64 = 0.05;

/// Of the tires' stiffness to what the wheels carry, where load is moved or added.
pub(super) const SENSITIVITY: Spec = Spec {
    name: "load_sensitivity",
    words: "load sensitivity of the tires",
    unit: "1",
    scale: Scale::Linear,
    mean: 0.6,
    std: 0.25,
    bounds: (0.0, 1.0),
    step: 0.1,
    model_error: 0.2,
    is_main: false,
};

/// How stiffness goes with load: in N with its power 1 − e near the usual load, and the more it falls behind
/// the further the load grows, `growth` for each e-fold. The normalized stiffness falls accordingly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sensitivity {
    pub(super) along: f64,
    pub(super) across: f64,
    pub(super) growth: f64,
}

impl Sensitivity {
    /// The same along and across, a power of the load.
    pub(super) fn power(e: f64) -> Self {
        Self { along: e, across: e, growth: 0.0 }
    }
}

/// Multiplies a wheel's load.
pub(super) fn change(on: &mut Acting, wheel: usize, share: f64, sensitivity: Sensitivity) {
    let share = share.max(SMALLEST_SHARE);
    on.load[wheel] *= share;
    // Powers of the share by its logarithm, taken once.
    let folds = share.ln();
    let further = 0.5 * sensitivity.growth * folds;
    let along = (-folds * (sensitivity.along + further)).exp();
    let is_alike = sensitivity.across == sensitivity.along;
    let across = if is_alike { along } else { (-folds * (sensitivity.across + further)).exp() };
    on.contact[wheel].stiffness_x *= along;
    on.contact[wheel].stiffness_y *= across;
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
        change(on, wheel, heavier * share, Sensitivity::power(sensitivity));
    }
}
