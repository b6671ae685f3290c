//! `gripd replay` as its users meet it: inputs, outputs, exit codes, and the same result every time.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::Instant;

use gripd::can::Frame;
use gripd::can::candump::Reader;
use serde_json::Value;
use tempfile::TempDir;
use testing::program::{gripd, project};

/// 20 s of the demo drive as candump text, 9000 lines.
fn drive() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        let scenario = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
        let path = folder.path().join("drive.toml");
        fs::write(&path, scenario.replace("duration_s = 120.0", "duration_s = 20.0")).unwrap();
        let output = gripd().arg("simulate").arg(path).args(["-o", "-"]).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text.lines().count(), 9000);
        text
    })
}

/// A folder with the drive in it, and replays there.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(TempDir::new().unwrap());
        place.write("drive.log", drive().as_bytes());
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: &[u8]) {
        fs::write(self.path(name), content).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// `gripd replay` of the demo car with these arguments, in this folder.
    fn replay(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = gripd();
        command.current_dir(self.0.path()).args(["replay", "-c"]).arg(project("config/demo.toml"));
        command.args(arguments.split_whitespace());
        command
    }

    /// The same; it must succeed. What it wrote to stdout.
    #[track_caller]
    fn replayed(&self, arguments: &str) -> String {
        let output = self.replay(arguments);
        assert!(output.status.success(), "{}", complaint(&output));
        String::from_utf8(output.stdout).unwrap()
    }
}

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn frames(text: &str) -> Vec<Frame> {
    let mut reader = Reader::from_read(Box::new(std::io::Cursor::new(text.to_owned())), "output").unwrap();
    let frames = std::iter::from_fn(|| reader.next_frame().unwrap()).collect();
    assert_eq!(reader.stats().skipped_lines, 0);
    frames
}

/// GIVEN any drive THEN a table on the standard error says of each published number how much of the time it was valid and, where
/// it was not, why; with -q it does not.
#[test]
fn what_was_learned_is_said_at_the_end() {
    let place = Place::new();
    let output = place.replay("drive.log");
    let said = String::from_utf8(output.stderr).unwrap();
    let line =
        |name: &str| said.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{said}"));
    let slope = line("Slip slope, front left");
    assert!(slope.contains(" % ") && slope.contains('±'), "{slope}");
    assert!(line("Friction available").contains("only a lower bound"), "{said}");
    assert!(line("highest use of the friction: 0.").ends_with(" s"), "{said}");
    assert!(output.stdout.is_empty());
    let quiet = place.replay("-q drive.log");
    assert!(quiet.stderr.is_empty(), "{}", String::from_utf8_lossy(&quiet.stderr));
}

#[test]
fn stdout_carries_the_published_frames_and_nothing_else() {
    let place = Place::new();
    let text = place.replayed("drive.log -o -");
    let published = frames(&text);
    let ids: BTreeSet<u32> = published.iter().map(|frame| frame.id.number()).collect();
    assert_eq!(ids.into_iter().collect::<Vec<_>>(), [0x6A0, 0x6A1, 0x6A2, 0x6A3, 0x6A4, 0x6A5, 0x6A6]);
    assert!((980..=1000).contains(&(published.len() / 7)), "{}", published.len());
    assert!(text.lines().all(|line| line.split(' ').nth(1) == Some("vcan0")));
    place.replayed("drive.log -o out.log");
    assert!(place.read("out.log") == text);
}

#[test]
fn all_adds_the_recording_in_order() {
    let place = Place::new();
    place.write("drive.log", drive().replace(" vcan0 ", " can7 ").as_bytes());
    let alone = place.replayed("drive.log -o -");
    let text = place.replayed("drive.log --all -o -");
    let of = |interface: &str| -> String {
        text.split_inclusive('\n').filter(|line| line.contains(interface)).collect()
    };
    assert!(of(" can7 ") == place.read("drive.log"), "the recording, line by line as it was");
    assert!(of(" vcan0 ") == alone);
    let times: Vec<_> = frames(&text).iter().map(|frame| frame.time).collect();
    assert!(times.is_sorted());
    assert_eq!(place.replay("drive.log --all").status.code(), Some(2), "--all needs -o");
}

#[test]
fn the_same_input_gives_the_same_output_to_the_last_bit_however_it_is_packed() {
    let place = Place::new();
    let outputs = |log: &str| -> [String; 3] {
        place.replayed(&format!("{log} -o out.log --estimates estimates.csv --samples samples.csv"));
        ["out.log", "estimates.csv", "samples.csv"].map(|name| place.read(name))
    };
    let first = outputs("drive.log");
    assert!(first.iter().all(|text| text.lines().count() > 1900));
    // Not assert_eq: what is not the same is long.
    assert!(outputs("drive.log") == first);

    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gzip.write_all(drive().as_bytes()).unwrap();
    place.write("drive.log.gz", &gzip.finish().unwrap());
    place.write("without_a_telling_name", &zstd::encode_all(drive().as_bytes(), 3).unwrap());
    assert!(outputs("drive.log.gz") == first);
    assert!(outputs("without_a_telling_name") == first);

    let mut child = place.command("- -o -").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(drive().as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(String::from_utf8(output.stdout).unwrap() == first[0], "from the standard input");

    // Playing it in its own time changes nothing either.
    assert!(place.replayed("drive.log --realtime=200 -o -") == first[0]);
}

#[test]
fn outputs_are_packed_as_their_names_say() {
    let place = Place::new();
    let plain = place.replayed("drive.log -o -");
    place.replayed("drive.log -o out.log.gz");
    place.replayed("drive.log -o out.log.zst");
    for (name, magic) in [("out.log.gz", &[0x1F, 0x8B][..]), ("out.log.zst", &[0x28, 0xB5, 0x2F, 0xFD])] {
        assert!(fs::read(place.path(name)).unwrap().starts_with(magic), "{name}");
        let mut reader = Reader::open(&place.path(name)).unwrap();
        let unpacked: Vec<Frame> = std::iter::from_fn(|| reader.next_frame().unwrap()).collect();
        assert!(unpacked == frames(&plain), "{name}");
    }
}

#[test]
fn a_recording_in_parts_is_one_recording() {
    let place = Place::new();
    let lines: Vec<&str> = drive().split_inclusive('\n').collect();
    place.write("a.log", lines[..3000].concat().as_bytes());
    place.write("b.log", lines[3000..3001].concat().as_bytes());
    place.write("c.log", lines[3001..].concat().as_bytes());
    place.write("empty.log", b"");
    let whole = place.replayed("drive.log -o -");
    assert!(place.replayed("a.log b.log empty.log c.log -o -") == whole);
}

#[test]
fn a_recording_that_begins_later_is_sampled_and_published_at_the_same_times() {
    let place = Place::new();
    let late: String = drive().split_inclusive('\n').skip(1237).collect();
    place.write("late.log", late.as_bytes());
    let outputs = |log: &str| {
        let published = place.replayed(&format!("{log} -o - --samples samples.csv"));
        let times = |text: &str, name| -> Vec<String> {
            text.lines().filter(|line| line.contains(name)).map(|line| line[..15].to_owned()).collect()
        };
        let samples: Vec<String> = place.read("samples.csv").lines().skip(1).map(str::to_owned).collect();
        (times(&published, " 6A5#"), samples)
    };
    let ((all, all_samples), (later, later_samples)) = (outputs("drive.log"), outputs("late.log"));
    assert!(later.len() > 800 && later_samples.len() > 1600);
    assert_eq!(all[all.len() - later.len()..], later);
    // Values too, once the ring of past values is full.
    let (tail, later_tail) = (1500, &later_samples[later_samples.len() - 1500..]);
    assert_eq!(all_samples[all_samples.len() - tail..], *later_tail);
    let grid = |line: &String| line.split(',').next().is_some_and(|t| t.ends_with("0000"));
    assert!(all_samples.iter().all(grid), "on multiples of 10 ms");
}

#[test]
fn the_columns_of_the_estimates_are_those_that_scripts_rely_on() {
    let place = Place::new();
    let text = place.replayed("drive.log --estimates -");
    let mut expected = vec!["t".to_owned(), "speed".to_owned()];
    for name in ["slope_{}", "slope_{}_std", "slip_offset_{}"] {
        expected.extend(["fl", "fr", "rl", "rr"].map(|wheel| name.replace("{}", wheel)));
    }
    expected.extend(CONTRACT.split_whitespace().map(str::to_owned));
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let header: Vec<String> = rows.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(header[..expected.len()], expected);
    let names: BTreeSet<&String> = header.iter().collect();
    assert_eq!(names.len(), header.len(), "no name twice");
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    let mut count = 0;
    let mut last = f64::NEG_INFINITY;
    // The csv reader itself refuses rows of another length.
    for row in rows.records().map(Result::unwrap) {
        let time: f64 = row[0].parse().unwrap();
        assert!(time > last);
        last = time;
        count += 1;
        for (name, value) in header.iter().zip(&row) {
            match name.as_str() {
                "mu_source" => assert!(!value.is_empty() && value.parse::<f64>().is_err(), "{value}"),
                _ if name.ends_with("_valid") => assert!(matches!(value, "0" | "1"), "{name} = {value}"),
                "faults" | "surface_changes" => assert!(value.parse::<u32>().is_ok(), "{name} = {value}"),
                _ => {
                    assert!(value.is_empty() || value.parse::<f64>().unwrap().is_finite(), "{name} = {value}")
                }
            }
        }
    }
    assert!((1980..=2000).contains(&count), "{count} samples of 10 ms in 20 s");
    let rows: Vec<csv::StringRecord> =
        csv::Reader::from_reader(text.as_bytes()).into_records().map(Result::unwrap).collect();
    let driving = rows.iter().filter(|row| row[column("speed")].parse().is_ok_and(|v: f64| v > 10.0)).count();
    assert!(driving > 1800, "the speed is there in {driving} samples");
}

/// The columns of the contract after those of the single wheels, in its order.
const CONTRACT: &str = "lateral_velocity sideslip slip_angle_front slip_angle_rear \
    vy_zero vy_integration vy_kinematic vy_bicycle vy_joint \
    cornering_front cornering_front_std cornering_rear cornering_rear_std \
    cornering_regression_front cornering_regression_rear cornering_ekf cornering_ekf_std \
    mu_max mu_max_low mu_max_high mu_used mu_source mu_brush mu_dahl mu_abs mu_map \
    slope_valid cornering_valid mu_valid motion_valid surface_changes faults";

#[test]
fn samples_are_the_configured_quantities_in_si_units() {
    let place = Place::new();
    let text = place.replayed("drive.log --samples -");
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let header: Vec<String> = rows.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(header[0], "t");
    let names: BTreeSet<&str> = header[1..].iter().map(String::as_str).collect();
    let expected = BTreeSet::from([
        "wheel_speed_fl",
        "wheel_speed_fr",
        "wheel_speed_rl",
        "wheel_speed_rr",
        "yaw_rate",
        "lateral_acceleration",
        "steering_wheel_angle",
        "longitudinal_acceleration",
        "drive_torque",
        "brake_pressure",
        "brake_active",
        "abs_active",
    ]);
    assert_eq!(names, expected);
    // The first sample of a drive at 15 m/s on wheels of about 0.31 m.
    let wheel = header.iter().position(|name| name == "wheel_speed_rl").unwrap();
    let row = rows.records().next().unwrap().unwrap();
    let speed: f64 = row[wheel].parse().unwrap();
    assert!((46.0..50.0).contains(&speed), "{speed} rad/s");
}

#[test]
fn the_stats_count_what_was_there() {
    let place = Place::new();
    let mut text = String::from("this is no frame\n# a comment\n");
    text.push_str(drive());
    text.push_str("DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n(20.5) vcan0 1A0#12\n");
    place.write("some.log", text.as_bytes());
    place.replayed("some.log --stats stats.json -o out.log");
    let stats = place.json("stats.json");
    let number = |key: &str| stats[key].as_f64().unwrap_or_else(|| panic!("{key} in {stats}"));
    assert_eq!(number("frames_in"), 9001.0);
    assert_eq!(number("frames_out"), frames(&place.read("out.log")).len() as f64);
    assert_eq!(number("skipped_lines"), 1.0);
    assert_eq!(number("dropped_by_recorder"), 3.0);
    assert!((number("seconds_of_recording") - 20.5).abs() < 0.01);
    assert!(number("wall_s") > 0.0);
    assert!((number("frames_per_s") * number("wall_s") / 9001.0 - 1.0).abs() < 1e-6);
    assert_eq!(stats["faults"]["frame"], 1, "the short frame: {stats}");
}

#[test]
fn real_time_is_paced() {
    let place = Place::new();
    let begun = Instant::now();
    place.replayed("drive.log --realtime=50 -o out.log");
    let took = begun.elapsed().as_secs_f64();
    // 20 s fifty times as fast; a busy machine may take longer.
    assert!((0.4..5.0).contains(&took), "{took} s");
    for wrong in ["0", "-1", "nan", "inf", "fast"] {
        assert_eq!(place.replay(&format!("drive.log --realtime={wrong}")).status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn what_is_wrong_with_the_usage_ends_with_two() {
    let place = Place::new();
    place.write("bad.toml", b"[bus]\ninterfaze = \"can0\"\n");
    let with =
        |config: &str| gripd().args(["replay", "-c"]).arg(place.path(config)).arg("x").output().unwrap();
    for (output, text) in [
        (place.replay(""), "LOG"),
        (place.replay("drive.log --no-such-option"), "--no-such-option"),
        (with("missing.toml"), "missing.toml"),
        (with("bad.toml"), "interfaze"),
    ] {
        assert_eq!(output.status.code(), Some(2), "{}", complaint(&output));
        assert!(complaint(&output).contains(text), "{}", complaint(&output));
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn a_recording_that_cannot_be_read_ends_with_one_and_leaves_what_was_there() {
    let place = Place::new();
    place.write("out.log", b"precious");
    place.write("table.blf", b"LOGG\x90\0\0\0rest of a Vector BLF file");
    for log in ["missing.log", "table.blf", "."] {
        let output = place.replay(&format!("drive.log {log} -o out.log"));
        assert_eq!(output.status.code(), Some(1), "{log}: {}", complaint(&output));
        assert!(complaint(&output).contains(log), "{log}: {}", complaint(&output));
        assert_eq!(place.read("out.log"), "precious", "{log}");
    }
    let output = place.replay("drive.log -o no/such/folder/out.log");
    assert_eq!(output.status.code(), Some(1), "{}", complaint(&output));
    assert!(complaint(&output).contains("no/such/folder"), "{}", complaint(&output));
    let left: Vec<_> =
        fs::read_dir(place.0.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), 3, "nothing half written is left: {left:?}");
}

#[test]
fn a_truncated_recording_gives_what_could_be_read_and_ends_with_one() {
    let place = Place::new();
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gzip.write_all(drive().as_bytes()).unwrap();
    let packed = gzip.finish().unwrap();
    place.write("cut.log.gz", &packed[..packed.len() / 2]);
    let output = place.replay("cut.log.gz -o out.log --stats stats.json");
    assert_eq!(output.status.code(), Some(1));
    let complaint = complaint(&output);
    assert!(complaint.contains("cut.log.gz") && complaint.contains("cut off"), "{complaint}");
    let whole = place.replayed("drive.log -o -");
    let cut = place.read("out.log");
    assert!(cut.len() > whole.len() / 4, "{} of {} bytes", cut.len(), whole.len());
    assert!(whole.starts_with(&cut), "the same as far as it goes");
    assert!(place.json("stats.json")["frames_in"].as_u64().unwrap() > 2000);
}

/// `gripd replay … -o - | head`: it ends instead of working on for nobody, and that is no failure.
#[test]
fn a_reader_that_goes_away_ends_it() {
    let place = Place::new();
    let long = drive().repeat(20);
    place.write("long.log", long.as_bytes());
    let mut child =
        place.command("long.log -o -").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", complaint(&output));
    assert!(!complaint(&output).contains("pipe"), "{}", complaint(&output));
}

#[test]
fn a_result_never_overwrites_what_it_is_made_of() {
    let place = Place::new();
    let before = place.read("drive.log");
    for arguments in [
        "drive.log -o drive.log",
        "drive.log --estimates ./drive.log",
        "drive.log -o x --samples x",
        "drive.log -o - --estimates -",
    ] {
        let output = place.replay(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {}", complaint(&output));
        assert!(place.read("drive.log") == before, "{arguments}");
    }
}

#[test]
fn a_recording_of_another_car_is_an_error_that_says_so() {
    let place = Place::new();
    place.write("other.log", b"(1.000000) can0 123#00\n(1.010000) can0 123#01\n");
    let output = place.replay("other.log -o out.log");
    assert_eq!(output.status.code(), Some(1));
    assert!(complaint(&output).contains("needed identifiers"), "{}", complaint(&output));
}

#[test]
fn after_a_gap_nothing_old_is_published_as_new() {
    let place = Place::new();
    let last = drive().lines().last().unwrap();
    let late = format!("(640.000000){}\n", &last[last.find(')').unwrap() + 1..]);
    place.write("gap.log", format!("{}{late}", drive()).as_bytes());
    let published = frames(&place.replayed("gap.log -o -"));
    let database = gripd::signals::publish::built_in_database().unwrap();
    let newest = &published[published.len() - 7..];
    assert!(newest.iter().all(|frame| frame.time.seconds() == 640.0));
    for (message, signal) in [
        ("GRIP_FRICTION", "MuMaxLow"),
        ("GRIP_STIFFNESS_LONG", "SlopeFL"),
        ("GRIP_STIFFNESS_LAT", "CorneringFront"),
        ("GRIP_MOTION", "Speed"),
    ] {
        let (message, signal) = database.signal(&format!("{message}.{signal}")).unwrap();
        let frame = newest.iter().find(|frame| frame.id == message.id).unwrap();
        assert_eq!(signal.bits(frame.data()), signal.value_named("not_available"), "{}", signal.name);
    }
}
