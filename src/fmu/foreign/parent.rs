//! Starts the process that runs a foreign library, waits for it, and takes nothing from it but numbers.

use std::fs::{self, File};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::Signal;

use super::child::ARGUMENT;
use super::job::{JOB_FILE, Job, REASON_FILE, ROWS_FILE};

/// The outputs of a run, at the start and after each step.
pub type Rows = Vec<Vec<f64>>;

/// The program that becomes the process, the folder that it works in, and how long it may take.
#[derive(Clone, Debug)]
pub struct Program {
    /// The program: it calls [`child::work`](super::child::work) for [`ARGUMENT`].
    pub executable: PathBuf,
    /// The process's own folder.
    pub folder: PathBuf,
    /// For all runs of a job together.
    pub limit: Duration,
}

/// How often is looked whether it has ended.
const LOOK_EVERY: Duration = Duration::from_millis(2);

/// So much of what it said is told.
const MOST_SAID: usize = 400;

impl Program {
    /// Does a job: the rows of each run.
    ///
    /// # Errors
    /// How it failed: a crash, too much time, a refusal, or numbers that are none.
    pub fn work(&self, job: &Job) -> Result<Vec<Rows>, String> {
        let said = self.folder.join("said");
        let begin = || -> std::io::Result<Child> {
            // What is left of the last job must not be taken for this one's.
            for name in [REASON_FILE, ROWS_FILE] {
                match fs::remove_file(self.folder.join(name)) {
                    Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
                    _ => {}
                }
            }
            fs::write(self.folder.join(JOB_FILE), serde_json::to_vec(job)?)?;
            Command::new(&self.executable)
                .arg(ARGUMENT)
                .arg(&self.folder)
                .current_dir(&self.folder)
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(File::create(&said)?)
                .spawn()
        };
        let mut child = begin().map_err(|error| format!("its process cannot be started: {error}"))?;
        let ended = wait(&mut child, self.limit).map_err(|error| format!("its process is lost: {error}"))?;
        let reached = || {
            let bytes = fs::metadata(self.folder.join(ROWS_FILE)).map_or(0, |there| there.len());
            let rows = bytes / (8 * job.outputs.len().max(1)) as u64;
            let within = rows.saturating_sub(1) % (job.steps as u64 + 1);
            let of = job.steps as f64 * job.step_s;
            if rows == 0 {
                "before its first step".to_owned()
            } else {
                format!("at {:.3} s of {of:.3} s", within as f64 * job.step_s)
            }
        };
        let Some(status) = ended else {
            let limit = self.limit.as_secs_f64();
            return Err(format!(
                "it was ended after {limit} s, {}; give it longer with time_limit_s, or longer steps with step_ms",
                reached()
            ));
        };
        if !status.success() {
            let reason = fs::read_to_string(self.folder.join(REASON_FILE)).ok();
            let reason = reason.unwrap_or_else(|| format!("it {}, {}", crashed(status), reached()));
            return Err(with_what_it_said(reason, &said));
        }
        self.rows(job)
    }

    fn rows(&self, job: &Job) -> Result<Vec<Rows>, String> {
        let bytes =
            fs::read(self.folder.join(ROWS_FILE)).map_err(|error| format!("it left no rows: {error}"))?;
        let (count, rows) = (job.outputs.len(), job.steps + 1);
        if bytes.len() != 8 * count * rows * job.runs.len() {
            return Err(format!("it ended with {} bytes of rows, not all of them", bytes.len()));
        }
        let numbers: Vec<f64> = bytes
            .chunks_exact(8)
            .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap_or([0xFF; 8])))
            .collect();
        if let Some(place) = numbers.iter().position(|number| !number.is_finite()) {
            let (row, column) = (place / count % rows, place % count);
            let reference = job.outputs.get(column).map_or(0, |(_, reference)| *reference);
            return Err(format!(
                "its variable {reference} is {} at {:.3} s: no number",
                numbers[place],
                row as f64 * job.step_s
            ));
        }
        let runs = numbers.chunks(count * rows);
        Ok(runs.map(|run| run.chunks(count).map(<[f64]>::to_vec).collect()).collect())
    }
}

/// Until it ends, or the time is over: then it is made to, and nothing is given.
fn wait(child: &mut Child, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if begun.elapsed() > limit {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

fn crashed(status: ExitStatus) -> String {
    match status.signal().map(Signal::try_from) {
        Some(Ok(signal)) => format!("crashed ({signal})"),
        Some(Err(_)) => "crashed".to_owned(),
        None => format!("ended the process with the code {}", status.code().unwrap_or(-1)),
    }
}

/// A reason, and the end of what was written to the standard error.
fn with_what_it_said(reason: String, said: &Path) -> String {
    let said = fs::read(said).unwrap_or_default();
    let from = said.len().saturating_sub(MOST_SAID);
    let text = String::from_utf8_lossy(&said[from..]);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if text.is_empty() { reason } else { format!("{reason}; it said: {text}") }
}
