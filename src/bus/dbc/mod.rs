//! A loaded, validated DBC file, compiled to decoders and encoders.
//!
//! ```text
//! bytes ─load─► text ─lines─► statements ─can-dbc─► raw messages ─validate─► Database of Messages of Signals
//! ```
//!
//! `can-dbc` parses but checks next to nothing, so everything that decoding relies on is checked here.
//! What cannot be used is left out with a [`Warning`] that names the line; the rest is loaded. Decoded
//! numbers are those of cantools: raw × factor + offset in double precision.

mod codec;
mod database;
mod error;
mod extract;
mod lines;
mod load;
mod lookup;
mod message;
mod mux;
mod signal;
mod validate;

pub use codec::{ByteOrder, Codec, ValueKind};
pub use database::Database;
pub use error::{DbcError, EncodeError, LookupError, Warning};
pub use extract::Extractor;
pub use message::Message;
pub use mux::{Condition, Mux};
pub use signal::Signal;
