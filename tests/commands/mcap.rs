//! GIVEN a drive WHEN its tables are written as MCAP THEN they say what the CSV says, under the topic and columns that the
//! layouts for viewers ask for. (tests/formats/peers has other people's readers.)

use std::fs;
use std::path::Path;

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

/// What is left to read, little end first.
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn take(&mut self, count: usize) -> &'a [u8] {
        let (these, rest) = self.0.split_at(count);
        self.0 = rest;
        these
    }

    fn number(&mut self, bytes: usize) -> u64 {
        self.take(bytes).iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte))
    }

    /// What has its length before it.
    fn sized(&mut self) -> &'a [u8] {
        let count = self.number(4) as usize;
        self.take(count)
    }

    /// Records until nothing is left: where each begins, its kind and its content.
    fn records(mut self, begin: usize) -> Vec<(usize, u64, &'a [u8])> {
        let size = self.0.len();
        let mut found = Vec::new();
        while !self.0.is_empty() {
            let at = begin + size - self.0.len();
            let (kind, count) = (self.number(1), self.number(8) as usize);
            found.push((at, kind, self.take(count)));
        }
        found
    }
}

fn checksum(bytes: &[u8]) -> u64 {
    let mut checksum = flate2::Crc::new();
    checksum.update(bytes);
    checksum.sum().into()
}

/// A topic as a file has it.
struct Topic {
    name: String,
    /// Lines of CSV, the first of them the names.
    rows: Vec<String>,
    /// Of each row but the first, ns.
    times: Vec<u64>,
    /// Chunks that it came in.
    chunks: usize,
}

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// The only topic of a file. Everything that the file says twice must be the same.
fn topic(path: &Path) -> Topic {
    let file = fs::read(path).unwrap();
    let records = file.strip_prefix(MAGIC).and_then(|rest| rest.strip_suffix(MAGIC)).unwrap();
    let records = Rest(records).records(MAGIC.len());
    let of_kind = |kind: u64| records.iter().filter(move |record| record.1 == kind);
    let [schema, again] = of_kind(0x03).collect::<Vec<_>>()[..] else { panic!() };
    assert_eq!(schema.2, again.2);
    let mut schema = Rest(schema.2);
    let schema_id = schema.number(2);
    let schema_name = text(schema.sized());
    assert_eq!(schema.sized(), b"protobuf");
    let columns = columns(schema.sized());

    let [channel, again] = of_kind(0x04).collect::<Vec<_>>()[..] else { panic!() };
    assert_eq!(channel.2, again.2);
    let mut channel = Rest(channel.2);
    let id = channel.number(2);
    assert_eq!(channel.number(2), schema_id);
    let name = text(channel.sized());
    assert_eq!(name, format!("/{}", schema_name.replace('.', "/")));
    assert_eq!(channel.sized(), b"protobuf");

    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let mut topic = Topic { name, rows: vec![names.join(",")], times: Vec::new(), chunks: 0 };
    let (chunks, entries) = (of_kind(0x06), of_kind(0x08));
    for (((chunk_at, _, chunk), (index_at, _, index)), (_, _, entry)) in
        chunks.zip(of_kind(0x07)).zip(entries)
    {
        let mut chunk_rest = Rest(chunk);
        let span = chunk_rest.take(16);
        let (size, crc) = (chunk_rest.number(8), chunk_rest.number(4));
        assert_eq!(chunk_rest.sized(), b"zstd");
        let packed_size = chunk_rest.number(8);
        assert_eq!(packed_size as usize, chunk_rest.0.len());
        let plain = zstd::decode_all(chunk_rest.0).unwrap();
        assert_eq!((size as usize, crc), (plain.len(), checksum(&plain)));
        let mut index = Rest(index);
        assert_eq!(index.number(2), id);
        let mut places = Rest(index.sized());
        let mut times = Vec::new();
        for (at, kind, message) in Rest(&plain).records(0) {
            assert_eq!(kind, 0x05);
            let mut message = Rest(message);
            assert_eq!(
                (message.number(2), message.number(4)),
                (id, topic.times.len() as u64 + times.len() as u64)
            );
            let (logged, published) = (message.number(8), message.number(8));
            assert_eq!((places.number(8), places.number(8)), (logged, at as u64));
            assert_eq!(logged, published);
            times.push(logged);
            let values = fields(message.0);
            assert!(values.iter().map(|(number, _)| *number).eq(1..=columns.len() as u64));
            let cells = columns.iter().zip(&values).map(|(column, (_, value))| cell(column, value));
            topic.rows.push(cells.collect::<Vec<_>>().join(","));
        }
        assert!(places.0.is_empty());
        let mut span = Rest(span);
        assert_eq!((span.number(8), span.number(8)), (times[0], times[times.len() - 1]));
        topic.times.extend(times);

        let mut entry = Rest(entry);
        assert_eq!(entry.take(16), &chunk[..16]);
        assert_eq!((entry.number(8), entry.number(8)), (*chunk_at as u64, (index_at - chunk_at) as u64));
        let mut indices = Rest(entry.sized());
        assert_eq!((indices.number(2), indices.number(8), indices.0.len()), (id, *index_at as u64, 0));
        entry.number(8);
        assert_eq!((entry.sized(), entry.number(8), entry.number(8)), (&b"zstd"[..], packed_size, size));
        topic.chunks += 1;
    }
    assert_eq!((of_kind(0x06).count(), of_kind(0x08).count()), (topic.chunks, topic.chunks));

    let [(_, _, statistics)] = of_kind(0x0B).collect::<Vec<_>>()[..] else { panic!() };
    let mut statistics = Rest(statistics);
    let count = topic.times.len() as u64;
    assert_eq!((statistics.number(8), statistics.number(2), statistics.number(4)), (count, 1, 1));
    assert_eq!((statistics.number(8), statistics.number(4)), (0, topic.chunks as u64));
    let ends = (topic.times[0], topic.times[topic.times.len() - 1]);
    assert_eq!((statistics.number(8), statistics.number(8)), ends);
    let [.., (footer_at, 0x02, footer)] = records[..] else { panic!() };
    let mut footer = Rest(footer);
    let (summary_at, offsets_at, crc) = (footer.number(8) as usize, footer.number(8), footer.number(4));
    assert_eq!((offsets_at, crc), (0, checksum(&file[summary_at..footer_at + 9 + 16])));
    let before_summary = records.iter().rfind(|record| record.0 < summary_at).unwrap();
    assert_eq!((before_summary.1, before_summary.2), (0x0F, &[0; 4][..]));
    topic
}

/// A short drive, replayed with these results.
fn replayed(folder: &Path, results: &str) {
    let scenario = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    fs::write(folder.join("drive.toml"), scenario.replace("duration_s = 120.0", "duration_s = 50.0"))
        .unwrap();
    assert!(gripd_in(folder, "simulate drive.toml -o drive.log").status.success());
    let config = project("config/demo.toml");
    let output = gripd_in(folder, &format!("replay -c {} drive.log {results}", config.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn topics_say_what_tables_say_and_layouts_ask_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    replayed(path, "--estimates e.csv --samples s.csv");
    replayed(path, "--estimates e.mcap --samples s.mcap");
    let estimates = topic(&path.join("e.mcap"));
    for (name, csv, read) in
        [("estimates", "e.csv", &estimates), ("samples", "s.csv", &topic(&path.join("s.mcap")))]
    {
        assert_eq!(read.name, format!("/gripd/{name}"));
        let csv = fs::read_to_string(path.join(csv)).unwrap();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(read.rows.len(), lines.len());
        let different = read.rows.iter().zip(&lines).find(|(row, line)| row != *line);
        assert!(different.is_none(), "{different:?}");
        let seconds = |line: &str| line.split(',').next().unwrap().parse::<f64>().unwrap();
        assert!(read.times.iter().zip(&lines[1..]).all(|(ns, line)| *ns as f64 / 1e9 == seconds(line)));
    }
    assert!(estimates.chunks > 1);
    let size = |name: &str| fs::metadata(path.join(name)).unwrap().len();
    assert!(2 * size("e.mcap") < size("e.csv"), "{} of {}", size("e.mcap"), size("e.csv"));

    let columns: Vec<&str> = estimates.rows[0].split(',').collect();
    for (layout, before) in [("foxglove.json", "/gripd/estimates."), ("plotjuggler.xml", "/gripd/estimates/")]
    {
        let text = fs::read_to_string(project("config/viewers").join(layout)).unwrap();
        let asked: Vec<&str> =
            text.split(before).skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
        assert!(asked.len() > 10 && asked.len() == text.matches("/gripd/").count(), "{layout}");
        assert!(asked.iter().all(|name| columns.contains(name)), "{layout}: {asked:?}");
    }
}
