use super::*;
use crate::estimate::learned::Known;
use crate::model::Vehicle;

fn is_valid(estimator: &SlopeEstimator) -> bool {
    estimator.are_valid(&estimator.slopes())
}

fn point(slope: f64, mu: f64, noise: f64) -> TractionPoint {
    TractionPoint {
        slip: mu / slope + 0.015 + noise,
        slip_std: 2e-4,
        mu,
        mu_std: 0.0,
        rolling: 20.0 + 10.0 * mu,
    }
}

/// Drives `blocks` blocks on a surface; returns at which of them changes were noticed.
fn drive(estimator: &mut SlopeEstimator, slope: f64, blocks: usize) -> Vec<usize> {
    (0..blocks)
        .filter(|&i| {
            let mu = 0.1 * (i as f64 * 0.3).sin();
            let noise = 2e-4 * ((i * 7919 % 13) as f64 - 6.0) / 3.74;
            let points = Wheel::ALL.map(|w| w.is_front().then(|| point(slope, mu, noise)));
            estimator.step(&points, 0.25)
        })
        .collect()
}

#[test]
fn a_change_of_surface_is_noticed_once_and_followed() {
    let car = Car::new(&Vehicle::thesis());
    let mut estimator = SlopeEstimator::new(&car, &Sensors::default(), &SlopeConfig::default());
    drive(&mut estimator, 95.0, 400);
    let [Some(fl), Some(_), None, None] = estimator.slopes() else { panic!("{:?}", estimator.slopes()) };
    assert!((fl.value - 95.0).abs() < 3.0 * fl.std && fl.std < 5.0, "{fl:?}");
    assert!((estimator.offsets()[0].unwrap().value - 0.015).abs() < 1e-4);
    let noticed = drive(&mut estimator, 50.0, 80);
    assert_eq!(noticed.len(), 1, "{noticed:?}");
    assert!(noticed[0] < 20);
    let fl = estimator.slopes()[0].unwrap();
    assert!((fl.value - 50.0).abs() < 5.0, "{fl:?}");
    assert!(is_valid(&estimator));
}

fn estimator() -> SlopeEstimator {
    let car = Car::new(&Vehicle::thesis());
    SlopeEstimator::new(&car, &Sensors::default(), &SlopeConfig::default())
}

fn learned_on(slope: f64) -> Learned {
    let mut estimator = estimator();
    drive(&mut estimator, slope, 400);
    let mut learned = Learned::default();
    estimator.learn(&mut learned);
    learned
}

/// Blocks until the slope is valid, and its error then, relative.
fn until_valid(estimator: &SlopeEstimator, slope: f64) -> (usize, f64) {
    for blocks in 1..400 {
        let mut driven = estimator.clone();
        drive(&mut driven, slope, blocks);
        if is_valid(&driven) {
            return (blocks, driven.slopes()[0].unwrap().value / slope - 1.0);
        }
    }
    panic!("never valid")
}

#[test]
fn what_was_learned_is_kept_and_taken_up_again_less_surely() {
    let learned = learned_on(95.0);
    assert_eq!((learned.slope[2], learned.slip_offset[3]), (None, None), "rear wheels roll");
    let (slope, offset) = (learned.slope[1].unwrap(), learned.slip_offset[1].unwrap());
    assert!((slope.value - 95.0).abs() < 3.0 * slope.std && slope.std < 5.0, "{slope:?}");
    assert!((offset.value - 0.015).abs() < 3.0 * offset.std && offset.std < 2e-4, "{offset:?}");
    let mut second = estimator();
    second.restore(&learned);
    assert!(!is_valid(&second));
    assert_eq!((second.slopes(), second.offsets()), ([None; 4], [None; 4]), "nothing was measured");
    // Cruising tells the offset, and not the slope: what was learned of it stays.
    for _ in 0..400 {
        second.age(0.25);
        let points = Wheel::ALL.map(|w| w.is_front().then(|| point(95.0, 0.01, 0.0)));
        second.step(&points, 0.25);
        assert!(!is_valid(&second));
    }
    let mut again = Learned::default();
    second.learn(&mut again);
    assert_eq!(again.slope, learned.slope);
    assert!(again.slip_offset[0].is_some());
}

#[test]
fn a_known_offset_tells_the_slope_from_a_steady_force() {
    let steady = |estimator: &mut SlopeEstimator| {
        for i in 0..40 {
            let noise = 2e-4 * ((i * 7919 % 13) as f64 - 6.0) / 3.74;
            let points = Wheel::ALL.map(|w| w.is_front().then(|| point(95.0, 0.25, noise)));
            estimator.step(&points, 0.25);
        }
    };
    let (mut first, mut second) = (estimator(), estimator());
    second.restore(&learned_on(95.0));
    steady(&mut first);
    steady(&mut second);
    // One force alone does not tell slope and offset apart: the first drive takes one for the other.
    let (first, second) = (first.slopes()[0].unwrap(), second.slopes()[0].unwrap());
    println!("first {first:?}, second {second:?}");
    assert!((first.value - 95.0).abs() > 20.0, "{first:?}");
    assert!((second.value - 95.0).abs() < 5.0 && second.std < 0.2 * second.value, "{second:?}");
}

#[test]
fn another_surface_is_learned_as_if_nothing_had_been_kept() {
    let fresh = until_valid(&estimator(), 95.0);
    let mut second = estimator();
    second.restore(&learned_on(40.0));
    let (blocks, error) = until_valid(&second, 95.0);
    assert!(error.abs() < 0.3 && blocks < 2 * fresh.0 + 10, "{blocks} blocks, {error}, fresh {fresh:?}");
    drive(&mut second, 95.0, 100);
    let slope = second.slopes()[0].unwrap();
    assert!((slope.value - 95.0).abs() < 3.0 * slope.std, "{slope:?}");
}

#[test]
fn other_tires_contradict_and_nothing_of_the_old_ones_is_left() {
    let mut learned = learned_on(95.0);
    for offset in learned.slip_offset.iter_mut().flatten() {
        offset.value -= 0.01;
    }
    let mut second = estimator();
    second.restore(&learned);
    let mut first = estimator();
    drive(&mut first, 95.0, 400);
    drive(&mut second, 95.0, 401);
    let (slope, fresh) = (second.slopes()[0].unwrap(), first.slopes()[0].unwrap());
    assert!((slope.value - fresh.value).abs() < 0.5 * fresh.std, "{slope:?} {fresh:?}");
    assert!((second.offsets()[0].unwrap().value - 0.015).abs() < 2e-4);
}

proptest::proptest! {
    /// Whatever was learned: a covariance that is one, and numbers that may be kept in turn.
    #[test]
    fn restored_it_is_sound(
        slope in 1.0..1000.0_f64, slope_std in 1e-6..500.0_f64,
        offset in -0.2..0.2_f64, offset_std in 1e-9..0.1_f64,
    ) {
        let mut estimator = estimator();
        let mut learned = Learned::default();
        learned.slope[0] = Some(Known { value: slope, std: slope_std });
        learned.slip_offset[0] = Some(Known { value: offset, std: offset_std });
        estimator.restore(&learned);
        proptest::prop_assert!(!is_valid(&estimator));
        for blocks in [0, 1, 30] {
            drive(&mut estimator, 95.0, blocks);
            let filter = estimator.wheels[0].as_ref().unwrap().filter;
            proptest::prop_assert!(filter.is_sound());
            proptest::prop_assert!(filter.covariance.symmetric_eigenvalues().min() > 0.0);
            let mut again = Learned::default();
            estimator.learn(&mut again);
            let again = again.plausible();
            estimator.restore(&again);
            proptest::prop_assert!(!estimator.wheels[0].as_ref().unwrap().filter.covariance.iter().any(|p| p.is_nan()));
        }
    }
}

#[test]
fn cruising_without_force_tells_no_slope() {
    let car = Car::new(&Vehicle::thesis());
    let mut estimator = SlopeEstimator::new(&car, &Sensors::default(), &SlopeConfig::default());
    for _ in 0..400 {
        let points = Wheel::ALL.map(|w| w.is_front().then(|| point(95.0, 0.01, 0.0)));
        estimator.step(&points, 0.25);
    }
    assert_eq!(estimator.slopes(), [None; 4]);
    assert!(!is_valid(&estimator));
}
