//! How many Runge–Kutta steps of the four-wheel car one core does per second, for each tire model: of one
//! car, and of eight side by side. One element is a step of 1 ms of one car.

#![allow(missing_docs, reason = "the macros of criterion make functions without")]
#![allow(clippy::unwrap_used, reason = "a benchmark that fails may panic")]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use gripd::model::integrate::{advance_in, drive_abreast};
use gripd::model::{Abreast, Controls, Plant, State, TireKind, Vehicle};

/// Cars side by side.
const CARS: usize = 8;
/// Steps of theirs at a time.
const STEPS: usize = 100;

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("simulation");
    for kind in [TireKind::Linear, TireKind::Piecewise, TireKind::Brush, TireKind::MagicFormula] {
        let plant = Plant::new(&Vehicle { tire: kind, ..Vehicle::thesis() });
        let mut state = State::rolling(&plant, 20.0);
        let controls =
            Controls { steer: 0.01, drive_torque: [150.0, 150.0, 0.0, 0.0], ..Controls::default() };
        group.throughput(Throughput::Elements(1));
        group.bench_function(format!("{kind:?}"), |bencher| {
            bencher.iter(|| {
                state = advance_in(&plant, black_box(&state), &controls, &controls, &plant.nominal, 1e-3, 1);
            });
        });
        let plants = Plant::abreast(&[plant; CARS]).unwrap();
        let mut states = State::abreast(&[State::rolling(&plant, 20.0); CARS]).unwrap();
        let rows = vec![Controls::abreast(&[controls; CARS]).unwrap(); STEPS + 1];
        group.throughput(Throughput::Elements((CARS * STEPS) as u64));
        group.bench_function(format!("{kind:?}, eight side by side"), |bencher| {
            bencher.iter(|| {
                drive_abreast(&plants, black_box(&mut states), &rows, &plants.nominal, 1e-3, &mut |_| ());
            });
        });
    }
    group.finish();
}

criterion_group!(benches, steps);
criterion_main!(benches);
