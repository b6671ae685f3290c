//! What was found, on another drive of the same car: does it help there, too, with the numbers that it has?

use serde::Serialize;

use super::case::Case;
use super::found::effects;
use super::ordinary::{Asked, Ordinary};
use super::result::{ByChannel, Finding, Nature};
use physics::model::Uncertain;
use physics::model::effect::{EffectConfig, EffectError};
use predict::Recording;

/// Another drive of the car, and what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Confirmed {
    /// The drive.
    pub log: String,
    /// How well the ordinary car predicts its held-out part, %, by channel.
    pub fit: Fits,
    /// By which share squared errors of the held-out part fall with what was found, its numbers unchanged: mean of the
    /// channels.
    pub gain_unchanged: f64,
    /// The same with its numbers refitted to this drive.
    pub gain_refitted: f64,
}

/// With and without.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fits {
    /// Without what was found.
    pub without: ByChannel,
    /// With it as it was found.
    pub unchanged: ByChannel,
    /// With its numbers refitted.
    pub refitted: ByChannel,
}

impl Case<'_> {
    /// Looks for what was found in another drive of the same car; none where it tells nothing of the car, or where
    /// nothing was found that another drive could have as well.
    ///
    /// # Errors
    /// Numbers that no table takes.
    pub fn confirm(
        &self,
        findings: &[Finding],
        recording: &Recording,
    ) -> Result<Option<Confirmed>, EffectError> {
        let known = carried(findings)?;
        if known.is_empty() {
            return Ok(None);
        }
        let open: Vec<EffectConfig> = known.iter().map(refitted).collect::<Result<_, _>>()?;
        let fit = |more: &[EffectConfig]| {
            let effects: Vec<EffectConfig> = self.effects.iter().chain(more).cloned().collect();
            let asked = Asked { seed: self.seed, ..Asked::CAR };
            let car = Ordinary::of(self.vehicle, &effects, std::slice::from_ref(recording), asked)?;
            Some(car.fit.holdout)
        };
        let (without, (unchanged, refitted)) =
            rayon::join(|| fit(&[]), || rayon::join(|| fit(&known), || fit(&open)));
        let fits = without.zip(unchanged).zip(refitted);
        Ok(fits.map(|((without, unchanged), refitted)| Confirmed {
            log: recording.name.clone(),
            gain_unchanged: gain(&without, &unchanged),
            gain_refitted: gain(&without, &refitted),
            fit: Fits { without, unchanged, refitted },
        }))
    }
}

/// What another drive could have as well, its numbers known: no number of the measurement, nothing that began at a moment or
/// was there for a while, and nothing that is the ordinary car's anyway.
pub fn carried(findings: &[Finding]) -> Result<Vec<EffectConfig>, EffectError> {
    let is_of_car = |finding: &&Finding| {
        matches!(finding.kind, Nature::Unusual | Nature::Law)
            && finding.place.intervals.is_empty()
            && finding.series.is_none()
    };
    let known = |config: EffectConfig| {
        let numbers = config.numbers().iter().map(|number| Uncertain::known(number.value)).collect();
        EffectConfig::new(config.kind(), config.channel(), numbers, config.course().clone())
    };
    effects(findings.iter().filter(is_of_car))?.into_iter().map(known).collect()
}

/// The same with what is known of such numbers before any drive.
fn refitted(known: &EffectConfig) -> Result<EffectConfig, EffectError> {
    let open = known.specs().zip(known.numbers()).map(|(spec, number)| {
        let slope = spec.scale.slope(spec.coordinate(number.value)).abs();
        Uncertain { value: number.value, std: if spec.is_main { spec.std * slope } else { 0.0 } }
    });
    EffectConfig::new(known.kind(), known.channel(), open.collect(), known.course().clone())
}

/// By which share squared errors fall, by the fits: mean of the channels.
fn gain(without: &ByChannel, with: &ByChannel) -> f64 {
    let falls = without.iter().filter_map(|(name, without)| {
        let left = (100.0 - with.get(name)?) / (100.0 - without);
        Some(1.0 - left * left)
    });
    let (count, sum) = falls.fold((0.0, 0.0), |(count, sum), fall| (count + 1.0, sum + fall));
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{case, recorded_as};
    use super::*;
    use crate::explain::result::{Estimate, Where};
    use physics::model::effect::{Channel, law};

    const PULL: &str = "[[effect]]\nkind = \"law\"\nplace = \"front slip angle\"\n\
                        expression = \"coefficient * a_x\"\ncoefficient = 0.0008\n";

    /// A finding of that.
    fn pull() -> Finding {
        let law = law::Law::named("front slip angle", "a_x").unwrap();
        let coefficient = Estimate { value: 0.0008, std: 1e-5 };
        Finding {
            parameters: [("coefficient".to_owned(), coefficient)].into(),
            place: Where::default(),
            ..Finding::of(&law::KIND, Some(Channel::Law(law)))
        }
    }

    /// GIVEN what was found on one drive WHEN another drive has it THEN it helps there as much as a refit; where it is not,
    /// it does harm, and a refit takes it back.
    #[test]
    #[ignore = "long: three cars fitted"]
    fn what_is_there_helps_and_what_is_not_does_not() {
        let confirmed = |effects: &str| {
            let (vehicle, recording) = recorded_as(effects, |scenario| scenario.seed = 5);
            let case = Case { library: &[], ..case(&vehicle, &[]) };
            case.confirm(&[pull()], &recording).unwrap().unwrap()
        };
        let there = confirmed(PULL);
        assert!(there.gain_unchanged > 0.1 && there.gain_refitted > 0.1, "{there:?}");
        assert!(there.gain_unchanged > 0.8 * there.gain_refitted, "{there:?}");
        let absent = confirmed("");
        assert!(absent.gain_unchanged < -0.05 && absent.gain_refitted > -0.05, "{absent:?}");
    }

    #[test]
    fn what_is_of_one_drive_is_not_carried() {
        let onset = Where { intervals: vec![[10.0, 40.0]], ..Where::default() };
        let ordinary = Finding { kind: Nature::Ordinary, ..pull() };
        assert!(carried(&[Finding { place: onset, ..pull() }, ordinary]).unwrap().is_empty());
        assert_eq!(carried(&[pull()]).unwrap()[0].numbers(), [Uncertain::known(0.0008)]);
    }
}
