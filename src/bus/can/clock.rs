//! The time of what comes live: the kernel's stamps without the steps of its clock.
//!
//! The kernel stamps frames by CLOCK_REALTIME, which jumps whenever somebody sets it (at boot, when the first time
//! server answers). Nothing on the bus jumps with it. CLOCK_BOOTTIME never jumps and runs at the same rate: so the
//! difference of both changes by steps only, and a stamp less what that difference has changed since the socket was
//! opened is the time that the clock of then would show. It goes on during a suspend, as the clocks of a car do.

use std::time::Duration;

use nix::time::ClockId;
use physics::Micros;

/// The steps of the kernel's clock since it was started.
#[derive(Clone, Debug)]
pub(super) struct SteadyClock {
    /// CLOCK_REALTIME less CLOCK_BOOTTIME: at the start, now, and before the newest step; µs.
    at_start: i64,
    offset: i64,
    before: i64,
    /// The newest time given out.
    newest: Micros,
    /// Frames since both clocks were read.
    unread: u32,
}

/// Both clocks at (almost) the same moment, µs.
#[derive(Clone, Copy, Debug)]
struct Reading {
    boot: i64,
    offset: i64,
    /// Somebody else may have had the processor between the two.
    error: i64,
}

impl SteadyClock {
    /// Smaller changes of the difference are none: the clocks are read one after the other, µs.
    const NO_STEP: i64 = 1000;
    /// Stamps may come out of order by so much, or be ahead of a clock that is read later, µs.
    const TOLERANCE: i64 = 2000;
    /// A frame so soon after the one before it needs no look at the clocks, for so many frames: a step that hides in
    /// there does no harm, µs.
    const SOON: i64 = 10_000;
    const UNREAD: u32 = 64;

    /// Begins with the clock as it is.
    pub(super) fn start() -> Self {
        let offset = Reading::take().map_or(0, |reading| reading.offset);
        Self { at_start: offset, offset, before: offset, newest: Micros(i64::MIN), unread: 0 }
    }

    /// What the clock of the start would show now; `None` if the kernel has no such clock.
    pub(super) fn now(&self) -> Option<Micros> {
        boot_time().map(|boot| Micros(boot + self.at_start))
    }

    /// When a frame came that the kernel has stamped so; to be called as soon as it is read.
    pub(super) fn steady(&mut self, stamp: Micros) -> Micros {
        let time = Micros(stamp.0.saturating_sub(self.offset - self.at_start));
        let since = time.0.saturating_sub(self.newest.0);
        if (-Self::TOLERANCE..Self::SOON).contains(&since) && self.unread < Self::UNREAD {
            self.unread += 1;
            self.newest = self.newest.max(time);
            return time;
        }
        self.unread = 0;
        Reading::take().map_or(stamp, |reading| self.place(stamp, reading))
    }

    fn place(&mut self, stamp: Micros, reading: Reading) -> Micros {
        let step = (reading.offset - self.offset).abs();
        // One that was torn apart tells of no step that it could not have made itself.
        if step > Self::NO_STEP + reading.error {
            (self.before, self.offset) = (self.offset, reading.offset);
        }
        let now = reading.boot + self.at_start;
        let by = |offset: i64| stamp.0.saturating_sub(offset - self.at_start);
        // It was received after the one before it and before now. Where the clock has just been set, it may have
        // been stamped before or after that: only one of both lies there.
        let first = self.newest.0.saturating_sub(Self::TOLERANCE);
        let fits = |time: i64| (first..=now + Self::TOLERANCE).contains(&time);
        let mut time = by(self.offset);
        if !fits(time) && fits(by(self.before)) {
            time = by(self.before);
        }
        if !fits(time) {
            // Set twice while it waited.
            time = time.clamp(self.newest.0.min(now), now);
        }
        self.newest = self.newest.max(Micros(time));
        Micros(time)
    }
}

impl Reading {
    fn take() -> Option<Self> {
        let first = boot_time()?;
        let real = micros(ClockId::CLOCK_REALTIME)?;
        let last = boot_time()?;
        Some(Self { boot: last, offset: real - first.midpoint(last), error: last - first })
    }
}

fn boot_time() -> Option<i64> {
    micros(ClockId::CLOCK_BOOTTIME)
}

fn micros(clock: ClockId) -> Option<i64> {
    let now = Duration::from(clock.now().ok()?);
    i64::try_from(now.as_micros()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPOCH: i64 = 1_795_000_000_000_000;

    /// A machine whose clock is set now and then.
    struct Machine {
        boot: i64,
        offset: i64,
    }

    impl Machine {
        fn stamp(&self) -> Micros {
            Micros(self.boot + self.offset)
        }

        fn reading(&self) -> Reading {
            Reading { boot: self.boot, offset: self.offset, error: 0 }
        }

        fn clock(&self) -> SteadyClock {
            SteadyClock {
                at_start: self.offset,
                offset: self.offset,
                before: self.offset,
                newest: Micros(i64::MIN),
                unread: 0,
            }
        }
    }

    #[test]
    fn without_a_step_a_stamp_is_what_it_was() {
        let mut machine = Machine { boot: 5_000_000, offset: EPOCH };
        let mut clock = machine.clock();
        for late in [3, 40, 2_000_000] {
            let stamp = machine.stamp();
            machine.boot += late;
            // What the two readings of a clock differ by is no step.
            let reading = Reading { offset: EPOCH + late % 7, ..machine.reading() };
            assert_eq!(clock.place(stamp, reading), stamp);
        }
    }

    #[test]
    fn a_step_of_any_size_moves_no_frame_that_was_stamped_before_or_after_it() {
        for step in [-3_600_000_000, -950_000, -500_000, -20_000, 20_000, 500_000, 31_536_000_000_000] {
            let mut machine = Machine { boot: 5_000_000, offset: EPOCH };
            let mut clock = machine.clock();
            let (mut waiting, mut last) = (std::collections::VecDeque::new(), i64::MIN);
            for millis in 0..200 {
                machine.boot += 1000;
                waiting.push_back((machine.boot, machine.stamp()));
                if millis == 100 {
                    machine.offset += step;
                }
                // Ten of them wait to be read, those around the step, too.
                if waiting.len() > 10
                    && let Some((true_time, stamp)) = waiting.pop_front()
                {
                    let time = clock.place(stamp, machine.reading());
                    assert_eq!(time.0, true_time + EPOCH, "step {step}, {millis} ms");
                    assert!(time.0 > last);
                    last = time.0;
                }
            }
        }
    }

    #[test]
    fn two_steps_while_frames_wait_leave_them_between_the_last_one_and_now() {
        let mut machine = Machine { boot: 5_000_000, offset: EPOCH };
        let mut clock = machine.clock();
        let first = clock.place(machine.stamp(), machine.reading());
        machine.boot += 10_000;
        let waiting = machine.stamp();
        machine.offset += 3_600_000_000;
        machine.boot += 10_000;
        machine.offset += 7_000_000;
        let time = clock.place(waiting, machine.reading());
        assert!(first <= time && time.0 <= machine.boot + EPOCH, "{time:?}");
    }

    #[test]
    fn a_reading_that_was_torn_apart_is_no_step() {
        let machine = Machine { boot: 5_000_000, offset: EPOCH };
        let mut clock = machine.clock();
        let torn = Reading { offset: EPOCH + 40_000, error: 80_000, ..machine.reading() };
        assert_eq!(clock.place(machine.stamp(), torn), machine.stamp());
        assert_eq!(clock.offset, EPOCH);
    }

    #[test]
    fn the_present_is_that_of_the_clock_while_nobody_sets_it() {
        let clock = SteadyClock::start();
        let real = micros(ClockId::CLOCK_REALTIME).unwrap();
        let now = clock.now().unwrap().0;
        // Another test's machine may be slow; its clock is not set for that.
        assert!((now - real).abs() < 1_000_000, "{now} and {real}");
    }
}
