//! Reading and writing candump logs: the whole grammar, damaged and endless input, packing.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "helpers of tests may fail loudly"
)]

use std::fs;
use std::io::{self, Cursor, Read, Write};
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use gripd::Micros;
use gripd::can::candump::{Compression, Damage, LogError, LogStats, Reader, Writer, write_line};
use gripd::can::{CanId, Frame, FrameKind};
use proptest::prelude::*;

fn read(text: impl Into<Vec<u8>>) -> (Vec<Frame>, LogStats) {
    let mut reader = Reader::from_read(Box::new(Cursor::new(text.into())), "test").unwrap();
    let mut frames = Vec::new();
    while let Some(frame) = reader.next_frame().unwrap() {
        frames.push(frame);
    }
    (frames, reader.stats().clone())
}

/// The only frame of a line.
#[track_caller]
fn one(line: &str) -> Frame {
    let (frames, stats) = read(line);
    assert_eq!(frames.len(), 1, "{line}: {stats:?}");
    frames[0]
}

#[track_caller]
fn damage(line: &str) -> Damage {
    let (frames, stats) = read(line);
    assert!(frames.is_empty(), "{line}: {frames:?}");
    assert_eq!(stats.skipped_lines, 1, "{line}");
    stats.first_skipped[0].reason
}

fn standard(number: u32) -> CanId {
    CanId::standard(number).unwrap()
}

fn extended(number: u32) -> CanId {
    CanId::extended(number).unwrap()
}

fn fd(bit_rate_switch: bool, error_state: bool) -> FrameKind {
    FrameKind::Fd { bit_rate_switch, error_state }
}

mod grammar {
    use super::*;

    #[test]
    fn classic_frames() {
        let time = Micros(1_760_000_000_000_584);
        let data = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88];
        let expected = Frame::data_frame(time, standard(0x123), &data).unwrap();
        assert_eq!(one("(1760000000.000584) can0 123#1122334455667788"), expected);
        assert_eq!(one("(1760000000.000584) can0 123#11.22.33.44.55.66.77.88"), expected);
        assert_eq!(one("(1760000000.000584) can0 123#11.2233.44556677.88"), expected);
        assert_eq!(one("(1760000000.000584) can0 123#1122334455667788_C"), expected, "raw length code");
        assert_eq!(one("(1.0) can0 7ff#").data(), &[] as &[u8]);
        assert_eq!(one("(1.0) can0 00a#aBcD").data(), [0xAB, 0xCD]);
    }

    #[test]
    fn a_number_of_eight_digits_is_extended_even_if_small() {
        assert_eq!(one("(1.0) can0 00000123#00").id, extended(0x123));
        assert_eq!(one("(1.0) can0 1FFFFFFF#00").id, extended(0x1FFF_FFFF));
        assert_eq!(one("(1.0) can0 98FEF100#00").id, extended(0x18FE_F100), "with the kernel's mark");
    }

    #[test]
    fn remote_requests() {
        for (line, length) in
            [("123#R", 0), ("123#R0", 0), ("123#r8", 8), ("123#R8_F", 8), ("00000123#R5", 5)]
        {
            let frame = one(&format!("(1.0) can0 {line}"));
            assert_eq!((frame.kind, frame.length()), (FrameKind::Remote, length), "{line}");
        }
    }

    #[test]
    fn fd_frames_with_their_flags() {
        assert_eq!(one("(1.0) can0 123##0112233").kind, fd(false, false));
        assert_eq!(one("(1.0) can0 123##1112233").kind, fd(true, false));
        assert_eq!(one("(1.0) can0 123##2112233").kind, fd(false, true));
        assert_eq!(one("(1.0) can0 123##7112233").kind, fd(true, true), "4 is candump's own");
        assert_eq!(one("(1.0) can0 123##F").data(), &[] as &[u8]);
        for data in ["AB".repeat(64), ".AB".repeat(64)] {
            assert_eq!(one(&format!("(1.0) can0 12345678##5{data}")).data(), [0xAB; 64], "{data}");
        }
    }

    #[test]
    fn error_frames() {
        let frame = one("(1.0) can0 20000204#0008000000006000");
        assert_eq!((frame.kind, frame.id.number()), (FrameKind::Error, 0x204));
        assert_eq!(frame.data(), [0, 8, 0, 0, 0, 0, 0x60, 0]);
    }

    #[test]
    fn xl_frames_are_counted_but_not_delivered() {
        let (frames, stats) = read(
            "(1.0) can0 123#81:00:12345678#11223344.556677\n\
             (1.0) can0 45123#81:00:12345678#11223344\n\
             (2.0) can0 123#00\n",
        );
        assert_eq!((frames.len(), stats.xl_frames, stats.skipped_lines), (1, 2, 0));
    }

    #[test]
    fn stamps_of_any_precision_are_cut_to_microseconds() {
        for (stamp, micros) in [
            ("12.345678", 12_345_678),
            ("12.345678999", 12_345_678),
            ("12.3", 12_300_000),
            ("12.3456789", 12_345_678),
            ("12", 12_000_000),
            ("0.000000", 0),
            ("0000000012.345678", 12_345_678),
            ("12.345678901234567", 12_345_678),
            ("-0.000001", -1),
        ] {
            assert_eq!(one(&format!("({stamp}) can0 123#00")).time, Micros(micros), "{stamp}");
        }
    }

    #[test]
    fn direction_suffix_and_padded_interface_names() {
        assert_eq!(one("(1.0) can0 123#0011 R").data(), [0, 0x11]);
        assert_eq!(one("(1.0) can0 123#0011 T\r\n").data(), [0, 0x11]);
        let mut reader =
            Reader::from_read(Box::new(&b"(1.0)   can0 123#00\n(2.0) vcan10 124#00"[..]), "test").unwrap();
        assert!(reader.next_frame().unwrap().is_some());
        assert_eq!(reader.interface(), "can0");
        assert!(reader.next_frame().unwrap().is_some(), "the last newline may be missing");
        assert_eq!(reader.interface(), "vcan10");
        assert_eq!(reader.next_frame().unwrap(), None);
        assert_eq!(reader.interface(), "vcan10");
    }

    #[test]
    fn lines_that_are_no_frames() {
        let (frames, stats) = read(
            "\u{feff}# a comment\r\n\n   \n; another\n(1.0) can0 123#00\r\n\
             DROPCOUNT: dropped 17 CAN frames on 'can0' socket (total drops 17)\n\
             DROPCOUNT: dropped 1 CAN frame on 'can0' socket (total drops 18)\n(2.0) can0 123#00\n",
        );
        assert_eq!((frames.len(), stats.lines, stats.blank_lines, stats.dropped), (2, 8, 4, 18));
        assert_eq!(stats.skipped_lines, 0);
        assert_eq!(stats.seconds(), 1.0);
    }

    #[test]
    fn damaged_lines_say_what_is_wrong() {
        for (line, reason) in [
            ("  can0  123   [8]  11 22 33 44 55 66 77 88", Damage::NoStamp),
            ("(1.0)  can0  123   [2]  11 22", Damage::NoFrame),
            ("(2025-01-01 12:00:00.0) can0 123#00", Damage::BadStamp),
            ("(1.) can0 123#00", Damage::BadStamp),
            ("(1.0 can0 123#00", Damage::BadStamp),
            ("(1234567890123.0) can0 123#00", Damage::BadStamp),
            ("(1.0)", Damage::Incomplete),
            ("(1.0) can0", Damage::Incomplete),
            ("(1.0) can0 1234#00", Damage::BadId),
            ("(1.0) can0 12G#00", Damage::BadId),
            ("(1.0) can0 800#00", Damage::IdTooLarge),
            ("(1.0) can0 5FFFFFFF#00", Damage::IdTooLarge),
            ("(1.0) can0 123#0", Damage::BadData),
            ("(1.0) can0 123#0G", Damage::BadData),
            ("(1.0) can0 123#00..11", Damage::BadData),
            ("(1.0) can0 123#112233445566778899", Damage::TooLong),
            ("(1.0) can0 123##", Damage::BadFlags),
            ("(1.0) can0 123##G", Damage::BadFlags),
            ("(1.0) can0 123##0112233445566778899", Damage::NotAnFdLength),
            ("(1.0) can0 123#R9", Damage::BadRemote),
            ("(1.0) can0 123#Rx", Damage::BadRemote),
            ("(1.0) can0 123#00 X", Damage::Trailing),
            ("DROPCOUNT: dropped many CAN frames", Damage::BadDropCount),
        ] {
            assert_eq!(damage(line), reason, "{line}");
        }
        let (_, stats) = read(b"(1.0) \xFF\xFE 123#00\n".to_vec());
        assert_eq!(stats.first_skipped[0].reason, Damage::BadInterface);
        let text = damage("(1.0)  can0  123   [2]  11 22").to_string();
        assert!(text.contains("candump -L"), "{text}");
    }

    #[test]
    fn damaged_lines_are_counted_and_the_first_are_kept_with_their_numbers() {
        let text = "(1.0) can0 123#00\nnonsense\n".repeat(50);
        let (frames, stats) = read(text);
        assert_eq!((frames.len(), stats.lines, stats.skipped_lines), (50, 100, 50));
        assert_eq!(stats.first_skipped.len(), LogStats::KEPT);
        assert_eq!(stats.first_skipped[1].line, 4);
    }

    #[test]
    fn time_that_runs_backwards_is_noticed() {
        let (frames, stats) = read(
            "(5.0) can0 123#00\n(5.0) can0 123#00\n(4.9) can0 123#00\n(5.1) can0 123#00\n(5.0) can0 123#00\n",
        );
        assert_eq!((frames.len(), stats.time_backwards, stats.first_backwards), (5, 2, Some(3)));
    }
}

mod hard_input {
    use super::*;

    /// As many bytes as wanted without a newline, and without memory.
    fn endless(bytes: u64) -> impl Read + Send {
        io::repeat(b'7').take(bytes)
    }

    #[test]
    fn a_line_of_a_gigabyte_costs_no_memory_and_only_itself() {
        let text = Cursor::new("(1.0) can0 123#00\n")
            .chain(endless(1 << 30))
            .chain(Cursor::new("\n(2.0) can0 124#00\n"));
        let mut reader = Reader::from_read(Box::new(text), "test").unwrap();
        let mut ids = Vec::new();
        while let Some(frame) = reader.next_frame().unwrap() {
            ids.push(frame.id.number());
        }
        assert_eq!(ids, [0x123, 0x124]);
        let stats = reader.stats();
        assert_eq!((stats.lines, stats.skipped_lines), (3, 1));
        assert_eq!((stats.first_skipped[0].line, stats.first_skipped[0].reason), (2, Damage::LongLine));
    }

    #[test]
    fn an_endless_last_line_is_damaged_too() {
        let text = Cursor::new("(1.0) can0 123#00\n").chain(endless(1 << 20));
        let mut reader = Reader::from_read(Box::new(text), "test").unwrap();
        assert!(reader.next_frame().unwrap().is_some());
        assert_eq!(reader.next_frame().unwrap(), None);
        assert_eq!(reader.stats().first_skipped[0].reason, Damage::LongLine);
    }

    /// Hands out a byte at a time, as a slow pipe may.
    struct Trickle(Cursor<Vec<u8>>);
    impl Read for Trickle {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let count = buffer.len().min(1);
            self.0.read(&mut buffer[..count])
        }
    }

    #[test]
    fn frames_come_however_the_bytes_do() {
        let text = "(1.0) can0 123#0011\n\n(2.0) can0 12345678##1AABB\nbad\n(3.0) can0 123#R\n".repeat(20);
        let mut slow =
            Reader::from_read(Box::new(Trickle(Cursor::new(text.clone().into()))), "test").unwrap();
        let mut frames = Vec::new();
        while let Some(frame) = slow.next_frame().unwrap() {
            frames.push(frame);
        }
        assert_eq!((frames, slow.stats().clone()), read(text));
    }

    #[test]
    fn a_frame_is_delivered_before_more_is_read() {
        /// One line, and then whoever reads on would wait forever.
        struct Live(Option<&'static [u8]>);
        impl Read for Live {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                let line = self.0.take().expect("read on although a line was there");
                let count = line.len().min(buffer.len());
                buffer[..count].copy_from_slice(&line[..count]);
                self.0 = Some(&line[count..]).filter(|rest| !rest.is_empty());
                Ok(count)
            }
        }
        let mut reader = Reader::from_read(Box::new(Live(Some(b"(1.0) can0 123#00\n"))), "test").unwrap();
        assert!(reader.next_frame().unwrap().is_some());
    }

    #[test]
    fn a_source_that_fails_says_where() {
        struct Failing;
        impl Read for Failing {
            fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
                Err(io::Error::from_raw_os_error(5))
            }
        }
        let text = Cursor::new("(1.0) can0 123#00\n(2.0) can0 123#00\n(3.0) can0 123#0").chain(Failing);
        let mut reader = Reader::from_read(Box::new(text), "disk.log").unwrap();
        assert!(reader.next_frame().unwrap().is_some());
        assert!(reader.next_frame().unwrap().is_some());
        let error = reader.next_frame().unwrap_err();
        assert!(matches!(error, LogError::Read { line: 2, .. }), "{error}");
        assert!(error.to_string().starts_with("disk.log: "), "{error}");
        assert_eq!(reader.next_frame().unwrap(), None, "the error comes once");
    }

    #[test]
    fn what_is_no_log_at_all_is_refused_at_once() {
        for (bytes, word) in
            [(&b"LOGG\x90\0\0\0"[..], "BLF"), (b"MDF     4.10", "MDF"), (b"\xFF\xFE(\0", "UTF-16")]
        {
            let Err(error) = Reader::from_read(Box::new(bytes), "x") else { panic!("{word} was taken") };
            assert!(error.to_string().contains(word), "{error}");
        }
        let Err(error) = Reader::open(Path::new("no/such/file.log")) else { panic!() };
        assert!(error.to_string().contains("no/such/file.log"), "{error}");
        assert!(Reader::open(Path::new("/")).is_err(), "a folder");
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..4000)) {
            if let Ok(mut reader) = Reader::from_read(Box::new(Cursor::new(bytes)), "x") {
                while let Ok(Some(_)) = reader.next_frame() {}
            }
        }

        #[test]
        fn almost_frames_do_not_make_it_panic(text in r"(\([-0-9.]{0,20}\)? {0,2}[a-z0-9]{0,5} {0,2}[0-9A-F]{0,9}[#R:_.]{0,3}[0-9A-FGR_.:#]{0,140}( [TRX])?\n){0,5}") {
            let (frames, stats) = read(text);
            prop_assert_eq!(stats.lines, stats.frames + stats.skipped_lines + stats.blank_lines + stats.xl_frames);
            prop_assert_eq!(stats.frames, frames.len() as u64);
        }
    }
}

mod packed {
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
}

mod writing {
    use super::*;

    fn line_of(frame: &Frame) -> String {
        let mut text = Vec::new();
        write_line(&mut text, "can0", frame);
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn lines_are_those_of_candump() {
        for line in [
            "(1760000000.000584) can0 123#1122334455667788",
            "(46408.584930) can0 00A#",
            "(0.000000) can0 7FF#AB",
            "(9999999999.999999) can0 18FEF100#0011",
            "(1.000000) can0 123#R",
            "(1.000000) can0 12345678#R8",
            "(1.000000) can0 123##7112233",
            "(1.000000) can0 00000001##4",
            "(1.000000) can0 20000204#0008000000006000",
        ] {
            assert_eq!(line_of(&one(line)), format!("{line}\n"));
        }
        assert_eq!(line_of(&one("(1.0) can0 123##3AA")), "(1.000000) can0 123##7AA\n", "marked as FD");
    }

    fn any_frame() -> impl Strategy<Value = Frame> {
        let time = -10_i64.pow(12)..10_i64.pow(17);
        let id = prop_oneof![(0..=0x7FF_u32).prop_map(standard), (0..=0x1FFF_FFFF_u32).prop_map(extended)];
        let length =
            prop_oneof![0..=8_usize, Just(12), Just(16), Just(20), Just(24), Just(32), Just(48), Just(64)];
        let bytes = length.prop_flat_map(|length| proptest::collection::vec(any::<u8>(), length));
        (time, id, bytes, 0..4_u8, any::<bool>(), any::<bool>()).prop_map(
            |(time, id, bytes, kind, brs, esi)| {
                let time = Micros(time);
                let classic = &bytes[..bytes.len().min(8)];
                match kind {
                    0 => Frame::data_frame(time, id, classic),
                    1 => Frame::remote(time, id, classic.len()),
                    2 => Frame::new(time, id, fd(brs, esi), &bytes),
                    // An error frame has a class, which is written like an extended identifier.
                    _ => Frame::new(time, extended(id.number()), FrameKind::Error, classic),
                }
                .unwrap()
            },
        )
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(frames in proptest::collection::vec(any_frame(), 0..50)) {
            let mut text = Vec::new();
            for frame in &frames {
                write_line(&mut text, "vcan0", frame);
            }
            let (back, stats) = read(text);
            prop_assert_eq!(back, frames);
            prop_assert_eq!(stats.skipped_lines, 0);
        }
    }

    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Vec<u8>>>);
    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn frames_of_several_interfaces() {
        let (shared, frame) = (Shared::default(), one("(1.0) x 123#00"));
        let mut writer = Writer::new(shared.clone(), "can0");
        writer.write(&frame).unwrap();
        writer.write_as("can1", &frame).unwrap();
        writer.flush().unwrap();
        assert_eq!(*shared.0.lock().unwrap(), b"(1.000000) can0 123#00\n(1.000000) can1 123#00\n");
        writer.finish().unwrap();
    }

    fn files_in(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        names.map(|name| name.into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_appears_when_it_is_complete_and_not_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.log");
        fs::write(&path, "precious").unwrap();
        let frame = one("(1.0) can0 123#00");

        let mut unfinished = Writer::create(&path, "can0").unwrap();
        unfinished.write(&frame).unwrap();
        unfinished.flush().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
        drop(unfinished);
        assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
        assert_eq!(files_in(folder.path()), ["out.log"], "nothing is left lying about");

        let mut writer = Writer::create(&path, "can0").unwrap();
        writer.write(&frame).unwrap();
        writer.finish().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "(1.000000) can0 123#00\n");
        assert_eq!(files_in(folder.path()), ["out.log"]);
    }

    #[test]
    fn links_are_followed_and_devices_are_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (link, target) = (folder.path().join("latest.log"), folder.path().join("drive.log"));
        fs::write(&target, "").unwrap();
        std::os::unix::fs::symlink("drive.log", &link).unwrap();
        let mut writer = Writer::create(&link, "can0").unwrap();
        writer.write(&one("(1.0) can0 123#00")).unwrap();
        writer.finish().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&target).unwrap(), "(1.000000) can0 123#00\n");

        let null = folder.path().join("null");
        std::os::unix::fs::symlink("/dev/null", &null).unwrap();
        Writer::create(&null, "can0").unwrap().finish().unwrap();
        assert!(fs::symlink_metadata("/dev/null").unwrap().file_type().is_char_device());
    }

    #[test]
    fn the_name_says_how_to_pack() {
        let folder = tempfile::tempdir().unwrap();
        for (name, expected) in
            [("a.log.gz", Compression::Gzip), ("a.log.zst", Compression::Zstd), ("a.log", Compression::None)]
        {
            let path = folder.path().join(name);
            let mut writer = Writer::create(&path, "can0").unwrap();
            for _ in 0..1000 {
                writer.write(&one("(1.0) can0 123#00")).unwrap();
            }
            writer.finish().unwrap();
            let mut reader = Reader::open(&path).unwrap();
            while reader.next_frame().unwrap().is_some() {}
            assert_eq!((reader.compression(), reader.stats().frames), (expected, 1000));
        }
    }

    #[test]
    fn where_nothing_can_be_written_the_message_names_the_file() {
        let Err(error) = Writer::create(Path::new("/no/such/folder/out.log"), "can0") else { panic!() };
        assert!(error.to_string().contains("/no/such/folder/out.log"), "{error}");
        assert!(Writer::create(Path::new("/"), "can0").is_err());
    }
}

mod real_recordings {
    use super::*;

    fn shared() -> Option<PathBuf> {
        let folder = std::env::var_os("GRIPD_SHARED")
            .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
        if folder.is_dir() {
            return Some(folder);
        }
        println!("skipped: no recordings at {} (GRIPD_SHARED names another place)", folder.display());
        None
    }

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
        let Some(shared) = shared() else { return };
        let recordings = logs(&shared.join("recordings"));
        assert!(recordings.len() >= 3, "{recordings:?}");
        recordings.iter().for_each(|path| comes_back_the_same(path));
    }

    #[test]
    fn so_do_some_of_the_trials() {
        let Some(shared) = shared() else { return };
        logs(&shared.join("trials")).iter().step_by(8).for_each(|path| comes_back_the_same(path));
    }
}
