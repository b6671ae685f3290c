//! `gripd convert`, and commands that take every format.

use std::fs;

use super::blf_file::{classic, container, file};
use super::mf4_file::unsorted;
use testing::program::gripd_in;

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_recording_of_any_format_becomes_a_candump_log() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let objects = [classic(0, 0x123, &[1, 2]), classic(1_000_000, 0x124, &[3])].concat();
    fs::write(path.join("a.blf"), file(&[container(&objects, 2)])).unwrap();
    let frames = [(0, 0x123, vec![1, 2]), (1000, 0x124, vec![3])];
    fs::write(path.join("a.mf4"), unsorted(&frames, true)).unwrap();
    let expected = "(1760000000.000000) can1 123#0102\n(1760000000.001000) can1 124#03\n";
    for name in ["a.blf", "a.mf4"] {
        let output = gripd_in(path, &format!("convert {name} -o -"));
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert_eq!(text(&output.stdout), expected);
        assert!(text(&output.stderr).contains("2 frames"), "{}", text(&output.stderr));
        let output = gripd_in(path, &format!("convert {name} -i vcan7 -o {name}.log.gz"));
        assert!(output.status.success(), "{}", text(&output.stderr));
        let output = gripd_in(path, &format!("convert {name}.log.gz -o -"));
        assert_eq!(text(&output.stdout), expected.replace("can1", "vcan7"));
    }
}

#[test]
fn a_candump_log_becomes_a_recording_of_any_format_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let log = "(1760000000.000000) can1 123#0102\n(1760000000.001000) can0 00000124#R3\n\
               (1760000000.002000) can0 123##5112233445566778899AABBCC\n";
    fs::write(path.join("a.log"), log).unwrap();
    for name in ["a.asc", "a.asc.gz", "a.blf", "a.mf4", "a.trc", "a.trc.zst", "b -f blf", "c.asc -f mf4"] {
        let output = gripd_in(path, &format!("convert a.log -o {name}"));
        assert!(output.status.success(), "{name}: {}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("WARN"), "{}", text(&output.stderr));
        let output = gripd_in(path, &format!("convert {} -o -", name.split(' ').next().unwrap()));
        assert_eq!(text(&output.stdout), log, "{name}");
    }
    // What is lost is said, and no result is half there.
    let output = gripd_in(path, "convert a.log -f csv -o -");
    let told = text(&output.stderr);
    assert!(text(&output.stdout).starts_with("timestamp,arbitration_id,extended,remote,error,dlc,data\n"));
    assert!(told.contains("1 of 3 frames written without its interface"), "{told}");
    assert!(told.contains("1 of 3 frames written without the marks of an FD frame"), "{told}");
    for (arguments, word) in
        [("-o x.blf.gz", "plain file"), ("-f mf4 -o -", "plain file"), ("-f xyz -o x", "xyz")]
    {
        let output = gripd_in(path, &format!("convert a.log {arguments}"));
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        assert!(text(&output.stderr).contains(word), "{}", text(&output.stderr));
        assert!(!path.join("x.blf.gz").exists() && !path.join("x").exists());
    }
}

#[test]
fn what_was_skipped_is_counted_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(
        path.join("a.asc"),
        "base hex timestamps absolute\n 0.1 1 100 Rx d 1 00\n 0.2 1 100 Rx d 2 00\n 0.3 1 900 Rx d 0\n 0.4 1 100 Rx d 1\n",
    )
    .unwrap();
    let output = gripd_in(path, "convert a.asc -o a.log");
    let told = text(&output.stderr);
    assert!(output.status.success(), "{told}");
    assert!(told.contains("1 frames") && told.contains("3 lines skipped"), "{told}");
    assert!(told.contains("a.asc:3: ") && told.contains("2 × the data are not as many bytes"), "{told}");
    assert_eq!(fs::read_to_string(path.join("a.log")).unwrap(), "(0.100000) can0 100#00\n");
}

#[test]
fn a_cut_off_recording_is_converted_as_far_as_it_goes_and_fails() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let bytes = file(&[container(&classic(0, 1, &[1]), 2), container(&classic(1, 1, &[2]), 2)]);
    fs::write(path.join("a.blf"), &bytes[..bytes.len() - 10]).unwrap();
    let output = gripd_in(path, "convert a.blf -o a.log");
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("cut off"), "{}", text(&output.stderr));
    assert!(fs::read_to_string(path.join("a.log")).unwrap().starts_with("(1760000000.000000) can1 001#01\n"));
}

#[test]
fn wrong_use_is_told_from_wrong_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("a.zip"), b"PK\x03\x04zip").unwrap();
    fs::write(path.join("a.asc"), "date x\nnothing\n").unwrap();
    for (arguments, code, word) in [
        ("convert a.asc -o a.asc", 2, "another name"),
        ("convert a.asc -o b -i not/an/interface", 2, "interface"),
        ("convert missing.blf -o b", 1, "missing.blf"),
        ("convert a.zip -o b", 1, "zip"),
        ("convert a.asc -o b", 1, "Vector ASC"),
    ] {
        let output = gripd_in(path, arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {}", text(&output.stderr));
        assert!(text(&output.stderr).contains(word), "{arguments}: {}", text(&output.stderr));
    }
}
