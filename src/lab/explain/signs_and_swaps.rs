//! Wrong signs and swapped channels. They spoil the plain model's fit completely. So they are tried before anything
//! else, where the audit of the measurement chain suggests them.

use super::candidates::Candidate;
use super::chain::{ChainReport, Confidence};
use super::fit::{Data, Fit};
use super::model::{Chosen, Free, Model};
use super::naming::Refitted;
use super::tuning::TUNING;
use physics::model::effect::{Channel, Course, Kind, named};
use predict::noise::Noise;

/// What the audit suggests.
pub fn suggested(chain: &[ChainReport]) -> Vec<Candidate> {
    let findings = chain.iter().flat_map(|report| &report.findings);
    let suggested = findings.filter(|finding| {
        finding.confidence >= Confidence::Likely && named(finding.effect).is_some_and(Kind::is_all_or_nothing)
    });
    let mut all: Vec<Candidate> = Vec::new();
    for finding in suggested {
        let (Some(kind), Ok(channel)) = (named(finding.effect), finding.channel.parse::<Channel>()) else {
            continue;
        };
        if all.iter().any(|other| other.kind == kind && other.channel == Some(channel)) {
            continue;
        }
        all.push(Candidate {
            kind,
            channel: Some(channel),
            free: Vec::new(),
            fixed: Vec::new(),
            live: None,
            stretches: Vec::new(),
        });
    }
    all
}

/// Takes those that make the plain model fit far better, one after the other.
pub fn taken<'a>(
    data: &Data<'_>,
    plain: &Model<'a>,
    baseline: &Fit<'a>,
    (free, noise): (&[Free], &Noise),
    suggested: &[Candidate],
) -> Vec<Refitted<'a>> {
    let mut taken: Vec<Refitted<'a>> = Vec::new();
    let mut model = plain.clone();
    let mut cost = baseline.cost();
    for candidate in suggested {
        let with = model.with(Chosen::usual(candidate.kind, candidate.channel, Course::None));
        let fit = data.fit(&with, free, noise, 8);
        let gain = cost - fit.cost();
        if gain > TUNING.selection.least_gain_of_a_sign {
            cost -= gain;
            model = with;
            taken.push(Refitted { candidate: candidate.clone(), fit, evidence: gain, follows: None });
        }
    }
    taken
}
