//! Several causes at once, and whether what is said to be probable is.

use super::part::{Cell, Part, text};
use super::score::{Said, Score};
use super::share::Share;

/// All parts.
pub fn parts(scores: &[Score]) -> [Part; 2] {
    [several(scores), probabilities(scores)]
}

fn several(scores: &[Score]) -> Part {
    let of = |count: usize| scores.iter().filter(move |s| s.kind == "several" && s.found.len() == count);
    let row = |count: usize| {
        let said = || of(count).flat_map(|s| &s.said_of);
        let beyond = || said().filter(|said| !said.is_ordinary);
        vec![
            Cell::Number(Some(count as f64), 0),
            Cell::Number(Some(of(count).count() as f64), 0),
            Cell::Share(Share::of(of(count).flat_map(|s| &s.found), |found| *found)),
            Cell::Share(Share::of(of(count), |s| s.found.iter().all(|found| *found))),
            Cell::Share(Share::of(of(count), |s| s.called_unknown())),
            Cell::Share(Share::of(said(), |said| !said.is_right)),
            Cell::Share(Share::of(beyond(), |said| !said.is_right)),
        ]
    };
    Part {
        key: "several",
        heading: "Several causes at once".into(),
        columns: vec![
            "causes",
            "recordings",
            "causes found",
            "all found",
            "called unknown",
            "false findings",
            "of what is not ordinary",
        ],
        rows: [2, 3].map(row).into(),
    }
}

/// What is said to be so probable, and how often it is right.
fn probabilities(scores: &[Score]) -> Part {
    let said = || scores.iter().filter(|s| s.kind != "unknown").flat_map(|s| &s.said_of);
    let row = |(low, high): (f64, f64)| {
        let within = |said: &&Said| (low..high).contains(&said.probability);
        let mean = super::part::mean(said().filter(within).map(|said| said.probability));
        vec![
            text(format!("{low} – {}", high.min(1.0))),
            Cell::Number(mean, 3),
            Cell::Share(Share::of(said().filter(within), |said| said.is_right)),
        ]
    };
    Part {
        key: "probabilities",
        heading: "Findings by the probability that is stated (what no library has left out)".into(),
        columns: vec!["stated", "mean", "right"],
        rows: [(0.0, 0.5), (0.5, 0.8), (0.8, 0.9), (0.9, 0.95), (0.95, 0.99), (0.99, 2.0)].map(row).into(),
    }
}
