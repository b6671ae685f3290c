//! The page in a real browser.

use nix::sys::signal::Signal;
use serde_json::json;

use super::browser::{Browser, Tab};
use super::*;

/// How many pixels of a plot have the colour of a variable of the style sheet, nearly.
fn pixels(browser: &mut Browser, tab: &Tab, plot: usize, color: &str) -> u64 {
    let script = format!(
        "(() => {{
            const canvas = document.querySelectorAll('figure canvas')[{plot}];
            const hex = getComputedStyle(document.documentElement).getPropertyValue('--{color}').trim();
            const wanted = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
            const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
            let count = 0;
            for (let at = 0; at < data.length; at += 4) {{
                const near = wanted.every((value, part) => Math.abs(data[at + part] - value) < 12);
                if (near && data[at + 3] > 200) count += 1;
            }}
            return count;
        }})()"
    );
    browser.evaluate(tab, &script).as_u64().unwrap()
}

fn text(browser: &mut Browser, tab: &Tab, selector: &str) -> String {
    let value = browser.evaluate(tab, &format!("document.querySelector('{selector}').innerText"));
    value.as_str().unwrap_or_default().to_owned()
}

/// What the card of this name says.
fn card(browser: &mut Browser, tab: &Tab, name: &str) -> String {
    let script = format!(
        "[...document.querySelectorAll('#facts > div')].find((card) => \
         card.querySelector('dt').textContent === '{name}')?.querySelector('dd').textContent"
    );
    browser.evaluate(tab, &script).as_str().unwrap_or_default().to_owned()
}

#[test]
#[ignore = "long: in a browser"]
fn the_page_draws_what_comes() {
    let Some(mut browser) = Browser::start() else { return };
    let server = Server::start("8");
    let tab = browser.open(&server.url());
    browser.wait_until(&tab, "document.body.dataset.rows > 100");
    let early = card(&mut browser, &tab, "Speed");
    assert!(early.ends_with("km/h"), "{early}");
    assert_eq!(browser.evaluate(&tab, "document.querySelectorAll('#facts > div').length"), 8);
    let plots = browser.evaluate(&tab, "document.querySelectorAll('figure canvas').length").as_u64().unwrap();
    assert_eq!(plots, 8);
    browser.wait_until(&tab, "/recording is over/.test(document.getElementById('clock').textContent)");
    // Lines are where they should be: in use, slopes, cornering stiffness, sideslip, speed, steering, acceleration.
    for plot in 0..7 {
        // Where there are two, the second may lie upon the first.
        let color = if matches!(plot, 1 | 2) { "second" } else { "first" };
        let drawn = pixels(&mut browser, &tab, plot, color);
        assert!(drawn > 100, "plot {plot}: {drawn} pixels of a line");
    }
    assert!(pixels(&mut browser, &tab, 7, "third") > 100, "no stretch in which anything was valid");
    // From the beginning of what came, not from two minutes before; and the numbers beside the plots are the cards'.
    let labels = "document.querySelector('figure .legend').innerText";
    let legend = browser.evaluate(&tab, labels).as_str().unwrap().to_owned();
    let in_use = card(&mut browser, &tab, "Friction in use");
    let told = legend.lines().find_map(|line| line.strip_prefix("in use")).map(str::trim);
    assert_eq!(told, Some(in_use.as_str()), "{legend}");
    // The numbers are those that `monitor --once` prints at the end of the same recording.
    let once =
        Command::new(GRIPD).args(["-q", "monitor", "--once", "-c", CAR]).arg(drive()).output().unwrap();
    let once = String::from_utf8(once.stdout).unwrap();
    let of = |line: &str| {
        let found = once.lines().find_map(|candidate| candidate.trim_start().strip_prefix(line));
        found.unwrap().split_whitespace().next().unwrap().to_owned()
    };
    assert_eq!(card(&mut browser, &tab, "Slip slope, front left"), of("FL"));
    assert_eq!(card(&mut browser, &tab, "Friction in use"), of("in use"));
    let speed: f64 = of("speed").parse().unwrap();
    let shown = card(&mut browser, &tab, "Speed");
    let shown: f64 = shown.strip_suffix(" km/h").unwrap().parse().unwrap();
    // Rounded once more, to whole numbers.
    assert!((shown - speed).abs() <= 0.56, "{shown} beside {speed}");
    assert!(text(&mut browser, &tab, "#headline").starts_with("Friction"));
    assert!(text(&mut browser, &tab, "#told").contains("nothing is sent"));
    for words in ["wheel FL", "GRIP_STATUS", "WHEELS", "no faults"] {
        assert!(text(&mut browser, &tab, "main").contains(words), "no `{words}`");
    }
    // Nothing came from elsewhere.
    let elsewhere =
        "performance.getEntriesByType('resource').filter((r) => !r.name.startsWith(location.origin)).length";
    assert_eq!(browser.evaluate(&tab, elsewhere), 0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "long: in a browser"]
fn it_suits_the_dark_and_the_phone_and_stands_still_when_told() {
    let Some(mut browser) = Browser::start() else { return };
    let server = Server::start("2");
    let tab = browser.open(&server.url());
    browser.wait_until(&tab, "document.body.dataset.rows > 60");
    let ground = "getComputedStyle(document.body).backgroundColor";
    let light = browser.evaluate(&tab, ground);
    let dark = json!({ "features": [{ "name": "prefers-color-scheme", "value": "dark" }] });
    browser.call(Some(&tab), "Emulation.setEmulatedMedia", dark);
    browser.wait_until(&tab, &format!("{ground} !== {light}"));
    let updates = browser.evaluate(&tab, "Number(document.body.dataset.updates)");
    browser.wait_until(&tab, &format!("document.body.dataset.updates > {updates} + 2"));
    // In the dark's own colour: the plots were drawn anew.
    assert!(pixels(&mut browser, &tab, 4, "first") > 100);

    let phone = json!({ "width": 390, "height": 800, "deviceScaleFactor": 2, "mobile": true });
    browser.call(Some(&tab), "Emulation.setDeviceMetricsOverride", phone);
    browser.wait_until(&tab, "innerWidth === 390");
    browser.wait_until(&tab, "document.querySelector('canvas').width > 390");
    let width = browser.evaluate(&tab, "document.documentElement.scrollWidth");
    assert!(width.as_u64().unwrap() <= 390, "the page is {width} wide");

    browser.evaluate(&tab, "document.getElementById('pause').click()");
    assert_eq!(
        browser.evaluate(&tab, "document.getElementById('pause').getAttribute('aria-pressed')"),
        "true"
    );
    let clock = text(&mut browser, &tab, "#clock");
    let updates = browser.evaluate(&tab, "Number(document.body.dataset.updates)");
    browser.wait_until(&tab, &format!("document.body.dataset.updates > {updates} + 8"));
    assert_eq!(text(&mut browser, &tab, "#clock"), clock, "it did not stand still");
    browser.evaluate(&tab, "document.getElementById('pause').click()");
    browser.wait_until(&tab, &format!("document.getElementById('clock').textContent.trim() !== {clock:?}"));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "long: in a browser"]
fn two_pages_see_the_same_and_say_when_nobody_answers() {
    let Some(mut browser) = Browser::start() else { return };
    let server = Server::start("10");
    let first = browser.open(&server.url());
    browser.wait_until(&first, "/is over/.test(document.getElementById('clock').textContent)");
    let second = browser.open(&server.url().replace("127.0.0.1", "localhost"));
    browser.wait_until(&second, "document.body.dataset.rows > 280");
    for name in ["Speed", "Friction in use", "Slip slope, front right"] {
        assert_eq!(card(&mut browser, &first, name), card(&mut browser, &second, name));
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
    // What is over is not running.
    let told = text(&mut browser, &first, "#told");
    assert!(told.contains("the recording is over") && !told.contains("running"), "{told}");
    let words = "[...document.querySelectorAll('#facts b')].map((word) => word.textContent)";
    let has = |word: &str| format!("{words}.includes('{word}')");
    assert_eq!(browser.evaluate(&first, &has("stale")), false);
    let silent = "/does not answer/.test(document.getElementById('connection').textContent)";
    // A program that hangs keeps its connections open.
    server.signal(Signal::SIGSTOP);
    browser.wait_until(&first, silent);
    assert_eq!(browser.evaluate(&first, &has("stale")), true);
    server.signal(Signal::SIGCONT);
    browser.wait_until(&first, &format!("!{silent} && !({})", has("stale")));
    drop(server);
    for tab in [&first, &second] {
        browser.wait_until(tab, silent);
        // No old value goes for a valid one.
        assert_eq!(browser.evaluate(tab, &has("valid")), false);
        assert_eq!(browser.evaluate(tab, &has("stale")), true);
        assert_eq!(text(&mut browser, tab, "#headline"), "The estimates are stale");
        let told = text(&mut browser, tab, "#told");
        assert!(told.contains("as it said last"), "{told}");
    }
}
