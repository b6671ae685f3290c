//! Recordings whose yaw rate is late, put on time.
//!
//! The ordinary car's delays are counted from the yaw rate. Where the audit is certain that it is the yaw rate which is
//! late, everything else would be called early, and delays of 0.3 s are nothing that its search expects.

use std::borrow::Cow;

use super::chain::{AuditFinding, ChainReport, Confidence};
use super::predict::Recording;
use physics::Quantity;

/// The recordings, what the audit says of each beside them.
pub fn on_time<'r>(recordings: &'r [Recording], chain: &[ChainReport]) -> Cow<'r, [Recording]> {
    let late: Vec<f64> = chain.iter().map(certainly_late).collect();
    if late.iter().all(|late| *late == 0.0) {
        return Cow::Borrowed(recordings);
    }
    let mut all = recordings.to_vec();
    for (recording, late) in all.iter_mut().zip(late) {
        let track = &mut recording.tracks[Quantity::YawRate as usize];
        track.iter_mut().for_each(|(t, _)| *t -= late);
        track.retain(|(t, _)| *t >= 0.0);
    }
    Cow::Owned(all)
}

/// How late the yaw rate is for certain, s.
fn certainly_late(report: &ChainReport) -> f64 {
    let of = |finding: &&AuditFinding| {
        finding.confidence == Confidence::Certain
            && finding.effect == "sensor_delay"
            && finding.channel == Quantity::YawRate.name()
    };
    report.findings.iter().find(of).and_then(|finding| finding.value).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::bench::recorded;
    use super::*;

    fn report(confidence: Confidence) -> ChainReport {
        let late = AuditFinding {
            effect: "sensor_delay",
            channel: "yaw_rate".into(),
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
        let put = on_time(&recordings, &[report(Confidence::Certain)]);
        let (yaw, steering) = (Quantity::YawRate as usize, Quantity::SteeringWheelAngle as usize);
        let (before, after) = (&recordings[0].tracks[yaw], &put[0].tracks[yaw]);
        let (last, was) = (after[after.len() - 1], before[before.len() - 1]);
        assert!((was.0 - last.0 - 0.3).abs() < 1e-12 && last.1 == was.1);
        assert!(after[0].0 >= 0.0 && after.len() < before.len());
        assert_eq!(recordings[0].tracks[steering], put[0].tracks[steering]);
        assert!(matches!(on_time(&recordings, &[report(Confidence::Likely)]), Cow::Borrowed(_)));
    }
}
