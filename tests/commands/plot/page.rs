//! The page in a real browser.

use std::time::Instant;

use serde_json::json;

use super::*;
use crate::view::browser::{Browser, Tab};

/// A page is opened and drawn within so long, s: it takes half a second, on a machine with nothing else to do.
const MOST_SECONDS: f64 = 15.0;

fn open(browser: &mut Browser, place: &Place) -> Tab {
    let tab = browser.open(&format!("file://{}", place.path("page.html").display()));
    browser.wait_until(&tab, "document.documentElement.dataset.ready");
    assert_eq!(browser.evaluate(&tab, "document.documentElement.dataset.error"), Value::Null);
    tab
}

/// What all panels show, if they show the same.
fn shown(browser: &mut Browser, tab: &Tab) -> (f64, f64) {
    let ranges = browser.evaluate(tab, "gripd.ranges()");
    let ranges = ranges.as_array().unwrap();
    assert!(ranges.len() >= 12 && ranges.iter().all(|range| *range == ranges[0]), "{ranges:?}");
    (ranges[0][0].as_f64().unwrap(), ranges[0][1].as_f64().unwrap())
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
    let tab = open(&mut browser, &place);
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
    let tab = open(&mut browser, &place);
    let ground = "getComputedStyle(document.body).backgroundColor";
    let light = browser.evaluate(&tab, ground);
    for (width, scale) in [(1280, 1), (390, 2)] {
        let screen =
            json!({ "width": width, "height": 800, "deviceScaleFactor": scale, "mobile": width < 600 });
        browser.call(Some(&tab), "Emulation.setDeviceMetricsOverride", screen);
        browser.wait_until(&tab, &format!("innerWidth === {width}"));
        let fits = format!(
            "[...document.querySelectorAll('.uplot')].every((plot) => \
             plot.getBoundingClientRect().right <= {width} && plot.offsetWidth > 0.2 * {width})"
        );
        browser.wait_until(&tab, &fits);
        let wide = browser.evaluate(&tab, "document.documentElement.scrollWidth").as_u64().unwrap();
        assert!(wide <= width, "the page is {wide} wide of {width}");
    }
    let dark = json!({ "features": [{ "name": "prefers-color-scheme", "value": "dark" }] });
    browser.call(Some(&tab), "Emulation.setEmulatedMedia", dark);
    browser.wait_until(&tab, &format!("{ground} !== {light}"));
    // On paper from a dark screen: ink on white, and the screen as before afterwards.
    browser.evaluate(
        &tab,
        "addEventListener('beforeprint', () => { window.paper = getComputedStyle(document.body).backgroundColor; })",
    );
    let printed = browser.call(Some(&tab), "Page.printToPDF", json!({ "printBackground": true }));
    assert!(printed["data"].as_str().unwrap().len() > 50_000);
    assert_eq!(browser.evaluate(&tab, "window.paper"), "rgb(255, 255, 255)");
    browser.wait_until(
        &tab,
        &format!("{ground} !== {light} && !document.documentElement.hasAttribute('data-paper')"),
    );
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "long: in a browser"]
fn an_hour_is_below_three_megabytes_and_opens_at_once() {
    let place = Place::new();
    place.write("hour.log", repeated(120));
    let page = place.plotted("hour.log");
    println!("{:.2} MB for an hour", page.len() as f64 / 1e6);
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
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
    let tab = open(&mut browser, &place);
    let seconds = begun.elapsed().as_secs_f64();
    println!("open and drawn after {seconds:.2} s");
    assert!(seconds < MOST_SECONDS, "{seconds}");
    let begun = Instant::now();
    browser.evaluate(&tab, "gripd.show(1000, 1100)");
    println!("zoomed after {:.2} s", begun.elapsed().as_secs_f64());
    assert_eq!(shown(&mut browser, &tab), (1000.0, 1100.0));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
