//! Hostile input: everything that is read from outside, with mutations of good input that know its grammar.
//!
//! `cargo test` runs a few seconds of it, always the same ones. For longer, and other ones:
//!
//! ```text
//! GRIPD_FUZZ=1000 GRIPD_FUZZ_SEED=7 cargo test --release --test formats fuzz -- --nocapture
//! ```
//!
//! runs each target a thousand times as long. An input that fails is written to a file that the message names,
//! TARGET-SEED-RUN; GRIPD_FUZZ_FROM=RUN goes there at once, and the file, put into `corpus/TARGET`, is run first from
//! then on. What must hold of the inputs is `testing::hostile`'s; `tests/fuzz/run.sh` asks it of inputs that coverage guides to.

mod candump;
mod config;
mod dbc;
mod engine;
mod files;
mod filters;
mod mutate;
mod recordings;
mod run;
mod sampler;
mod state;
