//! gripd estimates tire stiffness and tire-road friction from a vehicle's CAN bus.
//!
//! The data's way through the crate is its architecture:
//!
//! ```text
//! frames ─can─► dbc ─► signals ─► Sample ─► estimate ─► Estimates ─► signals ─► dbc ─► frames
//! ```
//!
//! [`Sample`] and [`Estimates`] are the two hinges: everything left and right of them knows of
//! buses and files, everything between knows only physics. The live service, the replay of a
//! recording, the tests and the benchmarks all drive the same [`service::Engine`].
//!
//! What to do with it, task by task: [`guide`].
//!
//! SI units inside, ISO 8855 axes (x forward, y left, z up); conversion happens once, at the DBC
//! boundary. Time is the frame's own stamp, in whole microseconds, never the wall clock.

pub mod cli;
#[cfg(feature = "desk")]
pub mod guide;

pub use bus::{Config, can, config, dbc, new_file, service, signals};
#[cfg(feature = "desk")]
pub use bus::{propose, watch};
#[cfg(feature = "desk")]
pub use lab::{explain, identify, pages, report, reproduce};
pub use physics::{
    Estimates, Faults, Micros, Quantity, Sample, Sensors, Wheel, estimate, estimates, faults, filter, model,
    sample, time,
};
