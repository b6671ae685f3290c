//! Reports for people: a page that is one HTML file, and the plots on it as inline SVG.
//!
//! Nothing is fetched, so a page can be mailed, printed and kept. A script runs only in a [`Page`] with plots of
//! [`interactive`], which draw themselves, to be looked into. Colours are CSS variables ([`Color`]), so that one file reads
//! well on light and on dark screens.

mod color;
mod decimate;
pub mod interactive;
mod markup;
mod page;
mod plot;
mod shifts;
mod wrap;

pub use color::Color;
pub use markup::{escape, number};
pub use page::{Fact, Page};
pub use plot::{Mark, Marker, Plot, PlotError, Segment, Span, Stroke};
pub use shifts::Shift;
pub use wrap::{WIDTH, wrapped};
