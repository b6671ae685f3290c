//! What the loop waits for besides its links; for what there is not, for ever.

use std::time::Duration;

use tokio::sync::mpsc::Receiver;
use tokio::time::{Interval, MissedTickBehavior};

use super::saved::Part;
use super::{Fresh, Reloads};

/// What a round that is held waits for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Waits {
    /// There is none.
    Not,
    /// That nothing more is there to be read.
    Input,
    /// The time at which it may go.
    Until(tokio::time::Instant),
}

impl Waits {
    pub(super) async fn over(self) {
        match self {
            Self::Not => std::future::pending().await,
            // With the budget gone the input may have more than it said.
            Self::Input => tokio::task::consume_budget().await,
            Self::Until(time) => tokio::time::sleep_until(time).await,
        }
    }
}

/// The next tick of a clock.
pub(super) async fn tick(interval: &mut Option<Interval>) {
    match interval {
        Some(interval) => drop(interval.tick().await),
        None => std::future::pending().await,
    }
}

/// The next configuration, or why it is none.
pub(super) async fn next_reload(reloads: &mut Option<Reloads>) -> Result<Fresh, String> {
    match reloads {
        Some(reloads) => reloads.next().await,
        None => std::future::pending().await,
    }
}

/// The next wish to forget.
pub(super) async fn next_forget(forgets: &mut Option<Receiver<&'static [Part]>>) -> &'static [Part] {
    match forgets {
        Some(wishes) => match wishes.recv().await {
            Some(parts) => parts,
            // Nobody is left who could wish for something.
            None => std::future::pending().await,
        },
        None => std::future::pending().await,
    }
}

/// A clock that ticks so often, from so long after now; `None` if never.
pub(super) fn every(period: Duration) -> Option<Interval> {
    (!period.is_zero()).then(|| {
        let start = tokio::time::Instant::now() + period;
        let mut interval = tokio::time::interval_at(start, period);
        interval.set_missed_tick_behavior(MissedTickBehavior::Delay);
        interval
    })
}
