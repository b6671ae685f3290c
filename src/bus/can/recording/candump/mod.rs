//! Recordings in the log format of can-utils' candump (`candump -L` and `-l`).
//!
//! ```text
//! (1760000000.000584) can0 123#1122334455667788        a classic frame
//! (1760000000.000601) can0 18FEF100#R8                 a remote request, extended identifier
//! (1760000000.000614) can0 123##5112233445566778899AABBCC    an FD frame with bit rate switch
//! ```
//!
//! The grammar is that of can-utils' `lib.h`; nothing here was taken from its code.

mod line;
mod reader;
mod rewrite;
mod usual;
mod writer;

pub use super::{Compression, Damage, LogError, LogStats, SkippedLine};
pub use crate::can::write_line;
pub use reader::Reader;
pub use rewrite::rewrite;
pub use writer::Writer;
