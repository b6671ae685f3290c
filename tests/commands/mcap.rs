//! GIVEN a drive WHEN its tables and published frames are written as MCAP THEN they say what the CSV and the frames say, under
//! the topics and columns that the layouts for viewers ask for.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use gripd::can::candump;
use gripd::signals::publish::built_in_database;
use mcap::MessageStream;
use testing::program::{gripd_in, project};

/// A field of a message: its bytes, or its number as the wire has it.
#[derive(Debug, PartialEq)]
enum Value {
    Number(u64),
    Bytes(Vec<u8>),
}

/// The fields of a message by their numbers.
fn fields(mut bytes: &[u8]) -> Vec<(u64, Value)> {
    fn varint(bytes: &mut &[u8]) -> u64 {
        let length = bytes.iter().position(|byte| byte & 0x80 == 0).unwrap() + 1;
        let (these, rest) = bytes.split_at(length);
        *bytes = rest;
        these.iter().rev().fold(0, |value, byte| value << 7 | u64::from(byte & 0x7F))
    }
    let mut found = Vec::new();
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let value = match key & 7 {
            0 => Value::Number(varint(&mut bytes)),
            1 => {
                let (these, rest) = bytes.split_at(8);
                bytes = rest;
                Value::Number(u64::from_le_bytes(these.try_into().unwrap()))
            }
            _ => {
                let length = varint(&mut bytes) as usize;
                let (these, rest) = bytes.split_at(length);
                bytes = rest;
                Value::Bytes(these.to_vec())
            }
        };
        found.push((key >> 3, value));
    }
    found
}

fn bytes_of(fields: &[(u64, Value)], number: u64) -> Vec<&[u8]> {
    let of_number = fields.iter().filter(|(found, _)| *found == number);
    of_number.map(|(_, value)| if let Value::Bytes(bytes) = value { &**bytes } else { panic!() }).collect()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Names and kinds of the columns, as a schema describes them (descriptor.proto).
fn columns(schema: &[u8]) -> Vec<(String, u64)> {
    let set = fields(schema);
    let file = fields(bytes_of(&set, 1)[0]);
    let kind = fields(bytes_of(&file, 4)[0]);
    let described = bytes_of(&kind, 2);
    let column = |bytes: &&[u8]| {
        let field = fields(bytes);
        let kind = field.iter().find(|(number, _)| *number == 5).map(|(_, value)| match value {
            Value::Number(kind) => *kind,
            Value::Bytes(_) => panic!(),
        });
        (text(bytes_of(&field, 1)[0]), kind.unwrap())
    };
    described.iter().map(column).collect()
}

/// A value as the CSV has it.
fn cell(column: &(String, u64), value: &Value) -> String {
    match (column.1, value) {
        (1, Value::Number(bits)) => match f64::from_bits(*bits) {
            number if number.is_nan() => String::new(),
            number if column.0 == "t" => format!("{number:.6}"),
            number => number.to_string(),
        },
        (8 | 13, Value::Number(number)) => number.to_string(),
        (9, Value::Bytes(bytes)) => text(bytes),
        other => panic!("{other:?}"),
    }
}

/// Rows of each topic as lines of CSV, the first of them the names; and the times, ns.
fn topics(path: &Path) -> BTreeMap<String, (Vec<String>, Vec<u64>)> {
    let file = fs::read(path).unwrap();
    let mut topics: BTreeMap<String, (Vec<String>, Vec<u64>)> = BTreeMap::new();
    for message in MessageStream::new(&file).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!((schema.encoding.as_str(), message.channel.message_encoding.as_str()), ("protobuf", "protobuf"));
        let columns = columns(&schema.data);
        let (rows, times) = topics.entry(message.channel.topic.clone()).or_default();
        if rows.is_empty() {
            rows.push(columns.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(","));
        }
        let values = fields(&message.data);
        assert!(values.iter().map(|(number, _)| *number).eq(1..=columns.len() as u64));
        let cells = columns.iter().zip(&values).map(|(column, (_, value))| cell(column, value));
        rows.push(cells.collect::<Vec<_>>().join(","));
        times.push(message.log_time);
    }
    topics
}

/// A short drive, replayed with these results.
fn replayed(folder: &Path, results: &str) {
    let scenario = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    fs::write(folder.join("drive.toml"), scenario.replace("duration_s = 120.0", "duration_s = 50.0")).unwrap();
    assert!(gripd_in(folder, "simulate drive.toml -o drive.log").status.success());
    let config = project("config/demo.toml");
    let output = gripd_in(folder, &format!("replay -c {} drive.log {results}", config.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn topics_say_what_tables_and_frames_say_and_layouts_ask_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    replayed(path, "--estimates e.csv --samples s.csv -o p.log");
    replayed(path, "--estimates e.mcap --samples s.mcap -o p.mcap");
    let estimates = topics(&path.join("e.mcap"));
    for (name, csv, read) in
        [("estimates", "e.csv", &estimates), ("samples", "s.csv", &topics(&path.join("s.mcap")))]
    {
        let (rows, times) = &read[&format!("/gripd/{name}")];
        let csv = fs::read_to_string(path.join(csv)).unwrap();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(rows.len(), lines.len());
        let different = rows.iter().zip(&lines).find(|(row, line)| row != *line);
        assert!(different.is_none(), "{different:?}");
        let seconds = |line: &str| line.split(',').next().unwrap().parse::<f64>().unwrap();
        assert!(times.iter().zip(&lines[1..]).all(|(ns, line)| *ns as f64 / 1e9 == seconds(line)));
    }
    published(&path.join("p.log"), &topics(&path.join("p.mcap")));
    let size = |name: &str| fs::metadata(path.join(name)).unwrap().len();
    assert!(2 * size("e.mcap") < size("e.csv"), "{} of {}", size("e.mcap"), size("e.csv"));

    let columns: Vec<&str> = estimates["/gripd/estimates"].0[0].split(',').collect();
    for (layout, before) in [("foxglove.json", "/gripd/estimates."), ("plotjuggler.xml", "/gripd/estimates/")] {
        let text = fs::read_to_string(project("config/viewers").join(layout)).unwrap();
        let asked: Vec<&str> = text.split(before).skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
        assert!(asked.len() > 10 && asked.len() == text.matches("/gripd/").count(), "{layout}");
        assert!(asked.iter().all(|name| columns.contains(name)), "{layout}: {asked:?}");
    }
}

/// Every frame as its message says it.
fn published(log: &Path, topics: &BTreeMap<String, (Vec<String>, Vec<u64>)>) {
    let database = built_in_database().unwrap();
    let mut reader = candump::Reader::open(log).unwrap();
    let mut expected: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut absent = 0;
    while let Some(frame) = reader.next_frame().unwrap() {
        let message = database.message_with_id(frame.id).unwrap();
        let mut cells = vec![frame.time.to_string()];
        for signal in &message.signals {
            let name = signal.value_name(signal.bits(frame.data()).unwrap());
            cells.push(match name {
                Some("not_available") => String::new(),
                Some(name) if signal.values.len() > 2 => name.to_owned(),
                _ => signal.decode(frame.data()).unwrap().to_string(),
            });
            absent += usize::from(name == Some("not_available"));
        }
        expected.entry(format!("/gripd/{}", message.name)).or_default().push(cells.join(","));
    }
    assert!(expected.len() == 7 && absent > 100, "{} {absent}", expected.len());
    for (topic, rows) in expected {
        assert_eq!(topics[&topic].0[1..], rows, "{topic}");
    }
}

#[test]
fn raw_frames_are_refused_and_nothing_is_left_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("drive.log"), "(1.000000) can0 123#00\n").unwrap();
    let config = project("config/demo.toml");
    let replay = |more: &str| gripd_in(path, &format!("replay -c {} drive.log {more}", config.display()));
    let output = replay("-o all.mcap --all");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("as MCAP the published frames are written"));
    let output = gripd_in(path, "convert drive.log -o drive.mcap");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(fs::read_dir(path).unwrap().count(), 1);
}
