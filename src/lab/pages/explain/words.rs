//! Names and units as a chassis engineer says them.

use crate::explain::chain::AuditFinding;
use crate::explain::{Estimate, Finding, ToDrive, Where};
use identify::Parameter;
use physics::model::effect::{self, Kind, Spec};
use physics::time::stretch;

pub use super::headline::{
    answer, beside, compared_with, confirmed, explained, headline, recordings, reference, subject, verdict,
};
pub use super::numbers::{number, plus_minus, probability, signed, three, with_unit};

/// "a, b and c".
pub fn list(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// With a capital first letter, unless it begins with a name as files have it.
pub fn sentence(text: &str) -> String {
    if text.split_whitespace().next().is_some_and(|word| word.contains(['_', '.', '/'])) {
        return text.to_owned();
    }
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// With a full stop at its end, if there is anything.
pub fn stopped(text: &str) -> String {
    let text = sentence(text.trim());
    if text.is_empty() || text.ends_with(['.', '!', '?']) { text } else { text + "." }
}

/// What to drive, and where that stands as a scenario.
pub fn to_drive(it: &ToDrive) -> String {
    let scenario = it.scenario.as_ref().map(|path| format!(" As a scenario for `gripd simulate`: {path}."));
    stopped(&it.words) + &scenario.unwrap_or_default()
}

/// When, by both clocks, the first few stretches.
pub fn intervals(place: &Where, most: usize) -> String {
    let shown = place.intervals.iter().take(most).enumerate();
    let one = |(number_of, [from, to]): (usize, &[f64; 2])| {
        let utc = place.intervals_utc.get(number_of).map(|utc| format!(" ({})", stretch(utc)));
        format!("{}–{} s{}", number(*from, 1), number(*to, 1), utc.unwrap_or_default())
    };
    let shown: Vec<String> = shown.map(one).collect();
    match place.intervals.len() - shown.len() {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// A quantity, or two.
pub fn channel(name: &str) -> String {
    // What a law says is a formula.
    if name.contains(": ") {
        return name.into();
    }
    let one = |name: &str| match name {
        "wheel_speed_fl" => "front left wheel speed".into(),
        "wheel_speed_fr" => "front right wheel speed".into(),
        "wheel_speed_rl" => "rear left wheel speed".into(),
        "wheel_speed_rr" => "rear right wheel speed".into(),
        other => other.replace('_', " "),
    };
    name.split('/').map(one).collect::<Vec<_>>().join(" and ")
}

/// Names of channels in the order in which one asks for them: the car's motion, then the wheels.
pub fn in_order<'a>(names: impl Iterator<Item = &'a String>) -> Vec<&'a str> {
    const FIRST: [&str; 5] =
        ["yaw_rate", "lateral_acceleration", "longitudinal_acceleration", "speed", "vehicle_speed"];
    let mut names: Vec<&str> = names.map(String::as_str).collect();
    let rank = |name: &str| FIRST.iter().position(|first| *first == name).unwrap_or(FIRST.len());
    names.sort_by(|a, b| rank(a).cmp(&rank(b)).then(a.cmp(b)));
    names.dedup();
    names
}

/// The error's share of the variance of what was recorded, from a fit in %.
pub fn left_of_variance(fit: f64) -> f64 {
    (1.0 - 0.01 * fit).powi(2)
}

/// What something is shown in: factor and unit.
pub fn shown_unit(channel: &str, unit: &str) -> (f64, String) {
    let degrees = 1f64.to_degrees();
    match unit {
        "rad/s" if channel.starts_with("wheel_speed") => (1.0, unit.into()),
        "rad/s" => (degrees, "°/s".into()),
        "rad" => (degrees, "°".into()),
        "m/s" if channel.contains("speed") => (3.6, "km/h".into()),
        "rad/(m/s²)" => (degrees, "°/(m/s²)".into()),
        "rad/(N m)" => (1e3 * degrees, "°/(kN m)".into()),
        "1" => (1.0, String::new()),
        unit => (1.0, unit.into()),
    }
}

/// An effect, of its channel.
pub fn effect(name: &str, of: Option<&str>) -> String {
    let of = of.map(channel);
    match (effect::named(name), of) {
        (Some(kind), of) => kind.words_of(of.as_deref()),
        (None, Some(channel)) => format!("{} of {channel}", name.replace('_', " ")),
        (None, None) => name.replace('_', " "),
    }
}

/// What a finding is called.
pub fn name_of(finding: &Finding) -> String {
    match effect::named(&finding.effect) {
        Some(_) => effect(&finding.effect, finding.channel.as_deref()),
        None => parameter_name(&finding.effect),
    }
}

/// A name that may have its channel with it, as `sensor_delay of yaw_rate` or `sensor_delay(yaw_rate)`.
pub fn effect_named(text: &str) -> String {
    if let Some(law) = text.trim().strip_prefix("law:") {
        return effect("law", Some(law));
    }
    let text = text.trim().trim_end_matches(')');
    // A number of an effect that every car has.
    if let Some((name, _)) = text.split_once('.').filter(|(name, _)| effect::named(name).is_some()) {
        return effect(name, None);
    }
    // Of four wheels one.
    if let Some((name, wheel)) = text.split_once(':').filter(|(_, of)| of.len() == 2) {
        return format!("{}, {}", effect(name, None), wheel.to_uppercase());
    }
    match text.split_once([' ', '(', ':']) {
        Some((name, of)) if effect::named(name).is_some() => {
            let of = of.trim_start_matches(['(', ' ']).trim_start_matches("of ");
            effect(name, (!of.is_empty()).then_some(of))
        }
        _ if effect::named(text).is_some() => effect(text, None),
        _ => text.replace('_', " "),
    }
}

/// Is it of the measurement rather than of the car?
pub fn is_of_sensors(name: &str) -> bool {
    name == AuditFinding::FOREIGN || effect::named(name).is_some_and(Kind::is_of_measurement)
}

/// A number as it is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// What it is.
    pub name: String,
    /// In the unit it is shown in.
    pub estimate: Estimate,
    /// That unit; empty for ratios.
    pub unit: String,
    /// Is it the one (or one of those) with which the effect vanishes?
    pub is_main: bool,
}

impl Shown {
    /// Value ± std with the unit.
    pub fn value(&self) -> String {
        let number = plus_minus(self.estimate);
        let is_sum = number.contains('±') && !self.unit.is_empty() && !number.starts_with('(');
        if is_sum && self.unit == "°" { format!("({number})°") } else { with_unit(&number, &self.unit) }
    }
}

/// The numbers of a finding, the main ones first.
pub fn parameters(finding: &Finding) -> Vec<Shown> {
    let kind = effect::named(&finding.effect);
    let of = finding.channel.as_deref().and_then(|channel| channel.parse().ok());
    let mut rows: Vec<Shown> = finding
        .parameters
        .iter()
        // A moment before the recording: it was there from the start.
        .filter(|(name, estimate)| name.as_str() != Spec::AT_S.name || estimate.value >= 0.0)
        .map(|(name, estimate)| {
            let place = kind.and_then(|kind| kind.place_of(name));
            let spec = kind.zip(place).and_then(|(kind, place)| kind.spec(place, of));
            let course = kind.and_then(|kind| kind.disturbance(of));
            let (words, unit, is_main) = match (spec, course) {
                (Some(spec), _) => (spec.words.to_owned(), spec.unit, spec.is_main),
                (None, Some(course)) if course.rms_name == name => {
                    (course.words.to_owned(), course.unit, true)
                }
                (None, course) => (parameter_name(name), course.map_or("1", |course| course.unit), false),
            };
            let of = finding.channel.as_deref().unwrap_or("");
            Shown { name: words, is_main, ..shown(name, of, unit, *estimate) }
        })
        .collect();
    // Of several main ones (four wheels), the one that is furthest from nothing.
    let weight = |row: &Shown| (row.estimate.value / row.estimate.std.max(f64::MIN_POSITIVE)).abs();
    rows.sort_by(|a, b| {
        b.is_main.cmp(&a.is_main).then(if a.is_main {
            weight(b).total_cmp(&weight(a))
        } else {
            a.name.cmp(&b.name)
        })
    });
    rows
}

/// A size of a number of this channel and unit, to three digits.
pub fn size(name: &str, channel: &str, unit: &str, size: f64) -> String {
    let shown = shown(name, channel, unit, Estimate { value: size, std: 0.0 });
    with_unit(&three(shown.estimate.value), &shown.unit)
}

/// What a number of an effect, or of the car, is.
pub fn parameter(effect: &str, channel: Option<&str>, name: &str) -> String {
    let of = channel.and_then(|channel| channel.parse().ok());
    let kind = effect::named(effect);
    let spec = kind.and_then(|kind| kind.spec(kind.place_of(name)?, of));
    spec.map_or_else(|| parameter_name(name), |spec| spec.words.to_owned())
}

/// A number in the unit it is shown in.
pub fn shown(name: &str, channel: &str, unit: &str, estimate: Estimate) -> Shown {
    let (factor, unit) = match name {
        // An effect's, or an ordinary number: how late a channel is.
        _ if name.ends_with("delay_s") => (1e3, "ms".to_owned()),
        "time_constant_s" => (1e3, "ms".to_owned()),
        "relative_error" => (100.0, "%".to_owned()),
        _ if name.starts_with("relative_difference") || name.starts_with("slip_offset") => {
            (100.0, "%".to_owned())
        }
        "roll_frequency_rad_per_s" => (0.5 / std::f64::consts::PI, "Hz".to_owned()),
        _ => shown_unit(channel, unit),
    };
    let estimate = Estimate { value: factor * estimate.value, std: (factor * estimate.std).abs() };
    Shown { name: parameter_name(name), estimate, unit, is_main: false }
}

/// One of the ordinary numbers: of the vehicle, of the measurement, or of an effect that every car has (`kind.number`);
/// of several recordings with the one that it is of behind it.
pub fn ordinary(name: &str, estimate: Estimate) -> Shown {
    if let Some((number, recording)) = name.split_once(" of ") {
        let shown = ordinary(number, estimate);
        return Shown { name: format!("{} of {recording}", shown.name), ..shown };
    }
    let of_an_effect = name.split_once('.').and_then(|(kind, number)| {
        let kind = effect::named(kind)?;
        Some((kind, kind.parameters.iter().find(|spec| spec.name == number)?))
    });
    if let Some((kind, spec)) = of_an_effect {
        let name = format!("{}: {}", kind.words, spec.words);
        return Shown { name, ..shown(spec.name, "", spec.unit, estimate) };
    }
    let unit = match name {
        "lateral_stiffness" => "1/rad",
        _ => Parameter::named(name).map_or("1", Parameter::unit),
    };
    shown(name, "", unit, estimate)
}

/// The name of an ordinary number in a sentence.
fn parameter_name(name: &str) -> String {
    let words = match name {
        "cg_to_front_m" => "front axle to centre of gravity",
        "yaw_inertia_kgm2" => "yaw inertia",
        "wheel_inertia_kgm2" => "wheel inertia",
        "brake_torque_per_bar_front_nm" => "front brake torque per bar",
        "brake_torque_per_bar_rear_nm" => "rear brake torque per bar",
        "drag_coefficient_kg_per_m" => "drag coefficient",
        "lateral_stiffness_front" => "front cornering stiffness",
        "lateral_stiffness_rear" => "rear cornering stiffness",
        "lateral_stiffness" => "cornering stiffness",
        "track_front_m" => "front track",
        "track_rear_m" => "rear track",
        _ => "",
    };
    if !words.is_empty() {
        return words.into();
    }
    if let Some(wheel) = name.strip_prefix("slip_offset_") {
        let wheel = channel(&format!("wheel_speed_{wheel}"));
        return format!("slip offset, {}", wheel.trim_end_matches(" speed"));
    }
    let units = ["_kgm2", "_kg_per_m", "_kg", "_nm", "_m", "_s", "_n", "_rad"];
    let short = units.iter().find_map(|unit| name.strip_suffix(unit)).unwrap_or(name);
    short.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_have_names_for_people() {
        assert_eq!(effect("load_transfer", None), "load transfer");
        assert_eq!(effect("sensor_delay", Some("yaw_rate")), "late yaw rate");
        assert_eq!(
            effect("channel_swap", Some("wheel_speed_fl/wheel_speed_fr")),
            "front left wheel speed and front right wheel speed swapped"
        );
        assert_eq!(effect_named("sensor_delay of yaw_rate"), "late yaw rate");
        assert_eq!(effect_named("sensor_scale(yaw_rate)"), "wrong scale of yaw rate");
        assert_eq!(
            effect_named("law:yaw moment: memory(a_y, 0.3 s)"),
            "law of the yaw moment: memory(a_y, 0.3 s)"
        );
        assert_eq!(effect_named("road_bank"), "road bank");
        assert_eq!(effect_named("a softer front axle"), "a softer front axle");
        for kind in effect::KINDS {
            assert!(!effect(kind.name, None).contains(['_', '{']), "{}", kind.name);
        }
    }

    #[test]
    fn angles_are_in_degrees_and_wheels_are_not() {
        assert_eq!(shown_unit("yaw_rate", "rad/s").1, "°/s");
        assert_eq!(shown_unit("wheel_speed_fl", "rad/s"), (1.0, "rad/s".into()));
        let offset = ordinary("yaw_rate_offset", Estimate { value: 0.01, std: 0.001 });
        assert_eq!(offset.value(), "0.57 ± 0.06 °/s");
        let delay = ordinary("lateral_acceleration_delay_s", Estimate { value: -0.0004, std: 0.0021 });
        assert_eq!(
            (delay.name.as_str(), delay.value().as_str()),
            ("lateral acceleration delay", "−0.4 ± 2.1 ms")
        );
        let ratio = ordinary("steering_ratio", Estimate { value: 15.5, std: 0.1 });
        assert_eq!((ratio.name.as_str(), ratio.value().as_str()), ("steering ratio", "15.50 ± 0.10"));
        let length = ordinary("relaxation_length.length_m", Estimate { value: 0.35, std: 0.05 });
        assert_eq!(
            (length.name.as_str(), length.value().as_str()),
            ("tire relaxation length: relaxation length", "0.35 ± 0.05 m")
        );
        let of_one = ordinary("speed_delay_s of a/b.log", Estimate { value: 0.01, std: 0.001 });
        assert_eq!(
            (of_one.name.as_str(), of_one.value().as_str()),
            ("speed delay of a/b.log", "10.0 ± 1.0 ms")
        );
        assert_eq!(
            ordinary("slip_offset_fl", Estimate { value: 0.01, std: 0.0 }).name,
            "slip offset, front left wheel"
        );
    }

    #[test]
    fn channels_are_in_the_order_in_which_one_asks_for_them() {
        let names =
            ["lateral_acceleration", "speed", "wheel_speed_rl", "wheel_speed_fl", "yaw_rate", "speed"];
        let names = names.map(str::to_owned);
        let order = ["yaw_rate", "lateral_acceleration", "speed", "wheel_speed_fl", "wheel_speed_rl"];
        assert_eq!(in_order(names.iter()), order);
    }

    #[test]
    fn a_few_stretches_are_named_and_the_others_counted() {
        let three = vec![[1.0, 2.0], [3.0, 4.5], [5.0, 6.0]];
        let mut place = Where { intervals: three, ..Where::default() };
        assert_eq!(intervals(&place, 2), "1.0–2.0 s, 3.0–4.5 s and 1 more");
        let utc = |seconds: &str| format!("2025-10-09T08:53:{seconds}Z");
        place.intervals_utc = vec![[utc("21.000"), utc("22.000")]];
        place.intervals.truncate(1);
        assert_eq!(intervals(&place, 2), "1.0–2.0 s (2025-10-09T08:53:21.000Z to 08:53:22.000Z)");
        assert_eq!(intervals(&Where::default(), 2), "");
    }
}
