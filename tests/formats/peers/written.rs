//! GIVEN recordings and tables written by gripd WHEN python-can and asammdf read them THEN they read what was written.

use std::fmt::Write as _;

use gripd::can::recording::{Format, Writer as AnyWriter};

use super::*;

/// A frame as read_back.py prints it; `None` if python-can does not read it in that format.
fn line(format: Format, interface: &str, frame: &Frame) -> Option<String> {
    let channel: u32 = interface.strip_prefix("can").unwrap().parse().unwrap();
    let channel = match format {
        Format::Csv => "None".to_owned(),
        Format::Trc => (channel + 1).to_string(),
        _ => channel.to_string(),
    };
    let is_error = frame.kind == FrameKind::Error;
    let kind = match frame.kind {
        FrameKind::Error if format == Format::Trc => return None,
        FrameKind::Error => "error".to_owned(),
        FrameKind::Remote => "remote".to_owned(),
        FrameKind::Fd { bit_rate_switch, error_state } if format != Format::Csv => {
            format!("fd{}{}", u8::from(bit_rate_switch), u8::from(error_state))
        }
        FrameKind::Fd { .. } | FrameKind::Data => "data".to_owned(),
    };
    let mut data = String::new();
    frame.data().iter().for_each(|byte| write!(data, "{byte:02x}").unwrap());
    if data.is_empty() {
        data.push('-');
    }
    let id = if is_error { "-".to_owned() } else { frame.id.to_string() };
    Some(format!("{} {channel} {id} {kind} {} {data}", frame.time.0, frame.length()))
}

#[test]
#[ignore = "long: fetches python-can, asammdf and polars"]
fn python_can_reads_in_every_format_what_was_written() {
    let Some(python) = testing::peers() else { return };
    let folder = tempfile::tempdir().unwrap();
    let hard = hard();
    // candump logs are compared with candump's own.
    for (name, format) in Format::NAMES.into_iter().filter(|(_, format)| *format != Format::Candump) {
        let path = folder.path().join(format!("hard.{name}"));
        let mut writer = AnyWriter::create(&path, format, "can0").unwrap();
        hard.iter().for_each(|(interface, frame)| writer.write_as(interface, frame).unwrap());
        writer.finish().unwrap();
        let read = succeed(Command::new(&python).arg(project("tests/peers/read_back.py")).arg(&path)).stdout;
        let read = String::from_utf8(read).unwrap();
        let read: Vec<&str> = read.lines().skip(1).collect();
        let expected: Vec<String> =
            hard.iter().filter_map(|(interface, frame)| line(format, interface, frame)).collect();
        let different = read.iter().zip(&expected).find(|(read, expected)| read != expected);
        assert!(different.is_none(), "{format}: {different:?}");
        assert_eq!(read.len(), expected.len(), "{format}");
        println!("{format}: {} frames", read.len());
    }
}

/// The published frames, decoded by asammdf with the DBC, and the estimates as signals.
#[test]
#[ignore = "long: fetches python-can, asammdf and polars"]
fn asammdf_shows_the_estimates_and_decodes_what_is_published() {
    let Some(python) = testing::peers() else { return };
    let folder = tempfile::tempdir().unwrap();
    let frames: Vec<_> = drive(folder.path(), 30).into_iter().map(|frame| ("can0", frame)).collect();
    let log = folder.path().join("drive.log");
    write(&log, &frames);
    let file = |name: &str| folder.path().join(name);
    for estimates in ["estimates.mf4", "estimates.csv"] {
        let mut replay = gripd();
        replay.args(["replay", "-q", "-c"]).arg(project("config/demo.toml")).arg(&log);
        succeed(replay.arg("-o").arg(file("published.mf4")).arg("--estimates").arg(file(estimates)));
    }
    let mut reader = Reader::open(&file("published.mf4")).unwrap();
    let mut count = 0;
    while let Some(frame) = reader.next_frame().unwrap() {
        count += usize::from(frame.id.number() == 0x6A4);
    }
    assert!(count > 1400, "{count}");
    let mut script = Command::new(&python);
    script.arg(project("tests/peers/mdf.py")).arg(file("published.mf4")).arg(project("dbc/gripd.dbc"));
    let told = succeed(script.arg(file("estimates.mf4")).arg(file("estimates.csv"))).stdout;
    let told = String::from_utf8(told).unwrap();
    let table = fs::read_to_string(file("estimates.csv")).unwrap();
    let (rows, columns) = (table.lines().count() - 1, table.lines().next().unwrap().split(',').count());
    let mut lines = told.lines();
    assert_eq!(
        lines.next(),
        Some(format!("signals {} {rows} True m/s 1/rad 1", columns - 1).as_str()),
        "{told}"
    );
    assert_eq!(
        lines.next(),
        Some(format!("published {count} {count} {count} {count} m/s True").as_str()),
        "{told}"
    );
}
