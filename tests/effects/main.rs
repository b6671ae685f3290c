//! What each effect does to a simulated drive, in the signals as they are recorded; and what an `[[effect]]`
//! table may say.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail as tests do")]

mod car;
mod road;
mod sensors;
mod support;
mod tables;
mod together;
