//! The whole job, from recordings to an answer.

use std::collections::BTreeMap;

use super::chain::ChainReport;
use super::correction::correct;
use super::fit::{Data, Fit};
use super::gross;
use super::locate::{EQUATIONS, Gains, gains, innovations, merged, regimes};
use super::model::{Model, Place};
use super::naming::Refitted;
use super::predict::noise::{Live, Noise};
use super::predict::{Drive, Recording, drive::COMPARED, drive::STEP_S};
use super::proof::{self, Saids};
use super::result;
use super::result::{
    Block, Estimate, Explanation, Finding, Missing, Models, Parts, Ranked, Trace, Verdict, Where,
};
use super::select::{Selection, select};
use super::smooth::{Smoothed, courses};
use super::split::{Part, Split};
use crate::Quantity;
use crate::model::Vehicle;
use crate::model::effect::{Course, EffectConfig};

/// What there is to explain.
#[derive(Debug)]
pub struct Case<'a> {
    /// The car, with what is uncertain of it.
    pub vehicle: &'a Vehicle,
    /// Effects that the configuration switches on: they belong to the plain model here.
    pub effects: &'a [EffectConfig],
    /// Recordings, the held-out ones last.
    pub recordings: &'a [Recording],
    /// How many of them the user has set apart.
    pub held_out: usize,
    /// What the audit of the measurement chain says of each.
    pub chain: &'a [ChainReport],
    /// For what is drawn at random.
    pub seed: u64,
}

/// An answer with the model it speaks of.
#[derive(Debug)]
pub struct Answer<'a> {
    /// The answer.
    pub explanation: Explanation,
    /// The extended model, with its courses smoothed over all readings of the first recording.
    pub model: Model<'a>,
}

/// So much of the unknown forces' gain must have a name; else what is missing is unknown.
const LEAST_EXPLAINED: f64 = 0.4;

/// Gain of the unknown forces, twice the log-likelihood ratio, below which nothing is missing.
const LEAST_MISSING: f64 = 45.0;

/// Seconds that must be usable.
const LEAST_SECONDS: f64 = 15.0;

impl<'a> Case<'a> {
    /// Explains. `progress` is told the stage and how far it is.
    pub fn explain(&self, progress: &(dyn Fn(&str, f64) + Sync)) -> Answer<'a> {
        let drives: Vec<Drive> =
            self.recordings.iter().map(|recording| Drive::new(recording, self.vehicle)).collect();
        let has = |quantity: Quantity| self.recordings.iter().any(|recording| recording.has(quantity));
        let knows_torque = drives.iter().all(|drive| drive.knows_torque);
        let split = Split::new(&drives, self.held_out);
        let noise = first_noise(&drives, knows_torque);
        let data = Data { drives: &drives, split: &split, part: Part::Train, own_noise: noise.clone() };
        let plain = Model::plain(self.vehicle, knows_torque).with_configured(self.effects);
        let usable: f64 =
            drives.iter().flat_map(|d| &d.runs).map(|(from, to)| (to - from) as f64 * STEP_S).sum();
        if usable < LEAST_SECONDS {
            return Answer { explanation: too_little(usable), model: plain };
        }
        progress("fitting the plain model", 0.0);
        let free = plain.ordinary(has);

        let baseline = data.fit_thoroughly(&plain, &free, &noise);
        let before = gross::taken(&data, &plain, &baseline, (&free, &noise), &gross::suggested(self.chain));
        progress("what could be explained", 0.0);
        let corrected = correct(&data, before.last().map_or(&baseline, |taken| &taken.fit), 4);
        let seconds = drives.iter().map(Drive::seconds).fold(0.0, f64::max);
        let selection = select(&data, (baseline, before), &has, seconds, progress);
        progress("proving", 0.0);
        Judge { case: self, drives: &drives, split: &split, data: &data, corrected, selection }.answer(usable)
    }
}

/// Noise to begin with; where nobody knows what drives the car, that is a course of its own.
fn first_noise(drives: &[Drive], knows_torque: bool) -> Noise {
    let noise = Noise::first(drives);
    if knows_torque {
        return noise;
    }
    noise.with(Live { size: 1.5, length_s: 1.0, least_s: 0.2, difference: 0.03 })
}

fn too_little(usable: f64) -> Explanation {
    let mut explanation = Explanation::empty(Verdict::InsufficientExcitation);
    explanation.seconds = usable;
    explanation.to_drive.push(format!(
        "only {usable:.0} s of driving above 3 m/s with all inputs could be used; drive for two minutes with curves \
         to both sides, accelerating and braking"
    ));
    explanation
}

/// Everything that an answer is made of.
struct Judge<'c, 'a> {
    case: &'c Case<'a>,
    drives: &'c [Drive],
    split: &'c Split,
    data: &'c Data<'c>,
    corrected: Fit<'a>,
    selection: Selection<'a>,
}

impl<'a> Judge<'_, 'a> {
    fn answer(self, usable: f64) -> Answer<'a> {
        let selection = &self.selection;
        let cost = |fit: &Fit<'_>| fit.minus_two_ln + fit.prior;
        // What unknown forces explain, or a course that had to be refused.
        let following = selection.rounds.iter().take(1).flat_map(|round| &round.following);
        let refused = following.map(|(_, evidence)| *evidence).fold(0.0, f64::max);
        let missing = (cost(&selection.baseline) - cost(&self.corrected) - 24.0).max(refused);
        let explained = cost(&selection.baseline) - cost(&selection.extended);
        let mut verdict = match selection.chosen.is_empty() {
            false if explained > LEAST_EXPLAINED * missing => Verdict::MissingPhysics,
            false => Verdict::UnknownPhysics,
            true if missing > LEAST_MISSING => Verdict::UnknownPhysics,
            true => Verdict::Adequate,
        };
        if verdict == Verdict::Adequate && !self.is_excited() {
            verdict = Verdict::InsufficientExcitation;
        }
        tracing::info!(missing, explained, ?verdict, "judged");
        let extended = match verdict {
            Verdict::MissingPhysics => &selection.extended,
            Verdict::UnknownPhysics => &self.corrected,
            _ => &selection.baseline,
        };
        let before = proof::simulate(self.drives, &selection.baseline);
        let after = match verdict {
            Verdict::MissingPhysics | Verdict::UnknownPhysics => proof::simulate(self.drives, extended),
            _ => before.clone(),
        };
        let place = self.place(&selection.baseline, extended);
        let mut findings = Vec::new();
        if verdict == Verdict::MissingPhysics {
            let mut earlier = &selection.baseline;
            for (number, (taken, _)) in selection.chosen.iter().enumerate() {
                findings.push(self.finding(number, taken, earlier, extended));
                earlier = &taken.fit;
            }
        }
        let mut explanation = Explanation::empty(verdict);
        explanation.ranking = self.ranking();
        explanation.fit =
            Models { baseline: proof::fits(&before, self.split), extended: proof::fits(&after, self.split) };
        explanation.prediction_fit = Models {
            baseline: self.prediction_fit(&selection.baseline),
            extended: self.prediction_fit(extended),
        };
        explanation.log_likelihood =
            Models { baseline: self.likelihood(&selection.baseline), extended: self.likelihood(extended) };
        if !matches!(verdict, Verdict::Adequate | Verdict::InsufficientExcitation) {
            explanation.improvement_ci95 = proof::improvement(&before, &after, self.split, self.case.seed);
        }
        explanation.unexplained = proof::unexplained(&before, &after, self.split, &extended.noise.sensor);
        explanation.parameters =
            Models { baseline: numbers(&selection.baseline), extended: numbers(extended) };
        explanation.equations =
            Models { baseline: self.equations(&selection.baseline), extended: self.equations(extended) };
        explanation.to_drive = self.to_drive(&findings, verdict);
        explanation.findings = findings;
        explanation.place = place;
        explanation.measurement_chain = self.case.chain.iter().flat_map(chain_words).collect();
        explanation.split = self.blocks();
        explanation.seconds = usable;
        explanation.traces = self.traces(&before, &after);
        let keeps = usize::from(!extended.model.knows_torque);
        let model = self.drives.first().map_or_else(
            || extended.model.clone(),
            |drive| proof::told(drive, &extended.model, extended, keeps, Default::default()),
        );
        Answer { explanation, model }
    }

    /// Did the drive turn at all?
    fn is_excited(&self) -> bool {
        let turns = self.drives.iter().flat_map(|drive| {
            drive.measured.iter().filter(|m| m.channel == Quantity::YawRate as u8).map(|m| m.value)
        });
        let (mut count, mut square) = (0.0, 0.0);
        for turn in turns {
            count += 1.0;
            square += turn * turn;
        }
        count > 0.0 && (square / count).sqrt() > 0.01
    }

    fn likelihood(&self, fit: &Fit<'_>) -> Parts<f64> {
        let of = |part| -0.5 * self.data.of(part).minus_two_ln(&fit.sums);
        Parts { train: of(Part::Train), holdout: of(Part::Holdout) }
    }

    /// Fit of predictions by one step, %.
    fn prediction_fit(&self, fit: &Fit<'_>) -> Parts<result::ByChannel> {
        let saids: Saids = self
            .drives
            .iter()
            .map(|drive| {
                let all = innovations(drive, &fit.model, &fit.noise);
                all.into_iter()
                    .map(|i| super::predict::free::Said {
                        t: i.t,
                        channel: i.channel,
                        measured: i.value,
                        simulated: i.value - i.error,
                    })
                    .collect()
            })
            .collect();
        proof::fits(&saids, self.split)
    }

    /// How much each equation misses, against the least there is.
    fn equations(&self, fit: &Fit<'_>) -> Vec<Missing> {
        let of = |(place, (equation, unit)): (usize, (&str, &str))| {
            let mut noise = fit.noise.clone();
            noise.diffusion[place] = Noise::LEAST_DIFFUSION[place];
            let without = self.data.minus_two_ln(&self.data.pass(&fit.model, &[], &noise));
            Missing {
                equation: equation.into(),
                unit: unit.into(),
                diffusion: fit.noise.diffusion[place],
                ratio: (without - fit.minus_two_ln).max(0.0),
            }
        };
        EQUATIONS.into_iter().enumerate().map(of).collect()
    }

    fn gains(&self, before: &Fit<'_>, after: &Fit<'_>) -> Vec<Gains> {
        let of = |drive: &Drive| {
            let before = innovations(drive, &before.model, &before.noise);
            let after = innovations(drive, &after.model, &after.noise);
            gains(drive.seconds(), &before, &after)
        };
        self.drives.iter().map(of).collect()
    }

    /// The mismatch as a whole: the recording with most of it.
    fn place(&self, before: &Fit<'_>, after: &Fit<'_>) -> Where {
        let all = self.gains(before, after);
        let total = |gains: &Gains| gains.bins.iter().sum::<f64>();
        let most = all.iter().zip(self.drives).max_by(|a, b| total(a.0).total_cmp(&total(b.0)));
        let Some((gains, drive)) = most.filter(|(gains, _)| total(gains) > 1.0) else {
            return Where::default();
        };
        let equations = self.equations(before);
        let equation = equations.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
        Where {
            equation: equation.map_or(String::new(), |missing| missing.equation.clone()),
            channels: gains.clearest(),
            regimes: regimes(drive, gains),
            intervals: gains.intervals(),
            recording: drive.name.clone(),
        }
    }

    fn finding(&self, number: usize, taken: &Refitted<'a>, earlier: &Fit<'a>, extended: &Fit<'a>) -> Finding {
        let candidate = &taken.candidate;
        let round = &self.selection.rounds[number];
        let weight = |evidence: f64| (0.5 * (evidence - taken.evidence)).clamp(-700.0, 700.0).exp();
        let all: f64 = round.refitted.iter().map(|other| weight(other.evidence)).sum::<f64>() + weight(0.0);
        let rivals = round.refitted.iter().filter(|other| {
            other.evidence > taken.evidence - 7.0 && other.candidate.name() != candidate.name()
        });
        let mut place = self.place(earlier, &taken.fit);
        place.equation = match candidate.channel {
            Some(channel) => format!("{}: {channel}", candidate.kind.place),
            None => candidate.kind.place.into(),
        };
        let place_of_effect = self.case.effects.len() + number;
        let number = place_of_effect;
        let mut parameters = own_numbers(extended, number);
        let mut series = None;
        if candidate.live.is_some()
            && let Some((drive, course)) = self.course(number, extended, &place.recording)
        {
            place.intervals = clear_stretches(&course);
            place.recording.clone_from(&drive.name);
            summarize(candidate, extended, number, &course, &mut parameters);
            series = Some(decimated(&course, candidate));
        } else if let Some(at) = candidate
            .kind
            .place_of("at_s")
            .and_then(|place| Some(extended.model.effects.get(number)?.numbers[place]).filter(|at| *at > 0.0))
        {
            place.intervals = vec![[at, self.drives.first().map_or(at, Drive::seconds)]];
        }
        Finding {
            effect: candidate.kind.name.into(),
            channel: candidate.channel.map(|channel| channel.to_string()),
            probability: weight(taken.evidence) / all.max(1.0),
            indistinguishable_from: rivals.map(|other| other.candidate.name()).collect(),
            to_tell_apart: candidate.kind.to_tell_apart.into(),
            parameters,
            series,
            place,
            about: candidate.kind.about.into(),
            equation: candidate.kind.equation.into(),
            evidence: taken.evidence,
        }
    }

    /// The course of a chosen effect, in the recording where it is clearest.
    fn course(&self, number: usize, fit: &Fit<'_>, recording: &str) -> Option<(&Drive, Smoothed)> {
        let Course::Live(slot) = fit.model.effects.get(number)?.course else { return None };
        let drive = self.drives.iter().find(|drive| drive.name == recording).or(self.drives.first())?;
        let course = courses(drive, &fit.model, &fit.noise, Default::default()).into_iter().nth(slot)?;
        Some((drive, course))
    }

    fn ranking(&self) -> Vec<Ranked> {
        let mut ranking = Vec::new();
        let mut seen = std::collections::BTreeSet::new();
        let Some(round) = self.selection.rounds.first() else { return ranking };
        for other in &round.refitted {
            if seen.insert(other.candidate.name()) {
                ranking.push(Ranked {
                    effect: other.candidate.kind.name.into(),
                    channel: other.candidate.channel.map(|channel| channel.to_string()),
                    score: other.evidence,
                    refitted: true,
                });
            }
        }
        for other in &round.scanned {
            let follows =
                round.following.iter().any(|(candidate, _)| candidate.name() == other.candidate.name());
            if !follows && seen.insert(other.candidate.name()) {
                let least = ranking.last().map_or(f64::INFINITY, |last: &Ranked| last.score);
                ranking.push(Ranked {
                    effect: other.candidate.kind.name.into(),
                    channel: other.candidate.channel.map(|channel| channel.to_string()),
                    score: other.gain.min(least),
                    refitted: false,
                });
            }
        }
        ranking
    }

    fn to_drive(&self, findings: &[Finding], verdict: Verdict) -> Vec<String> {
        let mut all: Vec<String> = findings
            .iter()
            .filter(|finding| !finding.indistinguishable_from.is_empty())
            .map(|finding| finding.to_tell_apart.clone())
            .collect();
        if verdict == Verdict::InsufficientExcitation {
            all.push(
                "curves to both sides at several speeds, accelerating and braking: hardly anything turned"
                    .into(),
            );
        }
        if verdict == Verdict::UnknownPhysics {
            all.push(
                "the same manoeuvre again on another road, and once with slow and once with quick steering: what \
                 comes again is the car, what does not is the road"
                    .into(),
            );
        }
        all
    }

    fn blocks(&self) -> Vec<Block> {
        let of = |(number, drive): (usize, &Drive)| {
            let blocks = self.split.blocks(number, drive.seconds()).into_iter();
            let name = drive.name.clone();
            blocks
                .map(move |(from, to, is_holdout)| Block {
                    recording: name.clone(),
                    t: [from, to],
                    is_holdout,
                })
                .collect::<Vec<_>>()
        };
        self.drives.iter().enumerate().flat_map(of).collect()
    }

    fn traces(&self, before: &Saids, after: &Saids) -> Vec<Trace> {
        let mut all = Vec::new();
        for ((drive, before), after) in self.drives.iter().zip(before).zip(after) {
            for channel in COMPARED {
                let of = |saids: &Vec<super::predict::free::Said>| -> Vec<super::predict::free::Said> {
                    saids.iter().filter(|said| said.channel == channel as u8).copied().collect()
                };
                let (before, after) = (of(before), of(after));
                if before.len() < 20 || before.len() != after.len() {
                    continue;
                }
                // Twenty points a second are more than a page can show.
                let every = (before.len() as f64 / (drive.seconds() * 20.0)).ceil().max(1.0) as usize;
                let some = || before.iter().zip(&after).step_by(every);
                all.push(Trace {
                    recording: drive.name.clone(),
                    channel: channel.name().into(),
                    unit: channel.unit().into(),
                    t: some().map(|(b, _)| b.t).collect(),
                    measured: some().map(|(b, _)| b.measured).collect(),
                    baseline: some().map(|(b, _)| b.simulated).collect(),
                    extended: some().map(|(_, a)| a.simulated).collect(),
                });
            }
        }
        all
    }
}

/// What an audit found, a line each.
fn chain_words(report: &ChainReport) -> Vec<String> {
    let line = |finding: &super::chain::Finding| {
        let confidence = format!("{:?}", finding.confidence).to_lowercase();
        let value =
            finding.value.zip(finding.std).map_or(String::new(), |(v, s)| format!(" {v:.3} ± {s:.3}"));
        format!("{} of {}{value}, {confidence}: {}", finding.effect, finding.channel, finding.evidence)
    };
    report.findings.iter().map(line).collect()
}

/// Ordinary numbers in their units, by name.
fn numbers(fit: &Fit<'_>) -> BTreeMap<String, Estimate> {
    let of = |(place, free): (usize, &super::model::Free)| {
        let std = fit.covariance.get((place, place)).copied().unwrap_or(0.0).sqrt();
        let (name, value, slope) = fit.model.ordinary_number(free.place)?;
        Some((name, Estimate { value, std: std * slope }))
    };
    fit.free.iter().enumerate().filter_map(of).collect()
}

/// Numbers of one of the effects, by name.
fn own_numbers(fit: &Fit<'_>, number: usize) -> BTreeMap<String, Estimate> {
    let Some(chosen) = fit.model.effects.get(number) else { return BTreeMap::new() };
    let of = |(place, spec): (usize, crate::model::effect::Spec)| {
        let coordinate = chosen.numbers[place];
        let free = fit.free.iter().position(|free| free.place == Place::Effect(number, place));
        let variance = free.and_then(|free| fit.covariance.get((free, free)).copied());
        let fixed = free.is_none();
        // What is not searched and has nothing to say is left out.
        if fixed && spec.name != "at_s" {
            return None;
        }
        let std = variance.unwrap_or(0.0).sqrt() * spec.scale.slope(coordinate).abs();
        Some((spec.name.to_owned(), Estimate { value: spec.value(coordinate), std }))
    };
    chosen.specs().enumerate().filter_map(of).collect()
}

/// Where a course is clearly not nothing, s.
fn clear_stretches(course: &Smoothed) -> Vec<[f64; 2]> {
    let peak = course.value.iter().map(|value| value.abs()).fold(0.0, f64::max);
    let first = course.t.first().copied().unwrap_or(0.0);
    let is_in: Vec<bool> = course
        .value
        .iter()
        .zip(&course.std)
        .map(|(value, std)| value.abs() > (0.2 * peak).max(2.0 * std))
        .collect();
    let mut stretches = merged(&is_in, STEP_S, 30);
    for stretch in &mut stretches {
        stretch[0] += first;
        stretch[1] += first;
    }
    stretches.retain(|[from, to]| to - from > 0.15);
    stretches
}

/// What a course comes to in one number, under the contract's name.
fn summarize(
    candidate: &super::candidates::Candidate,
    fit: &Fit<'_>,
    number: usize,
    course: &Smoothed,
    parameters: &mut BTreeMap<String, Estimate>,
) {
    let Some(surroundings) = candidate.kind.surroundings(candidate.channel) else { return };
    let place_of_peak = course.value.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let Some((peak_at, peak)) = place_of_peak.map(|(at, value)| (at, *value)) else { return };
    if surroundings.sign != 0.0 {
        // A share of a surface: what the surface is where there is most of it.
        let Some(chosen) = fit.model.effects.get(number) else { return };
        for (place, spec) in chosen.specs().enumerate() {
            if chosen.numbers[place] == spec.mean {
                continue;
            }
            let coordinate = spec.mean + peak * (chosen.numbers[place] - spec.mean);
            let std = course.std[peak_at] * (chosen.numbers[place] - spec.mean).abs();
            let slope = spec.scale.slope(coordinate).abs();
            parameters.insert(spec.name.into(), Estimate { value: spec.value(coordinate), std: std * slope });
        }
        return;
    }
    let (value, std) = if surroundings.rms_name.contains("peak") {
        (peak.abs(), course.std[peak_at])
    } else {
        let count = course.value.len().max(1) as f64;
        let square = course.value.iter().map(|value| value * value).sum::<f64>() / count;
        let variance = course.std.iter().map(|std| std * std).sum::<f64>() / count;
        (square.sqrt(), (variance / count.sqrt().max(1.0)).sqrt())
    };
    parameters.insert(surroundings.rms_name.into(), Estimate { value, std });
}

/// Ten points a second.
fn decimated(course: &Smoothed, candidate: &super::candidates::Candidate) -> result::Course {
    let unit = candidate.kind.surroundings(candidate.channel).map_or("", |course| course.unit);
    let some = |values: &[f64]| values.iter().step_by(10).copied().collect();
    result::Course {
        t: some(&course.t),
        value: some(&course.value),
        std: some(&course.std),
        unit: unit.into(),
    }
}
