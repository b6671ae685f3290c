//! The program under test, run as a user would: `gripd explain` with a car file and a log, in a folder where nothing
//! else is.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::set::{self, Set};
use testing::setting::setting;

pub struct Program {
    path: PathBuf,
    limit: Duration,
}

/// One run of it.
pub struct Run {
    pub seconds: f64,
    /// The answer, or why there is none.
    pub answer: Result<Value, String>,
}

impl Program {
    /// CONCEALED_PROGRAM, or the gripd that was built with this test.
    pub fn found() -> Self {
        let built = option_env!("CARGO_BIN_EXE_gripd").map(String::from);
        let path = std::env::var("CONCEALED_PROGRAM").ok().or(built);
        let path = path.expect("no gripd was built with this test: name one in CONCEALED_PROGRAM");
        Program { path: path.into(), limit: Duration::from_secs(setting("CONCEALED_SECONDS", 1200)) }
    }

    /// Explains `log` with the car file `toml`, beside the network's description, in a folder of its own.
    pub fn explain(&self, name: &str, log: &[u8], toml: &str, dbc: &str) -> Run {
        let folder =
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("concealed-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("trial.dbc"), dbc).unwrap();
        std::fs::write(folder.join("car.toml"), toml).unwrap();
        std::fs::write(folder.join("drive.log.gz"), log).unwrap();
        let mut command = Command::new(&self.path);
        command.args(["explain", "-c", "car.toml", "drive.log.gz", "--json", "answer.json"]);
        command.current_dir(&folder).stdin(Stdio::null()).stdout(Stdio::null());
        command.stderr(std::fs::File::create(folder.join("stderr")).unwrap());
        if setting("CONCEALED_JOBS", 2usize) > 1 && std::env::var_os("RAYON_NUM_THREADS").is_none() {
            command.env("RAYON_NUM_THREADS", "1");
        }
        let start = Instant::now();
        let ended = self.wait(&mut command);
        let seconds = start.elapsed().as_secs_f64();
        let answer = ended.and_then(|()| {
            let text =
                std::fs::read_to_string(folder.join("answer.json")).map_err(|e| format!("answer: {e}"))?;
            serde_json::from_str(&text).map_err(|e| format!("answer.json: {e}"))
        });
        let answer = answer.map_err(|why| {
            let said = std::fs::read_to_string(folder.join("stderr")).unwrap_or_default();
            format!("{why}: {}", said.trim())
        });
        std::fs::remove_dir_all(&folder).unwrap();
        Run { seconds, answer }
    }

    fn wait(&self, command: &mut Command) -> Result<(), String> {
        let mut child = command.spawn().map_err(|e| format!("{}: {e}", self.path.display()))?;
        let start = Instant::now();
        loop {
            match child.try_wait() {
                Ok(Some(status)) if status.success() => return Ok(()),
                Ok(Some(status)) => return Err(status.to_string()),
                Ok(None) if start.elapsed() > self.limit => {
                    let _ = child.kill();
                    let _ = child.wait();
                    return Err(format!("no answer in {} s", self.limit.as_secs()));
                }
                Ok(None) => std::thread::sleep(Duration::from_millis(20)),
                Err(e) => return Err(e.to_string()),
            }
        }
    }

    /// Answers every recording of a set that has no answer yet in `answers`.
    pub fn answer(&self, set: &Set, answers: &Path) {
        std::fs::create_dir_all(answers.join("runs")).unwrap();
        let names: Vec<String> = set.truths().keys().cloned().collect();
        let dbc = std::fs::read_to_string(set.folder.join("trial.dbc")).unwrap();
        set::share(names.len(), |i| {
            let name = &names[i];
            let file = answers.join(format!("{name}.json"));
            if file.exists() {
                return;
            }
            let toml = std::fs::read_to_string(set.folder.join(format!("{name}.toml"))).unwrap();
            let log = std::fs::read(set.folder.join(format!("{name}.log.gz"))).unwrap();
            let run = self.explain(name, &log, &toml, &dbc);
            let note = json!({ "seconds": run.seconds, "error": run.answer.as_ref().err() });
            std::fs::write(answers.join(format!("runs/{name}.json")), note.to_string()).unwrap();
            match run.answer {
                Ok(answer) => {
                    // Written at once: an answer that exists is whole.
                    let beside = answers.join(format!("runs/{name}.new"));
                    std::fs::write(&beside, serde_json::to_string_pretty(&answer).unwrap()).unwrap();
                    std::fs::rename(beside, file).unwrap();
                    println!("{name}: {:.1} s", run.seconds);
                }
                Err(why) => println!("{name}: {:.1} s: {why}", run.seconds),
            }
        });
    }
}
