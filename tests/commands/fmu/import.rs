//! `gripd explain --fmu`: FMUs of other programs, and what they may do wrong.

use std::fs;
use std::path::Path;
use std::process::Output;
use std::time::Duration;

use gripd::Quantity;
use gripd::fmu::foreign::{FmuConfig, Program, Recorded, Unpacked, Wiring, tune};
use testing::program::{executable, gripd_in};

use super::archives::{FOREIGN, archive, configure, drive, foreign};

fn explained(folder: &Path, fmu: &str) -> Output {
    gripd_in(folder, &format!("-q explain -c car.toml drive.log --fmu {fmu}"))
}

#[track_caller]
fn refused(output: &Output, code: i32, expected: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(said.contains(expected) && !said.contains("panicked"), "{expected}: {said}");
    assert_eq!(said.lines().count(), 1, "nothing else is said: {said}");
}

/// GIVEN files that are no FMUs, or none for here THEN that is said.
#[test]
fn what_is_no_fmu_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    drive(folder.path(), 14);
    fs::write(at("text.fmu"), "no archive").unwrap();
    archive(&at("empty.fmu"), &[]);
    archive(&at("broken.fmu"), &[("modelDescription.xml", b"<fmiModelDescription")]);
    archive(&at("one.fmu"), &[("modelDescription.xml", b"<fmiModelDescription fmiVersion='1.0'/>")]);
    let description = ("modelDescription.xml", FOREIGN.as_bytes());
    archive(&at("windows.fmu"), &[description, ("binaries/win64/somebody.dll", b"MZ")]);
    archive(&at("sources.fmu"), &[description, ("sources/all.c", b"int x;")]);
    archive(&at("nonsense.fmu"), &[description, ("binaries/linux64/somebody.so", b"no library")]);
    archive(
        &at("escaping.fmu"),
        &[description, ("binaries/linux64/somebody.so", b""), ("resources/../../escaped", b"x")],
    );
    // Cut off in the middle.
    let whole = fs::read(at("nonsense.fmu")).unwrap();
    fs::write(at("cut.fmu"), &whole[..whole.len() / 2]).unwrap();
    configure(folder.path(), "[fmu.outputs]\nyaw_rate = 'psi_dot'");
    for (name, expected) in [
        ("none.fmu", "cannot read the FMU none.fmu"),
        ("text.fmu", "text.fmu is no FMU that can be unpacked"),
        ("cut.fmu", "cut.fmu is no FMU that can be unpacked"),
        ("empty.fmu", "is it an FMU?"),
        ("broken.fmu", "broken.fmu: modelDescription.xml"),
        ("one.fmu", "FMI `1.0` cannot be run"),
        ("windows.fmu", "binaries/linux64/somebody.so is needed; it has libraries in win64"),
        ("sources.fmu", "it has sources at most"),
        ("escaping.fmu", "whose name leads out of it"),
        ("nonsense.fmu", "its library cannot be loaded"),
    ] {
        refused(&explained(folder.path(), name), 1, expected);
    }
    assert!(!folder.path().parent().unwrap().join("escaped").exists());
}

/// GIVEN an FMU that crashes, waits for ever, answers nonsense or ends the process THEN the command ends with a clear error,
/// in time. GIVEN a table that does not fit THEN its key is named.
#[test]
fn what_an_fmu_does_wrong_is_said() {
    let folder = tempfile::tempdir().unwrap();
    drive(folder.path(), 14);
    foreign(folder.path());
    let mood = |mood: u8| {
        format!("[fmu]\ntime_limit_s = 2.0\noutputs = {{ yaw_rate = 'psi_dot' }}\nset = {{ mood = {mood} }}")
    };
    for (table, code, expected) in [
        (mood(1), 1, "foreign.fmu: it crashed (SIGSEGV), at 1.0"),
        (mood(2), 1, "it was ended after 2 s, at 1.0"),
        (mood(3), 1, "its variable 1 is NaN at 0.000 s"),
        (mood(4), 1, "s on failed with an error"),
        (mood(5), 1, "not all of them"),
        (mood(6), 1, "crashed (SIGABRT), at 1.0"),
        (mood(6), 1, "it said: no licence was found"),
        (String::new(), 2, "[fmu].outputs: which output is the yaw rate?"),
        (
            "[fmu.outputs]\nyaw_rate = 'psi'".into(),
            2,
            "[fmu].outputs.yaw_rate: the FMU has no variable `psi`",
        ),
        ("[fmu.outputs]\nyaw_rate = 'psi'".into(), 2, "it has psi_dot"),
        ("[fmu.outputs]\nyaw_rate = { variable = 'psi_dot', unit = 'm' }".into(), 2, "unit \"m\""),
        ("[fmu]\ninputs = { yaw_rate = 'psi_dot' }".into(), 2, "is no input of the FMU"),
        ("[fmu]\noutputs = { yaw_rate = 'psi_dot' }\nset = { x = 1 }".into(), 2, "[fmu].set.x"),
        (
            "[fmu]\noutputs = { yaw_rate = 'psi_dot' }\ntune = { gain = [0.0, 20.0] }".into(),
            2,
            "[fmu].tune.gain: the FMU takes 0 to 10 only",
        ),
        ("[fmu]\ntime_limit = 1".into(), 2, "time_limit"),
    ] {
        configure(folder.path(), &table);
        let output = explained(folder.path(), "foreign.fmu");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{table}: {said}");
        assert!(said.contains(expected) && !said.contains("panicked"), "{table}: {expected}: {said}");
    }
    for more in ["--simulation drive.log", "--reference drive.log", "drive.log"] {
        let output = explained(folder.path(), &format!("foreign.fmu {more}"));
        assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

/// GIVEN a recording made with other numbers WHEN the FMU is tuned within ranges THEN they are found, and one whose range
/// leaves them out ends at its end.
#[test]
fn parameters_are_tuned_within_their_ranges() {
    let folder = tempfile::tempdir().unwrap();
    let path = foreign(folder.path());
    let fmu = Unpacked::new(&path, folder.path()).unwrap();
    let mut recorded = Recorded::default();
    let (gain, lag, zero) = (0.2, 0.25, 0.01);
    let mut yaw_rate = 0.0;
    for i in 0..2000 {
        let t = f64::from(i) * 0.01;
        let steering = 0.8 * (0.9 * t).sin() + 0.2 * (4.0 * t).cos();
        recorded[Quantity::SteeringWheelAngle as usize].push((t, steering));
        recorded[Quantity::YawRate as usize].push((t, yaw_rate + zero));
        let next = 0.8 * (0.9 * (t + 0.01)).sin() + 0.2 * (4.0 * (t + 0.01)).cos();
        let left = f64::exp(-0.01 / lag);
        yaw_rate = left * yaw_rate + (1.0 - left) * gain * 0.5 * (steering + next);
    }
    let to_si = |_: Quantity, _: &str| Ok(std::f64::consts::PI / 180.0);
    let program = Program {
        executable: executable(),
        folder: folder.path().to_owned(),
        limit: Duration::from_secs(60),
    };
    let tuned = |table: &str| {
        let config = FmuConfig::of_file(&format!("[fmu.outputs]\nyaw_rate = 'psi_dot'\n{table}")).unwrap();
        let wiring = Wiring::new(&fmu, &config, &recorded, &to_si).unwrap();
        assert_eq!((wiring.job.steps, wiring.job.step_s), (1999, 0.01));
        tune(&wiring, &recorded, &program, &path).unwrap()
    };
    let free = tuned("[fmu.tune]\ngain = [0.05, 2.0]\nlag = [0.05, 1.0]");
    let values: Vec<_> =
        free.values.iter().map(|(name, _, value, at_end)| (name.as_str(), *value, *at_end)).collect();
    assert!(
        matches!(values[..], [("gain", g, false), ("lag", l, false)]
        if (g - gain).abs() < 1e-3 && (l - lag).abs() < 2e-3),
        "{values:?}"
    );
    assert!(free.left[1] < 1e-3 && free.left[0] > 1.0, "{:?}", free.left);
    let narrow = tuned("[fmu.tune]\ngain = [0.5, 2.0]");
    assert!(narrow.values[0].3 && (narrow.values[0].2 - 0.5).abs() < 1e-6, "{:?}", narrow.values);
    let none = tuned("");
    assert!(none.values.is_empty() && none.left[0] == none.left[1]);
}

mod by_hand {
    use super::*;

    /// GIVEN a car's own FMU, which has no relaxation length, and a drive of a car that has one THEN that is among what it leaves
    /// out.
    #[test]
    #[ignore = "by hand, long: a car fitted to a simulation"]
    fn its_own_fmu_lacks_what_it_was_exported_without() {
        let folder = tempfile::tempdir().unwrap();
        drive(folder.path(), 40);
        let path = folder.path().join("scenario.toml");
        let scenario = fs::read_to_string(&path).unwrap();
        let quick = "[[steering_wheel_angle]]\nkind = 'random'\nrms = 0.35\ncorrelation_time_s = 0.2\n\
                     [[effect]]\nkind = 'relaxation_length'\nlength_m = 0.8\n";
        fs::write(&path, format!("{scenario}\n{quick}")).unwrap();
        for arguments in [
            "-q simulate scenario.toml -o drive.log",
            "-q export -c car.toml --fmu car.fmu --fmi 3",
            "-q explain -c car.toml drive.log --fmu car.fmu --json answer.json",
        ] {
            let output = gripd_in(folder.path(), arguments);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
        let answer = fs::read_to_string(folder.path().join("answer.json")).unwrap();
        let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
        assert_eq!(answer["simulation"]["steered_alike"], true, "{}", answer["simulation"]);
        let findings = answer["findings"].as_array().unwrap();
        let found = findings.iter().find(|finding| finding["effect"] == "relaxation_length");
        let length = found.map(|finding| finding["parameters"]["length_m"]["value"].as_f64().unwrap());
        assert!(length.is_some_and(|length| (length - 0.8).abs() < 0.1), "{findings:?}");
    }
}
