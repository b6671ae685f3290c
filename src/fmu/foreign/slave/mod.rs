//! A loaded library, whichever version of FMI it speaks.

mod fmi2;
mod fmi3;

use std::ffi::{CStr, CString, c_char};
use std::path::Path;

use libloading::Library;

use super::description::Kind;
use super::job::Job;

/// A library that has been loaded.
pub(super) enum Slave {
    Two(fmi2::Functions),
    Three(fmi3::Functions),
}

/// An instance of it.
pub(super) enum Instance<'s> {
    Two(fmi2::Instance<'s>),
    Three(fmi3::Instance<'s>),
}

impl Slave {
    /// Loads the library of a job.
    pub(super) fn load(job: &Job) -> Result<Self, String> {
        // SAFETY: what the library does when it is loaded, and ever after, cannot be known. That is why this is a process of
        // its own.
        let library = unsafe { Library::new(&job.library) }
            .map_err(|error| format!("its library cannot be loaded: {error}"))?;
        if job.is_three {
            fmi3::Functions::of(library).map(Self::Three)
        } else {
            fmi2::Functions::of(library).map(Self::Two)
        }
    }

    /// Makes an instance.
    pub(super) fn instantiate(&self, job: &Job) -> Result<Instance<'_>, String> {
        match self {
            Self::Two(functions) => fmi2::Instance::new(functions, job).map(Instance::Two),
            Self::Three(functions) => fmi3::Instance::new(functions, job).map(Instance::Three),
        }
    }
}

macro_rules! both {
    ($self:ident, $instance:ident => $call:expr) => {
        match $self {
            Instance::Two($instance) => $call,
            Instance::Three($instance) => $call,
        }
    };
}

impl Instance<'_> {
    /// The initialization begins; the drive will last so long.
    pub(super) fn begin(&mut self, seconds: f64) -> Result<(), String> {
        both!(self, instance => instance.begin(seconds))
    }

    /// The initialization ends.
    pub(super) fn begun(&mut self) -> Result<(), String> {
        both!(self, instance => instance.begun())
    }

    pub(super) fn set(&mut self, kind: Kind, reference: u32, value: f64) -> Result<(), String> {
        both!(self, instance => instance.set(kind, reference, value))
    }

    pub(super) fn get(&mut self, kind: Kind, reference: u32) -> Result<f64, String> {
        both!(self, instance => instance.get(kind, reference))
    }

    /// The rate of an input until the end of the next step.
    pub(super) fn set_rate(&mut self, reference: u32, rate: f64) -> Result<(), String> {
        match self {
            Self::Two(instance) => instance.set_rate(reference, rate),
            Self::Three(_) => Err("FMI 3.0 has no rates of inputs".into()),
        }
    }

    pub(super) fn step(&mut self, from: f64, seconds: f64) -> Result<(), String> {
        both!(self, instance => instance.step(from, seconds))
    }

    /// Ends it and frees it.
    pub(super) fn end(self) {
        both!(self, instance => instance.end());
    }
}

/// A function of a library.
///
/// # Safety
/// `T` is the function's type.
unsafe fn function<T: Copy>(library: &Library, name: &'static str) -> Result<T, String> {
    // SAFETY: as promised to this function.
    unsafe { library.get::<T>(name) }
        .map(|symbol| *symbol)
        .map_err(|_| format!("its library has no function {name}; the FMU is broken"))
}

/// What a status means, if it is no success: OK and warning are.
fn checked(status: i32, call: &str) -> Result<(), String> {
    let what = match status {
        0 | 1 => return Ok(()),
        2 => "discarded",
        3 => "failed with an error",
        4 => "failed fatally",
        5 => "did not wait for its end",
        other => return Err(format!("{call} answered {other}, which is no status of FMI")),
    };
    Err(format!("{call} {what}"))
}

/// Messages of the FMU, for people: its parent reads the standard error.
///
/// # Safety
/// `message` is null or a text of C.
unsafe fn heard(status: i32, message: *const c_char) {
    if status > 1 && !message.is_null() {
        use std::io::Write;
        // SAFETY: as promised to this function.
        let message = unsafe { CStr::from_ptr(message) }.to_string_lossy();
        let _ = writeln!(std::io::stderr(), "{message}");
    }
}

/// A text for the library.
fn text(text: &str) -> Result<CString, String> {
    CString::new(text).map_err(|_| "its description has texts with zeros".to_owned())
}

/// A path as text: what is no text is taken as near as it can.
fn path_text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}
