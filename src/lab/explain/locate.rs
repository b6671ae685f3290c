//! Where one model predicts better than another: in which sensors, in which driving, and when.

use std::collections::BTreeMap;

use super::model::Model;
use physics::Quantity;
use predict::GriddedDrive;
use predict::car::BODY_STATES;
use predict::grid::{STEP_S, points};
use predict::noise::Noise;
use predict::pass::{Beside, pass};
use predict::sums::{Innovation, PassOptions};

/// Seconds of one bin. Numerical: resolution of what is shown.
pub const BIN_S: f64 = 0.5;

/// How much better one model predicts than another, ln likelihood, bin by bin.
#[derive(Clone, Debug, Default)]
pub struct Gains {
    /// Of each bin.
    pub bins: Vec<f64>,
    /// Of each quantity.
    pub channels: BTreeMap<usize, f64>,
}

/// All innovations of a model over a drive.
pub fn innovations(drive: &GriddedDrive, model: &Model<'_>, noise: &Noise) -> Vec<Innovation> {
    let mut all = Vec::new();
    let ask = PassOptions { innovations: Some(&mut all), ..PassOptions::default() };
    pass((0, drive), &model.car(), Beside::default(), noise, ask);
    all
}

/// Compares two models' innovations of the same drive.
pub fn gains(seconds: f64, before: &[Innovation], after: &[Innovation]) -> Gains {
    let mut gains = Gains { bins: vec![0.0; (seconds / BIN_S).ceil() as usize + 1], ..Gains::default() };
    for (before, after) in before.iter().zip(after) {
        let ln = |i: &Innovation| -0.5 * (i.error / i.std).powi(2) - i.std.ln();
        let gain = ln(after) - ln(before);
        gains.bins[(before.t / BIN_S) as usize] += gain;
        *gains.channels.entry(usize::from(before.channel)).or_default() += gain;
    }
    gains
}

impl Gains {
    /// The quantities with most of the gain, the clearest first.
    pub fn clearest(&self) -> Vec<String> {
        let mut all: Vec<(usize, f64)> =
            self.channels.iter().map(|(channel, gain)| (*channel, *gain)).collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        let most = all.first().map_or(0.0, |first| first.1);
        let worth = all.into_iter().filter(|(_, gain)| *gain > 0.15 * most && *gain > 2.0);
        worth.map(|(channel, _)| Quantity::ALL[channel].name().to_owned()).collect()
    }

    /// The smallest stretches that hold most of the gain, s.
    pub fn intervals(&self) -> Vec<[f64; 2]> {
        let mut order: Vec<usize> = (0..self.bins.len()).filter(|bin| self.bins[*bin] > 0.0).collect();
        order.sort_by(|a, b| self.bins[*b].total_cmp(&self.bins[*a]));
        let total: f64 = order.iter().map(|bin| self.bins[*bin]).sum();
        let mut is_in = vec![false; self.bins.len()];
        let mut held = 0.0;
        for bin in order {
            if held > MOST_OF_IT * total {
                break;
            }
            held += self.bins[bin];
            is_in[bin] = true;
        }
        let at = |bin: usize| bin as f64 * BIN_S;
        let bins = is_in.iter().enumerate().filter(|(_, is_in)| **is_in);
        merged(bins.map(|(bin, _)| [at(bin), at(bin + 1)]), BIN_S)
    }
}

/// Share of the gain that the stretches hold. For the reader only: no verdict depends on it.
const MOST_OF_IT: f64 = 0.8;

/// Pieces of time in their order as stretches, s, to a hundredth; gaps up to this are bridged.
pub fn merged(pieces: impl Iterator<Item = [f64; 2]>, bridged_s: f64) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = Vec::new();
    for piece in pieces {
        let [from, to] = piece.map(|t| (t * 100.0).round() / 100.0);
        match all.last_mut() {
            Some(last) if from <= last[1] + bridged_s + 1e-6 => last[1] = to,
            _ => all.push([from, to]),
        }
    }
    all
}

/// Some kind of driving: its name, and whether an instant belongs to it.
type Regime = (&'static str, fn(&GriddedDrive, usize) -> bool);

/// The driving in which most of the gain lies, in words.
pub fn regimes(drive: &GriddedDrive, gains: &Gains) -> Vec<String> {
    let per_bin = points(BIN_S);
    let total: f64 = gains.bins.iter().map(|gain| gain.max(0.0)).sum();
    let all: [Regime; 9] = [
        ("slow, below 10 m/s", |d, k| d.speed[k] < 10.0),
        ("fast, above 25 m/s", |d, k| d.speed[k] > 25.0),
        ("braking", |d, k| d.inputs[k].brake_pressure > 2.0),
        ("driving off, torque well above rolling", |d, k| rate(d, k) > 1.0),
        ("turning hard, above 4 m/s²", |d, k| turn(d, k).abs() > 4.0),
        ("turning, 1.5 to 4 m/s²", |d, k| (1.5..=4.0).contains(&turn(d, k).abs())),
        ("straight ahead", |d, k| turn(d, k).abs() < 0.5),
        ("quick steering, above 1 rad/s", |d, k| steering_rate(d, k).abs() > 1.0),
        ("steady steering", |d, k| steering_rate(d, k).abs() < 0.1),
    ];
    let bins = gains.bins.len().min(drive.speed.len() / per_bin);
    let middle = |bin: usize| bin * per_bin + per_bin / 2;
    let mut found: Vec<(f64, String)> = all
        .into_iter()
        .filter_map(|(name, is_in)| {
            let within: Vec<usize> = (0..bins).filter(|bin| is_in(drive, middle(*bin))).collect();
            let share_of_time = within.len() as f64 / bins.max(1) as f64;
            let share = within.iter().map(|bin| gains.bins[*bin].max(0.0)).sum::<f64>() / total.max(1e-9);
            let is_typical = within.len() > 3 && share > 1.4 * share_of_time && share > 0.25;
            is_typical.then(|| {
                let words = format!(
                    "{name}: {:.0} % of it in {:.0} % of the time",
                    100.0 * share,
                    100.0 * share_of_time
                );
                (share / share_of_time, words)
            })
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut words: Vec<String> = found.into_iter().map(|(_, words)| words).take(3).collect();
    if words.is_empty() {
        words.push("all of the drive alike".into());
    }
    words
}

/// Lateral acceleration that steering asks for, roughly, m/s².
pub fn turn(drive: &GriddedDrive, k: usize) -> f64 {
    let speed = drive.speed[k];
    // A usual ratio and wheelbase, and some understeer.
    drive.inputs[k].steering_wheel / 15.5 * speed * speed / (2.7 + 0.003 * 2.7 * speed * speed)
}

/// How fast the steering wheel turns, rad/s.
pub fn steering_rate(drive: &GriddedDrive, k: usize) -> f64 {
    let near = points(0.05);
    let (from, to) = (k.saturating_sub(near), (k + near).min(drive.inputs.len() - 1));
    (drive.inputs[to].steering_wheel - drive.inputs[from].steering_wheel) / (2.0 * near as f64 * STEP_S)
}

/// How fast the speed by the wheels rises, m/s².
pub fn rate(drive: &GriddedDrive, k: usize) -> f64 {
    let near = points(0.25);
    let (from, to) = (k.saturating_sub(near), (k + near).min(drive.speed.len() - 1));
    (drive.speed[to] - drive.speed[from]) / (2.0 * near as f64 * STEP_S)
}

/// Names of the equations in the order of their diffusions.
pub const EQUATIONS: [(&str, &str); BODY_STATES] = [
    ("longitudinal force balance", "m/s per √s"),
    ("lateral force balance", "m/s per √s"),
    ("yaw moment balance", "rad/s per √s"),
];
