//! The process that runs a foreign library, and does nothing else.

use std::fs::{self, File};
use std::io::Write;
use std::mem::ManuallyDrop;
use std::path::Path;

use nix::sys::prctl::set_pdeathsig;
use nix::sys::resource::{Resource, setrlimit};
use nix::sys::signal::Signal;

use super::description::Kind;
use super::job::{Course, JOB_FILE, Job, Line, REASON_FILE, ROWS_FILE, Run};
use super::slave::Slave;

/// The argument that makes a program this process; the next one is the folder.
pub const ARGUMENT: &str = "--run-fmu-in";

/// More memory than this no FMU of a car needs: 8 GiB of addresses.
const MOST_MEMORY: u64 = 8 << 30;

/// Does the job that lies in a folder, and ends the process.
pub fn work(folder: &Path) -> ! {
    // Without them it runs all the same: they are for what goes wrong.
    let _ = set_pdeathsig(Signal::SIGKILL);
    let _ = setrlimit(Resource::RLIMIT_CORE, 0, 0);
    let _ = setrlimit(Resource::RLIMIT_AS, MOST_MEMORY, MOST_MEMORY);
    let code = match job(folder) {
        Ok(()) => 0,
        Err(reason) => {
            let _ = fs::write(folder.join(REASON_FILE), reason);
            1
        }
    };
    // SAFETY: it ends the process. What the library would do at the end of a program is nobody's business any more.
    unsafe { nix::libc::_exit(code) }
}

fn job(folder: &Path) -> Result<(), String> {
    let text = fs::read_to_string(folder.join(JOB_FILE)).map_err(|error| error.to_string())?;
    let job: Job = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let mut rows = File::create(folder.join(ROWS_FILE)).map_err(|error| error.to_string())?;
    // Never unloaded: some libraries do not survive it.
    let slave = ManuallyDrop::new(Slave::load(&job)?);
    job.runs.iter().try_for_each(|run| drive(&slave, &job, run, &mut rows))
}

/// One run, by an instance of its own.
fn drive(slave: &Slave, job: &Job, run: &Run, rows: &mut File) -> Result<(), String> {
    let mut instance = slave.instantiate(job)?;
    for value in &run.set {
        instance.set(value.kind, value.reference, value.value)?;
    }
    instance.begin(job.steps as f64 * job.step_s)?;
    for input in &job.inputs {
        instance.set(input.kind, input.reference, at(input, 0))?;
    }
    instance.begun()?;
    let mut bytes = Vec::with_capacity(8 * job.outputs.len());
    for step in 0..=job.steps {
        bytes.clear();
        for (kind, reference) in &job.outputs {
            bytes.extend(instance.get(*kind, *reference)?.to_le_bytes());
        }
        // Unbuffered: what has been reached is seen by who waits.
        rows.write_all(&bytes).map_err(|error| error.to_string())?;
        if step == job.steps {
            break;
        }
        for input in &job.inputs {
            let (from, to) = (at(input, step), at(input, step + 1));
            let is_number = matches!(input.kind, Kind::Real | Kind::Single);
            match job.course {
                Course::Rates if input.kind == Kind::Real => {
                    instance.set(input.kind, input.reference, from)?;
                    instance.set_rate(input.reference, (to - from) / job.step_s)?;
                }
                Course::ToTheEnd if is_number => instance.set(input.kind, input.reference, to)?,
                Course::Hold if is_number => {
                    instance.set(input.kind, input.reference, 0.5 * (from + to))?;
                }
                // Switches and counts have no middle: as they are at the start.
                _ => instance.set(input.kind, input.reference, from)?,
            }
        }
        instance.step(step as f64 * job.step_s, job.step_s)?;
    }
    instance.end();
    Ok(())
}

fn at(input: &Line, place: usize) -> f64 {
    input.values.get(place).copied().unwrap_or(0.0)
}
