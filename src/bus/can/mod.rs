//! CAN frames, and the buses and recordings they come from and go to.

pub mod bus;
pub mod candump;
mod clock;
mod digits;
mod error_report;
mod frame;
mod interface;
mod link_news;
mod memory;
mod raw_socket;
pub mod recording;
mod socketcan;
mod wire;

pub use bus::{Bus, Event, OpenError, Reception, SendError};
pub use error_report::{BusState, ErrorClass, ErrorReport};
pub use frame::{CanId, Frame, FrameError, FrameKind, Payload};
pub use interface::InterfaceName;
pub use memory::{MemoryBus, memory_pair};
pub use socketcan::{SocketCan, SocketCanConfig};
