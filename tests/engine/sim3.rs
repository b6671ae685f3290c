//! Sim3 of the thesis and what lies beyond it: the slope's step is found, friction is a bound while it
//! is one, and a value once the driven tires are at their limit, whatever their curve.

use gripd::estimate::{AtLimit, EstimatorsConfig, Pipeline, SlipPoint, WheelSaturation};
use gripd::estimates::{Estimates, MuSource};
use gripd::model::scenario::Stretch;
use gripd::model::scenario::thesis::{SIM2, SIM3, SIM3_LIMIT};
use gripd::model::simulate::SimulatedDrive;
use gripd::model::{Piece, Scenario, TireKind, Truth, Uncertain, Vehicle};
use gripd::reproduce::noticed;
use testing::results::Section;

/// Runs the pipeline over a drive; the tires' stiffness is not known before.
fn drive(scenario: &Scenario, seed: u64) -> Vec<(Truth, Estimates)> {
    drive_with(scenario, seed, &EstimatorsConfig::default())
}

fn drive_with(scenario: &Scenario, seed: u64, config: &EstimatorsConfig) -> Vec<(Truth, Estimates)> {
    let drive = SimulatedDrive::simulate(scenario, seed).unwrap();
    let unknown = Uncertain { value: 30.0, std: 15.0 };
    let vehicle = Vehicle { longitudinal_stiffness: unknown, ..drive.vehicle.clone() };
    let mut pipeline = Pipeline::new(&vehicle, &drive.sensors, config);
    drive.samples.iter().zip(&drive.truth).map(|(s, t)| (*t, *pipeline.step(s))).collect()
}

fn scenario(text: &str) -> Scenario {
    Scenario::parse(text).unwrap()
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
            if settled && truth.mu_used > 0.05 {
                let slope = estimates.slope[0].unwrap();
                let error = (slope.value / truth.slope[0] - 1.0).abs();
                assert!(error < 0.1, "seed {seed}, {t} s: {slope:?}");
            }
        }
    }
    let section = Section {
        name: "sim3_steps",
        seed: "seeds 1 to 24",
        tolerance: 0.02,
        header: "Sim3 | found | within, of driving",
    };
    section.check(&[format!("both steps of the slope | all | {slowest:.2} s")]);
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
    let section = Section {
        name: "sim3_limit",
        seed: "seeds 1 to 24",
        tolerance: 0.02,
        header: "Sim3 at half of the friction | valid after, at most | off by, at most",
    };
    section.check(&[format!("friction at the limit | {latest:.2} s | {:.1} %", 100.0 * worst)]);
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

/// A step on the accelerator that makes the wheels spin for half a second.
const SPIN: [[f64; 2]; 4] = [[40.0, 0.0], [42.0, 1.0], [42.6, 1.0], [43.0, 0.0]];

#[test]
fn the_limit_is_found_whatever_the_curve_of_the_tire() {
    let (mut latest, mut worst, mut wrong_changes) = (0.0_f64, 0.0_f64, 0);
    for tire in TIRES {
        for (friction, slope) in &SURFACES[1..] {
            let scenario = on_one_surface(tire, *friction, *slope, SPIN.to_vec());
            for seed in 1..=4 {
                let rows = drive(&scenario, seed);
                let found = judge(&rows, 0.95);
                assert_eq!(
                    (found.early, found.valid[0]),
                    (0, found.valid[1]),
                    "{tire:?} {friction}: {found:?}"
                );
                latest = latest.max(found.after_s.unwrap());
                worst = worst.max(found.worst);
                let wrong = noticed(&rows, &[]).1;
                if wrong > 0 {
                    println!("{tire:?} {friction} {seed}: {wrong}");
                }
                wrong_changes += wrong;
            }
        }
    }
    let section = Section {
        name: "limit_by_tire",
        seed: "seeds 1 to 4",
        tolerance: 0.02,
        header: "wheels spin for half a second, three shapes of tire, friction 0.6 to 0.2 | valid after, at most | off by, at most | wrong changes of surface",
    };
    section.check(&[format!(
        "friction at the limit | {latest:.2} s | {:.1} % | {wrong_changes}",
        100.0 * worst
    )]);
    assert!(latest <= 1.0 && worst <= 0.05, "{latest} s, {worst}");
}

/// At full grip half a g of acceleration moves a sixth of the front axle's load to the rear, which the
/// estimators do not know: the value is right for the static load, its interval too wide to act upon.
#[test]
fn at_full_grip_the_load_transfer_keeps_the_value_from_being_valid() {
    for tire in TIRES {
        let rows = drive(&on_one_surface(tire, 1.0, 50.0, SPIN.to_vec()), 1);
        let published = rows.iter().filter(|(_, e)| e.friction.source == MuSource::Limit);
        let errors: Vec<f64> = published.map(|(_, e)| (e.friction.max.unwrap() - 1.0).abs()).collect();
        assert!(!errors.is_empty() && errors.iter().all(|e| *e < 0.05), "{tire:?}: {errors:?}");
        assert_eq!(judge(&rows, 0.95).valid[0], 0);
    }
}

#[test]
fn the_accelerometer_alone_finds_the_limit_too() {
    let mut scenario = on_one_surface(TireKind::Brush, 0.5, 40.0, SPIN.to_vec());
    scenario.sensors.by_name.remove("drive_torque");
    for seed in 1..=8 {
        let found = judge(&drive(&scenario, seed), 0.95);
        println!("{found:?}");
        assert!(
            found.after_s.is_some_and(|after| after < 2.0) && found.worst < 0.06,
            "seed {seed}: {found:?}"
        );
    }
}

/// A traction control cycles the torque about the limit.
#[test]
fn a_traction_control_does_not_hide_the_limit() {
    let mut cycles = vec![[40.0, 0.0]];
    for cycle in 0..5 {
        let t = 41.0 + 0.5 * f64::from(cycle);
        cycles.extend([[t, 1.15], [t + 0.1, 1.15], [t + 0.25, 0.4], [t + 0.35, 0.5]]);
    }
    cycles.push([44.0, 0.0]);
    for tire in TIRES {
        for seed in 1..=4 {
            let found = judge(&drive(&on_one_surface(tire, 0.4, 30.0, cycles.clone()), seed), 0.95);
            println!("{tire:?} {found:?}");
            assert!(
                found.after_s.is_some_and(|after| after < 3.0) && found.worst < 0.1,
                "seed {seed}: {found:?}"
            );
        }
    }
}

#[test]
fn below_the_limit_friction_is_never_a_value() {
    for (i, seed) in (1..=24).enumerate() {
        let tire = TIRES[i % 3];
        let (friction, slope) = SURFACES[i / 3 % 4];
        // Several steps on the accelerator, slow and fast, to 60 % of the friction.
        let share = 0.58 - 0.3;
        let bursts = (0..8).flat_map(|burst| {
            let t = 12.0 + 6.0 * f64::from(burst);
            let rise = 0.1 + 0.2 * f64::from(burst % 4);
            [[t, 0.0], [t + rise, share], [t + rise + 1.0, share], [t + 2.0 * rise + 1.0, 0.0]]
        });
        let rows = drive(&on_one_surface(tire, friction, slope, bursts.collect()), seed);
        let most_used = judge(&rows, 0.999).most_used;
        assert!((0.4..0.6).contains(&most_used), "{most_used}");
        let values = rows.iter().filter(|(_, e)| e.friction.max.is_some()).count();
        assert_eq!(values, 0, "{tire:?} {friction}, seed {seed}");
    }
}

/// Softer and stiffer surfaces in turn, at a force that stays: the slip goes up and down by a multiple,
/// and nowhere is the limit.
#[test]
fn surfaces_that_change_at_constant_force_are_no_limit() {
    for (seed, transition_s) in [(1, 0.0), (2, 0.05), (3, 0.1), (4, 0.2), (5, 0.3)] {
        let mut scenario = on_one_surface(TireKind::Piecewise, 1.0, 90.0, vec![[10.0, 0.0], [11.0, 0.1]]);
        scenario.road = (0..20)
            .map(|i| Stretch {
                from_s: 12.0 + 2.3 * f64::from(i),
                transition_s,
                slope: Some(if i % 2 == 0 { 25.0 } else { 90.0 }),
                ..Stretch::default()
            })
            .collect();
        for (truth, estimates) in drive(&scenario, seed) {
            assert_ne!(
                estimates.friction.source,
                MuSource::Limit,
                "{transition_s} s: {}",
                truth.time.seconds()
            );
        }
    }
}

fn braking(slip: f64, mu: f64) -> SlipPoint {
    SlipPoint { slip: -slip, slip_std: 1e-4, mu: -mu, mu_std: 0.002 }
}

#[test]
fn braking_forces_at_their_limit_are_seen_like_driving_forces() {
    let mut wheel = WheelSaturation::new();
    let curve = |slip: f64| (30.0 * slip).min(0.45);
    let slips = [0.004, 0.008, 0.012, 0.016, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07];
    let found: Vec<_> = slips.iter().filter_map(|s| wheel.step(braking(*s, curve(*s)), 30.0)).collect();
    assert!(
        found.last().is_some_and(|found| (found.mu - 0.45).abs() < 0.005 && !found.is_beyond),
        "{found:?}"
    );
    let mut wheel = WheelSaturation::new();
    assert!(slips.iter().all(|s| wheel.step(braking(*s, 10.0 * s), 10.0).is_none()), "a line has no limit");
}

/// GIVEN a magic formula's tire of shape 1.6 WHEN its wheel is seen through the limit THEN that is the friction; where it is seen
/// spinning only, at 60 % of it, the tire is told to be beyond its limit.
#[test]
fn a_wheel_that_spins_far_beyond_its_limit_gives_less() {
    let (friction, slope, shape) = (0.4, 30.0, 1.6);
    let curve = |slip: f64| friction * f64::sin(shape * f64::atan(slope * slip / (shape * friction)));
    let seen = |slips: &[f64]| {
        let mut wheel = WheelSaturation::new();
        let point = |slip: &f64| SlipPoint { slip: *slip, slip_std: 1e-4, mu: curve(*slip), mu_std: 0.002 };
        slips.iter().filter_map(|slip| wheel.step(point(slip), slope)).last()
    };
    let through = seen(&[0.005, 0.01, 0.015, 0.02, 0.025, 0.03, 0.035, 0.04, 0.05, 0.06, 0.07]);
    let is_the_friction = |found: AtLimit| (found.mu / friction - 1.0).abs() < 0.03 && !found.is_beyond;
    assert!(through.is_some_and(is_the_friction), "{through:?}");
    let spinning = seen(&[0.8, 1.0, 1.3, 1.6, 2.0, 2.4, 2.9]);
    let is_less = |found: AtLimit| (0.55..0.7).contains(&(found.mu / friction)) && found.is_beyond;
    assert!(spinning.is_some_and(is_less), "{spinning:?}");
}

/// Seconds for which the lower bound was above the friction, and its mean.
fn bound_of_sim2(seed: u64, surface_lasts_s: f64) -> (f64, f64) {
    let mut config = EstimatorsConfig::default();
    config.friction.surface_lasts_s = surface_lasts_s;
    let rows = drive_with(&scenario(SIM2), seed, &config);
    let bound = |e: &Estimates| e.friction.low.unwrap_or(0.0);
    let above = rows.iter().filter(|(t, e)| bound(e) > t.mu_max).count() as f64 * 0.01;
    let mean = rows.iter().map(|(_, e)| bound(e)).sum::<f64>() / rows.len() as f64;
    (above, mean)
}

#[test]
fn the_lower_bound_ages_before_a_fall_of_friction_is_noticed() {
    let (mut for_ever, mut ageing) = ((0.0, 0.0), (0.0, 0.0));
    for seed in 1..=6 {
        for (sum, lasts) in [(&mut for_ever, 1e9), (&mut ageing, 10.0)] {
            let (above, mean) = bound_of_sim2(seed, lasts);
            sum.0 += above / 6.0;
            sum.1 += mean / 6.0;
        }
    }
    println!("above the friction for {for_ever:.2?} s and {ageing:.2?} s of 200 s; mean bound");
    assert!(ageing.0 < 0.6 * for_ever.0 && ageing.0 < 2.0, "{ageing:?} {for_ever:?}");
    assert!(ageing.1 > 0.8 * for_ever.1, "the bound is still worth something: {ageing:?} {for_ever:?}");
}
