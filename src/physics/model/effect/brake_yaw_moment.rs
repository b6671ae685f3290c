//! Something turns the car: ESP, torque vectoring.

use super::{Acting, Course, Disturbance, Effect, Kind, Now, Scale, SearchHints, Setting, Spec};

/// A course of the moment, N m, to the left. The wheels of that side are braked for it; where torque is
/// vectored, half of it drives the other side.
#[derive(Clone, Debug, PartialEq)]
struct BrakeYawMoment {
    moment: Course,
    front_share: f64,
    vectoring: f64,
}

/// Hardly a moment, N m: ESP does not brake single wheels for it.
const HARDLY: f64 = 40.0;

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "brake_yaw_moment",
    words: "yaw moment of single brakes or torque vectoring",
    about: "something turns the car for a moment: single brakes (ESP) or torque vectoring",
    equation: "J_z ṙ = … + (t/2) F_x of the braked (and driven) wheels",
    source: "rigid-body dynamics",
    place: "yaw moment balance",
    to_tell_apart: "the manoeuvre that made ESP act, with ESP switched off; or single brake pressures on \
                    the bus",
    channels: &[],
    parameters: &[
        Spec {
            name: "front_share",
            words: "front share",
            unit: "1",
            scale: Scale::Linear,
            mean: 0.8,
            std: 0.2,
            bounds: (0.0, 1.0),
            step: 0.05,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
        Spec {
            name: "vectoring",
            words: "vectoring",
            unit: "1",
            scale: Scale::Linear,
            mean: 0.1,
            std: 0.3,
            bounds: (0.0, 1.0),
            step: 0.05,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
    ],
    course: Some(Disturbance {
        unit: "N m",
        rms_name: "moment_peak_nm",
        words: "peak moment",
        size: 300.0,
        length_s: 0.5,
        sign: 0.0,
        is_told_by_its_peak: true,
        ..Disturbance::USUAL
    }),
    search: SearchHints { has_whole_shares: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        let [front_share, vectoring] = std::array::from_fn(|i| setting.values[i]);
        Box::new(BrakeYawMoment { moment: setting.course.clone(), front_share, vectoring })
    },
};

impl Effect for BrakeYawMoment {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let moment = self.moment.at(now);
        let (braked, driven) = if moment > 0.0 { (0, 1) } else { (1, 0) };
        // Where there is hardly any moment, nobody brakes for it: without a kink at zero, where a filter that
        // looks for the moment would take its own noise for braking.
        let braking = (1.0 - self.vectoring) * moment * moment / (moment * moment + HARDLY * HARDLY);
        let (most, least) = (0.5 + 0.5 * braking, 0.5 * braking - 0.5);
        let axles = [
            (0, self.front_share, on.body.half_track_front),
            (2, 1.0 - self.front_share, on.body.half_track_rear),
        ];
        for (first, share, arm) in axles {
            let force = share * moment.abs() / arm;
            on.brake[first + braked] += most * force;
            on.brake[first + driven] += least * force;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, constant};
    use super::*;

    #[test]
    fn the_side_it_turns_to_is_braked() {
        let on = Bench::driving(20.0).acted(&*constant(&KIND, &[1.0, 0.0], 500.0), &[]);
        let arm = on.body.half_track_front;
        assert!((arm * (on.brake[0] - on.brake[1]) - 500.0).abs() < 1e-9, "{:?}", on.brake);
        assert!(on.brake[1].abs() < 0.01 * on.brake[0] && on.brake[2..] == [0.0; 2], "{:?}", on.brake);
        let on = Bench::driving(20.0).acted(&*constant(&KIND, &[0.5, 1.0], -500.0), &[]);
        assert!((on.brake.iter().sum::<f64>()).abs() < 1e-9, "vectoring does not brake the car");
        let moment = on.body.half_track_front * (on.brake[0] - on.brake[1])
            + on.body.half_track_rear * (on.brake[2] - on.brake[3]);
        assert!((moment + 500.0).abs() < 1e-9);
        // Around zero nothing jumps.
        let drag = |moment| {
            let on = Bench::driving(20.0).acted(&*constant(&KIND, &[1.0, 0.0], moment), &[]);
            on.brake.iter().sum::<f64>()
        };
        assert!(drag(0.0) == 0.0 && drag(1.0) < 0.01 && drag(-1.0) < 0.01 && drag(200.0) > 200.0);
    }
}
