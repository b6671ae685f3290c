//! What goes on at a bus or in a recording, for those who look at it: nothing here ever sends a frame.
//!
//! ```text
//! bus or recording ─Source─► Watch ─┬─ Engine ─► published frames ─┐
//!                                   └─ frames that gripd published ┴─ Receiver ─► Round ─► Series of Rows
//! ```
//!
//! What is shown of the estimates is always read from published frames, as any receiver would: from those on the
//! bus, or from those that an engine of our own would send. Time is the frames' own; [`Watch::advance`] is told how
//! late it is.

mod playback;
mod receiver;
mod round;
mod series;
mod source;
mod traffic;
mod view;
mod words;

use crate::Config;
use crate::can::{CanId, ErrorReport, Frame};
use crate::service::{Engine, SetupError, Sink};
use physics::estimate::Learned;
use physics::{Estimates, Faults, Micros, Quantity, Sample};

pub use playback::{Pace, Playback};
pub use receiver::{Heard, Receiver, Word};
pub use round::Round;
pub use series::{Column, Row, Series};
pub use source::{Happening, Link, Listener, Source};
pub use traffic::Traffic;
pub use view::{InputNow, Told};
pub use words::{fault_words, quantity_label, quantity_shown, source_words, state_words};

/// Whose estimates are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// Those that a gripd on the bus publishes (or had published, in a recording).
    Bus,
    /// Those that an engine in this process makes of the same inputs.
    Own,
}

/// Everything that is known of a bus or recording at the moment, and some minutes back.
#[derive(Clone)]
pub struct Watch {
    engine: Engine,
    /// What the own engine publishes goes here and nowhere else.
    own: Receiver,
    bus: Receiver,
    estimator: Estimator,
    newest: Option<Sample>,
    inputs: Vec<Traffic>,
    series: Series,
    now: Micros,
    /// Time of the newest frame of any kind.
    last_frame: Option<Micros>,
    link: Option<Link>,
    errors: u64,
    last_error: Option<ErrorReport>,
    dropped: u64,
    /// When each fault was told last.
    faults: [Option<Micros>; Faults::COUNT],
    /// Faults since the last row.
    faults_of_row: Faults,
}

/// Takes what the own engine makes.
struct Eavesdrop<'a> {
    newest: &'a mut Option<Sample>,
    own: &'a mut Receiver,
}

impl Sink for Eavesdrop<'_> {
    fn estimates(&mut self, sample: &Sample, _estimates: &Estimates) {
        *self.newest = Some(*sample);
    }

    fn publish(&mut self, frame: &Frame) {
        self.own.take(frame);
    }
}

impl Watch {
    /// A fault is shown so long after it was told last: one status of 20 ms nobody would see.
    const FAULT_STAYS: Micros = Micros(1_500_000);

    /// Knows nothing yet. Of `[publish]`, `enabled` does not matter here: what is published is to be read.
    ///
    /// # Errors
    /// Everything that is wrong with DBC files and the mapping.
    pub fn new(config: &Config, estimator: Estimator) -> Result<Self, SetupError> {
        let mut config = config.clone();
        config.publish.enabled = true;
        let (input, output) = (config.input_database()?, config.output_database()?);
        let engine = Engine::with_databases(&config, &input, &output)?;
        let receiver = Receiver::new(engine.publisher(), &output);
        let inputs = engine.sampler().inputs();
        let traffic = |id: &CanId| Traffic::new(inputs.message_name(*id).unwrap_or_default(), *id);
        let inputs = engine.ids().iter().map(traffic).collect();
        Ok(Self {
            own: receiver.clone(),
            bus: receiver,
            estimator,
            newest: None,
            inputs,
            series: Series::default(),
            now: Micros(0),
            last_frame: None,
            link: None,
            errors: 0,
            last_error: None,
            dropped: 0,
            faults: [None; Faults::COUNT],
            faults_of_row: Faults::empty(),
            engine,
        })
    }

    /// The own engine goes on from what earlier drives taught. Before anything happens.
    pub fn restore(&mut self, learned: &Learned) {
        self.engine.restore(learned);
    }

    /// All identifiers that are looked at: inputs, and what gripd publishes.
    pub fn ids(&self) -> Vec<CanId> {
        self.engine.ids().iter().copied().chain(self.bus.ids()).collect()
    }

    /// Shows the estimates of the other one from now on; what was shown before stays in the series.
    pub fn set_estimator(&mut self, estimator: Estimator) {
        self.estimator = estimator;
    }

    /// Something that happened, and how late it was then ([`Source::now`]). A row that was due before it knows nothing
    /// of it.
    pub fn take(&mut self, happening: &Happening, now: Option<Micros>) {
        if let Some(now) = now {
            self.advance(now);
        }
        match happening {
            Happening::Frame(frame) => self.frame(frame),
            Happening::Link(link) => {
                if *link != Link::Up {
                    self.note(Faults::BUS_DOWN);
                }
                self.link = Some(*link);
            }
            Happening::Error(error) => {
                self.errors += 1;
                self.last_error = Some(*error);
                self.note(Faults::BUS_ERROR);
            }
            Happening::Dropped(count) => {
                self.dropped += u64::from(*count);
                self.engine.report_dropped(u64::from(*count));
                self.note(Faults::DROPPED);
            }
            Happening::Over | Happening::Failed(_) => {}
        }
    }

    fn frame(&mut self, frame: &Frame) {
        self.last_frame = Some(frame.time);
        if self.bus.take(frame) {
            if self.estimator == Estimator::Bus {
                let told = self.bus.take_faults();
                self.note_at(frame.time, told);
            }
            return;
        }
        if let Some(traffic) = self.inputs.iter_mut().find(|traffic| traffic.id() == frame.id) {
            traffic.count(frame.time);
        } else if let Some(error) = ErrorReport::from_frame(frame) {
            self.errors += 1;
            self.last_error = Some(error);
        }
        self.engine.frame(frame, &mut Eavesdrop { newest: &mut self.newest, own: &mut self.own });
        let told = match self.estimator {
            Estimator::Own => self.own.take_faults(),
            // Nobody on the bus tells what is wrong with the inputs: we do.
            Estimator::Bus if self.bus.is_silent(self.now) => self.engine.latest_faults(),
            Estimator::Bus => Faults::empty(),
        };
        self.note_at(frame.time, told);
    }

    fn note(&mut self, faults: Faults) {
        self.note_at(self.now, faults);
    }

    fn note_at(&mut self, time: Micros, faults: Faults) {
        self.faults_of_row |= faults;
        for fault in faults.iter() {
            if let Some(at) = self.faults.get_mut(fault.bits().trailing_zeros() as usize) {
                *at = Some(time);
            }
        }
    }

    /// It is so late now. Rows of the series that are due are made.
    pub fn advance(&mut self, now: Micros) {
        self.now = now;
        if let Some(time) = self.series.due(now) {
            let faults = std::mem::take(&mut self.faults_of_row);
            let row = self.row(time, faults);
            self.series.push(row);
        }
    }

    fn row(&self, time: Micros, faults: Faults) -> Row {
        let round = self.receiver().current(self.now);
        let sample = self.newest.filter(|sample| self.now - sample.time <= Receiver::PATIENCE);
        let input = |quantity: Quantity| sample.and_then(|sample| sample.get(quantity));
        Row::new(time, &round, faults, input)
    }

    fn receiver(&self) -> &Receiver {
        match self.estimator {
            Estimator::Bus => &self.bus,
            Estimator::Own => &self.own,
        }
    }
}
