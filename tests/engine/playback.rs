//! A link that plays frames and ends.

use std::rc::Rc;

use gripd::can::{Event, Frame, SendError};
use gripd::service::Link;
use tokio::sync::Notify;

/// Plays frames to the service, as fast as it takes them, and ends it.
pub struct Playback {
    pub frames: std::vec::IntoIter<Frame>,
    /// Told once they are over.
    pub over: Rc<Notify>,
}

impl Link for Playback {
    async fn recv(&mut self) -> Event {
        tokio::task::yield_now().await;
        match self.frames.next() {
            Some(frame) => Event::Frame(frame),
            None => {
                self.over.notify_one();
                std::future::pending().await
            }
        }
    }

    fn try_send(&mut self, _: &Frame) -> Result<(), SendError> {
        Ok(())
    }
}
