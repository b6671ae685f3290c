//! Answers that take long are kept, so that what was interrupted goes on.

use std::path::{Path, PathBuf};

/// The file of an answer to these words.
pub fn file(folder: &Path, words: &str, ending: &str) -> PathBuf {
    let plain = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
    folder.join(format!("{}.{ending}", words.trim().chars().map(plain).collect::<String>()))
}

/// Why a command did not do it, without the recording's name.
pub fn reason(told: &str) -> String {
    told.rsplit_once(".log.gz: ").map_or(told, |(_, why)| why).trim().to_owned()
}
