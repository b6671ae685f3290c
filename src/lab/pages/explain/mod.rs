//! The answer of `explain` as text and as a page: the answer first, then where, what, how sure, and everything else.

mod answer;
mod caveats;
mod formula;
mod gain;
mod headline;
mod history;
mod in_your_model;
mod missing;
mod numbers;
mod place;
mod plots;
mod rest;
#[cfg(test)]
mod sample;
pub mod sensitivity;
mod sure;
#[cfg(test)]
mod tests;
mod text;
mod tires;
mod to_change;
mod tried;
mod verified;
pub(in crate::pages) mod words;

use crate::explain::{Explanation, Verdict};
use crate::report::Page;

pub use text::print;
pub use words::{answer as answer_lines, name_of};

/// The page as one HTML file.
pub fn page(explanation: &Explanation) -> String {
    let title = format!("gripd explain: {}", words::headline(explanation));
    let mut page = Page::empty(&title);
    answer::write(&mut page, explanation);
    to_change::write(&mut page, explanation);
    plots::write(&mut page, explanation);
    if let Some(history) = &explanation.history {
        history::section(&mut page, history);
    }
    place::write(&mut page, explanation);
    missing::write(&mut page, explanation);
    sure::write(&mut page, explanation);
    super::axles::section(&mut page, &explanation.cornering_stiffness);
    if let Some(ordinary) = &explanation.ordinary {
        super::ordinary::section(&mut page, ordinary);
    }
    rest::write(&mut page, explanation);
    page.section("reading", "How to read this", "");
    page.notes(&[MODELS, if explanation.is_by_ordinary { FREE_FIT } else { FIT }]);
    page.notes(NOTES);
    page.html()
}

/// Does the extended model differ from the plain one?
fn has_extension(explanation: &Explanation) -> bool {
    let fit = &explanation.fit;
    explanation.verdict == Verdict::MissingPhysics
        || fit.baseline != fit.extended && !fit.extended.train.is_empty()
}

const MODELS: (&str, &str) = (
    "Plain model, extended model",
    "A planar car on four tires, its uncertain parameters refitted to this recording; the same with what was found \
     missing, everything fitted together.",
);

const FIT: (&str, &str) = (
    "Fit",
    "100 (1 − |y − ŷ| / |y − mean y|) per cent of a simulation driven by the recorded steering wheel, torques and \
     brakes, restarted every 20 s from what was measured. 100 is perfect, 0 no better than the mean; noise alone keeps \
     it below 100.",
);

/// The same where free runs decided.
const FREE_FIT: (&str, &str) = (
    "Fit",
    "100 (1 − |y − ŷ| / |y − mean y|) per cent. Yaw rate and lateral acceleration: of a free run from the recording's \
     beginning, driven by the recorded steering wheel and the measured speed. Other channels: of a simulation driven by \
     steering wheel, torques and brakes, restarted every 20 s. 100 is perfect, 0 no better than the mean; noise alone \
     keeps it below 100.",
);

const NOTES: &[(&str, &str)] = &[
    (
        "Held out",
        "Stretches that were set apart before anything was fitted. Only what improves there is believed.",
    ),
    (
        "95 % interval of a gain",
        "From resampling the held-out recording in blocks, because noise of sensors and roads is no white noise. \
         An interval that includes zero may be chance.",
    ),
    (
        "Probability",
        "Among all effects that were tried and the plain model. It does not know of causes that are in no library; \
         for those the verdict is “unknown physics”.",
    ),
    (
        "2 ln odds",
        "Twice the logarithm of the odds for an effect alone against the plain model, after every ordinary parameter \
         was allowed to make up for it. 10 is strong; below 0 the plain model is the better explanation.",
    ),
];
