//! The ordinary car on real drives, beside the yardstick that comes with them: how well it predicts what was held out.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use testing::program::gripd;
use testing::results::Section;
use testing::setting::setting;

/// `gripd identify --method ordinary`, as JSON.
fn identified(config: &Path, logs: &[PathBuf]) -> Value {
    let mut command = gripd();
    let output =
        command.args(["-q", "identify", "--method", "ordinary", "--json", "-", "-c"]).arg(config).args(logs);
    let output = output.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn held_out(answer: &Value, channel: &str) -> f64 {
    answer["fit"]["holdout"][channel].as_f64().unwrap_or(f64::NAN)
}

/// The Python that runs the tools of the recordings, which need numpy and more.
pub fn yardstick_python() -> String {
    setting("YARDSTICK_PYTHON", "python3".into())
}

/// The recordings of a configuration that comes with them. A group's drive of the GTI belongs to drives.toml, a lap to laps.toml.
pub fn logs_of(config: &Path) -> Vec<PathBuf> {
    let folder = config.parent().unwrap();
    let is_lap = |log: &PathBuf| !log.file_name().unwrap().to_string_lossy().starts_with("group");
    let mut logs = testing::recordings_in(folder);
    logs.retain(|log| !folder.ends_with("gti") || is_lap(log) == config.ends_with("laps.toml"));
    logs
}

#[test]
fn a_drive_in_circles_is_predicted_by_steering_and_speed() {
    let Some(folder) = testing::shared("recordings") else { return };
    let log = folder.join("gti/group1controller.log.gz");
    let answer = identified(&folder.join("gti/drives.toml"), &[log]);
    // A plain bicycle reaches 95.7 and 50.8.
    assert!(held_out(&answer, "yaw_rate") > 96.2, "{}", answer["fit"]);
    assert!(held_out(&answer, "lateral_acceleration") > 50.8, "{}", answer["fit"]);
}

mod by_hand {
    use super::*;

    /// What the yardstick says of a drive: fits of yaw rate and lateral acceleration, deviation of the sideslip, degrees.
    /// Not a number without a Python that has numpy, scipy, numba and pandas (named by `YARDSTICK_PYTHON`).
    fn yardstick(folder: &Path, config: &Path, log: &Path) -> [f64; 3] {
        let mut command = Command::new(yardstick_python());
        command.arg(folder.join("tools/bicycle.py")).args([config, log]);
        command.arg("--truth").arg(log.parent().unwrap().join("truth"));
        let output = command.output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        ["yaw rate", "lateral acceleration", "sideslip rms"].map(|what| {
            let (_, rest) = text.split_once(what).unwrap_or_default();
            rest.split_whitespace().next().and_then(|number| number.parse().ok()).unwrap_or(f64::NAN)
        })
    }

    /// Deviation of the sideslip from the truth beside a recording above 5 m/s, degrees.
    fn sideslip(answer: &Value, log: &Path) -> f64 {
        let name = log.file_name().unwrap().to_string_lossy().replace(".log.gz", ".truth.csv.gz");
        let Ok(file) = std::fs::File::open(log.parent().unwrap().join("truth").join(name)) else {
            return f64::NAN;
        };
        let text = std::io::read_to_string(flate2::read::MultiGzDecoder::new(file)).unwrap();
        let mut lines = text.lines();
        let header: Vec<&str> = lines.next().unwrap().split(',').collect();
        let places = ["t", "vx", "vy"].map(|name| header.iter().position(|column| *column == name).unwrap());
        let row = |line: &str| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
            places.map(|place| cells[place])
        };
        let truth: Vec<[f64; 3]> =
            lines.map(row).filter(|row| row.iter().all(|cell| cell.is_finite())).collect();
        let (mut sum, mut count) = (0.0, 0.0);
        for point in answer["sideslip"].as_object().unwrap().values().flat_map(|all| all.as_array().unwrap())
        {
            let (t, slip) = (point[0].as_f64().unwrap(), point[1].as_f64().unwrap());
            let place = truth.partition_point(|row| row[0] < t).min(truth.len() - 1);
            let [_, vx, vy] = truth[place];
            if vx > 5.0 {
                sum += (slip - vy.atan2(vx)).powi(2);
                count += 1.0;
            }
        }
        f64::sqrt(sum / count).to_degrees()
    }

    /// The table of the guide's results. `GRIPD_RENEW=1 YARDSTICK_PYTHON=… cargo test --release --test campaign
    /// by_hand::free_runs_beside_the_yardstick -- --ignored`.
    #[test]
    #[ignore = "by hand: ten minutes, and Python with numba for the yardstick"]
    fn free_runs_beside_the_yardstick() {
        let Some(folder) = testing::shared("recordings") else { return };
        let mut rows = Vec::new();
        for config in
            ["gti/drives.toml", "gti/laps.toml", "tts/car.toml", "gti_payload/car.toml", "av21/car.toml"]
        {
            let config = folder.join(config);
            let mut logs = logs_of(&config);
            // Two laps have another drive's steering.
            logs.retain(|log| {
                let name = log.file_name().unwrap().to_string_lossy();
                !name.starts_with("dry1") && !name.starts_with("wet2")
            });
            for log in logs {
                let answer = identified(&config, std::slice::from_ref(&log));
                let [yaw, lateral, slip] = yardstick(&folder, &config, &log);
                let own = [held_out(&answer, "yaw_rate"), held_out(&answer, "lateral_acceleration")];
                let number = |value: f64, digits: usize| {
                    if value.is_finite() { format!("{value:.digits$}") } else { "–".into() }
                };
                let place = log.strip_prefix(&folder).unwrap().display().to_string();
                let row = format!(
                    "{} | {} | {} | {} | {} | {} | {}",
                    place.replace(".log.gz", ""),
                    number(yaw, 1),
                    number(own[0], 1),
                    number(lateral, 1),
                    number(own[1], 1),
                    number(slip, 2),
                    number(sideslip(&answer, &log), 2),
                );
                println!("{row}");
                rows.push(row);
            }
        }
        let section = Section {
            name: "free_runs",
            seed: "recorded",
            tolerance: 0.02,
            header: "drive | bicycle: yaw rate | gripd: yaw rate | bicycle: lateral acceleration | gripd: lateral \
                     acceleration | bicycle: sideslip, ° | gripd: sideslip, °",
        };
        section.check(&rows);
    }

    /// The car's numbers by two halves of the drives, by name: values and deviations.
    fn halves(folder: &Path, in_first: impl Fn(usize) -> bool) -> BTreeMap<String, [(f64, f64); 2]> {
        let config = folder.join("drives.toml");
        let logs = logs_of(&config);
        let half = |first: bool| -> Vec<PathBuf> {
            let kept = logs.iter().enumerate().filter(|(place, _)| in_first(*place) == first);
            kept.map(|(_, log)| log.clone()).collect()
        };
        let [first, second] = [true, false].map(|first| {
            let answer = identified(&config, &half(first));
            answer["parameters"].as_object().unwrap().clone()
        });
        let number = |of: &Value| Some((of["value"].as_f64()?, of["std"].as_f64()?));
        let both =
            |(name, one): (&String, &Value)| Some((name.clone(), [number(one)?, number(second.get(name)?)?]));
        first.iter().filter_map(both).collect()
    }

    /// Do drives of one car say the same of it? `GRIPD_RENEW=1 cargo test --release --test campaign
    /// by_hand::halves_of_the_drives_beside_each_other -- --ignored`.
    #[test]
    #[ignore = "by hand: two minutes"]
    fn halves_of_the_drives_beside_each_other() {
        let Some(folder) = testing::shared("recordings/gti") else { return };
        let mut rows = Vec::new();
        for (name, bits) in [
            ("every second drive", 0b01_0101_0101_0101_u32),
            ("the first and the last seven", 0b00_0000_0111_1111),
            ("by pairs", 0b11_0011_0011_0010),
            ("by threes", 0b01_1100_0111_0010),
        ] {
            let numbers = halves(&folder, |place| bits >> place & 1 == 1);
            let apart = |[one, other]: &[(f64, f64); 2]| (one.0 - other.0) / one.1.hypot(other.1);
            for (name, both) in &numbers {
                println!("{name}: {both:?}, {:.2}", apart(both));
            }
            let square: f64 = numbers.values().map(|both| apart(both).powi(2)).sum();
            let furthest =
                |a: &[(f64, f64); 2], b: &[(f64, f64); 2]| apart(a).abs().total_cmp(&apart(b).abs());
            let (worst, both) = numbers.iter().max_by(|a, b| furthest(a.1, b.1)).unwrap();
            let row = format!(
                "{name} | {} | {:.1} | {worst} | {:.3} ± {:.3} | {:.3} ± {:.3}",
                numbers.len(),
                square / numbers.len() as f64,
                both[0].0,
                both[0].1,
                both[1].0,
                both[1].1
            );
            println!("{row}");
            rows.push(row);
        }
        let section = Section {
            name: "halves",
            seed: "recorded",
            tolerance: 0.1,
            header: "14 drives of a GTI, halves | numbers of the car | χ² per number | furthest apart | by one half | by the \
                     other",
        };
        section.check(&rows);
    }
}
