//! What the commands write to the standard error goes to Python's `logging`, to the logger `gripd`.

use std::fmt::{Debug, Write};

use pyo3::prelude::*;
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

/// From now on; where another library of the same process has it already, nothing changes.
pub fn to_python() {
    let _ = tracing_subscriber::registry().with(ToPython.with_filter(LevelFilter::INFO)).try_init();
}

struct ToPython;

impl<S: Subscriber> Layer<S> for ToPython {
    fn on_event(&self, event: &Event<'_>, _context: Context<'_, S>) {
        // The numbers of `logging`.
        let level = match *event.metadata().level() {
            Level::ERROR => 40,
            Level::WARN => 30,
            _ => 20,
        };
        let mut message = Message(String::new());
        event.record(&mut message);
        let tell = |py: Python<'_>| -> PyResult<()> {
            let logger = py.import("logging")?.call_method1("getLogger", ("gripd",))?;
            logger.call_method1("log", (level, message.0)).map(drop)
        };
        // Where the interpreter is ending, nobody listens.
        let _ = Python::try_attach(tell);
    }
}

/// An event's text.
struct Message(String);

impl Visit for Message {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            // Writing to a string cannot fail.
            let _ = write!(self.0, "{value:?}");
        }
    }
}
