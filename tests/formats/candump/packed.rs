//! gzip and zstd, whole, cut off and corrupt.

use super::*;

fn text() -> String {
    (0..20_000).map(|n| format!("({}.{:06}) can0 123#{n:08X}\n", 1000 + n / 100, n % 100)).collect()
}

fn gzip(text: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(text).unwrap();
    encoder.finish().unwrap()
}

/// Reads to the end or to the error.
fn drain(bytes: Vec<u8>) -> (usize, Compression, Option<LogError>) {
    let mut reader = Reader::from_read(Box::new(Cursor::new(bytes)), "drive.log.gz").unwrap();
    let mut count = 0;
    loop {
        match reader.next_frame() {
            Ok(Some(_)) => count += 1,
            Ok(None) => return (count, reader.compression(), None),
            Err(error) => {
                assert!(matches!(reader.next_frame(), Ok(None)), "the error comes once");
                return (count, reader.compression(), Some(error));
            }
        }
    }
}

#[test]
fn gzip_of_several_members_and_zstd_of_several_frames() {
    let (first, second) = ("(1.0) can0 123#00\n", "(2.0) can0 123#01\n");
    let members = [gzip(first.as_bytes()), gzip(second.as_bytes())].concat();
    assert!(matches!(drain(members), (2, Compression::Gzip, None)));
    let pack = |text: &str| zstd::encode_all(text.as_bytes(), 3).unwrap();
    assert!(matches!(drain([pack(first), pack(second)].concat()), (2, Compression::Zstd, None)));
}

#[test]
fn what_is_cut_off_is_read_as_far_as_it_goes() {
    let text = text();
    let zstd = zstd::encode_all(text.as_bytes(), 3).unwrap();
    for (packed, name) in [(gzip(text.as_bytes()), "gzip"), (zstd, "zstd")] {
        let (count, _, error) = drain(packed[..packed.len() / 2].to_vec());
        let error = error.expect("the end is missing");
        assert!(
            matches!(error, LogError::Truncated { line, .. } if line == count as u64),
            "{error} ({count})"
        );
        assert!(count < 20_000);
        assert!(name == "zstd" || count > 5_000, "{name}: only {count} frames of half a file");
        assert!(error.to_string().contains(name) && error.to_string().contains("cut off"), "{error}");
    }
}

#[test]
fn corrupt_data_are_no_truncation() {
    let mut packed = gzip(text().as_bytes());
    let middle = packed.len() / 2;
    packed[middle..middle + 64].fill(0xFF);
    let (_, _, error) = drain(packed);
    assert!(matches!(error, Some(LogError::Corrupt { .. })), "{error:?}");
    let trailing = [gzip(b"(1.0) can0 123#00\n"), b"garbage behind it".to_vec()].concat();
    let (count, _, error) = drain(trailing);
    assert_eq!(count, 1);
    assert!(matches!(error, Some(LogError::Corrupt { .. })), "{error:?}");
}
