//! CAN frames, and the buses and recordings they come from and go to.

pub mod bus;
mod candump_line;
mod clock;
mod error_report;
mod frame;
mod interface;
mod link_news;
mod memory;
mod raw_socket;
#[cfg(feature = "desk")]
pub mod recording;
mod socketcan;
mod wire;
mod words;

pub use bus::{Bus, Event, OpenError, Reception, SendError};
pub use candump_line::write_line;
pub use error_report::{BusState, ErrorClass, ErrorReport};
pub use frame::{CanId, Frame, FrameError, FrameKind, Payload};
pub use interface::InterfaceName;
pub use memory::{MemoryBus, memory_pair};
#[cfg(feature = "desk")]
pub use recording::candump;
pub use socketcan::{SocketCan, SocketCanConfig};
