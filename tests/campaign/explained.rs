//! What `gripd explain` says of real drives, and of the same drives with one effect put into them by the tool that comes
//! with the recordings, which has equations of its own. The unchanged drive is the control.

use std::path::Path;

use serde_json::Value;
use testing::program::gripd;

/// The answer, as JSON.
fn explained(config: &Path, log: &Path) -> Value {
    let mut command = gripd();
    command.args(["-q", "explain", "--json", "-", "-c"]).arg(config).arg(log);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Its findings of this kind: name, channel, main number.
fn findings(answer: &Value, kind: &str) -> Vec<String> {
    let all = answer["findings"].as_array().unwrap().iter().filter(|finding| finding["kind"] == kind);
    let name = |finding: &Value| {
        let channel = finding["channel"].as_str().map_or(String::new(), |channel| format!(" of {channel}"));
        let numbers = finding["parameters"].as_object().unwrap().iter();
        let numbers: Vec<String> = numbers
            .filter(|(name, _)| !name.contains("roll_damping") && !name.contains("frequency"))
            .map(|(name, number)| {
                let (value, std) = (number["value"].as_f64().unwrap(), number["std"].as_f64().unwrap());
                format!("{name} {value:.3} ± {std:.3}")
            })
            .collect();
        format!("{}{channel} ({})", finding["effect"].as_str().unwrap(), numbers.join(", "))
    };
    all.map(name).collect()
}

/// GIVEN a real drive of a minute WHEN it is explained THEN the answer is a car with what every car has, which predicts
/// driving that it was not fitted to.
#[test]
#[ignore = "long: half a minute"]
fn a_real_drive_is_an_ordinary_car() {
    let Some(folder) = testing::shared("recordings") else { return };
    let answer = explained(&folder.join("gti/drives.toml"), &folder.join("gti/group8controller.log.gz"));
    assert_eq!(answer["verdict"], "adequate", "{}", answer["findings"]);
    assert!(findings(&answer, "unusual").is_empty(), "{}", answer["findings"]);
    // Tires of passenger cars need 0.2 to 0.7 m.
    let usual = answer["findings"].as_array().unwrap();
    let relaxation = usual.iter().find(|finding| finding["effect"] == "relaxation_length").unwrap();
    let length = relaxation["parameters"]["length_m"]["value"].as_f64().unwrap();
    assert!((0.2..0.7).contains(&length) && relaxation["kind"] == "ordinary", "{relaxation}");
    let fit = |model: &str| answer["fit"][model]["holdout"]["yaw_rate"].as_f64().unwrap();
    assert!(fit("extended") > 96.2 && fit("extended") >= fit("baseline"), "{}", answer["fit"]);
}

mod by_hand {
    use std::path::PathBuf;
    use std::process::Command;

    use testing::results::Section;

    use super::*;

    /// Configuration and name of each real drive.
    const DRIVES: [(&str, &str); 19] = [
        ("gti/drives.toml", "gti/group10controller"),
        ("gti/drives.toml", "gti/group10lookahead"),
        ("gti/drives.toml", "gti/group11controller"),
        ("gti/drives.toml", "gti/group12controller"),
        ("gti/drives.toml", "gti/group132020controller"),
        ("gti/drives.toml", "gti/group1controller"),
        ("gti/drives.toml", "gti/group1lookahead"),
        ("gti/drives.toml", "gti/group2controller"),
        ("gti/drives.toml", "gti/group3lookahead"),
        ("gti/drives.toml", "gti/group4controller"),
        ("gti/drives.toml", "gti/group5controller"),
        ("gti/drives.toml", "gti/group5lookahead"),
        ("gti/drives.toml", "gti/group7lookahead"),
        ("gti/drives.toml", "gti/group8controller"),
        ("gti/laps.toml", "gti/wet1"),
        ("gti/laps.toml", "gti/dry4"),
        ("tts/car.toml", "tts/aa"),
        ("tts/car.toml", "tts/ad"),
        ("gti_payload/car.toml", "gti_payload/pid"),
    ];

    /// The table of the guide's results: `GRIPD_RENEW=1 cargo test --test campaign by_hand::real_drives_explained --
    /// --ignored`.
    #[test]
    #[ignore = "by hand: ten minutes"]
    fn real_drives_explained() {
        let Some(folder) = testing::shared("recordings") else { return };
        let row = |(config, name): (&str, &str)| {
            let answer = explained(&folder.join(config), &folder.join(format!("{name}.log.gz")));
            let fit = |model: &str| answer["fit"][model]["holdout"]["yaw_rate"].as_f64().unwrap_or(f64::NAN);
            let row = format!(
                "{name} | {} | {} | {} | {} | {:.1} | {:.1}",
                answer["verdict"].as_str().unwrap(),
                findings(&answer, "unusual").join("; "),
                findings(&answer, "measurement").join("; "),
                findings(&answer, "ordinary").join("; "),
                fit("baseline"),
                fit("extended"),
            );
            println!("{row}");
            row
        };
        let rows: Vec<String> = DRIVES.into_iter().map(row).collect();
        Section {
            name: "explained",
            seed: "recorded",
            tolerance: 0.1,
            header: "drive | verdict | unusual | measurement | what every car has | yaw rate held out, %: plain | found",
        }
        .check(&rows);
    }

    /// Effects as the tool calls them, and their names here; as strong as what a bicycle leaves.
    const CONCEALED: [(&str, &str, &str); 12] = [
        ("gti/group8controller", "tire_radius wheel=2 relative=-0.015", "tire_radius"),
        ("gti/group8controller", "sensor_bias channel=yaw_rate bias=0.03 from=30", "sensor_bias"),
        ("gti/group8controller", "sensor_scale channel=yaw_rate relative=0.06", "sensor_scale"),
        ("gti/group8controller", "relaxation_length length=1.5", "relaxation_length"),
        ("gti/group8controller", "friction_change factor=0.6 from=25 to=40", "friction_change"),
        ("gti/group8controller", "steering_ratio curvature=0.05", "steering_ratio"),
        ("gti/group8controller", "accelerometer_position ahead=1.0", "accelerometer_position"),
        ("gti/group8controller", "payload mass=350 behind=1.2", "payload"),
        ("gti/group8controller", "steering_compliance rad_per_kn=0.006", "steering_compliance"),
        ("gti/dry4", "tire_radius wheel=1 relative=-0.015", "tire_radius"),
        ("gti/dry4", "friction_change factor=0.7 from=30 to=60", "friction_change"),
        ("gti/wet1", "sensor_bias channel=yaw_rate bias=0.02 from=40", "sensor_bias"),
    ];

    /// `GRIPD_RENEW=1 YARDSTICK_PYTHON=… cargo test --test campaign by_hand::concealed_in_real_drives -- --ignored`.
    #[test]
    #[ignore = "by hand: ten minutes, and Python with numba for the tool that conceals"]
    fn concealed_in_real_drives() {
        let Some(folder) = testing::shared("recordings") else { return };
        let python = std::env::var("YARDSTICK_PYTHON").unwrap_or_else(|_| "python3".into());
        let scratch = tempfile::tempdir().unwrap();
        let row = |(drive, effect, own): (&str, &str, &str)| {
            let config = DRIVES.into_iter().find(|(_, name)| *name == drive).unwrap().0;
            let (config, log) = (folder.join(config), folder.join(format!("{drive}.log.gz")));
            let changed: PathBuf = scratch.path().join("changed.log.gz");
            let output = Command::new(&python)
                .arg(folder.join("tools/conceal.py"))
                .args([&config, &log, &changed])
                .args(effect.split(' '))
                .output()
                .unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let [with, without] = [&changed, &log].map(|log| explained(&config, log));
            let told = |answer: &Value| {
                let kinds = ["unusual", "measurement", "ordinary"];
                kinds.iter().flat_map(|kind| findings(answer, kind)).collect::<Vec<_>>()
            };
            let place = |all: &[String]| all.iter().position(|finding| finding.starts_with(own));
            let number = |place: Option<usize>| place.map_or("–".into(), |place| (place + 1).to_string());
            let (with, without) = (told(&with), told(&without));
            let found = place(&with).map_or(String::new(), |place| with[place].clone());
            let row = format!(
                "{drive} | {effect} | {} | {} | {found}",
                number(place(&with)),
                number(place(&without))
            );
            println!("{row}   {with:?} {without:?}");
            row
        };
        let rows: Vec<String> = CONCEALED.into_iter().map(row).collect();
        Section {
            name: "concealed_real",
            seed: "recorded",
            tolerance: 0.1,
            header: "drive | put in | named as number | in the unchanged drive | found",
        }
        .check(&rows);
    }
}
