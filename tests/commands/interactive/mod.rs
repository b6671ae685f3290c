//! Pages to look into, in a real browser: what all of them have to do, and those of `explain`, `identify` and `replay`.

mod pages;

use std::path::Path;

use serde_json::{Value, json};

use crate::view::browser::{Browser, Tab};

/// A page may be so large, bytes, however long the drive is.
pub const MOST_BYTES: usize = 3_000_000;

/// Opens a page and waits until it is drawn.
#[track_caller]
pub fn open(browser: &mut Browser, page: &Path) -> Tab {
    let tab = browser.open(&format!("file://{}", page.display()));
    browser.wait_until(&tab, "document.documentElement.dataset.ready");
    assert_eq!(browser.evaluate(&tab, "document.documentElement.dataset.error"), Value::Null);
    tab
}

/// What all panels show, if they show the same; there are at least so many.
#[track_caller]
pub fn shown(browser: &mut Browser, tab: &Tab, least: usize) -> (f64, f64) {
    let ranges = browser.evaluate(tab, "gripd.ranges()");
    let ranges = ranges.as_array().unwrap();
    assert!(ranges.len() >= least && ranges.iter().all(|range| *range == ranges[0]), "{ranges:?}");
    (ranges[0][0].as_f64().unwrap(), ranges[0][1].as_f64().unwrap())
}

/// The page fits a large screen and a phone, is dark where that is asked for, and ink on white on paper.
pub fn suits_every_screen(browser: &mut Browser, tab: &Tab) {
    let ground = "getComputedStyle(document.body).backgroundColor";
    let light = browser.evaluate(tab, ground);
    for (width, scale) in [(1280, 1), (390, 2)] {
        let screen =
            json!({ "width": width, "height": 800, "deviceScaleFactor": scale, "mobile": width < 600 });
        browser.call(Some(tab), "Emulation.setDeviceMetricsOverride", screen);
        browser.wait_until(tab, &format!("innerWidth === {width}"));
        let fits = format!(
            "[...document.querySelectorAll('.uplot')].every((plot) => \
             plot.getBoundingClientRect().right <= {width} && plot.offsetWidth > 0.2 * {width})"
        );
        browser.wait_until(tab, &fits);
        let wide = browser.evaluate(tab, "document.documentElement.scrollWidth").as_u64().unwrap();
        assert!(wide <= width, "the page is {wide} wide of {width}");
    }
    let dark = json!({ "features": [{ "name": "prefers-color-scheme", "value": "dark" }] });
    browser.call(Some(tab), "Emulation.setEmulatedMedia", dark);
    browser.wait_until(tab, &format!("{ground} !== {light}"));
    // On paper from a dark screen: ink on white, and the screen as before afterwards.
    browser.evaluate(
        tab,
        "addEventListener('beforeprint', () => { window.paper = getComputedStyle(document.body).backgroundColor; })",
    );
    let printed = browser.call(Some(tab), "Page.printToPDF", json!({ "printBackground": true }));
    assert!(printed["data"].as_str().unwrap().len() > 50_000);
    assert_eq!(browser.evaluate(tab, "window.paper"), "rgb(255, 255, 255)");
    browser.wait_until(
        tab,
        &format!("{ground} !== {light} && !document.documentElement.hasAttribute('data-paper')"),
    );
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Nothing of a page is loaded from elsewhere, and the browser is told to load nothing.
#[track_caller]
pub fn stands_alone(page: &str) {
    for attribute in ["src=", "@import", "url("] {
        assert!(!page.contains(attribute), "{attribute} loads something");
    }
    // Links to other parts of the page are fine.
    assert_eq!(page.matches("href=").count(), page.matches("href=\"#").count());
    assert!(page.contains("default-src 'none'"), "the browser is told to load nothing");
    assert!(page.contains("Copyright (c) 2022 Leon Sorokin"), "the library's licence");
    assert!(page.len() < MOST_BYTES, "{} bytes", page.len());
}

/// The numbers in a page.
pub fn data(page: &str) -> Value {
    let text = page.split_once("id=\"data\">").unwrap().1.split_once("</script>").unwrap().0;
    serde_json::from_str(text).unwrap()
}

/// A panel or figure by its title.
#[track_caller]
pub fn titled<'a>(data: &'a Value, kind: &str, title: &str) -> &'a Value {
    let all = data[kind].as_array().unwrap();
    all.iter().find(|it| it["title"] == title).unwrap_or_else(|| panic!("no `{title}`"))
}
