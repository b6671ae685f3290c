//! Recordings of real cars, where they are at hand.

use super::*;

fn logs(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(logs(&path));
        } else if path.to_string_lossy().ends_with(".log.gz") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Reads a recording, writes it again, and compares every byte with what gzip unpacks.
fn comes_back_the_same(path: &Path) {
    let mut original = Vec::new();
    flate2::read::MultiGzDecoder::new(fs::File::open(path).unwrap()).read_to_end(&mut original).unwrap();
    let mut reader = Reader::open(path).unwrap();
    let mut written = Vec::with_capacity(original.len());
    while let Some(frame) = reader.next_frame().unwrap() {
        write_line(&mut written, reader.interface(), &frame);
    }
    let stats = reader.stats();
    assert_eq!(stats.skipped_lines, 0, "{}: {:?}", path.display(), stats.first_skipped);
    assert!(stats.frames > 100, "{}: {} frames", path.display(), stats.frames);
    assert!(original == written, "{} differs", path.display());
}

#[test]
fn every_recording_reads_without_loss_and_is_rewritten_byte_for_byte() {
    let Some(shared) = testing::shared("recordings") else { return };
    let recordings = logs(&shared);
    assert!(recordings.len() >= 3, "{recordings:?}");
    recordings.iter().for_each(|path| comes_back_the_same(path));
}

#[test]
fn so_do_some_of_the_trials() {
    let Some(shared) = testing::shared("trials") else { return };
    logs(&shared).iter().step_by(8).for_each(|path| comes_back_the_same(path));
}
