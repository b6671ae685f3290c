//! Driving of many kinds, for long: drives drawn at random, a day with faults, odd roads, real cars.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod common_road;
mod concealed;
mod drives;
mod explained;
mod found;
mod free_runs;
mod kept;
mod left_out;
mod long_drives;
mod online;
mod over_drives;
mod real_cars;
mod soak;
mod whole_cars;

use testing::allocator::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
