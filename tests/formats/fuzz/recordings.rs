//! Recordings beyond candump: every format, under mutations that know some of its words.

use testing::hostile::recording::{check, read};

use super::mutate::Mutator;
use super::run::{corpus, fuzz, known};

/// Mutations of the corpus's files with that extension.
fn run(name: &str, extension: &str, words: &[&str], times: u64) {
    let files = corpus("recordings").into_iter().filter(|(name, _)| name.ends_with(extension));
    let seeds: Vec<Vec<u8>> = files.map(|(_, bytes)| bytes).collect();
    assert!(!seeds.is_empty());
    let mutator = Mutator { seeds: &seeds, words, longest: 20_000 };
    fuzz(name, times, |dice| mutator.make(dice), |bytes| check(bytes));
}

#[test]
fn recordings_as_they_are() {
    known("recordings", |bytes| {
        let (frames, stats) = read(bytes).unwrap();
        assert!(frames.len() >= 3 && stats.skipped_lines == 0, "{stats:?}");
        check(bytes);
    });
}

#[test]
fn asc() {
    let words = [
        "date ",
        "base dec",
        "relative",
        "CANFD ",
        " Rx ",
        " d 8 ",
        "ErrorFrame",
        "x ",
        "Begin Triggerblock ",
        "\r\n",
    ];
    run("asc", ".asc", &words, 2000);
}

#[test]
fn trc() {
    let words =
        [";$FILEVERSION=", ";$STARTTIME=", ";$COLUMNS=", "N,O,T,B,I,d,R,L,D", " DT ", " RTR", " FB ", "Rx"];
    run("trc", ".trc", &words, 2000);
}

#[test]
fn csv() {
    run("csv", ".csv", &["timestamp,arbitration_id,", "0x", "==", ",1,", "e-05", ",,"], 2000);
}

#[test]
fn blf() {
    run("blf", ".blf", &["LOBJ", "LOGG", "\0\0\0\0", "\u{7F}\u{7F}", "LOBJ\u{20}\0\u{1}\0"], 4000);
}

#[test]
fn mf4() {
    run(
        "mf4",
        ".mf4",
        &["##DG", "##CG", "##CN", "##DT", "##DZ", "##DL", "##HL", "\0\0\0\0\0\0\0\0", "CAN_DataFrame"],
        4000,
    );
}
