//! The page: per section its claims, then its pictures.

use super::Done;
use super::SECTIONS;
use super::table::{COLUMNS, Counts, cells};
use crate::report::{Page, PlotError};

/// The page of what was carried out.
pub fn html(done: &[Done]) -> Result<String, PlotError> {
    let mut page = Page::new(
        "gripd reproduce: the thesis, carried out again",
        &format!(
            "E. Narby, Modeling and Estimation of Dynamic Tire Properties, Linköping 2006: its figures and \
             claims, computed anew. {}.",
            Counts::of(done)
        ),
    );
    for section in SECTIONS {
        let of_section: Vec<&Done> = done
            .iter()
            .filter(|done| section.experiments.iter().any(|it| it.figure == done.experiment.figure))
            .collect();
        if of_section.is_empty() {
            continue;
        }
        page.heading(section.title);
        let rows: Vec<Vec<String>> = of_section.iter().flat_map(|done| cells(done)).map(row).collect();
        page.table_of_words(&COLUMNS, &rows);
        for outcome in of_section.iter().filter_map(|done| done.outcome.as_ref().ok()) {
            for picture in &outcome.pictures {
                page.plot(&picture.heading, &picture.plot, &picture.caption)?;
            }
        }
    }
    Ok(page.html())
}

/// The note stands behind what it is about.
fn row((mut cells, note): ([String; 5], String)) -> Vec<String> {
    if let [_, _, _, ours, _] = &mut cells
        && !note.is_empty()
    {
        *ours += &format!(" ({note})");
    }
    cells.to_vec()
}
