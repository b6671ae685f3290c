//! Lateral force needs some way to build up.

use super::{Effect, Felt, Kind, Now, Scale, SearchHints, Setting, Spec, lag};
use crate::model::body::Steer;
use crate::model::wheel;

/// The slip angle that each axle's tires answer to follows that of the motion over a length of road.
/// States: of front and rear axle, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RelaxationLength {
    length: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "relaxation_length",
    words: "tire relaxation length",
    about: "the tires need some way, about a wheel radius, to build up lateral force",
    equation: "σ α̇' = |v_x| (α − α'),  F_y = F_y(α')",
    source: "Pacejka, Tire and Vehicle Dynamics, ch. 5.4",
    place: "the tires' slip angles",
    to_tell_apart: "quick steering (sine sweep to 3 Hz) at low and at high speed: this lag is a length \
                    over the speed, a lag of the steering or of a sensor is the same time at every speed",
    channels: &[],
    parameters: &[Spec {
        name: "length_m",
        words: "relaxation length",
        unit: "m",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.4,
        bounds: (0.0, 2.0),
        step: 0.05,
        // Lengths that were put into real drives come out 11 to 16 % short (`concealed_in_real_drives`).
        model_error: 0.12,
        is_main: true,
    }],
    course: None,
    search: SearchHints { every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| Box::new(RelaxationLength { length: setting.values[0] }),
};

impl RelaxationLength {
    /// The lag now, s.
    fn time(&self, vx: f64) -> f64 {
        self.length / wheel::reference_speed(vx)
    }
}

/// Mean of each axle.
fn means(angles: &[f64; 4]) -> [f64; 2] {
    [0.5 * (angles[0] + angles[1]), 0.5 * (angles[2] + angles[3])]
}

impl Effect for RelaxationLength {
    fn states(&self) -> usize {
        2
    }

    fn state_names(&self) -> &'static [&'static str] {
        &["front", "rear"]
    }

    fn begin(&self, now: &Now<'_>, states: &mut [f64]) {
        let steer = Steer::new(now.steering_wheel / now.steering_ratio);
        let front = now.body.front_axle_velocity(&now.velocity, steer);
        let rear = now.body.rear_axle_velocity(&now.velocity);
        for (state, [along, across]) in states.iter_mut().zip([front, rear]) {
            *state = wheel::slip_angle(along, across);
        }
    }

    fn slip_angles(&self, now: &Now<'_>, states: &[f64], angles: &mut [f64; 4]) {
        let time = self.time(now.velocity.vx);
        for (axle, (mean, state)) in means(angles).into_iter().zip(states).enumerate() {
            let more = lag::output(mean, *state, time) - mean;
            for angle in &mut angles[2 * axle..2 * axle + 2] {
                *angle += more;
            }
        }
    }

    fn rates(&self, now: &Now<'_>, felt: &Felt, states: &[f64], rates: &mut [f64]) {
        let time = self.time(now.velocity.vx);
        for ((rate, state), mean) in rates.iter_mut().zip(states).zip(means(&felt.slip_angle)) {
            *rate = lag::rate(mean, *state, time);
        }
    }

    fn lag_rate(&self, vx: f64) -> Option<f64> {
        Some(lag::fastest_rate(self.time(vx)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn a_step_is_followed_over_the_length_whatever_the_speed() {
        for speed in [5.0, 20.0] {
            let bench = Bench::driving(speed);
            let effect = simple(&KIND, &[0.5]);
            let mut states = bench.begun(&*effect);
            assert_eq!(states, [0.0, 0.0]);
            let felt = Felt { slip_angle: [0.02, 0.02, 0.01, 0.01], ..Felt::default() };
            let h = 1e-4 / speed;
            for _ in 0..5000 {
                let rates = bench.rates(&*effect, &felt, &states);
                states.iter_mut().zip(rates).for_each(|(state, rate)| *state += h * rate);
            }
            let mut angles = felt.slip_angle;
            effect.slip_angles(&bench.now, &states, &mut angles);
            let arrived = 1.0 - (-1.0f64).exp();
            assert!((angles[0] / 0.02 - arrived).abs() < 1e-3, "{speed}: {angles:?}");
            assert!((angles[3] / 0.01 - arrived).abs() < 1e-3, "{speed}: {angles:?}");
        }
    }

    #[test]
    fn toe_is_not_lagged_and_no_length_changes_nothing() {
        let bench = Bench::driving(20.0);
        let mut angles = [0.03, 0.01, 0.0, 0.0];
        simple(&KIND, &[0.5]).slip_angles(&bench.now, &[0.0, 0.0], &mut angles);
        assert!((angles[0] - 0.01).abs() < 1e-12 && (angles[1] + 0.01).abs() < 1e-12);
        let mut angles = [0.03, 0.01, 0.02, 0.02];
        simple(&KIND, &[0.0]).slip_angles(&bench.now, &[0.5, 0.5], &mut angles);
        assert_eq!(angles, [0.03, 0.01, 0.02, 0.02]);
    }

    #[test]
    fn it_begins_where_the_car_is() {
        let mut bench = Bench::driving(20.0);
        bench.now.steering_wheel = 0.1;
        bench.now.velocity.vy = -1.0;
        bench.now.velocity.yaw_rate = 0.4;
        let states = bench.begun(&*simple(&KIND, &[0.5]));
        assert!((states[0] - (0.1 - (-0.4f64 / 20.0).atan())).abs() < 1e-12);
        assert!((states[1] + (-1.6f64 / 20.0).atan()).abs() < 1e-12);
    }
}
