//! The front wheels toe in.

use super::{Acting, Effect, Kind, Now, Scale, Setting, Spec};

/// Each front wheel is turned inwards.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WheelAlignment {
    toe: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "wheel_alignment",
    about: "the front wheels are not parallel: each is turned inwards (or outwards)",
    equation: "δ_left = δ − toe, δ_right = δ + toe, forces turned with the wheels",
    source: "suspension geometry",
    place: "front tires' slip angle",
    to_tell_apart: "hard turns to both sides and a long coast-down: unequally loaded tires make toe-in \
                    felt as a steering that depends on the square of the lateral acceleration, and it \
                    drags",
    channels: &[],
    parameters: &[Spec {
        name: "toe_rad",
        unit: "rad",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.003,
        bounds: (-0.05, 0.05),
        step: 0.0005,
        is_main: true,
    }],
    course: None,
    make: |setting: &Setting<'_>| Box::new(WheelAlignment { toe: setting.values[0] }),
};

impl Effect for WheelAlignment {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let (steer, angle) = (on.steer(), on.front_slip_angle(&now.velocity));
        let (sin, cos) = steer.sin_cos();
        on.toe[0] -= self.toe;
        on.toe[1] += self.toe;
        // The plain equations leave the lateral forces as if the wheels were parallel: what turning
        // them gives along the wheels. (Turning the forces along the wheels is left out: it cancels
        // between equal ones.)
        let along = [(0, -self.toe), (1, self.toe)]
            .map(|(i, toe)| -toe * on.load[i] * on.tire.lateral(&on.contact[i], angle + on.toe[i]));
        let sum = along[0] + along[1];
        on.external.fx += sum * cos;
        on.external.fy += sum * sin;
        on.external.moment += on.body.a * sum * sin + on.body.half_track_front * (along[1] - along[0]) * cos;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn straight_ahead_toe_in_drags_and_does_not_steer() {
        let on = Bench::driving(20.0).acted(&*simple(&KIND, &[0.003]), &[]);
        assert_eq!(on.toe, [-0.003, 0.003, 0.0, 0.0]);
        let stiffness = 11.5 * 1700.0 * 9.81 / 4.0;
        assert!((on.external.fx + 2.0 * stiffness * 0.003 * 0.003).abs() < 1e-9);
        assert!(on.external.moment.abs() < 1e-9 && on.external.fy.abs() < 1e-9);
    }

    #[test]
    fn in_a_left_turn_the_turned_forces_hold_it_back() {
        let mut bench = Bench::driving(20.0);
        bench.now.velocity.yaw_rate = -0.2;
        let on = bench.acted(&*simple(&KIND, &[0.003]), &[]);
        let angle = (0.3f64 / 20.0).atan();
        let force = 2.0 * 11.5 * 1700.0 * 9.81 / 4.0 * angle;
        assert!((on.external.moment + 0.75 * 0.003 * force).abs() < 1e-6, "{:?}", on.external);
    }
}
