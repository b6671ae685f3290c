//! Put right and looked at again, until nothing certain is left.

use std::path::{Path, PathBuf};

use crate::cli::Failure;
use crate::cli::desk::check::{self, Parts, RecordingReport};
use crate::cli::desk::part::Part;
use bus::Config;
use bus::propose::{self, Correction, Proposal, VehicleTable};
use bus::service::sensors;
use lab::explain::chain::{self, AuditFinding, ChainReport, Confidence};
use physics::model::Uncertain;
use physics::{Quantity, Sample, Wheel};

/// Rounds at most: signs hide scales, scales hide delays, and delays zeros.
const ROUNDS: usize = 6;
/// How well an acceleration tells a torque, relative: mass and radius are a guess, and hills are in it. Tuned: the Zoe's
/// motor torque comes out at 0.7 of what its gears are known for (`tests/commands/setup`).
const TORQUE_STD: f64 = 0.35;

/// What is read and written.
pub struct Files<'a> {
    /// The configuration.
    pub out: &'a Path,
    /// As they stand in it.
    pub dbcs: &'a [PathBuf],
    /// The recordings.
    pub logs: &'a [PathBuf],
    /// Of which only this part counts.
    pub part: Part,
}

/// The configuration when nothing more could be put right.
pub struct Settled {
    /// The file.
    pub text: String,
    /// What its signals are like.
    pub recordings: RecordingReport,
    /// How they agree.
    pub chain: ChainReport,
}

impl Settled {
    /// What is certain and could not be put right.
    pub fn certain(&self) -> impl Iterator<Item = &AuditFinding> {
        self.chain.findings.iter().filter(|finding| finding.confidence == Confidence::Certain)
    }
}

/// Reads the recordings as the configuration says, learns of the car what they tell, and takes out what is certainly
/// wrong with the signals; again, until nothing is.
pub fn settle(
    proposal: &mut Proposal,
    vehicle: &mut VehicleTable,
    files: &Files,
) -> Result<Settled, Failure> {
    let mut round = 0;
    loop {
        round += 1;
        let config = parse(&written(proposal, vehicle, files), files)?;
        let parts =
            Parts::build(&config, files.out).map_err(|problems| Failure::Usage(check::list(&problems)))?;
        let (recordings, samples) = check::read(files.logs, files.part.clone(), &config, &parts)?;
        learn_car(vehicle, &samples, &config);
        let text = written(proposal, vehicle, files);
        let config = parse(&text, files)?;
        let chain = chain::audit(&samples, &config.vehicle, &sensors(&parts.inputs));
        let mut changed = without_a_value(proposal, &recordings);
        changed |= repair(proposal, &chain);
        changed |= learn_torques(vehicle, &config, &chain);
        if !changed || round >= ROUNDS {
            return Ok(Settled { text, recordings, chain });
        }
    }
}

fn written(proposal: &Proposal, vehicle: &VehicleTable, files: &Files) -> String {
    let dbcs: Vec<&Path> = files.dbcs.iter().map(PathBuf::as_path).collect();
    let end = "Look at what is not `sure`.";
    propose::signals(proposal, &dbcs, "Made by `gripd setup` from", end)
        + &vehicle.text(|quantity| proposal.has(quantity))
}

fn parse(text: &str, files: &Files) -> Result<Config, Failure> {
    Config::parse(text, files.out).map_err(Failure::usage)
}

/// The driven axle and the steering ratio, where the drive tells them.
fn learn_car(vehicle: &mut VehicleTable, samples: &[Sample], config: &Config) {
    let mut car = config.vehicle.clone();
    if let Some(axle) = chain::driven_axle(samples, &car)
        && vehicle.learn_driven(axle, "slip under acceleration")
    {
        car.driven_axle = axle;
    }
    if let Some(ratio) = chain::steering_ratio(samples, &car) {
        vehicle.learn("steering_ratio", ratio, "steering against yaw rate");
    }
}

/// How much torque the signals mean, where the car's acceleration tells it.
fn learn_torques(vehicle: &mut VehicleTable, config: &Config, chain: &ChainReport) -> bool {
    let mut learned = false;
    for finding in &chain.findings {
        let (Some(value), "sensor_scale") = (finding.value, finding.effect) else { continue };
        let factor = 1.0 / (1.0 + value);
        let keys: &[&str] = match finding.channel.parse() {
            Ok(Quantity::DriveTorque) => &["drive_torque_ratio"],
            Ok(Quantity::BrakePressure) => &["brake_torque_per_bar_front_nm", "brake_torque_per_bar_rear_nm"],
            _ => continue,
        };
        for (key, number) in config.vehicle.parameters().into_iter().filter(|(key, _)| keys.contains(key)) {
            let value = number.value * factor;
            let number = Uncertain { value, std: TORQUE_STD * value.abs() };
            learned |= vehicle.learn(key, number, "torque against acceleration");
        }
    }
    learned
}

/// A signal whose quality bits deny every value is none.
fn without_a_value(proposal: &mut Proposal, recordings: &RecordingReport) -> bool {
    let mut changed = false;
    for channel in recordings.quantities.iter().filter(|channel| channel.min.is_none()) {
        let Ok(quantity) = channel.quantity.parse() else { continue };
        changed |= leave_out(proposal, quantity, "never has a value in these recordings");
    }
    changed
}

/// Leaves a quantity out, if the rest is enough to run.
fn leave_out(proposal: &mut Proposal, quantity: Quantity, why: &str) -> bool {
    let rest = |other: Quantity| other != quantity && proposal.has(other);
    Quantity::lacking(rest).is_empty() && proposal.correct(quantity, Correction::Foreign, why)
}

/// The order in which the audit puts things right before it looks for the next.
const ORDER: [&str; 7] = [
    AuditFinding::FOREIGN,
    "channel_swap",
    "sensor_sign",
    "sensor_scale",
    "sensor_delay",
    "sensor_bias",
    "tire_radius",
];

/// Takes out what is certain; true if anything could be.
fn repair(proposal: &mut Proposal, chain: &ChainReport) -> bool {
    let place = |finding: &&AuditFinding| ORDER.iter().position(|effect| *effect == finding.effect);
    let mut certain: Vec<&AuditFinding> =
        chain.findings.iter().filter(|finding| finding.confidence == Confidence::Certain).collect();
    certain.sort_by_key(place);
    let mut changed = false;
    for finding in certain {
        let words = words(finding);
        if finding.effect == AuditFinding::FOREIGN {
            // While it is there nothing else means much.
            if let Ok(quantity) = finding.channel.parse()
                && leave_out(proposal, quantity, &words)
            {
                return true;
            }
            continue;
        }
        for (quantity, correction) in corrections(finding) {
            changed |= proposal.correct(quantity, correction, &words);
        }
    }
    changed
}

/// What a finding is for each of its channels.
fn corrections(finding: &AuditFinding) -> Vec<(Quantity, Correction)> {
    let value = finding.value.unwrap_or(0.0);
    let correction = match finding.effect {
        "channel_swap" => {
            let pairs = finding.channel.split([',', ' ']).filter_map(|pair| pair.split_once('/'));
            let parsed = pairs.filter_map(|(one, other)| Some((one.parse().ok()?, other.parse().ok()?)));
            return parsed.map(|(one, other)| (one, Correction::Exchanged(other))).collect();
        }
        "sensor_sign" => Correction::Turned,
        "sensor_scale" => Correction::Times(1.0 + value),
        "sensor_delay" => Correction::Late(value),
        "sensor_bias" => Correction::Zero(value),
        // A larger wheel turns less often.
        "tire_radius" => Correction::Times(1.0 / (1.0 + value)),
        _ => return Vec::new(),
    };
    match finding.channel.as_str() {
        "wheel_speed" => {
            Wheel::ALL.into_iter().map(|wheel| (Quantity::wheel_speed(wheel), correction)).collect()
        }
        channel => channel.parse().map(|quantity| vec![(quantity, correction)]).unwrap_or_default(),
    }
}

/// A finding in words.
fn words(finding: &AuditFinding) -> String {
    let value = finding.value.unwrap_or(0.0);
    let what = match finding.effect {
        AuditFinding::FOREIGN => "does not belong to the others".to_owned(),
        "channel_swap" => format!("exchanged ({})", finding.channel),
        "sensor_sign" => "was the wrong way round".to_owned(),
        "sensor_scale" => format!("read {:.4} times what it should", 1.0 + value),
        "sensor_delay" => format!("comes {:.0} ms late", 1e3 * value),
        "sensor_bias" => format!("read {value:.3} where it should read zero"),
        "tire_radius" if value < 0.0 => {
            format!("its wheel is {:.2} % smaller than the others", -100.0 * value)
        }
        "tire_radius" => format!("its wheel is {:.2} % larger than the others", 100.0 * value),
        other => other.to_owned(),
    };
    format!("{what} ({})", finding.evidence)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(effect: &'static str, channel: &str, value: f64) -> AuditFinding {
        AuditFinding {
            effect,
            channel: channel.into(),
            value: Some(value),
            std: Some(0.01),
            t: 9.0,
            evidence: "so".into(),
            confidence: Confidence::Certain,
            repair: String::new(),
            or: Vec::new(),
        }
    }

    #[test]
    fn each_finding_has_its_correction() {
        let of = |effect, channel, value| corrections(&finding(effect, channel, value));
        let yaw = Quantity::YawRate;
        assert_eq!(of("sensor_sign", "yaw_rate", 0.0), [(yaw, Correction::Turned)]);
        assert_eq!(of("sensor_scale", "yaw_rate", 0.25), [(yaw, Correction::Times(1.25))]);
        assert_eq!(of("sensor_delay", "yaw_rate", 0.1), [(yaw, Correction::Late(0.1))]);
        assert_eq!(of("sensor_bias", "yaw_rate", 0.1), [(yaw, Correction::Zero(0.1))]);
        assert_eq!(of("sensor_scale", "wheel_speed", 1.0).len(), 4);
        let (fl, fr) = (Quantity::WheelSpeedFl, Quantity::WheelSpeedFr);
        assert_eq!(of("tire_radius", "wheel_speed_fl", 0.25), [(fl, Correction::Times(0.8))]);
        let swaps = of("channel_swap", "wheel_speed_fl/wheel_speed_fr, wheel_speed_rl/wheel_speed_rr", 0.0);
        assert_eq!(swaps.len(), 2);
        assert_eq!(swaps[0], (fl, Correction::Exchanged(fr)));
        assert!(of("something_else", "yaw_rate", 1.0).is_empty());
    }
}
