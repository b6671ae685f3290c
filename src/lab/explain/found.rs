//! What was found as tables of a configuration.

use super::result::Finding;
use physics::model::Uncertain;
use physics::model::effect::{Channel, Course, EffectConfig, EffectError, Kind, Series, named};

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
    let course = match (&finding.series, kind.course) {
        (Some(series), Some(_)) => {
            let value = series.value.iter().map(|value| rounded(*value)).collect();
            Course::Series(within_range(kind, channel, Series { t: series.t.clone(), value }))
        }
        (None, Some(_)) => Course::Stretches { intervals: finding.place.intervals.clone(), value: 1.0 },
        (_, None) => Course::None,
    };
    Some(EffectConfig::new(kind, channel, numbers.collect(), course))
}

/// A course within what it can be: smoothed, it may swing beyond.
pub fn within_range(kind: &Kind, channel: Option<Channel>, mut series: Series) -> Series {
    if let Some(known) = kind.disturbance(channel) {
        let (low, high) = known.range();
        series.value.iter_mut().for_each(|value| *value = value.clamp(low, high));
    }
    series
}

/// How a message of the speed is measured has no table.
fn takes(kind: &Kind, channel: &Channel) -> bool {
    kind.channels.contains(channel) || kind.is_law()
}

/// Six significant digits are more than anyone knows.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::super::result::CourseEstimate;
    use super::*;

    #[test]
    fn a_course_that_was_found_is_one_of_the_configuration() {
        let mut drift =
            Finding { effect: "sensor_drift".into(), channel: Some("yaw_rate".into()), ..Finding::default() };
        let (t, unit) = (vec![0.0, 10.0, 20.0], "rad/s".to_owned());
        drift.series = Some(CourseEstimate { t, value: vec![0.01, -0.02, 99.0], std: vec![0.001; 3], unit });
        let written = effects([&drift]).unwrap();
        let Course::Series(series) = written[0].course() else { panic!("{:?}", written[0]) };
        assert_eq!((&series.t[..], &series.value[..2]), (&[0.0, 10.0, 20.0][..], &[0.01, -0.02][..]));
        // No sensor drifts as far as that.
        assert!(series.value[2] <= 1.0, "{series:?}");
    }
}
