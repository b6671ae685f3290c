//! From recordings to the answer: fits the plain model, selects effects, judges.

use super::candidates::library;
use super::case::{Answer, Case};
use super::conclusion::Conclusion;
use super::correction::correct;
use super::disturbed::or_disturbed;
use super::excerpt::Excerpt;
use super::fit::Data;
use super::long_recording::LongSearch;
use super::model::{Free, Model};
use super::ordinary::{Bent, FittedCars, Ordinary};
use super::other_tires::or_other_tires;
use super::put_right::put_right;
use super::result::{Explanation, Finding, Verdict};
use super::select::{Selection, select};
use super::signs_and_swaps;
use super::split::{Part, Split};
use super::used::Used;
use super::verdict::Gains;
use super::work;
use physics::Quantity;
use predict::noise::{Live, Noise};
use predict::{GriddedDrive, Torque, grid::STEP_S};

/// Seconds that must be usable. Tuned, no test on record.
const LEAST_SECONDS: f64 = 15.0;

/// Rounds of fitting with unknown forces, and of fitting them to everything, if an excerpt came first.
/// Numerical: Gauss–Newton steps.
const CORRECTION_ROUNDS: usize = 4;
const CORRECTION_AGAIN: usize = 1;

impl<'a> Case<'a> {
    /// Explains. `progress` is told the stage and how far it is.
    pub fn explain(&self, progress: &(dyn Fn(&str, f64) + Sync)) -> Answer<'a> {
        if self.references > 0 || self.in_order {
            return self.changed(progress);
        }
        let drives: Vec<GriddedDrive> =
            self.recordings.iter().map(|recording| GriddedDrive::new(recording, self.vehicle)).collect();
        let has = |quantity: Quantity| self.recordings.iter().any(|recording| recording.has(quantity));
        let knows_torque = drives.iter().all(|drive| drive.knows_torque);
        let split = Split::new(&drives, self.held_out);
        let torque = if knows_torque { Torque::Recorded } else { Torque::Unknown };
        let noise = first_noise(&drives, torque);
        let own_noise = noise.clone();
        let mut data = Data { drives: &drives, split, part: Part::Train, own_noise, share: 1.0 };
        let plain = Model::plain(self.vehicle, torque).with_configured(self.effects);
        let usable: f64 =
            drives.iter().flat_map(|d| &d.runs).map(|(from, to)| (to - from) as f64 * STEP_S).sum();
        if usable < LEAST_SECONDS {
            let mut explanation = too_little(usable, &drives);
            explanation.take_chain(self.chain);
            return Answer { explanation, model: plain };
        }
        progress(work::ORDINARY, 0.0);
        let bent = Bent::of(self.vehicle);
        let recordings = put_right(self.recordings, self.chain);
        let cars = FittedCars::of((self.vehicle, &bent), self.effects, &recordings, self.asked(&|_| false));
        let ordinary_if =
            |searches: &dyn Fn(&Ordinary) -> bool| Some(cars.as_ref()?.say(self.asked(searches)));
        // A filter that takes noise for white learns nothing of physics where the car shakes, and little where nobody tells
        // the forces along it.
        let comes_first = |ordinary: &Ordinary| !knows_torque || ordinary.shakes();
        let mut ordinary = ordinary_if(&|ordinary| {
            if comes_first(ordinary) {
                progress(work::FIRST, 0.0);
            }
            comes_first(ordinary)
        });
        let turns = drives.iter().any(turns);
        let decides = |ordinary: &Ordinary| {
            let leaves_it_open = || ordinary.verdict(turns) == Verdict::UnknownPhysics;
            ordinary.shakes() || !knows_torque && !leaves_it_open()
        };
        let is_decided = ordinary.as_ref().is_some_and(decides);
        let along =
            |is_asked: bool| cars.as_ref().filter(|_| is_asked).map(|cars| cars.along(&drives, self.library));
        let along_first = along(is_decided);
        // What is left open is what manoeuvres are looked for in the end; hills always are.
        let is_open = |finding: &Finding| !finding.indistinguishable_from.is_empty();
        let climbs = along_first.as_ref().is_some_and(|along| along.grade.is_some());
        let stage = match &ordinary {
            Some(ordinary) if is_decided && (climbs || ordinary.beyond.findings.iter().any(is_open)) => {
                work::BESIDE_OPEN
            }
            _ if is_decided => work::BESIDE,
            _ => work::PLAIN,
        };
        progress(stage, 0.0);
        let free = plain.ordinary(has);
        let suggested = signs_and_swaps::suggested(self.chain);
        let library = |model: &Model<'_>, onsets: &[f64]| library(self.library, model, has, onsets);
        let excerpt = Excerpt::of(&data);
        let search = |plain: &Model<'a>, free: &[Free], progress: &(dyn Fn(&str, f64) + Sync)| {
            if let Some(excerpt) = excerpt.clone() {
                let search = LongSearch { data: &data, plain: (plain, free, &noise), suggested: &suggested };
                return search.select(excerpt, &library, progress);
            }
            let baseline = data.fit_thoroughly(plain, free, &noise);
            let before = signs_and_swaps::taken(&data, plain, &baseline, (free, &noise), &suggested);
            select(&data, (baseline, before), &library, progress)
        };
        let selection = if is_decided {
            let told = |round| progress(stage, (round + 1) as f64 / (PLAIN_ROUNDS + 1) as f64);
            let fitted = data.fit_watched(&plain, &free, &noise, PLAIN_ROUNDS, &told);
            Selection::nothing(fitted, data.split.clone())
        } else {
            let own = search(&plain, &free, progress);
            let again = |plain: &Model<'a>, free: &[Free]| {
                progress(work::AGAIN, 0.0);
                search(plain, free, &|_, _| ())
            };
            let own = or_other_tires(&data, own, |model| model.ordinary(has), again);
            if excerpt.is_some() {
                own
            } else {
                or_disturbed(&data, own, |data, before| {
                    progress(work::DISTURBED, 0.0);
                    select(data, before, &library, &|_, _| ())
                })
            }
        };
        data.split = selection.split.clone();
        if !is_decided {
            progress(work::UNKNOWN, 0.0);
        }
        let sound = selection.chosen.iter().rfind(|taken| taken.candidate.kind.is_all_or_nothing());
        let sound = sound.map_or(&selection.baseline, |taken| &taken.fit);
        let corrected = match excerpt {
            _ if is_decided => selection.baseline.clone(),
            Some(excerpt) => {
                let some = excerpt.drives(&drives);
                let first = correct(&data.over(&some), sound, CORRECTION_ROUNDS);
                data.fit_again(&first, CORRECTION_AGAIN)
            }
            None => correct(&data, sound, CORRECTION_ROUNDS),
        };
        tracing::debug!(noise = ?selection.baseline.noise, "of the plain model");
        tracing::debug!(noise = ?selection.extended.noise, "of the extended model");
        let gains = Gains::of(&data, &selection, &corrected);
        let by_filter = match gains.verdict(turns) {
            _ if is_decided => Verdict::UnknownPhysics,
            // What follows from inputs and motion is no course in time, however well one passes through it.
            Verdict::MissingPhysics
                if selection.is_led_by_time() && ordinary.as_ref().is_some_and(Ordinary::repeats_clearly) =>
            {
                Verdict::UnknownPhysics
            }
            verdict => verdict,
        };
        if by_filter == Verdict::UnknownPhysics && !ordinary.as_ref().is_some_and(comes_first) {
            progress(work::BEYOND, 0.0);
            ordinary = ordinary_if(&|_| true);
        }
        // What the plain model and its effects leave is asked of the ordinary car.
        let decided = ordinary.as_ref().filter(|_| by_filter == Verdict::UnknownPhysics);
        let decided = decided.map(|ordinary| match ordinary.verdict(turns) {
            Verdict::Adequate if !is_decided && (gains.is_restless_along() || gains.misses_along()) => {
                Verdict::UnknownPhysics
            }
            verdict => verdict,
        });
        let along = along_first.or_else(|| along(decided.is_some()));
        let climbs = along.as_ref().is_some_and(|along| along.grade.is_some());
        let decided = decided.map(|verdict| match verdict {
            Verdict::Adequate | Verdict::InsufficientExcitation if climbs => Verdict::MissingPhysics,
            verdict => verdict,
        });
        let verdict = match decided {
            // Then the plain model's own effects say nothing.
            Some(Verdict::MissingPhysics) => Verdict::Adequate,
            Some(decided) => decided,
            None => by_filter,
        };
        tracing::debug!(?gains, ?verdict, "judged");
        progress(if stage == work::BESIDE_OPEN { work::PROVING_OPEN } else { work::PROVING }, 0.0);
        Conclusion {
            case: self,
            drives: &drives,
            data: &data,
            corrected: &corrected,
            ordinary: ordinary.as_ref().map(|ordinary| (ordinary, decided)),
            along: along.as_ref(),
            selection: &selection,
            verdict,
        }
        .answer(usable)
    }
}

/// Rounds of fitting the plain model where it is only compared with. Numerical: Gauss–Newton steps.
const PLAIN_ROUNDS: usize = 6;

/// Noise to begin with; what nobody knows of what drives the car is a course of its own.
fn first_noise(drives: &[GriddedDrive], torque: Torque) -> Noise {
    let noise = Noise::first(drives);
    match torque {
        Torque::Recorded => noise,
        _ => noise.with(Live { size: 1.5, length_s: 1.0, least_s: 0.2, difference: 0.03 }),
    }
}

fn too_little(usable: f64, drives: &[GriddedDrive]) -> Explanation {
    let mut explanation = Explanation::empty(Verdict::InsufficientExcitation);
    // Without any run the sum is −0.
    explanation.seconds = usable + 0.0;
    explanation.used = drives.iter().map(Used::of).collect();
    let there = if usable > 0.0 { format!("only {usable:.0} s") } else { "nothing".to_owned() };
    let advice = format!(
        "{there} of driving above 3 m/s with all inputs could be used; drive for two minutes with curves to both sides, \
         accelerating and braking"
    );
    explanation.to_drive.push(advice.into());
    explanation
}

/// Root mean square of the yaw rate above which a drive turns at all, rad/s. Tuned, no test on record.
const LEAST_TURNING: f64 = 0.01;

fn turns(drive: &GriddedDrive) -> bool {
    let rates = drive.measured.iter().filter(|m| m.channel == Quantity::YawRate as u8);
    let (count, square) = rates.fold((0.0, 0.0), |(n, square), m| (n + 1.0, square + m.value * m.value));
    square > LEAST_TURNING * LEAST_TURNING * count
}
