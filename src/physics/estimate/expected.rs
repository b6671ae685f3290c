//! What the car's table lets expect of what is learned: what contradicts it was learned from a sensor that is wrong, or
//! the table is another car's. Neither is a thing to begin the next drive with.

use std::fmt;

use super::config::EstimatorsConfig;
use super::cornering::expected_errors;
use super::kinematics::Car;
use super::learned::{ERRORS, Known, Learned};

/// For all cars alike where the table takes a number for known: so much do cars of one class differ.
struct Class {
    /// Cornering stiffness, relative: the default's deviation.
    cornering: f64,
    /// Slope, relative: the default's deviation.
    slope: f64,
    /// Rolling radius, relative: tires of one size, new and worn.
    radius: f64,
    /// Steering ratio, relative: gears of one model, and those that vary with the angle.
    steering_ratio: f64,
}

const CLASS: Class = Class { cornering: 0.33, slope: 0.5, radius: 0.015, steering_ratio: 0.05 };

/// A number that was learned and the table does not allow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contradiction {
    /// Its name.
    pub what: &'static str,
    /// What was learned.
    pub learned: Known,
    /// What the table has.
    pub expected: Known,
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, learned, expected } = self;
        write!(
            f,
            "{what} {:.4} ± {:.4} contradicts [vehicle], which allows {:.4} ± {:.4}",
            learned.value, learned.std, expected.value, expected.std
        )
    }
}

/// Values and deviations of all that is learned, before anything is.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    errors: [Known; ERRORS],
    cornering: [Known; 2],
    /// Of a front and of a rear wheel.
    slope: [Known; 2],
    slip_offset: Known,
}

impl Expected {
    /// Further off (standard deviations, what was learned having its own) it contradicts. Statistical: of the fifteen
    /// numbers of a healthy car one in twenty-five cars has such a one, and starts each drive without it.
    const CONTRADICTION: f64 = 3.0;
    const ERRORS: [&str; ERRORS] = [
        "road angle offset",
        "lateral acceleration offset",
        "yaw rate offset",
        "speed scale",
        "road angle scale",
    ];
    const CORNERING: [&str; 2] = ["cornering stiffness front", "cornering stiffness rear"];
    const SLOPE: [&str; 4] = ["slope fl", "slope fr", "slope rl", "slope rr"];
    const SLIP_OFFSET: [&str; 4] = ["slip offset fl", "slip offset fr", "slip offset rl", "slip offset rr"];

    /// By the car's table and what its class is like.
    pub fn new(car: &Car, config: &EstimatorsConfig) -> Self {
        let of_class = |(value, std): (f64, f64), class: f64| Known {
            value,
            std: if std > 0.0 { std } else { class * value },
        };
        let or = |std: f64, class: f64| if std > 0.0 { std } else { class };
        let mut typical = car.clone();
        typical.radius_relative_std = or(car.radius_relative_std, CLASS.radius);
        typical.steering_ratio_relative_std = or(car.steering_ratio_relative_std, CLASS.steering_ratio);
        Self {
            errors: expected_errors(&typical, &config.cornering).map(|std| Known { value: 0.0, std }),
            cornering: car.cornering_prior.map(|prior| of_class(prior, CLASS.cornering)),
            slope: car.slope_prior.map(|prior| of_class(prior, CLASS.slope)),
            slip_offset: Known { value: 0.0, std: config.slope.initial_offset_std },
        }
    }

    /// What of it agrees with the table, and the first number that does not. An error of a sensor takes all others with
    /// it, and the cornering stiffnesses: they were told from each other by the same equations.
    pub fn agreeing(&self, learned: &Learned) -> (Learned, Option<Contradiction>) {
        let mut rest = *learned;
        let mut first = None;
        let mut agrees = |what, learned: &Option<Known>, expected: &Known| {
            let wrong = learned.and_then(|learned| Self::contradiction(what, learned, *expected));
            first = first.or(wrong);
            wrong.is_none()
        };
        let mut errors = true;
        for ((what, learned), expected) in Self::ERRORS.into_iter().zip(&learned.errors()).zip(&self.errors) {
            errors &= agrees(what, learned, expected);
        }
        if !errors {
            rest = Learned {
                time: learned.time,
                driving_s: learned.driving_s,
                slope: learned.slope,
                slip_offset: learned.slip_offset,
                ..Learned::default()
            };
        }
        for (place, what) in Self::CORNERING.into_iter().enumerate() {
            if !agrees(what, &learned.cornering[place], &self.cornering[place]) {
                rest.cornering[place] = None;
            }
        }
        for place in 0..4 {
            if !agrees(Self::SLOPE[place], &learned.slope[place], &self.slope[place / 2]) {
                rest.slope[place] = None;
            }
            if !agrees(Self::SLIP_OFFSET[place], &learned.slip_offset[place], &self.slip_offset) {
                rest.slip_offset[place] = None;
            }
        }
        (rest, first)
    }

    /// The same, and in the place of what does not agree what was known before: a bad drive takes nothing away.
    pub fn agreeing_or(&self, learned: &Learned, before: &Learned) -> Learned {
        let (mut rest, contradiction) = self.agreeing(learned);
        if contradiction.is_none() {
            return rest;
        }
        let is_gone = |(learned, rest): (&Option<Known>, &Option<Known>)| learned.is_some() && rest.is_none();
        if learned.errors().iter().zip(&rest.errors()).any(is_gone) {
            rest = Learned {
                time: rest.time,
                driving_s: rest.driving_s,
                slope: rest.slope,
                slip_offset: rest.slip_offset,
                cornering: rest.cornering,
                ..*before
            };
        }
        let of_tires = |of: &Learned| (of.cornering, of.slope, of.slip_offset);
        let ((cornering, slope, offset), before) = (of_tires(learned), of_tires(before));
        for (place, rest) in rest.cornering.iter_mut().enumerate() {
            if is_gone((&cornering[place], &*rest)) {
                *rest = before.0[place];
            }
        }
        for place in 0..4 {
            if is_gone((&slope[place], &rest.slope[place])) {
                rest.slope[place] = before.1[place];
            }
            if is_gone((&offset[place], &rest.slip_offset[place])) {
                rest.slip_offset[place] = before.2[place];
            }
        }
        rest
    }

    fn contradiction(what: &'static str, learned: Known, expected: Known) -> Option<Contradiction> {
        let off = (learned.value - expected.value).abs();
        (off > Self::CONTRADICTION * learned.std.hypot(expected.std)).then_some(Contradiction {
            what,
            learned,
            expected,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Uncertain, Vehicle};

    fn known(value: f64, std: f64) -> Option<Known> {
        Some(Known { value, std })
    }

    /// A car whose table says how sure it is, or not.
    fn expected(is_sure: bool) -> Expected {
        let std = |std: f64| if is_sure { 0.0 } else { std };
        let vehicle = Vehicle {
            wheel_radius_m: Uncertain { value: 0.31, std: std(0.005) },
            steering_ratio: Uncertain { value: 15.5, std: std(0.5) },
            lateral_stiffness_front: Uncertain { value: 12.0, std: std(3.0) },
            longitudinal_stiffness: Uncertain { value: 104.0, std: std(30.0) },
            ..Vehicle::thesis()
        };
        Expected::new(&Car::new(&vehicle), &EstimatorsConfig::default())
    }

    fn learned() -> Learned {
        Learned {
            driving_s: 100.0,
            slope: [known(95.0, 2.0), known(22.0, 1.0), None, None],
            slip_offset: [known(0.014, 1e-4), None, None, None],
            cornering: [known(13.5, 1.0), known(14.0, 1.0)],
            yaw_rate_offset: known(0.012, 4e-4),
            speed_scale: known(0.024, 0.01),
            road_angle_scale: known(-0.08, 0.02),
            error_correlations: [0.1; 10],
            ..Learned::default()
        }
    }

    #[test]
    fn what_a_healthy_drive_learns_is_kept_as_it_is() {
        for is_sure in [false, true] {
            assert_eq!(expected(is_sure).agreeing(&learned()), (learned(), None));
            assert_eq!(expected(is_sure).agreeing(&Learned::default()), (Learned::default(), None));
        }
    }

    /// GIVEN the speed that a yaw rate of four fifths teaches THEN neither it nor what was told from it is kept, and
    /// what the wheels alone tell is; where the table says nothing, too.
    #[test]
    fn an_error_that_no_such_car_has_takes_the_others_with_it() {
        for is_sure in [false, true] {
            let poisoned = Learned { speed_scale: known(0.123, 0.005), ..learned() };
            let (rest, contradiction) = expected(is_sure).agreeing(&poisoned);
            let Learned { time, driving_s, slope, slip_offset, .. } = learned();
            assert_eq!(rest, Learned { time, driving_s, slope, slip_offset, ..Learned::default() });
            let contradiction = contradiction.unwrap();
            assert_eq!(contradiction.what, "speed scale");
            let said = contradiction.to_string();
            assert!(said.starts_with("speed scale 0.1230 ± 0.0050 contradicts [vehicle]"), "{said}");
        }
    }

    #[test]
    fn a_tire_that_no_such_car_has_goes_alone() {
        let mut odd = learned();
        odd.cornering[0] = known(26.0, 0.5);
        odd.slope[1] = known(4.0, 0.2);
        odd.slip_offset[0] = known(-0.09, 1e-3);
        let (rest, contradiction) = expected(false).agreeing(&odd);
        let (mut wanted, mut slopes) = (learned(), learned().slope);
        slopes[1] = None;
        (wanted.slope, wanted.slip_offset, wanted.cornering[0]) = (slopes, [None; 4], None);
        assert_eq!(rest, wanted);
        assert_eq!(contradiction.map(|c| c.what), Some("cornering stiffness front"));
    }

    /// GIVEN what good drives learned WHEN a bad one contradicts the table THEN that is still there in its place; AND what
    /// the bad one learned no more is not.
    #[test]
    fn a_bad_drive_takes_nothing_away() {
        let before = learned();
        let mut bad = Learned { driving_s: 200.0, speed_scale: known(0.123, 0.005), ..learned() };
        (bad.slope[0], bad.slope[1], bad.slip_offset[0]) = (known(90.0, 2.0), known(4.0, 0.2), None);
        let kept = expected(false).agreeing_or(&bad, &before);
        let slope = [known(90.0, 2.0), before.slope[1], None, None];
        assert_eq!(kept, Learned { driving_s: 200.0, slope, slip_offset: [None; 4], ..before });
        let good = Learned { yaw_rate_offset: None, ..learned() };
        assert_eq!(expected(false).agreeing_or(&good, &before), good);
    }
}
