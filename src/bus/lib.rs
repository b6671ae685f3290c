//! From CAN frames to samples, from estimates to CAN frames, and the service that does both.
//!
//! ```text
//! frames ─can─► dbc ─► signals ─► Sample ─► physics ─► Estimates ─► signals ─► dbc ─► frames
//! ```

pub mod can;
pub mod config;
pub mod dbc;
pub mod new_file;
pub mod plain_file;
#[cfg(feature = "desk")]
pub mod propose;
pub mod service;
pub mod signals;
pub mod tire_file;
#[cfg(feature = "desk")]
pub mod watch;

pub use config::Config;
