//! The file that what was learned is kept in.

use flate2::Crc;
use gripd::service::saved::{parse, text};

/// What is taken is what a car can be, and is written again as it was.
pub fn check(file: &[u8]) {
    match parse(file, "car") {
        Ok(learned) => {
            assert_eq!(learned.problem(), None);
            let again = text(&learned, "car").unwrap();
            assert_eq!(parse(again.as_bytes(), "car").unwrap(), learned);
        }
        Err(refusal) => assert!(!refusal.to_string().is_empty()),
    }
}

/// With the checksum that the contents ask for: past the first door.
pub fn sealed(contents: &[u8]) -> Vec<u8> {
    let mut crc = Crc::new();
    crc.update(contents);
    [format!("checksum = \"{:08x}\"\n", crc.sum()).as_bytes(), contents].concat()
}
