//! Delays between channels, attributed to one channel.

use nalgebra::DMatrix;

use super::attribution::{AHEAD, Cause, Evidence, FOUND, SURE, SUSPECTED, attribute};
use super::bank::without_banks;
use super::relations::{Link, Relation, link};
use super::report::{AuditFinding, ChainReport, Confidence};
use super::sensor_group::SensorGroup;
use super::series::Series;
use super::tuning::TUNING;

/// Wheel speeds are averages over some teeth and so late by this, ± this, s. Physical.
const WHEELS_LATE_S: f64 = 0.008;
const WHEELS_LATE_STD_S: f64 = 0.007;
/// Messages have their own periods and phases: no relation is better than this, s.
/// Physical: periods of 10 ms are out of phase by ± 3 ms.
const PHASES_S: f64 = 0.004;

impl SensorGroup {
    /// How a relation's delay changes with this channel's.
    fn sense(self, relation: Relation) -> f64 {
        match (self, relation) {
            (Self::Wheels, Relation::RearWheels | Relation::FrontWheels)
            | (Self::Lateral, Relation::Lateral)
            | (Self::Steering, Relation::Steering)
            | (Self::Longitudinal, Relation::Longitudinal) => 1.0,
            (Self::Wheels, Relation::Longitudinal) => -1.0,
            (Self::Yaw, Relation::Longitudinal) => 0.0,
            (Self::Yaw, _) => -1.0,
            _ => 0.0,
        }
    }
}

/// Finds the channel that is late; returns the delay of each relation.
pub(super) fn delays(series: &Series, report: &mut ChainReport) -> Vec<Link> {
    let links: Vec<Link> = Relation::ALL.into_iter().filter_map(|r| link(series, r)).collect();
    let told = |link: &Link| link.is_clear && link.delay.is_finite() && link.explained > TUNING.told_late;
    let links: Vec<Link> = links.into_iter().filter(told).collect();
    let links = without_banks(series, links, report);
    for link in &links {
        if let Some(entry) = report.relations.iter_mut().find(|entry| entry.relation == link.relation.name())
        {
            (entry.delay_s, entry.delay_std) = (Some(link.delay), Some(link.delay_std));
        }
    }
    let mut known = [0.0; SensorGroup::ALL.len()];
    for _ in 0..2 {
        let Some((channel, delay)) = next_delay(series, &links, &known, report) else { break };
        known[channel as usize] += delay;
    }
    links
}

fn next_delay(
    series: &Series,
    links: &[Link],
    known: &[f64; SensorGroup::ALL.len()],
    report: &mut ChainReport,
) -> Option<(SensorGroup, f64)> {
    let expected = |relation: Relation| {
        let known: f64 = SensorGroup::ALL.iter().map(|c| c.sense(relation) * known[*c as usize]).sum();
        known + WHEELS_LATE_S * SensorGroup::Wheels.sense(relation)
    };
    let evidence = Evidence {
        seen: links.iter().map(|link| link.delay - expected(link.relation)).collect(),
        covariance: DMatrix::from_fn(links.len(), links.len(), |i, j| {
            let (a, b) = (&links[i], &links[j]);
            let own = if i == j { (a.widened() * a.delay_std).powi(2) + PHASES_S.powi(2) } else { 0.0 };
            own + WHEELS_LATE_STD_S.powi(2)
                * SensorGroup::Wheels.sense(a.relation)
                * SensorGroup::Wheels.sense(b.relation)
        }),
    };
    let causes: Vec<Cause<SensorGroup>> = SensorGroup::ALL
        .into_iter()
        .map(|channel| Cause {
            channel,
            pattern: links.iter().map(|link| channel.sense(link.relation)).collect(),
        })
        .collect();
    let (_, mut explanations) = attribute(&evidence, &causes)?;
    // Nothing is early: a channel that seems so means that all others are late, and one cause is more likely than several.
    for early in explanations.iter_mut().filter(|cause| cause.value < 0.0) {
        early.gain = (early.gain - AHEAD).max(0.0);
    }
    explanations.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let best = *explanations.first()?;
    let least = if best.value.abs() > TUNING.long_s { SUSPECTED } else { FOUND };
    if best.gain < least || best.value.abs() < TUNING.ordinary_s {
        return None;
    }
    let next = explanations.get(1).map_or(0.0, |next| next.gain);
    // Tires, compliance and steering gear delay the car behind the steering wheel, too.
    let kinematic = best.channel != SensorGroup::Steering;
    let seen_in = || links.iter().filter(|link| best.channel.sense(link.relation) != 0.0);
    let is_put_right = seen_in().any(|link| link.explained > TUNING.put_right);
    let confidence = if best.gain < FOUND || !is_put_right {
        Confidence::Unclear
    } else if kinematic && best.value > TUNING.extraordinary_s && best.gain - next > SURE {
        Confidence::Certain
    } else if best.gain - next > AHEAD {
        Confidence::Likely
    } else {
        Confidence::Unclear
    };
    let mut or: Vec<String> = explanations[1..]
        .iter()
        .filter(|other| best.gain - other.gain < AHEAD && other.gain > SUSPECTED)
        .map(|other| format!("sensor_delay of {} ({:+.0} ms)", series.name(other.channel), 1e3 * other.value))
        .collect();
    if !kinematic {
        or.push("steering_lag, steering_compliance or relaxation_length".to_owned());
    }
    let milliseconds = 1e3 * best.value;
    let repair = if best.value > 0.0 {
        format!("add {milliseconds:.0} to its delay_ms (delay_ms = {milliseconds:.0} if there is none)")
    } else {
        format!(
            "take {:.0} from its delay_ms; if there is none, all other channels are late by so much",
            -milliseconds
        )
    };
    report.findings.push(AuditFinding {
        effect: "sensor_delay",
        channel: series.name(best.channel).to_owned(),
        value: Some(best.value),
        std: Some(best.std),
        t: best.gain.sqrt(),
        evidence: seen_in()
            .map(|l| {
                format!("{}: later by {:.1} ± {:.1} ms", l.relation.name(), 1e3 * l.delay, 1e3 * l.delay_std)
            })
            .collect::<Vec<_>>()
            .join("; "),
        confidence,
        repair,
        or,
    });
    Some((best.channel, best.value))
}
