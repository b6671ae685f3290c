//! The audit of the measurement chain: every single error is found and named, and clean drives are left alone.

use std::sync::OnceLock;

use gripd::explain::chain::{AuditFinding, ChainReport, Confidence, audit};
use gripd::model::{Scenario, Simulation, Vehicle};
use gripd::{Config, Micros, Quantity, Sample, Sensors};
use testing::program;
use testing::town::DRIVE;

const WHEELS: [Quantity; 4] =
    [Quantity::WheelSpeedFl, Quantity::WheelSpeedFr, Quantity::WheelSpeedRl, Quantity::WheelSpeedRr];

/// What a simulated drive measures, on the grid of 10 ms.
fn drive(scenario: &Scenario, seed: u64) -> Vec<Sample> {
    let mut simulation = Simulation::new(scenario, seed).unwrap();
    let mut points: Vec<Vec<(f64, f64)>> = vec![Vec::new(); Quantity::COUNT];
    while let Some(tick) = simulation.next_tick() {
        for reading in tick.readings {
            points[reading.quantity as usize].push((reading.time.seconds(), reading.value));
        }
    }
    let mut places = [0; Quantity::COUNT];
    (2..(scenario.duration_s * 100.0) as i64 - 2)
        .map(|row| {
            let mut sample = Sample::empty(Micros::from_millis(10 * row), 0.01);
            for quantity in Quantity::ALL {
                let (points, place) = (&points[quantity as usize], &mut places[quantity as usize]);
                let t = sample.time.seconds();
                while points.get(*place + 1).is_some_and(|next| next.0 <= t) {
                    *place += 1;
                }
                if let (Some(a), Some(b)) = (points.get(*place), points.get(*place + 1)) {
                    sample.set(quantity, a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0));
                }
            }
            sample
        })
        .collect()
}

fn scenario() -> Scenario {
    Scenario::parse(DRIVE).unwrap()
}

/// The clean drive that errors are put into.
fn clean() -> Vec<Sample> {
    static CLEAN: OnceLock<Vec<Sample>> = OnceLock::new();
    CLEAN.get_or_init(|| drive(&scenario(), 77)).clone()
}

fn judge(samples: &[Sample]) -> ChainReport {
    judge_as(samples, &scenario().vehicle)
}

fn judge_as(samples: &[Sample], vehicle: &Vehicle) -> ChainReport {
    let mut sensors = Sensors::default();
    for quantity in Quantity::ALL.into_iter().filter(|q| samples[100].get(*q).is_some()) {
        sensors.add(quantity, None);
    }
    audit(samples, vehicle, &sensors)
}

/// The clean drive with every value of some quantities changed.
fn changed(quantities: &[Quantity], change: impl Fn(f64) -> f64) -> Vec<Sample> {
    let mut samples = clean();
    for sample in &mut samples {
        for quantity in quantities {
            if let Some(value) = sample.get(*quantity) {
                sample.set(*quantity, change(value));
            }
        }
    }
    samples
}

fn swapped(one: Quantity, other: Quantity) -> Vec<Sample> {
    let mut samples = clean();
    for sample in &mut samples {
        if let (Some(a), Some(b)) = (sample.get(one), sample.get(other)) {
            sample.set(one, b);
            sample.set(other, a);
        }
    }
    samples
}

fn delayed(quantities: &[Quantity], rows: usize) -> Vec<Sample> {
    let source = clean();
    let mut samples = source.clone();
    for (i, sample) in samples.iter_mut().enumerate() {
        for quantity in quantities {
            if let Some(value) = source[i.saturating_sub(rows)].get(*quantity) {
                sample.set(*quantity, value);
            }
        }
    }
    samples
}

fn summary(report: &ChainReport) -> String {
    let line = |f: &AuditFinding| {
        format!(
            "{:?} {} {} {:?} ± {:?}: {}; or {:?}",
            f.confidence, f.effect, f.channel, f.value, f.std, f.evidence, f.or
        )
    };
    report.findings.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The one finding that is expected, surest of all, and at least so sure.
#[track_caller]
fn expect<'a>(report: &'a ChainReport, effect: &str, channel: &str, least: Confidence) -> &'a AuditFinding {
    let Some(first) = report.findings.first() else { panic!("{effect} of {channel}: nothing found") };
    assert_eq!((first.effect, first.channel.as_str()), (effect, channel), "{}", summary(report));
    assert!(first.confidence >= least, "{}", summary(report));
    let wrong = report.findings[1..].iter().find(|f| f.confidence == Confidence::Certain);
    assert!(wrong.is_none(), "{}", summary(report));
    first
}

#[test]
fn clean_drives_give_no_certain_finding() {
    let (mut certain, mut likely) = (Vec::new(), 0);
    for seed in 100..124 {
        let report = judge(&drive(&scenario(), seed));
        likely += report.findings.iter().filter(|f| f.confidence == Confidence::Likely).count();
        if report.findings.iter().any(|f| f.confidence == Confidence::Certain) {
            certain.push(summary(&report));
        }
    }
    assert!(certain.is_empty(), "{}", certain.join("\n"));
    assert!(likely <= 3, "{likely} likely findings in 24 clean drives");
}

#[test]
fn tires_at_their_limit_in_a_gust_are_no_delay_for_sure() {
    let sliding = include_str!("../../config/scenarios/sim1.toml");
    let gust = "[[effect]]\nkind = \"crosswind\"\nvalue = 900.0\nintervals = [[60.0, 70.0]]";
    let scenario = Scenario::parse(&format!("{sliding}\n{gust}")).unwrap();
    let vehicle = Config::load(&program::project("config/thesis.toml")).unwrap().vehicle;
    let report = judge_as(&drive(&scenario, scenario.seed), &vehicle);
    assert!(report.findings.iter().all(|f| f.confidence != Confidence::Certain), "{}", summary(&report));
}

/// GIVEN the demo's drive, which brakes on ice with its wheels at their limit THEN nothing is found wrong; a brake that is told
/// three times as strong as it is in every stop of another drive is.
#[test]
fn a_car_that_slides_to_a_stop_has_no_wrong_brake() {
    let demo = Scenario::parse(include_str!("../../config/scenarios/demo.toml")).unwrap();
    let vehicle = Config::load(&program::project("config/demo.toml")).unwrap().vehicle;
    let report = judge_as(&drive(&demo, 5), &vehicle);
    assert!(report.findings.is_empty(), "{}", summary(&report));
    let report = judge(&changed(&[Quantity::BrakePressure], |pressure| 3.0 * pressure));
    let found = expect(&report, "sensor_scale", "brake_pressure", Confidence::Likely);
    assert!((found.value.unwrap() - 2.0).abs() < 0.5, "{}", summary(&report));
}

#[test]
fn every_flipped_sign_is_named() {
    for quantity in [
        Quantity::YawRate,
        Quantity::LateralAcceleration,
        Quantity::SteeringWheelAngle,
        Quantity::LongitudinalAcceleration,
        Quantity::DriveTorque,
        Quantity::BrakePressure,
        Quantity::WheelSpeedRl,
        Quantity::WheelSpeedFr,
    ] {
        let report = judge(&changed(&[quantity], |value| -value));
        let finding = expect(&report, "sensor_sign", quantity.name(), Confidence::Certain);
        assert!(finding.repair.contains("gain"), "{}", finding.repair);
    }
}

#[test]
fn every_swapped_pair_of_wheels_is_named() {
    for (i, one) in WHEELS.into_iter().enumerate() {
        for other in &WHEELS[i + 1..] {
            let report = judge(&swapped(one, *other));
            expect(&report, "channel_swap", &format!("{one}/{other}"), Confidence::Certain);
        }
    }
}

#[test]
fn swapped_accelerations_are_named() {
    let report = judge(&swapped(Quantity::LateralAcceleration, Quantity::LongitudinalAcceleration));
    let channel = "lateral_acceleration/longitudinal_acceleration";
    expect(&report, "channel_swap", channel, Confidence::Certain);
}

#[test]
fn a_delay_of_40_ms_is_named_and_measured() {
    for (quantity, least) in [
        (Quantity::YawRate, Confidence::Certain),
        (Quantity::LateralAcceleration, Confidence::Likely),
        (Quantity::LongitudinalAcceleration, Confidence::Likely),
    ] {
        let report = judge(&delayed(&[quantity], 4));
        let finding = expect(&report, "sensor_delay", quantity.name(), least);
        let (delay, std) = (finding.value.unwrap(), finding.std.unwrap());
        assert!((delay - 0.04).abs() < 3.0 * std && std < 0.015, "{quantity}: {delay} ± {std}");
    }
    let report = judge(&delayed(&WHEELS, 4));
    expect(&report, "sensor_delay", "wheel_speed", Confidence::Likely);
    // Behind the steering wheel the car itself is late: more is needed, and never certain.
    let report = judge(&delayed(&[Quantity::SteeringWheelAngle], 12));
    let finding = expect(&report, "sensor_delay", "steering_wheel_angle", Confidence::Unclear);
    assert!(
        finding.confidence < Confidence::Certain && finding.or.iter().any(|or| or.contains("steering_lag"))
    );
}

#[test]
fn a_scale_of_some_percent_is_named_and_measured() {
    let wheels: Vec<(&str, Vec<Quantity>)> = WHEELS.iter().map(|q| (q.name(), vec![*q])).collect();
    let others = [
        Quantity::YawRate,
        Quantity::LateralAcceleration,
        Quantity::LongitudinalAcceleration,
        Quantity::SteeringWheelAngle,
    ];
    let mut cases: Vec<(&str, Vec<Quantity>)> = others.iter().map(|q| (q.name(), vec![*q])).collect();
    cases.extend(wheels);
    cases.push(("wheel_speed", WHEELS.to_vec()));
    for (name, quantities) in cases {
        // Understeer hides a smaller error of the steering.
        let error = if name == "steering_wheel_angle" { 0.12 } else { 0.05 };
        let report = judge(&changed(&quantities, |value| (1.0 + error) * value));
        let finding = expect(&report, "sensor_scale", name, Confidence::Unclear);
        let (value, std) = (finding.value.unwrap(), finding.std.unwrap());
        assert!((value - error).abs() < (3.0 * std).max(0.01), "{name}: {value} ± {std}");
    }
}

#[test]
fn mistaken_units_are_named() {
    let degree = 180.0 / std::f64::consts::PI;
    for (channel, quantities, factor, words) in [
        ("yaw_rate", vec![Quantity::YawRate], degree, "deg/s"),
        ("yaw_rate", vec![Quantity::YawRate], 1.0 / degree, "rad/s"),
        ("steering_wheel_angle", vec![Quantity::SteeringWheelAngle], degree, "deg"),
        ("steering_wheel_angle", vec![Quantity::SteeringWheelAngle], 1.0 / 15.5, "road wheels"),
        ("lateral_acceleration", vec![Quantity::LateralAcceleration], 1.0 / 9.81, "taken for m/s^2"),
        ("longitudinal_acceleration", vec![Quantity::LongitudinalAcceleration], 9.81, "taken for g"),
        ("wheel_speed", WHEELS.to_vec(), 3.6, "km/h"),
        ("wheel_speed", WHEELS.to_vec(), 1.0 / 3.6, "m/s"),
        ("wheel_speed", WHEELS.to_vec(), 0.316, "m/s"),
        ("wheel_speed_rr", vec![Quantity::WheelSpeedRr], 3.6, "km/h"),
    ] {
        let report = judge(&changed(&quantities, |value| factor * value));
        let finding = expect(&report, "sensor_scale", channel, Confidence::Certain);
        assert!(finding.repair.contains(words), "{channel} × {factor}: {}", finding.repair);
    }
}

#[test]
fn offsets_are_measured_and_gross_ones_are_findings() {
    for (quantity, ordinary, gross, least) in [
        (Quantity::YawRate, 0.01, 0.06, Confidence::Certain),
        (Quantity::LateralAcceleration, 0.2, 1.5, Confidence::Likely),
        (Quantity::SteeringWheelAngle, 0.06, 0.5, Confidence::Likely),
        (Quantity::LongitudinalAcceleration, 0.15, 1.5, Confidence::Likely),
    ] {
        let report = judge(&changed(&[quantity], |value| value + ordinary));
        let offset = report.offsets.iter().find(|o| o.channel == quantity.name()).unwrap();
        let own = match quantity {
            Quantity::YawRate => 0.002,
            Quantity::LateralAcceleration => 0.04,
            Quantity::SteeringWheelAngle => 0.005,
            _ => -0.03,
        };
        let error = offset.value - ordinary - own;
        assert!(error.abs() < (4.0 * offset.std).max(0.1 * ordinary), "{quantity}: {offset:?}");
        assert!(!report.findings.iter().any(|f| f.effect == "sensor_bias"), "{}", summary(&report));
        let report = judge(&changed(&[quantity], |value| value + gross));
        expect(&report, "sensor_bias", quantity.name(), least);
    }
}

/// GIVEN a late accelerometer, and whatever zeros the sensors have (or a configuration takes from them) THEN the delays are the
/// same.
#[test]
fn delays_are_the_same_whatever_the_offsets_are() {
    use Quantity::{LateralAcceleration, SteeringWheelAngle, YawRate};
    let late = delayed(&[LateralAcceleration], 4);
    let delays = |offsets: [f64; 3]| -> Vec<Option<f64>> {
        let mut samples = late.clone();
        for sample in &mut samples {
            for (quantity, offset) in
                [YawRate, LateralAcceleration, SteeringWheelAngle].into_iter().zip(offsets)
            {
                if let Some(value) = sample.get(quantity) {
                    sample.set(quantity, value + offset);
                }
            }
        }
        judge(&samples).relations.iter().map(|relation| relation.delay_s).collect()
    };
    let without = delays([0.0; 3]);
    assert!(without.iter().flatten().count() >= 4, "{without:?}");
    for offsets in [[0.03, -2.0, 0.2], [-0.05, 3.0, -0.3]] {
        for (delay, before) in delays(offsets).iter().zip(&without) {
            let (delay, before) = (delay.unwrap_or(f64::NAN), before.unwrap_or(f64::NAN));
            assert!(delay.is_nan() && before.is_nan() || (delay - before).abs() < 1e-3, "{delay} {before}");
        }
    }
}

/// GIVEN a car that is parked, its wheel sensors saying that it creeps THEN it has not moved, and nothing is wrong.
#[test]
fn a_parked_car_is_no_fault() {
    let mut samples = clean();
    samples.truncate(1000);
    for (row, sample) in samples.iter_mut().enumerate() {
        for wheel in WHEELS {
            sample.set(wheel, 0.1);
        }
        sample.set(Quantity::YawRate, if row % 2 == 0 { 0.001 } else { -0.001 });
    }
    let report = judge(&samples);
    assert_eq!(report.moving_seconds, 0.0);
    assert!(report.findings.is_empty() && !report.compared, "{}", summary(&report));
    assert!(report.offsets.iter().any(|offset| offset.from == "at standstill"));
}

/// GIVEN an axle whose wheels turn alike (a locked differential), and no accelerometer THEN that is why they tell of no curves: not
/// that too little happened.
#[test]
fn what_could_not_be_compared_has_its_reason() {
    let mut samples = clean();
    for (row, sample) in samples.iter_mut().enumerate() {
        let wheels = [Quantity::WheelSpeedRl, Quantity::WheelSpeedRr];
        if let [Some(left), Some(right)] = wheels.map(|wheel| sample.get(wheel)) {
            let mean = 0.5 * (left + right);
            // Each has teeth of its own.
            sample.set(wheels[0], mean + 0.01 * (0.7 * row as f64).sin());
            sample.set(wheels[1], mean + 0.01 * (1.1 * row as f64).cos());
        }
        sample.clear(Quantity::LateralAcceleration);
    }
    let report = judge(&samples);
    let said = |relation: &str| {
        let unclear = report.unclear.iter().find(|it| it.what.starts_with(relation));
        unclear.unwrap_or_else(|| panic!("{:?}", report.unclear)).what.clone()
    };
    assert!(said("rear wheel speed difference").contains("the axle is locked"), "{:?}", report.unclear);
    assert!(
        said("lateral acceleration").contains("there is no lateral_acceleration"),
        "{:?}",
        report.unclear
    );
}

#[test]
fn a_worn_tire_is_named() {
    for wheel in WHEELS {
        let report = judge(&changed(&[wheel], |value| value / 0.992));
        let finding = expect(&report, "tire_radius", wheel.name(), Confidence::Certain);
        assert!((finding.value.unwrap() + 0.008).abs() < 0.002, "{}", summary(&report));
    }
}

#[test]
fn a_motorway_gives_no_verdict_but_says_what_to_drive() {
    let text = DRIVE.split("[driver]").next().unwrap().to_owned()
        + "[driver]\n[[driver.speed_mps]]\nkind = \"constant\"\nvalue = 25\n"
        + &DRIVE[DRIVE.find("[sensors]").unwrap()..];
    let scenario = Scenario::parse(&text).unwrap();
    let mut samples = drive(&scenario, 5);
    for sample in &mut samples {
        let r = sample.get(Quantity::YawRate).unwrap();
        sample.set(Quantity::YawRate, -r);
    }
    let report = judge(&samples);
    assert!(report.findings.iter().all(|f| f.confidence < Confidence::Certain), "{}", summary(&report));
    assert!(report.unclear.iter().any(|u| u.to_do.contains("curves")), "{:?}", report.unclear);
}

#[test]
fn nothing_and_almost_nothing_are_answered() {
    let vehicle = scenario().vehicle;
    assert!(!audit(&[], &vehicle, &Sensors::default()).unclear.is_empty());
    assert!(!audit(&clean()[..3], &vehicle, &Sensors::default()).unclear.is_empty());
    let empty: Vec<Sample> = (0..500).map(|i| Sample::empty(Micros::from_millis(10 * i), 0.01)).collect();
    assert!(audit(&empty, &vehicle, &Sensors::default()).findings.is_empty());
}

/// GIVEN a car that stands for 15 s before a drive and 10 s after it WHEN the zero of its gyroscope moves by 0.05 rad/s all
/// along THEN that is told, with its size, and nothing else; WHEN it is still THEN nothing is.
#[test]
fn a_zero_that_moves_shows_while_the_car_stands() {
    let with_stops = |zero: fn(f64) -> f64| {
        let driven = clean();
        let stop = |seconds: usize, at: &Sample| {
            let mut stands = *at;
            WHEELS.iter().for_each(|wheel| stands.set(*wheel, 0.0));
            stands.set(Quantity::YawRate, 0.0);
            stands.set(Quantity::LateralAcceleration, 0.0);
            vec![stands; 100 * seconds]
        };
        let before = stop(15, &driven[0]);
        let after = stop(10, &driven[driven.len() - 1]);
        let mut all: Vec<Sample> = before.into_iter().chain(driven).chain(after).collect();
        let seconds = 0.01 * all.len() as f64;
        // It was recorded with pauses: no car stops from one moment to the next.
        let begins = [1500, all.len() - 1000];
        for (row, sample) in all.iter_mut().enumerate() {
            let pauses = begins.iter().filter(|begins| row >= **begins).count() as i64;
            sample.time = Micros::from_millis(10 * row as i64 + 1000 * pauses);
            sample.elapsed_s = if begins.contains(&row) { 1.01 } else { 0.01 };
            let share = 0.01 * row as f64 / seconds;
            let noise = [1e-3, -1e-3][row % 2];
            sample.set(Quantity::YawRate, sample.get(Quantity::YawRate).unwrap() + zero(share) + noise);
        }
        judge(&all)
    };
    let certain = |report: &ChainReport| -> Vec<AuditFinding> {
        let all = report.findings.iter().filter(|found| found.confidence == Confidence::Certain);
        all.cloned().collect()
    };
    let report = with_stops(|share| 0.05 * (5.0 * share).sin());
    let [drift] = &certain(&report)[..] else { panic!("{}", summary(&report)) };
    assert_eq!((drift.effect, drift.channel.as_str()), ("sensor_drift", "yaw_rate"));
    let (value, std) = drift.value.zip(drift.std).unwrap();
    assert!((value - 0.034).abs() < 2.0 * std && std < 0.05, "{value} ± {std}");
    assert!(certain(&with_stops(|_| 0.01)).is_empty());
}

/// Two minutes on an oval: straights and long curves, with small corrections.
fn oval(bank: f64) -> Vec<Sample> {
    let (straight, ramp, curve, angle) = (8.0, 2.0, 17.5, 0.11);
    let (mut steering, mut road) = (vec![[0.0, 0.0]], vec![[0.0, 0.0]]);
    let mut t = straight;
    for _ in 0..4 {
        for (at, share) in [(0.0, 0.0), (ramp, 1.0), (curve, 1.0), (curve + ramp, 0.0)] {
            steering.push([t + at, angle * share]);
            road.push([t + at, bank * share]);
        }
        t += curve + ramp + straight;
    }
    let car = &DRIVE[DRIVE.find("[vehicle]").unwrap()..DRIVE.find("[driver]").unwrap()];
    let sensors = &DRIVE[DRIVE.find("[sensors]").unwrap()..];
    let sensors = &sensors[..sensors.find("[[effect]]").unwrap_or(sensors.len())];
    let (times, banks): (Vec<f64>, Vec<f64>) = road.into_iter().map(|[t, bank]| (t, bank)).unzip();
    let text = format!(
        "duration_s = {t}\ninitial_speed_mps = 40\n{car}\n\
         [[steering_wheel_angle]]\nkind = \"points\"\npoints = {steering:?}\n\
         [[steering_wheel_angle]]\nkind = \"sine\"\namplitude = 0.015\nfrequency_hz = 0.41\n\
         [[drive_torque]]\nkind = \"sine\"\namplitude = 200\noffset = 320\nfrequency_hz = 0.07\n{sensors}\n\
         [[effect]]\nkind = \"road_bank\"\nseries = {{ t = {times:?}, value = {banks:?} }}\n"
    );
    drive(&Scenario::parse(&text).unwrap(), 5)
}

/// GIVEN an oval whose long curves are banked WHEN it is audited THEN the accelerometer, which feels less than speed and yaw rate
/// say, is neither called wrong nor late, and what else it could be is said. On a level one nothing is.
#[test]
fn a_banked_oval_makes_no_accelerometer_wrong() {
    let banked = judge(&oval(0.1));
    let is_of_lateral = |finding: &&AuditFinding| finding.channel == "lateral_acceleration";
    assert!(banked.findings.iter().all(|finding| !is_of_lateral(&finding)), "{}", summary(&banked));
    assert!(banked.unclear.iter().any(|unclear| unclear.what.contains("banked")), "{:?}", banked.unclear);
    let slope = banked.relations.iter().find(|relation| relation.relation.starts_with("lateral")).unwrap();
    assert!(slope.gain.unwrap() < 0.85, "the bank is felt: {slope:?}");
    let level = judge(&oval(0.0));
    assert!(level.unclear.iter().all(|unclear| !unclear.what.contains("banked")), "{:?}", level.unclear);
    assert!(level.findings.iter().all(|finding| !is_of_lateral(&finding)), "{}", summary(&level));
}
