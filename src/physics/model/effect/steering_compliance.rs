//! The front tires turn the steering back.

use super::{Acting, Effect, Kind, Now, Scale, SearchHints, Setting, Spec};
use crate::model::tire::Shape;

/// Aligning moment = front lateral force × pneumatic trail; it turns the wheels back against the
/// elasticity of the steering.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SteeringCompliance {
    compliance: f64,
}

/// Pneumatic trail, m: a usual one, as far as the compliance is told in rad per aligning moment.
pub const TRAIL_M: f64 = 0.05;

/// Newton steps at most from the force of a moment ago to the one in balance with the angle it causes …
const STEPS: usize = 3;

/// … and the last step is smaller, N: the next one would be so much of a force, squared: hundredths of a newton. Numerical.
const LAST_STEP_N: f64 = 10.0;

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "steering_compliance",
    words: "steering compliance",
    about: "the steering is elastic: the front tires' aligning moment turns the wheels back",
    equation: "δ = δ_sw / i − c t F_y,front,  t = 0.05 m",
    source: "Pacejka, Tire and Vehicle Dynamics, ch. 1.3 (steering compliance)",
    place: "front tires' slip angle",
    to_tell_apart: "as it is a softer front axle while tires are linear: curves near the limit, where the \
                    tires saturate and the steering does not, or curves on a slippery surface",
    channels: &[],
    parameters: &[Spec {
        name: "compliance_rad_per_nm",
        words: "steer angle per aligning moment",
        unit: "rad/(N m)",
        scale: Scale::Linear,
        mean: 0.0,
        std: 7e-05,
        bounds: (0.0, 0.001),
        step: 1e-05,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints { every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| Box::new(SteeringCompliance { compliance: setting.values[0] }),
};

impl SteeringCompliance {
    /// The front axle's lateral force that the angle it causes leaves, N. Feeding back the force of a
    /// moment ago alone would oscillate where the steering is softer than the tires.
    fn balance(&self, now: &Now<'_>, on: &Acting) -> f64 {
        let back = self.compliance * TRAIL_M;
        let angle = on.front_slip_angle(&now.velocity);
        let mut force = now.front_force;
        for _ in 0..STEPS {
            let (mut given, mut slope) = (0.0, 0.0);
            for i in 0..2 {
                let (contact, angle) = (&on.contact[i], angle + on.toe[i] - back * force);
                let [share, by_angle] =
                    on.tire.force_and_slope(contact.stiffness_y, contact.friction_y, angle);
                given += on.load[i] * share;
                slope += on.load[i] * by_angle;
            }
            let step = (force - given) / (1.0 + back * slope.max(0.0));
            force -= step;
            if step.abs() < LAST_STEP_N {
                break;
            }
        }
        force
    }
}

impl Effect for SteeringCompliance {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        if self.compliance == 0.0 {
            return;
        }
        let force = if now.is_force_measured { now.front_force } else { self.balance(now, on) };
        let back = self.compliance * TRAIL_M * force;
        on.toe[0] -= back;
        on.toe[1] -= back;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    /// The front axle's force with what the effect did.
    fn force(bench: &Bench, on: &Acting) -> f64 {
        let angle = on.front_slip_angle(&bench.now.velocity);
        (0..2).map(|i| on.load[i] * on.tire.lateral(&on.contact[i], angle + on.toe[i])).sum()
    }

    #[test]
    fn the_axle_is_softer_by_the_elasticity_in_series() {
        let mut bench = Bench::driving(20.0);
        bench.now.steering_wheel = 0.02;
        let stiffness = 11.5 * 1700.0 * 9.81 / 2.0;
        let rigid = force(&bench, &bench.plain());
        assert!((rigid - 0.02 * stiffness).abs() < 1.0);
        for compliance in [1e-5, 1e-4, 1e-3] {
            let on = bench.acted(&*simple(&KIND, &[compliance]), &[]);
            let expected = rigid / (1.0 + compliance * TRAIL_M * stiffness);
            assert!((force(&bench, &on) - expected).abs() < 1e-6 * rigid, "{compliance}");
            assert!(on.toe[0] < 0.0 && on.toe[0] == on.toe[1] && on.toe[2] == 0.0);
        }
    }

    #[test]
    fn at_the_limit_the_moment_is_that_of_the_limit() {
        let mut bench = Bench::driving(20.0);
        bench.now.steering_wheel = 0.5;
        let on = bench.acted(&*simple(&KIND, &[1e-4]), &[]);
        let limit = 1700.0 * 9.81 / 2.0;
        assert!((on.toe[0] + 1e-4 * TRAIL_M * limit).abs() < 1e-9);
    }
}
