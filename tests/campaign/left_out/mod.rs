//! What `gripd explain --simulation` says of CommonRoad's single-track model beside real drives, beside the same with an
//! effect that `gripd conceal` put in, and beside drives of that very model with one thing more, or with nothing but noise.

mod by_hand {
    use std::path::{Path, PathBuf};
    use std::process::Command;

    use serde_json::{Value, json};
    use testing::program::{gripd, project};
    use testing::results::Section;

    use crate::found::{findings, held_out, judged, strength, told};
    use crate::{common_road, kept};

    /// The recordings' car.
    const CONFIG: &str = "gti/drives.toml";

    /// Drives on a lot, a minute each.
    const DRIVES: [&str; 3] = ["group8controller", "group4controller", "group11controller"];

    /// More of them: for these only noise is asked of.
    const MORE: [&str; 8] = [
        "group10controller",
        "group12controller",
        "group132020controller",
        "group1controller",
        "group1lookahead",
        "group2controller",
        "group3lookahead",
        "group5controller",
    ];

    /// Effects put into the real drives, as a command line gives them.
    const EFFECTS: [&str; 10] = [
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
    ];

    /// Numbers of the single-track model that are other ones in the recording, and what they are called by right.
    const OTHER_NUMBERS: [(&str, &[&str]); 6] = [
        ("stiffness=18", &["lateral_stiffness_front", "lateral_stiffness_rear"]),
        ("I_z=3900", &["yaw_inertia_kgm2"]),
        ("ratio=13.2", &["sensor_scale:steering_wheel_angle"]),
        ("a=1.29 b=1.34", &["cg_to_front_m"]),
        ("delay=0.08", &["sensor_delay:yaw_rate"]),
        ("relaxation=0.6", &["relaxation_length"]),
    ];

    /// Where the recording comes from.
    #[derive(Clone, Copy, PartialEq)]
    enum Case {
        /// A real drive, with this effect or as it was.
        Real(Option<&'static str>),
        /// The single-track model itself with these numbers.
        Simulated(&'static str),
        /// The same model, with noise of this seed.
        Same(u32),
    }

    /// `LEFT_OUT_PYTHON` is a Python with the package commonroad-vehicle-models. What has an answer in the folder
    /// `LEFT_OUT_ANSWERS` is not asked again. Then
    /// `GRIPD_RENEW=1 cargo test --test campaign by_hand::beside_a_single_track -- --ignored`.
    #[test]
    #[ignore = "by hand: an hour, and what was interrupted goes on"]
    fn beside_a_single_track() {
        let Some(folder) = testing::shared("recordings") else { return };
        let Some(python) = common_road::python("LEFT_OUT_PYTHON") else { return };
        let asks = Asks { folder, python, answers: kept::folder("LEFT_OUT_ANSWERS", "left_out") };
        let mut rows = Vec::new();
        let mut counts = Counts::default();
        let mut add = |row: String| {
            println!("{row}");
            rows.push(row);
        };
        for drive in DRIVES {
            let control = asks.answer(drive, Case::Real(None));
            add(format!("recorded | {drive} | nothing | | | {}", cells(&control)));
            for effect in EFFECTS {
                let answer = asks.answer(drive, Case::Real(Some(effect)));
                if let Some(why) = refused(&answer) {
                    add(format!("recorded | {drive} | {effect} | | refused: {why} | | "));
                    continue;
                }
                let (new, place) = judged(&answer, &control);
                let strength = strength(&answer["truth"]);
                counts.real(strength, place.is_some());
                let held = held_out(&answer["explained"]);
                add(format!(
                    "recorded | {drive} | {effect} | {strength:.1} | {} | {new} | {held}",
                    yes(place.is_some())
                ));
            }
            for (numbers, names) in OTHER_NUMBERS {
                let answer = asks.answer(drive, Case::Simulated(numbers));
                let found = findings(&answer["explained"]);
                let is_named = found.first().is_some_and(|first| names.contains(&first.name().as_str()));
                counts.simulated[0] += 1;
                counts.simulated[1] += usize::from(is_named);
                add(format!("simulated | {drive} | {numbers} | | {} | {}", yes(is_named), cells(&answer)));
            }
        }
        let same = DRIVES
            .iter()
            .flat_map(|drive| [(drive, 2), (drive, 4)])
            .chain(MORE.iter().map(|drive| (drive, 3)));
        for (drive, seed) in same {
            let answer = asks.answer(drive, Case::Same(seed));
            let is_silent =
                answer["explained"]["verdict"] == "adequate" && findings(&answer["explained"]).is_empty();
            counts.same[0] += 1;
            counts.same[1] += usize::from(is_silent);
            add(format!(
                "simulated | {drive} | nothing, noise of seed {seed} | | {} | {}",
                if is_silent { "silent" } else { "no" },
                cells(&answer)
            ));
        }
        add(format!("all | | | | {} | | ", counts.told()));
        Section {
            name: "beside_a_single_track",
            seed: "recorded; noise as told",
            tolerance: 0.1,
            header: "recording | drive | what it has that the simulation has not | strength | named | found (of a recorded drive: \
                     besides what the drive as it was has) | yaw rate held out, %: simulation → with that",
        }
        .check(&rows);
    }

    const fn yes(is: bool) -> &'static str {
        if is { "yes" } else { "no" }
    }

    /// Of what was put in and could be.
    #[derive(Default)]
    struct Counts {
        /// All and named.
        simulated: [usize; 2],
        real: [usize; 2],
        /// Those whose change is at least what the car leaves unexplained.
        strong: [usize; 2],
        /// All and silent.
        same: [usize; 2],
    }

    impl Counts {
        fn real(&mut self, strength: f64, is_named: bool) {
            for of in [&mut self.real, &mut self.strong].into_iter().take(1 + usize::from(strength >= 1.0)) {
                of[0] += 1;
                of[1] += usize::from(is_named);
            }
        }

        fn told(&self) -> String {
            let of = |[all, named]: [usize; 2]| format!("{named} of {all}");
            format!(
                "recorded drives: {}, strength ≥ 1: {}; simulated: {} first; nothing but noise: silent {}",
                of(self.real),
                of(self.strong),
                of(self.simulated),
                of(self.same)
            )
        }
    }

    /// What was found, and what it is good for.
    fn cells(answer: &Value) -> String {
        let found = findings(&answer["explained"]);
        let told: Vec<String> = found.iter().map(told).collect();
        format!("{} | {}", refused(answer).unwrap_or_else(|| told.join("; ")), held_out(&answer["explained"]))
    }

    fn refused(answer: &Value) -> Option<String> {
        let told = answer["refused"].as_str().or_else(|| answer["explained"]["refused"].as_str())?;
        Some(kept::reason(told))
    }

    /// Who asks.
    struct Asks {
        folder: PathBuf,
        python: String,
        answers: PathBuf,
    }

    impl Asks {
        /// The explanation of a drive beside the single-track model, and the truth of what was put in.
        fn answer(&self, drive: &str, case: Case) -> Value {
            let name = match case {
                Case::Real(effect) => format!("real {drive} {}", effect.unwrap_or_default()),
                Case::Simulated(numbers) => format!("simulated {drive} {numbers}"),
                Case::Same(seed) => format!("same {drive} seed {seed}"),
            };
            kept::answer(&kept::file(&self.answers, &name, "json"), || self.asked(drive, case))
        }

        fn asked(&self, drive: &str, case: Case) -> Value {
            let scratch = tempfile::tempdir().unwrap();
            let file = |name: &str| scratch.path().join(name);
            let mut log = self.folder.join(format!("gti/{drive}.log.gz"));
            let mut truth = Value::Null;
            if let Case::Real(Some(effect)) = case {
                let mut command = self.gripd(&["conceal", "--effect", effect]);
                command.arg(&log).arg("-o").arg(file("changed.log")).arg("--truth").arg(file("truth.json"));
                let output = command.output().unwrap();
                let told = String::from_utf8_lossy(&output.stderr);
                match output.status.code() {
                    Some(0) => {}
                    Some(1) => return json!({ "refused": told.trim() }),
                    _ => panic!("{told}"),
                }
                log = file("changed.log");
                truth = serde_json::from_slice(&std::fs::read(file("truth.json")).unwrap()).unwrap();
            }
            let mut command = self.gripd(&["replay"]);
            let samples = file("samples.csv");
            command.arg(&log).arg("--samples").arg(&samples).arg("-o").arg(file("published.log"));
            succeeded(&mut command);
            let model = || {
                let mut command = Command::new(&self.python);
                command.arg(project("tests/campaign/left_out/single_track.py")).arg(&samples);
                command
            };
            succeeded(model().arg(file("simulation.csv")));
            if !matches!(case, Case::Real(_)) {
                let (numbers, seed) = match case {
                    Case::Simulated(numbers) => (numbers, 1),
                    Case::Same(seed) => ("", seed),
                    Case::Real(_) => ("", 0),
                };
                log = file("recorded.log");
                let mut command = model();
                command.arg(file("other.csv")).args(numbers.split_whitespace());
                succeeded(command.arg("--log").arg(&log).args(["--seed", &seed.to_string()]));
            }
            let mut command = self.gripd(&["explain", "--json", "-"]);
            let output = command.arg(&log).arg("--simulation").arg(file("simulation.csv")).output().unwrap();
            if !output.status.success() {
                let told = String::from_utf8_lossy(&output.stderr);
                return json!({ "explained": { "refused": told.trim().lines().last() }, "truth": truth });
            }
            let all: Value = serde_json::from_slice(&output.stdout).unwrap();
            let kept = ["verdict", "findings", "fit", "simulation"];
            let explained: serde_json::Map<String, Value> =
                kept.iter().map(|key| ((*key).to_owned(), all[key].clone())).collect();
            json!({ "explained": explained, "truth": truth })
        }

        fn gripd(&self, arguments: &[&str]) -> Command {
            let mut command = gripd();
            command.arg("-q").args(arguments).arg("-c").arg(self.config());
            command
        }

        fn config(&self) -> PathBuf {
            Path::new(&self.folder).join(CONFIG)
        }
    }

    fn succeeded(command: &mut Command) {
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}
