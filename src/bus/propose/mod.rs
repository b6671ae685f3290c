//! Which signals of an unknown car are which quantities: proposed for a person to confirm.
//!
//! ```text
//! Database ─names, units, ranges─► candidates ┐
//! frames ─Drive─► series ─Motion─► evidence ──┴─► Proposal ─► [signals]
//! ```
//!
//! Names are judged by their words, recordings by what a car must obey: four wheels that agree
//! while driving straight on; outer wheels faster by track × yaw rate; lateral acceleration = speed × yaw rate;
//! steering angle in proportion to curvature; longitudinal acceleration = change of speed. Signs come from the same
//! relations. What is left and what is right no relation tells, since a mirrored car obeys them all: that comes
//! from the names of the wheels or, where most of the sensors are against these, from the sensors.
//!
//! A quantity for which nothing fits is not found; nothing is proposed for the sake of proposing.

mod along;
mod beside;
mod by_speed;
mod channel;
mod choose;
mod class;
mod corners;
mod correction;
mod drive;
mod evidence;
mod mapped;
mod motion;
mod names;
mod pick;
mod proposal;
mod regression;
mod source;
mod table;
mod vehicle;
mod vocabulary;
mod wheels;
mod words;

pub use choose::{Wishes, propose, propose_with};
pub use class::CarClass;
pub use correction::Correction;
pub use drive::Drive;
pub use evidence::{Evidence, Verdict};
pub use proposal::{Alternative, Choice, Confidence, Mapped, Proposal};
pub use source::Place;
pub use table::{signals, table};
pub use vehicle::{Number, Source, VehicleTable};
