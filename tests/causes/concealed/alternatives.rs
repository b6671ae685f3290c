//! Other explanations of a recording: one effect at a time, added to the plain model at a strength.

use super::hidden::{Hidden, LoadTransfer};

/// Another explanation; a strength of one is ordinary.
pub struct Alternative {
    pub name: &'static str,
    set: fn(&mut Hidden, f64),
    /// Whether a negative strength makes no sense.
    pub positive: bool,
}

impl Alternative {
    /// What it adds at a strength.
    pub fn at(&self, strength: f64) -> Hidden {
        let mut hidden = Hidden::default();
        (self.set)(&mut hidden, strength);
        hidden
    }

    /// The step of a finite difference in its strength. A much shorter relaxation than 4 cm is too stiff an equation
    /// for the fitted model's step.
    pub fn step(&self) -> f64 {
        if self.name == "relaxation_length" { 0.1 } else { 0.02 }
    }
}

const fn of(name: &'static str, positive: bool, set: fn(&mut Hidden, f64)) -> Alternative {
    Alternative { name, set, positive }
}

/// Those with one constant parameter. Series (bank, grade, wind, drift, patches) can follow anything and are left out.
pub const ALTERNATIVES: &[Alternative] = &[
    of("load_transfer", true, |h, x| {
        h.load_transfer = Some(LoadTransfer { height: 0.5 * x, front_share: 0.55, peak_load: 2.0 });
    }),
    of("body_roll", true, |h, x| h.roll_leak = 0.006 * x),
    of("roll_steer", false, |h, x| {
        h.roll_steer = 0.2 * x;
        h.roll_gain = 0.006;
    }),
    of("air_drag", true, |h, x| h.drag = 0.4 * x),
    of("rolling_resistance", true, |h, x| h.rolling = 0.012 * x),
    of("relaxation_length", true, |h, x| h.relaxation = 0.4 * x),
    of("steering_lag", true, |h, x| h.steering_lag = 0.06 * x),
    of("steering_compliance", true, |h, x| h.compliance = 1e-4 * x),
    of("steering_ratio", false, |h, x| h.ratio_curvature = 0.2 * x),
    of("rear_steer", true, |h, x| h.rear_steer = Some((0.15 * x, 16.0))),
    of("sensor_delay:yaw_rate", true, |h, x| h.faults[4].delay = 0.05 * x),
    of("sensor_delay:lateral_acceleration", true, |h, x| h.faults[5].delay = 0.05 * x),
    of("sensor_delay:longitudinal_acceleration", true, |h, x| h.faults[6].delay = 0.05 * x),
    of("sensor_delay:steering_wheel_angle", true, |h, x| h.faults[7].delay = 0.05 * x),
    of("sensor_scale:yaw_rate", false, |h, x| h.faults[4].scale = 0.05 * x),
    of("sensor_scale:lateral_acceleration", false, |h, x| h.faults[5].scale = 0.05 * x),
    of("sensor_scale:longitudinal_acceleration", false, |h, x| h.faults[6].scale = 0.05 * x),
    of("tire_radius:fl", false, |h, x| h.radius_error[0] = 0.005 * x),
    of("tire_radius:fr", false, |h, x| h.radius_error[1] = 0.005 * x),
    of("tire_radius:rl", false, |h, x| h.radius_error[2] = 0.005 * x),
    of("tire_radius:rr", false, |h, x| h.radius_error[3] = 0.005 * x),
    of("radius_growth", true, |h, x| h.radius_growth = 2e-5 * x),
    of("payload", true, |h, x| h.payload = 300.0 * x),
    of("tire_saturation", true, |h, x| h.saturation = (x > 1e-3).then(|| 1.0 / x)),
    of("combined_slip", true, |h, x| h.ellipse = (x > 0.0).then_some((x, 0.95))),
    of("brake_imbalance:front", false, |h, x| h.brake_imbalance[0] = 0.15 * x),
    of("brake_imbalance:rear", false, |h, x| h.brake_imbalance[1] = 0.15 * x),
    of("accelerometer_position", false, |h, x| h.accelerometer_at = 0.6 * x),
    of("wheel_alignment", false, |h, x| h.toe = [-0.01 * x, 0.01 * x, 0.0, 0.0]),
];
