//! What can go wrong in a vehicle, and what the service makes of it: one file per group of faults.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "helpers of tests may fail loudly"
)]

mod car;
mod case;
mod content;
mod frame;
mod heard;
mod output;
mod process;
mod reload;
mod sensor;
mod service;
mod timing;
