//! GIVEN the same DBC file and payloads WHEN gripd and cantools decode or encode THEN they agree to the
//! last bit.
//!
//! The script `cantools_reference.py` writes what cantools makes of random payloads; here it is compared.

use std::io::{BufRead, BufReader};
use std::path::Path;

use gripd::can::CanId;
use gripd::dbc::{Database, Message};
use serde_json::Value;

/// How much was compared; a comparison of nothing must not pass.
#[derive(Debug, Default)]
struct Compared {
    messages: usize,
    values: usize,
    absent: usize,
    encodings: usize,
}

fn number(value: &Value) -> Option<f64> {
    let digits = value.as_str()?;
    Some(f64::from_bits(u64::from_str_radix(digits, 16).unwrap()))
}

fn bytes(hexadecimal: &str) -> Vec<u8> {
    (0..hexadecimal.len() / 2)
        .map(|n| u8::from_str_radix(&hexadecimal[2 * n..2 * n + 2], 16).unwrap())
        .collect()
}

/// Equal, not-a-number included. `+0` and `-0` count as equal: cantools leaves a float whose factor is
/// 1 and offset 0 untouched, where adding the offset turns `-0` into `+0`.
fn same(a: f64, b: f64) -> bool {
    a == b || (a.is_nan() && b.is_nan())
}

fn compare(file: &Path, more: &[&str]) -> Option<Compared> {
    let python = testing::python()?;
    let out = tempfile::NamedTempFile::new().unwrap();
    let status =
        testing::reference(&python).arg("decode").arg(out.path()).arg(file).args(more).status().unwrap();
    assert!(status.success(), "cantools could not be asked about {}", file.display());
    let database = Database::load(file).unwrap();
    let mut compared = Compared::default();
    for line in BufReader::new(out.reopen().unwrap()).lines() {
        let record: Value = serde_json::from_str(&line.unwrap()).unwrap();
        compare_message(&database, &record, &mut compared);
    }
    assert_eq!(compared.messages, database.messages().len(), "{}: messages", file.display());
    println!("{}: {compared:?}", file.display());
    Some(compared)
}

fn compare_message(database: &Database, record: &Value, compared: &mut Compared) {
    let name = record["message"].as_str().unwrap();
    if record["repaired"].as_bool().unwrap() {
        assert!(database.message(name).is_none(), "{name} has an identifier that cannot be");
        assert!(database.warnings().iter().any(|w| w.message.contains(name)));
        return;
    }
    let message = database.message(name).unwrap_or_else(|| panic!("{name} is missing"));
    let id = record["id"].as_u64().unwrap() as u32;
    let extended = record["extended"].as_bool().unwrap();
    assert_eq!(Some(message.id), if extended { CanId::extended(id) } else { CanId::standard(id) });
    assert_eq!(message.length as u64, record["length"].as_u64().unwrap());
    let signals = record["signals"].as_object().unwrap();
    assert_eq!(message.signals.len(), signals.len(), "{name}: signals");
    for unusable in record["unusable"].as_array().unwrap() {
        let unusable = format!("{name}.{}", unusable.as_str().unwrap());
        assert!(database.warnings().iter().any(|w| w.message.contains(&unusable)), "{unusable}");
    }
    compared.messages += 1;
    let payloads: Vec<Vec<u8>> =
        record["payloads"].as_array().unwrap().iter().map(|p| bytes(p.as_str().unwrap())).collect();
    for (signal_name, expected) in signals {
        let signal = message.signal(signal_name).unwrap_or_else(|| panic!("{name}.{signal_name} is missing"));
        for (payload, expected) in payloads.iter().zip(expected.as_array().unwrap()) {
            let (ours, expected) = (signal.decode(payload), number(expected));
            let agrees = match (ours, expected) {
                (Some(a), Some(b)) => same(a, b),
                (a, b) => a == b,
            };
            assert!(agrees, "{name}.{signal_name} of {payload:02X?}: {ours:?}, cantools: {expected:?}");
            if expected.is_some() { compared.values += 1 } else { compared.absent += 1 }
        }
    }
    for encoding in record["encodings"].as_array().unwrap() {
        compare_encoding(message, &encoding[0], &encoding[1]);
        compared.encodings += 1;
    }
}

/// Either the payload of all signals together, or one payload for each.
fn compare_encoding(message: &Message, values: &Value, expected: &Value) {
    let mut together = vec![0; message.length];
    for (name, value) in values.as_object().unwrap() {
        let signal = message.signal(name).unwrap();
        let value = number(value).unwrap();
        if let Some(alone) = expected.get(name) {
            let mut payload = vec![0; message.length];
            signal.encode(&mut payload, value).unwrap();
            assert_eq!(payload, bytes(alone.as_str().unwrap()), "{}.{name} = {value}", message.name);
        } else if !value.is_finite() {
            // gripd encodes neither NaN nor infinity; their bits are put in as they come.
            let whole = bytes(expected.as_str().unwrap());
            signal.insert(&mut together, signal.bits(&whole).unwrap()).unwrap();
        } else {
            signal.encode(&mut together, value).unwrap();
        }
    }
    if let Some(expected) = expected.as_str() {
        assert_eq!(together, bytes(expected), "{} of {values}", message.name);
    }
}

#[test]
fn own_snippets_with_the_peculiarities_of_real_files() {
    let Some(compared) = compare(&testing::data("peculiar.dbc"), &["--payloads", "1000"]) else { return };
    assert!(
        compared.values > 15_000 && compared.absent > 1_000 && compared.encodings > 8_000,
        "{compared:?}"
    );
}

#[test]
fn the_files_of_real_cars() {
    let Some(folder) = testing::shared("dbc") else { return };
    let mut total = Compared::default();
    for name in FILES {
        let Some(compared) = compare(&folder.join(name), &["--payloads", "200"]) else { return };
        assert!(compared.values > 10_000 && compared.encodings > 3_000, "{name}: {compared:?}");
        total.values += compared.values;
        total.absent += compared.absent;
    }
    assert!(total.values > 1_000_000 && total.absent > 10_000, "{total:?}");
}

const FILES: [&str; 8] = [
    "fca_giorgio.dbc",
    "ford_lincoln_base_pt.dbc",
    "hyundai_2015_ccan.dbc",
    "hyundai_canfd_generated.dbc",
    "tesla_model3_party.dbc",
    "toyota_nodsu_pt_generated.dbc",
    "vw_mqb.dbc",
    "vw_pq.dbc",
];

#[test]
fn every_frame_of_the_rav4() {
    let Some(log) = testing::shared("recordings/rav4/bus0.log.gz") else { return };
    for dbc in ["recordings/rav4/_toyota_2017.dbc", "dbc/toyota_nodsu_pt_generated.dbc"] {
        let Some(dbc) = testing::shared(dbc) else { return };
        let Some(compared) = compare(&dbc, &["--log", log.to_str().unwrap()]) else { return };
        assert!(compared.values > 100_000, "{compared:?}");
    }
}
