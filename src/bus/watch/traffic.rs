//! How often an identifier comes.

use std::collections::VecDeque;

use crate::can::CanId;
use physics::Micros;

/// Counts the frames of one identifier.
#[derive(Clone, Debug)]
pub struct Traffic {
    name: String,
    id: CanId,
    frames: u64,
    last: Option<Micros>,
    /// Frames of each tenth of a second, newest last: tenths since the epoch of the time stamps.
    tenths: VecDeque<(i64, u32)>,
}

impl Traffic {
    const TENTH: i64 = 100_000;
    /// A rate is that of so many tenths of a second.
    const TENTHS: i64 = 20;

    /// None came yet.
    pub fn new(name: &str, id: CanId) -> Self {
        Self { name: name.to_owned(), id, frames: 0, last: None, tenths: VecDeque::new() }
    }

    /// Name of the message.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Identifier.
    pub fn id(&self) -> CanId {
        self.id
    }

    /// Frames so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Time of the newest frame.
    pub fn last(&self) -> Option<Micros> {
        self.last
    }

    /// One came at this time.
    pub fn count(&mut self, time: Micros) {
        self.frames += 1;
        self.last = Some(time);
        let tenth = time.0.div_euclid(Self::TENTH);
        // A clock that was set back begins a new count.
        if self.tenths.back().is_some_and(|(newest, _)| tenth < *newest - Self::TENTHS) {
            self.tenths.clear();
        }
        match self.tenths.back_mut() {
            Some((newest, count)) if *newest >= tenth => *count += 1,
            _ => self.tenths.push_back((tenth, 1)),
        }
        while self.tenths.front().is_some_and(|(oldest, _)| *oldest < tenth - Self::TENTHS) {
            self.tenths.pop_front();
        }
    }

    /// Frames per second, over the two seconds before this one's tenth, or since the first frame.
    pub fn rate(&self, now: Micros) -> f64 {
        let end = now.0.div_euclid(Self::TENTH);
        let counted = || self.tenths.iter().filter(|(tenth, _)| (end - Self::TENTHS..end).contains(tenth));
        let count: u32 = counted().map(|(_, count)| count).sum();
        let tenths = counted().next().map_or(Self::TENTHS, |(oldest, _)| end - oldest).max(1);
        // Of a message that comes seldom the first frame is no beginning.
        let tenths = if self.frames > u64::from(count) { Self::TENTHS } else { tenths };
        f64::from(count) * 10.0 / tenths as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn traffic() -> Traffic {
        Traffic::new("M", CanId::standard(1).unwrap())
    }

    #[test]
    fn rates_follow_what_comes_and_fade_when_nothing_does() {
        let mut traffic = traffic();
        for frame in 0..500 {
            traffic.count(Micros(frame * 10_000));
        }
        let end = Micros(5_000_000);
        assert_eq!((traffic.frames(), traffic.rate(end)), (500, 100.0));
        assert_eq!(traffic.rate(Micros(6_000_000)), 50.0);
        assert_eq!(traffic.rate(Micros(60_000_000)), 0.0);
        // Set back: the old count is no rate of the new time.
        traffic.count(Micros(0));
        traffic.count(Micros(50_000));
        assert_eq!(traffic.rate(Micros(100_000)), 1.0);
    }

    #[test]
    fn the_first_second_is_not_taken_for_two() {
        let mut traffic = traffic();
        for frame in 0..50 {
            traffic.count(Micros(7_000_000 + frame * 20_000));
        }
        assert_eq!(traffic.rate(Micros(8_000_000)), 50.0);
    }
}
