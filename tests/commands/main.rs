//! Each command as its users meet it: what goes in, what comes out, and how it fails. And what the pages and the map of
//! the rooms promise.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod audit;
mod bad_files;
mod beside_simulation;
mod calibrate;
mod changed;
mod check;
mod conceal;
mod demo;
mod errors;
mod export;
mod fmu;
mod identify_cli;
mod inputs;
mod interactive;
mod map;
mod mcap;
mod monitor;
mod pages;
mod parquet;
mod part;
mod plot;
mod replay;
mod results;
mod rooms;
mod setup;
mod view;
