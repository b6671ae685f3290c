//! Force along a tire takes force across away.

use super::{Acting, Effect, Kind, Now, Scale, SearchHints, Setting, Spec};

/// How much of the friction ellipse holds below the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CombinedSlip {
    factor: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "combined_slip",
    words: "combined slip",
    about: "driving and braking take lateral force away, long before the limit",
    equation: "F_y = F_y,pure √(1 − (e F_x/(μ F_z))²);  μ = 1 for linear tires",
    source: "friction ellipse (thesis 4.15)",
    place: "the tires' lateral forces",
    to_tell_apart: "the same curve coasting, with drive and with braking: the front of a front-wheel drive \
                    loses lateral force under drive, load transfer alone gives less",
    channels: &[],
    parameters: &[Spec {
        name: "ellipse_factor",
        words: "factor of the ellipse",
        unit: "1",
        scale: Scale::Linear,
        mean: 0.0,
        std: 0.5,
        bounds: (0.0, 1.5),
        step: 0.1,
        model_error: Spec::MODEL_ERROR,
        is_main: true,
    }],
    course: None,
    search: SearchHints { every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| Box::new(CombinedSlip { factor: setting.values[0] }),
};

impl Effect for CombinedSlip {
    fn act(&self, _now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        on.ellipse_factor += self.factor;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;

    #[test]
    fn it_asks_for_the_ellipse() {
        let bench = Bench::driving(20.0);
        assert_eq!(bench.plain().ellipse_factor, 0.0);
        assert_eq!(bench.acted(&*simple(&KIND, &[0.7]), &[]).ellipse_factor, 0.7);
    }
}
