//! From DBC signals to physical quantities and back.

pub mod e2e;
pub mod publish;
