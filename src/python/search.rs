//! `explain` and `identify`: minutes of searching, on a thread of its own, so that Ctrl-C is heard at once.

use std::any::Any;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use gripd::cli::Failure;
use gripd::cli::library::{Explain, Identify, Told, Watch, options};
use pyo3::prelude::*;

use crate::failure::{WorkError, exception, words};

/// Between two looks whether somebody has pressed Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// What the command has as JSON, and why a recording could not be read to its end.
type Found = (String, Option<String>);

/// Where simulation and recording differ, and why.
#[pyfunction]
pub fn explain(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<Found> {
    let explain: Explain = options("gripd explain", arguments).map_err(exception)?;
    found(py, move |watch| explain.told(watch))
}

/// The vehicle's parameters.
#[pyfunction]
pub fn identify(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<Found> {
    let identify: Identify = options("gripd identify", arguments).map_err(exception)?;
    found(py, move |watch| identify.told(watch))
}

/// Nobody waits for the answer any more.
struct NotWanted;

fn found(
    py: Python<'_>,
    work: impl FnOnce(Watch<'_>) -> Result<Told, Failure> + Send + 'static,
) -> PyResult<Found> {
    let wanted = Arc::new(AtomicBool::new(true));
    let (sender, mut receiver) = channel();
    let is_wanted = wanted.clone();
    let search = move || {
        // A search has no other way out. It ends with its stage, and nobody hears of it.
        let watch = |_: &str, _: f64| {
            if !is_wanted.load(Ordering::Relaxed) {
                resume_unwind(Box::new(NotWanted));
            }
        };
        let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(&watch))));
    };
    std::thread::Builder::new()
        .name("gripd".into())
        .spawn(search)
        .map_err(|error| WorkError::new_err(format!("cannot start a thread: {error}")))?;
    loop {
        let heard;
        (receiver, heard) = py.detach(move || {
            let heard = receiver.recv_timeout(LOOK);
            (receiver, heard)
        });
        match heard {
            Ok(Ok(told)) => {
                let told = told.map_err(exception)?;
                return Ok((told.json, told.whole.err().map(words)));
            }
            Ok(Err(panic)) => return Err(WorkError::new_err(said(&*panic))),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(interrupted) = py.check_signals() {
                    wanted.store(false, Ordering::Relaxed);
                    return Err(interrupted);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(WorkError::new_err("the search has ended without an answer"));
            }
        }
    }
}

/// What a bug of ours says.
fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("a bug in gripd, please report it: {}", text.unwrap_or("it does not say which"))
}
