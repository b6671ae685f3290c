//! ASAM MF4.

use std::fs;

use super::mf4_file::{MEMBERS, Mf4, head, unsorted};
use super::*;

fn open(bytes: &[u8]) -> Result<Reader, LogError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mf4");
    fs::write(&path, bytes).unwrap();
    Reader::open(&path)
}

fn read(bytes: &[u8]) -> Read {
    drain(open(bytes).unwrap())
}

fn frames(count: u64) -> Vec<(u64, u32, Vec<u8>)> {
    (0..count)
        .map(|n| (1000 * n, 0x7F0 + n as u32 % 32, vec![n as u8; [0, 3, 8, 12, 64][n as usize % 5]]))
        .collect()
}

fn lines(frames: &[(u64, u32, Vec<u8>)]) -> Vec<String> {
    let line = |(us, id, data): &(u64, u32, Vec<u8>)| {
        let time = Micros(1_760_000_000_000_000 + *us as i64);
        let hex: String = data.iter().map(|byte| format!("{byte:02X}")).collect();
        let id = if *id > 0x7FF { format!("{id:08X}") } else { format!("{id:03X}") };
        let fd = if data.len() > 8 { "#4" } else { "" };
        format!("({time}) can1 {id}#{fd}{hex}")
    };
    frames.iter().map(line).collect()
}

/// As loggers write them: data before or behind their records.
#[test]
fn unfinished_and_unsorted() {
    let frames = frames(5000);
    for data_first in [false, true] {
        let read = read(&unsorted(&frames, data_first));
        assert_eq!((read.format, read.stats.skipped_lines), (Format::Mf4, 0), "{:?}", read.stats);
        assert_eq!(read.lines, lines(&frames));
        assert!(read.error.is_none(), "{:?}", read.error);
    }
}

/// Records of 15 bytes and data, in blocks of their own through lists.
fn sorted(frames: &[(u64, u32, Vec<u8>)], compressed: bool, transposed: bool) -> Vec<u8> {
    let mut file = Mf4::new(b"MDF     ");
    let (mut records, mut signal) = (Vec::new(), Vec::new());
    for (us, id, data) in frames {
        records.extend(head(*us, 1, *id, data.len() as u8, data.len() > 8));
        records.extend((signal.len() as u64).to_le_bytes());
        signal.extend((data.len() as u32).to_le_bytes());
        signal.extend(data);
    }
    // Cut anywhere.
    let signal: Vec<u64> = signal.chunks(1001).map(|piece| file.block(b"SD", &[], piece)).collect();
    let signal = file.list(&signal);
    let mut blocks = Vec::new();
    for piece in records.chunks(2222) {
        blocks.push(match (compressed, transposed) {
            (true, transposed) => file.compressed(b"DT", piece, if transposed { 23 } else { 0 }),
            _ => file.block(b"DT", &[], piece),
        });
    }
    let blocks = file.list(&blocks);
    let mut members = MEMBERS.to_vec();
    members.push(("DataBytes", 1, 10, 15, 0, 64, signal));
    let channels = file.frame_channels("CAN_DataFrame", &members);
    let group = file.group(0, channels, 0, 2, 23);
    file.data_group(group, blocks, 0);
    file.bytes
}

#[test]
fn sorted_in_pieces_compressed_or_not() {
    let frames = frames(2000);
    for (compressed, transposed) in [(false, false), (true, false), (true, true)] {
        let read = read(&sorted(&frames, compressed, transposed));
        assert_eq!(read.lines, lines(&frames), "{compressed} {transposed}");
        assert!(read.error.is_none() && read.stats.skipped_lines == 0);
    }
}

/// Data, remote and error frames are groups of their own.
#[test]
fn groups_are_given_out_by_time() {
    let mut file = Mf4::new(b"MDF     ");
    let mut of_kind = |name: &str, times: &[u64], length: u8, with_data: bool| {
        let mut members = MEMBERS.to_vec();
        if with_data {
            members.push(("DataBytes", 0, 10, 15, 0, 64, 0));
        }
        let size = if with_data { 23 } else { 15 };
        let mut records = Vec::new();
        for us in times {
            records.extend(head(*us, 2, 0x123, length, false));
            records.extend(vec![0xAB; size - 15]);
        }
        let data = file.block(b"DT", &[], &records);
        let channels = file.frame_channels(name, &members);
        let group = file.group(0, channels, 0, 2, size as u32);
        file.data_group(group, data, 0);
    };
    of_kind("CAN_DataFrame", &[1, 4, 5], 8, true);
    of_kind("CAN_RemoteFrame", &[2, 6], 4, false);
    of_kind("CAN_ErrorFrame", &[3], 0, false);
    of_kind("LIN_Frame", &[0, 9], 0, false);
    let read = read(&file.bytes);
    let ends: Vec<&str> = read.lines.iter().map(|line| &line[line.find("can2").unwrap()..]).collect();
    let (data, remote) = ("can2 123#ABABABABABABABAB", "can2 123#R4");
    assert_eq!(ends, [data, remote, "can2 20000080#", data, data, remote]);
    assert_eq!(read.stats.time_backwards, 0);
}

#[test]
fn what_is_cut_off_gives_what_is_whole() {
    let frames = frames(300);
    let expected = lines(&frames);
    let unfinished = unsorted(&frames, false);
    let sorted = sorted(&frames, false, false);
    for end in (64..unfinished.len()).step_by(11) {
        if let Ok(reader) = open(&unfinished[..end]) {
            let cut = drain(reader);
            assert!(expected.starts_with(&cut.lines), "{end}: {:?}", cut.lines.last());
        }
    }
    // The channels stand at the end of this one: without them nothing can be known.
    for end in (0..sorted.len() - 8).step_by(501) {
        let name = match open(&sorted[..end]) {
            Err(error) => error.to_string(),
            Ok(reader) => drain(reader).error.expect("it is cut off").to_string(),
        };
        assert!(!name.is_empty());
    }
    // A block that the file ends in.
    let mut file = Mf4::new(b"MDF     ");
    let mut members = MEMBERS.to_vec();
    members.push(("DataBytes", 0, 10, 15, 0, 64, 0));
    let channels = file.frame_channels("CAN_DataFrame", &members);
    let group = file.group(0, channels, 0, 2, 23);
    let at = file.bytes.len() as u64 + 64;
    file.data_group(group, at, 0);
    let records: Vec<u8> =
        (0..10).flat_map(|n| [head(n, 1, 1, 8, false), vec![n as u8; 8]].concat()).collect();
    assert_eq!(file.block(b"DT", &[], &records), at);
    let cut = read(&file.bytes[..file.bytes.len() - 30]);
    assert_eq!(cut.lines.len(), 8);
    assert!(matches!(cut.error, Some(LogError::CutOff { .. })), "{:?}", cut.error);
}

#[test]
fn data_that_are_missing_cost_their_frame() {
    let frames = frames(10);
    let mut bytes = unsorted(&frames, false);
    // The last record's data: 64 bytes, their length and the record's number.
    let end = bytes.len() - 69;
    bytes.truncate(end);
    let read = read(&bytes);
    assert_eq!(read.lines, lines(&frames[..9]));
    assert_eq!(damage(&read), Damage::NoData);
}

#[test]
fn what_cannot_be_read_is_said() {
    for (bytes, word) in [
        (b"MDF     3.30    ".to_vec(), "cut off"),
        ([b"MDF     3.30    ".to_vec(), vec![0; 200]].concat(), "another version"),
        (Mf4::new(b"MDF     ").bytes, "without CAN frames"),
        ([b"MDF     4.10    ".to_vec(), vec![0; 200]].concat(), "byte 64: there is no block"),
    ] {
        let Err(error) = open(&bytes) else { panic!("{word} was taken") };
        assert!(error.to_string().contains(word), "{error}");
    }
    let bytes = unsorted(&frames(3), true);
    let Err(error) = Reader::from_read(Box::new(Cursor::new(bytes.clone())), "standard input") else {
        panic!()
    };
    assert!(matches!(error, LogError::NeedsFile { .. }), "{error}");
    let packed = zstd::encode_all(bytes.as_slice(), 3).unwrap();
    let Err(error) = Reader::from_read(Box::new(Cursor::new(packed)), "x.mf4.zst") else { panic!() };
    assert!(error.to_string().contains("unpack it"), "{error}");
}
