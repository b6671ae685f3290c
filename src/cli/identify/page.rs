//! The page.
use super::Story;
use crate::report::PlotError;
/// The page.
pub fn html(_story: &Story<'_>) -> Result<String, PlotError> {
    Ok(String::new())
}
