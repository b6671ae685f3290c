//! Four short recordings in every test run: one with nothing hidden, two whose cause the library has, one whose cause
//! no library has.

use serde_json::Value;

use super::bus;
use super::cause::Cause;
use super::program::Program;
use super::recording::{Order, Recording};
use super::score::{Score, score};

/// A minute's drive, answered and scored.
fn answered(cause: &str, number: u64) -> (Score, Value) {
    let cause = Cause::find(cause);
    let recording = Recording::make(Order { number, seconds: Some(60.0), ..Order::of(cause, 6) }).unwrap();
    let name = format!("sample-{}", cause.key);
    let run = Program::found().explain(&name, &recording.log_gz(), &recording.toml, bus::DBC);
    let answer = run.answer.unwrap();
    let score = score(&name, &recording.truth(), Some(&answer), Some(run.seconds));
    println!("{}: {} {:?}, {:.0} s", cause.key, score.verdict, score.order.first(), run.seconds);
    (score, answer)
}

#[test]
#[ignore = "long: explains a recording"]
fn where_nothing_is_hidden_nothing_is_missing() {
    let (score, answer) = answered("control", 6);
    assert_eq!(score.verdict, "adequate", "{answer:#}");
    assert_eq!(answer["findings"].as_array().map(Vec::len), Some(0), "{answer:#}");
}

#[test]
fn banked_bends_are_named_and_found_where_they_are() {
    let (score, answer) = answered("road_bank", 9);
    assert!(score.named && score.findings == 1, "{answer:#}");
    assert!(score.overlap.is_some_and(|share| share > 0.4), "{:?}", score.overlap);
    assert!(score.stated.iter().all(|p| (p.value / p.truth - 1.0).abs() < 0.15), "{:?}", score.stated);
    assert!(score.fit.is_some_and(|(before, after)| after > before), "{:?}", score.fit);
    assert_eq!(score.certain, Some(true), "{answer:#}");
}

#[test]
#[ignore = "long: explains a recording"]
fn play_in_the_steering_which_no_library_has_is_called_unknown() {
    let (score, answer) = answered("freeplay", 4);
    assert_eq!(score.verdict, "unknown_physics", "{answer:#}");
    let place = &answer["where"];
    assert!(place["intervals"].as_array().is_some_and(|list| !list.is_empty()), "{place}");
    assert!(score.fit.is_some_and(|(before, after)| after > before), "{:?}", score.fit);
}

mod by_hand {
    use super::*;

    #[test]
    #[ignore = "by hand, long: explains a recording"]
    fn roll_that_leaks_into_the_accelerometer_is_named_with_its_gain() {
        let (score, answer) = answered("body_roll", 7);
        assert!(score.class, "{answer:#}");
        assert!(score.stated.iter().all(|p| (p.value / p.truth - 1.0).abs() < 0.15), "{:?}", score.stated);
        // What the plain model bent to follow it goes back to the truth.
        let closer = score.moved.iter().filter(|m| m.closer).count();
        assert!(2 * closer > score.moved.len(), "{:?}", score.moved);
    }
}
