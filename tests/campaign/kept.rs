//! Answers that take long are kept, so that what was interrupted goes on.

use std::path::{Path, PathBuf};

use serde_json::Value;
use testing::program::target;

/// The folder that an environment variable names, or else one of this name below `target`.
pub fn folder(variable: &str, name: &str) -> PathBuf {
    let folder = std::env::var_os(variable).map_or_else(|| target(name), PathBuf::from);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// What a file has kept, or else what the answer is now, which it keeps.
pub fn answer(file: &Path, ask: impl FnOnce() -> Value) -> Value {
    read(file).unwrap_or_else(|| {
        let answer = ask();
        // Another one may ask the same at the same time.
        let aside = file.with_extension(format!("{:?}", std::thread::current().id()));
        std::fs::write(&aside, answer.to_string()).unwrap();
        std::fs::rename(aside, file).unwrap();
        answer
    })
}

/// The file of an answer to these words.
pub fn file(folder: &Path, words: &str, ending: &str) -> PathBuf {
    let plain = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
    folder.join(format!("{}.{ending}", words.trim().chars().map(plain).collect::<String>()))
}

/// JSON of a file, if there is some.
pub fn read(file: &Path) -> Option<Value> {
    serde_json::from_slice(&std::fs::read(file).ok()?).ok()
}

/// Why a command did not do it, without the recording's name.
pub fn reason(told: &str) -> String {
    let of = |ending: &str| told.rsplit_once(ending).map(|(_, why)| why);
    of(".log.gz: ").or_else(|| of(".log: ")).unwrap_or(told).trim().to_owned()
}
