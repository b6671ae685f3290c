//! How the service is, for whoever watches it: counts, as Prometheus reads them.
//!
//! The loop stores numbers and never waits; whoever reads them may see some a frame older than others.

use std::fmt::{self, Display, Write as _};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

use super::{Engine, Tally};
use physics::Faults;
use physics::estimates::State;

/// What the loop has counted last.
#[derive(Debug, Default)]
pub struct Health {
    received: AtomicU64,
    published: AtomicU64,
    unsent: AtomicU64,
    late: AtomicU64,
    foreign: AtomicU64,
    dropped: AtomicU64,
    samples: AtomicU64,
    /// By bit.
    faults: [AtomicU64; Faults::COUNT],
    state: AtomicU64,
    input_up: AtomicBool,
    recorded: AtomicU64,
    unrecorded: AtomicU64,
    contradicted: AtomicBool,
    accepted: AtomicU64,
    refused: AtomicU64,
}

impl Health {
    /// After each frame: some twenty stores.
    pub(super) fn update(&self, tally: &Tally, engine: &Engine) {
        self.received.store(tally.received, Relaxed);
        self.published.store(tally.published, Relaxed);
        self.unsent.store(tally.unsent, Relaxed);
        self.late.store(tally.late, Relaxed);
        self.foreign.store(tally.foreign, Relaxed);
        self.dropped.store(tally.dropped, Relaxed);
        self.samples.store(engine.counts().samples, Relaxed);
        for (bit, count) in self.faults.iter().enumerate() {
            count.store(engine.occurrences(Faults::from_bits_retain(1 << bit)), Relaxed);
        }
        self.state.store(engine.state() as u64, Relaxed);
    }

    pub(super) fn set_input_up(&self, up: bool) {
        self.input_up.store(up, Relaxed);
    }

    /// Faults recorded, and not.
    pub(super) fn set_recordings(&self, (recorded, unrecorded): (u64, u64)) {
        self.recorded.store(recorded, Relaxed);
        self.unrecorded.store(unrecorded, Relaxed);
    }

    /// What is learned contradicts the car's table, and is not saved.
    pub(super) fn set_contradicted(&self, contradicted: bool) {
        self.contradicted.store(contradicted, Relaxed);
    }

    pub(super) fn count_reload(&self, accepted: bool) {
        let count = if accepted { &self.accepted } else { &self.refused };
        count.fetch_add(1, Relaxed);
    }
}

/// In Prometheus' text format, version 0.0.4.
impl Display for Health {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut number = |name: &str, kind: &str, help: &str, value: u64| {
            writeln!(f, "# HELP gripd_{name} {help}\n# TYPE gripd_{name} {kind}\ngripd_{name} {value}")
        };
        let count = |count: &AtomicU64| count.load(Relaxed);
        number("frames_received_total", "counter", "Needed frames received.", count(&self.received))?;
        number("frames_published_total", "counter", "Frames published.", count(&self.published))?;
        number("frames_unsent_total", "counter", "Frames that could not be sent.", count(&self.unsent))?;
        number("frames_late_total", "counter", "Frames dropped because they were late.", count(&self.late))?;
        number(
            "frames_foreign_total",
            "counter",
            "Frames of others with an identifier of gripd's.",
            count(&self.foreign),
        )?;
        number(
            "frames_dropped_total",
            "counter",
            "Frames lost before they were read.",
            count(&self.dropped),
        )?;
        number("samples_total", "counter", "Samples made.", count(&self.samples))?;
        number("input_up", "gauge", "The input interface is up.", self.input_up.load(Relaxed).into())?;
        number(
            "learned_contradicts_table",
            "gauge",
            "What is learned contradicts [vehicle], and is not saved.",
            self.contradicted.load(Relaxed).into(),
        )?;
        number("recordings_total", "counter", "Recordings of faults.", count(&self.recorded))?;
        number("recordings_missed_total", "counter", "Faults not recorded.", count(&self.unrecorded))?;
        number("reloads_accepted_total", "counter", "Configurations taken over.", count(&self.accepted))?;
        number("reloads_refused_total", "counter", "Configurations refused.", count(&self.refused))?;
        f.write_str("# HELP gripd_state What the service can do at the moment.\n# TYPE gripd_state gauge\n")?;
        for state in State::ALL {
            let (name, is) = (state.name(), u64::from(count(&self.state) == state as u64));
            writeln!(f, "gripd_state{{state=\"{name}\"}} {is}")?;
        }
        f.write_str(
            "# HELP gripd_faults_total How often each fault began.\n# TYPE gripd_faults_total counter\n",
        )?;
        for (name, fault) in Faults::all().iter_names() {
            let count = count(&self.faults[fault.bits().trailing_zeros() as usize]);
            f.write_str("gripd_faults_total{fault=\"")?;
            name.chars().try_for_each(|letter| f.write_char(letter.to_ascii_lowercase()))?;
            writeln!(f, "\"}} {count}")?;
        }
        Ok(())
    }
}
