//! What there is to see of a [`Watch`] at the moment.

use super::{Estimator, Heard, Link, Receiver, Round, Row, Series, Traffic, Watch, Word};
use crate::can::ErrorReport;
use crate::service::EngineCounts;
use physics::{Faults, Micros, Quantity, Sample};

/// One measured quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputNow {
    /// Which.
    pub quantity: Quantity,
    /// Its newest usable value, SI, and how old that is.
    pub newest: Option<(f64, Micros)>,
    /// Is it older than its time-out?
    pub is_stale: bool,
    /// Is it left out at the moment, though it came: contradicted by others, or not available?
    pub is_doubted: bool,
}

/// Whose word the estimates are, and whether there is any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// A gripd on the bus publishes.
    ByBus,
    /// One did, but has fallen silent.
    Silent,
    /// None has published so far.
    Never,
    /// The engine of this process.
    ByOwn,
}

impl Watch {
    /// Whose estimates are shown.
    pub fn estimator(&self) -> Estimator {
        self.estimator
    }

    /// How it is with the estimates.
    pub fn told(&self) -> Told {
        match self.estimator {
            Estimator::Own => Told::ByOwn,
            Estimator::Bus if self.bus.is_unheard() => Told::Never,
            Estimator::Bus if self.bus.is_silent(self.now) => Told::Silent,
            Estimator::Bus => Told::ByBus,
        }
    }

    /// Does some gripd publish on the bus, whosever estimates are shown?
    pub fn bus_publishes(&self) -> bool {
        !self.bus.is_silent(self.now)
    }

    /// The estimates: nothing of what is stale.
    pub fn round(&self) -> Round {
        self.receiver().current(self.now)
    }

    /// The estimates as they were told last, however long ago.
    pub fn last_round(&self) -> Round {
        self.receiver().last()
    }

    /// The same as a row: what a page shows beside the series.
    pub fn last_row(&self) -> Row {
        Row::new(self.now, &self.last_round(), self.faults(), |_| None)
    }

    /// How it is with one of the published messages.
    pub fn word(&self, message: &str) -> Word {
        self.receiver().word_of(message, self.now)
    }

    /// How it is with each of the published messages.
    pub fn messages(&self) -> impl Iterator<Item = (&Heard, Word)> {
        let receiver: &Receiver = self.receiver();
        receiver.messages().iter().map(|heard| (heard, receiver.word(heard, self.now)))
    }

    /// Frames that were not believed: wrong checksums, jumps of counters, wrong shapes.
    pub fn damage(&self) -> [u64; 3] {
        self.receiver().messages().iter().fold([0; 3], |[crc, counter, shape], heard| {
            [crc + heard.crc_errors, counter + heard.counter_errors, shape + heard.misshapen]
        })
    }

    /// Each configured quantity.
    pub fn inputs(&self) -> impl Iterator<Item = InputNow> + '_ {
        let sampler = self.engine.sampler();
        let configured = Quantity::ALL.into_iter().filter(|quantity| sampler.inputs().has(*quantity));
        configured.map(move |quantity| {
            let newest = sampler.newest(quantity);
            let newest = newest.map(|(time, value)| (value, (self.now - time).max(Micros(0))));
            let timeout = sampler.inputs().describe(quantity).map(|about| about.timeout);
            let is_stale = newest.zip(timeout).is_some_and(|((_, age), timeout)| age > timeout);
            let sample: Option<&Sample> = self.newest.as_ref();
            let is_doubted = !is_stale && sample.is_some_and(|sample| sample.get(quantity).is_none());
            InputNow { quantity, newest, is_stale, is_doubted }
        })
    }

    /// The needed identifiers, and how often they come.
    pub fn traffic(&self) -> &[Traffic] {
        &self.inputs
    }

    /// Frames of needed inputs in a second.
    pub fn input_rate(&self) -> f64 {
        self.inputs.iter().map(|traffic| traffic.rate(self.now)).sum()
    }

    /// Faults that were told a moment ago, and those that last.
    pub fn faults(&self) -> Faults {
        let lately = |fault: &Faults| {
            let at = self.faults.get(fault.bits().trailing_zeros() as usize).copied().flatten();
            at.is_some_and(|at| self.now - at <= Self::FAULT_STAYS)
        };
        let mut faults: Faults = Faults::all().iter().filter(lately).collect();
        // This one we see for ourselves, as long as it lasts.
        if self.link.is_some_and(|link| link != Link::Up) {
            faults |= Faults::BUS_DOWN;
        }
        faults
    }

    /// How often faults of inputs began, as this process counts them.
    pub fn occurrences(&self, fault: Faults) -> u64 {
        self.engine.occurrences(fault)
    }

    /// State of the interface; `None` for a recording, and before anything is known.
    pub fn link(&self) -> Option<Link> {
        self.link
    }

    /// Errors that the controller reported, and the last of them.
    pub fn errors(&self) -> (u64, Option<&ErrorReport>) {
        (self.errors, self.last_error.as_ref())
    }

    /// Frames that were lost on the way here.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// What went through the own engine.
    pub fn counts(&self) -> EngineCounts {
        self.engine.counts()
    }

    /// How late it is, in the frames' time.
    pub fn now(&self) -> Micros {
        self.now
    }

    /// Since the newest frame of any kind.
    pub fn silence(&self) -> Option<Micros> {
        self.last_frame.map(|last| (self.now - last).max(Micros(0)))
    }

    /// The last minutes.
    pub fn series(&self) -> &Series {
        &self.series
    }
}
