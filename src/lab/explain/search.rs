//! The search for effects: in all of a short recording, in an excerpt of a long one.

use physics::Quantity;
use predict::noise::Noise;

use super::candidates::Candidate;
use super::excerpt::Excerpt;
use super::fit::Data;
use super::long_recording::LongSearch;
use super::model::{Free, Model};
use super::select::{Selection, select};
use super::signs_and_swaps;

/// What all searches of a case have in common.
pub struct Search<'s, 'd, H, L> {
    /// All of the recordings.
    pub data: &'s Data<'d>,
    /// What is worth it of a long recording.
    pub excerpt: Option<Excerpt>,
    /// To begin with.
    pub noise: &'s Noise,
    /// Wrong signs and swapped channels that the audit suggests.
    pub suggested: &'s [Candidate],
    /// What the recordings have.
    pub has: H,
    /// The candidates for a model, of something that could have begun at certain moments, s.
    pub library: L,
}

impl<H, L> Search<'_, '_, H, L>
where
    H: Fn(Quantity) -> bool + Copy,
    L: Fn(&Model<'_>, &[f64]) -> Vec<Candidate>,
{
    /// All of it, from a plain model.
    pub fn select<'a>(&self, plain: &Model<'a>, progress: &(dyn Fn(&str, f64) + Sync)) -> Selection<'a> {
        if let Some(excerpt) = self.excerpt.clone() {
            let plain = (plain, &self.free(plain)[..], self.noise);
            let search = LongSearch { data: self.data, plain, suggested: self.suggested };
            return search.select(excerpt, &self.library, progress);
        }
        select(self.data, self.prepared(self.data, plain), &self.library, usize::MAX, progress)
    }

    /// Only the first round.
    pub fn begin<'a>(&self, plain: &Model<'a>, progress: &(dyn Fn(&str, f64) + Sync)) -> Selection<'a> {
        self.in_part(|part| select(part, self.prepared(part, plain), &self.library, 1, progress))
    }

    /// All of it, after the first round from that plain model.
    pub fn go_on<'a>(
        &self,
        begun: Selection<'a>,
        plain: &Model<'a>,
        progress: &(dyn Fn(&str, f64) + Sync),
    ) -> Selection<'a> {
        if self.excerpt.is_some() {
            // The excerpt grows by what a fit to it misses.
            return self.select(plain, progress);
        }
        if begun.chosen.is_empty() {
            return begun;
        }
        select(self.data, begun, &self.library, usize::MAX, progress)
    }

    /// Asks something of what is searched first.
    pub fn in_part<T>(&self, ask: impl FnOnce(&Data<'_>) -> T) -> T {
        match &self.excerpt {
            Some(excerpt) => ask(&self.data.over(&excerpt.drives(self.data.drives))),
            None => ask(self.data),
        }
    }

    /// What is free of a plain model.
    pub fn free(&self, plain: &Model<'_>) -> Vec<Free> {
        plain.ordinary(self.has)
    }

    fn prepared<'a>(&self, data: &Data<'_>, plain: &Model<'a>) -> Selection<'a> {
        let free = self.free(plain);
        let baseline = data.fit_thoroughly(plain, &free, self.noise);
        let before = signs_and_swaps::taken(data, plain, &baseline, (&free, self.noise), self.suggested);
        Selection::begun(baseline, before, data.split.clone())
    }
}
