//! Identification of a 200 s recording at 100 Hz (20,000 rows), two parameters, from one start.

#![allow(missing_docs, reason = "the macros of criterion make functions without")]
#![allow(clippy::unwrap_used, reason = "a benchmark that fails may panic")]

use criterion::{Criterion, criterion_group, criterion_main};
use gripd::cli::reproduce::{Drive as Driven, SIM1};
use gripd::identify::{Drive, Identifier, IdentifyConfig, Record};
use gripd::model::Scenario;

fn sim1(criterion: &mut Criterion) {
    let scenario = Scenario::parse(&SIM1.replace("amplitude = 0.1", "amplitude = 0.01")).unwrap();
    let driven = Driven::simulate(&scenario, 1).unwrap();
    let records = [Record::new("sim1", &driven.samples, &driven.sensors)];
    let mut group = criterion.benchmark_group("identification");
    group.sample_size(10);
    for drive in [Drive::WheelSpeeds, Drive::Torque] {
        let config = IdentifyConfig {
            parameters: vec!["longitudinal_stiffness".into(), "lateral_stiffness".into()],
            drive: Some(drive),
            ..IdentifyConfig::default()
        };
        let identifier = Identifier::new(&records, &scenario.vehicle, &config).unwrap();
        group.bench_function(format!("{drive:?}"), |bencher| {
            bencher.iter(|| identifier.search(&[36.0, 9.6]));
        });
    }
    group.finish();
}

criterion_group!(benches, sim1);
criterion_main!(benches);
