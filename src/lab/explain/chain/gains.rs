//! Scales and units: the magnitudes of all relations' slopes, attributed to one channel.

use nalgebra::DMatrix;

use super::attribution::{AHEAD, Cause, Evidence, FOUND, SURE, attribute};
use super::bank::without_banks;
use super::relations::{Link, Relation, link};
use super::report::{AuditFinding, ChainReport, Confidence, RelationReport};
use super::sensor_group::SensorGroup;
use super::series::Series;
use super::tuning::TUNING;
use super::units;
use physics::Wheel;

/// How far a relation's slope may be from one without anything being wrong (logarithmic), beside what
/// the vehicle's own uncertainty allows.
fn model_error(series: &Series, relation: Relation) -> f64 {
    let driven = |front: bool| {
        let wheel = if front { Wheel::Fl } else { Wheel::Rl };
        series.vehicle.driven_axle.drives(wheel)
    };
    match relation {
        Relation::RearWheels if !driven(false) => 0.01,
        Relation::FrontWheels if !driven(true) => 0.015,
        // Inner and outer wheel slip differently under drive torque.
        Relation::RearWheels | Relation::FrontWheels => 0.08,
        Relation::Lateral | Relation::Longitudinal => 0.01,
        Relation::Steering => 0.02,
    }
}

fn covariance(series: &Series, links: &[Link]) -> DMatrix<f64> {
    let vehicle = &series.vehicle;
    let share = |u: physics::model::Uncertain| u.std / u.value;
    let radius = share(vehicle.wheel_radius_m);
    let track = share(vehicle.track_rear_m).max(share(vehicle.track_front_m));
    let is_axle = |link: &Link| link.relation.is_of_an_axle();
    DMatrix::from_fn(links.len(), links.len(), |i, j| {
        let (a, b) = (&links[i], &links[j]);
        let mut sum =
            radius.powi(2) * SensorGroup::Wheels.power(a.relation) * SensorGroup::Wheels.power(b.relation);
        if is_axle(a) && is_axle(b) {
            sum += track.powi(2);
        }
        if i == j {
            sum += (a.widened() * a.gain_std / a.gain).powi(2) + model_error(series, a.relation).powi(2);
            if a.relation == Relation::Steering {
                sum += share(vehicle.steering_ratio).powi(2) + share(vehicle.wheelbase_m).powi(2);
            }
        }
        sum
    })
}

/// Finds wrong scales one after the other and puts them right in the series.
pub(super) fn scales(series: &mut Series, report: &mut ChainReport) {
    let mut first = true;
    for _ in 0..3 {
        let links: Vec<Link> = Relation::ALL.into_iter().filter_map(|r| link(series, r)).collect();
        if std::mem::take(&mut first) {
            note(series, &links, report);
        }
        let links: Vec<Link> = links.into_iter().filter(Link::has_scale).collect();
        let links = without_banks(series, links, report);
        let Some((channel, factor)) = next_scale(series, &links, report) else { return };
        for quantity in series.quantities(channel) {
            series.scale(quantity, 1.0 / factor);
        }
        series.refresh();
    }
}

/// Every comparison goes into the report, and what could not be compared.
fn note(series: &Series, links: &[Link], report: &mut ChainReport) {
    for relation in Relation::ALL {
        let link = links.iter().find(|link| link.relation == relation);
        let clear = link.filter(|link| link.is_clear);
        report.relations.push(RelationReport {
            relation: relation.name(),
            gain: link.map(|link| link.gain),
            gain_std: link.map(|link| link.gain_std),
            delay_s: None,
            delay_std: None,
            explained: link.map(|link| link.explained),
        });
        if clear.is_none() {
            let (why, to_do) = why_not(series, relation, link);
            report.unclear(format!("{}: {why}", relation.name()), to_do);
        }
    }
}

/// A locked axle's wheels differ by less than this share of what the yaw rate asks for. Physical: tracks differ by a tenth.
const LOCKED: f64 = 0.3;

/// Why a relation was not to be compared, and what to do.
fn why_not(series: &Series, relation: Relation, link: Option<&Link>) -> (String, &'static str) {
    let lacking = relation.needs().into_iter().find(|quantity| !series.has(*quantity));
    if let Some(lacking) = lacking {
        return (format!("there is no {lacking}"), "map it, if the bus has it (gripd map)");
    }
    // So small, and so surely: the car did turn.
    let is_locked = |link: &&Link| link.gain.abs() + 3.0 * link.gain_std < LOCKED;
    if relation.is_of_an_axle() && link.is_some_and(|link| is_locked(&link)) {
        return (
            "its wheels turn alike while the car turns: the axle is locked (a spool, a locked differential)"
                .into(),
            "nothing is wrong if it is; else look for the right signals of its wheels",
        );
    }
    ("too little happened to compare them".into(), relation.manoeuvre())
}

fn next_scale(series: &Series, links: &[Link], report: &mut ChainReport) -> Option<(SensorGroup, f64)> {
    let evidence = Evidence {
        seen: links.iter().map(|link| link.gain.abs().ln()).collect(),
        covariance: covariance(series, links),
    };
    let causes: Vec<Cause<SensorGroup>> = SensorGroup::ALL
        .into_iter()
        .map(|channel| Cause {
            channel,
            pattern: links.iter().map(|link| channel.power(link.relation)).collect(),
        })
        .collect();
    let (_, explanations) = attribute(&evidence, &causes)?;
    let best = *explanations.first()?;
    if best.gain < FOUND || best.value.abs() < TUNING.harmless_scale {
        return None;
    }
    let next = explanations.get(1).map_or(0.0, |next| next.gain);
    let factor = best.value.exp();
    let seen_in = || links.iter().filter(|link| best.channel.power(link.relation) != 0.0);
    let large = best.value.abs() > best.channel.explained_by_physics();
    // The relation that says it best says it whatever error its regressor has.
    let pressed = seen_in().map(|link| link.pressed).fold(f64::INFINITY, f64::min);
    let surely = best.value.abs() - pressed > best.channel.explained_by_physics();
    let words = if series.is_by_wheels() || best.channel != SensorGroup::Wheels {
        units::mistake(best.channel, factor, best.std, &series.vehicle)
    } else {
        units::mistaken_speed(factor, best.std)
    };
    let words = words.filter(|_| large);
    let confidence = if surely && best.gain - next > SURE {
        Confidence::Certain
    } else if best.gain - next > AHEAD && best.value.abs() > pressed {
        Confidence::Likely
    } else {
        Confidence::Unclear
    };
    let mut or: Vec<String> = explanations[1..]
        .iter()
        .filter(|other| best.gain - other.gain < AHEAD && other.gain > FOUND)
        .map(|other| {
            format!("sensor_scale of {} ({:+.1} %)", series.name(other.channel), 100.0 * other.value.exp_m1())
        })
        .collect();
    if !large {
        or.extend(physics(best.channel).filter(|_| series.is_by_wheels()).map(str::to_owned));
    }
    let repair = match words {
        Some(words) => format!("{words}; or multiply its gain by {:.5}", 1.0 / factor),
        None => correction(series, best.channel, factor),
    };
    report.findings.push(AuditFinding {
        effect: "sensor_scale",
        channel: series.name(best.channel).to_owned(),
        value: Some(factor - 1.0),
        std: Some(factor * best.std),
        t: best.gain.sqrt(),
        evidence: format!(
            "values are {factor:.4} times what the other channels say ({})",
            seen_in()
                .map(|link| format!("{}: {:.3} ± {:.3}", link.relation.name(), link.gain, link.gain_std))
                .collect::<Vec<_>>()
                .join("; ")
        ),
        confidence,
        repair,
        or,
    });
    Some((best.channel, factor))
}

/// What, apart from the sensor, makes a channel's scale look wrong by some percent.
fn physics(channel: SensorGroup) -> Option<&'static str> {
    match channel {
        SensorGroup::Wheels => Some("wheel_radius_m is off"),
        SensorGroup::Yaw => None,
        SensorGroup::Lateral => Some("body_roll (the accelerometer leans with the body)"),
        SensorGroup::Longitudinal => Some("the accelerometer pitches with the body"),
        SensorGroup::Steering => Some("steering_ratio is off"),
    }
}

fn correction(series: &Series, channel: SensorGroup, factor: f64) -> String {
    match channel {
        SensorGroup::Wheels if series.is_by_wheels() => format!(
            "[vehicle] wheel_radius_m = {:.4}, or multiply the gain of all wheel speeds by {:.4}",
            series.vehicle.wheel_radius_m.value * factor,
            1.0 / factor
        ),
        SensorGroup::Steering => format!(
            "[vehicle] steering_ratio = {:.2}, or multiply its gain by {:.4}",
            series.vehicle.steering_ratio.value * factor,
            1.0 / factor
        ),
        _ => {
            format!("multiply its gain by {:.4} (gain = {:.4} if there is none)", 1.0 / factor, 1.0 / factor)
        }
    }
}
