//! What somebody's simulation of a drive leaves out of its recording.

use super::case::{Answer, Case};
use super::finding::told_apart;
use super::model::Model;
use super::ordinary::{Incomparable, Ordinary, Remaining};
use super::result::{Explanation, Verdict};
use super::work;
use predict::{Recording, Torque};

impl<'a> Case<'a> {
    /// Explains what the first recording has that a simulation of the same drive has not.
    ///
    /// # Errors
    /// Why the two cannot be compared.
    pub fn left_out(
        &self,
        simulation: &Recording,
        progress: &(dyn Fn(&str, f64) + Sync),
    ) -> Result<Answer<'a>, Incomparable> {
        progress(work::SIMULATION, 0.0);
        let both = (&self.recordings[0], simulation);
        let searches = |_: &Ordinary| {
            progress(work::LEFT_OUT, 0.0);
            true
        };
        let asked = self.asked(&searches);
        let (ordinary, simulated) = Ordinary::beside(self.vehicle, self.effects, both, asked)?;
        let verdict = match () {
            () if !ordinary.is_the_car_with_what_was_found() => Verdict::UnknownPhysics,
            () if !ordinary.beyond.findings.is_empty() => Verdict::MissingPhysics,
            () if ordinary.remaining.values().any(Remaining::repeats) => Verdict::UnknownPhysics,
            () => Verdict::Adequate,
        };
        let mut explanation = Explanation::empty(verdict);
        explanation.take_chain(self.chain);
        explanation.seconds = ordinary.seconds;
        explanation.simulation = Some(simulated);
        explanation.take_ordinary(&ordinary, Some(verdict));
        explanation.to_drive = told_apart(&explanation.findings);
        Ok(Answer {
            explanation,
            model: Model::plain(self.vehicle, Torque::Unknown).with_configured(self.effects),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{case, recorded_as};
    use super::*;
    use physics::Quantity;
    use physics::model::Scenario;
    use physics::model::effect::named;

    /// What a simulation of the bench's drive, as another simulator would write it (no noise, no wheels), leaves out of a
    /// recording with these effects.
    fn left_out(effects: &str, change: impl FnOnce(&mut Scenario)) -> Explanation {
        let silent = |scenario: &mut Scenario| {
            scenario.sensors.by_name.values_mut().for_each(|sensor| sensor.noise_std = 0.0);
        };
        let (_, mut simulation) = recorded_as("", silent);
        for quantity in Quantity::ALL {
            if !matches!(quantity, Quantity::YawRate | Quantity::LateralAcceleration) {
                simulation.tracks[quantity as usize].clear();
            }
        }
        let (vehicle, recording) = recorded_as(effects, change);
        let recordings = [recording];
        let library = ["relaxation_length", "steering_lag", "sensor_delay", "sensor_scale", "payload"];
        let library = library.map(|kind| named(kind).unwrap());
        let case = Case { library: &library, ..case(&vehicle, &recordings) };
        case.left_out(&simulation, &|_, _| {}).unwrap().explanation
    }

    /// GIVEN a car whose tires relax THEN that is what the simulation leaves out.
    #[test]
    #[ignore = "long: a car fitted to a simulation"]
    fn a_relaxing_tire_is_left_out() {
        let answer = left_out("[[effect]]\nkind = \"relaxation_length\"\nlength_m = 0.6\n", |_| {});
        assert_eq!(answer.verdict, Verdict::MissingPhysics);
        let first = &answer.findings[0];
        assert_eq!(first.effect, "relaxation_length", "{:?}", answer.findings);
        let length = first.parameters["length_m"];
        assert!((length.value - 0.6).abs() < 0.15, "{length:?}");
        let before = answer.fit.baseline.holdout["yaw_rate"];
        assert!(answer.fit.extended.holdout["yaw_rate"] > before, "{:?}", answer.fit);
    }

    mod by_hand {
        use super::*;

        /// GIVEN a simulation of the car as it is THEN it leaves out nothing.
        #[test]
        #[ignore = "by hand, as `commands` has it: a car fitted to a simulation"]
        fn of_the_same_car_nothing_is_left_out() {
            let answer = left_out("", |scenario| scenario.seed = 12);
            assert_eq!(answer.verdict, Verdict::Adequate, "{:?}", answer.findings);
        }
    }
}
