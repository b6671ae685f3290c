//! What can go wrong in a vehicle, and what the service makes of it: one file per group of faults.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "helpers of tests may fail loudly"
)]

mod car;
mod case;
#[path = "../support/fault/mod.rs"]
mod fault;
mod flood;
mod heard;
mod listed;
mod output;
mod process;
#[path = "../support/program.rs"]
mod program;
mod reload;
mod service;
