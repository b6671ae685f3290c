//! Numbers in little-endian bytes; `None` beyond the end.

/// Two bytes.
pub fn u16_at(bytes: &[u8], place: usize) -> Option<u16> {
    array(bytes, place).map(u16::from_le_bytes)
}

/// Four bytes.
pub fn u32_at(bytes: &[u8], place: usize) -> Option<u32> {
    array(bytes, place).map(u32::from_le_bytes)
}

/// Eight bytes.
pub fn u64_at(bytes: &[u8], place: usize) -> Option<u64> {
    array(bytes, place).map(u64::from_le_bytes)
}

/// Any number of bytes.
pub fn array<const N: usize>(bytes: &[u8], place: usize) -> Option<[u8; N]> {
    bytes.get(place..)?.first_chunk().copied()
}
