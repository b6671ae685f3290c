//! The configuration file: what each room wants to know, joined and checked.

/// The whole configuration.
#[derive(Clone, Debug)]
pub struct Config {}
