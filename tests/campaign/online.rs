//! What the service says of real drives, by the score that comes with them: a table of the guide's results.

use std::process::Command;

use super::free_runs::{logs_of, yardstick_python};
use testing::program::gripd;
use testing::results::Section;

/// A drive's cells of the score: all numbers of its line, in their order; nothing for what is not there.
fn cells(line: &str) -> Vec<String> {
    let words = line.split([' ', '|', '%']).filter(|word| !["", "deg", "of", "changes"].contains(word));
    words.map(|word| if word == "nan" { "–".into() } else { word.into() }).collect()
}

#[test]
fn a_line_of_the_score_has_its_numbers_in_their_order() {
    let line = "dry4   47 |   83%   0.77   1.50 deg |     0%   0.0%   0.0%   nan of 1.01 |  19.8  36.4    0% 2 changes |";
    assert_eq!(cells(line).join(" "), "dry4 47 83 0.77 1.50 0 0.0 0.0 – 1.01 19.8 36.4 0 2");
}

mod by_hand {
    use super::*;

    /// `GRIPD_RENEW=1 YARDSTICK_PYTHON=… cargo test --release --test campaign by_hand::real_drives_by_the_score -- --ignored`.
    #[test]
    #[ignore = "by hand: half a minute, and Python with pandas for the score"]
    fn real_drives_by_the_score() {
        let Some(folder) = testing::shared("recordings") else { return };
        let python = yardstick_python();
        let mut rows = Vec::new();
        for config in [
            "gti/drives.toml",
            "gti/laps.toml",
            "tts/car.toml",
            "gti_payload/car.toml",
            "av21/car.toml",
            "zoe/car.toml",
        ] {
            let config = folder.join(config);
            let own = config.parent().unwrap();
            for log in logs_of(&config) {
                let mut score = Command::new(&python);
                score
                    .arg(folder.join("tools/score_real.py"))
                    .arg(gripd().get_program())
                    .arg(&config)
                    .arg(&log);
                let output = score.arg("--truth").arg(own.join("truth")).output().unwrap();
                let text = String::from_utf8_lossy(&output.stdout).into_owned();
                let found = cells(text.lines().nth(1).unwrap_or_default());
                let [_, numbers @ ..] = &found[..] else {
                    panic!("{}: {text}{}", log.display(), String::from_utf8_lossy(&output.stderr))
                };
                let place = log.strip_prefix(&folder).unwrap().display().to_string();
                let row = format!("{} | {}", place.replace(".log.gz", ""), numbers.join(" | "));
                println!("{row}");
                rows.push(row);
            }
        }
        let section = Section {
            name: "online",
            seed: "recorded",
            tolerance: 0.02,
            header: "drive | s above 5 m/s | motion valid, % | sideslip off where valid, ° rms | where given | friction bounded, % \
                     of the time | valid | excluded | value | most used | cornering stiffness front, median | rear | valid, % | \
                     changes of surface",
        };
        section.check(&rows);
    }
}
