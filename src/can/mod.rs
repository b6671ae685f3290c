//! CAN frames, and the buses and recordings they come from and go to.

mod frame;

pub use frame::{CanId, Frame, FrameError, FrameKind, Payload};
