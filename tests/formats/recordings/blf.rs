//! Vector BLF.

use super::blf_file::{classic, container, file, object};
use super::*;

fn line(second: u64, id: u32, data: &str) -> String {
    format!("(176000000{second}.000000) can1 {id:03X}#{data}")
}

const SECOND: u64 = 1_000_000_000;

#[test]
fn objects_may_lie_across_containers_compressed_or_not() {
    let objects: Vec<u8> =
        (0..9).flat_map(|n| classic(n * SECOND, 0x100 + n as u32, &[n as u8; 8])).collect();
    let expected: Vec<_> = (0..9).map(|n| line(n, 0x100 + n as u32, &format!("{n:02X}").repeat(8))).collect();
    for method in [0, 2] {
        // Pieces of 37 bytes: smaller than an object.
        let containers: Vec<_> = objects.chunks(37).map(|piece| container(piece, method)).collect();
        let read = read(file(&containers));
        assert_eq!((read.format, read.stats.skipped_lines), (Format::Blf, 0));
        assert_eq!(read.lines, expected);
        assert!(read.error.is_none());
    }
    // Without any container.
    assert_eq!(read(file(&[objects])).lines, expected);
}

#[test]
fn every_type_of_frame() {
    let mut fd = vec![1, 0, 0, 9];
    fd.extend(0x123_u32.to_le_bytes());
    fd.extend([0, 0, 0, 0, 0, 0b011, 12, 0, 0, 0, 0, 0]);
    fd.extend(1..=12);
    fd.resize(84, 0);
    let mut fd_64 = vec![3, 15, 64, 0];
    fd_64.extend((0x18FE_F100_u32 | 1 << 31).to_le_bytes());
    fd_64.extend([0; 4]);
    fd_64.extend(0x5000_u32.to_le_bytes());
    fd_64.resize(40, 0);
    // Zeros at the end are not in the file.
    fd_64.extend([7; 8]);
    let mut remote = vec![1, 0, 0x80, 4];
    remote.extend(0x321_u32.to_le_bytes());
    remote.resize(16, 0);
    let text = object(65, 0, b"a comment");
    let mut ten_micros = classic(2, 0x7FF, &[1]);
    ten_micros[16] = 1;
    let objects = [
        object(100, SECOND, &fd),
        object(101, SECOND + 1499, &fd_64),
        text,
        object(86, SECOND + 1500, &remote),
        object(73, SECOND, &[1; 32]),
        ten_micros,
    ];
    let read = read(file(&[container(&objects.concat(), 2)]));
    let long = "07".repeat(8) + &"00".repeat(56);
    assert_eq!(
        read.lines,
        [
            "(1760000001.000000) can0 123##50102030405060708090A0B0C".to_owned(),
            format!("(1760000001.000001) can2 18FEF100##6{long}"),
            "(1760000001.000002) can0 321#R4".to_owned(),
            "(1760000001.000000) can256 20000080#".to_owned(),
            "(1760000000.000020) can1 7FF#01".to_owned(),
        ]
    );
    assert_eq!((read.stats.others, read.stats.skipped_lines, read.stats.time_backwards), (1, 0, 2));
}

#[test]
fn damage_costs_what_is_damaged() {
    let whole = |n: u64| classic(n * SECOND, 1, &[n as u8]);
    // Bytes between objects.
    let bytes = [whole(0), vec![0xAB; 50], whole(1)].concat();
    let between = read(file(&[container(&bytes, 2)]));
    assert_eq!(damage(&between), Damage::NoObject);
    assert_eq!(between.lines, [line(0, 1, "00"), line(1, 1, "01")]);
    // An object too short for its type.
    let short = read(file(&[container(&[object(1, 0, &[1; 7]), whole(1)].concat(), 2)]));
    assert_eq!((damage(&short), short.lines.len()), (Damage::ShortObject, 1));
    // A time beyond any clock.
    let late = read(file(&[container(&[object(1, u64::MAX, &[0; 16]), whole(1)].concat(), 2)]));
    assert_eq!((late.lines.len(), late.stats.skipped_lines), (2, 0), "292 years are no damage");
    let mut late = object(1, u64::MAX, &[0; 16]);
    late[16] = 1;
    let late = read(file(&[container(&[late, whole(1)].concat(), 2)]));
    assert_eq!((damage(&late), late.lines.len()), (Damage::BadTime, 1));
    // An object that claims to go on beyond all others.
    let mut greedy = whole(0);
    greedy[8..12].copy_from_slice(&1_000_000_u32.to_le_bytes());
    let greedy = read(file(&[container(&[greedy, whole(1)].concat(), 2)]));
    assert_eq!((damage(&greedy), greedy.lines), (Damage::NoObject, vec![line(1, 1, "01")]));
    // A container whose data are broken, and one of unknown compression.
    let mut broken = container(&whole(0), 2);
    let length = broken.len();
    broken[40..length].fill(0x55);
    let unknown = container(&whole(0), 7);
    for bad in [broken, unknown] {
        let read = read(file(&[bad, container(&whole(1), 2)]));
        assert_eq!((damage(&read), read.lines), (Damage::BadContainer, vec![line(1, 1, "01")]));
    }
    // Bytes between containers.
    let lost = read(file(&[container(&whole(0), 2), vec![1; 100], container(&whole(1), 2)]));
    assert_eq!((damage(&lost), lost.lines.len()), (Damage::NoObject, 2));
}

#[test]
fn a_file_that_is_cut_off_gives_what_is_whole_and_says_so() {
    let containers: Vec<_> = (0..3)
        .map(|n| {
            let objects: Vec<u8> =
                (0..100).flat_map(|m| classic((100 * n + m) * 1000, 1, &[m as u8; 8])).collect();
            container(&objects, 2)
        })
        .collect();
    let bytes = file(&containers);
    let whole = read(bytes.clone());
    assert_eq!((whole.lines.len(), whole.error.is_none()), (300, true));
    for end in (144..bytes.len()).step_by(7) {
        let cut = read(bytes[..end].to_vec());
        assert!(whole.lines.starts_with(&cut.lines), "{end}");
        // At a border, and within the bytes of padding there, nothing shows that something is missing.
        let borders: Vec<usize> = (0..=3).map(|n| file(&containers[..n]).len()).collect();
        if borders.iter().all(|border| end.abs_diff(*border) > 3) {
            let error = cut.error.unwrap_or_else(|| panic!("{end} of {borders:?}"));
            assert!(error.to_string().contains("cut off"), "{error}");
        }
    }
    // Packed, the packing tells.
    let packed = zstd::encode_all(bytes.as_slice(), 3).unwrap();
    assert_eq!(read(packed).lines.len(), 300);
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
    std::io::Write::write_all(&mut encoder, &bytes).unwrap();
    let mut packed = encoder.finish().unwrap();
    packed.truncate(packed.len() / 2);
    let cut = drain(Reader::from_read(Box::new(Cursor::new(packed)), "x").unwrap());
    assert!(matches!(cut.error, Some(LogError::Truncated { .. })), "{:?}", cut.error);
}

#[test]
fn a_header_that_cannot_be_is_an_error() {
    for (bytes, word) in
        [(b"LOGG".to_vec(), "cut off"), ([b"LOGG".to_vec(), vec![0; 140]].concat(), "byte 4")]
    {
        let Err(error) = Reader::from_read(Box::new(Cursor::new(bytes)), "x.blf") else {
            panic!("was taken")
        };
        assert!(error.to_string().starts_with("x.blf: ") && error.to_string().contains(word), "{error}");
    }
}

/// What a container unpacks to is bounded.
#[test]
fn a_bomb_is_damage() {
    let bomb = container(&vec![0; 1 << 27], 2);
    let read = read(file(&[bomb, container(&classic(0, 1, &[1]), 2)]));
    assert_eq!(read.lines, [line(0, 1, "01")]);
    assert!(read.stats.reasons.iter().any(|(reason, _)| *reason == Damage::BadContainer), "{:?}", read.stats);
}
