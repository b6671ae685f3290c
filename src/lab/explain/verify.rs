//! Does what `--sensitivity` predicts come true? Which sizes are to be put into the drive, and what became of them.

use std::collections::BTreeMap;

use physics::model::Uncertain;
use physics::model::effect::{Course, EffectConfig, Scale, Spec, named};
use serde::{Deserialize, Serialize};

use super::ordinary::conceal::drawn;
use super::result::{Finding, full_name};
use super::sensitivity::{Detectable, Sensitivity};
use crate::chance::wilson;

/// By which courses are drawn; not that of the prediction.
const SEED: u64 = 2;

/// What was predicted beside what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verified {
    /// Everything that was put in.
    pub runs: Vec<Outcome>,
    /// The same by what was predicted.
    pub bins: Vec<Bin>,
    /// What could not be put in, and why.
    pub left_out: Vec<LeftOut>,
}

/// An effect of some size, put into the drives.
#[derive(Clone, Debug, PartialEq)]
pub struct Try {
    /// What is put in.
    pub config: EffectConfig,
    /// What becomes of it; found nothing yet.
    pub outcome: Outcome,
}

/// What became of an effect of some size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its name in the library.
    pub effect: String,
    /// The quantity it is of.
    pub channel: Option<String>,
    /// The key of its number …
    pub parameter: String,
    /// … by how much that was changed from where it makes no difference …
    pub change: f64,
    /// … and the unit.
    pub unit: String,
    /// How probably it should be called by its name.
    pub predicted: f64,
    /// Was it?
    pub named: bool,
    /// Was anything found that is not in the unchanged drives, under whatever name?
    pub noticed: bool,
    /// What that was.
    pub found: Vec<String>,
    /// Why it could not be put in, if so; then it does not count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

/// Those with about the same prediction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// From which chance to which.
    pub predicted: [f64; 2],
    /// Their mean; none without any.
    pub mean: Option<f64>,
    /// So many …
    pub count: usize,
    /// … of which so many were called by their names.
    pub named: usize,
    /// The chance of that, 95 % (Wilson 1927).
    pub ci95: [f64; 2],
}

/// What could not be put in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// The effect, or the number of the car, with its channel.
    pub effect: String,
    /// Why.
    pub why: String,
}

/// A finding, as far as two answers are compared by it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// The effect.
    pub effect: String,
    /// The quantity it is of.
    pub channel: Option<String>,
    /// Values and deviations of its numbers.
    pub numbers: BTreeMap<String, [f64; 2]>,
}

/// Sizes that are put in: the one that is called by its name with 90 %, the half and the double of it, and those with these
/// chances.
const SHARES: [f64; 3] = [0.5, 1.0, 2.0];
const CHANCES: [f64; 3] = [0.3, 0.5, 0.7];

/// Bins of the predicted chance.
const BINS: usize = 5;

/// A number of another size is another finding: so many deviations of both. Statistical: 95 %.
const OTHER: f64 = 2.0;

impl Sensitivity {
    /// What is to be put in to see whether the predictions come true, into drives of so many seconds, of the effects that are
    /// wanted (`kind` or `kind:channel`; all without any); and what cannot be.
    pub fn to_verify(&self, wanted: &[String], seconds: f64) -> (Vec<Try>, Vec<LeftOut>) {
        let (mut all, mut left_out) = (Vec::new(), Vec::new());
        for of in &self.effects {
            if !wanted.is_empty() && !wanted.iter().any(|name| *name == of.effect || *name == of.full_name())
            {
                continue;
            }
            match tries(of, seconds) {
                Ok(tries) => all.extend(tries),
                Err(why) => left_out.push(LeftOut { effect: of.full_name(), why }),
            }
        }
        (all, left_out)
    }
}

impl Detectable {
    /// With its channel.
    pub fn full_name(&self) -> String {
        full_name(&self.effect, self.channel.as_deref())
    }
}

fn tries(of: &Detectable, seconds: f64) -> Result<Vec<Try>, String> {
    let power = &of.power;
    if of.named_90.is_none() {
        return Err("no size of it is called by its name".into());
    }
    if power.name.contains('.') || named(&of.effect).is_none() {
        return Err("it is a number of the car; only effects of the library can be put in".into());
    }
    let mut sizes: Vec<f64> = SHARES.iter().map(|share| share * power.named).collect();
    sizes.extend(CHANCES.iter().filter_map(|chance| power.size_of(*chance)));
    sizes.sort_by(f64::total_cmp);
    let mut all = Vec::new();
    let mut why = String::new();
    for (number, size) in sizes.into_iter().enumerate() {
        for change in [size, -size] {
            match config(of, change, seconds, number as u64) {
                Ok(config) => all.push(Try {
                    config,
                    outcome: Outcome {
                        effect: of.effect.clone(),
                        channel: of.channel.clone(),
                        parameter: of.parameter.clone(),
                        change,
                        unit: of.unit.clone(),
                        predicted: power.chance(size),
                        named: false,
                        noticed: false,
                        found: Vec::new(),
                        refused: None,
                    },
                }),
                Err(reason) => why = reason,
            }
        }
    }
    if all.is_empty() { Err(why) } else { Ok(all) }
}

/// The effect with its main number changed by so much; a course is drawn by this number.
fn config(of: &Detectable, change: f64, seconds: f64, number: u64) -> Result<EffectConfig, String> {
    let kind = named(&of.effect).ok_or("there is no such effect")?;
    let channel = match &of.channel {
        Some(channel) => Some(channel.parse().map_err(|_| "its channel is none of the configuration's")?),
        None => None,
    };
    let mut numbers = Vec::new();
    for (place, _) in kind.parameters.iter().enumerate() {
        let spec = kind.spec(place, channel).ok_or("it is not of this channel")?;
        let value = match spec.name {
            name if name == of.parameter => {
                let value = of.power.neutral + change;
                let (low, high) = spec.range();
                if !(low..=high).contains(&value) {
                    return Err(format!("{} of {value:.3e} {} is more than it can be", spec.name, spec.unit));
                }
                // On a scale that is bent a step the other way is no step of the same size.
                if spec.scale != Scale::Linear && change > 0.0 && spec.mean != 0.0 {
                    return Err("it only falls".into());
                }
                value
            }
            name if name == Spec::AT_S.name => of.power.from_s.unwrap_or_else(|| spec.value(spec.mean)),
            _ => spec.value(spec.mean),
        };
        numbers.push(Uncertain::known(value));
    }
    let course = match kind.course {
        None => Course::None,
        Some(course) if course.rms_name == of.parameter => {
            if change < 0.0 {
                return Err("it goes both ways by itself".into());
            }
            Course::Series(drawn(change, course.length_s, seconds, SEED, number))
        }
        Some(_) => {
            let from = of.power.from_s.unwrap_or(0.0);
            Course::Stretches { intervals: vec![[from, seconds.max(from + 1.0)]], value: 1.0 }
        }
    };
    EffectConfig::new(kind, channel, numbers, course).map_err(|why| why.to_string())
}

impl Known {
    /// Of findings.
    pub fn all(findings: &[Finding]) -> Vec<Self> {
        let of = |finding: &Finding| Self {
            effect: finding.effect.clone(),
            channel: finding.channel.clone(),
            numbers: finding.parameters.iter().map(|(name, it)| (name.clone(), [it.value, it.std])).collect(),
        };
        findings.iter().map(of).collect()
    }

    /// Is it what this one is, of the same size?
    fn is(&self, other: &Self) -> bool {
        let is_same = |(name, [value, std]): (&String, &[f64; 2])| {
            other
                .numbers
                .get(name)
                .is_some_and(|[before, deviation]| (value - before).abs() <= OTHER * std.hypot(*deviation))
        };
        (&self.effect, &self.channel) == (&other.effect, &other.channel) && self.numbers.iter().all(is_same)
    }
}

impl Outcome {
    /// Is it this one, whatever became of it?
    pub fn is_of(&self, other: &Self) -> bool {
        (&self.effect, &self.channel, &self.parameter) == (&other.effect, &other.channel, &other.parameter)
            && (self.change - other.change).abs() <= 1e-9 * self.change.abs()
    }

    /// With what was found in the drives that have it, beside what is found in those without.
    #[must_use]
    pub fn with(mut self, found: &[Known], control: &[Known]) -> Self {
        let new: Vec<&Known> =
            found.iter().filter(|one| control.iter().all(|known| !one.is(known))).collect();
        self.noticed = !new.is_empty();
        self.named = new.iter().any(|one| one.effect == self.effect && one.channel == self.channel);
        let name = |one: &&Known| full_name(&one.effect, one.channel.as_deref());
        self.found = new.iter().map(name).collect();
        self
    }
}

impl Verified {
    /// Of what was done.
    pub fn of(runs: Vec<Outcome>, left_out: Vec<LeftOut>) -> Self {
        let bin = |place: usize| {
            let [low, high] = [place, place + 1].map(|edge| edge as f64 / BINS as f64);
            let is_within = |it: &&Outcome| {
                it.refused.is_none() && it.predicted >= low && (it.predicted < high || place + 1 == BINS)
            };
            let own: Vec<&Outcome> = runs.iter().filter(is_within).collect();
            let named = own.iter().filter(|it| it.named).count();
            let sum: f64 = own.iter().map(|it| it.predicted).sum();
            Bin {
                predicted: [low, high],
                mean: (!own.is_empty()).then(|| sum / own.len() as f64),
                count: own.len(),
                named,
                ci95: wilson(named, own.len()),
            }
        };
        Self { bins: (0..BINS).map(bin).collect(), runs, left_out }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{case, recorded};
    use super::*;

    fn outcome(predicted: f64, named: bool) -> Outcome {
        Outcome {
            effect: "sensor_scale".into(),
            channel: Some("yaw_rate".into()),
            parameter: "relative_error".into(),
            change: 0.02,
            unit: "1".into(),
            predicted,
            named,
            noticed: named,
            found: Vec::new(),
            refused: None,
        }
    }

    #[test]
    fn what_was_found_is_counted_where_it_was_predicted() {
        let mut refused = outcome(0.95, false);
        refused.refused = Some("it would spin".into());
        let runs =
            vec![outcome(0.1, false), outcome(0.9, true), outcome(1.0, true), outcome(0.8, false), refused];
        let verified = Verified::of(runs, Vec::new());
        let counts: Vec<(usize, usize)> = verified.bins.iter().map(|bin| (bin.count, bin.named)).collect();
        assert_eq!(counts, [(1, 0), (0, 0), (0, 0), (0, 0), (3, 2)]);
        // The textbook's: 8 of 10 is 49 to 94 %.
        let [low, high] = wilson(8, 10);
        assert!((low - 0.490).abs() < 1e-3 && (high - 0.943).abs() < 1e-3, "{low} {high}");
        assert_eq!(verified.bins[1].ci95, [0.0, 1.0]);
    }

    #[test]
    fn what_the_unchanged_drive_has_as_well_was_not_put_in() {
        let known = |value: f64| Known {
            effect: "sensor_scale".into(),
            channel: Some("yaw_rate".into()),
            numbers: [("relative_error".to_owned(), [value, 0.002])].into(),
        };
        let of = |found: f64, control: f64| outcome(0.9, false).with(&[known(found)], &[known(control)]);
        assert!(of(0.03, 0.01).named);
        let same = of(0.012, 0.01);
        assert!(!same.named && !same.noticed);
    }

    /// GIVEN what a drive would tell THEN sizes around the predicted ones are put in, of both signs where there are two, with
    /// the chances that belong to them.
    #[test]
    #[ignore = "long: a car fitted, and more"]
    fn sizes_are_put_in_around_the_predicted_ones() {
        let (vehicle, recording) = recorded("");
        let recordings = [recording];
        let sensitivity = case(&vehicle, &recordings).sensitivity().unwrap();
        let (all, _) = sensitivity.to_verify(&["sensor_scale:yaw_rate".into()], 45.0);
        assert_eq!(all.len(), 2 * (SHARES.len() + CHANCES.len()));
        let named = sensitivity.effects.iter().find(|it| it.full_name() == "sensor_scale:yaw_rate").unwrap();
        let at_90 =
            all.iter().find(|it| (it.outcome.change - named.named_90.unwrap()).abs() < 1e-12).unwrap();
        assert!((at_90.outcome.predicted - 0.9).abs() < 1e-3, "{at_90:?}");
        for chance in CHANCES {
            assert!(all.iter().any(|it| (it.outcome.predicted - chance).abs() < 1e-3), "{chance}");
        }
        let (jumps, _) = sensitivity.to_verify(&["sensor_bias:yaw_rate".into()], 45.0);
        let at = jumps[0].config.numbers().iter().find(|number| (15.0..30.0).contains(&number.value));
        assert!(at.is_some(), "it begins in the middle: {:?}", jumps[0].config);
        // What varies goes both ways by itself.
        let (drifts, _) = sensitivity.to_verify(&["sensor_drift:yaw_rate".into()], 45.0);
        assert_eq!(drifts.len(), SHARES.len() + CHANCES.len());
        for it in drifts {
            let Course::Series(series) = it.config.course() else { panic!("{:?}", it.config) };
            assert!((series.rms() / it.outcome.change - 1.0).abs() < 1e-6, "{:?}", it.outcome);
        }
        // Of one drive alone the ordinary car's own radii take all of it.
        let (tires, left_out) = sensitivity.to_verify(&["tire_radius".into()], 45.0);
        assert!(tires.is_empty() && left_out.len() == 4, "{} {left_out:?}", tires.len());
        let (all, left_out) = sensitivity.to_verify(&[], 45.0);
        assert!(all.len() > 100 && left_out.iter().all(|it| !it.why.is_empty()), "{left_out:?}");
    }
}
