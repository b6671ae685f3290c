//! Could this drive have told? What a drive would show of each effect, before anybody looks for it in vain.

use serde::Serialize;

use super::case::Case;
use super::chain::{AuditFinding, Standing, certain_radius};
use super::ordinary::{Bar, MOST_TIMES_ORDINARY, Power, Powers, could_tell, likely_courses};
use super::result::{Chance, ToDrive};
use super::verify::Verified;
use physics::Quantity;
use physics::model::effect::{Channel, named};

/// How large each effect must be to be seen: `--sensitivity`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivity {
    /// The clearest first, by what they usually are.
    pub effects: Vec<Detectable>,
    /// What became of effects of such sizes, where they were put in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verified: Option<Verified>,
}

/// One effect, by its main number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Detectable {
    /// Its name in the library, or the number of the car that could have changed.
    pub effect: String,
    /// The quantity it is of.
    pub channel: Option<String>,
    /// The main number …
    pub parameter: String,
    /// … and its unit.
    pub unit: String,
    /// The smallest change of it that is called by its name with 90 % probability; none where nothing is large enough.
    pub named_90: Option<f64>,
    /// The same with 50 %.
    pub named_50: Option<f64>,
    /// The same for being found at all, under whatever name.
    pub noticed_90: Option<f64>,
    /// What it usually is.
    pub ordinary: f64,
    /// Where it makes no difference: what changes are counted from.
    pub neutral: f64,
    /// What it is taken for most easily, and the correlation of their traces.
    pub taken_for: Option<Rival>,
    /// All that is known of it; what the JSON has of it stands above.
    #[serde(skip)]
    pub power: Power,
}

/// What something is taken for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rival {
    /// Its name, with its channel.
    pub name: String,
    /// From −1 to 1, after the ordinary numbers have taken what they can.
    pub correlation: f64,
}

/// Which effects can be seen, and which can be told apart: `--isolability` (Frisk & Krysander's question, asked of this
/// drive's likelihood).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Isolability {
    /// Names, with their channels.
    pub effects: Vec<String>,
    /// Is each found with 90 % probability, at its ordinary size?
    pub detectable: Vec<bool>,
    /// How probably one of a row, at its ordinary size, has more evidence than one of a column.
    pub separable: Vec<Vec<f64>>,
    /// What to drive next, so that more of them are.
    pub to_drive: Vec<ToDrive>,
}

/// How probably an effect of its ordinary size is called by its name, in the mean over all; none where there is none.
fn mean_chance(powers: &Powers) -> Option<f64> {
    let count = powers.all.len();
    let sum: f64 = powers.all.iter().map(|power| power.chance(power.ordinary)).sum();
    (count > 0).then(|| sum / count as f64)
}

fn by_their_names(chance: Chance) -> String {
    format!("{chance} of these effects would be called by their names at their ordinary size")
}

impl Case<'_> {
    /// How large each effect must be. None where the drive does not tell the car itself.
    pub fn sensitivity(&self) -> Option<Sensitivity> {
        let Powers { mut all, courses, .. } = self.powers()?;
        all.extend(courses);
        let share = |power: &Power| power.noticed / power.ordinary;
        all.sort_by(|a, b| share(a).total_cmp(&share(b)));
        Some(Sensitivity { effects: all.into_iter().map(detectable).collect(), verified: None })
    }

    /// What can be seen and told apart at ordinary sizes. None as above.
    pub fn isolability(&self) -> Option<Isolability> {
        let (Powers { all, separable, .. }, to_drive) =
            self.proposals(self.library, &|powers| mean_chance(powers), &by_their_names)?;
        Some(Isolability {
            effects: all.iter().map(full_name).collect(),
            detectable: all.iter().map(|power| power.noticed <= power.ordinary).collect(),
            separable,
            to_drive,
        })
    }

    fn powers(&self) -> Option<Powers> {
        let told = could_tell(self.vehicle, self.effects, self.recordings, &[], self.asked(&|_| true));
        let mut now = told.map(|(now, _)| now)?;
        // Radii of an axle's wheels are told by the audit: in the ordinary car they are free.
        let best = |axle: usize| self.chain.iter().filter_map(|of| Some(of.radii?[axle])).reduce(f64::min);
        for power in now.all.iter_mut().filter(|_| self.references == 0) {
            let wheel = power.number.strip_prefix(RADIUS_OF).and_then(|wheel| wheel.chars().next());
            let std = wheel.and_then(|wheel| best(usize::from(wheel == 'r')));
            if let Some(std) = std.filter(|_| power.name == "tire_radius") {
                let bar = Bar { slope: power.ordinary / std, needed: certain_radius(std) / std };
                power.or_by(vec![vec![bar]]);
            }
        }
        // So is a zero of the yaw rate that moves while the car stands.
        let gyroscope = format!("{}:{}", AuditFinding::DRIFT, Quantity::YawRate);
        let drift = now.courses.iter_mut().find(|power| power.name == gyroscope);
        let standing = self.chain.get(self.references).and_then(|of| of.standing.as_ref());
        if let Some((drift, standing)) = drift.zip(standing) {
            drift.or_by(drifts_told(standing));
        }
        Some(now)
    }
}

/// What drifts of the gyroscope's ordinary size need to be told by what it reads while the car stands.
fn drifts_told(standing: &Standing) -> Vec<Vec<Bar>> {
    let gyroscope = Some(Channel::One(Quantity::YawRate));
    let course = named(AuditFinding::DRIFT).and_then(|kind| kind.disturbance(gyroscope));
    let drifts = course.into_iter().flat_map(|course| likely_courses(course, standing.recorded_s()));
    let way = |bars: [[f64; 2]; 2]| bars.map(|[slope, needed]| Bar { slope, needed }).into();
    drifts.filter_map(|drift| standing.bars(|t| drift.at(t)).map(way)).collect()
}

/// What numbers of wheels' radii begin with.
const RADIUS_OF: &str = "relative_difference_";

/// Of the four wheels each has its own.
fn full_name(power: &Power) -> String {
    match power.number.rsplit_once(RADIUS_OF) {
        Some((_, wheel)) => format!("{}:{wheel}", power.name),
        None => power.name.clone(),
    }
}

fn detectable(power: Power) -> Detectable {
    let below = |size: f64| (size < MOST_TIMES_ORDINARY * power.ordinary).then_some(size);
    let (effect, channel) = match power.name.split_once(':') {
        Some((effect, channel)) => (effect.to_owned(), Some(channel.to_owned())),
        None => (power.name.clone(), None),
    };
    // Of a number of an effect that every car has, the effect.
    let effect = effect.split('.').next().unwrap_or_default().to_owned();
    Detectable {
        effect,
        channel,
        parameter: power.number.clone(),
        unit: power.unit.clone(),
        named_90: below(power.named),
        named_50: power.size_of(0.5).and_then(below),
        noticed_90: below(power.noticed),
        ordinary: power.ordinary,
        neutral: power.neutral,
        taken_for: power.rival.clone().map(|(name, correlation)| Rival { name, correlation }),
        power,
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{case, recorded};
    use super::super::chain::ChainReport;
    use super::*;

    fn of(effects: &str) -> (Sensitivity, Isolability) {
        let (vehicle, recording) = recorded(effects);
        let recordings = [recording];
        let library =
            ["sensor_bias", "sensor_delay", "steering_ratio", "roll_steer"].map(|kind| named(kind).unwrap());
        let case = Case { library: &library, ..case(&vehicle, &recordings) };
        (case.sensitivity().unwrap(), case.isolability().unwrap())
    }

    /// GIVEN a drive whose audit tells the rear wheels' radii to 0.1 %, and the front ones' to 1 % THEN a rear tire that is
    /// 0.7 % small is called by its name, and a front tire not before 7 %.
    #[test]
    fn radii_are_told_as_well_as_the_audit_tells_them() {
        let (vehicle, recording) = recorded("");
        let recordings = [recording];
        let library = [named("tire_radius").unwrap()];
        let chain = [ChainReport { radii: Some([0.01, 0.001]), ..ChainReport::default() }];
        let case = Case { library: &library, chain: &chain, ..case(&vehicle, &recordings) };
        let sensitivity = case.sensitivity().unwrap();
        let of = |wheel: &str| {
            let is_it = |it: &&Detectable| it.parameter == format!("{RADIUS_OF}{wheel}");
            sensitivity.effects.iter().find(is_it).and_then(|it| it.named_90).unwrap_or(f64::INFINITY)
        };
        assert!((of("rl") - 0.00694).abs() < 1e-4, "{}", of("rl"));
        assert!(of("fr") > 0.06, "{}", of("fr"));
    }

    /// GIVEN a drive with little noise THEN an ordinary jump of the gyroscope would be seen, by a share of its size; and what
    /// is called hard to tell from another is so from both sides.
    #[test]
    fn a_quiet_drive_tells_small_things() {
        let (sensitivity, isolability) = of("");
        let jump = |it: &&Detectable| it.effect == "sensor_bias" && it.channel.as_deref() == Some("yaw_rate");
        let gyroscope = sensitivity.effects.iter().find(jump).unwrap();
        let (noticed, named) = (gyroscope.noticed_90.unwrap(), gyroscope.named_90.unwrap());
        assert!(noticed < 0.01 && noticed <= named, "{gyroscope:?}");
        let count = isolability.effects.len();
        assert_eq!((isolability.detectable.len(), isolability.separable.len()), (count, count));
        for (i, row) in isolability.separable.iter().enumerate() {
            assert_eq!(row.len(), count);
            assert!((row[i] - 0.5).abs() < 1e-6, "nothing is told from itself");
            assert!(row.iter().all(|chance| (0.5..=1.0).contains(chance)), "{row:?}");
        }
        let proposed = isolability.to_drive.iter().filter_map(|it| it.probability_to_tell);
        assert!(proposed.into_iter().all(|chance| chance.then > chance.now), "{:?}", isolability.to_drive);
    }

    /// GIVEN a drive with little noise THEN of all that varies as it likes it is said how large it must be, whatever its course:
    /// every second course is told at less than nine of ten are, and with these chances.
    #[test]
    fn what_varies_as_it_likes_is_told_in_the_mean_over_courses() {
        let (vehicle, recording) = recorded("");
        let recordings = [recording];
        let library = ["sensor_drift", "road_bank", "crosswind"].map(|kind| named(kind).unwrap());
        let case = Case { library: &library, ..case(&vehicle, &recordings) };
        let effects = case.sensitivity().unwrap().effects;
        let mut names: Vec<String> = effects.iter().map(|it| it.power.name.clone()).collect();
        names.sort_unstable();
        let drifts = ["lateral_acceleration", "steering_wheel_angle", "yaw_rate"]
            .map(|of| format!("sensor_drift:{of}"));
        assert_eq!(names, [&["crosswind".to_owned(), "road_bank".to_owned()], &drifts[..]].concat());
        for it in &effects {
            let (half, most) = (it.named_50.unwrap(), it.named_90.unwrap());
            assert!(0.0 < half && half < most && it.noticed_90.unwrap() <= most, "{it:?}");
            assert!((it.power.chance(half) - 0.5).abs() < 1e-3 && (it.power.chance(most) - 0.9).abs() < 1e-3);
        }
        let gyroscope = effects.iter().find(|it| it.power.name == drifts[2]).unwrap();
        // `a_drifting_gyroscope_is_told_from_the_road` finds one of 0.019 rad/s on this drive.
        let (half, most) = (gyroscope.named_50.unwrap(), gyroscope.named_90.unwrap());
        assert!((0.005..0.025).contains(&half) && most < 0.04, "{gyroscope:?}");
        assert_eq!((gyroscope.parameter.as_str(), gyroscope.unit.as_str()), ("drift_rms", "rad/s"));
    }
}
