//! Identification of C_x and C_y from 200 s at 100 Hz (20,000 rows), from one start: the thesis's problem
//! (5.26: slips and steering in; speed, yaw rate and lateral acceleration out), with tires that saturate.
//!
//! Beside it, in the same run, the same problem solved by scipy's `least_squares` over a Runge–Kutta
//! simulation compiled with numba, if `GRIPD_PYTHON` names a Python that has both. Compiling and importing
//! are not counted. We estimate the noise, the start of the motion and the errors, too; it does not.

#![allow(missing_docs, reason = "the macros of criterion make functions without")]
#![allow(clippy::unwrap_used, reason = "a benchmark that fails may panic")]

use std::fmt::Write as _;
use std::process::Command;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use gripd::identify::{Identifier, IdentifyConfig, LongitudinalInput, Method, Record};
use gripd::model::scenario::thesis::{SIM1, steered};
use gripd::model::simulate::SimulatedDrive;
use gripd::model::{GRAVITY, Vehicle};

const START_N: [f64; 2] = [1.5e5, 4e4];

/// Sim1 with gentle steering, as measured; its slips are those of the plant.
fn problem() -> (Vehicle, [Record; 1]) {
    let scenario = steered(SIM1, 0.01, true).unwrap();
    let driven = SimulatedDrive::simulate(&scenario, 1).unwrap();
    let mut record = Record::new("sim1", &driven.samples, &driven.sensors);
    for (row, truth) in record.rows.iter_mut().zip(&driven.truth) {
        row.slip = truth.slip;
        row.steering = truth.steer;
    }
    (scenario.vehicle, [record])
}

fn config() -> IdentifyConfig {
    IdentifyConfig {
        parameters: vec!["longitudinal_stiffness".into(), "lateral_stiffness".into()],
        drive: Some(LongitudinalInput::Slips),
        method: Method::FreeRun,
        ..IdentifyConfig::default()
    }
}

fn ours(criterion: &mut Criterion) {
    let ((vehicle, records), config) = (problem(), config());
    let identifier = Identifier::new(&records, &vehicle, &config).unwrap();
    let wheel_load = vehicle.mass() * GRAVITY / 4.0;
    let start = START_N.map(|newton| newton / wheel_load);
    let mut group = criterion.benchmark_group("identification");
    group.sample_size(10);
    group.bench_function("sim1", |bencher| bencher.iter(|| identifier.search(&start)));
    group.finish();
    let mut best = f64::INFINITY;
    let mut end = Vec::new();
    for _ in 0..10 {
        let begin = Instant::now();
        end = identifier.search(&start).unwrap().to;
        best = best.min(begin.elapsed().as_secs_f64());
    }
    println!("gripd: C_x {:.6e}, C_y {:.6e} in {:.4} s", end[0] * wheel_load, end[1] * wheel_load, best);
    if let Some(theirs) = theirs(&vehicle, &records[0]) {
        println!("ratio: {:.1}", theirs / best);
    }
}

/// Seconds that scipy and numba take, if they are there.
fn theirs(vehicle: &Vehicle, record: &Record) -> Option<f64> {
    let Some(python) = std::env::var_os("GRIPD_PYTHON") else {
        println!("GRIPD_PYTHON is not set: no comparison with scipy and numba");
        return None;
    };
    let mut table =
        String::from("steer,slip_fl,slip_fr,slip_rl,slip_rr,speed,yaw_rate,lateral_acceleration\n");
    for row in &record.rows {
        let [fl, fr, rl, rr] = row.slip;
        let speed = 0.5 * vehicle.wheel_radius_m.value * (row.wheel_speed[2] + row.wheel_speed[3]);
        let (yaw, ay) = (row.yaw_rate, row.lateral_acceleration);
        writeln!(table, "{},{fl},{fr},{rl},{rr},{speed},{yaw},{ay}", row.steering).unwrap();
    }
    let data = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(data.path(), table).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/identification_scipy.py");
    let output = Command::new(python).arg(script).arg(data.path()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    print!("{said}{}", String::from_utf8_lossy(&output.stderr));
    said.lines().find_map(|line| line.strip_prefix("seconds ")?.parse().ok())
}

criterion_group!(benches, ours);
criterion_main!(benches);
