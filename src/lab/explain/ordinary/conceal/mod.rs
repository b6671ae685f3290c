//! Puts effects into a recording of a real car, and leaves everything else of it as it is.
//!
//! ```text
//! Recording ─► ordinary car, fitted ─► two free runs, without and with the effects ─► their difference ─┐
//! effects of sensors and wheels ──────────────────────────────────────────────────────── Concealment ◄──┘
//! Concealment: what each reading becomes
//! ```
//!
//! What acts on the car or is of the road is added as the difference of two free runs from the same recorded inputs. The
//! car drives as fast as it did; so a force along it shows in what drives and brakes it, and in the slips of the wheels.
//! What is of a sensor or of a wheel's radius is put onto the readings themselves. The noise, the road and whatever else is
//! odd about the car stay.

mod course;
mod difference;
mod readings;

pub use super::bend::with_bend;
pub use course::drawn;
pub use difference::{Base, Car};

use physics::model::Vehicle;
use physics::model::effect::{Course, EffectConfig, Kind, Spec};
use physics::{Quantity, Wheel};

use self::difference::Difference;
use self::readings::Readers;
use crate::explain::Recording;

/// What is to be concealed, and in what.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// The car as configured …
    pub vehicle: &'a Vehicle,
    /// … with the effects that it is known to have.
    pub configured: &'a [EffectConfig],
    /// Its drive.
    pub recording: &'a Recording,
    /// What is put in, all of it together.
    pub effects: &'a [EffectConfig],
}

/// How an effect is put in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Onto the readings of its channel.
    Sensor,
    /// Onto the readings of the wheels.
    Wheels,
    /// As the difference of two free runs.
    Runs,
}

/// Why it cannot be put in.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// It is of a channel that is not recorded.
    #[error(
        "{effect} is of {channel}, which this recording does not have; map the signal in [signals], or take another \
         channel"
    )]
    NoChannel {
        /// The effect.
        effect: String,
        /// The channel.
        channel: String,
    },
    /// It begins too late.
    #[error(
        "{effect} is there from {from:.1} s on only, and the recording ends at {end:.1} s; let it begin earlier"
    )]
    Outside {
        /// The effect.
        effect: String,
        /// When it begins, s.
        from: f64,
        /// When the recording ends, s.
        end: f64,
    },
    /// No free run is possible.
    #[error(
        "{effect} acts on the car and needs a free run through the recording, but {why}; only effects of sensors and \
         of the wheels' radii can be put in here"
    )]
    NoRun {
        /// The effect.
        effect: String,
        /// Why.
        why: String,
    },
    /// The fitted car is not the one that drove.
    #[error(
        "the ordinary car, fitted, gives {fit:.0} % of the yaw rate (60 % are needed) and leaves {left:.3} rad/s rms: \
         does the steering belong to this drive? `gripd explain` tells more. Effects of sensors and of the wheels' \
         radii can be put in nevertheless"
    )]
    NotThisCar {
        /// How much of the yaw rate the free run gives, %.
        fit: f64,
        /// What is left of it, rad/s rms.
        left: f64,
    },
    /// The car would spin.
    #[error(
        "with {effect} the car would spin at {at:.1} s (sideslip of {degrees:.0}°) where it did not; take less of it, \
         or have it elsewhere"
    )]
    Spins {
        /// The effects.
        effect: String,
        /// When, s.
        at: f64,
        /// Sideslip, degrees.
        degrees: f64,
    },
    /// The car would drive elsewhere.
    #[error(
        "with {effect} the yaw rate would change by {change:.3} rad/s rms, of {all:.3} that it has: with the same \
         steering the car would not drive there any more; take less of it"
    )]
    Elsewhere {
        /// The effects.
        effect: String,
        /// The change, rad/s.
        change: f64,
        /// The yaw rate's own deviation, rad/s.
        all: f64,
    },
    /// The tires cannot do it.
    #[error(
        "with {effect} the same motion would take {needed:.0} N along the wheels at {at:.1} s, more than tires of \
         friction {friction:.2} can give; take less of it"
    )]
    TooStrong {
        /// The effects.
        effect: String,
        /// The force, N.
        needed: f64,
        /// When, s.
        at: f64,
        /// The friction.
        friction: f64,
    },
    /// More states than there is room for.
    #[error("{effect}: too many effects with states of their own at once; leave one out")]
    TooMany {
        /// The effects.
        effect: String,
    },
    /// Nothing that is recorded changes.
    #[error(
        "{effect} changes nothing that this recording has; it would show in {channels}: map one of them in [signals], \
         or take a drive in which it acts"
    )]
    Nowhere {
        /// The effects.
        effect: String,
        /// Where it would show.
        channels: String,
    },
}

impl Refusal {
    /// The same of these effects.
    fn of(self, titles: &str) -> Self {
        match self {
            Self::NoRun { why, .. } => Self::NoRun { effect: titles.to_owned(), why },
            other => other,
        }
    }
}

/// What each reading becomes.
#[derive(Debug)]
pub struct Concealment {
    readers: Readers,
    difference: Option<Difference>,
    /// The ordinary car, where one could be fitted.
    pub car: Option<Car>,
}

/// Kinds that change nothing but how far a wheel rolls in a turn.
const OF_THE_WHEELS: [&str; 2] = ["tire_radius", "radius_growth"];

/// How effects of a kind are put in.
pub fn way(kind: &Kind) -> Way {
    match () {
        () if kind.is_of_measurement() => Way::Sensor,
        () if OF_THE_WHEELS.contains(&kind.name) => Way::Wheels,
        () => Way::Runs,
    }
}

/// From when till when an effect is there within a recording of so many seconds.
pub fn intervals(effect: &EffectConfig, seconds: f64) -> Vec<[f64; 2]> {
    let onset = effect.kind().onset().map_or(0.0, |place| effect.numbers()[place].value.max(0.0));
    let course: Vec<[f64; 2]> = match effect.course() {
        Course::Stretches { intervals, .. } => intervals.clone(),
        Course::Series(series) => match (series.t.first(), series.t.last()) {
            (Some(from), Some(to)) => vec![[*from, *to]],
            _ => Vec::new(),
        },
        _ => vec![[onset, seconds]],
    };
    let within = course.into_iter().map(|[from, to]| [from.max(0.0), to.min(seconds)]);
    within.filter(|[from, to]| from < to).collect()
}

impl Concealment {
    /// Fits the car and makes the runs that are needed.
    ///
    /// # Errors
    /// Why an effect cannot be put into this recording, and what to do.
    pub fn of(asked: Asked<'_>) -> Result<Self, Refusal> {
        let own = with_bend(asked.vehicle);
        Self::beside(Base::of(&own, &asked).as_ref().map_err(Clone::clone), asked)
    }

    /// The same with a car that was fitted to this recording before, or with the reason why none was.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn beside(base: Result<&Base<'_>, Refusal>, asked: Asked<'_>) -> Result<Self, Refusal> {
        for effect in asked.effects {
            possible(effect, asked.recording)?;
        }
        let of_runs: Vec<EffectConfig> =
            asked.effects.iter().filter(|effect| way(effect.kind()) == Way::Runs).cloned().collect();
        let titles = titles(&of_runs);
        let (car, difference) = match base {
            Ok(base) => (Some(base.car.clone()), base.difference(&of_runs, asked.vehicle)?),
            // Nothing of it needs the car.
            Err(_) if of_runs.is_empty() => (None, None),
            Err(refusal) => return Err(refusal.of(&titles)),
        };
        let readers = Readers::new(asked.vehicle, asked.effects, asked.recording);
        let this = Self { readers, difference, car };
        if !of_runs.is_empty() {
            this.shows(&titles, asked.recording)?;
        }
        Ok(this)
    }

    /// What a reading becomes: of a quantity, at a time from the recording's start (s), as it was recorded, SI.
    pub fn reading(&self, quantity: Quantity, t: f64, recorded: f64) -> f64 {
        let changed = |quantity: Quantity, t: f64, recorded: f64| match &self.difference {
            Some(difference) => {
                difference.of(quantity, t, recorded, |other, t| self.readers.recorded(other, t))
            }
            None => recorded,
        };
        self.readers.reading(quantity, t, recorded, changed)
    }

    /// What the ordinary car leaves of a quantity, rms about its mean, SI; of accelerations as means over 0.2 s. None where
    /// it says nothing of it.
    pub fn unexplained(&self, quantity: Quantity) -> Option<f64> {
        self.car.as_ref().and_then(|car| car.unexplained[quantity as usize])
    }

    /// Something must show it.
    fn shows(&self, effect: &str, recording: &Recording) -> Result<(), Refusal> {
        let Some(difference) = &self.difference else { return Ok(()) };
        let changed: Vec<Quantity> = Quantity::ALL.into_iter().filter(|q| difference.changes(*q)).collect();
        if changed.is_empty() || changed.iter().any(|quantity| recording.has(*quantity)) {
            return Ok(());
        }
        let channels: Vec<_> = changed.iter().map(|quantity| quantity.name()).collect();
        Err(Refusal::Nowhere { effect: effect.to_owned(), channels: channels.join(", ") })
    }
}

/// Names of several, in a sentence.
fn titles(effects: &[EffectConfig]) -> String {
    effects.iter().map(EffectConfig::title).collect::<Vec<_>>().join(" and ")
}

/// Is what it is of recorded, and while it is there?
fn possible(effect: &EffectConfig, recording: &Recording) -> Result<(), Refusal> {
    let no = |quantity: Quantity| {
        let (effect, channel) = (effect.title(), quantity.name().to_owned());
        (!recording.has(quantity)).then_some(Refusal::NoChannel { effect, channel })
    };
    let of: Vec<Quantity> = match (effect.channel(), way(effect.kind())) {
        (Some(channel), _) => channel.quantities().collect(),
        (None, Way::Wheels) => wheels_of(effect),
        (None, _) => Vec::new(),
    };
    if let Some(refusal) = of.into_iter().find_map(no) {
        return Err(refusal);
    }
    if way(effect.kind()) == Way::Wheels
        && !Wheel::ALL.into_iter().any(|w| recording.has(Quantity::wheel_speed(w)))
    {
        return Err(Refusal::NoChannel { effect: effect.title(), channel: "the wheel speeds".into() });
    }
    let end = recording.seconds();
    let from = match effect.course() {
        Course::Stretches { intervals, .. } => intervals.first().map(|[from, _]| *from),
        Course::Series(series) => series.t.first().copied(),
        _ => effect.kind().place_of(Spec::AT_S.name).map(|place| effect.numbers()[place].value),
    };
    match from.filter(|from| *from >= end) {
        Some(from) => Err(Refusal::Outside { effect: effect.title(), from, end }),
        None => Ok(()),
    }
}

/// The wheels that an effect names with a number of theirs.
fn wheels_of(effect: &EffectConfig) -> Vec<Quantity> {
    let numbers = effect.specs().zip(effect.numbers());
    let named = numbers.filter(|(_, number)| number.value != 0.0).filter_map(|(spec, _)| {
        Wheel::ALL.into_iter().map(Quantity::wheel_speed).find(|quantity| {
            let wheel = quantity.name().trim_start_matches("wheel_speed");
            spec.name.ends_with(wheel)
        })
    });
    named.collect()
}

#[cfg(test)]
mod tests;
