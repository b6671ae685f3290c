//! Mass that the vehicle table does not know.

use super::{Acting, Effect, Kind, Now, Scale, SearchHints, Setting, Spec, load};

/// Further mass at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Payload {
    mass: f64,
    behind: f64,
    at: f64,
    load_sensitivity: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "payload",
    words: "payload",
    about: "passengers or load that the vehicle table does not know of",
    equation: "m → m + p at d behind the centre of gravity;  J_z → J_z + p m d²/(m + p);  C ∝ F_z^(1 − e)",
    source: "rigid-body dynamics",
    place: "longitudinal force balance",
    to_tell_apart: "accelerating and braking with known torques, and lane changes: all of mass, inertia \
                    and loads change together; a wrong torque ratio changes the longitudinal balance only",
    channels: &[],
    parameters: &[
        Spec {
            name: "mass_kg",
            words: "mass",
            unit: "kg",
            scale: Scale::Linear,
            mean: 0.0,
            std: 150.0,
            bounds: (-500.0, 3000.0),
            step: 20.0,
            model_error: Spec::MODEL_ERROR,
            is_main: true,
        },
        Spec {
            name: "position_behind_cg_m",
            words: "position behind the centre of gravity",
            unit: "m",
            scale: Scale::Linear,
            // Rear seats are some decimetres behind it, a boot more than a metre.
            mean: 0.7,
            std: 0.6,
            bounds: (-3.0, 3.0),
            step: 0.1,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
        Spec::AT_S,
        load::SENSITIVITY,
    ],
    course: None,
    search: SearchHints { from_start: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        let [mass, behind, at, load_sensitivity] = std::array::from_fn(|i| setting.values[i]);
        Box::new(Payload { mass, behind, at, load_sensitivity })
    },
};

impl Effect for Payload {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        if now.t < self.at {
            return;
        }
        let empty = on.body.mass;
        let mass = self.mass.max(-0.5 * empty);
        let share = mass / (empty + mass);
        on.body.yaw_inertia =
            (on.body.yaw_inertia + share * empty * self.behind * self.behind).max(0.1 * on.body.yaw_inertia);
        load::shift(on, share * self.behind, mass, self.load_sensitivity);
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn ten_percent_in_the_boot() {
        let bench = Bench::driving(20.0);
        let on = bench.acted(&*simple(&KIND, &[170.0, 1.1, -1.0, 1.0]), &[]);
        assert!((on.body.mass - 1870.0).abs() < 1e-9);
        assert!((on.body.a - 1.6).abs() < 1e-12, "1.1 m × 170/1870 = 0.1 m");
        assert!((on.body.yaw_inertia - 1700.0 - 170.0 * 1700.0 / 1870.0 * 1.21).abs() < 1e-9);
        assert!((on.load.iter().sum::<f64>() - 1870.0 * 9.81).abs() < 1e-9);
        let moment = (on.load[0] + on.load[1]) * on.body.a - (on.load[2] + on.load[3]) * on.body.b;
        assert!(moment.abs() < 1e-8, "the loads balance about the new centre: {moment}");
        let stiffness = |on: &Acting| on.load[2] * on.contact[2].stiffness_y;
        assert!((stiffness(&on) / stiffness(&bench.plain()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn before_it_gets_in_nothing() {
        let bench = Bench::driving(20.0);
        assert_eq!(bench.acted(&*simple(&KIND, &[170.0, 1.1, 10.0, 1.0]), &[]), bench.plain());
    }
}
