//! Recordings as they would be without what the audit of the measurement is certain of: a yaw rate whose zero moves, signs,
//! swapped channels, a late yaw rate.
//!
//! The ordinary car knows nothing of the first two. Its delays are counted from the yaw rate: where that is late,
//! everything else would be called early, and delays of 0.3 s are nothing that its search expects.

use std::borrow::Cow;

use super::chain::{AuditFinding, ChainReport, Confidence, ZeroCourse};
use physics::Quantity;
use physics::model::effect::Channel;
use predict::Recording;

/// The recordings, what the audit says of each beside them.
pub fn put_right<'r>(recordings: &'r [Recording], chain: &[ChainReport]) -> Cow<'r, [Recording]> {
    without(recordings, chain.iter().map(certainly_wrong).collect())
}

/// The same with nothing put right but zeros that move.
pub fn without_drifts<'r>(recordings: &'r [Recording], chain: &[ChainReport]) -> Cow<'r, [Recording]> {
    without(recordings, chain.iter().map(|report| drift(report).collect()).collect())
}

fn without<'r>(recordings: &'r [Recording], wrong: Vec<Vec<Wrong<'_>>>) -> Cow<'r, [Recording]> {
    if wrong.iter().all(Vec::is_empty) {
        return Cow::Borrowed(recordings);
    }
    let mut all = recordings.to_vec();
    for (recording, wrong) in all.iter_mut().zip(wrong) {
        wrong.into_iter().for_each(|wrong| wrong.put_right(recording));
    }
    Cow::Owned(all)
}

/// What can be put right without knowing the car.
enum Wrong<'w> {
    /// The yaw rate's zero moves.
    Drift(&'w ZeroCourse),
    /// A sign.
    Sign(Quantity),
    /// Two channels that were taken for each other.
    Swap(Quantity, Quantity),
    /// The yaw rate is so late, s.
    Late(f64),
}

impl Wrong<'_> {
    fn of(finding: &AuditFinding) -> Option<Self> {
        match (finding.effect, finding.channel.parse().ok()?) {
            ("sensor_sign", Channel::One(quantity)) => Some(Self::Sign(quantity)),
            ("channel_swap", Channel::Pair(one, other)) => Some(Self::Swap(one, other)),
            ("sensor_delay", Channel::One(Quantity::YawRate)) => finding.value.map(Self::Late),
            _ => None,
        }
    }

    fn put_right(self, recording: &mut Recording) {
        match self {
            Self::Drift(zero) => {
                let begins = recording.begins_s.unwrap_or_default();
                let track = &mut recording.tracks[Quantity::YawRate as usize];
                track.iter_mut().for_each(|(t, value)| *value -= zero.at(begins + *t));
            }
            Self::Sign(quantity) => {
                recording.tracks[quantity as usize].iter_mut().for_each(|(_, value)| *value = -*value);
            }
            Self::Swap(one, other) => recording.tracks.swap(one as usize, other as usize),
            Self::Late(late) => {
                let track = &mut recording.tracks[Quantity::YawRate as usize];
                track.iter_mut().for_each(|(t, _)| *t -= late);
                track.retain(|(t, _)| *t >= 0.0);
            }
        }
    }
}

/// The zero first: it was read off what was recorded.
fn certainly_wrong(report: &ChainReport) -> Vec<Wrong<'_>> {
    let certain = report.findings.iter().filter(|finding| finding.confidence == Confidence::Certain);
    drift(report).chain(certain.filter_map(Wrong::of)).collect()
}

fn drift(report: &ChainReport) -> impl Iterator<Item = Wrong<'_>> {
    report.drift.iter().map(Wrong::Drift)
}

#[cfg(test)]
mod tests {
    use super::super::bench::recorded;
    use super::*;

    fn report(confidence: Confidence, effect: &'static str, channel: &str) -> ChainReport {
        let late = AuditFinding {
            effect,
            channel: channel.into(),
            value: Some(0.3),
            std: Some(0.01),
            t: 30.0,
            evidence: String::new(),
            confidence,
            repair: String::new(),
            or: Vec::new(),
        };
        ChainReport { findings: vec![late], ..ChainReport::default() }
    }

    /// GIVEN a yaw rate that is late for certain THEN it, and nothing else, is put on time; GIVEN less than that THEN nothing.
    #[test]
    fn a_yaw_rate_that_is_late_for_certain_is_put_on_time() {
        let (_, recording) = recorded("");
        let recordings = [recording];
        let put = put_right(&recordings, &[report(Confidence::Certain, "sensor_delay", "yaw_rate")]);
        let (yaw, steering) = (Quantity::YawRate as usize, Quantity::SteeringWheelAngle as usize);
        let (before, after) = (&recordings[0].tracks[yaw], &put[0].tracks[yaw]);
        let (last, was) = (after[after.len() - 1], before[before.len() - 1]);
        assert!((was.0 - last.0 - 0.3).abs() < 1e-12 && last.1 == was.1);
        assert!(after[0].0 >= 0.0 && after.len() < before.len());
        assert_eq!(recordings[0].tracks[steering], put[0].tracks[steering]);
        assert!(matches!(
            put_right(&recordings, &[report(Confidence::Likely, "sensor_delay", "yaw_rate")]),
            Cow::Borrowed(_)
        ));
    }

    #[test]
    fn a_sign_and_a_swap_that_are_certain_are_put_right() {
        let (_, recording) = recorded("");
        let recordings = [recording];
        let track = |of: &[Recording], quantity: Quantity| of[0].tracks[quantity as usize].clone();
        let (steering, left, right) =
            (Quantity::SteeringWheelAngle, Quantity::WheelSpeedFl, Quantity::WheelSpeedFr);
        let turned = put_right(&recordings, &[report(Confidence::Certain, "sensor_sign", steering.name())]);
        let values = track(&recordings, steering).into_iter().zip(track(&turned, steering));
        assert!(values.clone().count() > 100 && values.into_iter().all(|(was, is)| is == (was.0, -was.1)));
        let pair = format!("{left}/{right}");
        let swapped = put_right(&recordings, &[report(Confidence::Certain, "channel_swap", &pair)]);
        assert_eq!(track(&swapped, left), track(&recordings, right));
        assert_eq!(track(&swapped, right), track(&recordings, left));
    }
}
