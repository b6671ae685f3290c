//! Runs a target over its corpus and over made-up inputs, and keeps the input that fails.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gripd::can::Frame;
use gripd::can::candump::write_line;
use nix::time::ClockId;
use testing::dice::Dice;
use testing::setting::setting;

/// What an input is written to a file as.
pub trait Input {
    fn bytes(&self) -> Vec<u8>;
    /// Independent inputs in it.
    fn count(&self) -> u64 {
        1
    }
}

impl Input for Vec<u8> {
    fn bytes(&self) -> Vec<u8> {
        self.clone()
    }
}

/// What an input is made of when it is used.
impl Input for u64 {
    fn bytes(&self) -> Vec<u8> {
        self.to_string().into_bytes()
    }
}

/// As a recording.
impl Input for Vec<Frame> {
    fn bytes(&self) -> Vec<u8> {
        let mut text = Vec::new();
        self.iter().for_each(|frame| write_line(&mut text, "can0", frame));
        text
    }
}

/// No input takes as long of the processor, however little of it there is for tests; a reader that hangs shows as a test
/// that does.
const PATIENCE: Duration = Duration::from_secs(10);

/// Runs `check` on so many inputs, times GRIPD_FUZZ.
pub fn fuzz<I: Input>(
    name: &str,
    usual: u64,
    mut make: impl FnMut(&mut Dice) -> I,
    mut check: impl FnMut(&I),
) {
    let (runs, seed) = (usual * setting("GRIPD_FUZZ", 1), setting("GRIPD_FUZZ_SEED", 1));
    let begun = Instant::now();
    let mut count = 0;
    for run in setting("GRIPD_FUZZ_FROM", 0)..runs {
        let input = make(&mut Dice::new(name, seed, run));
        count += input.count();
        one(name, &format!("{name}-{seed}-{run}"), &input, &mut check);
    }
    let seconds = begun.elapsed().as_secs_f64();
    println!("{name}: {count} inputs in {seconds:.1} s, {:.0} a second", count as f64 / seconds);
}

/// Runs `check` on one input, which is written down if that fails.
pub fn one<I: Input>(name: &str, title: &str, input: &I, check: &mut impl FnMut(&I)) {
    let begun = worked();
    let kept = KeepIfItFails { title, input };
    check(input);
    let took = worked() - begun;
    assert!(took < PATIENCE, "{name} took {took:?}");
    drop(kept);
}

/// For how long this thread has had a processor.
fn worked() -> Duration {
    ClockId::CLOCK_THREAD_CPUTIME_ID.now().unwrap().into()
}

/// The files of `corpus/NAME`, with their names.
pub fn corpus(name: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/fuzz/corpus").join(name);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let read = |file: PathBuf| (file.display().to_string(), std::fs::read(&file).unwrap());
    files.into_iter().map(read).collect()
}

/// What is in the files of `corpus/NAME`.
pub fn contents(name: &str) -> Vec<Vec<u8>> {
    corpus(name).into_iter().map(|(_, content)| content).collect()
}

/// Runs the corpus as it is.
pub fn known(name: &str, mut check: impl FnMut(&[u8])) {
    for (file, content) in corpus(name) {
        println!("{file}");
        one(name, "corpus", &content, &mut |content: &Vec<u8>| check(content));
    }
}

struct KeepIfItFails<'a, I: Input> {
    title: &'a str,
    input: &'a I,
}

impl<I: Input> Drop for KeepIfItFails<'_, I> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}.fuzz", self.title));
            let written = std::fs::write(&file, self.input.bytes());
            eprintln!("the input is in {} ({written:?})", file.display());
        }
    }
}
