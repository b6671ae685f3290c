//! The service's loop in memory, fed by a script.

use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use gripd::Config;
use gripd::can::{Event, Frame, Reception, SendError};
use gripd::config::ConfigError;
use gripd::service::{Link, Reloads, Service, Tally, serve};
use testing::demo_car as car;
use testing::heard::Heard;
use tokio::sync::Notify;
use tokio::time::sleep;

/// What happens next on the bus, or to the process.
#[derive(Clone, Debug)]
pub enum Happens {
    Now(Event),
    /// So many hangups, at once.
    Hangups(usize),
    Pause(Duration),
}

/// A bus on which everything happens in its order, and then nothing more.
struct Script {
    steps: std::vec::IntoIter<Happens>,
    /// Kept here, so that a pause may be cancelled.
    until: Option<tokio::time::Instant>,
    bell: Arc<Notify>,
    over: Rc<Notify>,
    retuned: Rc<std::cell::RefCell<Vec<Reception>>>,
}

impl Link for Script {
    async fn recv(&mut self) -> Event {
        loop {
            if let Some(until) = self.until {
                tokio::time::sleep_until(until).await;
                self.until = None;
            }
            tokio::task::yield_now().await;
            match self.steps.next() {
                Some(Happens::Now(event)) => return event,
                Some(Happens::Hangups(count)) => (0..count).for_each(|_| self.bell.notify_one()),
                Some(Happens::Pause(pause)) => self.until = Some(tokio::time::Instant::now() + pause),
                None => {
                    self.over.notify_one();
                    return std::future::pending().await;
                }
            }
        }
    }

    fn try_send(&mut self, _: &Frame) -> Result<(), SendError> {
        Ok(())
    }

    fn retune(&mut self, reception: Reception) -> std::io::Result<()> {
        self.retuned.borrow_mut().push(reception);
        Ok(())
    }
}

/// What came of it.
pub struct Ran {
    pub heard: Heard,
    pub tally: Tally,
    pub retuned: Vec<Reception>,
}

/// Frames at once, one after the other.
pub fn frames(frames: &[Frame]) -> Vec<Happens> {
    frames.iter().map(|frame| Happens::Now(Event::Frame(*frame))).collect()
}

/// Runs the service of the demo's car; `read` is what its configuration says when it is read anew.
pub fn run(
    script: Vec<Happens>,
    read: impl Fn() -> Result<Config, ConfigError> + Send + Sync + 'static,
) -> Ran {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let (bell, over) = (Arc::new(Notify::new()), Rc::new(Notify::new()));
    let retuned = Rc::default();
    let config = car::config();
    let script = Script {
        steps: script.into_iter(),
        until: None,
        bell: Arc::clone(&bell),
        over: Rc::clone(&over),
        retuned: Rc::clone(&retuned),
    };
    let mut heard = Heard::default();
    let tally = runtime.block_on(async {
        let reloads = Some(Reloads::new(&config, bell, read));
        let service = Service { reloads, ..Service::new(car::engine(&config), script) };
        let ended = async {
            over.notified().await;
            // What was asked for last may still be under way.
            sleep(Duration::from_millis(50)).await;
        };
        serve(service, &mut heard, ended).await
    });
    let retuned = retuned.take();
    Ran { heard, tally, retuned }
}
