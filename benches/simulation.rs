//! How many Runge–Kutta steps of the four-wheel car one core does per second, for each tire model. One element is a step
//! of 1 ms.

#![allow(missing_docs, reason = "the macros of criterion make functions without")]
#![allow(clippy::unwrap_used, reason = "a benchmark that fails may panic")]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use gripd::model::integrate::advance_in;
use gripd::model::{Controls, Plant, State, TireKind, Vehicle};

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
    }
    group.finish();
}

criterion_group!(benches, steps);
criterion_main!(benches);
