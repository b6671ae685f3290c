//! Sim3 of the thesis and what lies beyond it: the slope's step is found, friction is a bound while it
//! is one, and a value once the driven tires are at their limit, whatever their curve.
#![allow(clippy::unwrap_used)] // Tests.

use gripd::cli::reproduce::{Drive, SIM3, SIM3_LIMIT};
use gripd::estimate::{EstimatorsConfig, Pipeline};
use gripd::estimates::{Estimates, MuSource};
use gripd::model::{Piece, Scenario, TireKind, Truth, Uncertain, Vehicle};

/// Runs the pipeline over a drive; the tires' stiffness is not known before.
fn drive(scenario: &Scenario, seed: u64) -> Vec<(Truth, Estimates)> {
    let drive = Drive::simulate(scenario, seed).unwrap();
    let unknown = Uncertain { value: 30.0, std: 15.0 };
    let vehicle = Vehicle { longitudinal_stiffness: unknown, ..drive.vehicle.clone() };
    let mut pipeline = Pipeline::new(&vehicle, &drive.sensors, &EstimatorsConfig::default());
    drive.samples.iter().zip(&drive.truth).map(|(s, t)| (*t, *pipeline.step(s))).collect()
}

fn scenario(text: &str) -> Scenario {
    Scenario::parse(text).unwrap()
}

/// Seconds of driving with |μ_x| > 0.05 from each change of the surface until it was noticed, and how
/// many were noticed that were none.
fn noticed(rows: &[(Truth, Estimates)], changes: &[f64]) -> (Vec<f64>, u32) {
    let (mut after, mut wrong, mut count) = (Vec::new(), 0, 0);
    let mut changes = changes.iter().copied().peekable();
    let mut waiting = None;
    for (truth, estimates) in rows {
        if changes.next_if(|change| truth.time.seconds() >= *change).is_some() {
            waiting = Some(0.0);
        }
        if let Some(informative) = &mut waiting
            && (truth.fx[0] / truth.fz[0]).abs() > 0.05
        {
            *informative += 0.01;
        }
        if estimates.surface_changes > count {
            count = estimates.surface_changes;
            match waiting.take() {
                Some(informative) => after.push(informative),
                None => wrong += 1,
            }
        }
    }
    (after, wrong)
}

#[test]
fn both_steps_of_the_slope_are_found_within_two_seconds_and_friction_stays_a_bound() {
    let scenario = scenario(SIM3);
    let mut slowest = 0.0_f64;
    for seed in 1..=24 {
        let rows = drive(&scenario, seed);
        let (after, wrong) = noticed(&rows, &[100.0, 150.0]);
        assert_eq!((after.len(), wrong), (2, 0), "seed {seed}: {after:?}");
        slowest = after.into_iter().fold(slowest, f64::max);
        for (truth, estimates) in &rows {
            let t = truth.time.seconds();
            let friction = &estimates.friction;
            assert!(matches!(friction.source, MuSource::None | MuSource::LowerBound), "seed {seed}, {t} s");
            assert_eq!((friction.max, friction.high, friction.valid), (None, None, false));
            assert!(friction.low.is_none_or(|low| low <= truth.mu_max), "seed {seed}, {t} s: {friction:?}");
            let settled = [60.0..100.0, 110.0..150.0, 160.0..200.0].iter().any(|s| s.contains(&t));
            if settled {
                let slope = estimates.slope[0].unwrap().value;
                assert!((slope / truth.slope[0] - 1.0).abs() < 0.1, "seed {seed}, {t} s: {slope}");
            }
        }
    }
    println!("noticed within {slowest:.2} s of driving");
    assert!(slowest <= 2.0, "{slowest}");
}

/// What came of one drive to the limit.
#[derive(Debug, Default)]
struct Found {
    /// Seconds from reaching the limit to the first valid value; none if never.
    after_s: Option<f64>,
    /// Largest relative error of a valid value.
    worst: f64,
    /// Samples with a valid value, and of those with the truth in the interval.
    valid: [u32; 2],
    /// Largest use of friction of the whole drive.
    most_used: f64,
    /// Valid values before the limit was reached.
    early: u32,
}

fn judge(rows: &[(Truth, Estimates)], limit: f64) -> Found {
    let mut found = Found::default();
    let mut reached = None;
    for (truth, estimates) in rows {
        let t = truth.time.seconds();
        let used = truth.mu_used / truth.mu_max;
        found.most_used = found.most_used.max(used);
        if used >= limit {
            reached = reached.or(Some(t));
        }
        let friction = &estimates.friction;
        let (true, Some(max)) = (friction.valid, friction.max) else { continue };
        match reached {
            Some(reached) => found.after_s = found.after_s.or(Some(t - reached)),
            None => found.early += 1,
        }
        assert!(!matches!(friction.source, MuSource::None | MuSource::LowerBound));
        found.worst = found.worst.max((max / truth.mu_max - 1.0).abs());
        let interval = friction.low.unwrap()..=friction.high.unwrap();
        found.valid[0] += 1;
        found.valid[1] += u32::from(interval.contains(&truth.mu_max));
    }
    found
}

#[test]
fn at_the_halved_limit_friction_is_found_within_two_seconds_and_five_percent() {
    let scenario = scenario(SIM3_LIMIT);
    let (mut latest, mut worst) = (0.0_f64, 0.0_f64);
    for seed in 1..=24 {
        let rows = drive(&scenario, seed);
        let found = judge(&rows, 0.999);
        assert_eq!(found.early, 0, "seed {seed}: a value at half of the friction on full grip");
        assert_eq!(found.valid[0], found.valid[1], "seed {seed}: {found:?}");
        latest = latest.max(found.after_s.unwrap());
        worst = worst.max(found.worst);
        let (after, wrong) = noticed(&rows, &[100.0, 150.0]);
        assert_eq!((after.len(), wrong), (2, 0), "seed {seed}: wheel spin is no change of surface");
    }
    println!("found within {latest:.2} s, off by {:.1} % at most", 100.0 * worst);
    assert!(latest <= 2.0 && worst <= 0.05, "{latest} s, {worst}");
}

/// A straight drive on one surface; drive torque (both wheels, over time) beyond a gentle sine.
fn on_one_surface(tire: TireKind, friction: f64, slope: f64, extra: Vec<[f64; 2]>) -> Scenario {
    let mut scenario = scenario(SIM3);
    scenario.duration_s = 60.0;
    scenario.initial_speed_mps = 15.0;
    scenario.vehicle.tire = tire;
    scenario.vehicle.friction.value = friction;
    scenario.vehicle.longitudinal_stiffness.value = slope;
    scenario.road.clear();
    let limit = 2.0 * friction * scenario.vehicle.static_wheel_load(true) * 0.31;
    scenario.drive_torque = vec![
        Piece::Sine {
            amplitude: 0.15 * limit,
            offset: 0.15 * limit,
            frequency_hz: 0.1,
            phase_rad: 0.0,
            from_s: 0.0,
            to_s: f64::INFINITY,
        },
        Piece::Points { points: extra.into_iter().map(|[t, share]| [t, share * limit]).collect() },
    ];
    scenario
}

const TIRES: [TireKind; 3] = [TireKind::Piecewise, TireKind::Brush, TireKind::MagicFormula];
const SURFACES: [(f64, f64); 4] = [(1.0, 50.0), (0.6, 50.0), (0.4, 30.0), (0.2, 30.0)];

#[test]
fn the_limit_is_found_whatever_the_curve_of_the_tire() {
    for tire in TIRES {
        for (friction, slope) in SURFACES {
            let spin = vec![[40.0, 0.0], [42.0, 1.0], [42.6, 1.0], [43.0, 0.0]];
            let scenario = on_one_surface(tire, friction, slope, spin);
            for seed in 1..=5 {
                let found = judge(&drive(&scenario, seed), 0.95);
                println!("{tire:?} {friction} {slope}: {found:?}");
            }
        }
    }
}

#[test]
fn below_the_limit_friction_is_never_a_value() {
    for (i, seed) in (1..=20).enumerate() {
        let tire = TIRES[i % 3];
        let (friction, slope) = SURFACES[i % 4];
        // Several steps on the accelerator, slow and fast, to 60 % of the friction.
        let share = 0.58 - 0.3;
        let bursts = (0..8).flat_map(|burst| {
            let t = 12.0 + 6.0 * f64::from(burst);
            let rise = 0.1 + 0.2 * f64::from(burst % 4);
            [[t, 0.0], [t + rise, share], [t + rise + 1.0, share], [t + 2.0 * rise + 1.0, 0.0]]
        });
        let scenario = on_one_surface(tire, friction, slope, bursts.collect());
        let rows = drive(&scenario, seed);
        let found = judge(&rows, 0.999);
        assert!((0.4..0.62).contains(&found.most_used), "{found:?}");
        let values = rows.iter().filter(|(_, e)| e.friction.max.is_some()).count();
        println!(
            "{tire:?} {friction}: {values} values, valid {:?}, used {:.2}",
            found.valid, found.most_used
        );
    }
}
