//! The air presses the car onto the road, or lifts it.

use super::load::{self, Sensitivity};
use super::{Acting, Effect, Growth, Kind, Now, Scale, SearchHints, Setting, Spec};

/// Density of the air at 15 °C and sea level, kg/m³ (ISO 2533, standard atmosphere).
const AIR_DENSITY: f64 = 1.225;

/// A vertical force with the square of the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Downforce {
    area: f64,
    rearwards: f64,
    sensitivity: Sensitivity,
}

/// See [`super::KINDS`].
///
/// To first order only the product of the area and of the stiffness that comes with load shows.
pub static KIND: Kind = Kind {
    name: "downforce",
    words: "downforce",
    about: "the air presses the car onto the road, or lifts it, and tires grow less stiff than their load",
    equation: "F_z = static + (front: b/L − s, rear: a/L + s) ρ/2 A v²;  C ∝ F_z^(1 − e)",
    source: "Katz, Race Car Aerodynamics; Hucho, Aerodynamics of Road Vehicles",
    place: "the tires' loads and stiffnesses",
    to_tell_apart: "the same curve, or quick steering of the same size, at a low and at a very high speed: \
                    with the speed grip and stiffness grow together",
    channels: &[],
    parameters: &[
        // Passenger cars of 2.2 m² have lift coefficients of −0.1 to 0.3 (Hucho); race cars have 2 to 4 m² downwards (Katz).
        Spec {
            name: "downforce_area_m2",
            words: "lift coefficient times area, downwards",
            unit: "m^2",
            scale: Scale::Linear,
            mean: 0.0,
            std: 0.5,
            bounds: (-2.0, 10.0),
            step: 0.1,
            // As that of what load does to stiffness.
            model_error: 0.2,
            is_main: true,
        },
        // A car that keeps its balance at every speed is pressed as its weight is shared.
        Spec {
            name: "share_behind_static",
            words: "share of it that acts further back than the weight",
            unit: "1",
            scale: Scale::Linear,
            mean: 0.0,
            std: 0.05,
            bounds: (-0.3, 0.3),
            step: 0.01,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
        Spec { mean: 0.45, std: 0.2, step: 0.05, ..load::SENSITIVITY },
    ],
    course: None,
    search: SearchHints { growth: Growth::Proportional, every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        let [area, rearwards, sensitivity] = std::array::from_fn(|i| setting.values[i]);
        Box::new(Downforce { area, rearwards, sensitivity: Sensitivity::power(sensitivity) })
    },
};

impl Effect for Downforce {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let force = 0.5 * AIR_DENSITY * self.area * now.velocity.vx.powi(2);
        let front = on.body.b / (on.body.a + on.body.b) - self.rearwards;
        for wheel in 0..4 {
            let share = if wheel < 2 { front } else { 1.0 - front };
            load::change(on, wheel, 1.0 + 0.5 * share * force / on.load[wheel], self.sensitivity);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn loads_and_stiffness_grow_with_the_square_of_the_speed() {
        let at = |speed: f64| {
            let bench = Bench::driving(speed);
            (bench.plain(), bench.acted(&*simple(&KIND, &[3.0, 0.1, 0.4]), &[]))
        };
        for speed in [20.0, 40.0] {
            let (plain, on) = at(speed);
            let more = |wheels: [usize; 2]| wheels.map(|i| on.load[i] - plain.load[i]).iter().sum::<f64>();
            let force = 0.6125 * 3.0 * speed * speed;
            let front = (plain.load[0] + plain.load[1]) / plain.load.iter().sum::<f64>() - 0.1;
            assert!((more([0, 1]) - front * force).abs() < 1e-9);
            assert!((more([2, 3]) - (1.0 - front) * force).abs() < 1e-9);
            let force = |on: &Acting| on.load[3] * on.contact[3].stiffness_y;
            let share = on.load[3] / plain.load[3];
            assert!((force(&on) / force(&plain) - share.powf(0.6)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_car_that_is_lifted_keeps_its_wheels_on_the_road() {
        let bench = Bench::driving(100.0);
        let on = bench.acted(&*simple(&KIND, &[-2.0, 0.0, 0.4]), &[]);
        assert!(on.load.iter().all(|load| *load > 0.0));
    }
}
