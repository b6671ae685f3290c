//! The centre of gravity moves while one drives.

use super::{Acting, Effect, Kind, Now, Scale, SearchHints, Setting, Spec, load};

/// From a moment on the centre of gravity is elsewhere: something slid, someone moved.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CgShift {
    shift: f64,
    at: f64,
    load_sensitivity: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "cg_shift",
    words: "shifted centre of gravity",
    about: "from a moment on the centre of gravity lies further back (or ahead)",
    equation: "a → a + s, b → b − s from t ≥ at;  F_z front ∝ b − s, rear ∝ a + s;  C ∝ F_z^(1 − e)",
    source: "rigid-body statics",
    place: "yaw moment balance",
    to_tell_apart: "the same steady turns and lane changes before and after: the balance between front and \
                    rear changes from one moment on, on every surface, and stays",
    channels: &[],
    parameters: &[
        Spec {
            name: "shift_m",
            words: "shift to the rear",
            unit: "m",
            scale: Scale::Linear,
            mean: 0.0,
            std: 0.08,
            bounds: (-0.8, 0.8),
            step: 0.01,
            model_error: Spec::MODEL_ERROR,
            is_main: true,
        },
        Spec::AT_S,
        load::SENSITIVITY,
    ],
    course: None,
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| {
        Box::new(CgShift {
            shift: setting.values[0],
            at: setting.values[1],
            load_sensitivity: setting.values[2],
        })
    },
};

impl Effect for CgShift {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        if now.t >= self.at {
            load::shift(on, self.shift, 0.0, self.load_sensitivity);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn from_its_moment_on_the_rear_carries_more() {
        let mut bench = Bench::driving(20.0);
        let effect = simple(&KIND, &[0.15, 30.0, 0.6]);
        bench.now.t = 29.9;
        assert_eq!(bench.acted(&*effect, &[]), bench.plain());
        bench.now.t = 30.0;
        let (plain, on) = (bench.plain(), bench.acted(&*effect, &[]));
        assert!((on.body.a - 1.65).abs() < 1e-12 && (on.body.b - 1.35).abs() < 1e-12);
        assert!((on.load[0] / plain.load[0] - 0.9).abs() < 1e-12);
        assert!((on.load[2] / plain.load[2] - 1.1).abs() < 1e-12);
        let stiffness = |on: &Acting, i: usize| on.load[i] * on.contact[i].stiffness_y;
        let share = stiffness(&on, 0) / stiffness(&plain, 0);
        assert!((share - 0.9f64.powf(0.4)).abs() < 1e-12, "the force stiffness falls less than the load");
    }
}
