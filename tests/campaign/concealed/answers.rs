//! Drives with and without effects, and the answers to them, which are kept.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};
use testing::program::gripd;

use super::judge::{Judged, judge};
use super::plan::{By, Case};
use crate::free_runs::yardstick_python;
use crate::{found, kept};

/// Where drives are read from, and answers are kept.
pub struct Answers {
    recordings: PathBuf,
    kept: PathBuf,
}

/// Name and place on the bus of what the tool changes: frame, word, raw unit, whether signed.
const WORDS: [(&str, &str, usize, f64, bool); 7] = [
    ("yaw_rate", "1B0", 0, 1e-4, true),
    ("lateral_acceleration", "1B0", 1, 1e-3, true),
    ("longitudinal_acceleration", "1B0", 2, 1e-3, true),
    ("wheel_speed_fl", "1A0", 0, 0.005, false),
    ("wheel_speed_fr", "1A0", 1, 0.005, false),
    ("wheel_speed_rl", "1A0", 2, 0.005, false),
    ("wheel_speed_rr", "1A0", 3, 0.005, false),
];

impl Answers {
    /// None where the recordings are absent.
    pub fn in_folder() -> Option<Self> {
        let recordings = testing::shared("recordings")?;
        Some(Self { recordings, kept: kept::folder("CONCEALED_ANSWERS", "concealed_real") })
    }

    /// What is said of a case, or why it cannot be put in.
    pub fn of_case(&self, case: &Case) -> Result<Judged, String> {
        let changed = self.changed(case)?;
        let ask = |log: &Path, references: &[&str]| {
            let what = if log == changed.log { case.told() } else { "control".into() };
            self.explained(case.drive.config, case.drive.name, &what, log, references)
        };
        let original = self.log(case.drive.name);
        let said =
            |references: &[&str]| judge(case, &ask(&changed.log, references), &ask(&original, references));
        Ok(Judged {
            strength: self.strength(case, &changed),
            predicted: self.predicted(case),
            alone: said(&[]),
            beside: (!case.drive.references.is_empty()).then(|| said(case.drive.references)),
        })
    }

    /// What is said of an unchanged drive of the lot beside others.
    pub fn of_healthy(&self, drive: &str, references: &[&str]) -> Value {
        let name = format!("gti/{drive}");
        self.explained("gti/drives.toml", &name, "control", &self.log(&name), references)
    }

    fn log(&self, drive: &str) -> PathBuf {
        self.recordings.join(format!("{drive}.log.gz"))
    }

    fn file(&self, words: &[&str], ending: &str) -> PathBuf {
        kept::file(&self.kept, &words.join(" "), ending)
    }

    /// Verdict and findings; traces and courses are many, and not looked at.
    fn explained(&self, config: &str, drive: &str, what: &str, log: &Path, references: &[&str]) -> Value {
        let beside = references.join(" ");
        kept::answer(&self.file(&[drive, what, &beside], "json"), || {
            let mut command = self.explain(config);
            for reference in references {
                command.arg("--reference").arg(self.log(drive).with_file_name(format!("{reference}.log.gz")));
            }
            let answer = json_of(command.arg(log));
            json!({ "verdict": answer["verdict"], "findings": answer["findings"] })
        })
    }

    fn explain(&self, config: &str) -> Command {
        let mut command = gripd();
        // One of them on each core.
        command.env("RAYON_NUM_THREADS", "1");
        command.args(["-q", "explain", "--json", "-", "-c"]).arg(self.recordings.join(config));
        command
    }

    /// The chance that the unchanged drive has of telling such an effect by its name.
    fn predicted(&self, case: &Case) -> Option<f64> {
        let sensitivity = kept::answer(&self.file(&[case.drive.name, "sensitivity"], "json"), || {
            let mut command = self.explain(case.drive.config);
            json_of(command.arg("--sensitivity").arg(self.log(case.drive.name)))
        });
        let is_it = |of: &&Value| {
            of["effect"] == case.effect.name
                && of["channel"].as_str() == case.effect.channel
                && of["parameter"] == case.effect.number
        };
        let of = sensitivity["effects"].as_array()?.iter().find(is_it)?;
        let (half, most) = (of["named_50"].as_f64()?, of["named_90"].as_f64()?);
        let change = (case.expected()? - of["neutral"].as_f64()?).abs();
        // A normal variable is less than 1.2816 with a probability of 90 %.
        Some(lab::chance::normal_cdf(1.2816 * (change - half) / (most - half)))
    }

    fn changed(&self, case: &Case) -> Result<Changed, String> {
        let log = self.file(&[case.drive.name, &case.told()], "log.gz");
        let (truth, refused) = (log.with_extension("truth"), log.with_extension("refused"));
        if !log.exists() {
            if let Ok(reason) = fs::read_to_string(&refused) {
                return Err(reason);
            }
            let making = log.with_extension("making.gz");
            let mut command = match case.by {
                By::Gripd => self.by_gripd(case.drive.config, case.drive.name, &case.told(), &making, &truth),
                By::Tool => self.by_the_tool(case, &making),
            };
            let output = command.output().unwrap();
            let words = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            match output.status.code() {
                Some(0) => fs::rename(&making, &log).unwrap(),
                Some(1) if !words.contains("Traceback") => {
                    let reason = kept::reason(&words);
                    fs::write(&refused, &reason).unwrap();
                    return Err(reason);
                }
                _ => panic!("{words}"),
            }
        }
        Ok(Changed { log, truth })
    }

    fn by_gripd(&self, config: &str, drive: &str, effect: &str, out: &Path, truth: &Path) -> Command {
        let mut command = gripd();
        command.args(["-q", "conceal", "--effect", effect, "-c"]).arg(self.recordings.join(config));
        command.arg(self.log(drive)).arg("-o").arg(out).arg("--truth").arg(truth);
        command
    }

    fn by_the_tool(&self, case: &Case, out: &Path) -> Command {
        let mut command = Command::new(yardstick_python());
        command.arg(self.recordings.join("tools/conceal.py")).arg(self.recordings.join(case.drive.config));
        command.arg(self.log(case.drive.name)).arg(out).args(case.told().split(' '));
        command
    }

    /// The change over what the ordinary car leaves, in the channel where it is largest.
    fn strength(&self, case: &Case, changed: &Changed) -> f64 {
        if let Some(truth) = kept::read(&changed.truth) {
            return found::strength(&truth);
        }
        // What the ordinary car leaves is told of anything that is put in.
        let file = self.file(&[case.drive.name, "left"], "truth");
        let left = kept::read(&file).unwrap_or_else(|| {
            let any = "kind = 'sensor_bias', channel = 'yaw_rate', bias = 0.01";
            let out = file.with_extension("log");
            let output =
                self.by_gripd(case.drive.config, case.drive.name, any, &out, &file).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            kept::read(&file).unwrap()
        });
        let left = &left["channels"];
        let [before, after] = [&self.log(case.drive.name), &changed.log].map(|log| text(log));
        let raw = |log: &str, frame: &'static str, word: usize, signed: bool| -> Vec<Option<f64>> {
            words(log, frame, word, signed).collect()
        };
        let left = |name: &str| left[name]["unexplained_rms"].as_f64();
        let strength = |(name, frame, word, unit, signed): (&str, &'static str, usize, f64, bool)| {
            let unexplained = left(name)?;
            let [before, after] = [&before, &after].map(|log| raw(log, frame, word, signed));
            Some(unit * rms(before.iter().zip(&after).map(|(a, b)| Some((*b)? - (*a)?))) / unexplained)
        };
        // The angle is an input: it changes the yaw rate by the same share.
        let by_steering = || {
            let [before_angle, after_angle] = [&before, &after].map(|log| raw(log, "1C0", 0, true));
            let change = before_angle.iter().zip(&after_angle).map(|(a, b)| Some((*b)? - (*a)?));
            let yaw_rate = 1e-4 * rms(raw(&before, "1B0", 0, true).into_iter());
            Some(rms(change) / rms(before_angle.iter().copied()) * yaw_rate / left("yaw_rate")?)
        };
        WORDS.into_iter().filter_map(strength).chain(by_steering()).fold(0.0, f64::max)
    }
}

fn rms(values: impl Iterator<Item = Option<f64>>) -> f64 {
    let (sum, count) =
        values.flatten().fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    f64::sqrt(sum / f64::max(count, 1.0))
}

struct Changed {
    log: PathBuf,
    /// Where `gripd conceal` wrote it.
    truth: PathBuf,
}

fn json_of(command: &mut Command) -> Value {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn text(log: &Path) -> String {
    std::io::read_to_string(flate2::read::MultiGzDecoder::new(fs::File::open(log).unwrap())).unwrap()
}

/// Raw values of a 16-bit word of a frame, one for each frame; none where not available.
fn words<'t>(
    log: &'t str,
    frame: &'t str,
    word: usize,
    signed: bool,
) -> impl Iterator<Item = Option<f64>> + 't {
    log.lines()
        .filter_map(|line| line.split(' ').nth(2)?.split_once('#'))
        .filter(move |(id, _)| *id == frame)
        .map(move |(_, data)| {
            let byte = |place: usize| u8::from_str_radix(data.get(2 * place..2 * place + 2)?, 16).ok();
            let bytes = [byte(2 * word)?, byte(2 * word + 1)?];
            let raw = u16::from_le_bytes(bytes);
            (raw != 0x8000)
                .then(|| if signed { f64::from(i16::from_le_bytes(bytes)) } else { f64::from(raw) })
        })
}
