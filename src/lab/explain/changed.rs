//! What has changed: what a recording has that healthy drives of the same car have not.

use super::case::{Answer, Case};
use super::chain::{AuditFinding, ChainReport};
use super::finding::{leave_drift_to_audit, measured_wrong, told_apart};
use super::history::History;
use super::model::Model;
use super::ordinary::Ordinary;
use super::put_right::without_drifts;
use super::result::{Explanation, Finding, Verdict};
use super::work;
use predict::Torque;

impl<'a> Case<'a> {
    /// Explains what the recordings have that their references have not. The car's numbers are common to all, and each
    /// drive has its own offsets and delays.
    pub(super) fn changed(&self, progress: &(dyn Fn(&str, f64) + Sync)) -> Answer<'a> {
        progress(work::DRIVES, 0.0);
        let searches = |_: &Ordinary| {
            progress(work::CHANGES, 0.0);
            true
        };
        let recordings = without_drifts(self.recordings, self.chain);
        let ordinary = Ordinary::of(self.vehicle, self.effects, &recordings, self.asked(&searches));
        let model = Model::plain(self.vehicle, Torque::Unknown).with_configured(self.effects);
        let Some(ordinary) = ordinary else {
            let mut explanation = Explanation::empty(Verdict::InsufficientExcitation);
            let why = if self.in_order { TOO_FEW } else { TOO_LITTLE };
            explanation.to_drive.push(why.into());
            explanation.take_chain(self.chain);
            return Answer { explanation, model };
        };
        let used: Vec<String> = ordinary.sideslip.iter().map(|(name, _)| name.clone()).collect();
        let drives = (self.recordings, self.references);
        let history = ordinary.beyond.history.as_ref().map(|found| History::of(drives, &used, found));
        let mut found = ordinary.beyond.findings.clone();
        leave_drift_to_audit(&mut found, self.chain);
        let measured = self.measured_since(&found);
        let verdict = match () {
            () if !ordinary.is_the_car() => Verdict::UnknownPhysics,
            () if history.as_ref().is_some_and(|history| !history.tells()) => Verdict::InsufficientExcitation,
            () if ordinary.beyond.findings.is_empty() && measured.is_empty() => Verdict::Unchanged,
            () => Verdict::MissingPhysics,
        };
        let mut explanation = Explanation::empty(verdict);
        explanation.take_chain(self.chain);
        explanation.seconds = ordinary.seconds;
        explanation.references =
            self.recordings[..self.references].iter().map(|recording| recording.name.clone()).collect();
        explanation.history = history;
        explanation.take_ordinary(&ordinary, Some(verdict));
        leave_drift_to_audit(&mut explanation.findings, self.chain);
        explanation.findings.splice(0..0, measured);
        // The car that drove last.
        for finding in explanation.findings.iter().filter(|finding| finding.reference_value.is_some()) {
            for (name, estimate) in &finding.parameters {
                let all =
                    [Some(&mut explanation.parameters.extended), explanation.parameters.ordinary.as_mut()];
                for number in all.into_iter().flatten().filter_map(|numbers| numbers.get_mut(name)) {
                    *number = *estimate;
                }
            }
        }
        explanation.to_drive = told_apart(&explanation.findings);
        match verdict {
            Verdict::UnknownPhysics => explanation.to_drive.push(ANOTHER_CAR.into()),
            Verdict::InsufficientExcitation => explanation.to_drive.push(TOO_FEW.into()),
            _ => {}
        }
        Answer { explanation, model }
    }

    /// What the audit is certain of in the drives beside the references, and has not seen in these although it could have;
    /// what was found already is left out. Offsets and delays are each drive's own. Of drives in time order only numbers are
    /// told.
    fn measured_since(&self, known: &[Finding]) -> Vec<Finding> {
        let (references, others) = self.chain.split_at(self.references.min(self.chain.len()));
        if self.in_order {
            return Vec::new();
        }
        let is_new = |audited: &AuditFinding| references.iter().all(|report| is_new_since(report, audited));
        measured_wrong(&self.recordings[self.references..], others, known, is_new)
    }
}

/// Is this not in a healthy drive, whose audit could have seen it?
fn is_new_since(healthy: &ChainReport, audited: &AuditFinding) -> bool {
    let could_be_seen = match audited.effect {
        "sensor_bias" | "sensor_delay" => false,
        // A zero that moves moves otherwise in each drive.
        AuditFinding::DRIFT => healthy.drift.is_none(),
        "tire_radius" => healthy.radii.is_some(),
        _ => healthy.compared,
    };
    let is_there = |other: &AuditFinding| {
        let size = |finding: &AuditFinding| finding.value.zip(finding.std);
        let is_another_size = size(other).zip(size(audited)).is_some_and(|((was, was_std), (is, is_std))| {
            (is - was).abs() > ANOTHER_SIZE * was_std.hypot(is_std)
        });
        (other.effect, &other.channel) == (audited.effect, &audited.channel) && !is_another_size
    };
    could_be_seen && !healthy.findings.iter().any(is_there)
}

/// So many standard deviations apart are two sizes. Statistical: once in 16,000.
const ANOTHER_SIZE: f64 = 4.0;

const TOO_LITTLE: &str = "of the references and of the drives beside them at least one each must have steering, yaw rate, \
                          a speed and 12 s of driving above 4 m/s";

const TOO_FEW: &str = "two drives or more with steering, yaw rate, a speed and 12 s of driving above 4 m/s are needed, with \
                       curves in which the car shows what it is";

const ANOTHER_CAR: &str = "nothing was compared: one car with sensors of each drive's own does not predict the yaw rate; \
                           are the references drives of this car, with the same signals?";

#[cfg(test)]
mod tests {
    use super::super::bench::{case, recorded_as};
    use super::super::chain::Confidence;
    use super::*;
    use physics::model::Scenario;
    use physics::model::effect::named;
    use predict::Recording;

    /// What has changed in a drive since a healthy one.
    fn changed(effects: &str, change: impl FnOnce(&mut Scenario)) -> Explanation {
        let (_, healthy) = recorded_as("", |scenario| scenario.seed = 11);
        let (vehicle, recording) = recorded_as(effects, change);
        let recordings = [healthy, recording];
        let case = Case { references: 1, ..case(&vehicle, &recordings) };
        case.explain(&|_, _| {}).explanation
    }

    /// GIVEN what the audit says of a drive WHEN a healthy one's says the same, or could not have seen it THEN it is not new.
    #[test]
    fn what_a_healthy_drive_has_or_could_not_show_is_not_new() {
        let audited = |effect, value| AuditFinding {
            effect,
            channel: "wheel_speed_rl".into(),
            value: Some(value),
            std: Some(1e-4),
            t: 9.0,
            evidence: String::new(),
            confidence: Confidence::Certain,
            repair: String::new(),
            or: Vec::new(),
        };
        let healthy = |radii, findings| ChainReport { radii, compared: true, findings, ..Default::default() };
        let told = Some([1e-4; 2]);
        let small = audited("tire_radius", -0.02);
        assert!(is_new_since(&healthy(told, vec![]), &small));
        assert!(!is_new_since(&healthy(None, vec![]), &small), "the healthy drive did not tell radii");
        assert!(!is_new_since(&healthy(told, vec![audited("tire_radius", -0.0203)]), &small));
        assert!(is_new_since(&healthy(told, vec![audited("tire_radius", -0.01)]), &small));
        assert!(!is_new_since(&healthy(told, vec![]), &audited("sensor_delay", 0.1)), "of each drive's own");
    }

    fn main_number(finding: &Finding, name: &str, truth: f64) {
        let estimate = finding.parameters[name];
        let off = (estimate.value - truth).abs();
        assert!(off < 2.0 * estimate.std.max(0.05 * truth.abs()), "{name}: {estimate:?} for {truth}");
    }

    /// GIVEN three drives in time order, in the last of which a wheel is smaller THEN that is told since there; one drive does
    /// not tell whether it grows.
    #[test]
    #[ignore = "long: a car fitted, and more"]
    fn a_wheel_is_smaller_since_the_last_drive() {
        let wheel = "[[effect]]\nkind = \"tire_radius\"\nrelative_difference_rl = -0.02\n";
        let drive = |name: &str, effects: &str, seed| {
            let (vehicle, recording) = recorded_as(effects, |scenario| scenario.seed = seed);
            (vehicle, Recording { name: name.into(), ..recording })
        };
        let (vehicle, first) = drive("first", "", 11);
        let recordings = [first, drive("second", "", 12).1, drive("third", wheel, 13).1];
        let library: Vec<_> = named("tire_radius").into_iter().collect();
        let case = Case { in_order: true, library: &library, ..case(&vehicle, &recordings) };
        let answer = case.explain(&|_, _| {}).explanation;
        assert_eq!(answer.verdict, Verdict::MissingPhysics, "{:?}", answer.history);
        let history = answer.history.unwrap();
        let change = &history.changes[0];
        assert_eq!((change.parameter.as_str(), change.since.as_str()), ("relative_difference_rl", "third"));
        assert_eq!((history.changes.len(), change.grows), (1, None), "{:?}", history.changes);
        for (value, truth) in change.values.iter().zip([0.0, 0.0, -0.02]) {
            assert!((value.value - truth).abs() < 4.0 * value.std.max(3e-4), "{change:?}");
        }
        let stiffness = history.numbers.iter().find(|it| it.effect == "lateral_stiffness_front").unwrap();
        assert!(stiffness.told_from.is_some_and(|from| from > 0.0), "{stiffness:?}");
    }

    mod by_hand {
        use super::*;

        /// GIVEN a drive with a load in the back THEN that is named first, with its mass.
        #[test]
        #[ignore = "by hand: two cars fitted, minutes"]
        fn a_load_is_named() {
            let load = "[[effect]]\nkind = \"payload\"\nmass_kg = 300\nposition_behind_cg_m = 1.2\n";
            let answer = changed(load, |_| {});
            assert_eq!(answer.verdict, Verdict::MissingPhysics);
            assert_eq!(answer.findings[0].effect, "payload", "{:?}", answer.findings);
            main_number(&answer.findings[0], "mass_kg", 300.0);
        }

        /// GIVEN two drives of the same car THEN nothing has changed.
        #[test]
        #[ignore = "by hand: two cars fitted, minutes"]
        fn a_healthy_drive_is_unchanged() {
            let answer = changed("", |_| {});
            assert_eq!(answer.verdict, Verdict::Unchanged, "{:?}", answer.findings);
        }

        /// GIVEN a drive on other front tires THEN their stiffness is named, with the one before beside it.
        #[test]
        #[ignore = "by hand: two cars fitted, minutes"]
        fn another_stiffness_is_named_with_what_it_was() {
            let answer = changed("", |scenario| scenario.vehicle.lateral_stiffness_front.value = 9.0);
            let first = &answer.findings[0];
            assert_eq!(first.effect, "lateral_stiffness_front", "{:?}", answer.findings);
            main_number(first, "lateral_stiffness_front", 9.0);
            let was = first.reference_value.unwrap();
            assert!((was.value - 11.0).abs() < (3.0 * was.std).max(1.0), "{was:?}");
        }
    }
}
