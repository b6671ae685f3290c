//! What is missing: words, equation, numbers, what else it could be, what to drive next; and what the
//! ordinary numbers moved to.

use std::collections::BTreeSet;

use super::words::{self, Shown, sentence, stopped};
use super::{answer, caveats, formula, place, plots};
use crate::explain::{Explanation, Finding, Verdict};
use crate::report::{Page, Shift, escape};

/// Writes it.
pub fn write(page: &mut Page, explanation: &Explanation) {
    if !explanation.findings.is_empty() {
        let is_usual = explanation.verdict == Verdict::Adequate;
        let title = if is_usual { "What every car has, and yours" } else { "What is missing" };
        page.section("missing", title, "");
        for finding in &explanation.findings {
            card(page, explanation, finding);
        }
    }
    let is_told_already = explanation.verdict == Verdict::InsufficientExcitation;
    if !explanation.to_drive.is_empty() && !is_told_already {
        if explanation.findings.is_empty() {
            page.section("drive", "What to drive next", "");
        } else {
            page.heading("What to drive next");
        }
        answer::to_drive(page, explanation);
    }
    ordinary(page, explanation);
    in_doubt(page, explanation);
}

/// Numbers that are not taken over.
fn in_doubt(page: &mut Page, explanation: &Explanation) {
    let all = caveats::in_doubt(explanation);
    if all.is_empty() {
        return;
    }
    page.heading("In doubt: left as they were where this is applied");
    let row = |it: &caveats::InDoubt| {
        let table = it.table.clone().unwrap_or_else(|| "–".into());
        vec![sentence(&it.name), it.found.clone(), table, it.why.clone(), it.behind.clone()]
    };
    let rows: Vec<Vec<String>> = all.iter().map(row).collect();
    let columns = ["parameter", "found", "the table's", "why", "what may be behind it"];
    page.table_of_words(&columns, &rows);
}

fn card(page: &mut Page, explanation: &Explanation, finding: &Finding) {
    let is_one_of_many = explanation.findings.len() > 1;
    page.raw("<article class=\"finding\">");
    page.raw(&format!("<p>{}</p>", escape(&answer::about(finding))));
    if !finding.equation.is_empty() {
        page.raw(&format!("<p class=\"equation\">{}</p>", formula::html(&finding.equation)));
    }
    let rows: Vec<Vec<String>> =
        words::parameters(finding).iter().map(|row| vec![sentence(&row.name), row.value()]).collect();
    if !rows.is_empty() {
        page.table_of_words(&["parameter", "value ± standard deviation"], &rows);
    }
    page.raw("<dl class=\"place\">");
    let entry = |term: &str, text: &str| format!("<div><dt>{term}</dt><dd>{}</dd></div>", escape(text));
    page.raw(&entry("Probability", &words::probability(finding.probability)));
    if let Some(was) = words::reference(finding) {
        page.raw(&entry(&format!("In {}", words::compared_with(explanation)), &was));
    }
    let explained = words::explained(finding);
    if !explained.is_empty() {
        page.raw(&entry("Explains, on held-out driving", &stopped(&explained)));
    }
    let alike: Vec<String> =
        finding.indistinguishable_from.iter().map(|name| words::effect_named(name)).collect();
    let alike = if alike.is_empty() { "nothing that was tried".to_owned() } else { words::list(&alike) };
    page.raw(&entry("What else it could be", &stopped(&alike)));
    if !finding.to_tell_apart.is_empty() {
        page.raw(&entry("What would settle it", &stopped(&finding.to_tell_apart)));
    }
    let mechanisms = finding.law.as_ref().map(|law| law.mechanisms.join("; ")).unwrap_or_default();
    if !mechanisms.is_empty() {
        page.raw(&entry("What may be behind it", &stopped(&mechanisms)));
    }
    if is_one_of_many {
        place::about(page, &finding.place);
        if !finding.place.intervals.is_empty() {
            page.raw(&entry("When", &words::intervals(&finding.place, 6)));
        }
    }
    if let Some(at) = &finding.at_utc {
        page.raw(&entry("Since", at));
    }
    page.raw("</dl></article>");
}

/// One of the ordinary numbers, before and after.
struct Move {
    before: Option<Shown>,
    after: Option<Shown>,
    is_in_doubt: bool,
}

impl Move {
    fn name(&self) -> Option<String> {
        let mark = if self.is_in_doubt { " (in doubt)" } else { "" };
        Some(sentence(&self.any()?.name) + mark)
    }

    fn any(&self) -> Option<&Shown> {
        self.after.as_ref().or(self.before.as_ref())
    }

    /// In standard deviations, those of the surer one.
    fn size(&self) -> f64 {
        let (Some(before), Some(after)) = (&self.before, &self.after) else { return f64::INFINITY };
        let std = before.estimate.std.min(after.estimate.std).max(f64::MIN_POSITIVE);
        let size = (after.estimate.value - before.estimate.value).abs() / std;
        if size.is_finite() { size } else { 0.0 }
    }
}

/// Smaller moves are none, in standard deviations.
const LEAST_MOVE: f64 = 1.0;

fn ordinary(page: &mut Page, explanation: &Explanation) {
    let (before, after) = (&explanation.parameters.baseline, &explanation.parameters.extended);
    let names: BTreeSet<&String> = before.keys().chain(after.keys()).collect();
    let mut moves: Vec<Move> = names
        .into_iter()
        .map(|name| Move {
            before: before.get(name).map(|estimate| words::ordinary(name, *estimate)),
            after: after.get(name).map(|estimate| words::ordinary(name, *estimate)),
            is_in_doubt: explanation.in_doubt.contains_key(name),
        })
        .collect();
    if moves.is_empty() {
        return;
    }
    moves.sort_by(|a, b| b.size().total_cmp(&a.size()));
    let has_moved = |it: &Move| super::has_extension(explanation) && it.size() >= LEAST_MOVE;
    let (moved, stayed): (Vec<Move>, Vec<Move>) = moves.into_iter().partition(has_moved);
    if explanation.findings.is_empty() {
        page.section("parameters", "The ordinary parameters", "");
    }
    if !moved.is_empty() {
        let rows: Vec<Shift> = moved.iter().filter_map(shift).collect();
        let [plain, extended] = plots::names(explanation);
        page.shifts(
            "What the ordinary parameters moved to",
            (plain, extended),
            &rows,
            "Bars: 95 % intervals; text: ± one standard deviation. Each row has a scale of its own. Whatever the plain \
             model lacks, these had to make up for.",
        );
    }
    let row = |it: &Move| Some(vec![it.name()?, it.any()?.value()]);
    let rows: Vec<Vec<String>> = stayed.iter().filter_map(row).collect();
    if rows.is_empty() {
        return;
    }
    if !moved.is_empty() {
        page.heading("Ordinary parameters that hardly moved");
    }
    page.table_of_words(&["parameter", "value ± standard deviation"], &rows);
}

fn shift(it: &Move) -> Option<Shift> {
    let any = it.any()?;
    let interval = |shown: &Shown| {
        let (value, half) = (shown.estimate.value, 1.96 * shown.estimate.std);
        [value - half, value, value + half]
    };
    let said = |shown: &Option<Shown>| {
        shown.as_ref().map_or_else(|| "–".into(), |it| words::plus_minus(it.estimate))
    };
    Some(Shift {
        name: it.name()?,
        unit: any.unit.clone(),
        before: it.before.as_ref().map(interval),
        after: it.after.as_ref().map(interval),
        before_text: said(&it.before),
        after_text: said(&it.after),
    })
}
