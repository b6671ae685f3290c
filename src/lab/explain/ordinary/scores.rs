//! What was measured beside what cars say: how far off they are, and as traces for plots.

use physics::Quantity;

use super::beyond::rows;
use super::inputs::FreeDrive;
use super::run::Predicted;
use crate::explain::proof::Sums;
use crate::explain::result::{ByChannel, Models, Parts};

/// Yaw rate or lateral acceleration of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeTrace {
    /// The recording.
    pub recording: String,
    /// The quantity.
    pub channel: Quantity,
    /// Time, measured; predicted by the ordinary car with what was found beside it, and by the plain one.
    pub rows: Vec<[f64; 4]>,
}

/// Of so many points of a trace one is kept: twenty a second are more than a page can show.
pub(super) const TRACED_EVERY: usize = 5;

/// What is compared.
pub(super) const CHANNELS: [Quantity; 2] = [Quantity::YawRate, Quantity::LateralAcceleration];

pub(super) fn measured(drive: &FreeDrive, channel: Quantity) -> Option<&[f64]> {
    if channel == Quantity::YawRate { Some(&drive.yaw_rate) } else { drive.lateral.as_deref() }
}

pub(super) fn said(predicted: &Predicted, channel: Quantity) -> &[f64] {
    if channel == Quantity::YawRate { &predicted.yaw_rate } else { &predicted.lateral }
}

/// Squared errors of the rows that are held out.
pub(super) fn held_square(drives: &[FreeDrive], predicted: &[Predicted], channel: Quantity) -> f64 {
    let of = |(drive, predicted): (&FreeDrive, &Predicted)| -> f64 {
        let Some(measured) = measured(drive, channel) else { return 0.0 };
        let held = rows(drive).filter(|i| drive.counts[*i] && drive.held[*i] && measured[*i].is_finite());
        held.map(|i| (measured[i] - said(predicted, channel)[i]).powi(2)).sum()
    };
    drives.iter().zip(predicted).map(of).sum()
}

/// Sums over all drives, by channel.
fn sums(drives: &[FreeDrive], predicted: &[Predicted]) -> Parts<Sums> {
    let mut parts: Parts<Sums> = Parts::default();
    for channel in CHANNELS {
        let of = |(drive, own): (&FreeDrive, &Predicted)| {
            let measured = measured(drive, channel).unwrap_or_default();
            let all = measured.iter().zip(said(own, channel)).enumerate();
            let counts = all.filter(|(i, (y, _))| drive.counts[*i] && y.is_finite());
            counts.map(|(i, (y, z))| (drive.held[i], *y, *z)).collect::<Vec<_>>()
        };
        parts.add(channel, drives.iter().zip(predicted).flat_map(of));
    }
    parts
}

/// Fit over all drives, %, by channel.
pub(super) fn fits(drives: &[FreeDrive], predicted: &[Predicted]) -> Parts<ByChannel> {
    sums(drives, predicted).fits()
}

/// Root mean square errors over all drives, by channel: of the plain car, of the ordinary one, with what was found.
pub(super) fn errors(drives: &[FreeDrive], predicted: [&[Predicted]; 3]) -> Models<Parts<ByChannel>> {
    let [baseline, ordinary, extended] = predicted.map(|of| sums(drives, of).errors());
    Models { baseline, ordinary: Some(ordinary), extended }
}

/// What was measured of each drive and channel beside what two cars say.
pub(super) fn traces(drives: &[FreeDrive], found: &[Predicted], plain: &[Predicted]) -> Vec<FreeTrace> {
    let of = |channel: Quantity| {
        let both = found.iter().zip(plain);
        drives.iter().zip(both).filter_map(move |(drive, both)| trace(drive, both, channel))
    };
    CHANNELS.into_iter().flat_map(of).collect()
}

pub(super) fn sideslip(drive: &FreeDrive, predicted: &Predicted) -> (String, Vec<[f64; 2]>) {
    let some =
        predicted.tan_sideslip.iter().enumerate().step_by(TRACED_EVERY).filter(|(i, _)| drive.counts[*i]);
    (drive.name.clone(), some.map(|(i, tan)| [drive.time(i), tan.atan()]).collect())
}

fn trace(drive: &FreeDrive, (own, plain): (&Predicted, &Predicted), channel: Quantity) -> Option<FreeTrace> {
    let measured = measured(drive, channel)?;
    let (own, plain) = (said(own, channel), said(plain, channel));
    let of = |i: usize| [drive.time(i), measured[i], own[i], plain[i]];
    let rows = (0..drive.points()).step_by(TRACED_EVERY).map(of).collect();
    Some(FreeTrace { recording: drive.name.clone(), channel, rows })
}
