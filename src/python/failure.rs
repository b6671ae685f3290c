//! How a command failed, as an exception with the command's words.

use gripd::cli::Failure;
use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::PyException;

create_exception!(gripd, Error, PyException, "gripd could not do what it was asked.");
create_exception!(
    gripd,
    UsageError,
    Error,
    "What was asked, or the configuration, has to be changed (exit code 2)."
);
create_exception!(gripd, WorkError, Error, "The work failed (exit code 1).");

/// The exception of a failure.
pub fn exception(failure: Failure) -> PyErr {
    match failure {
        Failure::Usage(_) => UsageError::new_err(words(failure)),
        Failure::Work(_) | Failure::ReaderGone => WorkError::new_err(words(failure)),
    }
}

/// What the command would say.
pub fn words(failure: Failure) -> String {
    match failure {
        Failure::Usage(reason) | Failure::Work(reason) => reason,
        Failure::ReaderGone => "whoever read the standard output has gone".into(),
    }
}
