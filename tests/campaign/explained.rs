//! What `gripd explain` says of real drives.

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

/// The project's own configuration of that car.
const RAV4: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/config/rav4.toml");

/// GIVEN a minute of a RAV4 on a public road, whose bus has no torque WHEN it is explained THEN its hills are named with their
/// course: down for 24 s, up for 17, level after that; and they predict what was held out.
#[test]
#[ignore = "long: ten seconds"]
fn the_rav4s_minute_has_hills() {
    let Some(folder) = testing::shared("recordings") else { return };
    let answer = explained(Path::new(RAV4), &folder.join("rav4/bus0.log.gz"));
    assert_eq!(answer["verdict"], "missing_physics");
    let grade = &answer["findings"][0];
    assert_eq!(grade["effect"], "road_grade", "{}", answer["findings"]);
    assert_eq!(grade["indistinguishable_from"][0], "sensor_drift:longitudinal_acceleration");
    let numbers = |name: &str| -> Vec<f64> {
        grade["series"][name].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
    };
    let (t, value) = (numbers("t"), numbers("value"));
    let mean = |from: f64, to: f64| {
        let there = t.iter().zip(&value).filter(|(t, _)| (from..to).contains(*t)).map(|(_, value)| *value);
        let there: Vec<f64> = there.collect();
        there.iter().sum::<f64>() / there.len() as f64
    };
    let [down, up, level] = [mean(5.0, 20.0), mean(28.0, 38.0), mean(44.0, 54.0)];
    assert!(up - down > 0.05 && (down + 0.02..up - 0.02).contains(&level), "{down} {level} {up}");
    let error =
        |model: &str| answer["error"][model]["holdout"]["longitudinal_acceleration"].as_f64().unwrap();
    assert!(error("extended") < 0.5 * error("baseline"), "{}", answer["error"]);
}

mod by_hand {
    use testing::results::Section;

    use super::*;

    /// Configuration and name of each real drive.
    const DRIVES: [(&str, &str); 20] = [
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
        (RAV4, "rav4/bus0"),
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
}
