//! The thesis, experiment by experiment: what of it holds.

use gripd::reproduce::{SECTIONS, Section as Chapter, Verdict};
use rayon::prelude::*;
use testing::results::Section;

/// What came of a chapter's experiments, as a row. Each claims something, its pictures can be drawn, and what differs
/// has a reason.
fn row(chapter: &Chapter) -> String {
    let outcomes: Vec<_> =
        chapter.experiments.par_iter().map(|experiment| (experiment.run)().unwrap()).collect();
    for (experiment, outcome) in chapter.experiments.iter().zip(&outcomes) {
        assert!(!outcome.claims.is_empty(), "{} claims nothing", experiment.figure);
        for claim in &outcome.claims {
            let differs = matches!(claim.verdict, Verdict::Differs | Verdict::Short);
            assert!(!differs || !claim.note.is_empty(), "{}: {claim:?}", experiment.figure);
        }
        for picture in &outcome.pictures {
            assert!(picture.plot.svg_file().is_ok(), "{}", picture.name);
        }
    }
    let claims: Vec<_> = outcomes.iter().flat_map(|outcome| &outcome.claims).collect();
    let count = |verdict| claims.iter().filter(|claim| claim.verdict == verdict).count();
    format!(
        "{} | {} | {} | {} | {} | {}",
        chapter.title,
        outcomes.len(),
        count(Verdict::Holds),
        count(Verdict::Differs),
        count(Verdict::Better),
        count(Verdict::Short)
    )
}

mod by_hand {
    use super::*;

    #[test]
    #[ignore = "by hand: every experiment, minutes"]
    fn what_holds_of_the_thesis() {
        let section = Section {
            name: "thesis",
            seed: "the experiments' own seeds",
            tolerance: 0.0,
            header: "of the thesis | experiments | claims that hold | that differ | own answers that are better | that fall short",
        };
        section.check(&SECTIONS.iter().map(row).collect::<Vec<_>>());
    }
}
