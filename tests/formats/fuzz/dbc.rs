//! DBC files, and payloads for what they describe.

use std::sync::OnceLock;

use gripd::dbc::{Database, Message, Signal, ValueKind};

use super::mutate::Mutator;
use super::run::{corpus, fuzz, known};
use testing::dice::Dice;

const WORDS: [&str; 24] = [
    "BO_ ",
    " SG_ ",
    "VAL_ ",
    "BA_ ",
    "BA_DEF_ ",
    "SIG_VALTYPE_ ",
    "SG_MUL_VAL_ ",
    "CM_ ",
    "EV_ ",
    "VAL_TABLE_ ",
    " M ",
    " m0 ",
    " m1M ",
    "|64@0-",
    "|1@1+",
    "(1,0)",
    "(0,0)",
    "(1e-320,1e308)",
    "[0|0]",
    "\"\"",
    " ;",
    "\"",
    "2147483648",
    "3221225472",
];

/// Every signal of every message, on a payload as long as the message, longer, shorter and empty.
fn decode(database: &Database, dice: &mut Dice) {
    for message in database.messages() {
        for length in [message.length, 64, message.length / 2, 0] {
            decode_one(message, length, dice);
        }
    }
}

/// Every signal of a message on a payload of that length.
fn decode_one(message: &Message, length: usize, dice: &mut Dice) {
    let mut payload = [0; 64];
    payload.iter_mut().for_each(|byte| *byte = if dice.once_in(4) { 0xFF } else { dice.draw() as u8 });
    for signal in &message.signals {
        round_trip(message, signal, &payload[..length.min(64)]);
    }
}

/// Bits that are put back leave the payload as it was, and a number that stands for them means them.
fn round_trip(message: &Message, signal: &Signal, payload: &[u8]) {
    let _ = signal.is_active(payload);
    let Some(bits) = signal.bits(payload) else {
        return assert!(payload.len() < message.length, "{}.{}", message.name, signal.name);
    };
    let mut copy = [0; 64];
    let copy = &mut copy[..payload.len()];
    copy.copy_from_slice(payload);
    signal.insert(copy, bits).unwrap();
    assert_eq!(copy, payload, "{}.{}", message.name, signal.name);
    let value = signal.physical(bits);
    let _ = signal.value_name(bits);
    let codec = signal.codec();
    let exact = matches!(codec.kind, ValueKind::Unsigned | ValueKind::Signed) && codec.extractor.size() <= 32;
    let plain = codec.factor.abs() > 1e-9
        && codec.factor.abs() < 1e9
        && codec.offset.abs() < 1e6 * codec.factor.abs();
    if exact && plain {
        assert_eq!(signal.bits_from_physical(value), Ok(bits), "{}.{} {value}", message.name, signal.name);
    }
}

fn check(text: &[u8]) {
    match Database::parse(text, "fuzz.dbc") {
        Ok(database) => {
            for warning in database.warnings() {
                assert!(warning.line >= 1, "{warning}");
            }
            let mut dice = Dice::new("payload", text.len() as u64, 0);
            decode(&database, &mut dice);
        }
        Err(error) => assert!(error.to_string().starts_with("fuzz.dbc"), "{error}"),
    }
}

#[test]
fn files() {
    known("dbc", check);
    let seeds: Vec<Vec<u8>> = corpus("dbc").into_iter().map(|(_, text)| text).collect();
    let mutator = Mutator { seeds: &seeds, words: &WORDS, longest: 8000 };
    fuzz("dbc", 400, |dice| mutator.make(dice), |text| check(text));
}

#[test]
fn payloads() {
    static DATABASES: OnceLock<Vec<Database>> = OnceLock::new();
    let databases = DATABASES.get_or_init(|| {
        corpus("dbc").iter().filter_map(|(_, text)| Database::parse(text, "corpus").ok()).collect()
    });
    fuzz("payloads", 20_000, Dice::draw, |seed| {
        let mut dice = Dice::new("payloads", *seed, 0);
        let database = dice.of(databases);
        let message = dice.of(database.messages());
        let length = *dice.of(&[message.length, message.length, 64, message.length / 2, 0]);
        decode_one(message, length, &mut dice);
    });
}
