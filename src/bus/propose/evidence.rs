//! Does a signal behave like the quantity it may be?

use serde::Serialize;

use super::along;
use super::motion::{Confirmed, Motion, TRACK_M};
use super::regression::{Line, line};
use super::source::Unit;
use physics::Quantity;

/// What the recordings say of a signal as a quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evidence {
    /// Whether it behaves so.
    pub verdict: Verdict,
    /// Correlation with what it should follow, −1 to 1; none for flags.
    pub correlation: Option<f64>,
    /// What it reads over what it should, sign included; 1 is right. In the unit taken.
    pub scale: Option<f64>,
    /// The value where it should be zero, SI.
    pub zero: Option<f64>,
    /// In words, with the numbers.
    pub words: String,
    /// The unit that makes sense of it, where the file has none or a wrong one.
    #[serde(skip)]
    pub(super) unit: Unit,
    /// Which way it points: 1 or −1.
    #[serde(skip)]
    pub(super) sign: f64,
}

/// Whether a signal behaves like a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It does not.
    Contradicts,
    /// The recordings do not tell, or hardly.
    Silent,
    /// It does.
    Fits,
}

impl Evidence {
    pub(super) fn silent(unit: &Unit, words: String) -> Self {
        Self {
            verdict: Verdict::Silent,
            correlation: None,
            scale: None,
            zero: None,
            words,
            unit: unit.clone(),
            sign: 1.0,
        }
    }

    /// Strength without a sign.
    pub(super) fn strength(&self) -> f64 {
        self.correlation.map_or(0.0, f64::abs)
    }
}

/// A law that a quantity obeys.
struct Law {
    /// What it follows, in words.
    follows: &'static str,
    /// Correlation from which on it fits, and below which it contradicts.
    enough: [f64; 2],
    /// Scales that are possible.
    scales: [f64; 2],
    /// The sign may be turned.
    turns: bool,
    /// Units to try where the file has none, or one that cannot be.
    units: &'static [&'static str],
}

/// A yaw rate of this standard deviation is enough to call a sensor wrong, rad/s.
const CURVY: f64 = 0.02;

/// Compares the points of a signal, in the file's unit, with what a quantity would do.
pub(super) fn weigh(quantity: Quantity, series: &[f64], unit: &Unit, motion: &Motion) -> Evidence {
    let turns =
        matches!(quantity, Quantity::YawRate | Quantity::LateralAcceleration | Quantity::SteeringWheelAngle);
    let mut evidence = compare(quantity, series, unit, motion);
    // By a sensor whose own zero is not known, no other's is told.
    if turns && motion.confirmed.is_some() {
        evidence.zero = None;
    }
    // Gentle curves may confirm, but where they do not, noise may be the reason.
    if turns && motion.turning() < CURVY && evidence.verdict == Verdict::Contradicts {
        evidence.verdict = Verdict::Silent;
        evidence.words = format!("hardly any curves; {}", evidence.words);
    }
    evidence
}

fn compare(quantity: Quantity, series: &[f64], unit: &Unit, motion: &Motion) -> Evidence {
    let moving = motion.moving_s();
    if moving < 10.0 {
        return Evidence::silent(unit, format!("only {moving:.0} s of driving"));
    }
    match quantity {
        Quantity::YawRate | Quantity::LateralAcceleration | Quantity::SteeringWheelAngle
            if !motion.turned =>
        {
            Evidence::silent(unit, "the recording goes too straight on to tell".into())
        }
        Quantity::LongitudinalAcceleration
        | Quantity::BrakePressure
        | Quantity::BrakeTorque
        | Quantity::DriveTorque
        | Quantity::BrakeActive
            if motion.changing() < 0.2 =>
        {
            Evidence::silent(unit, "the speed hardly changes in the recording".into())
        }
        Quantity::YawRate => match &motion.confirmed {
            None => yaw_rate(series, unit, motion),
            Some(confirmed) => {
                let law = Law {
                    follows: "the one that is called so",
                    enough: [0.95, 0.8],
                    scales: [0.9, 1.1],
                    turns: true,
                    units: &["deg/s", "rad/s"],
                };
                by_another(follow(quantity, series, unit, &motion.turn, &law), confirmed)
            }
        },
        Quantity::LateralAcceleration => {
            let law = Law {
                follows: "speed × yaw rate",
                enough: [0.7, 0.35],
                scales: [0.6, 1.5],
                turns: true,
                units: &["m/s^2", "g"],
            };
            follow(quantity, series, unit, &motion.lateral(), &law)
        }
        Quantity::SteeringWheelAngle => {
            let law = Law {
                follows: "curvature",
                enough: [0.7, 0.35],
                scales: [0.4, 2.2],
                turns: true,
                units: &["deg", "rad"],
            };
            // Wheelbase times steering ratio of most cars, m.
            let angle: Vec<f64> = motion.steering().iter().map(|k| 42.0 * k).collect();
            follow(quantity, series, unit, &angle, &law)
        }
        Quantity::LongitudinalAcceleration => {
            let law = Law {
                follows: "change of speed",
                enough: [0.6, 0.3],
                scales: [0.5, 1.5],
                turns: true,
                units: &["m/s^2", "g"],
            };
            follow(quantity, series, unit, &motion.change, &law)
        }
        Quantity::VehicleSpeed => {
            let law = Law {
                follows: "wheels",
                enough: [0.95, 0.8],
                scales: [0.8, 1.25],
                turns: false,
                units: &["km/h", "m/s", "mph"],
            };
            match &motion.confirmed {
                None => follow(quantity, series, unit, &motion.speed, &law),
                Some(confirmed) => by_another(follow(quantity, series, unit, &motion.speed, &law), confirmed),
            }
        }
        Quantity::BrakePressure | Quantity::BrakeTorque => along::brake(series, unit, motion),
        Quantity::DriveTorque => along::torque(series, unit, motion),
        Quantity::BrakeActive => along::pedal(series, unit, motion),
        Quantity::AbsActive => Evidence::silent(unit, "recordings of ordinary driving do not show it".into()),
        Quantity::WheelSpeedFl | Quantity::WheelSpeedFr | Quantity::WheelSpeedRl | Quantity::WheelSpeedRr => {
            Evidence::silent(unit, "judged four at a time".into())
        }
    }
}

/// A signal that is in proportion to something, but for a zero.
fn follow(quantity: Quantity, series: &[f64], unit: &Unit, law_si: &[f64], law: &Law) -> Evidence {
    let Some(found) = line(series, &[law_si]) else {
        return constant(series, unit, law);
    };
    let slope = found.factors[0];
    judge(quantity, unit, law, &found, slope, |unit| unit * slope)
}

/// The verdict on a line.
fn judge(
    quantity: Quantity,
    unit: &Unit,
    law: &Law,
    found: &Line,
    slope: f64,
    scale_of: impl Fn(f64) -> f64,
) -> Evidence {
    let possible = |to_si: f64| {
        let scale = scale_of(to_si);
        (law.scales[0]..law.scales[1]).contains(&scale.abs()) && (law.turns || scale > 0.0)
    };
    let own = unit.to_si().filter(|to_si| possible(*to_si)).map(|_| unit.clone());
    let tried = law.units.iter().map(|name| Unit::guessed(quantity, name));
    let taken = own.or_else(|| {
        tried.filter(|u| u.to_si().is_some_and(possible)).min_by(|a, b| {
            let off = |unit: &Unit| unit.to_si().map_or(f64::INFINITY, |u| scale_of(u).abs().ln().abs());
            off(a).total_cmp(&off(b))
        })
    });
    let strength = found.correlation.abs();
    let unit = taken.clone().unwrap_or_else(|| unit.clone());
    let scale = unit.to_si().map(&scale_of);
    let verdict = match (&taken, strength) {
        (Some(_), s) if s >= law.enough[0] => Verdict::Fits,
        (None, s) if s >= law.enough[0] => Verdict::Contradicts,
        (_, s) if s < law.enough[1] => Verdict::Contradicts,
        _ => Verdict::Silent,
    };
    let size = match (scale, quantity) {
        (Some(scale), Quantity::SteeringWheelAngle) => {
            format!(", {:.1} of curvature × 2.7 m", (42.0 * scale / 2.7).abs())
        }
        (Some(scale), Quantity::YawRate) => format!(", as for a track of {:.2} m", TRACK_M * scale.abs()),
        (Some(scale), _) => format!(", scale {:.2}", scale.abs()),
        (None, _) => ", in no unit that is known".into(),
    };
    let turned = if scale.unwrap_or(slope) < 0.0 { ", the other way round" } else { "" };
    let words = format!("correlation {strength:.2} with {}{size}{turned}", law.follows);
    let zero = found.factors.last().zip(unit.to_si()).map(|(zero, to_si)| zero * to_si);
    Evidence {
        verdict,
        correlation: Some(found.correlation),
        scale,
        zero,
        words,
        sign: if slope < 0.0 { -1.0 } else { 1.0 },
        unit,
    }
}

/// A signal that no line can be drawn for.
fn constant(series: &[f64], unit: &Unit, law: &Law) -> Evidence {
    let values = series.iter().filter(|value| value.is_finite()).count();
    let words = if values < 25 {
        "too few values while driving".to_owned()
    } else {
        format!("does not move with {}", law.follows)
    };
    Evidence::silent(unit, words)
}

/// Wheels on the outside are faster, by track × yaw rate. The sensor is the regressor: it is less noisy.
fn yaw_rate(series: &[f64], unit: &Unit, motion: &Motion) -> Evidence {
    let law = Law {
        follows: "right minus left wheels",
        enough: [0.7, 0.35],
        scales: [1.1 / TRACK_M, 2.2 / TRACK_M],
        turns: true,
        units: &["deg/s", "rad/s"],
    };
    let Some(found) = line(&motion.difference, &[series, &motion.speed]) else {
        return constant(series, unit, &law);
    };
    let slope = found.factors[0];
    let mut evidence = judge(Quantity::YawRate, unit, &law, &found, slope, |to_si| slope / to_si / TRACK_M);
    // Where the wheels agree, the sensor's zero: without tires of unlike size, which nobody knows.
    evidence.zero = line(series, &[&motion.difference])
        .and_then(|zero| Some(zero.factors.last()? * evidence.unit.to_si()?));
    evidence
}

/// Where no wheels tell, a signal fits as well as another one confirmed it; where it should be zero is not known.
fn by_another(mut evidence: Evidence, confirmed: &Confirmed) -> Evidence {
    if evidence.verdict == Verdict::Fits {
        evidence.correlation = Some(evidence.sign * confirmed.correlation);
        evidence.zero = None;
        evidence.words = format!(
            "no wheels to compare with, but {} agrees with speed and yaw rate, correlation {:.2}",
            confirmed.with, confirmed.correlation
        );
    }
    evidence
}
