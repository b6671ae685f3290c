//! The moments of an answer by the calendar, beside the seconds of each recording.

use std::collections::BTreeMap;

use super::result::{Explanation, Where};
use physics::model::effect::Spec;
use physics::time::Clock;
use predict::Recording;

/// Recordings by their names.
struct Clocks<'r>(&'r [Recording]);

impl Clocks<'_> {
    /// Of the one with this name; where there is one only it needs none.
    fn of(&self, name: &str) -> Option<Clock> {
        let own = self.0.iter().find(|recording| recording.name == name);
        match (own, self.0) {
            (Some(own), _) => Some(own.clock()),
            (None, [only]) if name.is_empty() => Some(only.clock()),
            _ => None,
        }
    }

    fn tell(&self, place: &mut Where) {
        if let Some(clock) = self.of(&place.recording) {
            place.intervals_utc = place.intervals.iter().filter_map(|it| clock.utc_of(*it)).collect();
        }
    }
}

/// When recordings begin, by their names, of those whose stamps are dates.
pub fn begins(recordings: &[Recording]) -> BTreeMap<String, String> {
    recordings.iter().filter_map(|it| Some((it.name.clone(), it.clock().utc(0.0)?))).collect()
}

impl Explanation {
    /// Says all its moments in UTC, too, where the recordings' stamps are dates.
    pub fn tell_dates(&mut self, recordings: &[Recording]) {
        let clocks = Clocks(recordings);
        self.begins_utc = begins(recordings);
        clocks.tell(&mut self.place);
        for finding in &mut self.findings {
            clocks.tell(&mut finding.place);
            // A moment before the recording: it was there from the start.
            let at = finding.parameters.get(Spec::AT_S.name).map(|at| at.value).filter(|at| *at >= 0.0);
            finding.at_utc =
                at.zip(clocks.of(&finding.place.recording)).and_then(|(at, clock)| clock.utc(at));
        }
        for block in &mut self.split {
            block.t_utc = clocks.of(&block.recording).and_then(|clock| clock.utc_of(block.t));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::{Estimate, Finding, Verdict};

    #[test]
    fn moments_are_told_by_the_clock_of_their_recording() {
        let recording =
            |name: &str, begins_s| Recording { name: name.into(), begins_s, ..Recording::default() };
        let recordings = [recording("a", Some(1.76e9)), recording("b", Some(5.0))];
        let place =
            |name: &str| Where { recording: name.into(), intervals: vec![[1.0, 2.5]], ..Where::default() };
        let mut explanation = Explanation::empty(Verdict::MissingPhysics);
        explanation.place = place("b");
        let at = [("at_s".to_owned(), Estimate { value: 4.0, std: 0.1 })];
        let finding = Finding { place: place("a"), parameters: at.into(), ..Finding::default() };
        explanation.findings.push(finding);
        explanation.tell_dates(&recordings);
        let told = &explanation.findings[0];
        let utc = |second: &str| format!("2025-10-09T08:53:{second}Z");
        assert_eq!(told.place.intervals_utc, [[utc("21.000"), utc("22.500")]]);
        assert_eq!(told.at_utc, Some(utc("24.000")));
        assert!(explanation.place.intervals_utc.is_empty(), "seconds since a start are no date");
        assert_eq!(explanation.begins_utc, [("a".to_owned(), utc("20.000"))].into());
    }
}
