//! `gripd demo`, from an empty folder.

use std::fs;
use std::path::Path;
use std::process::Output;

use gripd::can::Frame;
use gripd::can::candump::Reader;
use gripd::signals::publish::built_in_database;
use testing::program;

fn gripd(folder: &Path, arguments: &[&str]) -> Output {
    program::gripd().args(arguments).current_dir(folder).output().unwrap()
}

/// Runs it in memory; the results of vcan0 are another test's.
fn demo(folder: &Path, arguments: &[&str]) -> String {
    let output = gripd(folder, &[&["demo", "--memory"], arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn frames(log: &[u8]) -> Vec<Frame> {
    let mut reader = Reader::from_read(Box::new(std::io::Cursor::new(log.to_vec())), "log").unwrap();
    let mut frames = Vec::new();
    while let Some(frame) = reader.next_frame().unwrap() {
        frames.push(frame);
    }
    assert_eq!(reader.stats().skipped_lines, 0);
    frames
}

/// Every tag that is opened is closed, in order.
fn assert_balanced(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    for tag in html.split('<').skip(1).map(|rest| rest.split('>').next().unwrap()) {
        if tag.starts_with('!') || tag.ends_with('/') {
            continue;
        }
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "</{name}>"),
            None => open.push(tag.split_whitespace().next().unwrap()),
        }
    }
    assert!(open.is_empty(), "never closed: {open:?}");
}

#[test]
fn a_page_with_all_plots_and_nothing_from_outside() {
    let folder = tempfile::tempdir().unwrap();
    let text = demo(folder.path(), &[]);
    let names: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["gripd-demo.html"], "the page and nothing else");
    let html = fs::read_to_string(folder.path().join("gripd-demo.html")).unwrap();
    assert_balanced(&html);
    assert!(html.len() < 1_500_000, "{} bytes are more points than pixels", html.len());
    for heading in [
        "Longitudinal slip slope",
        "Friction between tires and road",
        "Lateral velocity",
        "Sideslip",
        "Cornering stiffness of the front axle",
        "Cornering stiffness of the rear axle",
        "Slip at zero force",
        "Speed",
        "Tire forces",
        "Excitation",
        "Steering wheel angle",
    ] {
        assert!(html.contains(&format!("<figure><h2>{heading}")), "no plot of {heading}");
    }
    assert_eq!(html.matches("<svg").count(), html.matches("<figure>").count());
    for surface in ["asphalt", "gravel", "ice"] {
        assert!(html.contains(&format!(">\n{surface}\n<")), "{surface} is not labelled");
    }
    // A value that is older than its surface's end says so, and two truths are two strokes.
    assert!(
        html.contains("told last on each surface") && html.contains(" s before the end<"),
        "ages of values"
    );
    assert!(html.contains("<i class=\"dashes\" style=\"color:var(--truth)\"></i>front right: true"));
    for outside in ["<script", "<link", "<img", "@import", "url(", "src="] {
        assert!(!html.contains(outside), "{outside}");
    }
    assert_eq!(html.matches("http").count(), html.matches("http://www.w3.org/2000/svg").count());
    assert!(html.contains("prefers-color-scheme: dark"));
    assert!(text.contains("gripd-demo.html"), "{text}");
}

#[test]
fn both_changes_of_surface_are_noticed_on_every_drive() {
    let folder = tempfile::tempdir().unwrap();
    let mut false_alarms = 0;
    for seed in ["1", "2", "3", "4", "5", "6"] {
        let text = demo(folder.path(), &["--seed", seed]);
        assert_eq!(text.matches("noticed after").count(), 2, "seed {seed}: {text}");
        let line = text.lines().find(|line| line.contains("false alarms")).unwrap();
        false_alarms += line.split_whitespace().last().unwrap().parse::<u32>().unwrap();
    }
    // On ice this drive uses three quarters of the friction: a tire so near its limit is softer than it
    // was, which a straight line can only take for another surface.
    assert!(false_alarms <= 5, "{false_alarms} in 12 minutes");
}

#[test]
fn the_seed_decides_everything() {
    let folder = tempfile::tempdir().unwrap();
    let run = |seed, page: &str| {
        let text = demo(folder.path(), &["--seed", seed, "-o", page]);
        (text.replace(page, "PAGE"), fs::read_to_string(folder.path().join(page)).unwrap())
    };
    let (first, again, other) = (run("3", "a.html"), run("3", "b.html"), run("4", "c.html"));
    assert_eq!(first.0, again.0);
    assert!(first.1 == again.1, "the pages of one seed differ");
    assert!(first.0 != other.0 && first.1 != other.1, "another seed, but the same drive");
}

#[test]
fn what_is_shown_is_what_is_in_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let shown = demo(folder.path(), &[]);
    let published = frames(demo(folder.path(), &["--all"]).as_bytes());
    let database = built_in_database().unwrap();
    let (message, signal) = database.signal("GRIP_STIFFNESS_LONG.SlopeFL").unwrap();
    let lines: Vec<Vec<&str>> = shown.lines().map(|line| line.split_whitespace().collect()).collect();
    for second in [10.0, 60.0, 100.0] {
        let frame = published.iter().find(|f| f.id == message.id && f.time.seconds() >= second).unwrap();
        let expected = format!("{:.1}", signal.decode(frame.data()).unwrap());
        let line = lines.iter().find(|line| line.first() == Some(&format!("{second:.0}").as_str())).unwrap();
        assert_eq!(line[2], expected, "{line:?}");
    }
    let seconds = lines.iter().filter(|line| line.len() > 5 && line[0].parse::<u32>().is_ok()).count();
    assert!((120..=121).contains(&seconds), "{seconds} lines");
}

#[test]
fn its_recording_replays_to_the_same_frames() {
    let folder = tempfile::tempdir().unwrap();
    let published = demo(folder.path(), &["--all", "--log", "drive.log.zst"]);
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/config/demo.toml");
    let replayed = gripd(folder.path(), &["replay", "-c", config, "drive.log.zst", "-o", "-"]);
    assert!(replayed.status.success());
    let (published, replayed) = (frames(published.as_bytes()), frames(&replayed.stdout));
    assert!(published.len() > 30_000 && published == replayed, "the service and the replay differ");
}

#[test]
fn what_cannot_be_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, code, expected) in [
        (&["--interface", "no_such_if"][..], 2, "no_such_if"),
        (&["--interface", "a/b"], 2, "name of an interface"),
        (&["--interface", "vcan0", "--memory"], 2, "cannot be used with"),
        (&["--memory", "-o", "nowhere/page.html"], 1, "nowhere/page.html"),
        (&["--memory", "--log", "nowhere/drive.log"], 1, "nowhere/drive.log"),
        (&["--memory", "--scenario", "none.toml"], 2, "none.toml"),
        (&["--memory", "--scenario", "bad.toml"], 2, "bad.toml"),
    ] {
        fs::write(folder.path().join("bad.toml"), "duration_s = -1").unwrap();
        let output = gripd(folder.path(), &[&["demo"], arguments].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
}

#[test]
fn a_drive_without_surfaces_has_a_page_too() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = "duration_s = 5.0\ninitial_speed_mps = 15.0\n[vehicle]\nmass_kg = 1450.0\nwheelbase_m = 2.65\n\
                    cg_to_front_m = 1.2\nwheel_radius_m = 0.31\nsteering_ratio = 15.5\ndriven_axle = \"front\"\n";
    // No sensor says anything, so nothing is published.
    fs::write(folder.path().join("still.toml"), scenario).unwrap();
    let text = demo(folder.path(), &["--scenario", "still.toml"]);
    assert!(text.contains("published frames 0"), "{text}");
    assert_balanced(&fs::read_to_string(folder.path().join("gripd-demo.html")).unwrap());
}
