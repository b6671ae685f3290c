//! gripd estimates tire stiffness and tire-road friction from a vehicle's CAN bus.
//!
//! The data's way through the rooms is the architecture:
//!
//! ```text
//! frames ─can─► dbc ─► signals ─► Sample ─► estimate ─► Estimates ─► signals ─► dbc ─► frames
//! ```
//!
//! [`Sample`] and [`Estimates`] are the two hinges: everything left and right of them knows of
//! buses and files, everything between knows only physics. The live service, the replay of a
//! recording, the tests and the benchmarks all drive the same [`service::Engine`].
//!
//! The rooms lie in crates of a workspace, and the compiler keeps these apart:
//!
//! | Crate | Folder | Rooms |
//! |---|---|---|
//! | `physics` | `src/physics` | [`time`], [`sample`], [`estimates`], [`faults`], [`filter`], [`model`], [`estimate`] |
//! | `bus` | `src/bus` | [`new_file`], [`plain_file`], [`can`], [`dbc`], [`signals`], [`propose`], [`tire_file`], [`config`], [`service`], [`watch`] |
//! | `fmu` | `src/fmu` | the simulated car as an FMU, FMUs of other programs |
//! | `identify` | `src/identify` | [`identify`]: the vehicle's parameters from recordings |
//! | `predict` | `src/predict` | a car along a recording, and the filter that holds it there |
//! | `lab` | `src/lab` | [`report`], [`explain`], [`reproduce`], [`pages`] |
//! | `gripd` | `src/cli` | [`cli`]: one file or folder for each command |
//!
//! `bus`, `fmu` and `lab` know `physics` and not each other; `lab` stands on `identify` and `predict`. This crate gives all rooms out again, for tests and other programs.
//! What may depend on what within a crate: [`guide::contributing`].
//!
//! What to do with it, task by task: [`guide`].
//!
//! SI units inside, ISO 8855 axes (x forward, y left, z up); conversion happens once, at the DBC
//! boundary. Time is the frame's own stamp, in whole microseconds, never the wall clock.

pub mod cli;
#[cfg(feature = "desk")]
pub mod guide;

pub use bus::{Config, can, config, dbc, new_file, plain_file, service, signals, tire_file};
#[cfg(feature = "desk")]
pub use bus::{propose, watch};
#[cfg(feature = "desk")]
pub use fmu;
#[cfg(feature = "desk")]
pub use identify;
#[cfg(feature = "desk")]
pub use lab::{explain, pages, report, reproduce};
pub use physics::{
    Estimates, Faults, Micros, Quantity, Sample, Sensors, Wheel, estimate, estimates, faults, filter, model,
    sample, time,
};
