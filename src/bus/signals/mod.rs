//! From DBC signals to physical quantities and back.
//!
//! ```text
//! frame ─checks─► mapping ─units, signs─► limits ─► history ─grid─► plausibility ─► Sample
//! ```
//!
//! [`SignalsConfig`] is the `[signals]` table as written; [`Inputs`] is the same, compiled against a DBC;
//! [`Sampler`] makes samples of frames with it; [`Outputs`] makes frames of values, for the simulator.
//! The way back, from estimates to protected frames, is in [`publish`] and [`e2e`].

mod alter;
mod checks;
mod compile;
mod config;
mod counts;
mod describe;
pub mod e2e;
mod error;
mod grid;
mod history;
mod inputs;
mod limits;
mod mapping;
mod outputs;
mod plausibility;
pub mod publish;
mod rate_watch;
mod sampler;
mod units;

pub use alter::{Altered, Alterer, Change};
pub use config::{CrcConfig, CrcKind, QuantityConfig, SamplerConfig, SignalsConfig};
pub use counts::FaultCounts;
pub use describe::Description;
pub use error::{Problem, SignalsError};
pub use inputs::Inputs;
pub use outputs::Outputs;
pub use plausibility::Contradiction;
pub use sampler::{Pushed, Sampler};
pub use units::{UnitError, to_si};
