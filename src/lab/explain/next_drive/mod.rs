//! What to drive next: manoeuvres as the fitted car would drive them, with the errors that these recordings left, and what
//! they would add to what is known.

mod manoeuvres;

use rayon::prelude::*;

use super::case::Case;
use super::ordinary::{Asked, Power, Powers, could_tell};
use super::result::{Chance, Explanation, Finding, ToDrive, full_name};
use super::work;
use manoeuvres::{Manoeuvre, manoeuvres};
use physics::model::effect::Kind;
use predict::Recording;

/// So many manoeuvres are proposed …
const MOST: usize = 2;

/// … of those that add so much to the chance.
const LEAST_ADDED: f64 = 0.05;

impl Case<'_> {
    /// Manoeuvres that would tell what this answer leaves open, the most telling first: findings that could be something
    /// else as well. None where none is, and where none would help.
    pub fn next_drives(
        &self,
        explanation: &Explanation,
        progress: &(dyn Fn(&str, f64) + Sync),
    ) -> Vec<ToDrive> {
        let is_open = |finding: &&Finding| !finding.indistinguishable_from.is_empty();
        let open: Vec<&Finding> = explanation.findings.iter().filter(is_open).collect();
        // Not what somebody's simulation leaves out, nor what changed over many drives.
        if open.is_empty() || explanation.simulation.is_some() || self.in_order {
            return Vec::new();
        }
        progress(work::NEXT_DRIVE, 0.0);
        // What is still possible.
        let is_possible = |kind: &&&Kind| {
            let is = |other: &str| other.split([':', '.']).next() == Some(kind.name);
            open.iter().any(|it| is(&it.effect) || it.indistinguishable_from.iter().any(|other| is(other)))
        };
        let library: Vec<&'static Kind> = self.library.iter().filter(is_possible).copied().collect();
        let said = |chance: Chance| format!("{chance} chance to tell {}", told_apart(&open));
        let proposed = self.proposals(&library, &|powers| chance(powers, &open), &said);
        proposed.map_or(Vec::new(), |(_, proposed)| proposed)
    }

    /// What the drives could tell of these effects, and manoeuvres that add to the chance to tell, the most telling first.
    /// None where the drives do not tell the car itself.
    pub(super) fn proposals(
        &self,
        library: &[&'static Kind],
        chance: &dyn Fn(&Powers) -> Option<f64>,
        said: &dyn Fn(Chance) -> String,
    ) -> Option<(Powers, Vec<ToDrive>)> {
        let all = manoeuvres(self.vehicle, self.recordings.last()?);
        let drive = |it: &Manoeuvre| Recording::simulated(it.name, &it.scenario).ok();
        let planned: Vec<Option<Recording>> = all.par_iter().map(drive).collect();
        let driven = all.into_iter().zip(planned).filter_map(|(manoeuvre, drive)| Some((manoeuvre, drive?)));
        let (all, planned): (Vec<_>, Vec<_>) = driven.unzip();
        let asked = Asked { library, ..self.asked(&|_| true) };
        let (powers, then) = could_tell(self.vehicle, self.effects, self.recordings, &planned, asked)?;
        let now = chance(&powers).unwrap_or(0.0);
        let proposal = |(manoeuvre, powers): (Manoeuvre, Option<Powers>)| {
            let chance = Chance { now, then: chance(&powers?)? };
            let proposal = ToDrive {
                scenario: None,
                words: format!("{}: {}", manoeuvre.words, said(chance)),
                probability_to_tell: Some(chance),
                manoeuvre: Some((manoeuvre.name, Box::new(manoeuvre.scenario))),
            };
            (chance.then > now + LEAST_ADDED).then_some((chance.then, proposal))
        };
        let mut proposed: Vec<(f64, ToDrive)> = all.into_iter().zip(then).filter_map(proposal).collect();
        proposed.sort_by(|a, b| b.0.total_cmp(&a.0));
        Some((powers, proposed.into_iter().take(MOST).map(|(_, proposal)| proposal).collect()))
    }
}

/// How probably these findings are called by their names, in the mean; none where nothing is known of any.
fn chance(powers: &Powers, findings: &[&Finding]) -> Option<f64> {
    let chances: Vec<f64> = findings.iter().filter_map(|finding| of_one(powers, finding)).collect();
    (!chances.is_empty()).then(|| chances.iter().sum::<f64>() / chances.len() as f64)
}

fn of_one(powers: &Powers, finding: &Finding) -> Option<f64> {
    let name = full_name(&finding.effect, finding.channel.as_deref());
    let own = powers.all.iter().filter(|it| it.name == name || it.name.split('.').next() == Some(&*name));
    let size =
        |it: &Power| finding.parameters.get(&it.number).map(|estimate| (estimate.value - it.neutral).abs());
    // Of four wheels that which was found.
    let chances = own.filter_map(|it| Some(it.chance(size(it).filter(|size| *size > 0.0)?)));
    chances.reduce(f64::max)
}

/// "steering lag from relaxation length".
fn told_apart(open: &[&Finding]) -> String {
    let one = |finding: &&Finding| {
        let others: Vec<String> = finding.indistinguishable_from.iter().map(|name| said(name)).collect();
        let name = full_name(&finding.effect, finding.channel.as_deref());
        format!("{} from {}", said(&name), others.join(" and "))
    };
    open.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// `sensor_delay:yaw_rate` in words.
fn said(name: &str) -> String {
    name.replacen(':', " of ", 1).replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::super::bench::{case, recorded_as};
    use super::super::result::{Estimate, Verdict};
    use super::*;
    use physics::model::Simulation;
    use physics::model::effect::named;

    /// GIVEN a drive that hardly turns, and a finding that could be something else WHEN one asks what to drive next THEN it is
    /// a drive that tells more, which the simulation takes.
    #[test]
    #[ignore = "long: a car fitted, and seven drives planned"]
    fn what_is_proposed_tells_more() {
        let (vehicle, recording) = recorded_as("", |scenario| {
            scenario.sensors.by_name.values_mut().for_each(|sensor| sensor.noise_std *= 20.0);
        });
        let recordings = [recording];
        let case = case(&vehicle, &recordings);
        let mut finding = Finding::of(named("steering_lag").unwrap(), None);
        finding.parameters.insert("time_constant_s".into(), Estimate { value: 0.04, std: 0.02 });
        let mut explanation = Explanation::empty(Verdict::MissingPhysics);
        explanation.findings = vec![finding];
        assert_eq!(case.next_drives(&explanation, &|_, _| {}), [], "nothing is open");
        explanation.findings[0].indistinguishable_from =
            vec!["relaxation_length".into(), "sensor_delay:yaw_rate".into()];
        let proposed = case.next_drives(&explanation, &|_, _| {});
        assert!((1..=MOST).contains(&proposed.len()), "{proposed:#?}");
        let chances: Vec<Chance> = proposed.iter().filter_map(|it| it.probability_to_tell).collect();
        assert!(chances.iter().all(|it| it.then > it.now + LEAST_ADDED && it.then <= 1.0), "{chances:?}");
        assert!(chances.is_sorted_by(|a, b| a.then >= b.then), "{chances:?}");
        assert!(
            proposed[0].words.contains("steering lag from relaxation length and sensor delay of yaw rate")
        );
        let (_, scenario) = proposed[0].manoeuvre.as_ref().unwrap();
        assert!(Simulation::new(scenario, 1).is_ok());
    }
}
