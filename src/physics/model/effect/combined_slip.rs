//! Force along a tire takes force across away, and force across takes force along.

use super::{Acting, Effect, Kind, Now, SearchHints, Setting, Spec};

/// How much of the friction ellipse holds below the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CombinedSlip {
    across: f64,
    along: f64,
}

/// See [`super::KINDS`].
pub static KIND: Kind = Kind {
    name: "combined_slip",
    words: "combined slip",
    about: "driving and braking take lateral force away, long before the limit; a slip angle takes longitudinal force",
    equation: "F_y = F_y,pure √(1 − (e F_x/(μ F_z))²),  F_x = F_x,pure √(1 − (a F_y,pure/(μ F_z))²);  μ = 1 for linear tires",
    source: "friction ellipse (thesis 4.15); each force's weight by the other slip (Pacejka, Tire and Vehicle Dynamics, 4.3.2)",
    place: "the tires' forces",
    to_tell_apart: "the same curve coasting, with drive and with braking: the front of a front-wheel drive \
                    loses lateral force under drive, load transfer alone gives less",
    channels: &[],
    parameters: &[
        factor("ellipse_factor", "factor of the ellipse"),
        factor("ellipse_factor_along", "factor of the ellipse along"),
    ],
    course: None,
    search: SearchHints { every_car_has: true, ..SearchHints::USUAL },
    make: |setting: &Setting<'_>| {
        Box::new(CombinedSlip { across: setting.values[0], along: setting.values[1] })
    },
};

const fn factor(name: &'static str, words: &'static str) -> Spec {
    Spec { std: 0.5, bounds: (0.0, 1.5), step: 0.1, ..Spec::ratio(name, words) }
}

impl Effect for CombinedSlip {
    fn act(&self, _now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        on.ellipse.across += self.across;
        on.ellipse.along += self.along;
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{Bench, simple};
    use super::*;
    use crate::model::tire::ellipse::EllipseFactors;

    #[test]
    fn it_asks_for_the_ellipse() {
        let bench = Bench::driving(20.0);
        assert_eq!(bench.plain().ellipse, EllipseFactors::default());
        let acted = bench.acted(&*simple(&KIND, &[0.7, 0.4]), &[]);
        assert_eq!(acted.ellipse, EllipseFactors { across: 0.7, along: 0.4 });
    }
}
