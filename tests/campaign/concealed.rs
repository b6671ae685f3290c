//! Effects that `gripd conceal` puts into real drives, and what `gripd explain` says of them. The unchanged drive is the
//! control: what it has as well was not put in.

mod by_hand {
    use std::path::{Path, PathBuf};

    use serde_json::{Value, json};
    use testing::program::{gripd, target};
    use testing::results::Section;

    use crate::found::{findings, judged, strength, told};

    /// Configuration and name of each drive, and healthy drives of the same car on the same road: two on a lot, which turn
    /// to the left only, and a lap that is the only one of its kind.
    const DRIVES: [(&str, &str, &[&str]); 3] = [
        (
            "gti/drives.toml",
            "gti/group8controller",
            &["group4controller", "group1controller", "group10controller"],
        ),
        (
            "gti/drives.toml",
            "gti/group4controller",
            &["group8controller", "group1controller", "group10controller"],
        ),
        ("gti/laps.toml", "gti/dry4", &[]),
    ];

    /// Healthy drives of the car; each is asked what it has that the next three have not.
    const HEALTHY: [&str; 14] = [
        "group8controller",
        "group4controller",
        "group1controller",
        "group10controller",
        "group11controller",
        "group12controller",
        "group2controller",
        "group5controller",
        "group1lookahead",
        "group3lookahead",
        "group5lookahead",
        "group7lookahead",
        "group10lookahead",
        "group132020controller",
    ];

    /// Effects as a command line gives them.
    const EFFECTS: [&str; 13] = [
        "kind = 'tire_radius', relative_difference_rl = -0.015",
        "kind = 'sensor_bias', channel = 'yaw_rate', bias = 0.03, at_s = 30",
        "kind = 'sensor_scale', channel = 'yaw_rate', relative_error = 0.06",
        "kind = 'sensor_delay', channel = 'yaw_rate', delay_s = 0.08",
        "kind = 'relaxation_length', length_m = 1.5",
        "kind = 'friction_change', friction = 0.65, intervals = [[25, 40]]",
        "kind = 'steering_ratio', curvature_per_rad2 = 0.05",
        "kind = 'accelerometer_position', forward_of_cg_m = 1.0",
        "kind = 'payload', mass_kg = 350, position_behind_cg_m = 1.2",
        "kind = 'steering_compliance', compliance_rad_per_nm = 4e-4",
        "kind = 'crosswind', force_rms_n = 600",
        "kind = 'road_bank', bank_rms_rad = 0.04",
        "kind = 'cg_shift', shift_m = 0.12, at_s = 30",
    ];

    /// Drives with answers that are there already are not asked of again: `CONCEALED_ANSWERS` names another folder for
    /// them, as after a change of the program. Then
    /// `GRIPD_RENEW=1 cargo test --test campaign by_hand::concealed_by_gripd -- --ignored`.
    #[test]
    #[ignore = "by hand: half an hour, and what was interrupted goes on"]
    fn concealed_by_gripd() {
        let Some(folder) = testing::shared("recordings") else { return };
        let answers = folder_of_answers();
        let mut rows = Vec::new();
        let mut counts = [Counts::default(), Counts::default()];
        for (config, drive, references) in DRIVES {
            let ask =
                |effect, references| answer(&folder, &answers, config, drive, effect, references).unwrap();
            let controls =
                [ask(None, &[]), if references.is_empty() { Value::Null } else { ask(None, references) }];
            for effect in EFFECTS {
                let alone = match answer(&folder, &answers, config, drive, Some(effect), &[]) {
                    Ok(alone) => alone,
                    Err(reason) => {
                        rows.push(format!("{drive} | {effect} | – | | | | refused: {reason}"));
                        continue;
                    }
                };
                let strength = strength(&alone["truth"]);
                let of_alone = counts[0].judge(strength, &alone, &controls[0]);
                let of_both = if references.is_empty() {
                    ["–".to_owned(), String::new()]
                } else {
                    counts[1].judge(strength, &ask(Some(effect), references), &controls[1])
                };
                let row = format!(
                    "{drive} | {effect} | {strength:.2} | {} | {}",
                    of_alone.join(" | "),
                    of_both.join(" | ")
                );
                println!("{row}");
                rows.push(row);
            }
        }
        let [alone, both] = counts.map(|counts| counts.told());
        rows.push(format!("all | | | {alone} | | {both} | "));
        Section {
            name: "concealed_by_gripd",
            seed: "recorded; courses of seed 1",
            tolerance: 0.1,
            header: "drive | put in | strength | alone: named | found besides what the control has | \
                     beside three references: named | found besides what the control has",
        }
        .check(&rows);
    }

    /// What healthy drives are said to have that other healthy drives have not.
    #[test]
    #[ignore = "by hand: ten minutes, and what was interrupted goes on"]
    fn healthy_beside_healthy() {
        let Some(folder) = testing::shared("recordings") else { return };
        let answers = folder_of_answers();
        let mut rows = Vec::new();
        for (place, drive) in HEALTHY.into_iter().enumerate() {
            let references: Vec<&str> = (1..=3).map(|by| HEALTHY[(place + by) % HEALTHY.len()]).collect();
            let answer =
                answer(&folder, &answers, "gti/drives.toml", &format!("gti/{drive}"), None, &references)
                    .unwrap();
            let found = findings(&answer["explained"]);
            let verdict = answer["explained"]["verdict"].as_str().unwrap_or_default();
            rows.push(format!(
                "{drive} | {verdict} | {}",
                found.iter().map(told).collect::<Vec<_>>().join("; ")
            ));
        }
        let changed = rows.iter().filter(|row| !row.contains("| unchanged |")).count();
        rows.push(format!("all {} | {changed} changed | ", HEALTHY.len()));
        Section {
            name: "healthy_beside_healthy",
            seed: "recorded",
            tolerance: 0.1,
            header: "drive | beside the next three | found",
        }
        .check(&rows);
    }

    fn folder_of_answers() -> PathBuf {
        let answers =
            std::env::var_os("CONCEALED_ANSWERS").map_or_else(|| target("concealed_real"), PathBuf::from);
        std::fs::create_dir_all(&answers).unwrap();
        answers
    }

    /// How many were put in, named first, and named at all; and of those whose change is at least what is left unexplained.
    #[derive(Default)]
    struct Counts {
        all: [usize; 3],
        strong: [usize; 3],
    }

    impl Counts {
        /// How it is named, and what was found.
        fn judge(&mut self, strength: f64, changed: &Value, control: &Value) -> [String; 2] {
            let (found, place) = judged(changed, control);
            let is_named = [true, place == Some(0), place.is_some()];
            for (number, is) in is_named.into_iter().enumerate() {
                self.all[number] += usize::from(is);
                self.strong[number] += usize::from(is && strength >= 1.0);
            }
            let named = match place {
                Some(0) => "first",
                Some(_) => "yes",
                None => "no",
            };
            [named.into(), found]
        }

        fn told(&self) -> String {
            let of = |[all, first, named]: [usize; 3]| format!("{first} first, {named} at all of {all}");
            format!("{}; strength ≥ 1: {}", of(self.all), of(self.strong))
        }
    }

    /// Truth and explanation of a drive, with an effect or without; why it cannot have it.
    fn answer(
        folder: &Path,
        answers: &Path,
        config: &str,
        drive: &str,
        effect: Option<&str>,
        references: &[&str],
    ) -> Result<Value, String> {
        let name: String = format!("{drive} {} {}", effect.unwrap_or("control"), references.join(" "))
            .trim()
            .chars()
            .map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' })
            .collect();
        let kept = answers.join(format!("{name}.json"));
        if let Some(answer) = std::fs::read(&kept).ok().and_then(|text| serde_json::from_slice(&text).ok()) {
            return Ok(answer);
        }
        let (config, log) = (folder.join(config), folder.join(format!("{drive}.log.gz")));
        let scratch = tempfile::tempdir().unwrap();
        let (changed, truth) = (scratch.path().join("changed.log"), scratch.path().join("truth.json"));
        if let Some(effect) = effect {
            let mut command = gripd();
            command.args(["-q", "conceal", "--effect", effect, "-c"]).arg(&config).arg(&log);
            let output = command.arg("-o").arg(&changed).arg("--truth").arg(&truth).output().unwrap();
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            match output.status.code() {
                Some(0) => {}
                Some(1) => {
                    return Err(told
                        .rsplit_once(".log.gz: ")
                        .map_or(told.clone(), |(_, why)| why.trim().into()));
                }
                _ => panic!("{told}"),
            }
        }
        let mut command = gripd();
        command.args(["-q", "explain", "--json", "-", "-c"]).arg(&config);
        for reference in references {
            command.arg("--reference").arg(log.with_file_name(format!("{reference}.log.gz")));
        }
        let output = command.arg(if effect.is_some() { &changed } else { &log }).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let explained: Value = serde_json::from_slice(&output.stdout).unwrap();
        // Traces and courses are many, and not looked at.
        let explained = json!({ "verdict": explained["verdict"], "findings": explained["findings"] });
        let truth = std::fs::read(&truth).ok().and_then(|text| serde_json::from_slice::<Value>(&text).ok());
        let answer = json!({ "explained": explained, "truth": truth });
        std::fs::write(&kept, answer.to_string()).unwrap();
        Ok(answer)
    }
}
