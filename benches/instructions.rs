//! How many machine instructions each stage takes, as valgrind's callgrind counts them: unlike times the same on a busy
//! machine as on an idle one. Compared with benches/instructions.toml; more by a tenth, and by more than a few, is a failure.
//!
//! `cargo bench --profile dev --bench instructions`, with `-- --write` to keep what was counted. That is the build of the
//! tests, whose arithmetic is checked, as `.ci/run` makes it: a release, inlined across pieces and crates, takes fewer.
//! Without valgrind nothing is done, and that is said. What a stage needs once is not counted: it runs for n and for 2 n
//! elements, and the difference counts.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark that cannot be set up may fail loudly")]

use std::collections::BTreeMap;
use std::fs;
use std::hint::black_box;
use std::io::Cursor;
use std::path::Path;
use std::process::{Command, ExitCode};

use gripd::can::{Frame, candump};
use gripd::estimate::Pipeline;
use gripd::model::integrate::advance_in;
use gripd::model::{Controls, Plant, State, TireKind, Vehicle};
use gripd::service::sensors;
use gripd::signals::publish::{PublishConfig, Publisher, built_in_database};
use gripd::signals::{Inputs, Sampler};
use gripd::{Config, Sample};

use testing::program::project;

/// A stage: its name, how many elements are enough, and what is done with so many.
type Stage = (&'static str, usize, fn(usize));

const STAGES: [Stage; 7] = [
    ("read a frame of a candump log", 20_000, read),
    ("pass over a frame that is not needed", 20_000, pass_over),
    ("decode and sample, each sample", 4_000, sample),
    ("estimate, each sample", 4_000, estimate),
    ("publish a round of six frames", 2_000, publish),
    ("write a frame of a candump log", 20_000, write),
    ("a Runge-Kutta step of the car on magic-formula tires", 5_000, simulate),
];

/// More than this share is a failure, less than this is worth keeping.
const TOLERANCE: f64 = 0.1;

/// So many instructions more or fewer are the compiler's choice of registers: a stage of 14 counts 16 on another version.
const FEW: f64 = 4.0;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, stage, count] = arguments.as_slice()
        && flag == "--stage"
    {
        let (_, _, run) = STAGES[stage.parse::<usize>().unwrap()];
        run(count.parse().unwrap());
        return ExitCode::SUCCESS;
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        eprintln!("skipped: no valgrind");
        return ExitCode::SUCCESS;
    }
    let drive = tempfile::NamedTempFile::with_suffix(".log").unwrap();
    let mut simulate = Command::new(env!("CARGO_BIN_EXE_gripd"));
    simulate.args(["simulate", "-q"]).arg(project("config/scenarios/demo.toml")).arg("-o").arg(drive.path());
    assert!(simulate.status().unwrap().success());
    let counted: BTreeMap<String, u64> = STAGES
        .iter()
        .enumerate()
        .map(|(stage, (name, count, _))| {
            let count_with = |count| instructions(stage, count, drive.path());
            let difference = count_with(2 * count) - count_with(*count);
            ((*name).to_owned(), difference / *count as u64)
        })
        .collect();
    let path = project("benches/instructions.toml");
    if arguments.iter().any(|argument| argument == "--write") {
        let header =
            "# Instructions for each element, as .ci/run counts them; `-- --write` after its command\n";
        fs::write(&path, format!("{header}{}", toml::to_string(&counted).unwrap())).unwrap();
    }
    let kept: BTreeMap<String, u64> = toml::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let mut failed = false;
    for (name, _, _) in STAGES {
        let (now, before) = (counted[name], kept.get(name).copied().unwrap_or(0));
        let change = now as f64 / before as f64 - 1.0;
        let verdict = match change {
            _ if before == 0 => "not kept yet",
            _ if (now as f64 - before as f64).abs() <= FEW => "",
            TOLERANCE.. => "MORE",
            _ if change < -TOLERANCE => "less: keep it with --write",
            _ => "",
        };
        failed |= matches!(verdict, "MORE" | "not kept yet");
        println!("{name:55} {now:7} {:+6.1} % {verdict}", 100.0 * change);
    }
    if failed {
        eprintln!("more instructions than {} has; if that is meant, keep it with --write", path.display());
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

fn instructions(stage: usize, count: usize, drive: &Path) -> u64 {
    let mut valgrind = Command::new("valgrind");
    valgrind
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().unwrap());
    valgrind.args(["--stage", &stage.to_string(), &count.to_string()]).env(DRIVE, drive);
    let output = valgrind.output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    let collected = text.lines().find_map(|line| line.split_once("Collected : "));
    let Some((_, number)) = collected.filter(|_| output.status.success()) else { panic!("{text}") };
    number.trim().parse().unwrap()
}

fn config() -> Config {
    Config::load(&project("config/demo.toml")).unwrap()
}

/// The demo's drive, made once for all stages, so that making it does not count.
const DRIVE: &str = "GRIPD_DRIVE";

fn drive() -> Vec<Frame> {
    let mut reader = candump::Reader::open(Path::new(&std::env::var_os(DRIVE).unwrap())).unwrap();
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

/// All of its samples, however many are wanted: what is done with fewer has the same beforehand.
fn samples() -> Vec<Sample> {
    let mut sampler = sampler();
    let mut samples = Vec::new();
    for frame in drive() {
        sampler.push(&frame);
        samples.extend(std::iter::from_fn(|| sampler.next_sample()));
    }
    samples
}

fn pipeline() -> Pipeline {
    let config = config();
    Pipeline::new(&config.vehicle, &sensors(sampler().inputs()), &config.estimators)
}

fn a_frame(number: usize) -> Frame {
    testing::bus::unneeded(number, gripd::Micros(1_760_000_000_000_000 + 1000 * number as i64))
}

/// As many whatever is done with them, so that making them does not count.
fn frames() -> Vec<Frame> {
    (0..40_000).map(a_frame).collect()
}

fn read(count: usize) {
    let mut text = Vec::new();
    frames().iter().for_each(|frame| candump::write_line(&mut text, "can0", frame));
    let mut reader = candump::Reader::from_read(Box::new(Cursor::new(text)), "log").unwrap();
    for _ in 0..count {
        black_box(&reader.next_frame().unwrap());
    }
}

fn write(count: usize) {
    let (frames, mut writer) = (frames(), candump::Writer::new(std::io::sink(), "can0"));
    frames[..count].iter().for_each(|frame| writer.write(frame).unwrap());
}

fn sampler() -> Sampler {
    let config = config();
    let database = config.input_database().unwrap();
    let inputs = Inputs::compile(&config.signals, &database, config.vehicle.wheel_radius_m.value).unwrap();
    Sampler::new(inputs, &config.signals.sampling)
}

fn pass_over(count: usize) {
    let (frames, mut sampler) = (frames(), sampler());
    for frame in &frames[..count] {
        black_box(sampler.push(frame));
    }
}

fn sample(count: usize) {
    let (frames, mut sampler) = (drive(), sampler());
    let mut made = 0;
    for frame in &frames {
        sampler.push(frame);
        while let Some(sample) = sampler.next_sample() {
            black_box(&sample);
            made += 1;
        }
        if made >= count {
            return;
        }
    }
}

fn estimate(count: usize) {
    let (samples, mut pipeline) = (samples(), pipeline());
    for sample in &samples[..count] {
        black_box(pipeline.step(sample));
    }
}

fn publish(count: usize) {
    let (samples, mut pipeline) = (samples(), pipeline());
    let mut publisher = Publisher::new(&built_in_database().unwrap(), &PublishConfig::default()).unwrap();
    // Far enough into the drive for there to be something to tell.
    let estimates: Vec<_> = samples[..4_000].iter().map(|sample| *pipeline.step(sample)).collect();
    for estimates in &estimates[4_000 - count..] {
        publisher.publish(estimates.time, estimates, &mut |frame| {
            black_box(frame);
        });
    }
}

fn simulate(count: usize) {
    let plant = Plant::new(&Vehicle { tire: TireKind::MagicFormula, ..Vehicle::thesis() });
    let mut state = State::rolling(&plant, 20.0);
    let controls = Controls { steer: 0.01, drive_torque: [150.0, 150.0, 0.0, 0.0], ..Controls::default() };
    for _ in 0..count {
        state = advance_in(&plant, black_box(&state), &controls, &controls, &plant.nominal, 1e-3, 1);
    }
    black_box(state);
}
