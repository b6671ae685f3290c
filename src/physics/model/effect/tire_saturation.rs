//! The tires' force has a limit.

use super::{Acting, Effect, Kind, Needs, Now, Scale, SearchHints, Setting, Spec, grip};

/// One friction at all wheels, all the time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TireSaturation {
    inverse: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "tire_saturation",
    words: "tire saturation",
    about: "the tires saturate: their force has a limit that the plain model's tires do not have",
    equation: "1/μ = max(1/μ_plain, 1/friction) at all wheels; a linear tire becomes a magic formula (C = \
               1.35, E = −0.3)",
    source: "thesis 4.10",
    place: "the tires' forces",
    to_tell_apart: "turns and brakings up to the limit, by and by, on one surface: the force falls short \
                    of the proportional one more and more, the same everywhere on the road",
    channels: &[],
    parameters: &[Spec {
        name: "friction",
        words: "friction",
        unit: "1",
        scale: Scale::Inverse,
        mean: 0.0,
        std: 1.0,
        bounds: (0.0, 33.0),
        step: 0.3,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints { needs: Needs::LinearTire, every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| Box::new(TireSaturation { inverse: setting.values[0].recip() }),
};

impl Effect for TireSaturation {
    fn act(&self, _now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let limited = grip::inverse(on).map(|wheel| wheel.map(|own| own.max(self.inverse)));
        grip::limit(on, limited);
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    use crate::model::{TireKind, Vehicle};

    fn linear() -> Bench {
        let mut vehicle = Vehicle::thesis();
        vehicle.tire = TireKind::Linear;
        Bench::of(&vehicle, 20.0)
    }

    #[test]
    fn a_linear_tire_keeps_its_stiffness_and_gets_a_limit() {
        let on = linear().acted(&*simple(&KIND, &[0.9]), &[]);
        let force = |angle: f64| on.tire.lateral(&on.contact[1], angle);
        assert!((force(1e-6) / 1e-6 - 11.5).abs() < 1e-6);
        let highest = (0..1000).map(|i| force(f64::from(i) * 1e-3)).fold(0.0, f64::max);
        assert!((highest - 0.9).abs() < 1e-4, "{highest}");
    }

    #[test]
    fn without_a_limit_it_stays_linear_and_a_lower_one_stays() {
        let bench = linear();
        assert_eq!(bench.acted(&*simple(&KIND, &[f64::INFINITY]), &[]), bench.plain());
        let bench = Bench::driving(20.0);
        assert_eq!(bench.acted(&*simple(&KIND, &[1.5]), &[]).contact, bench.plain().contact);
        assert!((bench.acted(&*simple(&KIND, &[0.5]), &[]).contact[2].friction_x - 0.5).abs() < 1e-12);
    }
}
