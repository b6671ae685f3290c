//! How fast gripd is beside the tools that people use, on the same file, by turns in the same run, one core each:
//!
//! - can-utils' `log2asc`, which reads a candump log and writes it again, beside our reading, reading with decoding and
//!   sampling, and the whole of `gripd replay`: the RAV4's recording (../shared, or $GRIPD_SHARED) over and over, time
//!   going on (20 copies, 20 min);
//! - cantools and opendbc's CANParser beside our decoding, on the frames of that recording that all three decode.
//!
//! `cargo bench --bench peers [-- RUNS]` prints medians and ratios. What cannot be had is left out, with a message.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot be set up may fail loudly")]

use std::fs::{self, File};
use std::hint::black_box;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use gripd::can::recording::Reader;
use gripd::can::{Frame, candump};
use gripd::dbc::Database;
use gripd::signals::{Inputs, Sampler};
use gripd::{Config, Micros};
use testing::program::project;

const COPIES: usize = 20;

fn main() {
    let runs = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(7);
    let Some(recording) = testing::shared("recordings/rav4/bus0.log.gz") else { return };
    let folder = tempfile::TempDir::new().unwrap();
    let frames = frames(&recording);
    let log = folder.path().join("long.log");
    write_over_and_over(&frames, &log);
    beside_log2asc(&log, frames.len() * COPIES, folder.path(), runs);
    beside_decoders(&frames, folder.path(), runs);
}

fn frames(path: &Path) -> Vec<Frame> {
    let mut reader = Reader::open(path).unwrap();
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

/// The recording's stamps are counted on by its length and one mean pause.
fn write_over_and_over(frames: &[Frame], path: &Path) {
    let (first, last) = (frames[0].time, frames[frames.len() - 1].time);
    let length = (last - first).0 * frames.len() as i64 / (frames.len() as i64 - 1);
    let mut file = BufWriter::new(File::create(path).unwrap());
    let mut line = Vec::new();
    for copy in 0..COPIES {
        for frame in frames {
            let mut frame = *frame;
            frame.time = frame.time + Micros(length * copy as i64);
            line.clear();
            candump::write_line(&mut line, "can0", &frame);
            file.write_all(&line).unwrap();
        }
    }
    file.flush().unwrap();
}

/// The times of one contestant, s.
struct Contestant<'a> {
    name: &'static str,
    run: Box<dyn FnMut() + 'a>,
    times: Vec<f64>,
}

impl<'a> Contestant<'a> {
    fn new(name: &'static str, run: impl FnMut() + 'a) -> Self {
        Self { name, run: Box::new(run), times: Vec::new() }
    }

    fn median(&self) -> f64 {
        let mut times = self.times.clone();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    }
}

/// All of them by turns, once to warm up and then `runs` times, so that all meet the same machine.
fn compete(contestants: &mut [Contestant], runs: usize) {
    for run in 0..=runs {
        for contestant in contestants.iter_mut() {
            let begun = Instant::now();
            (contestant.run)();
            if run > 0 {
                contestant.times.push(begun.elapsed().as_secs_f64());
            }
        }
    }
}

fn beside_log2asc(log: &Path, frames: usize, folder: &Path, runs: usize) {
    let Some(log2asc) = log2asc() else {
        eprintln!("skipped: no log2asc (tests/vcan/fetch.sh fetches it)");
        return;
    };
    let config = Config::load(&project("config/rav4.toml")).unwrap();
    let database = config.input_database().unwrap();
    let inputs = Inputs::compile(&config.signals, &database, config.vehicle.wheel_radius_m.value).unwrap();
    let bytes = fs::metadata(log).unwrap().len() as f64;
    let mut contestants = [
        Contestant::new("log2asc", || {
            run(Command::new(&log2asc).arg("-I").arg(log).arg("-O").arg(folder.join("out.asc")).arg("can0"));
        }),
        Contestant::new("read", || {
            let mut reader = Reader::open(log).unwrap();
            while let Some(frame) = reader.next_frame().unwrap() {
                black_box(&frame);
            }
        }),
        Contestant::new("read, decode, sample", || {
            let mut reader = Reader::open(log).unwrap();
            let mut sampler = Sampler::new(inputs.clone(), &config.signals.sampling);
            while let Some(frame) = reader.next_frame().unwrap() {
                sampler.push(&frame);
                while let Some(sample) = sampler.next_sample() {
                    black_box(&sample);
                }
            }
        }),
        Contestant::new("gripd replay", || {
            let mut replay = Command::new(env!("CARGO_BIN_EXE_gripd"));
            replay.args(["replay", "-q", "-c"]).arg(project("config/rav4.toml")).arg(log);
            run(replay.arg("-o").arg(folder.join("out.log")));
        }),
    ];
    compete(&mut contestants, runs);
    let theirs = contestants[0].median();
    println!("{frames} frames, {:.1} MB, medians of {runs} runs", bytes / 1e6);
    for contestant in &contestants {
        let seconds = contestant.median();
        println!(
            "{:22} {seconds:7.3} s {:7.1} ns/frame {:6.2} GB/s {:6.1} x log2asc",
            contestant.name,
            seconds / frames as f64 * 1e9,
            bytes / seconds / 1e9,
            theirs / seconds
        );
    }
}

fn log2asc() -> Option<PathBuf> {
    let script = ". tests/vcan/fetch.sh && fetch >&2 && echo \"$CACHE/bin/log2asc\"";
    let fetched = Command::new("sh").args(["-c", script]).current_dir(project(".")).output().ok()?;
    let path = PathBuf::from(String::from_utf8(fetched.stdout).ok()?.trim());
    path.exists().then_some(path)
}

fn run(command: &mut Command) {
    let status = command.stdout(Stdio::null()).status().unwrap();
    assert!(status.success(), "{command:?}");
}

fn beside_decoders(frames: &[Frame], folder: &Path, runs: usize) {
    let Some(python) = testing::decoders() else { return };
    let dbc = project("dbc/rav4.dbc");
    let database = Database::load(&dbc).unwrap();
    let log = folder.join("once.log");
    let mut writer = candump::Writer::create(&log, "can0").unwrap();
    frames.iter().for_each(|frame| writer.write(frame).unwrap());
    writer.finish().unwrap();
    let ours: Vec<&Frame> =
        frames.iter().filter(|frame| database.message_with_id(frame.id).is_some()).collect();
    // Nanoseconds per frame: ours, cantools, opendbc.
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..runs {
        let begun = Instant::now();
        // Long enough for the clock.
        const TIMES: usize = 100;
        for _ in 0..TIMES {
            for frame in &ours {
                decode(&database, frame);
            }
        }
        times[0].push(begun.elapsed().as_nanos() as f64 / (TIMES * ours.len()) as f64);
        let mut script = Command::new(&python);
        let output = script.arg(project("benches/decoders.py")).arg(&dbc).arg(&log).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        for (line, times) in String::from_utf8(output.stdout).unwrap().lines().zip(&mut times[1..]) {
            let words: Vec<&str> = line.split(' ').collect();
            assert_eq!(words[1], ours.len().to_string(), "not the same frames");
            times.push(words[2].parse::<f64>().unwrap() * 1e9 / ours.len() as f64);
        }
    }
    let [ours_ns, cantools, opendbc] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    println!("decode all signals of {} frames, medians of {runs} runs", ours.len());
    println!("gripd                  {ours_ns:7.1} ns/frame");
    println!("cantools               {cantools:7.1} ns/frame, {:6.1} x as long", cantools / ours_ns);
    println!("opendbc's CANParser    {opendbc:7.1} ns/frame, {:6.1} x as long", opendbc / ours_ns);
}

fn decode(database: &Database, frame: &Frame) {
    let Some(message) = database.message_with_id(frame.id) else { return };
    for signal in &message.signals {
        if signal.is_active(frame.data()) {
            black_box(signal.decode(frame.data()));
        }
    }
}
