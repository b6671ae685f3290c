//! The guide's pictures: pages of simulated drives, as a browser shows them.

use std::fs;

use serde_json::json;
use testing::program::project;

use super::pages::Garage;
use super::*;

/// A picture has at most so many bytes: those of the guide are read over slow lines, too.
const MOST_BYTES: usize = 200_000;

/// Wide enough for three figures beside each other, and for text that can still be read in a page's column.
const WIDTH: u32 = 1080;

/// So many panels or figures (`#panels`, `#figures`) of a page, the first ones.
fn picture(browser: &mut Browser, tab: &Tab, of: &str, count: usize) -> Vec<u8> {
    let screen = json!({ "width": WIDTH, "height": 900, "deviceScaleFactor": 1, "mobile": false });
    browser.call(Some(tab), "Emulation.setDeviceMetricsOverride", screen);
    browser.wait_until(tab, &format!("innerWidth === {WIDTH}"));
    // Drawn anew at the new width.
    std::thread::sleep(std::time::Duration::from_secs(1));
    let edges = browser.evaluate(
        tab,
        &format!(
            "(() => {{ const boxes = [...document.querySelectorAll('{of} > figure')].slice(0, {count}) \
             .map((it) => it.getBoundingClientRect()); \
             return [Math.min(...boxes.map((it) => it.top)) + scrollY, Math.max(...boxes.map((it) => it.bottom)) + scrollY, \
             boxes.length]; }})()"
        ),
    );
    let edge = |place: usize| edges[place].as_f64().unwrap();
    assert_eq!(edge(2) as usize, count, "figures in {of}");
    let clip =
        json!({ "x": 0, "y": edge(0) - 8.0, "width": WIDTH, "height": edge(1) - edge(0) + 16.0, "scale": 1 });
    let asked = json!({ "format": "png", "captureBeyondViewport": true, "clip": clip });
    let shot = browser.call(Some(tab), "Page.captureScreenshot", asked);
    of_base64(shot["data"].as_str().unwrap())
}

/// Bytes of what RFC 4648 calls base64.
fn of_base64(text: &str) -> Vec<u8> {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let place = |letter: u8| LETTERS.iter().position(|it| *it == letter).map(|place| place as u32);
    let letters: Vec<u32> = text.bytes().filter_map(place).collect();
    let bytes = |four: &[u32]| {
        let joined = four.iter().fold(0, |sum, six| (sum << 6) | six) << (6 * (4 - four.len()));
        joined.to_be_bytes()[1..four.len()].to_vec()
    };
    letters.chunks(4).flat_map(bytes).collect()
}

#[test]
fn base64_is_read() {
    assert_eq!(of_base64("Z3JpcGQ="), b"gripd");
    assert_eq!(of_base64("Z3JpcA=="), b"grip");
    assert_eq!(of_base64("/+8A"), [0xff, 0xef, 0]);
}

#[test]
fn pictures_of_the_guide_are_small_and_shown() {
    let pages: String = ["explain-a-mismatch.md", "recordings-and-formats.md"]
        .map(|page| fs::read_to_string(project(&format!("src/guide/{page}"))).unwrap())
        .concat();
    let folder = fs::read_dir(project("src/guide/pictures")).unwrap();
    let pictures: Vec<_> = folder.map(|entry| entry.unwrap().path()).collect();
    assert!(!pictures.is_empty());
    for path in pictures {
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"\x89PNG"), "{} is no PNG", path.display());
        assert!(bytes.len() <= MOST_BYTES, "{}: {} bytes", path.display(), bytes.len());
        let name = format!("](pictures/{})", path.file_name().unwrap().to_str().unwrap());
        assert!(pages.contains(&name), "no page shows {}", path.display());
    }
}

mod by_hand {
    use super::*;

    /// Writes them anew.
    #[test]
    #[ignore = "by hand: writes the guide's pictures"]
    fn the_guides_pictures() {
        let mut browser = Browser::start().expect("a chromium");
        let garage =
            Garage::new(90, "[[effect]]\nkind = \"sensor_delay\"\nchannel = \"yaw_rate\"\ndelay_s = 0.08\n");
        for (command, shown) in [
            ("plot", &[("plot.png", "#figures", 3)][..]),
            ("explain", &[("explain-errors.png", "#panels", 2), ("explain-tires.png", "#figures", 3)][..]),
        ] {
            garage.page(&[command]);
            let tab = open(&mut browser, &garage.path("page.html"));
            for (name, of, count) in shown {
                let bytes = picture(&mut browser, &tab, of, *count);
                assert!(bytes.len() <= MOST_BYTES, "{name}: {} bytes", bytes.len());
                fs::write(project(&format!("src/guide/pictures/{name}")), bytes).unwrap();
            }
        }
        assert_eq!(browser.complaints(), Vec::<String>::new());
    }
}
