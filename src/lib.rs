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

pub mod can;
pub mod cli;
pub mod config;
pub mod dbc;
pub mod estimate;
pub mod estimates;
pub mod explain;
pub mod faults;
pub mod filter;
pub mod guide;
pub mod identify;
pub mod model;
pub mod new_file;
pub mod propose;
pub mod report;
pub mod sample;
pub mod service;
pub mod signals;
pub mod time;
pub mod watch;

pub use config::Config;
pub use estimates::Estimates;
pub use faults::Faults;
pub use sample::{Quantity, Sample, Sensors, Wheel};
pub use time::Micros;
