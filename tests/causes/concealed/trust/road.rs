//! Roads and noise as cars have them.

use super::super::cause::Cause;
use super::super::drive::{self, Kind, Plan};
use super::super::recording::{Order, Recording};
use super::super::road::{Course, Road};
use super::super::set::Wish;
use super::*;

/// What is left of a course on average, squared, and over so many samples together.
fn products(course: &Course, seconds: f64, apart: f64) -> f64 {
    let count = (seconds / STEP) as usize - 1000;
    let at = |k: usize, by: f64| course.at(k as f64 * STEP + by);
    (0..count).map(|k| at(k, 0.0) * at(k, apart)).sum::<f64>() / count as f64
}

#[test]
fn courses_are_as_large_and_as_slow_as_they_are_asked_to_be() {
    let mut dice = Dice::new(3, 1);
    let waves = Course::waves(200.0, (1.0, 12.0), 60.0, &mut dice);
    close(products(&waves, 200.0, 0.0).sqrt(), 60.0, 0.1, "rms of waves");
    let noise = Course::wander(500.0, 0.15, 2.0, &mut dice);
    close(products(&noise, 500.0, 0.0).sqrt(), 2.0, 0.1, "rms of noise");
    close(products(&noise, 500.0, 0.15) / products(&noise, 500.0, 0.0), (-1f64).exp(), 0.1, "memory");
    assert_eq!(Course::default().at(3.0), 0.0);
}

/// GIVEN a rough road WHEN a car is driven on it THEN it turns a little otherwise, and on the whole as before.
#[test]
fn a_rough_road_disturbs_a_drive_and_leaves_it_what_it_was() {
    let (car, mut dice) = (car(4), Dice::new(5, 2));
    let plan = Plan::random(Kind::Mixed, 40.0, 7.0, &mut dice);
    let rough = Hidden { road: Some(Road::random(40.0, &mut dice)), ..Hidden::default() };
    let [smooth, rough] = [&Hidden::default(), &rough].map(|hidden| drive::drive(&plan, &car, hidden));
    let square = |of: &dyn Fn(&Moment, &Moment) -> f64| -> f64 {
        smooth.iter().zip(&rough).map(|(one, other)| of(one, other).powi(2)).sum()
    };
    let share = (square(&|one, other| one.r - other.r) / square(&|one, _| one.r)).sqrt();
    assert!((0.001..0.1).contains(&share), "{share}");
}

#[test]
fn the_same_drive_on_a_real_road_is_recorded_otherwise() {
    let order = Order { seconds: Some(20.0), number: 2, ..Order::of(Cause::find("control"), 31) };
    let tidy = Recording::make(order).unwrap();
    let real = Recording::make(Order { is_real: true, ..order }).unwrap();
    assert!(tidy.log != real.log && tidy.toml == real.toml);
    assert_eq!(tidy.plan.speed, real.plan.speed);
    assert_eq!(real.truth()["kind"], "control");
    assert_eq!(real.truth()["expected"], "adequate");
}

/// Causes that act together are in one car, each with its truth.
#[test]
fn several_causes_are_drawn_that_can_be_together() {
    let wish = Wish {
        seed: 9,
        count: 40,
        factors: vec![1.0],
        only: None,
        seconds: Some(20.0),
        is_real: false,
        together: vec![2, 3],
    };
    let orders = wish.orders();
    assert_eq!(orders.iter().filter(|order| order.causes().count() == 3).count(), 20);
    assert!(orders.iter().all(Order::is_possible));
    let truth = Recording::make(orders[1]).unwrap().truth();
    assert_eq!(truth["kind"], "several");
    let told: Vec<_> = truth["causes"].as_array().unwrap().iter().map(|one| one["cause"].clone()).collect();
    assert_eq!(told, orders[1].causes().map(|cause| cause.key).collect::<Vec<_>>());
}
