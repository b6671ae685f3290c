//! On virtual CAN interfaces of a real kernel.
//!
//! Where a test may not make its own it says so and passes; `tests/vcan/run.sh` is cargo's runner for a place where it may.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod bus;
mod demo;
mod service;
