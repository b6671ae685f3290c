//! Hostile input: everything that is read from outside, with mutations of good input that know its grammar.
//!
//! `cargo test` runs a few seconds of it, always the same ones. For longer, and other ones:
//!
//! ```text
//! GRIPD_FUZZ=1000 GRIPD_FUZZ_SEED=7 cargo test --release --test fuzz -- --nocapture
//! ```
//!
//! runs each target a thousand times as long. An input that fails is written to a file that the message names,
//! TARGET-SEED-RUN; GRIPD_FUZZ_FROM=RUN goes there at once, and the file, put into `corpus/TARGET`, is run first from
//! then on.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "helpers of tests may fail loudly"
)]

mod candump;
#[path = "../faults/car.rs"]
#[allow(dead_code, reason = "the tests of faults use the rest")]
mod car;
mod config;
mod dbc;
mod dice;
mod engine;
mod filters;
mod frames;
#[path = "../faults/heard.rs"]
#[allow(dead_code, reason = "the tests of faults use the rest")]
mod heard;
mod mutate;
#[path = "../support/program.rs"]
mod program;
mod recordings;
mod run;
mod sampler;
#[path = "../support/sound.rs"]
mod sound;
mod state;
