//! The road climbs.

use super::{Acting, Course, Disturbance, Effect, Kind, Needs, Now, SearchHints, Setting};
use crate::model::GRAVITY;

/// A course of the road's grade, rad, positive uphill.
#[derive(Clone, Debug, PartialEq)]
struct RoadGrade {
    angle: Course,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "road_grade",
    words: "road grade",
    about: "the road climbs or falls: gravity pulls the car along and no accelerometer feels it",
    equation: "v̇_x = F_x/m + v_y r − g sin u",
    source: "rigid-body dynamics on an inclined plane",
    place: "longitudinal force balance",
    to_tell_apart: "the same road in both directions at steady speed: a grade changes its sign, a wrong \
                    resistance does not; standing on it, the longitudinal accelerometer shows it",
    channels: &[],
    parameters: &[],
    course: Some(Disturbance {
        unit: "rad",
        rms_name: "grade_rms_rad",
        words: "grade, rms",
        size: 0.03,
        length_s: 5.0,
        sign: 0.0,
        ..Disturbance::USUAL
    }),
    search: SearchHints { needs: Needs::KnownTorque, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| Box::new(RoadGrade { angle: setting.course.clone() }),
};

impl Effect for RoadGrade {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        on.gravity[0] -= GRAVITY * self.angle.at(now).sin();
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, constant};
    use super::*;

    #[test]
    fn uphill_gravity_pulls_back() {
        let on = Bench::driving(20.0).acted(&*constant(&KIND, &[], 0.05), &[]);
        assert!((on.gravity[0] + 9.81 * 0.05f64.sin()).abs() < 1e-12);
        assert_eq!((on.gravity[1], on.external.fx), (0.0, 0.0));
    }
}
