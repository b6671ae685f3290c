//! The thread that watches: takes what comes, and tells the hub of it some times a second.

use std::time::Duration;

use tokio::sync::oneshot;
use tokio::time::{MissedTickBehavior, interval};

use super::hub::{Hub, News};
use super::news;
use crate::cli::Failure;
use crate::cli::desk::watched::Subject;
use bus::watch::{Happening, Watch};

/// Time between two words to the browsers.
const NEWS: Duration = Duration::from_millis(200);

/// Runs until the process ends. Says first whether what is to be watched could be opened.
pub fn run(subject: Subject, hub: &Hub, opened: oneshot::Sender<Result<(), Failure>>) {
    let runtime = match tokio::runtime::Builder::new_current_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return drop(opened.send(Err(Failure::work(error)))),
    };
    runtime.block_on(async {
        let mut source = match subject.open() {
            Ok(source) => source,
            Err(failure) => return drop(opened.send(Err(failure))),
        };
        if opened.send(Ok(())).is_err() {
            return;
        }
        let mut teller = Teller { watch: subject.watch, told: 0, beginnings: 0, remark: String::new() };
        let mut over = false;
        let mut ticks = interval(NEWS);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                biased;
                _ = ticks.tick() => {
                    if let Some(now) = source.now() {
                        teller.watch.advance(now);
                    }
                    hub.tell(teller.news());
                }
                happening = source.next(), if !over => {
                    teller.watch.take(&happening, source.now());
                    match happening {
                        Happening::Over => {
                            over = true;
                            teller.remark = "the recording is over".into();
                        }
                        Happening::Failed(reason) => {
                            tracing::warn!("{reason}");
                            over = true;
                            teller.remark = reason;
                        }
                        _ => {}
                    }
                }
            }
        }
    });
}

struct Teller {
    watch: Watch,
    /// Rows that were told of.
    told: u64,
    /// How often the series had begun anew then.
    beginnings: u32,
    remark: String,
}

impl Teller {
    fn news(&mut self) -> News {
        let series = self.watch.series();
        let anew = series.beginnings() != self.beginnings;
        let (rows, count) = news::rows(series.since(self.told));
        self.told = series.made();
        self.beginnings = series.beginnings();
        News { rows, count, anew, now: news::now(&self.watch, &self.remark) }
    }
}
