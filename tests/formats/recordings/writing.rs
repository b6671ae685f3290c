//! GIVEN frames of every kind WHEN they are written in a format and read again THEN they are the same, but for what is
//! counted as lost.

use std::fs;
use std::path::Path;

use gripd::can::recording::{Loss, Writer, Written};
use gripd::can::{CanId, Frame, FrameKind};
use proptest::prelude::*;

use super::*;

const FORMATS: [(&str, Format); 8] = [
    ("x.log", Format::Candump),
    ("x.asc", Format::Asc),
    ("x.asc.gz", Format::Asc),
    ("x.trc", Format::Trc),
    ("x.trc.zst", Format::Trc),
    ("x.csv", Format::Csv),
    ("x.blf", Format::Blf),
    ("x.mf4", Format::Mf4),
];

type Tagged = (String, Frame);

/// Writes them, and reads what is there then.
fn through(path: &Path, format: Format, frames: &[Tagged]) -> (Written, Vec<Tagged>) {
    let mut writer = Writer::create(path, format, "can0").unwrap();
    frames.iter().for_each(|(interface, frame)| writer.write_as(interface, frame).unwrap());
    let written = writer.finish().unwrap();
    let mut reader = Reader::open(path).unwrap();
    assert_eq!(reader.format(), format);
    let mut read = Vec::new();
    while let Some(frame) = reader.next_frame().unwrap() {
        read.push((reader.interface().to_owned(), frame));
    }
    assert_eq!(reader.stats().skipped_lines, 0, "{:?}", reader.stats());
    (written, read)
}

/// What the format has of the frames: the losses that it should count, and what should be read.
fn kept(format: Format, frames: &[Tagged]) -> (Vec<(Loss, u64)>, Vec<Tagged>) {
    let mut losses: Vec<(Loss, u64)> = Vec::new();
    let mut kept = frames.to_vec();
    if format == Format::Candump {
        return (losses, kept);
    }
    for (interface, frame) in &mut kept {
        let original = (interface.clone(), *frame);
        if frame.kind == FrameKind::Error {
            let class = CanId::extended(0x80).unwrap();
            *frame = Frame::new(frame.time, class, FrameKind::Error, &[]).unwrap();
        }
        if format == Format::Csv {
            *interface = "can0".into();
            if frame.is_fd() {
                let fd = FrameKind::Fd { bit_rate_switch: false, error_state: false };
                let kind = if frame.length() > 8 { fd } else { FrameKind::Data };
                *frame = Frame::new(frame.time, frame.id, kind, frame.data()).unwrap();
            }
        }
        // One reason for each frame.
        let loss = match frame {
            frame if *frame == original.1 => (*interface != original.0).then_some(Loss::Interface),
            frame if frame.kind == FrameKind::Error => Some(Loss::ErrorClass),
            _ => Some(Loss::FdMarks),
        };
        if let Some(loss) = loss {
            match losses.iter_mut().find(|(known, _)| *known == loss) {
                Some((_, count)) => *count += 1,
                None => losses.push((loss, 1)),
            }
        }
    }
    if format == Format::Mf4 {
        // Groups are read by time; of the same microsecond one kind after the other.
        let group = |kind: FrameKind| match kind {
            FrameKind::Data => 0,
            FrameKind::Fd { .. } => 1,
            FrameKind::Remote => 2,
            FrameKind::Error => 3,
        };
        kept.sort_by_key(|(_, frame)| (frame.time, group(frame.kind)));
    }
    (losses, kept)
}

fn frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        (0..=CanId::MAX_STANDARD).prop_map(|id| CanId::standard(id).unwrap()),
        (0..=CanId::MAX_EXTENDED).prop_map(|id| CanId::extended(id).unwrap()),
    ];
    let length =
        prop_oneof![4 => 0_usize..=8, 1 => prop::sample::select(vec![12_usize, 16, 20, 24, 32, 48, 64])];
    let bytes = prop::collection::vec(any::<u8>(), 64);
    (id, length, bytes, 0..8_u8, any::<[bool; 2]>()).prop_map(|(id, length, bytes, kind, marks)| {
        let [bit_rate_switch, error_state] = marks;
        let fd = FrameKind::Fd { bit_rate_switch, error_state };
        let time = Micros(0);
        match kind {
            _ if length > 8 => Frame::new(time, id, fd, &bytes[..length]),
            0 => Frame::new(time, id, fd, &bytes[..length]),
            1 => Frame::remote(time, id, length),
            2 => {
                let class = CanId::extended(id.number()).unwrap();
                Frame::new(time, class, FrameKind::Error, &bytes[..length])
            }
            3 => Frame::new(time, CanId::extended(0x80).unwrap(), FrameKind::Error, &[]),
            _ => Frame::new(time, id, FrameKind::Data, &bytes[..length]),
        }
        .unwrap()
    })
}

/// From a start on, in order, each so many microseconds after the one before.
fn frames() -> impl Strategy<Value = Vec<Tagged>> {
    let start = prop_oneof![0..100_000_000_i64, 1_600_000_000_000_000..1_900_000_000_000_000_i64];
    let step = prop_oneof![3 => 0..2000_i64, 1 => 0..3_600_000_000_i64];
    let rest = prop::collection::vec((frame(), step, 0..4_usize), 1..60);
    (start, rest).prop_map(|(mut time, rest)| {
        let tag = |(mut frame, step, interface): (Frame, i64, usize)| {
            time += step;
            frame.time = Micros(time);
            (["can0", "can0", "can1", "can12"][interface].to_owned(), frame)
        };
        rest.into_iter().map(tag).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn what_is_written_is_read(frames in frames()) {
        let folder = tempfile::tempdir().unwrap();
        for (name, format) in FORMATS {
            let (losses, kept) = kept(format, &frames);
            let (written, read) = through(&folder.path().join(name), format, &frames);
            prop_assert_eq!(&written.losses, &losses, "{}", name);
            prop_assert_eq!((written.frames, written.renamed), (frames.len() as u64, Vec::new()));
            prop_assert_eq!(&read, &kept, "{}", name);
        }
    }
}

fn data(time: i64, byte: u8) -> Frame {
    Frame::data_frame(Micros(time), CanId::standard(0x123).unwrap(), &[byte; 8]).unwrap()
}

/// Enough for many containers and blocks.
#[test]
fn long_recordings_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let frames: Vec<Tagged> = (0..100_000)
        .map(|n| (format!("can{}", n % 3), data(1_760_000_000_000_000 + 211 * n, (n * n) as u8)))
        .collect();
    for (name, format) in FORMATS {
        let (written, read) = through(&folder.path().join(name), format, &frames);
        assert_eq!(written.left_out(), 0);
        assert!(format == Format::Csv || read == frames, "{name}");
        assert_eq!(read.len(), frames.len());
    }
}

#[test]
fn recordings_without_frames_are_recordings() {
    let folder = tempfile::tempdir().unwrap();
    for (name, format) in FORMATS.into_iter().filter(|(_, format)| *format != Format::Candump) {
        let (written, read) = through(&folder.path().join(name), format, &[]);
        assert_eq!((written, read.len()), (Written::default(), 0), "{name}");
    }
}

#[test]
fn what_does_not_fit_is_counted_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let second = 1_000_000;
    let tag = |name: &str, frame| (name.to_owned(), frame);
    let frames = [
        tag("vcan0", data(-second, 0)),
        tag("vcan0", data(10 * second, 1)),
        // Others came a little late, or much too late.
        tag("can0", data(10 * second - 499_000, 2)),
        tag("can0", data(8 * second, 3)),
        tag("can0", data(i64::MAX / 2, 4)),
    ];
    // (Those without a start take any time.)
    for (name, format) in FORMATS.into_iter().filter(|(_, f)| !matches!(f, Format::Candump | Format::Csv)) {
        let (written, read) = through(&folder.path().join(name), format, &frames);
        let bytes: Vec<u8> = read.iter().map(|(_, frame)| frame.data()[0]).collect();
        let expected: (&[(Loss, u64)], &[u8]) = match format {
            // Its clock has a sign.
            Format::Mf4 => (&[(Loss::NoDate, 2)], &[1, 2, 3]),
            _ => (&[(Loss::NoDate, 2), (Loss::BeforeStart, 1)], &[1, 2]),
        };
        assert_eq!((written.losses.as_slice(), bytes.as_slice()), expected, "{name}");
        let renamed = [("vcan0", "can0"), ("can0", "can1")].map(|(a, b)| (a.to_owned(), b.to_owned()));
        assert_eq!(written.renamed, renamed, "{name}");
        assert_eq!(written.left_out(), 5 - bytes.len() as u64);
    }
    let frames: Vec<Tagged> = (0..300).map(|n| (format!("bus{n}"), data(n, n as u8))).collect();
    let (written, read) = through(&folder.path().join("x.blf"), Format::Blf, &frames);
    assert_eq!((written.losses, read.len()), (vec![(Loss::ManyInterfaces, 45)], 255));
}

#[test]
fn what_is_not_finished_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    for (name, format) in FORMATS {
        let path = folder.path().join(name);
        fs::write(&path, "old").unwrap();
        let mut writer = Writer::create(&path, format, "can0").unwrap();
        (0..50_000).for_each(|n| writer.write(&data(n, n as u8)).unwrap());
        drop(writer);
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), FORMATS.len());
}

/// `/dev/full` takes nothing, as a full disk does.
#[test]
fn a_full_disk_is_an_error_with_its_name() {
    for (_, format) in FORMATS {
        let path = Path::new("/dev/full");
        let write = || {
            let mut writer = Writer::create(path, format, "can0")?;
            for n in 0..200_000 {
                writer.write(&data(n, ((n * n) >> 3) as u8))?;
            }
            writer.finish()
        };
        let error = write().unwrap_err().to_string();
        assert!(error.starts_with("/dev/full: cannot be written: "), "{error}");
    }
}

#[test]
fn binary_formats_go_to_plain_files_only() {
    for (name, format) in [("-", Format::Blf), ("x.mf4.gz", Format::Mf4), ("x.blf.zst", Format::Blf)] {
        let error = Writer::create(Path::new(name), format, "can0").err().unwrap();
        assert!(matches!(error, LogError::NotAStream { .. }), "{error}");
        assert!(!Path::new(name).exists());
    }
}
