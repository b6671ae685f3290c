//! The latest frames, in memory that was there before the first one.
//!
//! The loop writes and never waits: what is oldest is overwritten. Who reads follows behind and notices what was
//! overwritten under its eyes: the loop says what it gives up before it writes there.

use std::sync::Arc;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use std::sync::atomic::{AtomicU64, fence};

use crate::can::{CanId, Frame, FrameKind};
use physics::Micros;

/// Where a frame came in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// On the interface that we listen on.
    Input,
    /// On the one that we publish on, where that is another one.
    Output,
}

/// A frame takes a word for its time, one for what it is, and one for each eight bytes that it carries.
#[derive(Debug)]
struct Ring {
    words: Box<[AtomicU64]>,
    /// Words that were ever written, and those of them that are given up. Both end on whole frames.
    head: AtomicU64,
    tail: AtomicU64,
}

impl Ring {
    fn word(&self, position: u64) -> &AtomicU64 {
        // Their number is a power of two, and on no machine more than it can count.
        &self.words[position as usize & (self.words.len() - 1)]
    }

    /// Words of the frame that begins there.
    fn length_at(&self, position: u64) -> u64 {
        Kind(self.word(position + 1).load(Relaxed)).words()
    }
}

/// The loop's end.
#[derive(Debug)]
pub(super) struct Front {
    ring: Arc<Ring>,
    head: u64,
    tail: u64,
}

/// The end of who writes files. It begins with the oldest frame that there is.
#[derive(Clone, Debug)]
pub(super) struct Back {
    ring: Arc<Ring>,
    position: u64,
}

/// For this many words, or the next power of two. They begin with ones: of zeros the kernel would give the pages only when
/// each is written for the first time, and a frame would wait for it.
pub(super) fn ring(words: usize) -> (Front, Back) {
    let words = (0..words.next_power_of_two().max(16)).map(|_| AtomicU64::new(u64::MAX)).collect();
    let ring = Arc::new(Ring { words, head: AtomicU64::new(0), tail: AtomicU64::new(0) });
    (Front { ring: Arc::clone(&ring), head: 0, tail: 0 }, Back { ring, position: 0 })
}

impl Front {
    /// Keeps a frame as long as there is room.
    pub fn push(&mut self, frame: &Frame, origin: Origin) {
        let kind = Kind::new(frame, origin);
        let end = self.head + kind.words();
        while end - self.tail > self.ring.words.len() as u64 {
            self.tail += self.ring.length_at(self.tail);
        }
        self.ring.tail.store(self.tail, Relaxed);
        // Whoever sees a word of this frame sees after its own fence what was given up for it.
        fence(Release);
        self.ring.word(self.head).store(frame.time.0.cast_unsigned(), Relaxed);
        self.ring.word(self.head + 1).store(kind.0, Relaxed);
        for (place, bytes) in (self.head + 2..).zip(frame.data().chunks(8)) {
            let mut word = [0; 8];
            word[..bytes.len()].copy_from_slice(bytes);
            self.ring.word(place).store(u64::from_le_bytes(word), Relaxed);
        }
        self.head = end;
        self.ring.head.store(end, Release);
    }
}

impl Back {
    /// Goes back to the oldest frame that there is.
    pub fn rewind(&mut self) {
        self.position = self.ring.tail.load(Relaxed);
    }

    /// The next frame, and whether some before it were overwritten; `None` if there is none yet.
    pub fn next(&mut self) -> Option<(Frame, Origin, bool)> {
        let mut lost = false;
        while self.position < self.ring.head.load(Acquire) {
            let read = self.read();
            fence(Acquire);
            let tail = self.ring.tail.load(Relaxed);
            if tail > self.position {
                (self.position, lost) = (tail, true);
                continue;
            }
            let (frame, origin, words) = read?;
            self.position += words;
            return Some((frame, origin, lost));
        }
        None
    }

    /// What stands at the position now, which may be given up meanwhile.
    fn read(&self) -> Option<(Frame, Origin, u64)> {
        let time = Micros(self.ring.word(self.position).load(Relaxed).cast_signed());
        let kind = Kind(self.ring.word(self.position + 1).load(Relaxed));
        let mut data = [0; 64];
        for (place, bytes) in (self.position + 2..).zip(data.chunks_exact_mut(8)).take(kind.data_words()) {
            bytes.copy_from_slice(&self.ring.word(place).load(Relaxed).to_le_bytes());
        }
        Some((kind.frame(time, data)?, kind.origin(), kind.words()))
    }
}

/// All of a frame but its time and its data, in one word.
#[derive(Clone, Copy)]
struct Kind(u64);

impl Kind {
    const EXTENDED: u64 = 1 << 32;
    const REMOTE: u64 = 1 << 33;
    const ERROR: u64 = 1 << 34;
    const FD: u64 = 1 << 35;
    const BIT_RATE_SWITCH: u64 = 1 << 36;
    const ERROR_STATE: u64 = 1 << 37;
    const OUTPUT: u64 = 1 << 38;
    /// From this bit on.
    const LENGTH: u32 = 48;

    fn new(frame: &Frame, origin: Origin) -> Self {
        let bit = |is: bool, bit: u64| if is { bit } else { 0 };
        let kind = match frame.kind {
            FrameKind::Data => 0,
            FrameKind::Remote => Self::REMOTE,
            FrameKind::Error => Self::ERROR,
            FrameKind::Fd { bit_rate_switch, error_state } => {
                Self::FD | bit(bit_rate_switch, Self::BIT_RATE_SWITCH) | bit(error_state, Self::ERROR_STATE)
            }
        };
        Self(
            u64::from(frame.id.number())
                | bit(frame.id.is_extended(), Self::EXTENDED)
                | bit(origin == Origin::Output, Self::OUTPUT)
                | kind
                | (frame.length() as u64) << Self::LENGTH,
        )
    }

    fn is(self, bit: u64) -> bool {
        self.0 & bit != 0
    }

    fn length(self) -> usize {
        ((self.0 >> Self::LENGTH) as usize).min(64)
    }

    fn data_words(self) -> usize {
        if self.is(Self::REMOTE) { 0 } else { self.length().div_ceil(8) }
    }

    fn words(self) -> u64 {
        2 + self.data_words() as u64
    }

    fn origin(self) -> Origin {
        if self.is(Self::OUTPUT) { Origin::Output } else { Origin::Input }
    }

    /// `None` for what no frame can be: a word of another one, overwritten while it was read.
    fn frame(self, time: Micros, data: [u8; 64]) -> Option<Frame> {
        let number = self.0 as u32;
        let id = if self.is(Self::EXTENDED) { CanId::extended(number) } else { CanId::standard(number) }?;
        let kind = if self.is(Self::REMOTE) {
            return Frame::remote(time, id, self.length()).ok();
        } else if self.is(Self::ERROR) {
            FrameKind::Error
        } else if self.is(Self::FD) {
            FrameKind::Fd {
                bit_rate_switch: self.is(Self::BIT_RATE_SWITCH),
                error_state: self.is(Self::ERROR_STATE),
            }
        } else {
            FrameKind::Data
        };
        Frame::new(time, id, kind, &data[..self.length()]).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of every kind and length, the number in each.
    fn frame(number: u64) -> Frame {
        let time = Micros(number as i64 * 10 - 5000);
        let short = CanId::standard(number as u32 % 0x800).unwrap();
        let long = CanId::extended(number as u32).unwrap();
        let data = number.to_le_bytes();
        let fd = FrameKind::Fd {
            bit_rate_switch: number.is_multiple_of(2),
            error_state: number.is_multiple_of(3),
        };
        match number % 6 {
            0 => Frame::data_frame(time, short, &data).unwrap(),
            1 => Frame::data_frame(time, long, &data[..3]).unwrap(),
            2 => Frame::remote(time, short, 5).unwrap(),
            3 => Frame::new(time, long, FrameKind::Error, &data).unwrap(),
            4 => Frame::new(time, short, fd, &data.repeat(8)).unwrap(),
            _ => Frame::new(time, long, fd, &data.repeat(2)[..12]).unwrap(),
        }
    }

    fn drain(back: &mut Back) -> Vec<(Frame, Origin, bool)> {
        std::iter::from_fn(|| back.next()).collect()
    }

    #[test]
    fn what_goes_in_comes_out() {
        let (mut front, mut back) = ring(4096);
        assert!(back.next().is_none());
        for number in 0..300 {
            let origin = if number % 7 == 0 { Origin::Output } else { Origin::Input };
            front.push(&frame(number), origin);
        }
        let read = drain(&mut back);
        assert_eq!(read.len(), 300);
        for (number, (read, origin, lost)) in (0..).zip(read) {
            assert_eq!((read, lost), (frame(number), false));
            assert_eq!(origin == Origin::Output, number % 7 == 0);
        }
        assert!(back.next().is_none());
        back.rewind();
        assert_eq!(drain(&mut back).len(), 300);
    }

    /// GIVEN more frames than there is room for THEN the newest are there, whole, and what is missing is told once.
    #[test]
    fn the_oldest_give_way() {
        let (mut front, mut back) = ring(64);
        for number in 0..1000 {
            front.push(&frame(number), Origin::Input);
        }
        let read = drain(&mut back);
        let first = 1000 - read.len() as u64;
        assert!((6..=32).contains(&read.len()));
        for (number, (read, _, lost)) in (first..).zip(read) {
            assert_eq!((read, lost), (frame(number), number == first));
        }
        front.push(&frame(1000), Origin::Input);
        assert_eq!(back.next(), Some((frame(1000), Origin::Input, false)));
    }

    /// GIVEN a reader that is overtaken again and again by a writer in another thread THEN each frame that it gets is
    /// one that was written, in order, and it knows of every gap.
    #[test]
    fn a_reader_that_is_overtaken_gets_no_mixture() {
        const COUNT: u64 = 300_000;
        let (mut front, mut back) = ring(256);
        let writer = std::thread::spawn(move || {
            for number in 0..COUNT {
                front.push(&frame(number), Origin::Input);
                if number % 64 == 0 {
                    std::thread::yield_now();
                }
            }
        });
        let (mut next, mut gaps, mut read) = (0, 0, 0);
        while next < COUNT {
            let Some((found, _, lost)) = back.next() else {
                std::thread::yield_now();
                continue;
            };
            let number = (found.time.0.cast_unsigned().wrapping_add(5000)) / 10;
            assert_eq!(found, frame(number));
            assert_eq!(number != next, lost, "{number} after {next}");
            (next, read) = (number + 1, read + 1);
            gaps += u64::from(lost);
        }
        writer.join().unwrap();
        assert!(gaps > 0 && read > 100, "{gaps} gaps, {read} read");
    }
}
