//! Effects that `gripd conceal` puts into real drives, and what `gripd explain` says of them. The unchanged drive is the
//! control: what it has as well was not put in.

mod by_hand {
    use std::collections::BTreeMap;
    use std::path::{Path, PathBuf};

    use serde_json::{Value, json};
    use testing::program::{gripd, target};
    use testing::results::Section;

    /// Configuration and name of each drive: two on a lot, which turn to the left only, and a lap.
    const DRIVES: [(&str, &str); 3] = [
        ("gti/drives.toml", "gti/group8controller"),
        ("gti/drives.toml", "gti/group4controller"),
        ("gti/laps.toml", "gti/dry4"),
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

    /// A finding, as far as it is looked at.
    struct Found {
        effect: String,
        channel: Option<String>,
        kind: String,
        numbers: BTreeMap<String, (f64, f64)>,
    }

    /// Drives with answers that are there already are not asked of again: `CONCEALED_ANSWERS` names another folder for
    /// them, as after a change of the program. Then
    /// `GRIPD_RENEW=1 cargo test --test campaign by_hand::concealed_by_gripd -- --ignored`.
    #[test]
    #[ignore = "by hand: twenty minutes, and what was interrupted goes on"]
    fn concealed_by_gripd() {
        let Some(folder) = testing::shared("recordings") else { return };
        let answers =
            std::env::var_os("CONCEALED_ANSWERS").map_or_else(|| target("concealed_real"), PathBuf::from);
        std::fs::create_dir_all(&answers).unwrap();
        let mut rows = Vec::new();
        let (mut first, mut at_all, mut all) = (0, 0, 0);
        for (config, drive) in DRIVES {
            let control = answer(&folder, &answers, config, drive, None).unwrap();
            for effect in EFFECTS {
                let row = match answer(&folder, &answers, config, drive, Some(effect)) {
                    Err(reason) => format!("{drive} | {effect} | – | – | – | – | refused: {reason} | "),
                    Ok(changed) => {
                        let (row, place) = judged(drive, effect, &changed, &control);
                        (first, at_all) =
                            (first + usize::from(place == Some(0)), at_all + usize::from(place.is_some()));
                        all += 1;
                        row
                    }
                };
                println!("{row}");
                rows.push(row);
            }
        }
        rows.push(format!("all {all} | | | {first} | {at_all} | | | "));
        Section {
            name: "concealed_by_gripd",
            seed: "recorded; courses of seed 1",
            tolerance: 0.1,
            header: "drive | put in | strength | named first | named at all | verdict | found besides what the control has | \
                     the control has",
        }
        .check(&rows);
    }

    /// The row, and where the effect stands among what the control has not.
    fn judged(drive: &str, effect: &str, changed: &Value, control: &Value) -> (String, Option<usize>) {
        let [found, known] = [changed, control].map(|answer| findings(&answer["explained"]));
        let new: Vec<&Found> =
            found.iter().filter(|one| known.iter().all(|other| is_other(one, other))).collect();
        let truth = &changed["truth"]["effects"][0];
        let is_it = |one: &&Found| {
            truth["effect"] == one.effect && truth["channel"].as_str() == one.channel.as_deref()
        };
        let place = new.iter().position(is_it);
        let yes = |is: bool| if is { "yes" } else { "no" };
        let words = |all: &mut dyn Iterator<Item = &Found>| all.map(told).collect::<Vec<_>>().join("; ");
        let own = known.iter().filter(|one| one.effect == truth["effect"].as_str().unwrap_or_default());
        let row = format!(
            "{drive} | {effect} | {:.2} | {} | {} | {} | {} | {}",
            strength(&changed["truth"]),
            yes(place == Some(0)),
            yes(place.is_some()),
            changed["explained"]["verdict"].as_str().unwrap_or_default(),
            words(&mut new.iter().copied()),
            words(&mut own.into_iter()),
        );
        (row, place)
    }

    /// How large the change is in the channel where it is largest beside what the ordinary car leaves there.
    fn strength(truth: &Value) -> f64 {
        let channels = truth["channels"].as_object().into_iter().flatten();
        channels.filter_map(|(_, channel)| channel["strength"].as_f64()).fold(0.0, f64::max)
    }

    /// Is it another effect, or the same of another size?
    fn is_other(one: &Found, other: &Found) -> bool {
        if (&one.effect, &one.channel) != (&other.effect, &other.channel) {
            return true;
        }
        one.numbers.iter().any(|(name, (value, std))| match other.numbers.get(name) {
            Some((before, deviation)) => (value - before).abs() > 2.0 * std.hypot(*deviation),
            None => true,
        })
    }

    fn findings(explained: &Value) -> Vec<Found> {
        let of = |finding: &Value| {
            let numbers =
                finding["parameters"].as_object().into_iter().flatten().filter_map(|(name, number)| {
                    Some((name.clone(), (number["value"].as_f64()?, number["std"].as_f64()?)))
                });
            Found {
                effect: finding["effect"].as_str().unwrap_or_default().to_owned(),
                channel: finding["channel"].as_str().map(str::to_owned),
                kind: finding["kind"].as_str().unwrap_or_default().to_owned(),
                numbers: numbers.collect(),
            }
        };
        explained["findings"].as_array().into_iter().flatten().map(of).collect()
    }

    fn told(found: &Found) -> String {
        let channel = found.channel.as_ref().map_or(String::new(), |channel| format!(" of {channel}"));
        let numbers =
            found.numbers.iter().map(|(name, (value, std))| format!("{name} {value:.4} ± {std:.4}"));
        format!("{}{channel} ({}; {})", found.effect, found.kind, numbers.collect::<Vec<_>>().join(", "))
    }

    /// Truth and explanation of a drive, with an effect or without; why it cannot have it.
    fn answer(
        folder: &Path,
        answers: &Path,
        config: &str,
        drive: &str,
        effect: Option<&str>,
    ) -> Result<Value, String> {
        let name: String = format!("{drive} {}", effect.unwrap_or("control"))
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
