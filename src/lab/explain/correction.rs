//! The upper bound of what effects could explain: two unknown forces and a moment, each a free course in time.
//!
//! These are no physics. They say how much is missing: the gain of a named effect is judged against theirs. Where no
//! effect is named they still help to predict.

use super::fit::{Data, Fit};
use super::model::Chosen;
use physics::Quantity;
use physics::model::effect::{Acting, Course, Effect, Felt, Kind, Now, Readings, SearchHints, Setting};
use predict::Torque;
use predict::noise::Live;

/// An unknown force or moment.
#[derive(Clone, Debug)]
struct Unknown {
    course: Course,
    of: Of,
}

#[derive(Clone, Copy, Debug)]
enum Of {
    Along,
    Across,
    Moment,
}

impl Effect for Unknown {
    fn act(&self, now: &Now<'_>, _states: &[f64], on: &mut Acting) {
        let value = self.course.at(now);
        match self.of {
            Of::Along => on.external.fx += value,
            Of::Across => on.external.fy += value,
            Of::Moment => on.external.moment += value,
        }
    }
}

const fn kind(name: &'static str, place: &'static str, make: fn(&Setting<'_>) -> Box<dyn Effect>) -> Kind {
    Kind {
        name,
        words: name,
        about: "something acts on the car that no effect of the library does",
        equation: "… + u(t)",
        source: "no physics: a smooth course of its own",
        place,
        to_tell_apart: "",
        channels: &[],
        parameters: &[],
        course: None,
        search: SearchHints::USUAL,
        make,
    }
}

static ALONG: Kind = kind("unknown_longitudinal_force", "longitudinal force balance", |setting| {
    Box::new(Unknown { course: setting.course.clone(), of: Of::Along })
});
static ACROSS: Kind = kind("unknown_lateral_force", "lateral force balance", |setting| {
    Box::new(Unknown { course: setting.course.clone(), of: Of::Across })
});
static MOMENT: Kind = kind("unknown_yaw_moment", "yaw moment balance", |setting| {
    Box::new(Unknown { course: setting.course.clone(), of: Of::Moment })
});

/// The same as disturbances: nothing tells them when a car runs freely.
static PUSHED: Kind = kind("disturbing_force", "lateral force balance", ACROSS.make);
static TURNED: Kind = kind("disturbing_moment", "yaw moment balance", MOMENT.make);

/// Noise of a sensor that goes on for a while.
static COLOURED: Kind = kind("coloured_noise", "a sensor", |setting| {
    Box::new(Coloured { course: setting.course.clone(), quantity: setting.quantity() })
});

/// Disturbances across and about the vertical, and of a sensor.
pub static DISTURBANCES: [&Kind; 3] = [&PUSHED, &TURNED, &COLOURED];

/// Is it one?
pub fn is_disturbance(kind: &Kind) -> bool {
    DISTURBANCES.into_iter().any(|own| std::ptr::eq(own, kind))
}

#[derive(Clone, Debug)]
struct Coloured {
    course: Course,
    quantity: Option<Quantity>,
}

impl Effect for Coloured {
    fn sense(&self, now: &Now<'_>, _felt: &Felt, _states: &[f64], readings: &mut Readings) {
        if let Some(quantity) = self.quantity {
            readings[quantity as usize] += self.course.at(now);
        }
    }
}

/// First sizes, N and N m, and length, s. Numerical: where the search begins.
const FORCE_N: f64 = 150.0;
const MOMENT_NM: f64 = 150.0;
const LENGTH_S: f64 = 0.7;

/// The plain model with all three; without a known torque the longitudinal one is there already.
pub fn correct<'a>(data: &Data<'_>, baseline: &Fit<'a>, rounds: usize) -> Fit<'a> {
    let mut model = baseline.model.clone();
    let mut noise = baseline.noise.clone();
    let kinds: &[(&'static Kind, f64)] = match model.torque {
        Torque::Recorded => &[(&ACROSS, FORCE_N), (&MOMENT, MOMENT_NM), (&ALONG, FORCE_N)],
        Torque::Unknown => &[(&ACROSS, FORCE_N), (&MOMENT, MOMENT_NM)],
        Torque::Roughly => return baseline.clone(),
    };
    for (kind, size) in kinds {
        model.effects.push(Chosen::usual(kind, None, Course::Live(noise.live.len())));
        noise = noise.with(Live { size: *size, length_s: LENGTH_S, least_s: 0.1, difference: 0.02 * size });
    }
    data.fit(&model, &baseline.free, &noise, rounds)
}
