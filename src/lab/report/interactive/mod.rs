//! Pages to look into: one HTML file with its data and a plotting library in it, whose panels zoom together.
//!
//! Rust says what there is ([`Document`]: panels over time, figures of one quantity over another), and one script,
//! `page.js`, draws whatever it is given. Nothing is fetched: the page works from a disk, by mail, and in ten years.

mod document;
mod figure;
mod html;
mod numbers;
mod panel;
mod spans;
mod thin;

pub use document::{Clock, Document, Fact, Mark};
pub use figure::{Figure, Line, Points, Ring, Shade, Shape};
pub use html::HtmlError;
pub use numbers::Numbers;
pub use panel::{Panel, Series, Source, Span};
pub use spans::spans;
pub use thin::Grid;
