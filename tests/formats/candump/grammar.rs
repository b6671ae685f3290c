//! Every form of line, good and bad.

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
    for (line, length) in [("123#R", 0), ("123#R0", 0), ("123#r8", 8), ("123#R8_F", 8), ("00000123#R5", 5)] {
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
