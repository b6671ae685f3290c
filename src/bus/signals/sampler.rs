//! From asynchronous frames to uniform samples.

use super::checks::{CounterTrack, Progress};
use super::config::SamplerConfig;
use super::counts::FaultCounts;
use super::grid::{Grid, Step};
use super::history::{At, History, Point};
use super::inputs::{Inputs, Traits};
use super::limits::RateCheck;
use super::mapping::{Mapping, Reading};
use super::plausibility::{Contradiction, CrossChecks, Run};
use super::rate_watch::RateWatch;
use crate::can::{CanId, Frame, FrameKind};
use physics::{Faults, Micros, Quantity, Sample};

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pushed {
    /// Not a needed identifier.
    Ignored,
    /// Its values were taken (or found not available).
    Used,
    /// It was dropped as a whole, for this reason.
    Dropped(Faults),
}

/// Makes uniform [`Sample`]s of frames that come when they like.
///
/// Sample times are multiples of the period on the frames' own time. A sample is made once a frame's
/// time has passed it by the configured lag, so that frames that come late or out of order are still
/// counted in. A value is interpolated between the frames around the instant, or held after the last
/// one until its time-out. What it makes is a function of the sequence of needed frames alone, so a
/// replay makes the live run's samples.
///
/// After each [`Sampler::push`] call [`Sampler::next_sample`] until it returns `None`. Neither allocates.
#[derive(Clone, Debug)]
pub struct Sampler {
    inputs: Inputs,
    index: IdIndex,
    grid: Grid,
    channels: Vec<Channel>,
    counters: Vec<CounterTrack>,
    /// How often each message comes; none where that is not watched.
    rates: Vec<RateWatch>,
    /// The message that came too often last.
    sent_twice: Option<CanId>,
    /// What each quality signal of another message last said, and when.
    gates: Vec<Option<(Micros, bool)>>,
    /// Quantities heard of, as bits.
    heard: u16,
    /// Those that the first sample waits for.
    awaited: u16,
    /// Events since the last sample.
    pending: Faults,
    /// Lasting conditions of the last sample.
    lasting: Faults,
    /// Quantities that the last sample found too old, as bits.
    too_old: u16,
    counts: FaultCounts,
    cross_checks: Option<CrossChecks>,
}

/// A configured quantity at work.
#[derive(Clone, Debug)]
struct Channel {
    quantity: Quantity,
    traits: Traits,
    history: History,
    /// Time of the first point since the start.
    since: Option<Micros>,
    rate: RateCheck,
    run: Run,
}

impl Sampler {
    /// A sampler that has not seen any frame. All memory is taken here.
    pub fn new(inputs: Inputs, config: &SamplerConfig) -> Self {
        let configured =
            || Quantity::ALL.into_iter().filter_map(|q| inputs.traits[q as usize].map(|t| (q, t)));
        let longest = configured().map(|(_, traits)| traits.delay).max().unwrap_or_default();
        let grid = Grid::new(config, longest);
        let reach = grid.reach();
        let channel = |(quantity, traits)| Channel {
            quantity,
            traits,
            history: History::reaching(reach),
            since: None,
            rate: RateCheck::default(),
            run: Run::default(),
        };
        let channels: Vec<Channel> = configured().map(channel).collect();
        Self {
            index: IdIndex::new(inputs.ids()),
            counters: vec![CounterTrack::default(); inputs.messages.len()],
            rates: inputs
                .messages
                .iter()
                .filter(|_| config.rate_watch)
                .map(|message| RateWatch::new(message.cycle))
                .collect(),
            sent_twice: None,
            gates: vec![None; inputs.messages.iter().map(|message| message.gates.len()).sum()],
            grid,
            channels,
            heard: 0,
            awaited: inputs.basic(),
            pending: Faults::empty(),
            lasting: Faults::empty(),
            too_old: 0,
            counts: FaultCounts::default(),
            cross_checks: config.cross_checks.then(|| CrossChecks::new(inputs.wheel_radius_m)),
            inputs,
        }
    }

    /// The mapping in use.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Faults since the start.
    pub fn counts(&self) -> &FaultCounts {
        &self.counts
    }

    /// Which sensors contradicted each other in the last sample.
    pub fn contradiction(&self) -> Option<Contradiction> {
        self.cross_checks.as_ref()?.reason()
    }

    /// The message that came too often last, by its name in the DBC.
    pub fn sent_twice(&self) -> Option<(&str, CanId)> {
        let id = self.sent_twice?;
        Some((self.inputs.message_name(id)?, id))
    }

    /// Time of the newest needed frame.
    pub fn now(&self) -> Option<Micros> {
        self.grid.now()
    }

    /// Time of a quantity's newest value that could be used.
    pub fn last_seen(&self, quantity: Quantity) -> Option<Micros> {
        self.newest(quantity).map(|(time, _)| time)
    }

    /// A quantity's newest value that could be used, in SI, and its time.
    pub fn newest(&self, quantity: Quantity) -> Option<(Micros, f64)> {
        let channel = self.channels.iter().find(|channel| channel.quantity == quantity)?;
        let newest = channel.history.last().filter(|point| !point.value.is_nan())?;
        Some((newest.time, newest.value))
    }

    /// Goes on where another sampler ended: in its time, and with its counts. What it held of values is left
    /// to it, for they were read by another mapping.
    pub fn follow(&mut self, before: &Sampler) {
        self.grid.follow(&before.grid);
        self.counts = before.counts;
    }

    /// Takes a frame. Frames that are not needed change nothing, not even the time.
    ///
    /// Of a needed identifier any data frame will do, classic or FD, that has at least the bytes the DBC
    /// gives the message; remote requests and shorter frames are dropped with [`Faults::FRAME`].
    #[inline]
    pub fn push(&mut self, frame: &Frame) -> Pushed {
        match self.index.find(frame.id) {
            Some(index) if frame.kind != FrameKind::Error => self.push_needed(frame, index),
            _ => Pushed::Ignored,
        }
    }

    fn push_needed(&mut self, frame: &Frame, index: usize) -> Pushed {
        match self.grid.advance(frame.time) {
            Step::Onward => {}
            Step::Late if self.grid.last().is_some_and(|sampled| frame.time <= sampled) => {
                self.note(Faults::TIME);
            }
            Step::Late => {}
            Step::Gap => self.note(Faults::TIME),
            Step::Back => {
                self.note(Faults::TIME);
                self.forget();
            }
        }
        // What is dropped anyway, such as a frame that a gateway repeats, is not one too many.
        let reason = self
            .check(frame, index)
            .or_else(|| self.too_often(frame, index))
            .unwrap_or_else(|| self.take(frame, index));
        self.grid.start(self.heard & self.awaited == self.awaited);
        if reason.is_empty() {
            Pushed::Used
        } else {
            self.pending |= reason;
            self.counts.record(reason - Faults::SENT_TWICE);
            Pushed::Dropped(reason)
        }
    }

    /// The next sample that is due, if any.
    #[inline]
    pub fn next_sample(&mut self) -> Option<Sample> {
        let (time, elapsed_s) = self.grid.due()?;
        Some(self.sample(time, elapsed_s))
    }

    fn sample(&mut self, time: Micros, elapsed_s: f64) -> Sample {
        let mut sample = Sample::empty(time, elapsed_s);
        let mut lasting = Faults::empty();
        let mut too_old = 0;
        let starting = self.grid.is_starting();
        for channel in &self.channels {
            match channel.history.at(time, channel.traits.interpolate, channel.traits.timeout) {
                At::Value(value) => sample.set(channel.quantity, value),
                At::NotAvailable => lasting |= Faults::NOT_AVAILABLE,
                At::TooOld if starting && channel.since.is_none_or(|since| since > time) => {}
                At::TooOld => too_old |= 1 << channel.quantity as usize,
            }
        }
        for _ in 0..(too_old & !self.too_old).count_ones() {
            self.counts.record(Faults::TIMEOUT);
        }
        self.too_old = too_old;
        if too_old != 0 {
            lasting |= Faults::TIMEOUT;
        }
        if let Some(checks) = &mut self.cross_checks {
            for channel in &self.channels {
                checks.runs[channel.quantity as usize] = channel.run;
            }
            let found = checks.check(&mut sample);
            self.counts.record(found - self.lasting);
            lasting |= found;
        }
        sample.faults = lasting | self.pending;
        self.pending = Faults::empty();
        self.lasting = lasting;
        sample
    }

    /// At the end of a recording: the samples up to the last frame become due without waiting.
    pub fn flush(&mut self) {
        self.grid.end();
    }

    fn note(&mut self, faults: Faults) {
        self.pending |= faults;
        self.counts.record(faults);
    }

    /// After a step of the clock nothing older says anything of what comes.
    fn forget(&mut self) {
        for channel in &mut self.channels {
            channel.history.clear();
            channel.since = None;
            channel.rate = RateCheck::default();
            channel.run = Run::default();
        }
        self.counters.fill(CounterTrack::default());
        self.rates.iter_mut().for_each(RateWatch::forget);
        self.gates.fill(None);
        self.heard = 0;
        self.too_old = 0;
        if let Some(checks) = &mut self.cross_checks {
            checks.forget();
        }
    }

    /// Is it one of two senders'? It is told with every frame, and counted when it begins.
    fn too_often(&mut self, frame: &Frame, index: usize) -> Option<Faults> {
        let (too_often, begins) = self.rates.get_mut(index)?.count(frame.time);
        if begins {
            self.counts.record(Faults::SENT_TWICE);
            self.sent_twice = Some(frame.id);
        }
        too_often.then_some(Faults::SENT_TWICE)
    }

    /// Kind, length, checksum and counter: the reason to drop the frame, if there is one.
    fn check(&mut self, frame: &Frame, index: usize) -> Option<Faults> {
        let message = &self.inputs.messages[index];
        let data = frame.data();
        if !frame.is_data() || data.len() < message.length {
            return Some(Faults::FRAME);
        }
        if message.checksum.as_ref().is_some_and(|checksum| !checksum.is_right(data)) {
            return Some(Faults::CHECKSUM);
        }
        let counter = message.counter.as_ref()?;
        match self.counters[index].judge(counter, frame.time, counter.read(data)?) {
            Progress::Fresh => None,
            Progress::Repeated => Some(Faults::COUNTER),
            Progress::Jumped => {
                self.note(Faults::COUNTER);
                None
            }
        }
    }

    /// Takes all values of a frame. Returns why, if its time leaves no place for them.
    fn take(&mut self, frame: &Frame, index: usize) -> Faults {
        let mut taken = Faults::empty();
        let mut dropped = Faults::empty();
        let data = frame.data();
        let message = &self.inputs.messages[index];
        for gate in &message.gates {
            let known = &mut self.gates[gate.number];
            if let Some(allowed) = gate.quality.allows(data)
                && known.is_none_or(|(time, _)| time <= frame.time)
            {
                *known = Some((frame.time, allowed));
            }
        }
        for mapping in &message.mappings {
            let place = self.inputs.places[mapping.quantity as usize];
            let Some(channel) = self.channels.get_mut(usize::from(place)) else { continue };
            let time = frame.time - channel.traits.delay;
            let value = match passed(&self.gates, mapping, frame.time, channel.traits.timeout)
                .unwrap_or_else(|| mapping.read(data))
            {
                Reading::NotInThisFrame => continue,
                Reading::NotAvailable => {
                    taken |= Faults::NOT_AVAILABLE;
                    f64::NAN
                }
                Reading::Value(value) if !channel.traits.limits.holds(value) => {
                    taken |= Faults::RANGE;
                    f64::NAN
                }
                Reading::Value(value) => value,
            };
            self.heard |= 1 << mapping.quantity as usize;
            if channel.history.last().is_some_and(|last| time < last.time) {
                dropped |= Faults::TIME;
                continue;
            }
            if !value.is_nan() {
                channel.run.follow(time, value);
                if !channel.rate.accepts(&channel.traits.limits, channel.traits.timeout, time, value) {
                    taken |= Faults::RATE;
                    continue;
                }
            }
            channel.since = channel.since.or(Some(time));
            channel.history.push(Point { time, value });
        }
        self.note(taken);
        dropped
    }
}

/// What the quality signals of other messages say against a value; `None` if nothing.
#[inline]
fn passed(
    gates: &[Option<(Micros, bool)>],
    mapping: &Mapping,
    now: Micros,
    timeout: Micros,
) -> Option<Reading> {
    mapping.gates.iter().find_map(|gate| match gates[*gate] {
        Some((time, true)) if now - time <= timeout => None,
        Some((time, false)) if now - time <= timeout => Some(Reading::NotAvailable),
        // Nothing is known of its quality: as if the value had not come.
        _ => Some(Reading::NotInThisFrame),
    })
}

/// Finds the place of a needed identifier: a table for standard ones, a search for extended ones.
#[derive(Clone, Debug)]
struct IdIndex {
    standard: Box<[u16; IdIndex::STANDARD]>,
    extended: Vec<(CanId, usize)>,
}

impl IdIndex {
    const STANDARD: usize = CanId::MAX_STANDARD as usize + 1;
    const NONE: u16 = u16::MAX;

    fn new(ids: &[CanId]) -> Self {
        let mut standard = Box::new([Self::NONE; Self::STANDARD]);
        let mut extended = Vec::new();
        for (place, id) in ids.iter().enumerate() {
            if id.is_extended() {
                extended.push((*id, place));
            } else {
                standard[id.number() as usize] = place as u16;
            }
        }
        Self { standard, extended }
    }

    #[inline]
    fn find(&self, id: CanId) -> Option<usize> {
        if id.is_extended() {
            let at = self.extended.binary_search_by_key(&id, |(id, _)| *id).ok()?;
            Some(self.extended[at].1)
        } else {
            let place = self.standard[id.number() as usize % Self::STANDARD];
            (place != Self::NONE).then_some(usize::from(place))
        }
    }
}
