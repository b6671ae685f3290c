//! Wind from the side.

use super::{Acting, Course, Disturbance, Effect, Kind, Now, Scale, SearchHints, Setting, Spec};

/// A course of the force, N, to the left.
#[derive(Clone, Debug, PartialEq)]
struct Crosswind {
    lever: f64,
    force: Course,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "crosswind",
    words: "crosswind",
    about: "wind pushes the car sideways, and turns it as far as it does not push at the centre of gravity",
    equation: "m a_y = … + u,  J_z ṙ = … + x_p u",
    source: "aerodynamic side force and yaw moment",
    place: "lateral force balance",
    to_tell_apart: "straight ahead with the wheel held still, in both directions: the wind changes its \
                    side, and unlike a bank the accelerometer feels it at once",
    channels: &[],
    parameters: &[Spec {
        name: "centre_of_pressure_m",
        words: "centre of pressure ahead of the centre of gravity",
        unit: "m",
        scale: Scale::Linear,
        mean: 0.3,
        std: 0.5,
        bounds: (-3.0, 3.0),
        step: 0.1,
        model_error: Spec::MODEL_ERROR,
        is_main: false,
    }],
    course: Some(Disturbance {
        unit: "N",
        rms_name: "force_rms_n",
        words: "force, rms",
        size: 300.0,
        length_s: 1.5,
        sign: 0.0,
        ..Disturbance::USUAL
    }),
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| {
        Box::new(Crosswind { lever: setting.values[0], force: setting.course.clone() })
    },
};

impl Effect for Crosswind {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let force = self.force.at(now);
        on.external.fy += force;
        on.external.moment += self.lever * force;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, constant};
    use super::*;

    #[test]
    fn ahead_of_the_centre_it_turns_the_car_with_it() {
        let on = Bench::driving(20.0).acted(&*constant(&KIND, &[0.4], 500.0), &[]);
        assert_eq!((on.external.fx, on.external.fy, on.external.moment), (0.0, 500.0, 200.0));
    }
}
