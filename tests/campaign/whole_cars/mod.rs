//! What `gripd explain` says of whole cars by another author: CommonRoad's multi-body car with one unusual thing in it, or with
//! nothing but what every car has.

mod by_hand {
    use std::path::PathBuf;
    use std::process::Command;

    use serde_json::{Value, json};
    use testing::program::{gripd, project};
    use testing::results::Section;

    use crate::found::{Found, findings, held_out, told};
    use crate::{common_road, kept};

    /// The package's cars, in the order in which they are asked: BMW 320i, VW Vanagon, Ford Escort.
    const VEHICLES: [usize; 3] = [2, 3, 1];

    /// Ways to drive.
    const SCENARIOS: [&str; 4] = ["mixed", "slalom", "hard", "highway"];

    /// What is put in, as the simulator's command line gives it, what it is called by right, and the scenario that can show
    /// it, for each vehicle.
    const CAUSES: [(&str, &str, [&str; 3]); 12] = [
        ("tire_radius_rl=-0.007", "tire_radius", ["highway", "mixed", "slalom"]),
        ("yaw_delay=0.05", "sensor_delay:yaw_rate", ["slalom", "hard", "mixed"]),
        ("yaw_scale=0.05", "sensor_scale:yaw_rate", ["mixed", "slalom", "hard"]),
        ("lateral_delay=0.05", "sensor_delay:lateral_acceleration", ["slalom", "mixed", "hard"]),
        ("steering_lag=0.07", "steering_lag", ["slalom", "hard", "mixed"]),
        ("yaw_jump=0.02 at=45", "sensor_bias:yaw_rate", ["highway", "mixed", "slalom"]),
        ("steering_jump=0.1 at=45", "sensor_bias:steering_wheel_angle", ["highway", "slalom", "mixed"]),
        ("friction_patch=0.6 from=30 to=40", "friction_change", ["hard", "slalom", "slalom"]),
        ("wind=1000 from=30 to=40", "crosswind", ["highway", "highway", "highway"]),
        ("lateral_bias_drift=0.3", "sensor_drift:lateral_acceleration", ["highway", "mixed", "hard"]),
        ("brake_pull=0.3", "brake_imbalance", ["hard", "mixed", "hard"]),
        ("steering_curvature=0.04", "steering_ratio", ["mixed", "hard", "mixed"]),
    ];

    /// A drive of 90 s.
    #[derive(Clone, Copy)]
    struct Drive {
        vehicle: usize,
        scenario: &'static str,
        /// What is hidden and what it is called by right.
        hidden: Option<(&'static str, &'static str)>,
        seed: usize,
    }

    impl Drive {
        /// Of each car first those with nothing unusual.
        fn all() -> Vec<Self> {
            VEHICLES.into_iter().flat_map(Self::of).collect()
        }

        fn of(vehicle: usize) -> impl Iterator<Item = Self> {
            let ordinary = SCENARIOS.into_iter().enumerate().map(move |(place, scenario)| Self {
                vehicle,
                scenario,
                hidden: None,
                seed: 10 * vehicle + place,
            });
            let unusual = CAUSES.into_iter().enumerate().map(move |(place, (what, name, scenarios))| Self {
                vehicle,
                scenario: scenarios[vehicle - 1],
                hidden: Some((what, name)),
                seed: 100 * vehicle + place,
            });
            ordinary.chain(unusual)
        }

        /// What is hidden, in words.
        fn hides(&self) -> &'static str {
            self.hidden.map_or("nothing", |(what, _)| what)
        }

        fn is_it(&self, found: &Found) -> bool {
            self.hidden.is_some_and(|(_, name)| found.name() == name)
        }

        /// Does the answer say that this could be it as well?
        fn is_alike(&self, found: &Found) -> bool {
            self.hidden.is_some_and(|(_, name)| found.alike.iter().any(|other| other == name))
        }
    }

    /// `WHOLE_CARS_PYTHON` is a Python with the package commonroad-vehicle-models. What has an answer in the folder
    /// `WHOLE_CARS_ANSWERS` is not asked again. `WHOLE_CARS_DRIVES=16`: the first 16 only, one car's. Then
    /// `GRIPD_RENEW=1 cargo test --test campaign by_hand::whole_cars_by_another_author -- --ignored`.
    #[test]
    #[ignore = "by hand: two hours, and what was interrupted goes on"]
    fn whole_cars_by_another_author() {
        let Some(python) = common_road::python("WHOLE_CARS_PYTHON") else { return };
        let asks = Asks { python, answers: kept::folder("WHOLE_CARS_ANSWERS", "whole_cars") };
        let mut rows = Vec::new();
        let mut counts = Counts::default();
        let mut add = |row: String| {
            println!("{row}");
            rows.push(row);
        };
        let all = Drive::all();
        let most = std::env::var("WHOLE_CARS_DRIVES").map_or(all.len(), |most| most.parse().unwrap());
        let asked = most.min(all.len());
        for drive in all.iter().copied().take(asked) {
            let answer = asks.answer(drive);
            let found = findings(&answer);
            let is_open = answer["verdict"] == "unknown_physics" || answer["refused"].is_string();
            let first = counts.add(drive, &found, is_open);
            let (ordinary, unusual): (Vec<&Found>, Vec<&Found>) =
                found.iter().partition(|one| is_ordinary(one));
            let (first, unusual) = match answer["refused"].as_str() {
                Some(why) => ("", format!("refused: {}", kept::reason(why))),
                None => (first, unusual.into_iter().map(told).collect::<Vec<_>>().join("; ")),
            };
            let ordinary: Vec<String> = ordinary.into_iter().map(Found::name).collect();
            let Drive { vehicle, scenario, .. } = drive;
            add(format!(
                "{vehicle} | {scenario} | {} | {first} | {unusual} | {} | {}",
                drive.hides(),
                ordinary.join(", "),
                held_out(&answer)
            ));
        }
        add(format!("all | | | {} | {} | | ", counts.named(), counts.misled()));
        Section {
            name: "whole_cars_by_another_author",
            seed: &format!("seeds 10 to 33 of ordinary cars, 100 to 311 of others; {asked} of {} drives", all.len()),
            tolerance: 0.1,
            header: "vehicle | scenario | hidden | is the first that is not ordinary | found | what every car has | yaw rate \
                     held out, %: plain → extended",
        }
        .check(&rows);
    }

    /// Is it what every car has?
    fn is_ordinary(found: &Found) -> bool {
        found.kind == "ordinary"
    }

    /// Of what was hidden, and of what was said besides.
    #[derive(Default)]
    struct Counts {
        /// With something hidden: all, those where it is named first, those where the first could be it as well.
        hidden: [usize; 3],
        /// With nothing hidden: all and silent.
        ordinary: [usize; 2],
        /// Something is named that is neither ordinary nor hidden, nor could be what is hidden.
        misled: usize,
    }

    impl Counts {
        /// What the first finding that is not ordinary is. An answer that leaves it open, or none at all, is
        /// not silent.
        fn add(&mut self, drive: Drive, found: &[Found], is_open: bool) -> &'static str {
            let beyond: Vec<&Found> = found.iter().filter(|one| !is_ordinary(one)).collect();
            self.misled += usize::from(beyond.iter().any(|one| !drive.is_it(one) && !drive.is_alike(one)));
            if drive.hidden.is_none() {
                let is_silent = beyond.is_empty() && !is_open;
                self.ordinary[0] += 1;
                self.ordinary[1] += usize::from(is_silent);
                return if is_silent { "silent" } else { "no" };
            }
            let is_it = beyond.first().is_some_and(|one| drive.is_it(one));
            let is_alike = !is_it && beyond.first().is_some_and(|one| drive.is_alike(one));
            self.hidden[0] += 1;
            self.hidden[1] += usize::from(is_it);
            self.hidden[2] += usize::from(is_alike);
            match (is_it, is_alike) {
                (true, _) => "yes",
                (_, true) => "alike",
                _ => "no",
            }
        }

        fn named(&self) -> String {
            let ([hidden, named, alike], [ordinary, silent]) = (self.hidden, self.ordinary);
            format!(
                "{named} of {hidden} named first, {alike} more as one of what looks alike; nothing hidden: silent {silent} of \
                 {ordinary}"
            )
        }

        fn misled(&self) -> String {
            format!("something false in {} of {}", self.misled, self.hidden[0] + self.ordinary[0])
        }
    }

    /// Who asks.
    struct Asks {
        python: String,
        answers: PathBuf,
    }

    impl Asks {
        /// The explanation of a drive, or why there is none.
        fn answer(&self, drive: Drive) -> Value {
            let name = format!("v{} {} {}", drive.vehicle, drive.scenario, drive.hides());
            kept::answer(&kept::file(&self.answers, &name, "json"), || self.asked(drive))
        }

        fn asked(&self, drive: Drive) -> Value {
            let scratch = tempfile::tempdir().unwrap();
            let [log, car] = ["drive.log", "car.toml"].map(|name| scratch.path().join(name));
            let mut command = Command::new(&self.python);
            command.arg(project("tests/campaign/whole_cars/multi_body.py")).arg(&log).arg(&car);
            command.args(["--vehicle", &drive.vehicle.to_string(), "--scenario", drive.scenario]);
            command.args(["--seconds", "90", "--seed", &drive.seed.to_string()]);
            let output = command
                .args(drive.hidden.iter().flat_map(|(what, _)| what.split_whitespace()))
                .output()
                .unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let mut command = gripd();
            command.args(["-q", "explain", "-c"]).arg(&car).arg(&log).args(["--json", "-"]);
            let output = command.output().unwrap();
            let told = String::from_utf8_lossy(&output.stderr);
            match output.status.code() {
                Some(0) => serde_json::from_slice(&output.stdout).unwrap(),
                Some(1) => json!({ "refused": told.trim().lines().last() }),
                _ => panic!("{told}"),
            }
        }
    }
}
