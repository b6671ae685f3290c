//! Vector ASC, Peak TRC, python-can CSV.

use super::*;

const ASC: &str = "\
date Thu Oct 09 08:53:20.000 2025
base hex  timestamps absolute
internal events logged
Begin Triggerblock Thu Oct 09 08:53:20.000 2025
 0.000000 Start of measurement
 0.010007 1  100             Rx   d 8 00 11 22 33 44 55 66 77
 0.020014 2  18FEF100x       Tx   d 2 aa BB  Length = 230000 BitCount = 118 ID = 419361024x
 1.500123 1  123             Rx   r 8
 1.600000 CANFD   1 Rx        123  Engine_1  1 0 9 12 00 11 22 33 44 55 66 77 88 99 00 11        0    0     3000
 1.700000 CANFD   2 Rx        124                                   0 0 2 2 01 02        0    0     0
 1.800000 1  ErrorFrame
 1.900000 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%
 1.950000 1  100             TxRq d 1 00
End TriggerBlock
";

const ASC_LINES: [&str; 6] = [
    "(1760000000.010007) can0 100#0011223344556677",
    "(1760000000.020014) can1 18FEF100#AABB",
    "(1760000001.500123) can0 123#R8",
    "(1760000001.600000) can0 123##5001122334455667788990011",
    "(1760000001.700000) can1 124#0102",
    "(1760000001.800000) can0 20000080#",
];

#[test]
fn asc_has_frames_of_all_kinds() {
    let read = read(ASC);
    assert_eq!(read.format, Format::Asc);
    assert_eq!(read.lines, ASC_LINES);
    assert_eq!((read.stats.skipped_lines, read.stats.others), (0, 3), "{:?}", read.stats);
}

#[test]
fn asc_survives_other_line_ends_and_packing() {
    let text = ASC.replace('\n', "\r\n");
    assert_eq!(read(text.clone()).lines, ASC_LINES);
    let packed = zstd::encode_all(text.as_bytes(), 3).unwrap();
    assert_eq!(read(packed).lines, ASC_LINES);
    // Without headers, and with some text before.
    let bare = "\n; a comment of somebody\n".to_owned() + &ASC.lines().skip(1).collect::<Vec<_>>().join("\n");
    let bare = read(bare);
    assert_eq!((bare.format, damage(&bare)), (Format::Asc, Damage::UnknownLine));
    assert_eq!(bare.lines, ASC_LINES);
}

#[test]
fn asc_in_decimal_with_relative_times() {
    let text = std::fs::read_to_string("tests/formats/fuzz/corpus/recordings/dec.asc").unwrap();
    let read = read(text);
    assert_eq!(
        read.lines,
        [
            "(1760000000.133000) can0 100#00112233445566FF",
            "(1760000000.143000) can1 18FEF100#R",
            "(1760000000.163000) can0 123##40011223344556677",
            "(1760000000.183000) can1 20000080#",
        ]
    );
    assert_eq!(read.stats.skipped_lines, 0, "{:?}", read.stats);
}

/// When a second measurement is appended, its times begin anew.
#[test]
fn asc_counts_from_the_trigger_that_its_times_count_from() {
    let from_date = "date Thu Oct 09 08:53:20.000 2025\nbase hex timestamps absolute\n\
        Begin Triggerblock Thu Oct 09 08:55:00.000 2025\n 100.5 1 100 Rx d 0\nEnd Triggerblock\n\
        Begin Triggerblock Thu Oct 09 08:56:00.000 2025\n 160.5 1 100 Rx d 0\nEnd Triggerblock\n\
        Begin Triggerblock Thu Oct 09 09:53:20.000 2025\n 0.5 1 100 Rx d 0\nEnd Triggerblock\n";
    let times: Vec<String> = read(from_date).lines.iter().map(|line| line[1..18].to_owned()).collect();
    assert_eq!(times, ["1760000100.500000", "1760000160.500000", "1760003600.500000"]);
}

#[test]
fn damaged_lines_of_asc_are_skipped_and_named() {
    for (line, reason) in [
        ("nonsense", Damage::UnknownLine),
        ("0.5", Damage::FewColumns),
        ("1.2.3 1 100 Rx d 0", Damage::BadTime),
        ("0.5 1 100 Rx", Damage::FewColumns),
        ("0.5 1 8000 Rx d 0", Damage::BadNumber),
        ("0.5 1 xyz Rx d 0", Damage::BadNumber),
        ("0.5 1 100 Rx d 3 00 11", Damage::BadBytes),
        ("0.5 1 100 Rx d 2 00 1", Damage::BadBytes),
        ("0.5 1 100 Rx d z 00 1", Damage::BadLength),
        ("0.5 CANFD 1 Rx 123 1 0 9 65 00", Damage::TooLong),
        ("0.5 CANFD 1 Rx 123 1 0 9 9 00 00 00 00 00 00 00 00 00", Damage::NotAnFdLength),
        ("0.5 CANFD 1 Rx 123 1", Damage::FewColumns),
    ] {
        let text = ASC.replace(" 0.010007", &format!("{line}\n 0.010007"));
        let read = read(text);
        assert_eq!(damage(&read), reason, "{line}");
        assert_eq!((read.stats.first_skipped[0].line, read.lines.len()), (6, 6), "{line}");
    }
    let long = read(ASC.replace(" 1.900000", &"9".repeat(1 << 20)));
    assert_eq!((damage(&long), long.lines.len()), (Damage::LongLine, 6));
}

/// Cut off anywhere, a text gives the lines before, and no other frame.
#[test]
fn what_is_cut_off_gives_what_is_whole() {
    for text in [ASC, TRC, CSV] {
        let whole = read(text).lines;
        for end in 60..text.len() {
            let cut = drain(Reader::from_read(Box::new(Cursor::new(text[..end].to_owned())), "x").unwrap());
            assert!(whole.starts_with(&cut.lines), "{:?} of {whole:?}", cut.lines.last());
            // A frame in a line without an end is not believed.
            let is_told = cut.stats.skipped_lines == 1 || text.as_bytes()[end - 1] == b'\n';
            let is_frame = whole.len() > cut.lines.len() && end > text.len() - 10;
            assert!(is_told || !is_frame, "{:?}", cut.stats);
        }
    }
}

const TRC: &str = "\
;$FILEVERSION=2.1
;$STARTTIME=45939.37037037037
;$COLUMNS=N,O,T,B,I,d,R,L,D
;   Start time: 2025-10-09
      1         0.000 DT  1     0100 Rx -  8    00 11 22 33 44 55 66 77
      2        10.007 DT  2 18FEF100 Tx -  2    AA BB
      3        20.500 FB  1     0123 Rx -  9    00 11 22 33 44 55 66 77 88 99 00 11
      4        21.000 RR  1     0123 Rx -  8
      5        22.000 ST  1        - Rx -  4    00 00 00 08
      6        23.000 ER  1     0008 Rx -  5    04 00 02 00 00
      7        24.000 DT  1     0100 Rx -  0
";

#[test]
fn trc_has_its_versions() {
    let newest = read(TRC);
    assert_eq!((newest.format, newest.stats.skipped_lines, newest.stats.others), (Format::Trc, 0, 1));
    assert_eq!(
        newest.lines,
        [
            "(1760000000.000000) can0 100#0011223344556677",
            "(1760000000.010007) can1 18FEF100#AABB",
            "(1760000000.020500) can0 123##5001122334455667788990011",
            "(1760000000.021000) can0 123#R8",
            "(1760000000.023000) can0 20000080#",
            "(1760000000.024000) can0 100#",
        ]
    );
    let lines =
        |name| read(std::fs::read(format!("tests/formats/fuzz/corpus/recordings/{name}")).unwrap()).lines;
    assert_eq!(
        lines("old.trc"),
        [
            "(1760000000.000003) can0 100#0011223344556677",
            "(1760000000.010103) can0 18FEF100#AABB",
            "(1760000000.020203) can0 123#R8",
            "(1760000000.040403) can0 20000080#",
        ]
    );
    assert_eq!(
        lines("columns.trc")[1..3],
        ["(1760000000.010103) can0 123##500112233445566778899AABB", "(1760000000.020203) can0 18FEF100#R8"]
    );
    let oldest = read(
        ";#####\n;   C:\\drive.trc\n     1)      1841 0001 8 00 11 22 33 44 55 66 77\n     2)      1842 FFFFFFFF 4 00 00 00 04\n     3)  1843 0002 2 RTR\n",
    );
    assert_eq!((oldest.format, oldest.stats.others), (Format::Trc, 1));
    assert_eq!(oldest.lines, ["(1.841000) can0 001#0011223344556677", "(1.843000) can0 002#R2"]);
    let three = read(";$FILEVERSION=1.3\n;$STARTTIME=25569\n 1) 1.5 2 Rx 0001 - 1 AB\n");
    assert_eq!(three.lines, ["(0.001500) can1 001#AB"]);
}

#[test]
fn damaged_lines_of_trc_are_skipped_and_named() {
    for (line, reason) in [
        ("1 x DT 1 0100 Rx - 0", Damage::BadTime),
        ("1", Damage::BadTime),
        ("1 1.0 XX 1 0100 Rx - 0", Damage::UnknownLine),
        ("1 1.0 DT 1 0800 Rx - 0", Damage::BadNumber),
        ("1 1.0 DT 1 0100 Rx - 2 00", Damage::BadBytes),
        ("1 1.0 DT 1 0100 Rx - -", Damage::BadLength),
        ("1 1.0 FD 1 0100 Rx - 16", Damage::BadLength),
        (";$FILEVERSION=9.9", Damage::UnknownLine),
        (";$STARTTIME=never", Damage::BadTime),
    ] {
        let read = read(TRC.replace("      3 ", &format!("{line}\n      3 ")));
        assert_eq!(damage(&read), reason, "{line}");
        assert_eq!((read.stats.first_skipped[0].line, read.lines.len()), (7, 6), "{line}");
    }
}

const CSV: &str = "\
timestamp,arbitration_id,extended,remote,error,dlc,data
1760000000.010007,0x100,0,0,0,8,ABEiM0RVZnc=
1760000001.5001228,0x123,0,1,0,8,
1760000001.600123,0x12345678,1,0,0,2,qrs=
1760000001.700123,0x123,0,0,0,12,ABEiM0RVZneImQAR
1760000001.800123,0x0,1,0,1,0,
";

#[test]
fn csv_has_what_python_can_puts_into_it() {
    let read = read(CSV);
    assert_eq!((read.format, read.stats.skipped_lines), (Format::Csv, 0));
    assert_eq!(
        read.lines,
        [
            "(1760000000.010007) can0 100#0011223344556677",
            "(1760000001.500123) can0 123#R8",
            "(1760000001.600123) can0 12345678#AABB",
            "(1760000001.700123) can0 123##4001122334455667788990011",
            "(1760000001.800123) can0 20000080#",
        ]
    );
}

#[test]
fn damaged_lines_of_csv_are_skipped_and_named() {
    for (line, reason) in [
        ("1.0,0x1,0,0,0,0", Damage::FewColumns),
        ("1.0,0x1,0,0,0,0,,", Damage::UnknownLine),
        ("1.0,0x1,2,0,0,0,", Damage::UnknownLine),
        (",0x1,0,0,0,0,", Damage::BadTime),
        ("1.0,0x800,0,0,0,0,", Damage::BadNumber),
        ("1.0,0x1,0,0,0,2,qg==", Damage::BadBytes),
        ("1.0,0x1,0,0,0,2,q!==", Damage::BadBytes),
        ("1.0,0x1,0,0,0,9,AAAAAAAAAAAA", Damage::NotAnFdLength),
    ] {
        let read = read(CSV.replace("1760000001.600123", &format!("{line}\n1760000001.600123")));
        assert_eq!(damage(&read), reason, "{line}");
        assert_eq!((read.stats.first_skipped[0].line, read.lines.len()), (4, 5), "{line}");
    }
}
