//! What was found as tables of a configuration.

use super::result::Finding;
use physics::model::Uncertain;
use physics::model::effect::{Channel, Course, EffectConfig, EffectError, Kind, named};

/// Findings as the configuration's tables.
///
/// # Errors
/// Numbers that no table takes.
pub fn effects<'f>(
    findings: impl IntoIterator<Item = &'f Finding>,
) -> Result<Vec<EffectConfig>, EffectError> {
    findings.into_iter().filter_map(effect).collect()
}

fn effect(finding: &Finding) -> Option<Result<EffectConfig, EffectError>> {
    let kind = named(&finding.effect)?;
    let channel = match &finding.channel {
        Some(channel) => Some(channel.parse::<Channel>().ok().filter(|channel| takes(kind, channel))?),
        None => None,
    };
    let specs = (0..kind.parameters.len()).filter_map(|place| kind.spec(place, channel));
    let numbers = specs.map(|spec| {
        let known = finding.parameters.get(spec.name);
        let (low, high) = spec.range();
        let value = known.map_or(spec.value(spec.mean), |known| known.value.clamp(low, high));
        Uncertain { value: rounded(value), std: rounded(known.map_or(0.0, |known| known.std)) }
    });
    let course = match kind.course {
        Some(_) => Course::Stretches { intervals: finding.place.intervals.clone(), value: 1.0 },
        None => Course::None,
    };
    Some(EffectConfig::new(kind, channel, numbers.collect(), course))
}

/// How a message of the speed is measured has no table.
fn takes(kind: &Kind, channel: &Channel) -> bool {
    kind.channels.contains(channel) || kind.is_law()
}

/// Six significant digits are more than anyone knows.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
