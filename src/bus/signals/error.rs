//! What can be wrong with the mapping, all of it at once.

use std::fmt;

use thiserror::Error;

/// One thing to be put right in the configuration.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{key}: {message}")]
pub struct Problem {
    /// The key, from the top of the file: `signals.yaw_rate.sign`.
    pub key: String,
    /// What is wrong with it and what to do.
    pub message: String,
}

/// Everything that is wrong with `[signals]`, so that a user mends it in one go.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub struct SignalsError {
    /// At least one.
    pub problems: Vec<Problem>,
}

impl fmt::Display for SignalsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let [only] = self.problems.as_slice() {
            return write!(f, "{only}");
        }
        write!(f, "{} problems in [signals]:", self.problems.len())?;
        for problem in &self.problems {
            write!(f, "\n  {problem}")?;
        }
        Ok(())
    }
}

/// Gathers problems while the mapping is compiled.
#[derive(Debug, Default)]
pub(super) struct Problems(Vec<Problem>);

impl Problems {
    pub(super) fn add(&mut self, key: impl Into<String>, message: impl Into<String>) {
        let problem = Problem { key: key.into(), message: message.into() };
        if !self.0.contains(&problem) {
            self.0.push(problem);
        }
    }

    /// `Ok` if nothing was gathered.
    pub(super) fn finish(self) -> Result<(), SignalsError> {
        if self.0.is_empty() { Ok(()) } else { Err(SignalsError { problems: self.0 }) }
    }
}

/// The known name nearest to a mistyped one, if it is near enough to be meant.
pub(super) fn nearest<'a>(typed: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|name| (edits(typed, name), name))
        .min()
        .filter(|(distance, name)| *distance <= name.len() / 3 + 1)
        .map(|(_, name)| name)
}

/// Insertions, deletions and substitutions between two names (Levenshtein), case ignored.
fn edits(a: &str, b: &str) -> usize {
    let (a, b) = (a.to_lowercase(), b.to_lowercase());
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.chars().enumerate() {
            let substituted = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[row.len() - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistyped_name_is_recognized_and_a_foreign_one_is_not() {
        let known = ["yaw_rate", "brake_torque"];
        assert_eq!(nearest("yawrate", known), Some("yaw_rate"));
        assert_eq!(nearest("Brake_Torque", known), Some("brake_torque"));
        assert_eq!(nearest("interface", known), None);
    }

    #[test]
    fn one_problem_is_a_line_and_several_are_a_list() {
        let mut problems = Problems::default();
        problems.add("signals.yaw_rate.sign", "is 8 bits wide");
        problems.add("signals.yaw_rate.sign", "is 8 bits wide");
        let one = problems.finish().unwrap_err();
        assert_eq!(one.to_string(), "signals.yaw_rate.sign: is 8 bits wide");
        let mut problems = Problems::default();
        problems.add("a", "x");
        problems.add("b", "y");
        assert_eq!(problems.finish().unwrap_err().to_string(), "2 problems in [signals]:\n  a: x\n  b: y");
    }
}
