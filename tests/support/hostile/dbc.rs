//! DBC files.

use gripd::dbc::{Database, Message, Signal, ValueKind};

use crate::dice::Dice;

/// Every signal of every message, on a payload as long as the message, longer, shorter and empty.
fn decode(database: &Database, dice: &mut Dice) {
    for message in database.messages() {
        for length in [message.length, 64, message.length / 2, 0] {
            decode_one(message, length, dice);
        }
    }
}

/// Every signal of a message on a payload of that length.
pub fn decode_one(message: &Message, length: usize, dice: &mut Dice) {
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

/// An error names the file; what is read decodes and encodes.
pub fn check(text: &[u8]) {
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
