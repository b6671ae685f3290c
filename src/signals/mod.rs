//! From DBC signals to physical quantities and back.
