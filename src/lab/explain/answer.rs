//! Puts the answer together. It compares the plain model with the extended one: free simulation, prediction,
//! likelihood, numbers.

use std::collections::BTreeMap;

use super::case::Answer;
use super::conclusion::Conclusion;
use super::course::give_means_to_zeros;
use super::disturbed::undisturbed;
use super::doubt;
use super::finding::{finding, leave_banks_open, leave_drift_to_audit, measured_wrong, ranking, told_apart};
use super::fit::Fit;
use super::lateness::against_the_earliest;
use super::locate::{EQUATIONS, Gains, gains, innovations, regimes};
use super::model::{Free, Place};
use super::proof::{self, Comparisons};
use super::result::{
    Block, Driven, Estimate, Explanation, Finding, Missing, Models, Parts, ToDrive, Trace, Verdict, Where,
};
use super::split::Part;
use super::used::Used;
use predict::sums::{Comparison, Innovation};
use predict::{GriddedDrive, grid::COMPARED};

/// The innovations of each drive.
type Innovations = Vec<Vec<Innovation>>;

impl<'a> Conclusion<'_, 'a> {
    /// The answer, of so many usable seconds.
    pub fn answer(self, usable: f64) -> Answer<'a> {
        let baseline = &self.selection.baseline;
        let differing = match self.verdict {
            Verdict::MissingPhysics => &self.selection.extended,
            Verdict::UnknownPhysics => self.corrected,
            Verdict::Adequate | Verdict::Unchanged | Verdict::InsufficientExcitation => baseline,
        };
        let differs = matches!(self.verdict, Verdict::MissingPhysics | Verdict::UnknownPhysics);
        let split = &self.data.split;
        let simulated = |fit| proof::simulate(self.drives, fit);
        let (before, after) = if differs {
            rayon::join(|| simulated(baseline), || simulated(differing))
        } else {
            let before = simulated(baseline);
            (before.clone(), before)
        };
        let mut fits = Models {
            baseline: proof::sums(&before, split).fits(),
            ordinary: None,
            extended: proof::sums(&after, split).fits(),
        };
        // Unknown forces say where something is missing, whether or not they help to simulate.
        let helps = self.verdict != Verdict::UnknownPhysics
            || proof::is_better(&fits.baseline.holdout, &fits.extended.holdout);
        let (extended, after) = if helps { (differing, after) } else { (baseline, before.clone()) };
        if !helps {
            fits.extended = fits.baseline.clone();
        }
        let improvement_ci95 = if differs {
            proof::improvement(&before, &after, split, self.case.seed)
        } else {
            Default::default()
        };
        let unexplained = proof::unexplained(&before, &after, split, &extended.noise.sensor);
        let [baseline_error, extended_error] = [&before, &after].map(|of| proof::sums(of, split).errors());
        let traces = self.traces(&before, &after);
        // Of an hour either of them is a hundred megabytes.
        drop((before, after));
        let (plainly, differently) =
            rayon::join(|| self.innovations(baseline), || differs.then(|| self.innovations(differing)));
        let differently = differently.unwrap_or_else(|| plainly.clone());
        let place = self.place(&plainly, &differently);
        let predicted = proof::sums(&compared(&plainly), split).fits();
        let prediction_fit = Models {
            extended: if helps {
                proof::sums(&compared(&differently), split).fits()
            } else {
                predicted.clone()
            },
            baseline: predicted,
            ordinary: None,
        };
        drop(differently);
        let equations =
            Models { baseline: self.equations(baseline), ordinary: None, extended: self.equations(extended) };

        let mut explanation = Explanation::empty(self.verdict);
        explanation.place = place;
        if let Some(most) =
            equations.baseline.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio)).filter(|_| differs)
        {
            explanation.place.equation.clone_from(&most.equation);
        }
        explanation.findings = self.findings(extended, plainly);
        explanation.ranking = ranking(self.selection);
        explanation.fit = fits;
        explanation.error = Models { baseline: baseline_error, ordinary: None, extended: extended_error };
        explanation.prediction_fit = prediction_fit;
        explanation.log_likelihood = Models {
            baseline: self.likelihood(baseline),
            ordinary: None,
            extended: self.likelihood(extended),
        };
        explanation.improvement_ci95 = improvement_ci95;
        explanation.unexplained = unexplained;
        explanation.parameters =
            Models { baseline: self.numbers(baseline), ordinary: None, extended: self.numbers(extended) };
        explanation.in_doubt = doubt::of_fit(extended, &explanation.parameters.extended);
        explanation.take_axles();
        if let [_] = self.drives {
            give_means_to_zeros(&mut explanation.findings, &mut explanation.parameters.extended);
        }
        explanation.equations = equations;
        explanation.split = self.blocks();
        explanation.used = self.drives.iter().map(Used::of).collect();
        explanation.seconds = usable;
        explanation.traces = traces;
        explanation.vehicle = Some(self.case.vehicle.clone());
        explanation.driven = self.drives.iter().map(Driven::of).collect();
        if let Some((ordinary, decided)) = self.ordinary {
            explanation.take_ordinary(ordinary, decided);
        }
        if let Some(along) = self.along {
            explanation.take_along(along);
        }
        if explanation.is_by_ordinary {
            leave_drift_to_audit(&mut explanation.findings, self.case.chain);
            let wrong =
                measured_wrong(self.case.recordings, self.case.chain, &explanation.findings, |_| true);
            let says_nothing =
                matches!(explanation.verdict, Verdict::Adequate | Verdict::InsufficientExcitation);
            if !wrong.is_empty() && says_nothing {
                explanation.verdict = Verdict::MissingPhysics;
            }
            explanation.findings.splice(0..0, wrong);
            if self.case.references == 0 {
                against_the_earliest(&mut explanation.findings);
            }
        } else {
            let tire = baseline.model.vehicle.tire;
            explanation.tires_bend_as = (tire != self.case.vehicle.tire).then_some(tire);
        }
        leave_banks_open(&mut explanation.findings, self.case.chain);
        explanation.take_chain(self.case.chain);
        explanation.to_drive = self.to_drive(&explanation.findings);
        let keeps = extended.model.own_courses();
        let model = self.drives.first().map_or_else(
            || extended.model.clone(),
            |drive| proof::with_courses(drive, &extended.model, extended, keeps, Default::default()),
        );
        Answer { explanation, model: undisturbed(&model) }
    }

    /// What has a name; each is located by how much better it predicts than what was there before it.
    fn findings(&self, extended: &Fit<'_>, baseline: Innovations) -> Vec<Finding> {
        if self.verdict != Verdict::MissingPhysics {
            return Vec::new();
        }
        let mut earlier = baseline;
        let mut all = Vec::new();
        for (number, taken) in self.selection.chosen.iter().enumerate() {
            let now = self.innovations(&taken.fit);
            all.push(finding(self, number, extended, self.place(&earlier, &now)));
            earlier = now;
        }
        all
    }

    fn innovations(&self, fit: &Fit<'_>) -> Innovations {
        self.drives.iter().map(|drive| innovations(drive, &fit.model, &fit.noise)).collect()
    }

    fn likelihood(&self, fit: &Fit<'_>) -> Parts<f64> {
        let of = |part| -0.5 * self.data.of(part).minus_two_ln(&fit.sums);
        Parts { train: of(Part::Train), holdout: of(Part::Holdout) }
    }

    /// How much each equation misses, against the least there is.
    fn equations(&self, fit: &Fit<'_>) -> Vec<Missing> {
        let ratios = self.data.missing(fit);
        let of = |(place, (equation, unit)): (usize, (&str, &str))| Missing {
            equation: equation.into(),
            unit: unit.into(),
            diffusion: fit.noise.diffusion[place],
            ratio: ratios[place],
        };
        EQUATIONS.into_iter().enumerate().map(of).collect()
    }

    /// Where one model predicts better than another, in the recording with most of it.
    fn place(&self, before: &Innovations, after: &Innovations) -> Where {
        let of = |(drive, (before, after)): (&GriddedDrive, (&Vec<_>, &Vec<_>))| {
            gains(drive.seconds(), before, after)
        };
        let all: Vec<Gains> = self.drives.iter().zip(before.iter().zip(after)).map(of).collect();
        let total = |gains: &Gains| gains.bins.iter().sum::<f64>();
        let most = all.iter().zip(self.drives).max_by(|a, b| total(a.0).total_cmp(&total(b.0)));
        let Some((gains, drive)) = most.filter(|(gains, _)| total(gains) > 1.0) else {
            return Where::default();
        };
        Where {
            channels: gains.clearest(),
            regimes: regimes(drive, gains),
            intervals: gains.intervals(),
            recording: drive.name.clone(),
            ..Where::default()
        }
    }

    /// Ordinary numbers in their units, by name.
    fn numbers(&self, fit: &Fit<'_>) -> BTreeMap<String, Estimate> {
        let of = |(free, variance): (&Free, f64)| {
            let (name, value, slope) = fit.model.ordinary_number(free.place)?;
            Some((name, Estimate { value, std: variance.sqrt() * slope }))
        };
        // Tires without a limit say nothing of how it bends them.
        let is_told = |(free, variance): &(&Free, f64)| {
            free.place != Place::BendAlong || *variance < 0.99 * free.std * free.std
        };
        fit.free.iter().zip(self.data.variances(fit)).filter(is_told).filter_map(of).collect()
    }

    fn to_drive(&self, findings: &[Finding]) -> Vec<ToDrive> {
        let mut all = told_apart(findings);
        if self.verdict == Verdict::InsufficientExcitation {
            all.push(
                "curves to both sides at several speeds, accelerating and braking: hardly anything turned"
                    .into(),
            );
        }
        if self.verdict == Verdict::UnknownPhysics {
            all.push(
                "the same manoeuvre again on another road, and once with slow and once with quick steering: what \
                 comes again is the car, what does not is the road"
                    .into(),
            );
        }
        all
    }

    fn blocks(&self) -> Vec<Block> {
        let of = |(number, drive): (usize, &GriddedDrive)| {
            let blocks = self.data.split.blocks(number, drive.seconds()).into_iter();
            let name = drive.name.clone();
            blocks
                .map(move |(from, to, is_holdout)| Block {
                    t_utc: None,
                    recording: name.clone(),
                    t: [from, to],
                    is_holdout,
                })
                .collect::<Vec<_>>()
        };
        self.drives.iter().enumerate().flat_map(of).collect()
    }

    fn traces(&self, before: &Comparisons, after: &Comparisons) -> Vec<Trace> {
        let mut all = Vec::new();
        for ((drive, before), after) in self.drives.iter().zip(before).zip(after) {
            for channel in COMPARED {
                let of = |comparisons: &Vec<Comparison>| -> Vec<Comparison> {
                    comparisons.iter().filter(|compared| compared.channel == channel as u8).copied().collect()
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

/// Predictions by one step as a simulation's.
fn compared(steps: &Innovations) -> Comparisons {
    let of = |i: &Innovation| Comparison {
        t: i.t,
        channel: i.channel,
        measured: i.value,
        simulated: i.value - i.error,
    };
    steps.iter().map(|steps| steps.iter().map(of).collect()).collect()
}
