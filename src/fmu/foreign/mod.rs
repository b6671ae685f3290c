//! FMUs of other programs: read, unpacked, and run in a process of their own.
//!
//! ```text
//! archive ─► unpack ─► description ─► wiring (configuration, recorded inputs) ─► Job ─► parent ──process──► child ─► slave
//!                                                                               rows ◄──────── rows of outputs ◄───┘
//! ```
//!
//! What a foreign library does is anybody's guess: it may crash, wait for ever, print, or answer with nonsense. It does so in
//! a process that has nothing but a folder of its own, a limit of time and memory, and a file to write rows into.

pub mod child;
mod config;
mod description;
mod job;
mod parent;
mod slave;
mod tune;
mod unpack;
mod wiring;

use std::path::PathBuf;

use thiserror::Error;

pub use config::FmuConfig;
pub use description::{Description, Kind, Role, Scalar};
pub use job::{Course, Job, Line, Run, Value};
pub use parent::{Program, Rows};
pub use tune::{Tuned, tune};
pub use unpack::Unpacked;
pub use wiring::{Recorded, Wiring};

/// An FMU that cannot be used.
#[derive(Debug, Error)]
pub enum ForeignError {
    /// It cannot be opened.
    #[error("cannot read the FMU {0}: {1}")]
    Read(PathBuf, String),
    /// It is no archive, or a broken one.
    #[error("{0} is no FMU that can be unpacked: {1}")]
    Archive(PathBuf, String),
    /// Its description cannot be used.
    #[error("{0}: modelDescription.xml: {1}")]
    Description(PathBuf, String),
    /// It has no library for this machine.
    #[error("{path} has no library for this machine: {needed} is needed; {there}")]
    Machine {
        /// The archive.
        path: PathBuf,
        /// The library's name in the archive.
        needed: String,
        /// What there is instead.
        there: String,
    },
    /// The configuration and the FMU do not fit.
    #[error("[fmu]{key}: {reason}")]
    Wiring {
        /// The key within the table, with its dot.
        key: String,
        /// What is wrong, and what to do.
        reason: String,
    },
    /// It ran and failed.
    #[error("{0}: {1}")]
    Run(PathBuf, String),
}
