//! What the audit says.

use std::fmt;

use serde::Serialize;

use super::standing::{Standing, ZeroCourse};
use physics::Quantity;

/// How sure a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Confidence {
    /// Something is there, but more than one cause explains it.
    Unclear,
    /// The best explanation; physics beyond the plain car could do the same.
    Likely,
    /// No road, tire or car does this.
    Certain,
}

/// One thing wrong with the measurement chain.
#[derive(Clone, Debug, Serialize)]
pub struct AuditFinding {
    /// `foreign_signal`, `sensor_sign`, `channel_swap`, `sensor_scale`, `sensor_delay`, `sensor_bias`, `sensor_drift` or
    /// `tire_radius`.
    pub effect: &'static str,
    /// The quantity; two with a slash for a swap; `wheel_speed` for all four.
    pub channel: String,
    /// How much: factor − 1 for a scale, s for a delay, SI for a bias and a drift (rms), relative for a radius; none for
    /// signs and swaps.
    pub value: Option<f64>,
    /// Its standard deviation.
    pub std: Option<f64>,
    /// Size of the evidence in standard deviations.
    pub t: f64,
    /// In words.
    pub evidence: String,
    /// How sure.
    pub confidence: Confidence,
    /// What to write into the configuration.
    pub repair: String,
    /// What else it could be.
    pub or: Vec<String>,
}

impl AuditFinding {
    /// The effect of a signal that does not belong to the others. While it is there, nothing else means much: it is said
    /// first.
    pub const FOREIGN: &'static str = "foreign_signal";

    /// The effect of a zero that moves.
    pub const DRIFT: &'static str = "sensor_drift";

    /// How much, as it is read: with its unit, and digits as its standard deviation has them.
    pub fn amount(&self) -> Option<String> {
        let (value, std) = self.value.zip(self.std)?;
        let (factor, unit) = match self.effect {
            "sensor_delay" => (1e3, "ms"),
            "sensor_scale" | "tire_radius" => (100.0, "%"),
            _ => (1.0, self.channel.parse::<Quantity>().map_or("", Quantity::unit)),
        };
        let (value, std) = (factor * value, factor * std);
        let decimals = (1.0 - std.log10().floor()).clamp(0.0, 6.0) as usize;
        Some(format!("{value:.decimals$} ± {std:.decimals$} {unit}").trim_end().to_owned())
    }
}

/// In a line without full stop.
impl fmt::Display for AuditFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let confidence = format!("{:?}", self.confidence).to_lowercase();
        let value = self.amount().map_or(String::new(), |amount| format!(" {amount}"));
        write!(f, "{} of {}{value}, {confidence}: {}", self.effect, self.channel, self.evidence)
    }
}

/// A comparison that was made.
#[derive(Clone, Debug, Serialize)]
pub struct RelationReport {
    /// Which.
    pub relation: &'static str,
    /// Slope, one if all is right; in the recording as it is, before anything was put right.
    pub gain: Option<f64>,
    /// Its standard deviation.
    pub gain_std: Option<f64>,
    /// How much later the first channel is than the second, s; signs and scales put right.
    pub delay_s: Option<f64>,
    /// Its standard deviation.
    pub delay_std: Option<f64>,
    /// Share of the variance that the relation explains.
    pub explained: Option<f64>,
}

/// A constant that a channel is off by. Sensors have them; the estimators learn them.
#[derive(Clone, Debug, Serialize)]
pub struct Offset {
    /// The quantity.
    pub channel: &'static str,
    /// SI.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
    /// How it was found.
    pub from: &'static str,
    /// What would take it out.
    pub repair: String,
}

/// What could not be judged, and what to drive.
#[derive(Clone, Debug, Serialize)]
pub struct Unclear {
    /// What.
    pub what: String,
    /// What to do about it.
    pub to_do: String,
}

/// The result of the audit.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ChainReport {
    /// Length of the drive.
    pub seconds: f64,
    /// Of which the car moved.
    pub moving_seconds: f64,
    /// What is wrong, surest first.
    pub findings: Vec<AuditFinding>,
    /// Offsets, whether they matter or not.
    pub offsets: Vec<Offset>,
    /// What could not be judged.
    pub unclear: Vec<Unclear>,
    /// All comparisons.
    pub relations: Vec<RelationReport>,
    /// What the yaw rate reads while the car stands.
    #[serde(skip)]
    pub standing: Option<Standing>,
    /// How the yaw rate's zero moves, if that is among the findings.
    #[serde(skip)]
    pub drift: Option<ZeroCourse>,
    /// May a banked road be what lateral acceleration and yaw rate say of scale and delay?
    #[serde(skip)]
    pub may_be_banked: bool,
    /// How well the radii of an axle's wheels are told apart, front and rear, relative; none where the driving does not.
    #[serde(skip)]
    pub radii: Option<[f64; 2]>,
    /// Was there enough driving to compare anything? Else nothing was found because nothing was looked at.
    pub compared: bool,
}

impl ChainReport {
    /// Notes what could not be judged.
    pub(super) fn unclear(&mut self, what: impl Into<String>, to_do: impl Into<String>) {
        self.unclear.push(Unclear { what: what.into(), to_do: to_do.into() });
    }

    /// Surest first, then by evidence.
    pub(super) fn sort(&mut self) {
        let is_other = |finding: &AuditFinding| finding.effect != AuditFinding::FOREIGN;
        self.findings.sort_by(|a, b| {
            let by_confidence = is_other(a).cmp(&is_other(b)).then(b.confidence.cmp(&a.confidence));
            by_confidence.then(b.t.abs().total_cmp(&a.t.abs()))
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_amount_has_its_unit() {
        let amount = |effect, channel: &str, value, std| {
            let finding = AuditFinding {
                effect,
                channel: channel.into(),
                value: Some(value),
                std: Some(std),
                t: 5.0,
                evidence: String::new(),
                confidence: Confidence::Likely,
                repair: String::new(),
                or: Vec::new(),
            };
            finding.amount().unwrap()
        };
        assert_eq!(amount("sensor_delay", "yaw_rate", -0.085_46, 0.020_85), "-85 ± 21 ms");
        assert_eq!(amount("sensor_scale", "wheel_speed", 0.0312, 0.0011), "3.12 ± 0.11 %");
        assert_eq!(amount("sensor_bias", "yaw_rate", 0.01, 0.002), "0.0100 ± 0.0020 rad/s");
    }
}
