//! The verdict: do the named effects explain what the unknown forces could?

use super::fit::{Data, Fit};
use super::naming::OF_A_COURSE;
use super::result::Verdict;
use super::select::Selection;
use super::tuning::TUNING;
use physics::Quantity;
use predict::car::BODY_STATES;

/// What the sizes and lengths of the unknown forces and the moment are worth, which were searched for.
const FREEDOM: f64 = 3.0 * OF_A_COURSE;

/// By how much −2 ln likelihood falls, the prior counted in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gains {
    /// Seconds that this is of.
    pub seconds: f64,
    /// With what was chosen; none, if nothing was.
    pub named: Option<f64>,
    /// Share of the evidence of all that was chosen which the first name has.
    pub leading: f64,
    /// The same of the strongest name.
    pub strongest: f64,
    /// With unknown forces instead.
    pub unknown: f64,
    /// With a course that had to be refused instead.
    pub refused: f64,
    /// What each equation of the plain model misses.
    pub missing: [f64; BODY_STATES],
    /// What each equation misses beside what was chosen.
    pub left: [f64; BODY_STATES],
    /// How much more than usual a sensor errs now and then…
    pub restless: f64,
    /// …and beside what was chosen.
    pub still_restless: f64,
    /// The same of those sensors that tell of the motion along the car and of single wheels.
    pub still_restless_along: f64,
}

/// What the ordinary car, driven by a measured speed, does not predict.
const ALONG: [Quantity; 5] = [
    Quantity::WheelSpeedFl,
    Quantity::WheelSpeedFr,
    Quantity::WheelSpeedRl,
    Quantity::WheelSpeedRr,
    Quantity::LongitudinalAcceleration,
];

impl Gains {
    /// Of a selection and the plain model with unknown forces.
    pub fn of(data: &Data<'_>, selection: &Selection<'_>, corrected: &Fit<'_>) -> Self {
        let plain = &selection.baseline;
        let following = selection.rounds.iter().take(1).flat_map(|round| &round.following);
        let has_names = !selection.chosen.is_empty();
        let counted = data.counted(&plain.sums);
        let missing = data.missing(plain);
        let of_names = selection.of_names();
        let evidence: f64 = of_names.iter().sum();
        Self {
            leading: of_names.first().map_or(1.0, |first| first / evidence),
            strongest: of_names.iter().copied().max_by(f64::total_cmp).map_or(1.0, |most| most / evidence),
            seconds: counted.map(|sums| sums.t.1 - sums.t.0).sum(),
            named: has_names.then(|| plain.cost() - selection.extended.cost()),
            unknown: plain.cost() - corrected.cost() - FREEDOM,
            refused: following.map(|(_, evidence)| *evidence).fold(0.0, f64::max),
            missing,
            left: if has_names { data.missing(&selection.extended) } else { missing },
            restless: restless(data, plain, &Quantity::ALL),
            still_restless: restless(data, &selection.extended, &Quantity::ALL),
            still_restless_along: restless(data, &selection.extended, &ALONG),
        }
    }

    /// What is missing beyond what always is.
    fn beyond_usual(&self, missing: &[f64; BODY_STATES]) -> f64 {
        let usual = TUNING.verdict.usually_missing_per_s.map(|usual| usual * self.seconds);
        missing.iter().zip(usual).map(|(missing, usual)| (missing - usual).max(0.0)).sum()
    }

    /// Is most of what an equation missed still missing?
    fn leaves_an_equation(&self, always: f64) -> bool {
        let mut each = self.left.iter().zip(self.missing);
        each.any(|(left, missing)| *left > always && *left > TUNING.verdict.most_left_of_one * missing)
    }

    /// Does a sensor err far more now and then of which the ordinary car says nothing? Then that car does not clear it.
    pub fn is_restless_along(&self) -> bool {
        self.still_restless_along > self.most_restless()
    }

    /// Does the equation along the car miss much of which the ordinary car, driven by a measured speed, says nothing?
    pub fn misses_along(&self) -> bool {
        self.left[0] > TUNING.verdict.cleared_along_per_s * self.seconds
    }

    fn most_restless(&self) -> f64 {
        let most = TUNING.verdict.most_restless * self.restless;
        most.clamp(TUNING.verdict.usually_restless, TUNING.verdict.never_restless)
    }

    /// The verdict; a drive that does not turn cannot clear the car.
    pub fn verdict(&self, turns: bool) -> Verdict {
        let left = self.beyond_usual(&self.left);
        let most = TUNING.verdict.most_left * self.beyond_usual(&self.missing);
        let always = TUNING.verdict.always_left_per_s * self.seconds;
        let is_much = left > most.clamp(always, TUNING.verdict.never_left_per_s * self.seconds);
        // The strongest may come after what every car has, if it and that leave no equation as it was.
        let of =
            if self.leaves_an_equation(always) { self.leading } else { self.leading.max(self.strongest) };
        let imitates = left > always && of < TUNING.verdict.least_leading;
        let is_restless = self.still_restless > self.most_restless();
        let least = TUNING.verdict.least_missing.max(TUNING.verdict.least_missing_per_s * self.seconds);
        match self.named {
            Some(_) if is_much || is_restless || imitates => Verdict::UnknownPhysics,
            Some(_) => Verdict::MissingPhysics,
            None if is_much || is_restless || self.unknown.max(self.refused) > least => {
                Verdict::UnknownPhysics
            }
            None if turns => Verdict::Adequate,
            None => Verdict::InsufficientExcitation,
        }
    }
}

/// Do the equations of a model miss more than they usually do?
pub fn misses_much(data: &Data<'_>, fit: &Fit<'_>) -> bool {
    let seconds = data.counted(&fit.sums).map(|sums| sums.t.1 - sums.t.0).sum();
    let gains = Gains { seconds, ..Gains::default() };
    gains.beyond_usual(&data.missing(fit)) > TUNING.verdict.always_left_per_s * seconds
}

/// The gain, if the most restless sensor's noise were not the same everywhere: by blocks in which it errs more
/// than in the median one.
fn restless(data: &Data<'_>, fit: &Fit<'_>, sensors: &[Quantity]) -> f64 {
    let of = |channel: Quantity| {
        let place = channel as usize;
        let blocks = data.counted(&fit.sums).filter(|sums| sums.of[place] > 20);
        let shares: Vec<(f64, f64)> =
            blocks.map(|sums| (sums.square[place] / sums.of[place] as f64, sums.of[place] as f64)).collect();
        let mut sorted: Vec<f64> = shares.iter().map(|(share, _)| *share).collect();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied()?;
        let gain = |(share, count): &(f64, f64)| {
            let more = (share / median).max(1.0);
            count * (more - 1.0 - more.ln())
        };
        Some(shares.iter().map(gain).sum())
    };
    sensors.iter().copied().filter_map(of).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(named: Option<f64>, missing: f64, left: f64) -> Verdict {
        let of_yaw = |missing| [50.0, 0.0, missing];
        let gains = Gains {
            seconds: 60.0,
            leading: 1.0,
            missing: of_yaw(missing),
            left: of_yaw(left),
            ..Gains::default()
        };
        Gains { named, ..gains }.verdict(true)
    }

    #[test]
    fn nothing_to_gain_is_adequate_on_a_drive_that_turns() {
        assert_eq!(verdict(None, 10.0, 10.0), Verdict::Adequate);
        let straight = Gains { seconds: 60.0, unknown: 10.0, ..Gains::default() };
        assert_eq!(straight.verdict(false), Verdict::InsufficientExcitation);
    }

    #[test]
    fn what_a_name_explains_is_missing_and_what_it_leaves_is_unknown() {
        assert_eq!(verdict(Some(900.0), 9000.0, 200.0), Verdict::MissingPhysics);
        assert_eq!(verdict(Some(900.0), 9000.0, 5000.0), Verdict::UnknownPhysics);
        assert_eq!(verdict(None, 9000.0, 9000.0), Verdict::UnknownPhysics);
    }

    #[test]
    fn a_sensor_that_errs_far_more_now_and_then_is_something_unknown() {
        let gains = Gains { seconds: 60.0, restless: 5000.0, still_restless: 5000.0, ..Gains::default() };
        assert_eq!(gains.verdict(true), Verdict::UnknownPhysics);
        let named = Gains { named: Some(9000.0), leading: 1.0, still_restless: 100.0, ..gains };
        assert_eq!(named.verdict(true), Verdict::MissingPhysics);
        // Half as much as before, and yet far from what any name leaves.
        let imitated = Gains { restless: 120_000.0, still_restless: 50_000.0, ..named };
        assert_eq!(imitated.verdict(true), Verdict::UnknownPhysics);
    }

    /// GIVEN what errs now and then WHEN it is a gyro, and when it is a wheel THEN the ordinary car has a say in the first only.
    #[test]
    fn the_ordinary_car_does_not_clear_a_wheel_that_errs_now_and_then() {
        let gyro = Gains { seconds: 60.0, restless: 5000.0, still_restless: 5000.0, ..Gains::default() };
        assert!(gyro.verdict(true) == Verdict::UnknownPhysics && !gyro.is_restless_along());
        assert!(Gains { still_restless_along: 5000.0, ..gyro }.is_restless_along());
        // As much as any sensor has.
        assert!(!Gains { still_restless_along: 500.0, ..gyro }.is_restless_along());
    }

    /// GIVEN much that is missing along the car, and as much that is missing across THEN the ordinary car has no say in the first.
    #[test]
    fn the_ordinary_car_does_not_clear_what_is_missing_along() {
        let across = Gains { seconds: 60.0, left: [300.0, 90_000.0, 90_000.0], ..Gains::default() };
        assert!(!across.misses_along());
        assert!(Gains { left: [15_000.0, 0.0, 0.0], ..across }.misses_along());
    }

    #[test]
    fn several_that_only_together_explain_it_are_no_name_for_it() {
        let (missing, left) = ([0.0, 90_000.0, 0.0], [0.0, 5000.0, 0.0]);
        let gains = Gains { seconds: 60.0, named: Some(9000.0), missing, left, ..Gains::default() };
        assert_eq!(Gains { leading: 0.8, ..gains }.verdict(true), Verdict::MissingPhysics);
        assert_eq!(Gains { leading: 0.34, ..gains }.verdict(true), Verdict::UnknownPhysics);
        // After what every car has one explains most, of each equation.
        let late = Gains { leading: 0.34, strongest: 0.6, ..gains };
        assert_eq!(late.verdict(true), Verdict::MissingPhysics);
        let one_as_it_was = Gains { missing: [0.0, 90_000.0, 6000.0], left: [0.0, 100.0, 5000.0], ..late };
        assert_eq!(one_as_it_was.verdict(true), Verdict::UnknownPhysics);
        let complete = Gains { leading: 0.34, left: [0.0; 3], ..gains };
        assert_eq!(complete.verdict(true), Verdict::MissingPhysics, "several small causes");
    }

    #[test]
    fn without_a_name_unknown_forces_and_refused_courses_count() {
        let gains = Gains { seconds: 60.0, refused: 500.0, ..Gains::default() };
        assert_eq!(gains.verdict(true), Verdict::UnknownPhysics);
        let gains = Gains { seconds: 60.0, unknown: 70.0, ..Gains::default() };
        assert_eq!(gains.verdict(true), Verdict::UnknownPhysics);
        // Ten minutes add up to as much without anything missing.
        assert_eq!(Gains { seconds: 600.0, ..gains }.verdict(true), Verdict::Adequate);
        assert_eq!(Gains { seconds: 600.0, unknown: 500.0, ..gains }.verdict(true), Verdict::UnknownPhysics);
    }
}
