//! Files: recordings, DBC files and tables, beside other people's programs, and hostile ones.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod candump;
mod dbc_cantools;
mod dbc_files;
mod dbc_layouts;
mod fuzz;
mod peers;
mod publish_cantools;
mod recordings;
mod vss;
