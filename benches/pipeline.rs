//! How long each stage takes, and all of them together, on a simulated bus of 900 frames per second
//! of which half are not needed. One element is a frame, a sample or a published round; so at
//! `5.0 Melem/s` each takes 200 ns. Beside other tools: peers.rs.

#![allow(missing_docs, reason = "the macros of criterion make functions without")]
#![allow(clippy::unwrap_used, reason = "a benchmark that cannot be set up may fail loudly")]

use std::hint::black_box;
use std::io::Cursor;

use criterion::{BatchSize, Criterion, Throughput, criterion_group};
use gripd::can::Frame;
use gripd::can::candump::{Reader, Writer, write_line};
use gripd::estimate::Pipeline;
use gripd::service::{Engine, Sink};
use gripd::signals::publish::{PublishConfig, Publisher, built_in_database};
use gripd::signals::{Inputs, Sampler};
use gripd::{Config, Estimates, Quantity, Sample, Sensors};

use testing::bus::frames;
use testing::cells::renew;
use testing::program::project;
use testing::results::{Section, measured};

fn config() -> Config {
    Config::load(&project("config/demo.toml")).unwrap()
}

fn reader(text: &[u8]) -> Reader {
    Reader::from_read(Box::new(Cursor::new(text.to_vec())), "bus").unwrap()
}

/// The simulated bus, as a log.
fn bus() -> Vec<u8> {
    let mut text = Vec::new();
    testing::bus::bus().iter().for_each(|frame| write_line(&mut text, "can0", frame));
    text
}

/// Takes everything, so that nothing is optimized away.
#[derive(Default)]
struct Samples(Vec<Sample>);

impl Sink for Samples {
    fn estimates(&mut self, sample: &Sample, _: &Estimates) {
        self.0.push(*sample);
    }

    fn publish(&mut self, _: &Frame) {}
}

struct Nowhere;

impl Sink for Nowhere {
    fn estimates(&mut self, _: &Sample, estimates: &Estimates) {
        black_box(estimates);
    }

    fn publish(&mut self, frame: &Frame) {
        black_box(frame);
    }
}

fn reading(criterion: &mut Criterion) {
    let text = bus();
    let mut group = criterion.benchmark_group("candump");
    let read = |mut reader: Reader| while black_box(reader.next_frame().unwrap()).is_some() {};
    group.throughput(Throughput::Bytes(text.len() as u64));
    group.bench_function("read, bytes", |b| {
        b.iter_batched(|| reader(&text), read, BatchSize::LargeInput);
    });
    let all = frames(&text);
    group.throughput(Throughput::Elements(all.len() as u64));
    group.bench_function("read, frames", |b| {
        b.iter_batched(|| reader(&text), read, BatchSize::LargeInput);
    });
    group.bench_function("write, frames", |b| {
        b.iter(|| {
            let mut writer = Writer::new(std::io::sink(), "can0");
            all.iter().for_each(|frame| writer.write(frame).unwrap());
        });
    });
    group.finish();
}

fn stages(criterion: &mut Criterion) {
    let config = config();
    let database = config.input_database().unwrap();
    let all = frames(&bus());
    let inputs = || Inputs::compile(&config.signals, &database, config.vehicle.wheel_radius_m.value).unwrap();
    let mut group = criterion.benchmark_group("stage");

    group.throughput(Throughput::Elements(all.len() as u64));
    group.bench_function("decode and sample, frames", |b| {
        let sampler = || Sampler::new(inputs(), &config.signals.sampling);
        let run = |mut sampler: Sampler| {
            for frame in &all {
                sampler.push(frame);
                while let Some(sample) = sampler.next_sample() {
                    black_box(&sample);
                }
            }
        };
        b.iter_batched(sampler, run, BatchSize::LargeInput);
    });

    let mut samples = Samples::default();
    let mut engine = Engine::new(&config).unwrap();
    all.iter().for_each(|frame| engine.frame(frame, &mut samples));
    let samples = samples.0;
    let inputs = inputs();
    let mut sensors = Sensors::default();
    for quantity in Quantity::ALL.into_iter().filter(|quantity| inputs.has(*quantity)) {
        sensors.add(quantity, inputs.noise_std(quantity));
    }
    let pipeline = || Pipeline::new(&config.vehicle, &sensors, &config.estimators);
    group.throughput(Throughput::Elements(samples.len() as u64));
    group.bench_function("estimate, samples", |b| {
        let run = |mut pipeline: Pipeline| {
            for sample in &samples {
                black_box(pipeline.step(sample));
            }
        };
        b.iter_batched(pipeline, run, BatchSize::LargeInput);
    });

    let mut pipeline = pipeline();
    let estimates: Vec<Estimates> = samples.iter().map(|sample| *pipeline.step(sample)).collect();
    let publisher = || Publisher::new(&built_in_database().unwrap(), &PublishConfig::default()).unwrap();
    group.throughput(Throughput::Elements(estimates.len() as u64));
    group.bench_function("publish, rounds of six frames", |b| {
        let run = |mut publisher: Publisher| {
            for (sample, estimates) in samples.iter().zip(&estimates) {
                publisher.publish(sample.time, estimates, &mut |frame| {
                    black_box(frame);
                });
            }
        };
        b.iter_batched(publisher, run, BatchSize::LargeInput);
    });
    group.finish();
}

fn whole(criterion: &mut Criterion) {
    let config = config();
    let text = bus();
    let all = frames(&text);
    let engine = || Engine::new(&config).unwrap();
    let mut group = criterion.benchmark_group("whole");
    group.throughput(Throughput::Elements(all.len() as u64));
    group.bench_function("engine, frames", |b| {
        let run = |mut engine: Engine| all.iter().for_each(|frame| engine.frame(frame, &mut Nowhere));
        b.iter_batched(engine, run, BatchSize::LargeInput);
    });
    group.bench_function("replay in memory, frames", |b| {
        let run = |(mut reader, mut engine): (Reader, Engine)| {
            while let Some(frame) = reader.next_frame().unwrap() {
                engine.frame(&frame, &mut Nowhere);
            }
        };
        b.iter_batched(|| (reader(&text), engine()), run, BatchSize::LargeInput);
    });
    group.finish();
}

criterion_group!(benches, reading, stages, whole);

/// `GRIPD_RENEW=1 cargo bench --bench pipeline` writes the medians into the guide's results, too.
fn main() {
    benches();
    Criterion::default().configure_from_args().final_summary();
    if renew() {
        let section =
            Section { name: "speeds", seed: "seed 1", tolerance: 0.0, header: "on one core | median" };
        section.write(&["candump", "stage", "whole"].map(measured).concat());
    }
}
