//! A differential that holds its wheels together.

use super::{Acting, Effect, Growth, Kind, Needs, Now, Scale, SearchHints, Setting, Spec, Usual};
use crate::Wheel;

/// The slower wheel of a driven axle gets more of its torque than the faster one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LimitedSlipDifferential {
    locking: f64,
    preload: f64,
}

/// Slower than this a car's speed says little of how its wheels turn, m/s. Numerical.
const SLOWEST_MPS: f64 = 1.0;

/// A limit below this makes no difference, N. Numerical.
const LEAST_FORCE: f64 = 1e-3;

/// See [`super::KINDS`].
///
/// Wheels that are held together slip by half the difference of their speeds, until the clutch between them slides.
pub static KIND: Kind = Kind {
    name: "limited_slip_differential",
    words: "limited-slip differential",
    about: "the slower wheel of a driven axle gets more of the drive torque than the faster one",
    equation: "F_slow − F_fast = 2 F_m tanh(C_x F_z (t/2) r/(v F_m));  F_m = (S m max(a_x, 0) + T_0/r_w)/2",
    source: "Milliken & Milliken, Race Car Vehicle Dynamics, ch. 20; Reimpell, The Automotive Chassis, ch. 1",
    place: "the driven wheels' forces along",
    to_tell_apart: "the same curve coasting and with much drive: it turns the car out of the curve with the drive torque, \
                    load transfer does so under braking, too, with the other sign",
    channels: &[],
    parameters: &[
        // Clutch and gear types have 0.25 to 0.6, open ones up to 0.1 by friction (Reimpell).
        Spec {
            name: "locking_value",
            words: "locking value",
            unit: "1",
            scale: Scale::Linear,
            mean: 0.0,
            std: 0.3,
            bounds: (0.0, 1.0),
            step: 0.05,
            model_error: 0.1,
            is_main: true,
        },
        Spec {
            name: "preload_nm",
            words: "torque that it holds without drive",
            unit: "N m",
            scale: Scale::Linear,
            mean: 0.0,
            std: 80.0,
            bounds: (0.0, 600.0),
            step: 10.0,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
    ],
    course: None,
    // By the change of speed alone an open differential's friction, an axle's toe and a heavier load look like it.
    search: SearchHints {
        needs: Needs::KnownTorque,
        growth: Growth::Proportional,
        usual: Some(Usual { of: None, bounds: (0.0, 0.2) }),
        ..SearchHints::USUAL
    },
    make: |setting: &Setting<'_>| {
        let [locking, preload] = std::array::from_fn(|i| setting.values[i]);
        Box::new(LimitedSlipDifferential { locking, preload })
    },
};

impl Effect for LimitedSlipDifferential {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let drive = on.body.mass * now.ax.max(0.0);
        let axles = [on.body.half_track_front, on.body.half_track_rear];
        let driven = [0, 1].map(|axle| now.driven_axle.drives(Wheel::ALL[2 * axle]));
        let share = if driven == [true; 2] { 0.5 } else { 1.0 };
        for (axle, half_track) in axles.into_iter().enumerate().filter(|(axle, _)| driven[*axle]) {
            let left = 2 * axle;
            let most = 0.5 * (self.locking * share * drive + self.preload / on.radius[left]);
            if most < LEAST_FORCE {
                continue;
            }
            // Held together, the wheel inside of the curve is faster than its place on the body, the other one slower.
            let slip = half_track * now.velocity.yaw_rate / now.velocity.vx.max(SLOWEST_MPS);
            let wheels = [left, left + 1].map(|wheel| on.contact[wheel].stiffness_x * on.load[wheel]);
            let stiffness = 2.0 * wheels[0] * wheels[1] / (wheels[0] + wheels[1]);
            let force = most * (stiffness * slip / most).tanh();
            on.brake[left] -= force;
            on.brake[left + 1] += force;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;
    use crate::model::DrivenAxle;

    /// By how much the left rear wheel of a rear-wheel drive drives more than the right one, N.
    fn more_at_left(values: [f64; 2], ax: f64, yaw_rate: f64) -> f64 {
        let mut bench = Bench::driving(20.0);
        (bench.now.ax, bench.now.velocity.yaw_rate) = (ax, yaw_rate);
        bench.now.driven_axle = DrivenAxle::Rear;
        let on = bench.acted(&*simple(&KIND, &values), &[]);
        assert_eq!(on.brake[..2], [0.0; 2], "the front axle is not driven");
        assert!(on.brake.iter().sum::<f64>().abs() < 1e-9, "nothing is gained along");
        on.brake[3] - on.brake[2]
    }

    #[test]
    fn the_slower_wheel_drives_more_until_the_clutch_slides() {
        let mass = Bench::driving(20.0).plain().body.mass;
        let left_turn = more_at_left([0.5, 0.0], 2.0, 0.5);
        assert!((left_turn / (0.5 * mass * 2.0) - 1.0).abs() < 0.01, "{left_turn}");
        assert!((more_at_left([0.5, 0.0], 2.0, -0.5) + left_turn).abs() < 1e-9);
        assert_eq!(more_at_left([0.5, 0.0], 2.0, 0.0), 0.0);
        assert_eq!(more_at_left([0.5, 0.0], -2.0, 0.5), 0.0, "braking is not its business");
    }

    #[test]
    fn a_locked_axle_slips_by_the_difference_of_its_speeds() {
        let on = Bench::driving(20.0).plain();
        let slip = on.body.half_track_rear * 1e-3 / 20.0;
        let force = 2.0 * on.contact[2].stiffness_x * on.load[2] * slip;
        assert!((more_at_left([0.0, 600.0], 0.0, 1e-3) / force - 1.0).abs() < 0.01);
    }

    #[test]
    fn axles_that_share_the_torque_lock_by_their_shares() {
        let mut bench = Bench::driving(20.0);
        (bench.now.ax, bench.now.velocity.yaw_rate, bench.now.driven_axle) = (2.0, 0.5, DrivenAxle::All);
        let on = bench.acted(&*simple(&KIND, &[0.5, 0.0]), &[]);
        assert!((on.brake[1] / on.brake[3] - 1.0).abs() < 0.01);
        assert!(((on.brake[3] - on.brake[2]) / (0.25 * on.body.mass * 2.0) - 1.0).abs() < 0.01);
    }
}
