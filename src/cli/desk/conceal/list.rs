//! What can be put in, and what that needs.

use std::io::Write as _;

use super::asked::drawn_key;
use crate::cli::Failure;
use bus::Config;
use lab::explain::ordinary::conceal::{Way, way};
use physics::Quantity;
use physics::model::effect::{EffectConfig, KINDS, Kind, Spec};

/// All kinds, to the standard output.
pub fn print(config: Option<&Config>) -> Result<(), Failure> {
    let mut text = String::new();
    for kind in KINDS {
        text += &about(kind, config);
    }
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    stdout.flush()?;
    Ok(())
}

fn about(kind: &Kind, config: Option<&Config>) -> String {
    let keys: Vec<String> = kind.parameters.iter().map(number).collect();
    let course: Vec<&str> =
        drawn_key(kind).into_iter().chain(EffectConfig::keys(kind).filter(|key| is_of_course(key))).collect();
    let of: Vec<String> = kind.channels.iter().map(ToString::to_string).collect();
    let mut text = format!("{}: {}\n", kind.name, kind.about);
    let mut line = |name: &str, value: String| {
        if !value.is_empty() {
            text += &format!("    {name:<10}{value}\n");
        }
    };
    line("channel", of.join(", "));
    line("numbers", keys.join(", "));
    line("course", course.join(", or "));
    line("needs", needs(kind, config));
    text
}

fn is_of_course(key: &str) -> bool {
    matches!(key, "value" | "intervals" | "series")
}

/// A number's key and unit.
fn number(spec: &Spec) -> String {
    if spec.unit == "1" { spec.name.to_owned() } else { format!("{} ({})", spec.name, spec.unit) }
}

fn needs(kind: &Kind, config: Option<&Config>) -> String {
    let (words, lacking) = match way(kind) {
        Way::Sensor => ("its channel; put onto the frames", Vec::new()),
        Way::Wheels => ("the wheel speeds; put onto the frames", lacking(config, &[&Quantity::ALL[..4]])),
        Way::Runs => {
            let speed: Vec<Quantity> = Quantity::ALL.into_iter().filter(|q| q.tells_speed()).collect();
            let all = [&[Quantity::YawRate][..], &[Quantity::SteeringWheelAngle], &speed];
            (
                "yaw_rate, steering_wheel_angle and a speed; the difference of two free runs is added to all that is there \
                 of yaw rate, accelerations, wheel speeds, drive torque and brakes",
                lacking(config, &all),
            )
        }
    };
    if lacking.is_empty() {
        words.to_owned()
    } else {
        format!("{words} (not configured: {})", lacking.join(", "))
    }
}

/// Of groups any of which will do, those that a configuration has nothing of.
fn lacking(config: Option<&Config>, groups: &[&[Quantity]]) -> Vec<String> {
    let Some(config) = config else { return Vec::new() };
    let has = |quantity: &Quantity| config.signals.quantities.contains_key(quantity);
    let without = groups.iter().filter(|group| !group.iter().any(has));
    without.filter_map(|group| group.first()).map(|quantity| quantity.name().to_owned()).collect()
}
