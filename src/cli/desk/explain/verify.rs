//! `--sensitivity --verify`: puts effects of the predicted sizes into the drives and explains these for real.

use std::collections::VecDeque;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::{Value, json};

use super::recordings::{self, One, Read};
use crate::cli::Failure;
use crate::cli::desk::output::write_json;
use crate::cli::desk::part::Part;
use crate::cli::desk::progress::Progress;
use bus::Config;
use bus::can::Frame;
use bus::signals::Alterer;
use lab::explain::ordinary::conceal::{Asked, Base, Concealment, Refusal, with_bend};
use lab::explain::{Case, Known, Outcome, Sensitivity, Try, Verified};
use physics::{Micros, Quantity};

/// The drives as they were read, and what they are asked.
pub struct Drives<'d> {
    pub config: &'d Config,
    pub case: &'d Case<'d>,
    pub read: &'d Read,
    /// Where each comes from.
    pub logs: &'d [PathBuf],
    /// Which part of each was read.
    pub part: &'d (dyn Fn(usize) -> Part + Sync),
}

/// What is done already, in a file.
struct Kept<'k> {
    path: &'k Path,
    /// Of what.
    inputs: String,
    /// What is found in the drives as they are.
    control: Option<Vec<Known>>,
    done: Vec<Outcome>,
}

/// Where what is done is kept: beside the answer, else by the name of the recording.
pub fn kept_in(json: Option<&Path>, log: &Path) -> PathBuf {
    let beside = json.filter(|path| path.as_os_str() != "-").map(|path| path.as_os_str().to_owned());
    let mut name = beside.unwrap_or_else(|| log.file_name().unwrap_or(log.as_os_str()).to_owned());
    name.push(".verified");
    PathBuf::from(name)
}

/// Does it, and goes on where an earlier run with the same inputs was ended.
pub fn verified(
    sensitivity: &Sensitivity,
    wanted: &[String],
    drives: &Drives<'_>,
    path: &Path,
) -> Result<Verified, Failure> {
    let case = drives.case;
    let seconds = case.recordings.iter().skip(case.references).map(|it| it.seconds()).fold(0.0, f64::max);
    let (tries, left_out) = sensitivity.to_verify(wanted, seconds);
    if tries.is_empty() {
        let asked = if wanted.is_empty() { String::new() } else { format!(" of {}", wanted.join(", ")) };
        let why = left_out.first().map_or(String::new(), |it| format!(": {}: {}", it.effect, it.why));
        return Err(Failure::work(format_args!("nothing{asked} can be put into these drives{why}")));
    }
    let mut kept = Kept::read(path, digest(case));
    let open: VecDeque<&Try> = tries.iter().filter(|it| !kept.has(&it.outcome)).collect();
    let progress = Progress::of_parts(tries.len());
    (0..tries.len() - open.len()).for_each(|_| progress.part_done());
    if kept.control.is_none() {
        progress.begin("the drives as they are".into());
        kept.control = Some(Known::all(&case.explain(&|_, _| {}).explanation.findings));
        kept.write()?;
    }
    let control = kept.control.clone().unwrap_or_default();
    let own = with_bend(case.vehicle);
    let bases = drives.bases(&own, !open.is_empty());
    let open = Mutex::new(open);
    let kept = Mutex::new(kept);
    let failed: Mutex<Option<Failure>> = Mutex::new(None);
    let work = || {
        loop {
            if locked(&failed).is_some() {
                return;
            }
            let Some(next) = locked(&open).pop_front() else { return };
            progress.begin(next.config.title());
            let done = drives.found(next, &bases).and_then(|found| {
                let mut kept = locked(&kept);
                kept.done.push(match found {
                    Ok(found) => next.outcome.clone().with(&found, &control),
                    Err(why) => Outcome { refused: Some(why.to_string()), ..next.outcome.clone() },
                });
                kept.write()
            });
            progress.part_done();
            if let Err(failure) = done {
                locked(&failed).get_or_insert(failure);
            }
        }
    };
    // Threads of its own: in the pool that an explanation computes with one would wait for another, and none would end.
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, Into::into) {
            scope.spawn(work);
        }
    });
    progress.finish();
    if let Some(failure) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(failure);
    }
    let kept = kept.into_inner().unwrap_or_else(PoisonError::into_inner);
    let outcome = |it: &Try| kept.done.iter().find(|done| done.is_of(&it.outcome)).cloned();
    Ok(Verified::of(tries.iter().filter_map(outcome).collect(), left_out))
}

/// What is behind a lock; a thread that panicked has left nothing half done there.
fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

type Bases<'a> = Vec<Result<Base<'a>, Refusal>>;

impl Drives<'_> {
    /// The car as it drove in each of the drives that are explained.
    fn bases<'a>(&self, own: &'a physics::model::Vehicle, is_needed: bool) -> Bases<'a> {
        let explained = self.case.recordings.iter().skip(self.case.references);
        let base = |recording| Base::of(own, &self.asked(recording, &[]));
        explained.filter(|_| is_needed).map(base).collect()
    }

    fn asked<'a>(
        &'a self,
        recording: &'a lab::explain::Recording,
        effects: &'a [physics::model::effect::EffectConfig],
    ) -> Asked<'a> {
        Asked { vehicle: self.case.vehicle, configured: self.case.effects, recording, effects }
    }

    /// What is found in the drives with an effect; why they cannot have it.
    fn found(&self, it: &Try, bases: &Bases<'_>) -> Result<Result<Vec<Known>, Refusal>, Failure> {
        let effects = std::slice::from_ref(&it.config);
        let mut all = self.case.recordings[..self.case.references].to_vec();
        let mut chain = self.case.chain[..self.case.references].to_vec();
        for (place, base) in (self.case.references..).zip(bases) {
            let base = base.as_ref().map_err(Clone::clone);
            let asked = self.asked(&self.case.recordings[place], effects);
            match Concealment::beside(base, asked) {
                Ok(concealment) => {
                    let One { recording, chain: audit, .. } = self.with(place, &concealment)?;
                    all.push(recording);
                    chain.push(audit);
                }
                Err(why) => return Ok(Err(why)),
            }
        }
        let case = Case { recordings: &all, chain: &chain, ..*self.case };
        Ok(Ok(Known::all(&case.explain(&|_, _| {}).explanation.findings)))
    }

    /// A recording's frames with what is concealed in them, as they are read.
    fn with(&self, place: usize, concealment: &Concealment) -> Result<One, Failure> {
        let start = self.read.starts[place];
        let change = |quantity: Quantity, time: Micros, value: f64| {
            concealment.reading(quantity, (time - start).seconds(), value)
        };
        let source = (self.logs[place].as_path(), (self.part)(place));
        let database = self.config.input_database()?;
        let radius = self.config.vehicle.wheel_radius_m.value;
        let mut alterer =
            Alterer::compile(&self.config.signals, &database, radius).map_err(Failure::usage)?;
        let mut reader = source.1.open(source.0)?;
        while let Some(frame) = reader.next_frame()? {
            alterer.look(&frame, &change);
        }
        // What is said of checksums is said where a recording is written.
        let _ = alterer.looked(self.case.seed);
        let alter = |frame: Frame| alterer.alter(&frame, &change).unwrap_or(frame);
        let mut broken = Vec::new();
        let one = recordings::one(source, self.config, &Progress::hidden(), &mut broken, alter)?;
        if broken.is_empty() { Ok(one) } else { Err(Failure::Work(broken.join("; "))) }
    }
}

impl<'k> Kept<'k> {
    /// What an earlier run with the same inputs has done; nothing else.
    fn read(path: &'k Path, inputs: String) -> Self {
        let nothing = Self { path, inputs, control: None, done: Vec::new() };
        let Ok(text) = std::fs::read_to_string(path) else { return nothing };
        let Ok(mut value) = serde_json::from_str::<Value>(&text) else {
            tracing::warn!("{}: cannot be read and is begun anew", path.display());
            return nothing;
        };
        if value["inputs"].as_str() != Some(&nothing.inputs) {
            tracing::warn!(
                "{}: is of another configuration, other recordings or another version, and is begun anew",
                path.display()
            );
            return nothing;
        }
        let control = serde_json::from_value(value["control"].take()).ok();
        let done: Vec<Outcome> = serde_json::from_value(value["done"].take()).unwrap_or_default();
        tracing::info!("{}: goes on; {} done before", path.display(), done.len());
        Self { control, done, ..nothing }
    }

    fn has(&self, outcome: &Outcome) -> bool {
        self.done.iter().any(|done| done.is_of(outcome))
    }

    fn write(&self) -> Result<(), Failure> {
        let value = json!({ "inputs": self.inputs, "control": self.control, "done": self.done });
        write_json(self.path, &value)
    }
}

/// What an answer depends on, in a few letters (FNV-1a, 64 bits: against mistakes, not against malice).
fn digest(case: &Case<'_>) -> String {
    struct Sum(u64);
    impl Sum {
        fn add(&mut self, bytes: &[u8]) {
            for byte in bytes {
                self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    impl Write for Sum {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.add(text.as_bytes());
            Ok(())
        }
    }
    let mut sum = Sum(0xcbf2_9ce4_8422_2325);
    // It takes whatever it is given.
    let _ = write!(
        sum,
        "{} {:?} {:?} {} {} {}",
        env!("CARGO_PKG_VERSION"),
        case.vehicle,
        case.effects,
        case.references,
        case.held_out,
        case.seed
    );
    for recording in case.recordings {
        for (quantity, track) in recording.tracks.iter().enumerate() {
            sum.add(&(quantity as u64).to_le_bytes());
            for (t, value) in track {
                sum.add(&t.to_le_bytes());
                sum.add(&value.to_le_bytes());
            }
        }
    }
    format!("{:016x}", sum.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_done_is_kept_beside_the_answer() {
        let log = Path::new("drives/a.log.gz");
        assert_eq!(kept_in(Some(Path::new("out/answer.json")), log), Path::new("out/answer.json.verified"));
        assert_eq!(kept_in(Some(Path::new("-")), log), Path::new("a.log.gz.verified"));
        assert_eq!(kept_in(None, log), Path::new("a.log.gz.verified"));
    }

    /// GIVEN what one run has done THEN a second one with the same inputs has it, and one with others, or with a damaged file,
    /// has nothing.
    #[test]
    fn what_is_done_is_taken_by_the_same_inputs_only() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("answer.json.verified");
        let outcome = Outcome {
            effect: "sensor_scale".into(),
            channel: Some("yaw_rate".into()),
            parameter: "relative_error".into(),
            change: 0.1 + 0.2,
            unit: "1".into(),
            predicted: 0.9,
            named: true,
            noticed: true,
            found: vec!["sensor_scale:yaw_rate".into()],
            refused: None,
        };
        let control = Some(vec![Known {
            effect: "relaxation_length".into(),
            channel: None,
            numbers: [("length_m".to_owned(), [0.5, 0.02])].into(),
        }]);
        let kept =
            Kept { path: &path, inputs: "abc".into(), control: control.clone(), done: vec![outcome.clone()] };
        kept.write().unwrap();
        let again = Kept::read(&path, "abc".into());
        assert!(again.has(&outcome) && again.control == control);
        assert!(!again.has(&Outcome { change: 0.31, ..outcome.clone() }));
        let other = Kept::read(&path, "abd".into());
        assert!(!other.has(&outcome) && other.control.is_none());
        std::fs::write(&path, "{\"inputs\": \"abc\", \"do").unwrap();
        assert!(!Kept::read(&path, "abc".into()).has(&outcome));
    }

    /// GIVEN drives THEN another configuration, another reading or another seed is another input.
    #[test]
    fn inputs_are_told_apart() {
        let vehicle = physics::model::Vehicle::thesis();
        let mut recording = lab::explain::Recording::default();
        recording.tracks[Quantity::YawRate as usize] = vec![(0.0, 0.1), (0.01, 0.2)];
        let of = |vehicle: &physics::model::Vehicle, recording: &lab::explain::Recording, seed| {
            digest(&Case {
                vehicle,
                effects: &[],
                recordings: std::slice::from_ref(recording),
                references: 0,
                in_order: false,
                held_out: 0,
                chain: &[],
                library: &[],
                seed,
            })
        };
        let was = of(&vehicle, &recording, 1);
        assert_eq!(was, of(&vehicle, &recording, 1));
        assert_ne!(was, of(&vehicle, &recording, 2));
        let mut heavier = vehicle.clone();
        heavier.mass_kg.value += 1.0;
        assert_ne!(was, of(&heavier, &recording, 1));
        recording.tracks[Quantity::YawRate as usize][1].1 += 1e-12;
        assert_ne!(was, of(&vehicle, &recording, 1));
    }
}
