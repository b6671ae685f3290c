//! Does a message come more often than it should? Then two nodes send it, and nobody can tell whom to believe.
//!
//! How often it should come is learned from the first two seconds in which it comes evenly; where only every other
//! frame does, and at the DBC's cycle time, two nodes send it from the start. (In that order: cars are often faster than
//! their DBC says.) A message that comes when something happens is not watched.

use physics::Micros;

/// The rate of one message, and what it should be.
#[derive(Clone, Debug)]
pub(super) struct RateWatch {
    /// Frames of the last two seconds, in slices.
    slices: [u32; SLICES],
    /// Their sum.
    recent: u32,
    /// Number of the newest slice on the frames' own time; `None` before the first frame.
    slice: Option<i64>,
    cycle: Cycle,
    /// The DBC's, s.
    in_dbc: Option<f64>,
    too_often: bool,
}

const SLICES: usize = 20;
const SLICE: Micros = Micros::from_millis(100);

/// What is known of the cycle.
#[derive(Clone, Copy, Debug)]
enum Cycle {
    /// Nothing yet: these frames came so far.
    Learning(Gaps),
    /// s between two frames; `None`: it has none.
    Known(Option<f64>),
}

/// The distances of frames of two seconds.
#[derive(Clone, Copy, Debug, Default)]
struct Gaps {
    begun: Option<Micros>,
    /// The last frame, and the one before it.
    last: [Option<Micros>; 2],
    /// From each frame to the next, and to the one after that.
    next: Spread,
    second: Spread,
    /// Stretches of two seconds that were not even.
    uneven: u32,
}

/// Mean and spread of some distances.
#[derive(Clone, Copy, Debug, Default)]
struct Spread {
    count: u32,
    sum_s: f64,
    squares_s2: f64,
}

impl Spread {
    fn add(&mut self, gap: Micros) {
        let gap = gap.seconds();
        (self.count, self.sum_s, self.squares_s2) =
            (self.count + 1, self.sum_s + gap, self.squares_s2 + gap * gap);
    }

    /// The mean, s, if they are enough, and all about the same.
    fn cycle(&self) -> Option<f64> {
        let count = f64::from(self.count.max(1));
        let mean = self.sum_s / count;
        let spread = (self.squares_s2 / count - mean * mean).max(0.0).sqrt();
        (self.count >= RateWatch::FEWEST && spread < RateWatch::EVEN * mean).then_some(mean)
    }
}

impl RateWatch {
    /// Above so many times its rate, it is sent twice.
    const MOST: f64 = 1.3;
    /// Two senders that both keep the DBC's cycle are as near to it as this share.
    const AS_IN_DBC: f64 = 0.15;
    /// Frames that are fewer tell no rate.
    const FEWEST: u32 = 15;
    /// Even is what spreads by less than this share of the mean distance. The frames of two senders of one message,
    /// one after the other, spread by more unless one comes just in the middle between those of the other.
    const EVEN: f64 = 0.25;
    const STRETCH: Micros = Micros::from_millis(2000);
    /// After so many stretches that are not even there is no use in waiting for one.
    const PATIENCE: u32 = 3;

    /// Of a message whose cycle time in the DBC this is.
    pub(super) fn new(in_dbc: Option<Micros>) -> Self {
        Self {
            slices: [0; SLICES],
            recent: 0,
            slice: None,
            cycle: Cycle::Learning(Gaps::default()),
            in_dbc: in_dbc.map(|cycle| cycle.seconds()),
            too_often: false,
        }
    }

    /// After a step of the clock: what is known of the cycle stays.
    pub(super) fn forget(&mut self) {
        (self.slices, self.recent, self.slice, self.too_often) = ([0; SLICES], 0, None, false);
        if let Cycle::Learning(gaps) = &mut self.cycle {
            *gaps = Gaps { uneven: gaps.uneven, ..Gaps::default() };
        }
    }

    /// A frame came. Is it one of too many, and has that just begun?
    pub(super) fn count(&mut self, time: Micros) -> (bool, bool) {
        let slice = time.0.div_euclid(SLICE.0);
        let newest = *self.slice.get_or_insert(slice);
        // What is late counts where the newest do.
        for passed in (newest + 1..=slice).take(SLICES) {
            let place = passed.rem_euclid(SLICES as i64) as usize;
            self.recent -= std::mem::take(&mut self.slices[place]);
        }
        if slice - newest >= SLICES as i64 {
            (self.slices, self.recent) = ([0; SLICES], 0);
        }
        self.slice = Some(newest.max(slice));
        let place = newest.max(slice).rem_euclid(SLICES as i64) as usize;
        self.slices[place] = self.slices[place].saturating_add(1);
        self.recent = self.recent.saturating_add(1);
        if let Cycle::Learning(gaps) = &mut self.cycle
            && let Some(cycle) = gaps.learn(time, self.in_dbc)
        {
            self.cycle = cycle;
        }
        let Cycle::Known(Some(cycle_s)) = self.cycle else { return (false, false) };
        let most = (Self::MOST * Self::STRETCH.seconds() / cycle_s).max(f64::from(Self::FEWEST));
        let before = std::mem::replace(&mut self.too_often, f64::from(self.recent) > most);
        (self.too_often, self.too_often && !before)
    }
}

impl Gaps {
    /// Takes the next frame; what the cycle is, once it is known.
    fn learn(&mut self, time: Micros, in_dbc: Option<f64>) -> Option<Cycle> {
        let begun = *self.begun.get_or_insert(time);
        let [last, before] = self.last;
        last.into_iter().for_each(|last| self.next.add(time - last));
        before.into_iter().for_each(|before| self.second.add(time - before));
        self.last = [Some(time), last];
        if time - begun < RateWatch::STRETCH {
            return None;
        }
        if let Some(cycle) = self.next.cycle() {
            return Some(Cycle::Known(Some(cycle)));
        }
        // Every other frame comes evenly, and as the DBC has it: there are two senders from the start.
        let as_in_dbc =
            |cycle: &f64| in_dbc.is_some_and(|dbc| (cycle / dbc - 1.0).abs() < RateWatch::AS_IN_DBC);
        if let Some(cycle) = self.second.cycle().filter(as_in_dbc) {
            return Some(Cycle::Known(Some(cycle)));
        }
        let uneven = self.uneven + 1;
        *self = Self { uneven, ..Self::default() };
        (uneven >= RateWatch::PATIENCE).then_some(Cycle::Known(None))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many frames were too many of those that come at these times, s.
    fn too_many(watch: &mut RateWatch, times: impl IntoIterator<Item = f64>) -> usize {
        times.into_iter().filter(|time| watch.count(Micros::from_seconds(*time)).0).count()
    }

    fn each(period: f64, from: f64, to: f64) -> impl Iterator<Item = f64> {
        (0..).map(move |n| from + f64::from(n) * period).take_while(move |time| *time < to)
    }

    /// Two senders of one message.
    fn both(one: impl Iterator<Item = f64>, other: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut all: Vec<f64> = one.chain(other).collect();
        all.sort_by(f64::total_cmp);
        all
    }

    #[test]
    fn a_second_sender_is_found_within_a_second_and_forgotten_after_two() {
        for period in [0.01, 0.02, 0.1] {
            let mut watch = RateWatch::new(None);
            assert_eq!(too_many(&mut watch, each(period, 0.0, 10.0)), 0);
            // Right behind the first, and in the middle.
            for behind in [0.1, 0.5] {
                let two = both(each(period, 10.0, 20.0), each(period, 10.0 + behind * period, 20.0));
                let frames = two.len();
                let found = too_many(&mut watch, two);
                assert!(found as f64 > 0.85 * frames as f64, "{found} of {frames} at {period} s");
                too_many(&mut watch, each(period, 20.0, 22.0));
                assert_eq!(too_many(&mut watch, each(period, 22.0, 30.0)), 0);
                watch.forget();
            }
        }
    }

    #[test]
    fn two_from_the_start_are_found_by_the_dbc_and_one_that_is_faster_than_the_dbc_is_not() {
        let dbc = Some(Micros::from_millis(10));
        let mut watch = RateWatch::new(dbc);
        let two = both(each(0.01, 0.0, 20.0), each(0.01, 0.002, 20.0));
        assert!(too_many(&mut watch, two) > 2500);
        let mut watch = RateWatch::new(dbc);
        assert_eq!(too_many(&mut watch, each(0.005, 0.0, 20.0)), 0);
    }

    #[test]
    fn jitter_gaps_batches_and_events_are_none() {
        // A tenth of a millisecond to four, from one number to the next anywhere.
        let jitter = |n: u32| f64::from(n.wrapping_mul(2_654_435_761) >> 16) / 65_536.0 * 0.004;
        let mut watch = RateWatch::new(Some(Micros::from_millis(10)));
        let shaken = |from: u32, to: u32| (from..to).map(move |n| f64::from(n) * 0.01 + jitter(n));
        assert_eq!(too_many(&mut watch, shaken(0, 2000)), 0);
        assert_eq!(too_many(&mut watch, shaken(2300, 4000)), 0, "after a gap");
        let mut watch = RateWatch::new(Some(Micros::from_millis(10)));
        assert_eq!(too_many(&mut watch, (0..4000).map(|n| f64::from(n / 10) * 0.1)), 0, "ten at a time");
        let mut watch = RateWatch::new(None);
        let events = (0..4000u32).map(|n| f64::from(n / 40) + f64::from(n % 40) * 0.002);
        assert_eq!(too_many(&mut watch, events), 0);
        // And it may come slower than it was learned.
        let mut watch = RateWatch::new(None);
        assert_eq!(too_many(&mut watch, each(0.01, 0.0, 5.0).chain(each(0.1, 5.0, 20.0))), 0);
    }

    #[test]
    fn any_times_are_borne() {
        let mut watch = RateWatch::new(Some(Micros(1)));
        for time in [i64::MIN / 2, i64::MAX / 2, 0, -1, 5, i64::MAX / 2, i64::MIN / 2] {
            watch.count(Micros(time));
        }
        watch.forget();
        watch.count(Micros(0));
    }
}
