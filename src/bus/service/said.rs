//! What the daemon says in the log, and how often, so that a bad day does not fill it.

use std::time::Instant;

use super::Engine;
use super::throttle::{Allowed, Quota, Throttle};
use crate::can::{BusState, CanId, ErrorReport, Event, SendError};
use physics::Faults;
use physics::estimate::Doubt;

/// What was said lately.
#[derive(Debug, Default)]
pub(super) struct Said {
    dropped: Throttle,
    unsent: Throttle,
    late: Throttle,
    /// Of somebody else under our name once is enough: the metrics count.
    foreign: bool,
    bus_off: Throttle,
    bus_state: Throttle,
    link: Quota,
    contradiction: Throttle,
    sent_twice: Throttle,
    doubt: Throttle,
    /// What was doubted a frame ago.
    doubted: Faults,
}

impl Said {
    /// Sensors that contradict each other.
    const CONTRADICTION: Faults = Faults::STUCK.union(Faults::WHEEL_MISMATCH).union(Faults::MOTION_MISMATCH);

    /// The kernel, or a queue, dropped frames.
    pub(super) fn dropped(&mut self, count: u32, total: u64) {
        if let Some(withheld) = self.dropped.pass(Instant::now()) {
            tracing::warn!(count, total, withheld, "the kernel dropped frames: we are too slow");
        }
    }

    /// A frame could not be sent.
    pub(super) fn unsent(&mut self, total: u64, error: &SendError) {
        if self.unsent.pass(Instant::now()).is_some() {
            tracing::warn!(total, "a frame was not sent: {error}");
        }
    }

    /// A round would have been too late.
    pub(super) fn late(&mut self, total: u64) {
        if self.late.pass(Instant::now()).is_some() {
            tracing::warn!(total, "a round was dropped, it would have been too late: we are too slow");
        }
    }

    /// Somebody else sends what only we should.
    pub(super) fn foreign(&mut self, id: CanId) {
        if !std::mem::replace(&mut self.foreign, true) {
            tracing::warn!(
                "another node sends {id}, which is gripd's: no receiver can tell whom to believe. Find it (a second \
                 gripd, a replay?), or give gripd other identifiers in [publish.ids]"
            );
        }
    }

    /// Changes of a link, unless it does nothing but change.
    pub(super) fn link(&mut self, place: &str, event: Event) {
        let allowed = self.link.pass(Instant::now());
        if allowed == Allowed::No {
            return;
        }
        match event {
            Event::Up => tracing::info!("the {place} interface is up"),
            Event::Down => tracing::warn!(
                "the {place} interface is down; waiting for it (`ip link set … up`; a controller needs a bit rate \
                 before that: `ip link set … type can bitrate 500000`)"
            ),
            _ => tracing::warn!("the {place} interface does not exist; waiting for it"),
        }
        if allowed == Allowed::LastForNow {
            tracing::warn!("the interfaces change all the time: no more is said of it for up to a minute");
        }
    }

    /// Changes of the controller's state, each at its own level; single errors are for debugging only.
    pub(super) fn error(&mut self, place: &str, error: ErrorReport) {
        let Some(state) = error.bus_state() else {
            tracing::debug!("{place}: {error}");
            return;
        };
        let said = if state == BusState::Off { &mut self.bus_off } else { &mut self.bus_state };
        let Some(withheld) = said.pass(Instant::now()) else { return };
        match state {
            BusState::Off => tracing::error!(withheld, "{place}: {error}"),
            BusState::Passive | BusState::Warning => tracing::warn!(withheld, "{place}: {error}"),
            BusState::Active => tracing::info!(withheld, "{place}: {error}"),
        }
    }

    /// Why sensors or the estimators are not believed, when that begins. To be called after each frame.
    pub(super) fn doubts(&mut self, engine: &Engine) {
        let now = engine.latest_faults() & (Self::CONTRADICTION | Faults::INCONSISTENT | Faults::SENT_TWICE);
        let begun = now - std::mem::replace(&mut self.doubted, now);
        if begun.is_empty() {
            return;
        }
        if begun.contains(Faults::SENT_TWICE)
            && let Some((message, id)) = engine.sampler().sent_twice()
            && let Some(withheld) = self.sent_twice.pass(Instant::now())
        {
            tracing::warn!(
                withheld,
                "{message} ({id}) comes more often than it should: two nodes send it, and it is not used. If that is \
                 right, switch it off: [signals.sampling] rate_watch = false"
            );
        } else if begun.intersects(Self::CONTRADICTION)
            && let Some(reason) = engine.sampler().contradiction()
            && let Some(withheld) = self.contradiction.pass(Instant::now())
        {
            tracing::warn!(withheld, "sensors contradict each other: {reason}");
        } else if begun.contains(Faults::INCONSISTENT)
            && let Some(reason) = engine.doubt().filter(|doubt| *doubt != Doubt::Sensors)
            && let Some(withheld) = self.doubt.pass(Instant::now())
        {
            tracing::info!(withheld, "the motion is not believed at the moment: {reason}");
        }
    }
}
