//! The road of a scenario: what each wheel touches at a time.

use crate::Wheel;
use crate::model::scenario::Stretch;
use crate::model::tire::Contact;

/// Surfaces one after the other.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// What was before the first stretch.
    before: [Contact; 4],
    stretches: Vec<Part>,
    /// The stretch of the last call; time goes forward.
    current: Option<usize>,
}

#[derive(Clone, Copy, Debug)]
struct Part {
    from_s: f64,
    transition_s: f64,
    contact: [Contact; 4],
}

impl Surface {
    pub(super) fn new(nominal: &[Contact; 4], road: &[Stretch]) -> Self {
        let contact = |stretch: &Stretch, wheel: Wheel| {
            let own = nominal[wheel as usize];
            let side = stretch.side(wheel.is_left());
            let stiffness = |absolute: Option<f64>, factor: Option<f64>, own: f64| {
                absolute.unwrap_or(own * factor.unwrap_or(1.0))
            };
            let tire_and_road = |road: f64| Contact::in_series(own.stiffness_x, road);
            let absolute = side.slope.or(side.surface_stiffness.map(tire_and_road));
            Contact {
                stiffness_x: stiffness(absolute, side.longitudinal_factor, own.stiffness_x),
                stiffness_y: stiffness(side.cornering, side.lateral_factor, own.stiffness_y),
                friction_x: side.friction.unwrap_or(own.friction_x),
                friction_y: side.friction.unwrap_or(own.friction_y),
            }
        };
        let part = |stretch: &Stretch| Part {
            from_s: stretch.from_s,
            transition_s: stretch.transition_s,
            contact: Wheel::ALL.map(|wheel| contact(stretch, wheel)),
        };
        Self { before: *nominal, stretches: road.iter().map(part).collect(), current: None }
    }

    /// Contact of each wheel at `t`, which must not fall from call to call.
    pub(super) fn at(&mut self, t: f64) -> [Contact; 4] {
        let mut next = self.current.map_or(0, |i| i + 1);
        while self.stretches.get(next).is_some_and(|part| part.from_s <= t) {
            self.current = Some(next);
            next += 1;
        }
        let Some(i) = self.current else { return self.before };
        let part = &self.stretches[i];
        if t >= part.from_s + part.transition_s {
            return part.contact;
        }
        let from = if i == 0 { &self.before } else { &self.stretches[i - 1].contact };
        let share = (t - part.from_s) / part.transition_s;
        std::array::from_fn(|w| mix(&from[w], &part.contact[w], share))
    }
}

fn mix(from: &Contact, to: &Contact, share: f64) -> Contact {
    let mix = |from: f64, to: f64| from + share * (to - from);
    Contact {
        stiffness_x: mix(from.stiffness_x, to.stiffness_x),
        stiffness_y: mix(from.stiffness_y, to.stiffness_y),
        friction_x: mix(from.friction_x, to.friction_x),
        friction_y: mix(from.friction_y, to.friction_y),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Plant, Vehicle};

    #[test]
    fn surfaces_follow_each_other_with_transitions() {
        let road = [
            Stretch { from_s: 10.0, transition_s: 2.0, friction: Some(0.2), ..Stretch::default() },
            Stretch { from_s: 20.0, slope: Some(80.0), ..Stretch::default() },
        ];
        let mut surface = Surface::new(&Plant::new(&Vehicle::thesis()).nominal.contact, &road);
        let friction = [5.0, 11.0, 13.0, 25.0].map(|t| surface.at(t)[0].friction_x);
        assert_eq!(friction, [1.0, 0.6, 0.2, 1.0]);
        assert_eq!(surface.at(25.0)[3].stiffness_x, 80.0);
        assert_eq!(surface.at(25.0)[3].stiffness_y, 11.5);
    }

    #[test]
    fn a_soft_road_is_a_spring_in_series_with_the_tire() {
        let road = [Stretch { surface_stiffness: Some(50.0), ..Stretch::default() }];
        let contact = Surface::new(&Plant::new(&Vehicle::thesis()).nominal.contact, &road).at(0.0)[0];
        // The thesis's tire alone has 50, too.
        assert!((contact.stiffness_x - 25.0).abs() < 1e-9 && contact.stiffness_y == 11.5);
    }
}
