//! What was tried, told such that what gained nothing is said once.

use std::collections::BTreeSet;

use super::words::{self, sentence, signed};
use crate::explain::{Explanation, Ranked};

/// So many with the very same score are a group.
const LEAST_GROUP: usize = 5;

/// The ranking in two parts.
pub struct Tried<'a> {
    /// Those with a score of their own, the best first.
    pub own: Vec<&'a Ranked>,
    /// Those that gained nothing: all of them have the same score, that of having nothing to add.
    pub idle: Vec<&'a Ranked>,
}

impl<'a> Tried<'a> {
    /// Of an answer.
    pub fn of(explanation: &'a Explanation) -> Self {
        let ranking = &explanation.ranking;
        let alike =
            |it: &Ranked| ranking.iter().filter(|other| score(other.score) == score(it.score)).count();
        let group = ranking
            .iter()
            .filter(|it| it.score < 0.0)
            .map(|it| (alike(it), it.score))
            .filter(|(count, _)| *count >= LEAST_GROUP)
            .max_by(|a, b| a.0.cmp(&b.0))
            .map(|(_, shared)| score(shared));
        let (idle, own) = ranking.iter().partition(|it| group.as_ref() == Some(&score(it.score)));
        Self { own, idle }
    }

    /// How many gained nothing, in words; `None` if there are none.
    pub fn nothing(&self) -> Option<String> {
        let first = self.idle.first()?;
        let others = if self.own.is_empty() { "all" } else { "others" };
        Some(format!("{} {others}: nothing gained ({} each)", self.idle.len(), score(first.score)))
    }
}

/// Twice the log odds, as it is shown.
pub fn score(score: f64) -> String {
    signed(score, if score.abs() < 9.95 { 1 } else { 0 })
}

/// An effect of the ranking.
pub fn name(ranked: &Ranked) -> String {
    sentence(&words::effect(&ranked.effect, ranked.channel.as_deref()))
}

/// How many were tried.
pub fn count(explanation: &Explanation) -> String {
    match explanation.ranking.len() {
        0 => "the effects that were tried".into(),
        1 => "the one effect that was tried".into(),
        count => format!("the {count} effects that were tried"),
    }
}

/// How many kinds that were, for those of sensors come once for each channel: to go on with a sentence.
pub fn kinds(explanation: &Explanation) -> String {
    let kinds: BTreeSet<&str> = explanation.ranking.iter().map(|it| it.effect.as_str()).collect();
    match kinds.len() {
        kinds if kinds == explanation.ranking.len() => String::new(),
        kinds => format!(" ({kinds} kinds, those of sensors for each channel)"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn what_gained_nothing_is_a_group() {
        let mut explanation = sample::adequate();
        let count = explanation.ranking.len();
        for ranked in explanation.ranking.iter_mut().skip(2) {
            ranked.score = -4.2;
        }
        explanation.ranking[1].score = -1.0;
        let tried = Tried::of(&explanation);
        assert_eq!((tried.own.len(), tried.idle.len()), (2, count - 2));
        assert_eq!(tried.nothing().unwrap(), format!("{} others: nothing gained (−4.2 each)", count - 2));
        // What gained is not one of them, however many are alike.
        for ranked in &mut explanation.ranking {
            ranked.score = 12.0;
        }
        assert!(Tried::of(&explanation).nothing().is_none());
        assert_eq!(kinds(&explanation), "", "each kind once");
        explanation.ranking.extend(explanation.ranking.last().cloned());
        assert_eq!(kinds(&explanation), format!(" ({count} kinds, those of sensors for each channel)"));
    }
}
