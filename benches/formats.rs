//! How fast recordings of each format are read and written, the same frames in all of them, by turns in the same run,
//! and how fast python-can reads the same files: the simulated bus of the other benchmarks, 15 copies, time going on.
//!
//! `cargo bench --bench formats [-- RUNS]` prints medians and ratios. python-can gets a fifth of the frames, and is left
//! out, with a message, where it cannot be had.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot be set up may fail loudly")]

use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use gripd::Micros;
use gripd::can::Frame;
use gripd::can::recording::{Format, Reader, Writer};

const COPIES: i64 = 15;
/// python-can gets so many of them.
const FEWER: i64 = 3;
/// 9 October 2025.
const START: Micros = Micros(1_760_000_000_000_000);

/// Seconds of each run.
#[derive(Default)]
struct Times {
    read: Vec<f64>,
    write: Vec<f64>,
    python: Vec<f64>,
}

fn main() {
    let runs: usize = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(5);
    let folder = tempfile::TempDir::new().unwrap();
    let once = testing::bus::bus();
    let copies = |count: i64| -> Vec<Frame> {
        let length = Micros(once[once.len() - 1].time.0 + 1000);
        let mut all: Vec<Frame> = Vec::new();
        for copy in 0..count {
            all.extend(&once);
            let place = all.len() - once.len();
            all[place..]
                .iter_mut()
                .for_each(|frame| frame.time = START + frame.time + Micros(copy * length.0));
        }
        all
    };
    let (all, fewer) = (copies(COPIES), copies(FEWER));
    let python = testing::peers();
    let mut results = Format::NAMES.map(|(name, format)| (name, format, Times::default()));
    // The first one warms up.
    for run in 0..=runs {
        for (name, format, times) in &mut results {
            let path = folder.path().join(format!("bus.{}", if *name == "candump" { "log" } else { *name }));
            let begun = Instant::now();
            write(&path, *format, &all);
            let write_s = begun.elapsed().as_secs_f64();
            let begun = Instant::now();
            assert_eq!(read(&path), all.len());
            if run > 0 {
                times.write.push(write_s);
                times.read.push(begun.elapsed().as_secs_f64());
            }
            let Some(python) = python.as_ref().filter(|_| run > 0 && run <= 2) else { continue };
            write(&path, *format, &fewer);
            let script =
                Command::new(python).arg(testing::program::project("benches/formats.py")).arg(&path).output();
            let told = String::from_utf8(script.unwrap().stdout).unwrap();
            let (count, seconds) = told.trim().split_once(' ').unwrap();
            assert_eq!(count, fewer.len().to_string(), "{name}");
            times.python.push(seconds.parse().unwrap());
        }
    }
    println!("{} frames, medians of {runs} runs, one core", all.len());
    println!(
        "format     MB   read Mframes/s   MB/s  ns/frame   write ns/frame   python-can us/frame   ratio"
    );
    for (name, format, times) in results {
        let path = folder.path().join("size");
        write(&path, format, &all);
        let megabytes = fs::metadata(&path).unwrap().len() as f64 / 1e6;
        let count = all.len() as f64;
        let (read, write) = (median(times.read), median(times.write));
        print!(
            "{name:8} {megabytes:5.1} {:15.2} {:7.0} {:8.1} {:15.1}",
            count / read / 1e6,
            megabytes / read,
            read / count * 1e9,
            write / count * 1e9
        );
        if times.python.is_empty() {
            println!();
            continue;
        }
        let theirs = median(times.python) / fewer.len() as f64;
        println!("{:20.2} {:9.0}", theirs * 1e6, theirs / (read / count));
    }
}

fn write(path: &Path, format: Format, frames: &[Frame]) {
    let mut writer = Writer::create(path, format, "can0").unwrap();
    frames.iter().for_each(|frame| writer.write(frame).unwrap());
    writer.finish().unwrap();
}

fn read(path: &Path) -> usize {
    let mut reader = Reader::open(path).unwrap();
    let mut count = 0;
    while let Some(frame) = reader.next_frame().unwrap() {
        black_box(&frame);
        count += 1;
    }
    count
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
