//! Plots to look into: their data and a plotting library stand in the page, and all panels zoom together.
//!
//! Rust says what there is ([`Plots`]: panels over time, figures of one quantity over another), and one script,
//! `page.js`, draws whatever it is given. Nothing is fetched: the page works from a disk, by mail, and in ten years.

mod embedded;
mod figure;
mod numbers;
mod panel;
mod plots;
mod spans;
mod thin;

pub use embedded::Embedded;
pub use figure::{Figure, Line, Points, Ring, Shade, Shape};
pub use numbers::Numbers;
pub use panel::{Band, Panel, Series, Source, Span};
pub use plots::{Clock, Mark, Plots};
pub use spans::spans;
pub use thin::Grid;
