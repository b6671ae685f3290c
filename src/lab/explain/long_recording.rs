//! The search on a long recording.
//!
//! Causes are searched in an excerpt. Then the model is fitted to the whole recording, judged by it, and compared
//! with its held-out part. A stretch that stays unexplained and is not in the excerpt is added, and the search goes
//! on.

use rayon::prelude::*;

use super::candidates::Candidate;
use super::excerpt::Excerpt;
use super::fit::{Data, Fit, Learn};
use super::held_out::is_confirmed;
use super::model::{Free, Model};
use super::naming::{Refitted, onset};
use super::precedence::prefer_the_simpler;
use super::select::{Round, Selection, following_share, least_evidence, select};
use super::signs_and_swaps;
use super::split::BLOCK_S;
use super::tuning::TUNING;
use super::work;
use predict::GriddedDrive;
use predict::grid::{STEP_S, points};
use predict::noise::Noise;
use predict::sums::BlockSums;

/// Rounds of the plain model's first fit, of fits to a larger excerpt, and of fits to everything.
/// Numerical: Gauss–Newton steps.
const FIRST_ROUNDS: usize = 4;
const AGAIN_ROUNDS: usize = 3;
const EVERYTHING_ROUNDS: usize = 2;

/// What there is to search in.
pub struct LongSearch<'s, 'd, 'a> {
    /// All of the recordings.
    pub data: &'s Data<'d>,
    /// The plain model, what is free in it, and the noise to begin with.
    pub plain: (&'s Model<'a>, &'s [Free], &'s Noise),
    /// Wrong signs and swapped channels that the audit suggests.
    pub suggested: &'s [Candidate],
}

/// What everything says of a selection from an excerpt.
struct Settled<'a> {
    selection: Selection<'a>,
    /// What of it was confirmed, as fitted to the excerpt.
    kept: Vec<Refitted<'a>>,
    /// Something else than in the excerpt won: what was chosen after it does not count.
    is_changed: bool,
}

impl<'a> LongSearch<'_, '_, 'a> {
    /// Chooses by an excerpt, and settles it by everything.
    pub fn select(
        &self,
        mut excerpt: Excerpt,
        library: &impl Fn(&Model<'_>, &[f64]) -> Vec<Candidate>,
        progress: &(dyn Fn(&str, f64) + Sync),
    ) -> Selection<'a> {
        let (plain, free, noise) = self.plain;
        let drives = excerpt.drives(self.data.drives);
        let first = self.data.over(&drives).fit(plain, free, noise, FIRST_ROUNDS);
        excerpt.locate(self.data, &first);
        let drives = excerpt.drives(self.data.drives);
        let part = self.data.over(&drives);
        let baseline = part.fit_thoroughly(&first.model, free, &first.noise);
        let before = signs_and_swaps::taken(&part, plain, &baseline, (free, noise), self.suggested);
        tracing::debug!(share = part.share, "an excerpt is searched");
        let mut selection = select(&part, (baseline, before), library, progress);
        let mut times = 0;
        loop {
            progress(work::EVERYTHING, 0.0);
            let settled = self.settled(&excerpt.drives(self.data.drives), &selection);
            let everything = Data { split: settled.selection.split.clone(), ..self.data.clone() };
            let goes_on = times < TUNING.long.most_enlargements
                && (excerpt.locate(&everything, &settled.selection.extended) || settled.is_changed);
            if !goes_on {
                return settled.selection;
            }
            times += 1;
            let drives = excerpt.drives(self.data.drives);
            let part = Data { split: everything.split.clone(), ..self.data.over(&drives) };
            let again = |fit: &Fit<'a>| part.fit(&fit.model, &fit.free, &fit.noise, AGAIN_ROUNDS);
            let baseline = again(&selection.baseline);
            let kept = settled.kept.into_iter();
            let before = kept.map(|taken| Refitted { fit: again(&taken.fit), ..taken }).collect();
            tracing::debug!(share = part.share, "a larger excerpt is searched");
            let rounds = selection.rounds;
            selection = select(&part, (baseline, before), library, progress);
            // What was tried beside the ones that were kept.
            for (round, tried) in selection.rounds.iter_mut().zip(rounds) {
                if round.scanned.is_empty() {
                    *round = tried;
                }
            }
        }
    }

    /// Fits the plain model and what was chosen to everything, one after the other, and takes what everything
    /// confirms.
    fn settled(&self, drives: &[GriddedDrive], selection: &Selection<'a>) -> Settled<'a> {
        let mut data = Data { split: selection.split.clone(), ..self.data.clone() };
        let to_everything = |data: &Data<'_>, fit: &Fit<'a>| data.fit_again(fit, EVERYTHING_ROUNDS);
        let mut baseline = to_everything(&data, &selection.baseline);
        let mut extended = baseline.clone();
        let (mut chosen, mut kept): (Vec<Refitted<'a>>, Vec<Refitted<'a>>) = (Vec::new(), Vec::new());
        let mut rounds: Vec<Round<'a>> = Vec::new();
        let mut is_changed = false;
        for (taken, round) in selection.chosen.iter().zip(&selection.rounds) {
            let has_no_number = taken.candidate.kind.is_all_or_nothing();
            let mut contenders: Vec<Refitted<'a>> = vec![taken.clone()];
            let rivals = round.refitted.iter().filter(|other| {
                other.candidate.name() != taken.candidate.name()
                    && other.evidence > TUNING.selection.rival_share * taken.evidence
            });
            contenders.extend(
                rivals.take(if has_no_number { 0 } else { TUNING.selection.most_rivals - 1 }).cloned(),
            );
            for contender in &mut contenders {
                self.place_onset(drives, &data, contender);
            }
            if let Some(split) =
                contenders[0].onset().and_then(|at| data.split.released(at, TUNING.selection.onset_s))
            {
                data.split = split;
                baseline = to_everything(&data, &baseline);
                extended = if chosen.is_empty() { baseline.clone() } else { to_everything(&data, &extended) };
                for contender in &mut contenders {
                    self.place_onset(drives, &data, contender);
                }
            }
            let mut fitted: Vec<Refitted<'a>> = contenders
                .par_iter()
                .map(|contender| {
                    let of = |fit: Fit<'a>| judged(&extended, &contender.candidate, fit);
                    let first = of(to_everything(&data, &contender.fit));
                    if first.evidence > contender.evidence || has_no_number {
                        return first;
                    }
                    // The excerpt's numbers may lead astray: from those of everything without it, too.
                    let second = of(beside(&data, &extended, contender));
                    if second.evidence > first.evidence { second } else { first }
                })
                .collect();
            fitted.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
            prefer_the_simpler(&mut fitted);
            fitted.retain(|refitted| {
                let is_own = |share| share <= TUNING.selection.most_following;
                has_no_number || following_share(&data, refitted).is_none_or(is_own)
            });
            let Some(first) = fitted.first().cloned() else { break };
            let least = least_evidence(1.0, &chosen);
            let confirmed = has_no_number
                || first.evidence > least && is_confirmed(&data, &extended, &first, !chosen.is_empty());
            tracing::debug!(
                name = first.candidate.name(),
                in_excerpt = taken.evidence,
                evidence = first.evidence,
                confirmed,
                numbers = ?first.fit.model.effects.last().map(|effect| effect.values()),
                "on everything"
            );
            rounds.push(as_on_everything(round, &fitted));
            if !confirmed {
                break;
            }
            is_changed = first.candidate.name() != taken.candidate.name();
            let of_excerpt =
                contenders.into_iter().find(|other| other.candidate.name() == first.candidate.name());
            kept.extend(of_excerpt);
            extended = first.fit.clone();
            chosen.push(first);
            if is_changed {
                break;
            }
        }
        let rest = selection.rounds.iter().skip(rounds.len()).cloned();
        rounds.extend(rest.collect::<Vec<_>>());
        let selection = Selection { baseline, extended, chosen, rounds, split: data.split };
        Settled { selection, kept, is_changed }
    }

    /// Puts the moment at which something began where everything around it says: an excerpt may not have it.
    fn place_onset(&self, drives: &[GriddedDrive], data: &Data<'_>, refitted: &mut Refitted<'a>) {
        let Some((at, place)) = refitted.onset().zip(refitted.candidate.kind.onset()) else {
            return;
        };
        let (from, to) = gap_around(drives, at);
        let cut: Vec<GriddedDrive> = data
            .drives
            .iter()
            .map(|drive| {
                drive.within(&[(
                    points((from - TUNING.long.around_s).max(0.0)),
                    points(to + TUNING.long.around_s),
                )])
            })
            .collect();
        let around = data.over(&cut);
        let effect = refitted.fit.model.effects.len() - 1;
        let noise = refitted.fit.noise.clone();
        let at_moment = |model: &Model<'a>, at: f64| {
            let mut model = model.clone();
            model.effects[effect].numbers[place] = at;
            let sums = around.pass(&model, &[], &noise);
            (model, sums)
        };
        let mut model = refitted.fit.model.clone();
        if to > from {
            // Before the moment as if it had not begun, after it as if it had all along.
            let ((_, always), (_, never)) = (at_moment(&model, from), at_moment(&model, to));
            let cost = |sum: &BlockSums| sum.log_s + sum.square.iter().sum::<f64>();
            let gains = around.counted(&always).zip(around.counted(&never));
            let mut gains: Vec<(f64, f64)> =
                gains.map(|(always, never)| (always.t.1, cost(never) - cost(always))).collect();
            gains.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (mut sum, mut best) = (0.0, (0.0, from));
            for (t, gain) in gains.into_iter().filter(|(t, _)| *t > from && *t < to) {
                sum += gain;
                if sum < best.0 {
                    best = (sum, t);
                }
            }
            model = at_moment(&model, best.1).0;
        }
        let (_, sums) = at_moment(&model, model.effects[effect].numbers[place]);
        let fit = Fit { minus_two_ln: around.minus_two_ln(&sums), model, ..refitted.fit.clone() };
        let near = Refitted { fit, ..refitted.clone() };
        let model = near.begun_within(&around, BLOCK_S);
        let minus_two_ln = around.minus_two_ln(&around.pass(&model, &[], &noise));
        let near = Fit { minus_two_ln, model, ..refitted.fit.clone() };
        refitted.fit.model = onset(&around, &near, effect, place);
    }
}

/// The stretch, s, in which an onset could be as well, as far as an excerpt says.
fn gap_around(drives: &[GriddedDrive], at: f64) -> (f64, f64) {
    let (mut from, mut to) = (at, at);
    for drive in drives {
        let ends = drive.runs.iter().map(|(_, to)| *to as f64 * STEP_S);
        let begins = drive.runs.iter().map(|(from, _)| *from as f64 * STEP_S);
        let before = ends.filter(|end| *end < at + TUNING.long.near_s).fold(0.0, f64::max);
        let after = begins.filter(|begin| *begin > at - TUNING.long.near_s).fold(drive.seconds(), f64::min);
        let is_in_run =
            drive.runs.iter().any(|run| (run.0 as f64 * STEP_S..run.1 as f64 * STEP_S).contains(&at));
        let is_near = (before - at).abs() < TUNING.long.near_s || (after - at).abs() < TUNING.long.near_s;
        if !is_in_run || is_near {
            (from, to) = (from.min(before), to.max(after));
        }
    }
    (from, to)
}

/// Fits what was chosen in an excerpt to everything, beside what everything says of the rest.
fn beside<'a>(data: &Data<'_>, extended: &Fit<'a>, chosen: &Refitted<'a>) -> Fit<'a> {
    let mut model = extended.model.clone();
    model.effects.extend(chosen.fit.model.effects.last().cloned());
    let mut noise = extended.noise.clone();
    if chosen.candidate.live.is_some() {
        noise.live.extend(chosen.fit.noise.live.last());
    }
    data.search(&model, &chosen.fit.free, &noise, EVERYTHING_ROUNDS, Learn::Rest)
}

/// A fit to everything, judged; a wrong sign has no number.
fn judged<'a>(before: &Fit<'_>, candidate: &Candidate, fit: Fit<'a>) -> Refitted<'a> {
    if candidate.kind.is_all_or_nothing() {
        let evidence = before.cost() - fit.cost();
        return Refitted { candidate: candidate.clone(), fit, evidence, follows: None };
    }
    Refitted::new(before, candidate.clone(), fit)
}

/// A round with what of it was fitted to everything; what was only fitted to the excerpt has as much evidence as there
/// would be, were everything like the excerpt.
fn as_on_everything<'a>(round: &Round<'a>, fitted: &[Refitted<'a>]) -> Round<'a> {
    let mut round = round.clone();
    let find = |name: &str| fitted.iter().find(|other| other.candidate.name() == name);
    let known =
        |refitted: &Refitted<'a>| Some((refitted.evidence, find(&refitted.candidate.name())?.evidence));
    let scale = round.refitted.iter().find_map(known).map_or(1.0, |(part, all)| (all / part).max(1.0));
    for refitted in &mut round.refitted {
        match find(&refitted.candidate.name()) {
            Some(other) => *refitted = other.clone(),
            None => refitted.evidence *= scale,
        }
    }
    for scored in &mut round.scanned {
        scored.gain *= scale;
    }
    for (_, evidence) in &mut round.following {
        *evidence *= scale;
    }
    round.refitted.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    round
}
