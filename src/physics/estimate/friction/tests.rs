use super::*;
use crate::model::Vehicle;

fn sample(ax: f64, ay: f64) -> Kinematics {
    Kinematics {
        elapsed_s: 0.01,
        speed: Some(20.0),
        wheels: Some([20.0; 4]),
        yaw_rate: Some(ay / 20.0),
        lateral_acceleration: Some(ay),
        longitudinal_acceleration: Some(ax),
        road_angle: Some(0.0),
        rear_angle: 0.0,
        axle_torque: None,
        braking: None,
        abs: None,
    }
}

#[test]
fn gentle_driving_gives_a_bound_and_no_value() {
    let car = Car::new(&Vehicle::thesis());
    let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
    let brush = Some(BrushFriction { mu: 0.9, std: 0.01, is_bound: false, is_doubted: false, age_s: 0.0 });
    let mut friction = Friction::default();
    for _ in 0..200 {
        friction = monitor.step(&sample(0.0, 2.0), Some(0.0), Evidence { brush, ..Evidence::default() });
    }
    assert_eq!(friction.source, MuSource::LowerBound);
    assert_eq!((friction.max, friction.high, friction.valid), (None, None, false));
    assert!((friction.low.unwrap() - 0.174).abs() < 0.01, "{friction:?}");
}

#[test]
fn an_offset_of_the_accelerometer_is_no_use_of_friction() {
    let car = Car::new(&Vehicle::thesis());
    let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
    let straight = Kinematics { yaw_rate: Some(0.0), ..sample(0.0, -5.1) };
    let mut friction = Friction::default();
    for _ in 0..200 {
        friction = monitor.step(&straight, Some(0.0), Evidence::default());
    }
    assert!(friction.low.is_none_or(|low| low < 0.05), "{friction:?}");
}

#[test]
fn the_bound_ages_and_a_change_of_surface_forgets_it() {
    let car = Car::new(&Vehicle::thesis());
    let config = FrictionConfig { surface_lasts_s: 10.0, ..FrictionConfig::default() };
    let mut monitor = FrictionMonitor::new(&car, &config);
    let after = |monitor: &mut FrictionMonitor, ay, samples| {
        let mut friction = Friction::default();
        for _ in 0..samples {
            friction = monitor.step(&sample(0.0, ay), Some(0.0), Evidence::default());
        }
        friction
    };
    let turning = after(&mut monitor, 6.0, 200);
    assert!((turning.low.unwrap() - 0.56).abs() < 0.02, "{turning:?}");
    // With 45 % it is another surface by now, and all of those are as likely.
    let later = after(&mut monitor, 0.0, 600);
    assert!((later.low.unwrap() - 0.025 / 0.45 * 1.3).abs() < 0.03, "{later:?}");
    after(&mut monitor, 6.0, 200);
    monitor.surface_changed();
    assert!(after(&mut monitor, 0.0, 1).low.is_none_or(|low| low < 0.56));
    assert_eq!(after(&mut monitor, 0.0, 100).source, MuSource::LowerBound);
    monitor.surface_changed();
    assert_eq!(after(&mut monitor, 0.0, 1).source, MuSource::None);
}

#[test]
fn a_mapping_is_published_with_its_interval_and_never_as_certain() {
    let car = Car::new(&Vehicle::thesis());
    let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
    let map = Some(MappedFriction { mu: 0.5, low: 0.35, high: 0.65 });
    let evidence = Evidence { map, ..Evidence::default() };
    let friction = monitor.step(&sample(0.0, 0.0), Some(0.0), evidence);
    assert_eq!((friction.source, friction.valid), (MuSource::SlopeMap, false));
    assert_eq!((friction.max, friction.low, friction.high), (Some(0.5), Some(0.35), Some(0.65)));
    let limit =
        Some(LimitFriction { mu: 0.8, std: [0.02; 2], is_beyond: false, is_one_sided: false, age_s: 0.0 });
    let measured = Evidence { limit, ..evidence };
    assert_eq!(monitor.step(&sample(0.0, 0.0), Some(0.0), measured).source, MuSource::Limit);
    // Using more than it allows refutes it.
    let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
    let mut braking = Friction::default();
    for _ in 0..200 {
        braking = monitor.step(&sample(0.0, 8.0), Some(0.0), evidence);
    }
    assert_eq!((braking.source, braking.max), (MuSource::LowerBound, None), "{braking:?}");
}

#[test]
fn an_abs_braking_is_believed_for_a_while_and_then_widens() {
    let car = Car::new(&Vehicle::thesis());
    let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
    let braking = Kinematics { abs: Some(true), ..sample(-4.0, 0.0) };
    let brake = |monitor: &mut FrictionMonitor| {
        let step = |i: i32| {
            let abs_working_s = Some(0.01 * f64::from(i));
            let working = Evidence { abs_working_s, brakes_at_limit: Some(true), ..Evidence::default() };
            monitor.step(&braking, Some(-4.0), working)
        };
        (0..150).map(step).last().unwrap()
    };
    let mut all = vec![brake(&mut monitor)];
    all.extend((0..2000).map(|_| monitor.step(&sample(0.0, 0.0), Some(0.0), Evidence::default())));
    assert!(all[0].valid && all[0].source == MuSource::Abs, "{:?}", all[0]);
    assert!((all[0].max.unwrap() - 0.4).abs() < 0.01);
    assert_eq!(all[0].age_s, Some(0.0));
    let width = |friction: &Friction| friction.high.unwrap_or(2.0) - friction.low.unwrap_or(0.0);
    assert!(all.windows(2).all(|pair| width(&pair[1]) > width(&pair[0]) - 1e-3));
    let opened = all.iter().position(|friction| !friction.valid).unwrap();
    assert!(all[opened..].iter().all(|friction| !friction.valid));
    assert_eq!(all[2000].max, None);
    // Using more than it gave is another surface.
    brake(&mut monitor);
    let mut turning = Friction::default();
    for _ in 0..100 {
        turning = monitor.step(&sample(0.0, 8.0), Some(0.0), Evidence::default());
    }
    assert_eq!((turning.source, turning.max), (MuSource::LowerBound, None));
    assert!(turning.low > Some(0.7));
}

#[test]
fn an_abs_that_works_for_one_wheel_bounds_nothing_from_above() {
    let car = Car::new(&Vehicle::thesis());
    let braking = Kinematics { abs: Some(true), ..sample(-4.0, 0.0) };
    let brake = |brakes_at_limit: Option<bool>| {
        let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
        let step = |i: i32| {
            let abs_working_s = Some(0.01 * f64::from(i));
            let working = Evidence { abs_working_s, brakes_at_limit, ..Evidence::default() };
            monitor.step(&braking, Some(-4.0), working)
        };
        (0..150).map(step).last().unwrap()
    };
    let [refuted, unseen, seen] = [Some(false), None, Some(true)].map(brake);
    assert_eq!((refuted.source, refuted.high), (MuSource::LowerBound, None));
    assert!(!unseen.valid && unseen.high > Some(0.75), "{unseen:?}");
    assert!(seen.valid && seen.high < Some(0.55), "{seen:?}");
}

#[test]
fn brakes_that_are_let_go_are_no_limit_while_the_flag_stays_on() {
    let car = Car::new(&Vehicle::thesis());
    // Half a second at 9 m/s², then half a second of less and less; some wheels seem to slip.
    let stop = |held_s: f64, seen: Option<bool>| {
        let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
        let mut all = Vec::new();
        for i in 0..(100.0 * (held_s + 0.5)) as i32 {
            let t = 0.01 * f64::from(i);
            let ax = -9.0 + 14.0 * (t - held_s).clamp(0.0, 0.5);
            let braking = Kinematics { abs: Some(true), ..sample(ax, 0.0) };
            let working = Evidence { abs_working_s: Some(t), brakes_at_limit: seen, ..Evidence::default() };
            all.push(monitor.step(&braking, Some(ax), working));
        }
        all
    };
    for (held_s, seen) in [(0.5, Some(true)), (0.5, None), (2.0, None)] {
        let wrong =
            stop(held_s, seen).into_iter().filter(|friction| friction.high.is_some_and(|high| high < 0.88));
        assert_eq!(wrong.count(), 0, "{held_s} {seen:?}");
    }
    assert!(stop(2.0, Some(true))[150].valid);
}
