//! From frames to estimates: the sampler, the estimators, their faults, and what is published.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod accuracy;
mod all_driven;
mod allocations;
mod black_box;
mod effects;
mod fault_bits;
mod faults;
mod filter;
mod golden;
mod learned;
mod model;
mod one_channel;
mod plausibility;
mod playback;
mod publish;
mod sampler;
mod signals;
mod sim2_joint;
mod sim3;
mod simulate;
mod thesis_lateral;
mod watch;

use testing::allocator::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
