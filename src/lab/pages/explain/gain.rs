//! By how much the extended model is better on what was held out.

use super::words;
use crate::explain::Explanation;
use crate::pages::beside;
use physics::Quantity;

/// How the held-out fit of a channel changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain<'a> {
    /// The channel.
    pub channel: &'a str,
    /// Of the plain model, %.
    pub from: f64,
    /// Of the extended one, %.
    pub to: f64,
    /// 95 % interval of the difference, percentage points.
    pub interval: Option<[f64; 2]>,
}

impl Gain<'_> {
    /// Percentage points.
    pub fn points(&self) -> f64 {
        self.to - self.from
    }

    /// Is it above zero with the whole interval?
    pub fn is_certain(&self) -> bool {
        self.interval.is_none_or(|[low, _]| low > 0.0)
    }

    /// A fit below zero is no fit: what happens there counts for nothing.
    fn visible(&self) -> f64 {
        self.to.max(0.0) - self.from.max(0.0)
    }
}

/// Of all channels, the largest certain one first.
pub fn gains(explanation: &Explanation) -> Vec<Gain<'_>> {
    let fit = &explanation.fit;
    let mut gains: Vec<Gain<'_>> = fit
        .extended
        .holdout
        .iter()
        .filter_map(|(channel, to)| {
            let from = *fit.baseline.holdout.get(channel)?;
            let interval = explanation.improvement_ci95.get(channel).copied();
            let interval = interval.filter(|it| it.iter().all(|end| end.is_finite()));
            (from.is_finite() && to.is_finite()).then_some(Gain { channel, from, to: *to, interval })
        })
        .collect();
    gains.sort_by(|a, b| {
        let certain = b.is_certain().cmp(&a.is_certain());
        certain.then(b.visible().total_cmp(&a.visible())).then(b.points().total_cmp(&a.points()))
    });
    gains
}

/// The error of a channel on what was held out, of the plain and of the extended model where that differs, in words.
pub fn error(explanation: &Explanation, channel: &str) -> Option<String> {
    let [before, after] = [&explanation.error.baseline, &explanation.error.extended]
        .map(|of| of.holdout.get(channel).copied().unwrap_or(f64::NAN));
    let (factor, unit) = shown(channel);
    beside::told(&[before, after], (factor, &unit))
}

/// The unit that a channel is shown in, and what an SI unit is in it.
pub fn shown(channel: &str) -> (f64, String) {
    // Only the speed is no quantity of the configuration.
    words::shown_unit(channel, channel.parse::<Quantity>().map_or("m/s", Quantity::unit))
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn a_gain_is_told_in_the_unit_of_its_channel() {
        let explanation = sample::missing();
        assert_eq!(gains(&explanation)[0].channel, "lateral_acceleration");
        assert_eq!(error(&explanation, "yaw_rate").as_deref(), Some("3.55 → 0.630 °/s"));
        assert_eq!(error(&explanation, "speed").as_deref(), Some("0.0360 km/h"));
        assert_eq!(error(&explanation, "nothing"), None);
    }
}
