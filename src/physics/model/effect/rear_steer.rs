//! The rear wheels are steered, too: against the front ones at low speed, with them at high speed.
//!
//! In a steady turn without sideslip at the centre of gravity the single-track model asks for
//! δ_r/δ_f = −(b − m a v²/(L C_r)) / (a + m b v²/(L C_f)), the first law of four-wheel steering (Furukawa et al. 1989).
//! Of a car whose axles are alike (a = b, C_f = C_r) that is −(1 − v²/v0²)/(1 + v²/v0²) with
//! v0² = L C/m of an axle's cornering stiffness C. Cars take a share of it.

use super::{Acting, Effect, Growth, Kind, Now, Scale, SearchHints, Setting, Spec};

/// The rear axle follows the front one by a ratio that depends on the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RearSteer {
    low_speed_ratio: f64,
    crossover_speed: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "rear_steer",
    words: "rear-wheel steering",
    about: "the rear wheels are steered with the front ones: against them at low speed, with them at high speed",
    equation: "δ_r = −k δ_f (1 − v²/v0²) / (1 + v²/v0²)",
    source: "Furukawa et al. 1989, Vehicle System Dynamics 18 (steering without sideslip), a share k of it",
    place: "rear tires' slip angle",
    to_tell_apart: "the same bends at 8 m/s and less and at 25 m/s and more: at one speed it is another \
                    steering ratio beside another rear axle, and only it turns from the one into the other",
    channels: &[],
    parameters: &[
        // 5° of the rear wheels beside 30 to 35° of the front ones were usual in 1987 (Honda, Mazda) and are the
        // deviation. The bound is a little more than the 12 to 15° of a pickup truck beside 40° (GM 2002).
        Spec {
            name: "low_speed_ratio",
            words: "rear angle per front angle at low speed",
            unit: "1",
            scale: Scale::Linear,
            mean: 0.0,
            std: 0.15,
            bounds: (0.0, 0.4),
            step: 0.02,
            model_error: Spec::MODEL_ERROR,
            is_main: true,
        },
        // Makers say 60 km/h (BMW 2010), or between 50 and 80 (Porsche 2013). 40 and 90 are the bounds: one of them
        // before, 35 (Mazda 1987), is left out, for wheels that are with the front ones at almost every speed are also
        // what forces and the lean do to an ordinary rear axle.
        Spec {
            name: "crossover_speed_mps",
            words: "speed at which the rear wheels stay straight",
            unit: "m/s",
            scale: Scale::Linear,
            mean: 16.0,
            std: 2.0,
            bounds: (11.0, 25.0),
            step: 0.5,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
    ],
    course: None,
    search: SearchHints { growth: Growth::Proportional, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        Box::new(RearSteer { low_speed_ratio: setting.values[0], crossover_speed: setting.values[1] })
    },
};

impl Effect for RearSteer {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let square = (now.velocity.vx / self.crossover_speed).powi(2);
        let rear = -self.low_speed_ratio * on.steer() * (1.0 - square) / (1.0 + square);
        on.toe[2] += rear;
        on.toe[3] += rear;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn the_rear_turns_against_the_front_then_not_at_all_then_with_it() {
        let rear = |speed: f64| {
            let mut bench = Bench::driving(speed);
            (bench.now.steering_ratio, bench.now.steering_wheel) = (15.0, 1.5);
            let toe = bench.acted(&*simple(&KIND, &[0.2, 16.0]), &[]).toe;
            assert_eq!((toe[0], toe[1], toe[3]), (0.0, 0.0, toe[2]));
            toe[2]
        };
        // Of 0.1 rad at the front, to the left.
        assert!((rear(0.0) + 0.02).abs() < 1e-12);
        assert!((rear(8.0) + 0.02 * 0.6).abs() < 1e-12);
        assert!(rear(16.0).abs() < 1e-12);
        assert!((rear(32.0) - 0.02 * 0.6).abs() < 1e-12);
    }

    /// A car whose axles are alike, at the ratio and speed of the law, turns without sideslip.
    #[test]
    fn with_the_whole_ratio_a_steady_turn_has_no_sideslip() {
        let (mass, length, stiffness) = (1500.0, 2.7, 90_000.0);
        let crossover = f64::sqrt(length * stiffness / mass);
        let (speed, front) = (25.0, 0.02);
        let mut bench = Bench::driving(speed);
        (bench.now.steering_ratio, bench.now.steering_wheel) = (1.0, front);
        let rear = bench.acted(&*simple(&KIND, &[1.0, crossover]), &[]).toe[2];
        let yaw_rate = speed * (front - rear) / length;
        let half_of_force = 0.5 * mass * speed * yaw_rate;
        let (at_front, at_rear) =
            (front - 0.5 * length * yaw_rate / speed, rear + 0.5 * length * yaw_rate / speed);
        assert!((stiffness * at_front / half_of_force - 1.0).abs() < 1e-9);
        assert!((stiffness * at_rear / half_of_force - 1.0).abs() < 1e-9);
    }
}
