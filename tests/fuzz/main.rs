//! Feeds one of gripd's readers what libFuzzer makes up, guided by what the inputs before reached. `run.sh` builds and starts it.

#![no_main]

use std::env;
use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use testing::hostile::{READERS, Reader};

/// Which of the readers: libFuzzer has the command line.
const READER: &str = "GRIPD_FUZZ_READER";

fn reader() -> Reader {
    let name = env::var(READER).unwrap_or_default();
    let of_name = READERS.iter().find(|(of, _)| *of == name);
    let names = READERS.map(|(name, _)| name).join(", ");
    of_name.unwrap_or_else(|| panic!("{READER}=`{name}` is none of {names}")).1
}

fuzz_target!(|data: &[u8]| {
    static ASKED: OnceLock<Reader> = OnceLock::new();
    ASKED.get_or_init(reader)(data);
});
