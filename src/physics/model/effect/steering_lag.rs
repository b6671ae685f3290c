//! The road wheels follow the steering wheel late.

use super::{Acting, Effect, Felt, Kind, Now, Scale, SearchHints, Setting, Spec, lag};

/// A first-order lag between steering wheel and road wheels; its state is what has arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SteeringLag {
    time_constant: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "steering_lag",
    words: "steering lag",
    about: "the road wheels follow the steering wheel late (elastic shaft, servo, play of the gear)",
    equation: "T δ̇_s = δ_sw − δ_s,  δ = δ_s / i",
    source: "first-order lag",
    place: "the steering",
    to_tell_apart: "quick steering (steps, sine sweep to 2 Hz) at two very different speeds: this lag in \
                    seconds is the same at both, a relaxation length gives one over the speed, and a late \
                    yaw rate sensor leaves the lateral acceleration alone",
    channels: &[],
    parameters: &[Spec {
        name: "time_constant_s",
        words: "time constant",
        unit: "s",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.06,
        bounds: (0.0, 0.5),
        step: 0.01,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints::USUAL,
    make: |setting: &Setting<'_>| Box::new(SteeringLag { time_constant: setting.values[0] }),
};

impl Effect for SteeringLag {
    fn states(&self) -> usize {
        1
    }

    fn state_names(&self) -> &'static [&'static str] {
        &["angle"]
    }

    fn begin(&self, now: &Now<'_>, states: &mut [f64]) {
        states.fill(now.steering_wheel);
    }

    fn act(&self, _now: &Now<'_>, states: &[f64], on: &mut Acting) {
        let Some(state) = states.first() else { return };
        on.steering_wheel = lag::output(on.steering_wheel, *state, self.time_constant);
    }

    fn rates(&self, now: &Now<'_>, _felt: &Felt, states: &[f64], rates: &mut [f64]) {
        for (rate, state) in rates.iter_mut().zip(states) {
            *rate = lag::rate(now.steering_wheel, *state, self.time_constant);
        }
    }

    fn lag_rate(&self, _vx: f64) -> Option<f64> {
        Some(lag::fastest_rate(self.time_constant))
    }

    fn follows_steering(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn a_step_arrives_by_63_percent_after_the_time_constant() {
        let mut bench = Bench::driving(20.0);
        let effect = simple(&KIND, &[0.06]);
        let mut states = bench.begun(&*effect);
        bench.now.steering_wheel = 1.0;
        assert_eq!(bench.acted(&*effect, &states).steering_wheel, 0.0);
        for _ in 0..600 {
            states[0] += 1e-4 * bench.rates(&*effect, &Felt::default(), &states)[0];
        }
        let arrived = bench.acted(&*effect, &states).steering_wheel;
        assert!((arrived - (1.0 - (-1.0f64).exp())).abs() < 1e-3, "{arrived}");
    }

    #[test]
    fn without_a_time_constant_the_wheel_is_followed_at_once() {
        let mut bench = Bench::driving(20.0);
        bench.now.steering_wheel = 1.0;
        assert_eq!(bench.acted(&*simple(&KIND, &[0.0]), &[0.3]).steering_wheel, 1.0);
    }
}
