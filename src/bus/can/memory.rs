//! A bus within the process, for tests and for the demonstration without a CAN kernel.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use super::{Event, Frame, SendError};

/// One end of a bus of two nodes. What one sends, only the other receives, as on a real bus.
///
/// Bounded: where a kernel would drop the newest frame, this drops the oldest, because in a
/// demonstration the present matters more; both report it as [`Event::Dropped`].
#[derive(Debug)]
pub struct MemoryBus {
    incoming: Arc<Lane>,
    outgoing: Arc<Lane>,
    /// What the caller has been told: whether there is somebody at the other end.
    told: Option<Event>,
}

/// One direction.
#[derive(Debug)]
struct Lane {
    queue: Mutex<Queue>,
    arrived: Notify,
}

#[derive(Debug)]
struct Queue {
    frames: VecDeque<Frame>,
    capacity: usize,
    dropped: u32,
    /// One of the two ends is gone.
    closed: bool,
}

/// Two connected ends that hold up to `capacity` frames (at least one) in each direction.
pub fn memory_pair(capacity: usize) -> (MemoryBus, MemoryBus) {
    let (there, back) = (Lane::new(capacity), Lane::new(capacity));
    (
        MemoryBus { incoming: Arc::clone(&back), outgoing: Arc::clone(&there), told: None },
        MemoryBus { incoming: there, outgoing: back, told: None },
    )
}

impl Lane {
    fn new(capacity: usize) -> Arc<Self> {
        let capacity = capacity.max(1);
        let frames = VecDeque::with_capacity(capacity);
        let queue = Mutex::new(Queue { frames, capacity, dropped: 0, closed: false });
        Arc::new(Self { queue, arrived: Notify::new() })
    }

    /// A queue is in order after every statement, so a panic of another holder does no harm.
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MemoryBus {
    /// As [`Bus::recv`](super::Bus::recv). Frames keep the time their sender gave them. When the other
    /// end is dropped, the rest is delivered, then [`Event::Gone`], then nothing more.
    pub async fn recv(&mut self) -> Event {
        loop {
            if self.told.is_none() {
                self.told = Some(Event::Up);
                return Event::Up;
            }
            if let Some(event) = self.next_event() {
                return event;
            }
            self.incoming.arrived.notified().await;
        }
    }

    fn next_event(&mut self) -> Option<Event> {
        let mut queue = self.incoming.lock();
        if queue.dropped > 0 {
            return Some(Event::Dropped(std::mem::take(&mut queue.dropped)));
        }
        if let Some(frame) = queue.frames.pop_front() {
            return Some(Event::Frame(frame));
        }
        if queue.closed && self.told != Some(Event::Gone) {
            self.told = Some(Event::Gone);
            return self.told;
        }
        None
    }

    /// As [`Bus::try_send`](super::Bus::try_send); takes every kind of frame.
    ///
    /// # Errors
    /// [`SendError::Gone`] when the other end is.
    pub fn try_send(&mut self, frame: &Frame) -> Result<(), SendError> {
        let mut queue = self.outgoing.lock();
        if queue.closed {
            return Err(SendError::Gone);
        }
        if queue.frames.len() == queue.capacity {
            queue.frames.pop_front();
            queue.dropped = queue.dropped.saturating_add(1);
        }
        queue.frames.push_back(*frame);
        drop(queue);
        self.outgoing.arrived.notify_one();
        Ok(())
    }
}

impl Drop for MemoryBus {
    fn drop(&mut self) {
        for lane in [&self.incoming, &self.outgoing] {
            lane.lock().closed = true;
            lane.arrived.notify_one();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::CanId;
    use physics::Micros;

    fn frame(number: u8) -> Frame {
        Frame::data_frame(Micros(i64::from(number)), CanId::standard(1).unwrap(), &[number]).unwrap()
    }

    #[tokio::test]
    async fn the_oldest_go_first_and_are_counted() {
        let (mut left, mut right) = memory_pair(2);
        for number in 0..5 {
            left.try_send(&frame(number)).unwrap();
        }
        let mut events = Vec::new();
        for _ in 0..4 {
            events.push(right.recv().await);
        }
        assert_eq!(events, [Event::Up, Event::Dropped(3), Event::Frame(frame(3)), Event::Frame(frame(4))]);
    }

    #[tokio::test]
    async fn what_was_sent_before_leaving_still_arrives_and_own_frames_do_not_return() {
        let (mut left, mut right) = memory_pair(8);
        right.try_send(&frame(9)).unwrap();
        left.try_send(&frame(1)).unwrap();
        drop(left);
        assert_eq!(right.recv().await, Event::Up);
        assert_eq!(right.recv().await, Event::Frame(frame(1)));
        assert_eq!(right.recv().await, Event::Gone);
        assert_eq!(right.try_send(&frame(2)), Err(SendError::Gone));
        let pause = std::time::Duration::from_millis(20);
        assert!(tokio::time::timeout(pause, right.recv()).await.is_err(), "Gone is said once");
    }

    #[tokio::test]
    async fn a_waiting_receiver_is_woken() {
        let (mut left, mut right) = memory_pair(8);
        assert_eq!(right.recv().await, Event::Up);
        let (event, sent) = tokio::join!(right.recv(), async { left.try_send(&frame(7)) });
        assert_eq!((event, sent), (Event::Frame(frame(7)), Ok(())));
    }
}
