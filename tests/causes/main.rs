//! What explains a recording: parameters that are identified, and causes that are found.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod concealed;
mod explain_long;
mod identify;
mod reproduce;
