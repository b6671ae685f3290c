//! Makes BLF files, as loggers do and as they should not.

use std::io::Write;

/// An object of a type, its time in nanoseconds.
pub fn object(kind: u32, ns: u64, body: &[u8]) -> Vec<u8> {
    let mut bytes = b"LOBJ".to_vec();
    bytes.extend(32_u16.to_le_bytes());
    bytes.extend(1_u16.to_le_bytes());
    bytes.extend((32 + body.len() as u32).to_le_bytes());
    bytes.extend(kind.to_le_bytes());
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(ns.to_le_bytes());
    bytes.extend(body);
    bytes.extend(vec![0; body.len() % 4]);
    bytes
}

/// A classic frame of channel 2.
pub fn classic(ns: u64, id: u32, data: &[u8]) -> Vec<u8> {
    let mut body = vec![2, 0, 0, data.len() as u8];
    body.extend(id.to_le_bytes());
    body.extend(data);
    body.resize(16, 0);
    object(1, ns, &body)
}

/// A container of bytes, of zlib data or (method 0) as they are.
pub fn container(objects: &[u8], method: u16) -> Vec<u8> {
    let mut data = objects.to_vec();
    if method == 2 {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(objects).unwrap();
        data = encoder.finish().unwrap();
    }
    let mut bytes = b"LOBJ".to_vec();
    bytes.extend(16_u16.to_le_bytes());
    bytes.extend(1_u16.to_le_bytes());
    bytes.extend((32 + data.len() as u32).to_le_bytes());
    bytes.extend(10_u32.to_le_bytes());
    bytes.extend(method.to_le_bytes());
    bytes.extend([0; 6]);
    bytes.extend((objects.len() as u32).to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(&data);
    bytes.extend(vec![0; data.len() % 4]);
    bytes
}

/// A file that began on 9 October 2025 at 08:53:20.
pub fn file(parts: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"LOGG".to_vec();
    bytes.extend(144_u32.to_le_bytes());
    bytes.resize(40, 0);
    for number in [2025_u16, 10, 4, 9, 8, 53, 20, 0] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.resize(144, 0);
    bytes.extend(parts.concat());
    bytes
}
