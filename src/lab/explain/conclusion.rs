//! What the search and the verdict came to.

use super::case::Case;
use super::fit::{Data, Fit};
use super::ordinary::{Along, Ordinary};
use super::result::Verdict;
use super::select::Selection;
use predict::GriddedDrive;

/// Everything that an answer is made of.
pub struct Conclusion<'c, 'a> {
    /// What there was to explain.
    pub case: &'c Case<'a>,
    /// Its recordings on the filter's grid.
    pub drives: &'c [GriddedDrive],
    /// The same with their split.
    pub data: &'c Data<'c>,
    /// The plain model with unknown forces.
    pub corrected: &'c Fit<'a>,
    /// The ordinary car, where it could be fitted, and what it decides: the plain model and its effects did not.
    pub ordinary: Option<(&'c Ordinary, Option<Verdict>)>,
    /// What the measured speed says along the road, where the ordinary car decides.
    pub along: Option<&'c Along>,
    /// What was chosen.
    pub selection: &'c Selection<'a>,
    /// What the plain model and its effects came to.
    pub verdict: Verdict,
}
