//! The road leans.

use super::{Acting, Course, Disturbance, Effect, Kind, Now, SearchHints, Setting};
use crate::model::GRAVITY;

/// A course of the road's bank, rad, positive where gravity pulls to the left.
#[derive(Clone, Debug, PartialEq)]
struct RoadBank {
    angle: Course,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "road_bank",
    words: "road bank",
    about: "the road is banked: gravity pulls the car sideways and no accelerometer feels it",
    equation: "v̇_y = F_y/m − v_x r + g sin u",
    source: "rigid-body dynamics on an inclined plane",
    place: "lateral force balance",
    to_tell_apart: "the same road in both directions: its bank changes sign with the direction, a wind or \
                    an offset of a sensor does not; and stand still on it, where the accelerometer shows \
                    the bank and no wind",
    channels: &[],
    parameters: &[],
    course: Some(Disturbance {
        unit: "rad",
        rms_name: "bank_rms_rad",
        words: "bank, rms",
        size: 0.03,
        length_s: 3.0,
        sign: 0.0,
        ..Disturbance::USUAL
    }),
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| Box::new(RoadBank { angle: setting.course.clone() }),
};

impl Effect for RoadBank {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        on.gravity[1] += GRAVITY * self.angle.at(now).sin();
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, constant};
    use super::*;

    #[test]
    fn gravity_pulls_to_the_left() {
        let on = Bench::driving(20.0).acted(&*constant(&KIND, &[], 0.05), &[]);
        assert!((on.gravity[1] - 9.81 * 0.05f64.sin()).abs() < 1e-12);
        assert_eq!((on.gravity[0], on.external.fy), (0.0, 0.0));
    }
}
