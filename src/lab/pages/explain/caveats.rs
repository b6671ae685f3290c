//! What is to be known before an answer is used: which part of the recordings it is of, and which of its numbers are in doubt.

use super::words::{list, number, ordinary};
use crate::explain::{Estimate, Explanation, Used};
use identify::Doubt;
use physics::model::TireKind;

/// Which part of each recording was used, and why not the rest; nothing of those that were used whole.
pub fn used(explanation: &Explanation) -> Vec<String> {
    let of = |used: &Used| {
        let left: Vec<String> =
            used.left_out.iter().map(|it| format!("{} s {}", number(it.seconds, 0), it.why)).collect();
        (!left.is_empty()).then(|| {
            let (long, whole) = (number(used.used_s, 0), number(used.seconds, 0));
            format!("{long} of {whole} s of {}; left out: {}", used.recording, list(&left))
        })
    };
    explanation.used.iter().filter_map(of).collect()
}

/// Tires that bend otherwise than the configuration's.
pub fn tires(explanation: &Explanation) -> Option<String> {
    let kind = match explanation.tires_bend_as? {
        TireKind::Brush => "a brush does: their stiffness falls in proportion to the force",
        TireKind::MagicFormula => "a magic formula does: hardly before half of the friction is used",
        TireKind::Piecewise | TireKind::Linear => return None,
    };
    Some(format!(
        "those of the recording bend as {kind}; with the configuration's more would be missing (`tire` in [vehicle], which --apply \
         writes)"
    ))
}

/// A number in doubt, as it is shown.
pub struct InDoubt {
    /// What it is.
    pub name: String,
    /// What was found.
    pub found: String,
    /// What the table has, if it has it.
    pub table: Option<String>,
    /// Why it is in doubt.
    pub why: String,
    /// What may be behind it, if anybody knows.
    pub behind: String,
}

impl InDoubt {
    /// All of it.
    pub fn line(&self) -> String {
        let mut line = format!("{} {}: {}", self.name, self.found, self.why);
        if let Some(table) = &self.table {
            line += &format!(" ({table})");
        }
        if !self.behind.is_empty() {
            line += &format!("; what may be behind it: {}", self.behind);
        }
        line
    }
}

/// What is in doubt of an answer.
pub fn in_doubt(explanation: &Explanation) -> Vec<InDoubt> {
    let of = |(name, doubt): (&String, &Doubt)| {
        let found = ordinary(name, Estimate { value: doubt.value, std: doubt.std });
        let table = doubt.table.map(|table| ordinary(name, Estimate { value: table.value, std: table.std }));
        InDoubt {
            name: found.name.clone(),
            found: found.value(),
            table: table.map(|table| table.value()),
            why: doubt.why.clone(),
            behind: doubt.behind.into(),
        }
    };
    explanation.in_doubt.iter().map(of).collect()
}
