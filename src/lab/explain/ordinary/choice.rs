//! Which of the physics that every car has is taken: what the data do not refuse.

use super::fit::{FreeFit, count_more, fit, fit_from};
use super::inputs::FreeDrive;
use super::numbers::{free, with_downforce, with_load_sensitivity, with_ordinary};
use super::problem::{Problem, Scale};
use crate::explain::model::Model;
use crate::explain::select::LEAST_EVIDENCE;
use physics::model::Vehicle;

/// Statistical: odds of 20 to 1, in 2 ln.
pub const REFUSED: f64 = 6.0;

/// With less friction in use an axle loses less than 3 % of its stiffness to the load that moves between its wheels, at a usual height
/// and sensitivity (`ORDINARY`): nothing tells one from the other.
const HARD: f64 = 0.6;

/// Below this nobody's downforce shows, m/s: the 3 m² of a race car press it with a fifth of its weight there, a passenger car's
/// 0.3 m² with a hundredth.
const FAST_MPS: f64 = 30.0;

/// Fits the model with the physics that every car has, and without what of that the data refuse.
///
/// Every error counts in full for the refusal: a run that spins where the car did not is no outlier. The search begins where that
/// of `other` tires has ended, if there was one.
pub fn fit_ordinary<'a>(
    model: &Model<'a>,
    vehicle: &Vehicle,
    drives: &[FreeDrive],
    other: Option<&FreeFit<'_>>,
) -> FreeFit<'a> {
    let [usual, simpler] = with_ordinary(model);
    let free = |model: &Model<'a>| free(model, vehicle, drives);
    let usual = match other {
        Some(other) => fit_from(&usual, free(&usual), drives, other),
        None => fit(&usual, free(&usual), drives),
    };
    let simpler = fit_from(&simpler, free(&simpler), drives, &usual);
    if is_refused(&usual, &simpler, REFUSED, drives) { simpler } else { usual }
}

/// The same with what shows in few, where something repeats beside the usual car, and the data refuse that as clearly as anything is
/// named: the load sensitivity of this car's own tires, where it is driven hard; and downforce of a race car's size, where it is
/// fast enough to show it. Says also whether something repeats beside the fit.
pub fn fit_car<'a>(
    model: &Model<'a>,
    vehicle: &Vehicle,
    drives: &[FreeDrive],
    other: Option<&FreeFit<'_>>,
    leaves: impl Fn(&FreeFit<'_>) -> bool,
) -> (FreeFit<'a>, bool) {
    let asked = |model: Model<'a>, found: &FreeFit<'_>| {
        count_more(drives, 1);
        fit_from(&model, free(&model, vehicle, drives), drives, found)
    };
    let is_better =
        |found: &FreeFit<'_>, other: &FreeFit<'_>| is_refused(found, other, LEAST_EVIDENCE, drives);
    let mut found = fit_ordinary(model, vehicle, drives, other);
    let mut repeats = leaves(&found);
    if repeats && drives.iter().filter_map(FreeDrive::used_friction).any(|used| used > HARD) {
        let loaded = asked(with_load_sensitivity(model), &found);
        if is_better(&found, &loaded) {
            repeats = leaves(&loaded);
            found = loaded;
        }
    }
    if repeats && drives.iter().filter_map(FreeDrive::fastest).any(|fastest| fastest >= FAST_MPS) {
        let pressed = asked(with_downforce(model), &found);
        if is_race_cars(&pressed) && is_better(&found, &pressed) {
            repeats = leaves(&pressed);
            found = pressed;
        }
    }
    (found, repeats)
}

/// Less than this presses passenger cars down, or lifts them: there it is what the tires' curve lacks, m². Tuned by
/// `a_car_that_is_not_has_none`.
const LEAST_PRESSED_M2: f64 = 1.0;

/// Is the downforce of a size that shows?
fn is_race_cars(pressed: &FreeFit<'_>) -> bool {
    let mut named = pressed.free.iter().zip(&pressed.at).map(|(free, at)| free.named(&pressed.model, *at));
    named.any(|(name, value, _)| name == "downforce.downforce_area_m2" && value > LEAST_PRESSED_M2)
}

/// Do the data refuse the first of two fits for the other one, by so much?
pub fn is_refused(usual: &FreeFit<'_>, other: &FreeFit<'_>, least: f64, drives: &[FreeDrive]) -> bool {
    let memory = other.time_constants_s.map(Scale::memory_of);
    let [of_usual, of_other] = [usual, other].map(|fit| {
        let problem = Problem { model: &fit.model, free: &fit.free, drives };
        problem.prior_cost(&fit.at) + problem.misfit(fit, memory)
    });
    tracing::debug!(of_usual, of_other, "the ordinary car, and another one if the data refuse it");
    of_usual > of_other + least
}

impl Problem<'_, '_> {
    /// −2 ln likelihood of the residuals for noise of the size that they have.
    fn misfit(&self, fit: &FreeFit<'_>, memory: [f64; 2]) -> f64 {
        let (mut squares, mut count) = ([0.0; 2], [0.0; 2]);
        let all = self.drives.iter().zip(&fit.predicted);
        for row in all.flat_map(|(drive, predicted)| self.residuals(drive, predicted)) {
            for (channel, error) in row.into_iter().enumerate().filter(|(_, error)| error.is_finite()) {
                squares[channel] += error * error;
                count[channel] += 1.0;
            }
        }
        let of = |channel: usize| match count[channel] {
            0.0 => 0.0,
            count => count / memory[channel] * (squares[channel] / count).max(1e-12).ln(),
        };
        of(0) + of(1)
    }
}

#[cfg(test)]
mod tests {
    use physics::model::TireKind;

    use super::super::super::bench::recorded_as;
    use super::super::answer::{Asked, Ordinary};

    /// From 25 to 60 m/s and back.
    const FAST: &str =
        "[driver]\nspeed_mps = [{ kind = \"points\", points = [[0, 25], [70, 60], [90, 45]] }]\n";

    /// The ordinary car of a fast drive of a car that is pressed by so many square metres.
    fn fast(area_m2: f64) -> Ordinary {
        let downforce = format!("[[effect]]\nkind = \"downforce\"\ndownforce_area_m2 = {area_m2}\n");
        let (mut vehicle, recording) = recorded_as(&format!("{FAST}{downforce}"), |scenario| {
            (scenario.duration_s, scenario.initial_speed_mps) = (90.0, 25.0);
            scenario.drive_torque.clear();
            scenario.brake_pressure.clear();
            // What a car bears at 60 m/s.
            scenario.steering_wheel_angle.truncate(1);
            scenario.vehicle.steering_ratio = physics::model::Uncertain::known(80.0);
        });
        vehicle.tire = TireKind::Linear;
        Ordinary::of(&vehicle, &[], &[recording], Asked::CAR).unwrap()
    }

    /// GIVEN a race car from 25 to 60 m/s, and a table of linear tires WHEN the ordinary car is fitted THEN it has the downforce, and its
    /// stiffness is that of the car that stands still.
    #[test]
    fn a_car_that_is_pressed_at_high_speed_has_downforce() {
        let found = fast(4.0);
        let number = |name: &str| found.numbers.iter().find(|number| number.name == name).unwrap().estimate;
        let area = number("downforce.downforce_area_m2");
        assert!((area.value - 4.0).abs() < 3.0 * area.std && area.value > 4.0 * area.std, "{area:?}");
        for (axle, truth) in [("front", 11.0), ("rear", 14.0)] {
            let stiffness = number(&format!("lateral_stiffness_{axle}"));
            assert!((stiffness.value / truth - 1.0).abs() < 0.1, "{axle}: {stiffness:?}");
        }
    }

    #[test]
    fn a_car_that_is_not_has_none() {
        assert!(fast(0.0).numbers.iter().all(|number| !number.name.starts_with("downforce")));
    }
}
