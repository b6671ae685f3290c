use super::*;

/// A drive by hand: a slope on the bus of estimates, and ABS brakings at given times.
struct Drive {
    finder: PairFinder,
    time: i64,
    estimates: Estimates,
    speed: f64,
}

impl Drive {
    fn new() -> Self {
        let mut sensors = Sensors::default();
        sensors.add(Quantity::DriveTorque, None);
        let finder = PairFinder::new(&Vehicle::thesis(), &sensors);
        Self { finder, time: 0, estimates: Estimates::default(), speed: 25.0 }
    }

    fn slope(&mut self, value: f64, relative: f64, age_s: f64) {
        let slope = Some(Estimate { value, std: relative * value, age_s });
        self.estimates.slope = [slope, slope, None, None];
        self.estimates.slope_valid = relative < 0.15;
    }

    fn go(&mut self, seconds: f64, deceleration: f64, lateral: f64, abs: bool) -> &mut Self {
        for _ in 0..(seconds * 100.0) as i64 {
            self.time += 10_000;
            self.speed -= 0.01 * deceleration;
            let mut sample = Sample::empty(Micros(self.time), 0.01);
            for quantity in &Quantity::ALL[..4] {
                sample.set(*quantity, self.speed / self.finder.car.radius);
            }
            sample.set(Quantity::LateralAcceleration, lateral);
            sample.set(Quantity::LongitudinalAcceleration, -deceleration);
            sample.set(Quantity::BrakeActive, f64::from(u8::from(abs)));
            sample.set(Quantity::AbsActive, f64::from(u8::from(abs)));
            self.finder.step(&sample, &self.estimates);
        }
        self
    }

    fn only(&mut self) -> Braking {
        let brakings = self.finder.clone().finish();
        assert_eq!(brakings.len(), 1);
        brakings[0].clone()
    }
}

#[test]
fn a_settled_slope_makes_a_pair_and_the_seconds_after_it_confirm_it() {
    let mut drive = Drive::new();
    drive.slope(90.0, 0.03, 1.0);
    drive.go(8.0, 0.0, 0.0, false).go(1.0, 6.0, 0.0, true).go(1.0, 0.0, 0.0, false);
    let braking = drive.only();
    let pair = braking.pair().unwrap();
    assert!((pair.slope - 90.0).abs() < 1e-9 && (pair.mu - 6.0 / GRAVITY).abs() < 0.02, "{pair:?}");
    assert!(!braking.confirmed && braking.time == Micros(8_010_000), "{braking:?}");
    drive.go(10.0, 0.0, 0.0, false);
    assert!(drive.only().confirmed);
}

#[test]
fn every_other_braking_is_listed_with_its_reason() {
    let brake = |prepare: &dyn Fn(&mut Drive), lateral: f64| {
        let mut drive = Drive::new();
        prepare(&mut drive);
        drive.go(1.0, 6.0, lateral, true).go(1.0, 0.0, 0.0, false);
        let braking = drive.only();
        assert_eq!(braking.pair(), None);
        braking.not_a_pair.unwrap()
    };
    let settled = |drive: &mut Drive| {
        drive.slope(90.0, 0.03, 1.0);
        drive.go(8.0, 0.0, 0.0, false);
    };
    assert_eq!(brake(&|drive: &mut Drive| _ = drive.go(8.0, 0.0, 0.0, false), 0.0), NotAPair::NoSlope);
    assert!(matches!(brake(&settled, 4.0), NotAPair::Cornering { share } if share > 60.0));
    let unsure = |drive: &mut Drive| {
        drive.slope(90.0, 0.3, 1.0);
        drive.go(8.0, 0.0, 0.0, false);
    };
    assert!(matches!(brake(&unsure, 0.0), NotAPair::NotConverged { .. }));
    let old = |drive: &mut Drive| {
        drive.slope(90.0, 0.03, 20.0);
        drive.go(8.0, 0.0, 0.0, false);
    };
    assert!(matches!(brake(&old, 0.0), NotAPair::TooOld { .. }));
    let moving = |drive: &mut Drive| {
        settled(drive);
        drive.slope(70.0, 0.03, 0.0);
        drive.go(2.0, 0.0, 0.0, false);
    };
    let reason = brake(&moving, 0.0);
    assert!(matches!(reason, NotAPair::NotSettled { settled_s, .. } if settled_s < 2.1), "{reason:?}");
    let changed = |drive: &mut Drive| {
        settled(drive);
        drive.estimates.surface_changes += 1;
        drive.go(2.0, 0.0, 0.0, false);
    };
    assert!(matches!(brake(&changed, 0.0), NotAPair::NotSettled { .. }));
}

#[test]
fn a_change_noticed_right_after_the_braking_was_there_before() {
    let mut drive = Drive::new();
    drive.slope(90.0, 0.03, 1.0);
    drive.go(8.0, 0.0, 0.0, false).go(1.0, 4.0, 0.0, true).go(3.0, -2.0, 0.0, false);
    assert!(drive.only().pair().is_some());
    drive.estimates.surface_changes += 1;
    drive.go(1.0, 0.0, 0.0, false);
    let reason = drive.only().not_a_pair;
    assert!(matches!(reason, Some(NotAPair::SurfaceChanged { after_s }) if after_s > 2.0), "{reason:?}");
}

#[test]
fn what_all_slopes_share_is_no_uncertainty_of_one() {
    let slope = Some(Estimate { value: 100.0, std: 5.0, age_s: 1.0 });
    let mean = mean_slope(&[slope, slope, None, None], DrivenAxle::Front, 0.04).unwrap();
    assert!((mean.std - 3.0).abs() < 1e-9);
    assert_eq!(mean_slope(&[slope, None, None, None], DrivenAxle::Front, 0.0), None);
}
