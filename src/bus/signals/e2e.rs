//! AUTOSAR end-to-end protection, profile 1, variant 1A.
//!
//! A CRC-8 over a data ID that both ends know and over the payload but the CRC itself, and a counter
//! of 0 to 14. Variant 1A has the CRC in byte 0, the counter in the low nibble of byte 1, and both
//! bytes of the data ID in the CRC. Source: AUTOSAR PRS E2E Protocol, chapter on profile 1.

/// The counter never takes the value 15.
pub const COUNTER_MAX: u8 = 14;

/// SAE J1850.
const POLYNOMIAL: u8 = 0x1D;

const TABLE: [u8; 256] = table();

const fn table() -> [u8; 256] {
    let mut table = [0; 256];
    let mut value = 0;
    while value < 256 {
        let mut crc = value as u8;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 0x80 != 0 { (crc << 1) ^ POLYNOMIAL } else { crc << 1 };
            bit += 1;
        }
        table[value] = crc;
        value += 1;
    }
    table
}

/// Continues a CRC-8 (polynomial 0x1D, most significant bit first) with more bytes.
#[inline]
pub fn crc8_j1850(crc: u8, bytes: &[u8]) -> u8 {
    bytes.iter().fold(crc, |crc, byte| TABLE[usize::from(crc ^ byte)])
}

/// The checksum of profile 1 with both bytes of the data ID: start value 0, no final XOR.
///
/// `crc_byte` is the place of the checksum in the payload (0 in variant 1A); it is left out. A place
/// beyond the payload leaves out nothing.
#[inline]
pub fn profile_1_crc(data_id: u16, payload: &[u8], crc_byte: usize) -> u8 {
    let crc = crc8_j1850(0, &data_id.to_le_bytes());
    let (before, after) = payload.split_at(crc_byte.min(payload.len()));
    crc8_j1850(crc8_j1850(crc, before), after.get(1..).unwrap_or_default())
}

/// The counter that follows.
#[inline]
pub const fn next_counter(counter: u8) -> u8 {
    if counter >= COUNTER_MAX { 0 } else { counter + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_value_of_the_polynomial() {
        // CRC-8 with polynomial 0x1D, start 0, no XOR, over "123456789"; with 0xFF for both, 0x4B.
        assert_eq!(crc8_j1850(0, b"123456789"), 0x37);
        assert_eq!(crc8_j1850(0xFF, b"123456789") ^ 0xFF, 0x4B);
    }

    #[test]
    fn vectors_of_profile_1() {
        // The first is the specification's example; all are what the `autosar-e2e` package computes.
        assert_eq!(profile_1_crc(0x123, &[0; 8], 0), 0xCC);
        assert_eq!(profile_1_crc(0x6A0, &[0; 8], 0), 0x13);
        assert_eq!(profile_1_crc(0x6A5, &[0; 8], 0), 0xFF);
        assert_eq!(profile_1_crc(0x6A0, &[0xAA, 0x13, 1, 2, 3, 4, 5, 0xFF], 0), 0xC6);
    }

    #[test]
    fn the_checksum_itself_is_left_out_wherever_it_is() {
        assert_eq!(profile_1_crc(1, &[7, 8, 0, 9], 2), profile_1_crc(1, &[7, 8, 99, 9], 2));
        assert_ne!(profile_1_crc(1, &[7, 8, 0, 9], 2), profile_1_crc(1, &[7, 9, 0, 9], 2));
    }

    /// The remainder bit by bit, as it is defined.
    fn divided(mut crc: u8, byte: u8) -> u8 {
        for bit in (0..8).rev() {
            let carry = (crc >> 7) ^ (byte >> bit & 1);
            crc = (crc << 1) ^ if carry == 1 { POLYNOMIAL } else { 0 };
        }
        crc
    }

    /// Each step of a checksum is one of these, so all checksums are right.
    #[test]
    fn every_step_is_that_of_the_division() {
        for crc in 0..=255 {
            for byte in 0..=255 {
                assert_eq!(crc8_j1850(crc, &[byte]), divided(crc, byte), "{crc} {byte}");
            }
        }
    }

    /// The checksum is linear in the payload: a change is missed where it has itself the checksum zero, whatever the payload
    /// and the data ID are. Tried are all changes of one bit, of two, and of any within eight in a row, wherever they are in
    /// eight bytes.
    #[test]
    fn no_change_of_two_bits_and_no_burst_of_eight_is_missed() {
        let checksum = |change: u64| profile_1_crc(0, &change.to_be_bytes(), 0);
        let (first, id) = (0x0123_4567_89AB_CDEF_u64, 0x6A5);
        let places = 0..56;
        let two = places.clone().flat_map(|one| (0..56).map(move |other| 1_u64 << one | 1_u64 << other));
        let bursts = places.flat_map(|place| (1..=255_u64).map(move |burst| burst << place));
        let changes = two.chain(bursts).map(|change| change & (u64::MAX >> 8)).filter(|change| *change != 0);
        for change in changes {
            assert_ne!(checksum(change), 0, "{change:016x}");
            let whole = |payload: u64| profile_1_crc(id, &payload.to_be_bytes(), 0);
            assert_eq!(whole(first) ^ whole(first ^ change), checksum(change), "{change:016x}");
        }
    }

    /// From any number that a byte can hold the counter comes to one that it may have, and goes round all fifteen of these.
    #[test]
    fn every_counter_goes_round() {
        for from in 0..=255 {
            let mut counter = next_counter(from);
            assert!(counter <= COUNTER_MAX, "{from}");
            let mut seen = [false; COUNTER_MAX as usize + 1];
            for _ in 0..=COUNTER_MAX {
                seen[usize::from(counter)] = true;
                counter = next_counter(counter);
            }
            assert_eq!(seen, [true; COUNTER_MAX as usize + 1], "{from}");
        }
    }

    #[test]
    fn the_counter_skips_fifteen() {
        assert_eq!((next_counter(0), next_counter(13), next_counter(14), next_counter(15)), (1, 14, 0, 0));
    }
}
