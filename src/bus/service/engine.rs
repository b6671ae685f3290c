//! The engine: frames in, frames out. Live, in replay, in tests and benchmarks it is the same one.

use super::{SetupError, saved};
use crate::Config;
use crate::can::{CanId, Frame, FrameKind};
use crate::dbc::Database;
use crate::signals::publish::Publisher;
use crate::signals::{FaultCounts, Inputs, Pushed, Sampler, SamplerConfig};
use physics::estimate::{Contradiction, Doubt, EstimatorsConfig, Learned, Pipeline};
use physics::estimates::State;
use physics::model::Vehicle;
use physics::model::effect::EffectConfig;
use physics::{Estimates, Faults, Micros, Quantity, Sample, Sensors};

/// Who takes what the engine makes.
pub trait Sink {
    /// A sample and what the estimators know after it.
    fn estimates(&mut self, _sample: &Sample, _estimates: &Estimates) {}
    /// A frame to be published.
    fn publish(&mut self, frame: &Frame);
}

/// Sampler, estimators and publisher in a row. Does no I/O, knows no clock, and does not allocate
/// once built.
#[derive(Clone, Debug)]
pub struct Engine {
    sampler: Sampler,
    pipeline: Pipeline,
    publisher: Publisher,
    origin: Origin,
    period: Micros,
    next_publication: Option<Micros>,
    /// After so long without any frame no required quantity is there any more.
    silence: Micros,
    /// Nothing has come for that long.
    is_silent: bool,
    /// Faults since the last publication.
    faults: Faults,
    /// How often each was reported from outside, or began in the estimators.
    reported: FaultCounts,
    /// What the estimators say of themselves, of the last sample.
    doubted: Faults,
    /// Faults of the last publication.
    told: Faults,
    /// Faults that every publication tells until they are taken back.
    lasting: Faults,
    dropped: u64,
    counts: EngineCounts,
}

/// What the estimators were made of, besides the compiled mapping.
#[derive(Clone, Debug, PartialEq)]
struct Origin {
    sampling: SamplerConfig,
    vehicle: Vehicle,
    estimators: EstimatorsConfig,
    effects: Vec<EffectConfig>,
    fingerprint: String,
}

/// What of an engine lives on in the one that takes its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Survived {
    /// All that it knew: nothing that its estimates stand on has changed.
    Everything,
    /// What would outlive the drive: it is the same car, otherwise measured or estimated.
    Learned,
    /// Nothing: it is another car, or another mapping.
    Nothing,
}

/// What went through the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EngineCounts {
    /// Frames offered.
    pub frames_in: u64,
    /// Frames published.
    pub frames_out: u64,
    /// Samples made.
    pub samples: u64,
}

impl Engine {
    /// Estimates older than this are not published any more. Samples wait for late frames by some tens
    /// of milliseconds, at most a second.
    const STALE_AFTER: Micros = Micros::from_millis(1500);

    /// Builds everything from a configuration. Warnings (of DBC files, of optional things left out)
    /// go to the log.
    ///
    /// # Errors
    /// Everything that is wrong with DBC files and the mapping.
    pub fn new(config: &Config) -> Result<Self, SetupError> {
        Self::with_databases(config, &config.input_database()?, &config.output_database()?)
    }

    /// The same with databases that are loaded already.
    ///
    /// # Errors
    /// Everything that is wrong with the mapping.
    pub fn with_databases(config: &Config, input: &Database, output: &Database) -> Result<Self, SetupError> {
        for warning in input.warnings().iter().chain(output.warnings()) {
            tracing::debug!("{warning}");
        }
        let inputs = Inputs::compile(&config.signals, input, config.vehicle.wheel_radius_m.value)?;
        let publisher = Publisher::new(output, &config.publish)?;
        for warning in publisher.warnings() {
            tracing::warn!("{warning}");
        }
        if let Some(id) = publisher.ids().iter().find(|id| inputs.ids().contains(id)) {
            return Err(SetupError::OwnIdentifier { id: *id });
        }
        let pipeline = Pipeline::new(&config.vehicle, &sensors(&inputs), &config.estimators)
            .with_effects(&config.vehicle, &config.effect);
        let silence = inputs.longest_timeout();
        Ok(Self {
            silence,
            is_silent: false,
            sampler: Sampler::new(inputs, &config.signals.sampling),
            pipeline,
            period: publisher.period(),
            publisher,
            origin: Origin {
                sampling: config.signals.sampling,
                vehicle: config.vehicle.clone(),
                estimators: config.estimators.clone(),
                effects: config.effect.clone(),
                fingerprint: saved::fingerprint(config),
            },
            next_publication: None,
            faults: Faults::empty(),
            reported: FaultCounts::default(),
            doubted: Faults::empty(),
            told: Faults::empty(),
            lasting: Faults::empty(),
            dropped: 0,
            counts: EngineCounts::default(),
        })
    }

    /// The same with the thesis's estimators beside those that are published ([`Pipeline::with_thesis`]): for who
    /// reads [`Estimates::thesis`]. Before the first frame.
    #[must_use]
    pub fn with_thesis(mut self) -> Self {
        self.pipeline = self.pipeline.with_thesis();
        self
    }

    /// Goes on from what an earlier drive learned ([`Pipeline::restore`]). Before the first frame. What contradicts
    /// the car's table is not taken, and the log says so.
    pub fn restore(&mut self, learned: &Learned) {
        if let Some(contradiction) = self.pipeline.restore(learned) {
            tracing::warn!("what was learned before is not taken as far as that goes: the {contradiction}");
        }
    }

    /// Takes the place of another engine, between two frames: what it has received but not yet sampled is
    /// sampled, what it knows goes on as far as it still applies, and so do counters and counts.
    pub fn take_over(&mut self, mut before: Engine, sink: &mut impl Sink) -> Survived {
        let same_samples = self.origin.sampling == before.origin.sampling
            && self.sampler.inputs() == before.sampler.inputs();
        if !same_samples {
            before.finish(sink);
        }
        let survived = if same_samples && self.origin == before.origin {
            Survived::Everything
        } else if self.origin.fingerprint == before.origin.fingerprint {
            Survived::Learned
        } else {
            Survived::Nothing
        };
        match survived {
            Survived::Everything => self.pipeline = before.pipeline,
            Survived::Learned => self.restore(&before.learned()),
            Survived::Nothing => {}
        }
        if same_samples {
            self.sampler = before.sampler;
        } else {
            self.sampler.follow(&before.sampler);
        }
        self.publisher.follow(&before.publisher);
        self.next_publication = before.next_publication.filter(|_| self.period == before.period);
        self.faults |= before.faults;
        (self.reported, self.doubted) = (before.reported, before.doubted);
        self.lasting = before.lasting;
        self.dropped = before.dropped;
        self.pipeline.set_dropped_frames(self.dropped);
        self.counts = before.counts;
        survived
    }

    /// Begins anew with what is left when these parts are forgotten: other tires, for one.
    pub fn forget(&mut self, parts: &[saved::Part]) {
        let learned = saved::without(self.learned(), parts);
        let Origin { vehicle, estimators, effects, .. } = &self.origin;
        self.pipeline = Pipeline::new(vehicle, &sensors(self.sampler.inputs()), estimators)
            .with_effects(vehicle, effects);
        self.pipeline.restore(&learned);
        self.pipeline.set_dropped_frames(self.dropped);
        self.doubted = Faults::empty();
    }

    /// What was learned and is not worth keeping, since it contradicts the car's table ([`Pipeline::contradiction`]).
    pub fn contradiction(&self) -> Option<Contradiction> {
        self.pipeline.contradiction()
    }

    /// What is worth keeping for the next drive ([`Pipeline::learned`]).
    pub fn learned(&self) -> Learned {
        self.pipeline.learned()
    }

    /// The same, and in the place of what is not worth keeping what was known before this drive.
    pub fn learned_or(&self, before: &Learned) -> Learned {
        self.pipeline.learned_or(before)
    }

    /// Seconds that the car moved, those of earlier drives included if they were restored.
    pub fn driving_s(&self) -> f64 {
        self.pipeline.driving_s()
    }

    /// Identifiers that are needed: all others may be filtered out before.
    pub fn ids(&self) -> &[CanId] {
        self.sampler.inputs().ids()
    }

    /// Takes a frame; hands on the samples it completes, and what is then due to be published.
    pub fn frame(&mut self, frame: &Frame, sink: &mut impl Sink) {
        self.counts.frames_in += 1;
        if frame.kind == FrameKind::Error {
            // In a recording with error frames; live they come as events of the bus.
            self.report(Faults::BUS_ERROR);
            return;
        }
        if self.sampler.push(frame) == Pushed::Ignored {
            return;
        }
        self.is_silent = false;
        self.drain(sink);
        // Not the frame's time: one that comes late must not bring the last round once more.
        if let Some(now) = self.sampler.now() {
            self.publish_if_due(now, sink);
        }
    }

    /// At the end of a recording: the samples that waited for later frames.
    pub fn finish(&mut self, sink: &mut impl Sink) {
        self.sampler.flush();
        self.drain(sink);
    }

    /// Now and then while frames come live, or do not, once all that came is here: when it has been silent for so long
    /// that nothing is known any more, rounds go on all the same, with everything not available.
    pub fn idle(&mut self, now: Micros, sink: &mut impl Sink) {
        let Some(newest) = self.sampler.now().filter(|_| self.counts.samples > 0) else { return };
        if now - newest <= self.silence || !self.is_due(now) {
            return;
        }
        if !std::mem::replace(&mut self.is_silent, true) {
            self.reported.record(Faults::TIMEOUT);
        }
        self.faults |= Faults::TIMEOUT;
        let nothing = Self::nothing_since(self.pipeline.latest());
        self.publish(now, nothing, sink);
    }

    /// A last round, with everything not available, if there was any before it.
    pub fn farewell(&mut self, now: Micros, sink: &mut impl Sink) {
        if self.counts.samples == 0 {
            return;
        }
        self.report(Faults::ENDING);
        let nothing = Self::nothing_since(self.pipeline.latest());
        self.publish(now, nothing, sink);
    }

    /// Something is wrong with the bus; it shows in the next status frame.
    pub fn report(&mut self, faults: Faults) {
        self.faults |= faults;
        self.reported.record(faults);
    }

    /// The faults of the round that was published last.
    pub fn told(&self) -> Faults {
        self.told
    }

    /// A round that told these faults did not get through: the next one tells them once more.
    pub fn untold(&mut self, told: Faults) {
        self.faults |= told;
    }

    /// Something is wrong that lasts, or (`false`) is wrong no more: every status frame tells it meanwhile. It is
    /// counted when it begins.
    pub fn set_lasting(&mut self, faults: Faults, wrong: bool) {
        if wrong {
            self.report(faults - self.lasting);
        }
        self.lasting.set(faults, wrong);
    }

    /// Frames were lost before they came here.
    pub fn report_dropped(&mut self, count: u64) {
        if count == 0 {
            return;
        }
        self.dropped = self.dropped.saturating_add(count);
        self.report(Faults::DROPPED);
        self.pipeline.set_dropped_frames(self.dropped);
    }

    /// What went through so far.
    pub fn counts(&self) -> EngineCounts {
        self.counts
    }

    /// What it can do at the moment.
    pub fn state(&self) -> State {
        self.pipeline.latest().state
    }

    /// Faults of the last sample and of the estimates made of it.
    pub fn latest_faults(&self) -> Faults {
        self.pipeline.latest().faults
    }

    /// What was wrong at any time since the last round but one: of the bus, of samples and of the estimators.
    pub fn present_faults(&self) -> Faults {
        self.faults | self.told
    }

    /// How often the surface has changed.
    pub fn surface_changes(&self) -> u32 {
        self.pipeline.latest().surface_changes
    }

    /// Of `[vehicle]` and the mapping: whose state it is.
    pub(super) fn fingerprint(&self) -> &str {
        &self.origin.fingerprint
    }

    /// Why the lateral filter does not believe itself at the moment.
    pub fn doubt(&self) -> Option<Doubt> {
        self.pipeline.doubt()
    }

    /// How often a fault began or was reported.
    pub fn occurrences(&self, fault: Faults) -> u64 {
        self.sampler.counts().get(fault) + self.reported.get(fault)
    }

    /// How often each fault began or was reported.
    pub fn fault_counts(&self) -> FaultCounts {
        self.reported.plus(self.sampler.counts())
    }

    /// The publisher, for those who read what it sends.
    pub fn publisher(&self) -> &Publisher {
        &self.publisher
    }

    /// The sampler, for what it knows of the inputs.
    pub fn sampler(&self) -> &Sampler {
        &self.sampler
    }

    fn drain(&mut self, sink: &mut impl Sink) {
        while let Some(sample) = self.sampler.next_sample() {
            self.counts.samples += 1;
            let estimates = self.pipeline.step(&sample);
            self.faults |= estimates.faults;
            let doubted = estimates.faults - sample.faults;
            self.reported.record(doubted - self.doubted);
            self.doubted = doubted;
            sink.estimates(&sample, estimates);
        }
    }

    /// The latest estimates, unless nothing came for so long that they are of another moment.
    #[inline]
    fn current(&self, now: Micros) -> Estimates {
        let latest = self.pipeline.latest();
        if now - latest.time <= Self::STALE_AFTER { *latest } else { Self::nothing_since(latest) }
    }

    #[cold]
    fn nothing_since(latest: &Estimates) -> Estimates {
        Estimates {
            time: latest.time,
            // Without any sample: after a reload, until there is one.
            state: if latest.state == State::Starting { State::Starting } else { State::NoInput },
            surface_changes: latest.surface_changes,
            dropped_frames: latest.dropped_frames,
            ..Estimates::default()
        }
    }

    /// Publication runs on frame time, on multiples of the period: a replay publishes what the live
    /// run did, wherever either began. Nothing is published before the first sample, and nothing
    /// while no frames come ([`Engine::idle`] does that): never a stale value with a live counter.
    fn publish_if_due(&mut self, now: Micros, sink: &mut impl Sink) {
        if self.counts.samples == 0 || !self.is_due(now) {
            return;
        }
        let estimates = self.current(now);
        self.publish(now, estimates, sink);
    }

    fn is_due(&mut self, now: Micros) -> bool {
        let due = *self.next_publication.get_or_insert_with(|| now.next_multiple_of(self.period));
        // After the clock was set back, the next multiple lies far ahead: start again.
        let stepped_back = due - now > self.period;
        now >= due || stepped_back
    }

    fn publish(&mut self, now: Micros, mut estimates: Estimates, sink: &mut impl Sink) {
        self.next_publication = Some((now + Micros(1)).next_multiple_of(self.period));
        self.told = std::mem::take(&mut self.faults);
        estimates.faults |= self.told | self.lasting;
        let sent = &mut self.counts.frames_out;
        self.publisher.publish(now, &estimates, &mut |frame| {
            *sent += 1;
            sink.publish(frame);
        });
    }
}

/// What the mapping tells the estimators of the sensors.
pub fn sensors(inputs: &Inputs) -> Sensors {
    let mut sensors = Sensors::default();
    for quantity in Quantity::ALL.into_iter().filter(|quantity| inputs.has(*quantity)) {
        sensors.add(quantity, inputs.noise_std(quantity));
    }
    sensors
}
