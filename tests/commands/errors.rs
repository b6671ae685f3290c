//! Malformed input: exit codes as the contract has them, messages that name the place, no panic, and no
//! memory beyond what a good input takes.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use flate2::Compression;
use flate2::write::GzEncoder;
use tempfile::TempDir;
use testing::program;

const DBC: &str = r#"VERSION ""
BU_: CAR
BO_ 416 WHEELS: 8 CAR
 SG_ FL : 0|16@1+ (0.01,0) [0|400] "rad/s" CAR
 SG_ FR : 16|16@1+ (0.01,0) [0|400] "rad/s" CAR
 SG_ RL : 32|16@1+ (0.01,0) [0|400] "rad/s" CAR
 SG_ RR : 48|16@1+ (0.01,0) [0|400] "rad/s" CAR
BO_ 432 INERTIAL: 8 CAR
 SG_ Yaw : 0|16@1- (0.001,0) [-3|3] "rad/s" CAR
 SG_ Lateral : 16|16@1- (0.01,0) [-30|30] "m/s2" CAR
 SG_ Counter : 48|4@1+ (1,0) [0|15] "" CAR
 SG_ Crc : 56|8@1+ (1,0) [0|255] "" CAR
BO_ 448 STEERING: 4 CAR
 SG_ Angle : 0|16@1- (0.001,0) [-16|16] "rad" CAR
"#;

const CAR: &str = r#"[dbc]
input = ["car.dbc"]

[signals]
wheel_speed_fl = "WHEELS.FL"
wheel_speed_fr = "WHEELS.FR"
wheel_speed_rl = "WHEELS.RL"
wheel_speed_rr = "WHEELS.RR"
yaw_rate = "INERTIAL.Yaw"
lateral_acceleration = "INERTIAL.Lateral"
steering_wheel_angle = "STEERING.Angle"

[vehicle]
mass_kg = 1500.0
wheelbase_m = 2.7
cg_to_front_m = 1.2
wheel_radius_m = 0.31
steering_ratio = 15.0
driven_axle = "front"
"#;

const SCENARIO: &str = "duration_s = 1\ninitial_speed_mps = 20\n[vehicle]\nmass_kg = 1500\nwheelbase_m = 2.7\n\
    cg_to_front_m = 1.2\nwheel_radius_m = 0.31\nsteering_ratio = 15\ndriven_axle = \"front\"\n";

/// What became of a run.
struct Ended {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Ended {
    /// With this exit code, and a message that names all of these.
    #[track_caller]
    fn with(&self, code: i32, named: &[&str]) {
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        for name in named {
            assert!(self.stderr.contains(name), "no `{name}` in: {}", self.stderr);
        }
    }
}

/// A folder with a good car in it, for tests to spoil.
struct Garage(TempDir);

impl Garage {
    fn new() -> Self {
        let garage = Self(tempfile::tempdir().unwrap());
        garage.write("car.dbc", DBC);
        garage.write("car.toml", CAR);
        garage.write("drive.log", drive(300));
        garage
    }

    /// The same, with a part of the configuration exchanged.
    fn with(from: &str, to: &str) -> Self {
        let garage = Self::new();
        assert!(CAR.contains(from), "{from}");
        garage.write("car.toml", CAR.replacen(from, to, 1));
        garage
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    fn gripd(&self, arguments: &[&str]) -> Ended {
        let output = self.command(arguments).stdin(Stdio::null()).output().unwrap();
        Ended {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = program::gripd();
        command.args(arguments).current_dir(self.0.path());
        command
    }

    /// A configuration error is the same, whoever reads the configuration.
    #[track_caller]
    fn refused(&self, named: &[&str]) {
        self.gripd(&["check", "-c", "car.toml"]).with(2, named);
        self.gripd(&["replay", "-c", "car.toml", "drive.log"]).with(2, named);
        self.gripd(&["run", "-c", "car.toml"]).with(2, named);
    }
}

/// Straight ahead at 15 m/s.
fn drive(rows: usize) -> String {
    let row = |i: usize| {
        let t = format!("({}.{:06}) can0", 1000 + i / 100, i % 100 * 10_000);
        format!("{t} 1A0#E812E812E812E812\n{t} 1B0#0000000000000000\n{t} 1C0#00000000\n")
    };
    (0..rows).map(row).collect()
}

fn packed(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(text.as_bytes()).unwrap();
    encoder.finish().unwrap()
}

/// GIVEN a name that ends as no format does THEN it is refused with those that do, and nothing is written; --format says it all the
/// same, and a name without an ending is a candump log.
#[test]
fn a_recording_is_converted_to_a_format_that_is_known() {
    let garage = Garage::new();
    garage
        .gripd(&["convert", "drive.log", "-o", "drive.xyz"])
        .with(2, &["drive.xyz", ".xyz", ".mf4", "--format"]);
    garage.gripd(&["convert", "drive.log", "-o", "drive.xyz.gz"]).with(2, &[".xyz"]);
    assert!(!garage.path("drive.xyz").exists());
    for (arguments, name) in [(&["--format", "asc"][..], "drive.xyz"), (&[], "drive"), (&[], "packed.gz")] {
        garage.gripd(&[&["convert", "drive.log", "-o", name], arguments].concat()).with(0, &[]);
        assert!(garage.path(name).exists(), "{name}");
    }
}

/// GIVEN a recording of a car that is parked THEN `check` says that it stands and warns of no signal, and `explain` says in words
/// that this is too little, with exit code 0.
#[test]
fn a_parked_car_is_told_in_words() {
    let garage = Garage::new();
    // Wheels and yaw rate rest at the same code, as they do at standstill.
    let frame =
        |i: i32, id: &str, data: &str| format!("({}.{:02}0000) can0 {id}#{data}\n", 100 + i / 100, i % 100);
    let log: String = (0..2000)
        .flat_map(|i| {
            [
                frame(i, "1A0", "0A000A000A000A00"),
                frame(i, "1B0", "0000000000000000"),
                frame(i, "1C0", "10000000"),
            ]
        })
        .collect();
    garage.write("parked.log", log);
    let checked = garage.gripd(&["-q", "check", "-c", "car.toml", "parked.log"]);
    checked.with(0, &[]);
    assert!(checked.stdout.contains("the car stands from 0.0 to 20.0 s"), "{}", checked.stdout);
    assert!(!checked.stdout.contains("stands still"), "{}", checked.stdout);
    assert!(checked.stdout.contains("nothing could be compared"), "{}", checked.stdout);
    let explained = garage.gripd(&["-q", "explain", "-c", "car.toml", "parked.log", "--json", "answer.json"]);
    explained.with(0, &[]);
    for part in
        ["Too little excitation", "Used: 0 of 20 s", "standing, or slower than 3 m/s", "To drive next"]
    {
        assert!(explained.stdout.replace("\n  ", " ").contains(part), "{part}: {}", explained.stdout);
    }
    assert!(!explained.stdout.contains("-0 s") && !explained.stdout.contains("−0 s"), "{}", explained.stdout);
    let answer = std::fs::read_to_string(garage.path("answer.json")).unwrap();
    let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(answer["verdict"], "insufficient_excitation");
    assert_eq!(answer["used"][0]["used_s"].as_f64(), Some(0.0));
}

/// GIVEN a shell THEN it completes the names of parameters; one that is none is refused with those that are.
#[test]
fn shells_complete_names_of_parameters() {
    let garage = Garage::new();
    for shell in ["bash", "zsh", "fish"] {
        let completions = garage.gripd(&["completions", shell]);
        completions.with(0, &[]);
        for name in ["yaw_inertia_kgm2", "lateral_stiffness", "steering_wheel_angle_offset"] {
            assert!(completions.stdout.contains(name), "{shell}: {name}");
        }
    }
}

/// GIVEN bash WHEN a list's second name is begun THEN it is completed behind the comma.
#[test]
fn bash_completes_behind_a_comma() {
    let garage = Garage::new();
    let script = garage.gripd(&["completions", "bash"]).stdout.clone()
        + "COMP_WORDS=(gripd identify --parameters friction,lateral_stiffness_f); COMP_CWORD=3\n\
           _gripd_lists gripd friction,lateral_stiffness_f --parameters; printf '%s\n' \"${COMPREPLY[@]}\"\n\
           complete -p gripd";
    std::fs::write(garage.path("try.sh"), script).unwrap();
    let Ok(output) = std::process::Command::new("bash").arg(garage.path("try.sh")).output() else { return };
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(told.starts_with("friction,lateral_stiffness_front\n"), "{told}{output:?}");
    assert!(told.contains("-F _gripd_lists "), "{told}");
}

/// GIVEN a name for a recording whose ending is no format's THEN whoever writes recordings refuses it.
#[test]
fn no_recording_is_written_under_an_unknown_ending() {
    let garage = Garage::new();
    std::fs::copy(program::project("config/scenarios/demo.toml"), garage.path("scenario.toml")).unwrap();
    for command in [
        &["replay", "-c", "car.toml", "drive.log", "-o", "out.xyz"][..],
        &["simulate", "scenario.toml", "-o", "out.xyz"],
        &["convert", "drive.log", "-o", "out.xyz"],
    ] {
        let refused = garage.gripd(command);
        refused.with(2, &["out.xyz: no format ends in .xyz"]);
        assert_eq!(refused.stderr.contains("--format"), command[0] == "convert", "{}", refused.stderr);
        assert!(!garage.path("out.xyz").exists());
    }
}

#[test]
fn the_good_car_is_good() {
    let garage = Garage::new();
    garage.gripd(&["check", "-c", "car.toml"]).with(0, &[]);
    garage.gripd(&["check", "-c", "car.toml", "drive.log"]).with(0, &[]);
    garage.gripd(&["replay", "-c", "car.toml", "drive.log"]).with(0, &[]);
}

#[test]
fn no_result_goes_over_what_it_is_made_of() {
    let garage = Garage::with("[vehicle]", "[service]\nstate_file = \"learned\"\n[vehicle]");
    garage.write("learned", "kept");
    garage.write("drive.toml", SCENARIO);
    let names = ["car.toml", "car.dbc", "learned", "drive.log", "drive.toml"];
    let contents = || names.map(|name| std::fs::read(garage.path(name)).unwrap());
    let before = contents();
    let car = ["-c", "car.toml", "drive.log"];
    for (command, option) in [
        ("check", "--json"),
        ("replay", "-o"),
        ("replay", "--estimates"),
        ("replay", "--stats"),
        ("replay", "--html"),
        ("identify", "--json"),
        ("identify", "--html"),
        ("explain", "--json"),
        ("explain", "--html"),
        ("explain", "--apply"),
    ] {
        for result in &names[..4] {
            let arguments = [&[command], &car[..], &[option, result]].concat();
            garage.gripd(&arguments).with(2, &[result, "another name"]);
        }
    }
    for result in ["car.toml", "car.dbc", "drive.toml"] {
        let arguments = ["simulate", "drive.toml", "-c", "car.toml", "-o", result];
        garage.gripd(&arguments).with(2, &[result, "another name"]);
    }
    assert!(contents() == before);
}

// ---- recordings ----

#[test]
fn a_truncated_gzip_log_is_read_as_far_as_it_goes_and_named() {
    let garage = Garage::new();
    let whole = packed(&drive(3000));
    garage.write("cut.log.gz", &whole[..whole.len() / 2]);
    let checked = garage.gripd(&["check", "-c", "car.toml", "cut.log.gz"]);
    checked.with(1, &["cut.log.gz", "cut off", "after line"]);
    assert!(checked.stdout.contains("recording cut.log.gz"), "{}", checked.stdout);
    garage
        .gripd(&["replay", "-c", "car.toml", "cut.log.gz", "--stats", "s.json"])
        .with(1, &["cut.log.gz", "cut off"]);
    let stats: serde_json::Value =
        serde_json::from_slice(&std::fs::read(garage.path("s.json")).unwrap()).unwrap();
    assert!(stats["frames_in"].as_u64().unwrap() > 1000, "{stats}");
}

#[test]
fn binary_garbage_is_no_recording() {
    let garage = Garage::new();
    let mut state = 1u64;
    let noise: Vec<u8> = std::iter::repeat_with(|| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    })
    .take(1 << 20)
    .collect();
    garage.write("noise.log", &noise);
    let checked = garage.gripd(&["check", "-c", "car.toml", "noise.log"]);
    checked.with(1, &["noise.log"]);
    garage.gripd(&["replay", "-c", "car.toml", "noise.log"]).with(1, &["noise.log"]);
    let mut broken = packed(&drive(3000));
    let middle = broken.len() / 2;
    broken[middle..middle + 64].fill(0xA5);
    garage.write("broken.log.gz", &broken);
    garage.gripd(&["check", "-c", "car.toml", "broken.log.gz"]).with(1, &["broken.log.gz"]);
    garage.gripd(&["replay", "-c", "car.toml", "broken.log.gz"]).with(1, &["broken.log.gz"]);
}

#[test]
fn a_line_without_end_takes_no_memory() {
    let garage = Garage::new();
    for command in [&["check", "-c", "car.toml", "-"][..], &["replay", "-c", "car.toml", "-"]] {
        // A limit on memory that a line kept whole would break.
        let program = env!("CARGO_BIN_EXE_gripd");
        let mut child = Command::new("sh")
            .args(["-c", "ulimit -v 400000; exec \"$0\" \"$@\"", program])
            .args(command)
            .current_dir(garage.0.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdin = child.stdin.take().unwrap();
        stdin.write_all(drive(200).as_bytes()).unwrap();
        let chunk = vec![b'A'; 1 << 20];
        for _ in 0..500 {
            stdin.write_all(&chunk).unwrap();
        }
        stdin.write_all(b"\n").unwrap();
        drop(stdin);
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{stderr}");
    }
}

#[test]
fn frames_of_the_wrong_length_are_counted_and_what_never_comes_is_named() {
    let garage = Garage::new();
    garage.write("short.log", drive(300).replace("1B0#0000000000000000", "1B0#000000"));
    let checked = garage.gripd(&["check", "-c", "car.toml", "short.log"]);
    checked.with(1, &["signals.yaw_rate"]);
    assert!(checked.stdout.contains("warning: lateral_acceleration never has a value"), "{}", checked.stdout);
    assert!(checked.stdout.contains("INERTIAL (1B0): 300 of 300 frames too short"), "{}", checked.stdout);
    garage.write("other.log", drive(300).replace("1C0#", "1C1#"));
    let checked = garage.gripd(&["check", "-c", "car.toml", "other.log"]);
    checked.with(1, &["signals.steering_wheel_angle", "never comes"]);
    assert!(checked.stdout.contains("STEERING (1C0) never comes"), "{}", checked.stdout);
    garage.write("lines.log", drive(200) + "(1.0 can0 1A0#00\n" + &drive(200));
    let checked = garage.gripd(&["check", "-c", "car.toml", "lines.log"]);
    checked.with(0, &[]);
    assert!(checked.stdout.contains("1 lines skipped, 1 times backwards"), "{}", checked.stdout);
    assert!(checked.stdout.contains("line 601"), "{}", checked.stdout);
}

#[test]
fn missing_files_are_named() {
    let garage = Garage::new();
    garage.gripd(&["check", "-c", "none.toml"]).with(2, &["none.toml"]);
    garage.gripd(&["run", "-c", "none.toml"]).with(2, &["none.toml"]);
    garage.gripd(&["replay", "-c", "none.toml", "drive.log"]).with(2, &["none.toml"]);
    garage.gripd(&["check", "-c", "car.toml", "none.log"]).with(1, &["none.log"]);
    garage.gripd(&["replay", "-c", "car.toml", "none.log"]).with(1, &["none.log"]);
    garage.gripd(&["simulate", "none.toml", "-o", "out.log"]).with(2, &["none.toml"]);
    garage.gripd(&["check", "-c", "car.toml", "."]).with(1, &["."]);
    std::fs::remove_file(garage.path("car.dbc")).unwrap();
    garage.refused(&["car.dbc"]);
}

// ---- configuration ----

#[test]
fn unknown_keys_are_named_with_line_and_what_was_meant() {
    Garage::with("yaw_rate =", "yawrate =").refused(&["car.toml", "line 9", "yawrate", "`yaw_rate`"]);
    Garage::with("mass_kg =", "mass =").refused(&["car.toml", "line 14", "mass", "`mass_kg`"]);
    Garage::with("[vehicle]", "[vehikle]").refused(&["car.toml", "line 13", "vehikle", "`vehicle`"]);
    Garage::with("\"INERTIAL.Yaw\"", "{ signal = \"INERTIAL.Yaw\", timeout = 3 }").refused(&[
        "car.toml",
        "line 9",
        "timeout",
        "`timeout_ms`",
    ]);
    Garage::with("input =", "inputs =").refused(&["car.toml", "line 2", "inputs", "`input`"]);
}

#[test]
fn values_of_the_wrong_kind_are_named_with_line() {
    Garage::with("mass_kg = 1500.0", "mass_kg = \"heavy\"").refused(&["car.toml", "line 14", "value"]);
    Garage::with("\"front\"", "\"middle\"").refused(&["car.toml", "line 19", "middle", "`front`"]);
    Garage::with("[\"car.dbc\"]", "3").refused(&["car.toml", "line 2"]);
    Garage::with("\"INERTIAL.Yaw\"", "7").refused(&["car.toml", "line 9", "MESSAGE.Signal"]);
    Garage::with("wheelbase_m = 2.7", "wheelbase_m = 2,7").refused(&["car.toml", "line 15"]);
}

#[test]
fn impossible_values_are_named_with_key() {
    Garage::with("mass_kg = 1500.0", "mass_kg = -1500.0").refused(&["car.toml", "vehicle.mass_kg", "-1500"]);
    Garage::with("mass_kg = 1500.0", "mass_kg = nan").refused(&["car.toml", "vehicle.mass_kg"]);
    Garage::with("mass_kg = 1500.0", "mass_kg = { value = 1500, std = -1 }")
        .refused(&["vehicle.mass_kg", "std"]);
    Garage::with("cg_to_front_m = 1.2", "cg_to_front_m = 3.2")
        .refused(&["vehicle.cg_to_front_m", "wheelbase_m"]);
    let gain = "{ signal = \"INERTIAL.Yaw\", gain = 0.0, timeout_ms = -3 }";
    Garage::with("\"INERTIAL.Yaw\"", gain).refused(&["signals.yaw_rate.gain", "signals.yaw_rate.timeout_ms"]);
}

#[test]
fn missing_and_mistyped_signals_are_all_named_at_once() {
    let garage = Garage::with("steering_wheel_angle = \"STEERING.Angle\"\n", "");
    let text = std::fs::read_to_string(garage.path("car.toml")).unwrap();
    garage.write(
        "car.toml",
        text.replace("INERTIAL.Lateral", "INERTIAL.Laterall").replace("WHEELS.RR", "WHEEL.RR"),
    );
    garage.refused(&[
        "signals.steering_wheel_angle",
        "is required",
        "signals.lateral_acceleration",
        "INERTIAL.Lateral",
        "signals.wheel_speed_rr",
        "WHEELS",
    ]);
}

#[test]
fn an_unknown_effect_is_named() {
    let garage = Garage::new();
    garage.write("car.toml", format!("{CAR}\n[[effect]]\nkind = \"flux_capacitor\"\n"));
    garage.refused(&["car.toml", "line", "effect kind", "flux_capacitor", "load_transfer"]);
}

#[test]
fn broken_dbc_files_are_named_with_line() {
    let garage = Garage::new();
    garage.write("car.dbc", "this is no DBC file\n");
    garage.refused(&["car.dbc:1"]);
    garage.write("car.dbc", [0u8, 255, 7, 13, 200].repeat(1000));
    garage.refused(&["car.dbc"]);
    garage.write("car.dbc", DBC.replace("SG_ Yaw : 0|16@1-", "SG_ Yaw : 60|16@1-"));
    garage.refused(&["signals.yaw_rate", "car.dbc:9"]);
    garage.write("car.dbc", DBC.replace("(0.001,0) [-3|3] \"rad/s\"", "(0.001,0) [-3|3] \"bar\""));
    garage.refused(&["signals.yaw_rate", "bar", "unit = "]);
}

#[test]
fn checksums_that_cannot_be_reckoned_are_named() {
    let with_crc = |crc: &str| {
        let yaw = format!("{{ signal = \"INERTIAL.Yaw\", counter = \"INERTIAL.Counter\", crc = {crc} }}");
        Garage::with("\"INERTIAL.Yaw\"", &yaw)
    };
    with_crc("{ signal = \"INERTIAL.Crc\", kind = \"e2e_p01a\", data_id = 0x1B0 }")
        .gripd(&["check", "-c", "car.toml"])
        .with(0, &[]);
    with_crc("{ signal = \"INERTIAL.Crc\", kind = \"e2e_p01a\" }")
        .refused(&["signals.yaw_rate.crc", "data_id"]);
    with_crc("{ signal = \"INERTIAL.Crc\", kind = \"crc9\" }").refused(&["line 9", "crc9", "`crc8`"]);
    with_crc("{ signal = \"INERTIAL.Counter\", kind = \"xor8\" }").refused(&["signals.yaw_rate.crc"]);
    with_crc("{ signal = \"INERTIAL.Crk\", kind = \"xor8\" }")
        .refused(&["signals.yaw_rate.crc.signal", "Crc"]);
    with_crc("{ signal = \"INERTIAL.Crc\", kind = \"crc8\" }")
        .refused(&["signals.yaw_rate.crc", "polynomial"]);
}

#[test]
fn identifiers_that_are_read_and_written_are_named() {
    let garage = Garage::new();
    garage.write("car.toml", format!("{CAR}\n[publish.ids]\nGRIP_MOTION = 0x1A0\n"));
    garage.refused(&["1A0", "publish"]);
    garage.write("car.toml", format!("{CAR}\n[publish]\nperiod_ms = 0\n"));
    garage.refused(&["publish.period_ms"]);
}

#[test]
fn broken_scenarios_are_named() {
    let garage = Garage::new();
    let simulate = |text: &str| {
        garage.write("scenario.toml", text);
        garage.gripd(&["simulate", "scenario.toml", "-o", "out.log"])
    };
    simulate(SCENARIO).with(0, &[]);
    simulate(&SCENARIO.replace("duration_s", "duration")).with(2, &["scenario.toml", "line 1", "duration"]);
    simulate(&SCENARIO.replace("mass_kg = 1500", "mass_kg = -5")).with(2, &["vehicle.mass_kg", "-5"]);
    simulate(&SCENARIO.replace("duration_s = 1", "duration_s = -1")).with(2, &["duration_s"]);
    simulate(&format!("{SCENARIO}[[effect]]\nkind = \"flux_capacitor\"\n"))
        .with(2, &["scenario.toml", "line", "effect kind", "flux_capacitor", "load_transfer"]);
    garage.write("scenario.toml", SCENARIO);
    let nowhere = Path::new("no/such/folder/out.log");
    garage
        .gripd(&["simulate", "scenario.toml", "-o", nowhere.to_str().unwrap()])
        .with(1, &["no/such/folder"]);
}

#[test]
fn bad_usage_is_two() {
    let garage = Garage::new();
    garage.gripd(&["replay", "-c", "car.toml"]).with(2, &["LOGS"]);
    garage.gripd(&["frobnicate"]).with(2, &["frobnicate"]);
    garage.gripd(&["replay", "-c", "car.toml", "drive.log", "--realtime=-1"]).with(2, &["--realtime"]);
    garage.gripd(&["check"]).with(2, &["--config"]);
}
