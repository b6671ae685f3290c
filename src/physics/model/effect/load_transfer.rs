//! Accelerating moves load between the wheels.

use super::load::{self, Sensitivity};
use super::{Acting, Effect, Growth, Kind, Now, Scale, SearchHints, Setting, Spec};

/// The height of the centre of gravity moves load in proportion to the accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LoadTransfer {
    height: f64,
    sensitivity: Sensitivity,
    front_roll_share: f64,
    radius_loss: f64,
}

/// See [`super::KINDS`].
///
/// To first order only the product of the height and of the stiffness that comes with load shows. What tells them
/// apart is the curve of stiffness over load far from the usual one: so their model error is large.
pub static KIND: Kind = Kind {
    name: "load_transfer",
    words: "load transfer",
    about: "accelerating, braking and turning move load between the wheels, and tires grow less stiff than \
            their load",
    equation: "F_z = static ∓ m h a_x/(2 L) ± (front share) m h a_y/t;  C ∝ x^(1 − e − g/2 ln x), x = F_z/static;  \
               r = r_0 − c (F_z − static)",
    source: "Pacejka, Tire and Vehicle Dynamics, ch. 1.3; rigid-body statics",
    place: "the tires' loads and stiffnesses",
    to_tell_apart: "hard turns without braking, hard braking straight ahead, and both at once: load \
                    transfer grows with the square of the lateral acceleration and turns the car in under \
                    braking",
    channels: &[],
    parameters: &[
        Spec {
            name: "cg_height_m",
            words: "height of the centre of gravity",
            unit: "m",
            scale: Scale::Linear,
            mean: 0.0,
            std: 0.5,
            bounds: (0.0, 1.5),
            step: 0.1,
            model_error: 0.2,
            is_main: true,
        },
        Spec {
            name: "load_sensitivity",
            words: "load sensitivity of the tires",
            unit: "1",
            scale: Scale::Linear,
            mean: 0.45,
            std: 0.2,
            bounds: (0.0, 1.0),
            step: 0.05,
            model_error: 0.2,
            is_main: false,
        },
        Spec {
            name: "load_sensitivity_along",
            words: "load sensitivity along the wheel",
            unit: "1",
            scale: Scale::Linear,
            mean: 0.4,
            std: 0.4,
            // With 1 load changes nothing along, which a fit has to be able to say.
            bounds: (0.0, 1.5),
            step: 0.05,
            model_error: 0.2,
            is_main: false,
        },
        Spec {
            name: "front_roll_share",
            words: "front share of the roll moment",
            unit: "1",
            scale: Scale::Linear,
            mean: 0.55,
            std: 0.08,
            bounds: (0.2, 0.9),
            step: 0.02,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
        Spec {
            name: "radius_loss_m_per_n",
            words: "loss of rolling radius per load",
            unit: "m/N",
            scale: Scale::Linear,
            mean: 0.5e-6,
            std: 1e-6,
            bounds: (0.0, 1e-5),
            step: 1e-7,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
        Spec {
            name: "load_sensitivity_growth",
            words: "growth of the load sensitivity with load",
            unit: "1",
            scale: Scale::Linear,
            mean: 0.0,
            std: 0.6,
            bounds: (0.0, 2.0),
            step: 0.1,
            model_error: Spec::MODEL_ERROR,
            is_main: false,
        },
    ],
    course: None,
    // The change of stiffness grows with the square of the moved load.
    search: SearchHints { growth: Growth::Quadratic, every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        let [height, across, along, front_roll_share, radius_loss, growth] =
            std::array::from_fn(|i| setting.values[i]);
        let sensitivity = Sensitivity { along, across, growth };
        Box::new(LoadTransfer { height, sensitivity, front_roll_share, radius_loss })
    },
};

impl Effect for LoadTransfer {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let body = &on.body;
        let lever = body.mass * self.height;
        let rearwards = 0.5 * lever * now.ax / (body.a + body.b);
        let front = self.front_roll_share * lever * now.ay / (2.0 * body.half_track_front);
        let rear = (1.0 - self.front_roll_share) * lever * now.ay / (2.0 * body.half_track_rear);
        let more = [-rearwards - front, -rearwards + front, rearwards - rear, rearwards + rear];
        for (wheel, more) in more.into_iter().enumerate() {
            let static_load = on.load[wheel];
            load::change(on, wheel, 1.0 + more / static_load, self.sensitivity);
            on.radius[wheel] -= self.radius_loss * (on.load[wheel] - static_load);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    fn acted(ax: f64, ay: f64, values: [f64; 6]) -> (Acting, Acting) {
        let mut bench = Bench::driving(20.0);
        (bench.now.ax, bench.now.ay) = (ax, ay);
        (bench.plain(), bench.acted(&*simple(&KIND, &values), &[]))
    }

    #[test]
    fn moments_balance() {
        let (plain, on) = acted(2.0, 4.0, [0.5, 0.45, 0.4, 0.55, 0.0, 0.0]);
        let more: [f64; 4] = std::array::from_fn(|i| on.load[i] - plain.load[i]);
        let moment = 1700.0 * 0.5;
        assert!(more.iter().sum::<f64>().abs() < 1e-9);
        assert!((more[2] + more[3] - moment * 2.0 / 3.0).abs() < 1e-9, "driving loads the rear");
        let front = 0.75 * (more[1] - more[0]);
        let rear = 0.75 * (more[3] - more[2]);
        assert!((front + rear - moment * 4.0).abs() < 1e-9, "a left turn loads the right");
        assert!((front / (front + rear) - 0.55).abs() < 1e-12);
    }

    #[test]
    fn an_axle_with_unequal_loads_is_softer() {
        let axle = |on: &Acting| (0..2).map(|i| on.load[i] * on.contact[i].stiffness_y).sum::<f64>();
        let (plain, on) = acted(0.0, 6.0, [0.5, 0.45, 0.4, 0.55, 0.0, 0.0]);
        assert!(axle(&on) < 0.99 * axle(&plain));
        let share = on.load[1] / plain.load[1];
        let stiffer = on.load[1] * on.contact[1].stiffness_y / (plain.load[1] * 11.5);
        assert!((stiffer - share.powf(0.55)).abs() < 1e-12);
        let (plain, on) = acted(0.0, 6.0, [0.5, 0.0, 0.0, 0.55, 0.0, 0.0]);
        assert!((axle(&on) - axle(&plain)).abs() < 1e-6, "in proportion to the load nothing is lost");
    }

    #[test]
    fn a_sensitivity_that_grows_is_of_second_order() {
        let (plain, power) = acted(0.0, 6.0, [0.5, 0.45, 0.4, 0.55, 0.0, 0.0]);
        let (_, growing) = acted(0.0, 6.0, [0.5, 0.45, 0.4, 0.55, 0.0, 0.6]);
        for i in 0..4 {
            let further = (growing.load[i] / plain.load[i]).ln();
            let ratio = growing.contact[i].stiffness_y / power.contact[i].stiffness_y;
            assert!((ratio - (-0.3 * further * further).exp()).abs() < 1e-12);
        }
    }

    #[test]
    fn wheels_stay_on_the_ground() {
        let (plain, on) = acted(0.0, 30.0, [0.5, 0.45, 0.4, 0.55, 0.0, 0.0]);
        assert!((on.load[0] - 0.05 * plain.load[0]).abs() < 1e-9);
    }
}
