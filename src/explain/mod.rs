//! Where recording and physics disagree, and why.
//!
//! The first step is [`chain`]: before any physics is blamed, the measurement chain must be right.

pub mod chain;
