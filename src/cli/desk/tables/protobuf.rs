//! As much of Protocol Buffers as rows need: one message type of numbers, flags and words, described for readers that have
//! never seen it, and its messages.
//!
//! Learned from protobuf.dev ("Encoding", and `descriptor.proto`). Every field of a message is written.

use super::rows::{Column, Kind};

/// How a field's value is laid down.
const VARINT: u64 = 0;
const FIXED_64: u64 = 1;
const BYTES: u64 = 2;

/// A message that is being written.
#[derive(Default)]
pub struct Message(Vec<u8>);

impl Message {
    /// Begins another one.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// What was written.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// A number (`double`).
    pub fn double(&mut self, field: u64, value: f64) {
        self.varint(field << 3 | FIXED_64);
        self.0.extend(value.to_le_bytes());
    }

    /// A whole number or a flag (`uint32`, `bool`).
    pub fn unsigned(&mut self, field: u64, value: u64) {
        self.varint(field << 3 | VARINT);
        self.varint(value);
    }

    /// A text, or a message within this one.
    pub fn bytes_of(&mut self, field: u64, value: &[u8]) {
        self.varint(field << 3 | BYTES);
        self.varint(value.len() as u64);
        self.0.extend(value);
    }

    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }
}

/// A `FileDescriptorSet` of one file with one message type, `gripd.NAME`, whose fields are numbered from 1 in the order of the
/// columns.
pub fn description(name: &str, columns: &[Column]) -> Vec<u8> {
    // Numbers of fields and types in descriptor.proto.
    let mut kind = Message::default();
    kind.bytes_of(1, name.as_bytes());
    for (number, column) in (1..).zip(columns) {
        let mut field = Message::default();
        field.bytes_of(1, column.name.as_bytes());
        field.unsigned(3, number);
        field.unsigned(4, 1); // LABEL_OPTIONAL
        field.unsigned(
            5,
            match column.kind {
                Kind::Real => 1,   // TYPE_DOUBLE
                Kind::Count => 13, // TYPE_UINT32
                Kind::Flag => 8,   // TYPE_BOOL
                Kind::Word => 9,   // TYPE_STRING
            },
        );
        kind.bytes_of(2, field.bytes());
    }
    let mut file = Message::default();
    file.bytes_of(1, format!("gripd/{name}.proto").as_bytes());
    file.bytes_of(2, b"gripd");
    file.bytes_of(4, kind.bytes());
    file.bytes_of(12, b"proto3");
    let mut set = Message::default();
    set.bytes_of(1, file.bytes());
    set.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_documentation() {
        let mut message = Message::default();
        message.unsigned(1, 150);
        message.bytes_of(2, b"testing");
        assert_eq!(message.bytes(), b"\x08\x96\x01\x12\x07testing");
        message.clear();
        message.double(16, 1.0);
        assert_eq!(message.bytes(), b"\x81\x01\0\0\0\0\0\0\xF0\x3F");
    }
}
