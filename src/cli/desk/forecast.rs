//! How much of a long work is done, and how long the rest takes.

use identify::Stage;

/// What is not in a table takes so much of the first stage.
const USUAL: f64 = 0.5;

/// A stage that takes longer than it should takes so much of its time so far still. Numerical: for want of knowledge.
const LONGER: f64 = 0.3;

/// Of a fifth of a stage its own pace is known. Numerical.
const SOON: f64 = 5.0;

/// Before this share of the first stage nobody knows how long it takes.
const LEAST: f64 = 0.03;

/// Follows the stages of a work. Seconds are counted from its beginning.
#[derive(Debug)]
pub struct Forecast {
    stages: &'static [Stage],
    /// The stage it is in: its name, when that began, and how much of it is done, as far as it tells.
    now: Option<(String, f64, f64)>,
    /// How long the first stage took, s.
    first_took: Option<f64>,
    /// The most that was said to be done.
    share: f64,
}

impl Forecast {
    /// Of a work in these stages.
    pub fn new(stages: &'static [Stage]) -> Self {
        Self { stages, now: None, first_took: None, share: 0.0 }
    }

    /// A mark: the stage, and the share of it that is done (0–1).
    pub fn at(&mut self, seconds: f64, name: &str, inner: f64) {
        match &mut self.now {
            Some((now, _, done)) if now == name => *done = inner,
            now => {
                if let Some((_, began, _)) = now {
                    self.first_took.get_or_insert(seconds - *began);
                }
                *now = Some((name.to_owned(), seconds, inner));
            }
        }
    }

    /// Is it in this stage?
    pub fn is_in(&self, name: &str) -> bool {
        self.now.as_ref().is_some_and(|(now, ..)| now == name)
    }

    /// What is left, s; `counted` is how much of the stage is done, where that is counted elsewhere.
    pub fn left(&self, seconds: f64, counted: Option<f64>) -> Option<f64> {
        let (name, began, inner) = self.now.as_ref()?;
        let stage = self.stages.iter().find(|stage| stage.name == name);
        let (takes, after) = stage.map_or((USUAL, USUAL), |stage| (stage.takes, stage.after));
        let so_far = seconds - began;
        let inner = counted.unwrap_or(*inner);
        let Some(first_took) = self.first_took else {
            let whole = (inner >= LEAST).then(|| so_far / inner)?;
            return Some(whole - so_far + after / takes * whole);
        };
        let as_usual = (takes * first_took - so_far).max(LONGER * so_far);
        // Soon its own pace counts for more than what is usual.
        let here = match inner {
            0.0 => as_usual,
            inner => {
                let own = (SOON * inner).min(1.0);
                own * so_far * (1.0 - inner) / inner + (1.0 - own) * as_usual
            }
        };
        Some(here + after * first_took)
    }

    /// The share that is done, which never falls.
    pub fn share(&mut self, seconds: f64, left: Option<f64>) -> f64 {
        if let Some(left) = left {
            self.share = self.share.max(seconds / (seconds + left).max(f64::MIN_POSITIVE));
        }
        self.share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAGES: &[Stage] = &[
        Stage { name: "fit", takes: 1.0, after: 1.0 },
        Stage { name: "name", takes: 0.5, after: 0.5 },
        Stage { name: "prove", takes: 0.5, after: 0.0 },
    ];

    #[test]
    fn work_as_usual_is_foreseen_from_its_first_stage() {
        let mut forecast = Forecast::new(STAGES);
        assert_eq!(forecast.left(0.0, None), None);
        forecast.at(0.0, "fit", 0.0);
        assert_eq!(forecast.left(1.0, Some(0.01)), None);
        // A quarter of ten seconds, and as much again after it.
        assert_eq!(forecast.left(2.5, Some(0.25)), Some(17.5));
        forecast.at(10.0, "name", 0.0);
        assert_eq!(forecast.left(12.0, None), Some(8.0));
        forecast.at(15.0, "prove", 0.0);
        assert_eq!(forecast.left(18.0, None), Some(2.0));
    }

    #[test]
    fn the_bar_never_goes_back_and_the_rest_is_never_nothing_before_the_end() {
        let mut forecast = Forecast::new(STAGES);
        forecast.at(0.0, "fit", 0.0);
        let mut before = 0.0;
        for tick in 1..400 {
            let seconds = 0.1 * f64::from(tick);
            match tick {
                100 => forecast.at(seconds, "name", 0.0),
                // Three times as long as usual, then something that no table has.
                250 => forecast.at(seconds, "again", 0.0),
                _ => (),
            }
            let left = forecast.left(seconds, Some((0.01 * f64::from(tick)).min(1.0)));
            assert!(left.is_none_or(|left| left > 0.0), "{tick} {left:?}");
            let share = forecast.share(seconds, left);
            assert!(share >= before && share < 1.0, "{tick} {share}");
            before = share;
        }
    }

    #[test]
    fn a_stage_that_counts_goes_at_its_own_pace() {
        let mut forecast = Forecast::new(STAGES);
        forecast.at(0.0, "fit", 0.0);
        forecast.at(10.0, "prove", 0.0);
        // Usually five seconds; nearly at its end by its own count, after twenty.
        forecast.at(30.0, "prove", 0.9);
        let left = forecast.left(30.0, None).unwrap();
        assert!((2.0..4.0).contains(&left), "{left}");
        // The same, where it is counted elsewhere.
        forecast.at(30.0, "prove", 0.0);
        assert_eq!(forecast.left(30.0, Some(0.9)), Some(left));
    }
}
