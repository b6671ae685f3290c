//! The guide: a page for each task, as it is read beside the program (`/usr/share/doc/gripd/guide`).
//!
//! For those who use it:
//!
//! - [`map_a_car`]: from a DBC and a recorded drive to a configuration
//! - [`read_the_frames`]: what is published, what it means, and when there is nothing
//! - [`at_home`]: from Python, in viewers, in VSS
//! - [`recordings_and_formats`]: which recordings are read and written, and what each can hold
//! - [`gateway`]: install it as a service, reload it, watch it
//! - [`calibrate`]: from stiffness to friction by ABS brakings
//! - [`explain_a_mismatch`]: where, why and how much simulation and recording differ
//! - [`results`]: what was measured
//! - [`when_things_go_wrong`]: every fault, and what becomes of it
//!
//! For those who change it:
//!
//! - [`contributing`]: the map of the rooms, the quick loop, and how to add to them
//! - [`glossary`]: the field's words and the house's

#[doc = include_str!("guide/map-a-car.md")]
pub mod map_a_car {}

#[doc = include_str!("guide/read-the-frames.md")]
pub mod read_the_frames {}

#[doc = include_str!("guide/at-home.md")]
pub mod at_home {}

#[doc = include_str!("guide/recordings-and-formats.md")]
pub mod recordings_and_formats {}

#[doc = include_str!("guide/gateway.md")]
pub mod gateway {}

#[doc = include_str!("guide/calibrate.md")]
pub mod calibrate {}

#[doc = include_str!("guide/explain-a-mismatch.md")]
pub mod explain_a_mismatch {}

#[doc = include_str!("guide/results.md")]
pub mod results {}

#[doc = include_str!("guide/when-things-go-wrong.md")]
pub mod when_things_go_wrong {}

#[doc = include_str!("guide/contributing.md")]
pub mod contributing {}

#[doc = include_str!("guide/glossary.md")]
pub mod glossary {}
