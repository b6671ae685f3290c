//! Identification of the vehicle's parameters from recordings (thesis 5.3.2, methods.md §7).
//!
//! ```text
//! Samples ─► Record ─► segments ─► search (Levenberg–Marquardt) ─► uncertainty ─► Identification
//!                         └ simulated with exact derivatives (Dual), all of them side by side
//! ```
//!
//! Noise of each channel and how much the equations lose between segments come out of the data, so the
//! same search is output error where the equations hold, and a prediction-error method where they do not.

mod axles;
mod bounded;
mod braking;
mod car;
mod config;
mod doubt;
mod error;
mod excitation;
mod fit;
mod free;
mod free_run;
mod held;
mod identification;
mod input_noise;
mod longitudinal_input;
mod motion;
mod normal_equations;
mod parameter;
mod plant;
mod prepare;
mod profile;
mod record;
mod result;
mod segment;
mod segment_sums;
mod setup;
mod shooting;
mod slips;
mod smooth;
mod stages;
mod uncertainty;
pub mod understeer;

pub use axles::{AxleStiffness, CorneringStiffness, against, too_unsure};
pub use bounded::bounded_step;
pub use config::IdentifyConfig;
pub use doubt::{Doubt, MOST_DEVIATIONS, Told};
pub use error::IdentifyError;
pub use excitation::{far_from_limit, friction_in_use, hardly_exceeded};
pub use fit::Method;
pub use free_run::{BLOCK_S, FitRow, Fits, free_run};
pub use identification::Identifier;
pub use longitudinal_input::LongitudinalInput;
pub use motion::Output;
pub use parameter::{Parameter, Values};
pub use plant::plant;
pub use record::{Record, Row};
pub use result::{Identification, Identified, Path};
pub use stages::{BESIDE, STAGES, Stage};
