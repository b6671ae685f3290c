//! The page in a real browser.

use std::time::Instant;

use serde_json::json;

use super::*;
use crate::interactive::{self, MOST_BYTES, open, suits_every_screen};
use crate::view::browser::{Browser, Tab};

/// A page is opened and drawn within so long, s: it takes half a second, on a machine with nothing else to do.
const MOST_SECONDS: f64 = 15.0;

/// What all panels show.
fn shown(browser: &mut Browser, tab: &Tab) -> (f64, f64) {
    interactive::shown(browser, tab, 12)
}

/// The mouse over the second panel, at a share of its width.
fn mouse(browser: &mut Browser, tab: &Tab, kind: &str, share: f64, clicks: u32) {
    let place = browser.evaluate(
        tab,
        "(() => { const box = document.querySelectorAll('#panels .u-over')[1].getBoundingClientRect(); \
         return [box.left, box.top + box.height / 2, box.width]; })()",
    );
    let at = |index: usize| place[index].as_f64().unwrap();
    let event = json!({
        "type": kind, "x": at(0) + share * at(2), "y": at(1), "button": "left", "clickCount": clicks,
        "buttons": u32::from(kind == "mousePressed"),
    });
    browser.call(Some(tab), "Input.dispatchMouseEvent", event);
}

fn text(browser: &mut Browser, tab: &Tab, id: &str) -> String {
    let value = browser.evaluate(tab, &format!("document.getElementById('{id}').textContent"));
    value.as_str().unwrap().to_owned()
}

#[test]
#[ignore = "long: in a browser"]
fn all_panels_zoom_and_follow_the_cursor_together() {
    let Some(mut browser) = Browser::start() else { return };
    let place = Place::new();
    place.write("drive.log", repeated(1));
    place.plotted("drive.log");
    let tab = open(&mut browser, &place.path("page.html"));
    browser
        .evaluate(&tab, "document.querySelectorAll('#panels figure')[1].scrollIntoView({ block: 'center' })");
    let (from, to) = shown(&mut browser, &tab);
    assert!(from < 0.1 && (to - 30.0).abs() < 0.1, "{from} to {to}");
    // Drawn over with the mouse: a third of the time.
    for (kind, share) in [
        ("mouseMoved", 0.3),
        ("mousePressed", 0.3),
        ("mouseMoved", 0.5),
        ("mouseMoved", 0.6),
        ("mouseReleased", 0.6),
    ] {
        mouse(&mut browser, &tab, kind, share, 1);
    }
    let (from, to) = shown(&mut browser, &tab);
    assert!((from - 9.0).abs() < 0.3 && (to - 18.0).abs() < 0.3, "{from} to {to}");
    // The cursor: both clocks, and a number for each line.
    mouse(&mut browser, &tab, "mouseMoved", 0.5, 0);
    let clock = text(&mut browser, &tab, "clock");
    assert!(clock.starts_with("13.") && clock.contains("2025-10-09T08:53:3"), "{clock}");
    let numbers = "[...document.querySelectorAll('#panels .legend b')].filter((it) => it.textContent).length";
    assert!(browser.evaluate(&tab, numbers).as_u64().unwrap() > 20);
    let here = "document.querySelectorAll('#figures .here:not([hidden])').length";
    assert!(browser.evaluate(&tab, here).as_u64().unwrap() >= 2, "no place on the track");
    // Buttons, and everything again by a double click.
    browser.evaluate(&tab, "document.querySelector('[data-move=closer]').click()");
    let (closer, end) = shown(&mut browser, &tab);
    assert!(((end - closer) / (to - from) - 0.5).abs() < 0.02, "{closer} to {end}");
    for clicks in [1, 2] {
        mouse(&mut browser, &tab, "mousePressed", 0.5, clicks);
        mouse(&mut browser, &tab, "mouseReleased", 0.5, clicks);
    }
    let (from, to) = shown(&mut browser, &tab);
    assert!(from < 0.1 && (to - 30.0).abs() < 0.1, "{from} to {to}");
    let loaded = "performance.getEntriesByType('resource').length";
    assert_eq!(browser.evaluate(&tab, loaded), 0, "nothing is loaded");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "long: in a browser"]
fn it_suits_the_phone_the_dark_and_paper() {
    let Some(mut browser) = Browser::start() else { return };
    let place = Place::new();
    place.plotted("drive.log");
    let tab = open(&mut browser, &place.path("page.html"));
    suits_every_screen(&mut browser, &tab);
}

#[test]
#[ignore = "long: in a browser"]
fn an_hour_is_below_three_megabytes_and_opens_at_once() {
    let place = Place::new();
    place.write("hour.log", repeated(120));
    let page = place.plotted("hour.log");
    println!("{:.2} MB for an hour", page.len() as f64 / 1e6);
    assert!(page.len() < MOST_BYTES, "{} bytes", page.len());
    let data = data(&page);
    assert!(data["stretch_s"].as_f64().unwrap() < 1.0);
    // Peaks of the same half minute are there each of the 120 times.
    let steering = titled(&data, "panels", "Steering wheel")["series"][0]["values"].clone();
    let steering: Vec<f64> = steering.as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    let peak = steering.iter().copied().fold(f64::MIN, f64::max);
    let near = steering.iter().filter(|angle| **angle > 0.93 * peak).count();
    assert!(near >= 120, "{near} rows at the peaks of {peak} °");
    let Some(mut browser) = Browser::start() else { return };
    let begun = Instant::now();
    let tab = open(&mut browser, &place.path("page.html"));
    let seconds = begun.elapsed().as_secs_f64();
    println!("open and drawn after {seconds:.2} s");
    assert!(seconds < MOST_SECONDS, "{seconds}");
    let begun = Instant::now();
    browser.evaluate(&tab, "gripd.show(1000, 1100)");
    println!("zoomed after {:.2} s", begun.elapsed().as_secs_f64());
    assert_eq!(shown(&mut browser, &tab), (1000.0, 1100.0));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
