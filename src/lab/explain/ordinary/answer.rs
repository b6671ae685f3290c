//! What the ordinary car says of recordings: how well it predicts, with which numbers, and what is left.

use std::collections::BTreeMap;

use physics::Quantity;
use physics::model::effect::{EffectConfig, Kind};
use physics::model::{TireKind, Vehicle};

use super::along::Along;
use super::axles;
use super::bend::{Bent, with_bend};
use super::beyond::{Beyond, Powers, Question, beyond, powers_with, rows};
use super::choice::{REFUSED, fit_car, fit_ordinary, is_refused};
use super::drives::{Drives, MOST_S};
use super::fit::{FreeFit, begin_counting, count_more, fit};
use super::fitted_number::{Number, numbers};
use super::grid::STEP_S;
use super::inputs::{FreeDrive, Held};
use super::numbers::{free, on_time};
use super::remaining::{Remaining, remaining};
use super::robust::deviation;
use super::run::Predicted;
use super::scores::{
    CHANNELS, FreeTrace, TRACED_EVERY, errors, fits, held_square, measured, said, sideslip, traces,
};
use super::tires::{self, AxleTires};
use crate::explain::dates::begins;
use crate::explain::model::{Chosen, Model};
use crate::explain::result::{Block, ByChannel, Disturbance, Driven, Models, Parts, Verdict};
use identify::{CorneringStiffness, Values};
use predict::{GriddedDrive, Recording, Torque};

/// The ordinary car fitted to recordings.
#[derive(Clone, Debug)]
pub struct Ordinary {
    /// Fit by channel, %, of the free run.
    pub fit: Parts<ByChannel>,
    /// The same of the car as configured, its numbers refitted, sensors on time.
    pub plain_fit: Parts<ByChannel>,
    /// The same with what was found beside the ordinary car.
    pub found_fit: Parts<ByChannel>,
    /// Root mean square errors of the three, SI.
    pub error: Models<Parts<ByChannel>>,
    /// Which stretches were held out.
    pub split: Vec<Block>,
    /// How each recorded car was driven.
    pub driven: Vec<Driven>,
    /// Its numbers.
    pub numbers: Vec<Number>,
    /// How its tires bend.
    pub tire: TireKind,
    /// Its axles, what gives way in the steering with them.
    pub cornering_stiffness: CorneringStiffness,
    /// Those of the car as configured.
    pub plain_numbers: Vec<Number>,
    /// What it does not predict, by channel.
    pub disturbances: BTreeMap<String, Disturbance>,
    /// What of that repeats, by channel.
    pub remaining: BTreeMap<String, Remaining>,
    /// Does most of what repeats repeat beside what was found, too?
    pub leaves_most: bool,
    /// Recordings that could not be used, and why.
    pub left_out: Vec<String>,
    /// Measured and predicted.
    pub traces: Vec<FreeTrace>,
    /// What the recordings say beyond it, if that was asked for.
    pub beyond: Beyond,
    /// What the mean of the lateral acceleration over 0.2 s changes by within 30 ms for no reason of the car's, m/s².
    pub shaking_mps2: f64,
    /// Sideslip that the free run gives: recording; time, s, and rad.
    pub sideslip: Vec<(String, Vec<[f64; 2]>)>,
    /// Front and rear axle, where the recordings are the car's own and it predicts them.
    pub tires: [AxleTires; 2],
    /// Seconds that were run.
    pub seconds: f64,
    /// When recordings begin, in UTC, by their names; of those whose stamps are dates.
    pub begins_utc: BTreeMap<String, String>,
}

/// What is asked of recordings.
#[derive(Clone, Copy)]
pub struct Asked<'s> {
    /// What could be beyond the ordinary car …
    pub library: &'s [&'static Kind],
    /// … and whether that is to be searched for beside the one that was fitted.
    pub searches: &'s dyn Fn(&Ordinary) -> bool,
    /// The first so many recordings are healthy drives of the car: all of them is fitted to, and the search is for what the
    /// others have that they have not.
    pub references: usize,
    /// Are the recordings drives in time order, behind the references? Then the search is for what changed on the way.
    pub in_order: bool,
    /// Does each gyroscope that the question is about read the same before and after the drive, while the car stands? Then
    /// its zero has not moved in between.
    pub zero_is_still: bool,
    /// The last so many are only predicted; without any, every third block of 6 s of each.
    pub held_out: usize,
    /// Of what is drawn at random.
    pub seed: u64,
}

impl Asked<'_> {
    /// Nothing but the car itself.
    pub const CAR: Asked<'static> = Asked {
        library: &[],
        searches: &|_| false,
        references: 0,
        in_order: false,
        zero_is_still: false,
        held_out: 0,
        seed: 1,
    };
}

/// Beside something else that repeats the tires bend as a brush's by so much likelihood, 2 ln. Tuned by
/// `what_no_library_has_is_told_as_a_law`, 26, and `an_accelerometer_that_sits_ahead_is_not_called_early`, 89: there the bend is
/// a law else.
const SURELY_BENT: f64 = 50.0;

/// Below this share of the held-out yaw rate the car is not the one that drove, or its steering is not the one that
/// steered: then nothing can be said of what is left. A drive that hardly turns is not better.
pub(super) const LEAST_FIT: f64 = 60.0;

/// What was found accounts for at least half of the squared error that repeated; else it is at most a part of the answer.
const MOST_UNACCOUNTED: f64 = 0.5;

/// The ordinary car fitted to recordings of one car, and the car as configured beside it.
pub struct FittedCars<'a> {
    drives: Drives,
    found: FreeFit<'a>,
    plain: FreeFit<'a>,
    begins_utc: BTreeMap<String, String>,
}

impl<'a> FittedCars<'a> {
    /// Of the vehicle beside what it is with tires that bend. None where no recording can be used, or none beside its references.
    pub fn of(
        (vehicle, bent): (&'a Vehicle, &'a Bent),
        effects: &[EffectConfig],
        recordings: &[Recording],
        asked: Asked<'_>,
    ) -> Option<Self> {
        let all = Drives::of(&bent.smooth, recordings, asked)?;
        let drives = &all.drives;
        let plain =
            Model { values: Values::of(vehicle), ..as_configured(&bent.smooth, effects).of(vehicle.clone()) };
        begin_counting(drives, 2);
        // The ordinary car once more, without what the data may refuse.
        count_more(drives, 1);
        let leaves = |fit: &FreeFit<'_>| does_repeat(&repeating(drives, &fit.predicted, asked.seed));
        let fitted = |vehicle: &'a Vehicle, other: Option<&FreeFit<'_>>| {
            fit_car(&as_configured(vehicle, effects), vehicle, drives, other, leaves)
        };
        let ((found, repeats), plain) = rayon::join(
            || fitted(&bent.smooth, None),
            || fit(&plain, on_time(free(&plain, vehicle, drives)), drives),
        );
        let found = match &bent.brush {
            Some(brush) if repeats => {
                count_more(drives, 2);
                let (other, repeats) = fitted(brush, Some(&found));
                // What repeats is the tires' bend where another one leaves nothing of it; else it may be a shadow of what does.
                let least = if repeats { SURELY_BENT } else { REFUSED };
                if is_refused(&found, &other, least, drives) { other } else { found }
            }
            _ => found,
        };
        // Who asks for the car alone asks how well it is known; what is beyond it is judged by odds.
        let found = if asked.library.is_empty() { found.widened_by_leaving_out(drives) } else { found };
        Some(Self { found, plain, begins_utc: begins(recordings), drives: all })
    }

    /// What they say.
    pub fn say(&self, asked: Asked<'_>) -> Ordinary {
        let Self { found, plain, drives: Drives { drives, references, left_out }, .. } = self;
        let fitted = Fitted { vehicle: &found.model.vehicle, drives, found, plain, simulated: None };
        Ordinary {
            left_out: left_out.clone(),
            begins_utc: self.begins_utc.clone(),
            ..fitted.answer(Asked { references: *references, ..asked })
        }
    }

    /// What the measured speed says along the road; `gridded` tells how the same recordings were driven.
    pub fn along(&self, gridded: &[GriddedDrive], library: &[&'static Kind]) -> Along {
        Along::of(&self.found, &self.drives.drives, gridded, library)
    }
}

impl Ordinary {
    /// Of recordings of one car. None where no recording can be used, or none beside its references.
    pub fn of(
        vehicle: &Vehicle,
        effects: &[EffectConfig],
        recordings: &[Recording],
        asked: Asked<'_>,
    ) -> Option<Self> {
        let bent = Bent::of(vehicle);
        Some(FittedCars::of((vehicle, &bent), effects, recordings, asked)?.say(asked))
    }

    /// What it comes to, where the plain model and its effects leave much. Does any of the recordings turn?
    pub fn verdict(&self, turns: bool) -> Verdict {
        let repeats = does_repeat(&self.remaining);
        match () {
            // Straight on, noise is the larger part of the yaw rate, however well the car is known.
            () if !self.is_the_car() && !turns && !repeats => Verdict::InsufficientExcitation,
            () if !self.is_the_car() => Verdict::UnknownPhysics,
            () if self.beyond.is_unusual && self.leaves_most => Verdict::UnknownPhysics,
            () if self.beyond.is_unusual => Verdict::MissingPhysics,
            // What does not repeat is the road.
            () if repeats => Verdict::UnknownPhysics,
            () => Verdict::Adequate,
        }
    }

    /// Does much of what it does not predict repeat?
    pub fn repeats_clearly(&self) -> bool {
        self.remaining.values().any(Remaining::repeats_clearly)
    }

    /// Does the accelerometer shake with body, engine and road, as a raw inertial unit does? That is no white noise.
    pub fn shakes(&self) -> bool {
        self.shaking_mps2 > MOST_SHAKING_MPS2
    }

    /// Does it predict the held-out yaw rate at all?
    pub fn is_the_car(&self) -> bool {
        predicts_yaw_rate(&self.fit)
    }

    /// Does it with what was found?
    pub fn is_the_car_with_what_was_found(&self) -> bool {
        predicts_yaw_rate(&self.found_fit)
    }
}

fn predicts_yaw_rate(fit: &Parts<ByChannel>) -> bool {
    fit.holdout.get(Quantity::YawRate.name()).is_some_and(|fit| *fit >= LEAST_FIT)
}

/// An ordinary car fitted to drives.
pub(super) struct Fitted<'f> {
    /// The vehicle it is of.
    pub vehicle: &'f Vehicle,
    /// The drives.
    pub drives: &'f [FreeDrive],
    /// The car.
    pub found: &'f FreeFit<'f>,
    /// What it is compared with.
    pub plain: &'f FreeFit<'f>,
    /// See [`Question::simulated`].
    pub simulated: Option<&'f FreeFit<'f>>,
}

impl Fitted<'_> {
    /// What it says; `asked.references` of the drives are references.
    pub(super) fn answer(&self, asked: Asked<'_>) -> Ordinary {
        let Asked { library, searches, references, in_order, zero_is_still, seed, .. } = asked;
        let &Self { vehicle, drives, found, plain, simulated } = self;
        let predicted = &found.predicted;
        let plain_squares = CHANNELS.map(|channel| held_square(drives, &plain.predicted, channel));
        let repeats = |predicted: &[Predicted]| does_repeat(&repeating(drives, predicted, seed));
        let mut answer = Ordinary {
            fit: fits(drives, predicted),
            plain_fit: fits(drives, &plain.predicted),
            found_fit: Parts::default(),
            error: Models::default(),
            split: drives.iter().flat_map(FreeDrive::blocks).collect(),
            driven: drives.iter().map(|drive| drive.driven_every(TRACED_EVERY)).collect(),
            tire: vehicle.tire,
            cornering_stiffness: axles::of(found),
            numbers: numbers(found, drives),
            plain_numbers: numbers(plain, drives),
            disturbances: BTreeMap::new(),
            remaining: repeating(drives, predicted, seed),
            leaves_most: false,
            left_out: Vec::new(),
            traces: Vec::new(),
            beyond: Beyond::default(),
            shaking_mps2: shaking(drives, predicted),
            sideslip: drives.iter().zip(predicted).map(|(drive, own)| sideslip(drive, own)).collect(),
            tires: Default::default(),
            seconds: drives.iter().map(|drive| drive.points() as f64 * STEP_S).sum(),
            begins_utc: BTreeMap::new(),
        };
        if simulated.is_none() && answer.is_the_car() {
            answer.tires = tires::of(found, &Model::plain(&plain.model.vehicle, Torque::Unknown), drives);
        }
        // A simulation may be far from the car that drove.
        if (simulated.is_some() || answer.is_the_car()) && searches(&answer) {
            let question = Question {
                kinds: library,
                references,
                in_order,
                zero_is_still,
                simulated,
                plain: plain_squares,
                repeating: does_repeat(&answer.remaining),
                repeats: &repeats,
                seed,
            };
            answer.beyond = beyond(found, vehicle, drives, question);
            answer.beyond.agree_with(&answer.numbers);
        }
        let with_found = answer.beyond.predicted.clone();
        let with_found = with_found.as_deref().unwrap_or(predicted);
        answer.found_fit = fits(drives, with_found);
        answer.error = errors(drives, [&plain.predicted, predicted, with_found]);
        if answer.beyond.predicted.is_some() {
            let left = repeating(drives, with_found, seed);
            if let (true, Some(ordinary)) =
                (left.values().any(Remaining::repeats_clearly), &answer.error.ordinary)
            {
                let [before, after] = [(&answer.remaining, ordinary), (&left, &answer.error.extended)]
                    .map(|(remaining, error)| repeated(remaining, &error.holdout, &ordinary.holdout));
                answer.leaves_most = after > MOST_UNACCOUNTED * before;
            }
            if simulated.is_some() {
                answer.remaining = left;
            }
        }
        tracing::debug!(shaking_mps2 = answer.shaking_mps2, remaining = ?answer.remaining, "the ordinary car");
        for (place, channel) in CHANNELS.into_iter().enumerate() {
            if drives.iter().all(|drive| measured(drive, channel).is_none()) {
                continue;
            }
            let name = channel.name().to_owned();
            let disturbance = Disturbance {
                std: found.noise[place],
                unit: channel.unit().into(),
                time_constant_s: found.time_constants_s[place],
            };
            answer.disturbances.insert(name, disturbance);
        }
        answer.traces = traces(drives, with_found, &plain.predicted);
        answer
    }
}

/// What repeats of what runs leave, by channel.
fn repeating(drives: &[FreeDrive], predicted: &[Predicted], seed: u64) -> BTreeMap<String, Remaining> {
    let of = |channel: Quantity| {
        let error = |drive: &FreeDrive, own: &Predicted, i: usize| {
            measured(drive, channel).map_or(f64::NAN, |of| of[i] - said(own, channel)[i])
        };
        Some((channel.name().to_owned(), remaining(drives, predicted, error, seed)?))
    };
    CHANNELS.into_iter().filter_map(of).collect()
}

fn does_repeat(remaining: &BTreeMap<String, Remaining>) -> bool {
    remaining.values().any(Remaining::repeats)
}

/// Squared error that repeats, over both channels, each by what the ordinary car misses there.
fn repeated(remaining: &BTreeMap<String, Remaining>, error: &ByChannel, ordinary: &ByChannel) -> f64 {
    let of = |(channel, remaining): (&String, &Remaining)| {
        Some(remaining.share * (error.get(channel)? / ordinary.get(channel)?).powi(2))
    };
    remaining.iter().filter_map(of).sum()
}

/// What the recordings could tell of each effect, and of each number of the car beside references; and what they would with
/// each of these drives more, which are planned only. None where no recording can be used, or where the ordinary car does
/// not predict them.
pub fn could_tell(
    vehicle: &Vehicle,
    effects: &[EffectConfig],
    recordings: &[Recording],
    planned: &[Recording],
    asked: Asked<'_>,
) -> Option<(Powers, Vec<Option<Powers>>)> {
    let own = with_bend(vehicle);
    let Drives { drives, references, .. } = Drives::of(&own, recordings, asked)?;
    let found = fit_ordinary(&as_configured(&own, effects), &own, &drives, None);
    let fits = fits(&drives, &found.predicted);
    if fits.holdout.get(Quantity::YawRate.name()).is_none_or(|fit| *fit < LEAST_FIT) {
        return None;
    }
    let question = Question {
        kinds: asked.library,
        references,
        in_order: false,
        // Of what would be there.
        zero_is_still: false,
        simulated: None,
        plain: [0.0; 2],
        repeating: false,
        repeats: &|_| false,
        seed: asked.seed,
    };
    let planned =
        planned.iter().map(|recording| FreeDrive::new(recording, &own, Held::EveryThird, MOST_S).ok());
    Some(powers_with(&found, &own, &drives, question, planned.collect()))
}

/// The model of this vehicle with these effects, what is uncertain of them free. Delays are searched for, not supposed.
pub(super) fn as_configured<'a>(own: &'a Vehicle, effects: &[EffectConfig]) -> Model<'a> {
    let effects = effects.iter().map(|effect| Chosen::configured(effect).free_where_uncertain()).collect();
    Model { delays: Default::default(), effects, ..Model::plain(own, Torque::Unknown) }
}

/// Beyond this it is called shaking. Tuned by recordings: cars on roads have 0.13 to 0.54, simulated drives with white noise
/// of up to 0.2 m/s² at 100 Hz have 0.02 at most.
const MOST_SHAKING_MPS2: f64 = 0.05;

/// See [`Ordinary::shaking_mps2`]; 0 where nothing tells.
fn shaking(drives: &[FreeDrive], predicted: &[Predicted]) -> f64 {
    let steps = drives.iter().zip(predicted).filter_map(|(drive, own)| {
        let measured = drive.lateral.as_ref()?;
        let error: Vec<f64> = rows(drive).map(|i| measured[i] - own.lateral[i]).collect();
        let counts: Vec<bool> = rows(drive).map(|i| drive.counts[i]).collect();
        let steps = (1..error.len()).filter(move |i| counts[*i] && counts[i - 1]);
        Some(steps.map(move |i| error[i] - error[i - 1]).collect::<Vec<_>>())
    });
    deviation(steps.flatten()).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::super::bench::{recorded, recorded_as};
    use super::*;

    /// What is hidden in a recording comes out of a free run: the car, delays and offsets.
    #[test]
    fn a_late_steering_a_small_wheel_and_a_relaxing_tire_come_out() {
        let hidden = "[[effect]]\nkind = \"sensor_delay\"\nchannel = \"steering_wheel_angle\"\ndelay_s = 0.08\n\
                      [[effect]]\nkind = \"sensor_bias\"\nchannel = \"yaw_rate\"\nbias = 0.02\n\
                      [[effect]]\nkind = \"relaxation_length\"\nlength_m = 0.6\n";
        let (vehicle, recording) = recorded(hidden);
        let found = Ordinary::of(&vehicle, &[], &[recording], Asked::CAR).unwrap();
        let number = |name: &str| found.numbers.iter().find(|number| number.name == name).unwrap();
        let is_near = |name: &str, truth: f64, most: f64| {
            let estimate = number(name).estimate;
            let apart = (estimate.value - truth).abs();
            assert!(apart < most && apart < 4.0 * estimate.std.max(0.1 * most), "{name} {estimate:?}");
        };
        is_near("steering_wheel_angle_delay_s", 0.08, 0.015);
        is_near("yaw_rate_offset", 0.02, 0.004);
        is_near("relaxation_length.length_m", 0.6, 0.2);
        let yaw_rate = |fit: &Parts<ByChannel>| fit.holdout["yaw_rate"];
        assert!(yaw_rate(&found.fit) > 95.0 && yaw_rate(&found.fit) > yaw_rate(&found.plain_fit) + 2.0);
        assert_eq!(found.verdict(true), Verdict::Adequate, "{:?}", found.remaining);
        // Something unusual is the answer, or a part of it.
        let told = Ordinary { beyond: Beyond { is_unusual: true, ..Beyond::default() }, ..found };
        assert_eq!(told.verdict(true), Verdict::MissingPhysics);
        assert_eq!(Ordinary { leaves_most: true, ..told }.verdict(true), Verdict::UnknownPhysics);
    }

    /// GIVEN a brush's tires and hardly any noise, and a table that knows of no bend WHEN the ordinary car is fitted THEN its tires
    /// bend as a brush's do, and nothing is left that repeats; with a friction that is free, too, the magic formula does as well.
    #[test]
    fn where_the_noise_is_small_a_brush_is_seen() {
        let (mut vehicle, recording) = recorded_as("", |scenario| {
            scenario.sensors.by_name.values_mut().for_each(|sensor| sensor.noise_std *= 0.1);
        });
        let recordings = [recording];
        for (tire, bends_as) in [
            (TireKind::Piecewise, &[TireKind::Brush][..]),
            (TireKind::Linear, &[TireKind::Brush, TireKind::MagicFormula]),
        ] {
            vehicle.tire = tire;
            let found = Ordinary::of(&vehicle, &[], &recordings, Asked::CAR).unwrap();
            assert!(bends_as.contains(&found.tire), "{tire:?}: {:?}", found.tire);
            assert_eq!(found.verdict(true), Verdict::Adequate, "{tire:?}: {:?}", found.remaining);
        }
    }

    #[test]
    fn what_repeats_is_counted_by_what_the_ordinary_car_misses() {
        let of = |share: f64| Remaining { share, null: 0.0, most_of_null: 0.0 };
        let remaining =
            BTreeMap::from([("yaw_rate".to_owned(), of(0.8)), ("lateral_acceleration".to_owned(), of(0.2))]);
        let errors = |yaw_rate: f64, lateral: f64| -> ByChannel {
            [("yaw_rate".to_owned(), yaw_rate), ("lateral_acceleration".to_owned(), lateral)].into()
        };
        let ordinary = errors(0.01, 0.1);
        assert!((repeated(&remaining, &ordinary, &ordinary) - 1.0).abs() < 1e-12);
        // Half the error is a quarter of its square.
        assert!((repeated(&remaining, &errors(0.005, 0.1), &ordinary) - 0.4).abs() < 1e-12);
    }

    #[test]
    fn a_recording_without_yaw_rate_or_driving_is_left_out() {
        let (vehicle, mut recording) = recorded("");
        recording.tracks[Quantity::YawRate as usize].clear();
        assert!(Ordinary::of(&vehicle, &[], &[recording], Asked::CAR).is_none());
    }
}
