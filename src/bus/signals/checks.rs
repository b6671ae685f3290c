//! Counters and checksums of a message, checked on reception and made on sending.

use super::config::{CrcConfig, CrcKind};
use crate::can::CanId;
use crate::dbc::{Codec, Message};
use physics::Micros;

/// After a silence this long a counter that has not moved is no sign of a frozen sender any more: the
/// sender may have started anew, or sent a whole turn of the counter unheard.
const SILENCE: Micros = Micros::from_millis(200);

/// A message's counter: where it stands and at how much it starts over.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Counter {
    /// Parts, least significant first.
    parts: Vec<Codec>,
    modulo: u64,
}

impl Counter {
    /// `None` if the parts hold more than 32 bits or fewer values than the modulo.
    pub(super) fn new(parts: Vec<Codec>, modulo: Option<u64>) -> Option<Self> {
        let bits: u32 = parts.iter().map(|part| part.extractor.size()).sum();
        if bits == 0 || bits > 32 {
            return None;
        }
        let capacity = 1u64 << bits;
        let modulo = modulo.unwrap_or(capacity);
        (2..=capacity).contains(&modulo).then_some(Self { parts, modulo })
    }

    /// The counter in this payload; `None` if the payload is too short.
    #[inline]
    pub(super) fn read(&self, data: &[u8]) -> Option<u64> {
        let mut value = 0;
        let mut shift = 0;
        for part in &self.parts {
            value |= part.bits(data)? << shift;
            shift += part.extractor.size();
        }
        Some(value)
    }

    /// Puts a counter into a payload; one that is too short stays as it is.
    pub(super) fn write(&self, data: &mut [u8], value: u64) {
        let mut rest = value % self.modulo;
        for part in &self.parts {
            let size = part.extractor.size();
            // Every part fits the message: this was checked when the DBC was loaded.
            let _ = part.insert(data, rest & ((1 << size) - 1));
            rest >>= size;
        }
    }

    /// The counter after this one.
    pub(super) fn next(&self, value: u64) -> u64 {
        (value + 1) % self.modulo
    }
}

/// What a counter says about a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// One further, or the first one seen.
    Fresh,
    /// Where it was: a repetition, or a sender that has frozen.
    Repeated,
    /// Frames are missing, or the value cannot be.
    Jumped,
}

/// Follows one counter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CounterTrack {
    last: Option<(Micros, u64)>,
}

impl CounterTrack {
    /// Judges the next frame's counter.
    pub(super) fn judge(&mut self, counter: &Counter, time: Micros, value: u64) -> Progress {
        let last = self.last.replace((time, value));
        match last {
            _ if value >= counter.modulo => Progress::Jumped,
            None => Progress::Fresh,
            Some((before, _)) if time - before > SILENCE => Progress::Fresh,
            Some((_, last)) if last == value => Progress::Repeated,
            Some((_, last)) if counter.next(last) == value => Progress::Fresh,
            Some(_) => Progress::Jumped,
        }
    }
}

/// A message's checksum: one byte, and how it is reckoned from the others.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Checksum {
    /// The byte it stands in.
    at: usize,
    /// Bytes that belong to the message.
    length: usize,
    method: Method,
}

#[derive(Clone, Debug, PartialEq)]
enum Method {
    Crc { table: Box<[u8; 256]>, init: u8, xor_out: u8, extra: Extra },
    Sum { init: u8, xor_out: u8, extra: Extra },
    Xor { init: u8, xor_out: u8, extra: Extra },
}

/// What is reckoned besides the data.
#[derive(Clone, Debug, PartialEq)]
enum Extra {
    /// The same bytes before and after the data of every frame.
    Fixed { prefix: Vec<u8>, suffix: Vec<u8> },
    /// Before the data, the data ID's low byte at even counters, its high byte at odd ones.
    Alternating { bytes: [u8; 2], counter: Counter },
    /// After the data, a byte for each counter value.
    Magic { bytes: [u8; 16], counter: Counter },
}

impl Checksum {
    /// Compiles a configured checksum of a message.
    ///
    /// # Errors
    /// What does not fit, in words, for the key `crc`.
    pub(super) fn new(
        config: &CrcConfig,
        message: &Message,
        signal: Codec,
        counter: Option<&Counter>,
    ) -> Result<Self, String> {
        refuse_unused(config)?;
        let at = byte_of(signal, message.length)
            .ok_or_else(|| format!("{} must be 8 bits that fill one byte", config.signal))?;
        let fixed = |prefix: Vec<u8>| Extra::Fixed { prefix, suffix: Vec::new() };
        let own = || Extra::Fixed { prefix: config.prefix.clone(), suffix: config.suffix.clone() };
        let (init, xor_out) = (config.init.unwrap_or(0), config.xor_out.unwrap_or(0));
        let data_id = || {
            config.data_id.map(u16::to_le_bytes).ok_or("this kind needs data_id (from the E2E specification)")
        };
        let needs_counter = || {
            counter
                .cloned()
                .ok_or("this kind depends on the counter: give the quantity counter = \"MESSAGE.Signal\" too")
        };
        let method = match config.kind {
            CrcKind::E2eP01a => {
                let extra = fixed(data_id()?.to_vec());
                Method::Crc { table: table(0x1D), init: 0, xor_out: 0, extra }
            }
            CrcKind::E2eP01b => {
                let extra = Extra::Alternating { bytes: data_id()?, counter: needs_counter()? };
                Method::Crc { table: table(0x1D), init: 0, xor_out: 0, extra }
            }
            CrcKind::Toyota => {
                let mut prefix = identifier_bytes(message.id);
                prefix.push(message.length as u8);
                Method::Sum { init: 0, xor_out: 0, extra: fixed(prefix) }
            }
            CrcKind::VwMqb => {
                let extra = match config.magic.as_slice() {
                    [one] => Extra::Fixed { prefix: Vec::new(), suffix: vec![*one] },
                    many => {
                        let bytes = many.try_into().map_err(|_| {
                            format!(
                                "magic must be one byte, or 16, one per counter value; it has {}",
                                many.len()
                            )
                        })?;
                        Extra::Magic { bytes, counter: needs_counter()? }
                    }
                };
                Method::Crc { table: table(0x2F), init: 0xFF, xor_out: 0xFF, extra }
            }
            CrcKind::Crc8 => {
                let polynomial = config.polynomial.ok_or("kind crc8 needs a polynomial, such as 0x1D")?;
                Method::Crc { table: table(polynomial), init, xor_out, extra: own() }
            }
            CrcKind::Sum8 => Method::Sum { init, xor_out, extra: own() },
            CrcKind::Xor8 => Method::Xor { init, xor_out, extra: own() },
        };
        Ok(Self { at, length: message.length, method })
    }

    /// Does the payload carry the checksum that it should? A payload that is too short does not.
    #[inline]
    pub(super) fn is_right(&self, data: &[u8]) -> bool {
        data.get(self.at) == Some(&self.reckon(data))
    }

    /// Puts the right checksum into a payload.
    pub(super) fn write(&self, data: &mut [u8]) {
        let checksum = self.reckon(data);
        if let Some(byte) = data.get_mut(self.at) {
            *byte = checksum;
        }
    }

    fn reckon(&self, data: &[u8]) -> u8 {
        let data = &data[..data.len().min(self.length)];
        match &self.method {
            Method::Crc { table, init, xor_out, extra } => {
                xor_out ^ self.fold(data, extra, *init, |crc, byte| table[usize::from(crc ^ byte)])
            }
            Method::Sum { init, xor_out, extra } => xor_out ^ self.fold(data, extra, *init, u8::wrapping_add),
            Method::Xor { init, xor_out, extra } => {
                xor_out ^ self.fold(data, extra, *init, |x, byte| x ^ byte)
            }
        }
    }

    fn fold(&self, data: &[u8], extra: &Extra, init: u8, step: impl Fn(u8, u8) -> u8) -> u8 {
        let (mut before, mut after): (&[u8], &[u8]) = (&[], &[]);
        let picked;
        match extra {
            Extra::Fixed { prefix, suffix } => (before, after) = (prefix, suffix),
            Extra::Alternating { bytes, counter } => {
                picked = [bytes[(counter.read(data).unwrap_or(0) & 1) as usize]];
                before = &picked;
            }
            Extra::Magic { bytes, counter } => {
                picked = [bytes[(counter.read(data).unwrap_or(0) & 15) as usize]];
                after = &picked;
            }
        }
        let (start, rest) = data.split_at(self.at.min(data.len()));
        let parts = [before, start, rest.get(1..).unwrap_or_default(), after];
        parts.into_iter().flatten().fold(init, |sum, byte| step(sum, *byte))
    }
}

/// Keys that another kind of checksum has are a misunderstanding, not to be passed over.
fn refuse_unused(config: &CrcConfig) -> Result<(), String> {
    use CrcKind::*;
    let generic = matches!(config.kind, Crc8 | Sum8 | Xor8);
    let unused = [
        ("data_id", config.data_id.is_some() && !matches!(config.kind, E2eP01a | E2eP01b)),
        ("magic", !config.magic.is_empty() && config.kind != VwMqb),
        ("polynomial", config.polynomial.is_some() && config.kind != Crc8),
        ("init", config.init.is_some() && !generic),
        ("xor_out", config.xor_out.is_some() && !generic),
        ("prefix", !config.prefix.is_empty() && !generic),
        ("suffix", !config.suffix.is_empty() && !generic),
    ];
    match unused.iter().find(|(_, given)| *given) {
        Some((key, _)) => {
            Err(format!("`{key}` has no meaning for this kind; leave it out, or use another kind"))
        }
        None => Ok(()),
    }
}

/// The byte that a signal fills, if it fills exactly one.
fn byte_of(signal: Codec, length: usize) -> Option<usize> {
    let mut probe = [0; 64];
    signal.insert(&mut probe[..length.min(64)], 0xFF).ok()?;
    let at = probe.iter().position(|byte| *byte == 0xFF)?;
    let alone = probe.iter().filter(|byte| **byte != 0).count() == 1;
    (alone && signal.extractor.size() == 8).then_some(at)
}

/// The bytes of the identifier's number, as many as its kind needs.
fn identifier_bytes(id: CanId) -> Vec<u8> {
    let bytes = id.number().to_be_bytes();
    if id.is_extended() { bytes.to_vec() } else { bytes[2..].to_vec() }
}

/// The CRC-8 of every byte, highest bit first.
fn table(polynomial: u8) -> Box<[u8; 256]> {
    Box::new(std::array::from_fn(|byte| {
        (0..8).fold(byte as u8, |crc, _| if crc & 0x80 != 0 { crc << 1 ^ polynomial } else { crc << 1 })
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dbc::Database;

    fn database() -> Database {
        let text = "VERSION \"\"\n\nBU_: A\n\nBO_ 257 M: 8 A\n SG_ Crc : 0|8@1+ (1,0) [0|0] \"\" A\n SG_ Cnt : 8|4@1+ (1,0) [0|0] \"\" A\n SG_ Split : 4|8@1+ (1,0) [0|0] \"\" A\n SG_ Low : 14|2@1+ (1,0) [0|0] \"\" A\n SG_ High : 30|2@1+ (1,0) [0|0] \"\" A\n\nBO_ 180 SPEED: 8 A\n SG_ CHECKSUM : 63|8@0+ (1,0) [0|0] \"\" A\n\nBO_ 9 NINE: 10 A\n SG_ Last : 72|8@1+ (1,0) [0|0] \"\" A\n";
        Database::parse(text.as_bytes(), "test.dbc").unwrap()
    }

    fn checksum(signal: &str, toml: &str, counter: Option<&Counter>) -> Result<Checksum, String> {
        let database = database();
        let config: CrcConfig = toml::from_str(&format!("signal = \"{signal}\"\n{toml}")).unwrap();
        let (message, found) = database.signal(signal).unwrap();
        Checksum::new(&config, message, found.codec(), counter)
    }

    fn counter(names: &[&str], modulo: Option<u64>) -> Option<Counter> {
        let database = database();
        Counter::new(names.iter().map(|name| database.signal(name).unwrap().1.codec()).collect(), modulo)
    }

    #[test]
    fn known_polynomials_give_their_published_check_values() {
        // CRC catalogue: the CRC of the digits 1 to 9.
        let digits = *b"123456789\0";
        for (toml, check) in [
            ("polynomial = 0x1D\ninit = 0xFF\nxor_out = 0xFF", 0x4B), // SAE J1850
            ("polynomial = 0x2F\ninit = 0xFF\nxor_out = 0xFF", 0xDF), // AUTOSAR 8H2F
            ("polynomial = 0x07", 0xF4),                              // SMBUS
        ] {
            let crc = checksum("NINE.Last", &format!("kind = \"crc8\"\n{toml}"), None).unwrap();
            assert_eq!(crc.reckon(&digits), check, "{toml}");
        }
        assert_eq!(checksum("NINE.Last", "kind = \"xor8\"", None).unwrap().reckon(&digits), 0x31);
        assert_eq!(checksum("NINE.Last", "kind = \"sum8\"", None).unwrap().reckon(&digits), 0xDD);
    }

    #[test]
    fn a_frame_of_a_real_toyota_is_accepted_and_a_damaged_one_is_not() {
        let crc = checksum("SPEED.CHECKSUM", "kind = \"toyota\"", None).unwrap();
        let mut data = [0, 0, 0, 0, 0x1D, 0x0B, 0x7A, 0x5E];
        assert!(crc.is_right(&data));
        data[4] ^= 1;
        assert!(!crc.is_right(&data));
        assert!(!crc.is_right(&data[..7]));
    }

    #[test]
    fn profile_1_covers_data_id_and_everything_but_the_checksum() {
        let crc = checksum("M.Crc", "kind = \"e2e_p01a\"\ndata_id = 0x123", None).unwrap();
        // J1850 from zero over 23 01, then the seven bytes after the checksum.
        let generic = "kind = \"crc8\"\npolynomial = 0x1D\nprefix = [0x23, 0x01]";
        let same = checksum("M.Crc", generic, None).unwrap();
        let data = [0xAA, 0x05, 1, 2, 3, 4, 5, 6];
        assert_eq!(crc.reckon(&data), same.reckon(&data));
        assert_eq!(crc.reckon(&data), crate::signals::e2e::profile_1_crc(0x123, &data, 0));
        assert_eq!(crc.reckon(&data), crc.reckon(&[0, 0x05, 1, 2, 3, 4, 5, 6]));
        assert_ne!(crc.reckon(&data), crc.reckon(&[0xAA, 0x06, 1, 2, 3, 4, 5, 6]));
        let cnt = counter(&["M.Cnt"], None).unwrap();
        let alternating = checksum("M.Crc", "kind = \"e2e_p01b\"\ndata_id = 0x123", Some(&cnt)).unwrap();
        let low = checksum("M.Crc", "kind = \"crc8\"\npolynomial = 0x1D\nprefix = [0x23]", None).unwrap();
        let high = checksum("M.Crc", "kind = \"crc8\"\npolynomial = 0x1D\nprefix = [0x01]", None).unwrap();
        assert_eq!(alternating.reckon(&[0, 4, 9, 9, 9, 9, 9, 9]), low.reckon(&[0, 4, 9, 9, 9, 9, 9, 9]));
        assert_eq!(alternating.reckon(&[0, 5, 9, 9, 9, 9, 9, 9]), high.reckon(&[0, 5, 9, 9, 9, 9, 9, 9]));
    }

    #[test]
    fn the_magic_byte_follows_the_counter() {
        let cnt = counter(&["M.Cnt"], None).unwrap();
        let magic: Vec<String> = (0..16).map(|i| (i * 3).to_string()).collect();
        let toml = format!("kind = \"vw_mqb\"\nmagic = [{}]", magic.join(","));
        let crc = checksum("M.Crc", &toml, Some(&cnt)).unwrap();
        let same = "kind = \"crc8\"\npolynomial = 0x2F\ninit = 0xFF\nxor_out = 0xFF\nsuffix = [21]";
        let same = checksum("M.Crc", same, None).unwrap();
        assert_eq!(crc.reckon(&[0, 7, 1, 1, 1, 1, 1, 1]), same.reckon(&[0, 7, 1, 1, 1, 1, 1, 1]));
        assert!(checksum("M.Crc", &toml, None).unwrap_err().contains("counter"));
        assert!(checksum("M.Crc", "kind = \"vw_mqb\"\nmagic = [1, 2]", None).unwrap_err().contains("16"));
    }

    #[test]
    fn checksums_that_cannot_be_are_refused_with_what_to_do() {
        assert!(checksum("M.Split", "kind = \"sum8\"", None).unwrap_err().contains("one byte"));
        assert!(checksum("M.Crc", "kind = \"crc8\"", None).unwrap_err().contains("polynomial"));
        assert!(checksum("M.Crc", "kind = \"e2e_p01a\"", None).unwrap_err().contains("data_id"));
        assert!(checksum("M.Crc", "kind = \"toyota\"\ninit = 3", None).unwrap_err().contains("`init`"));
    }

    #[test]
    fn a_counter_in_two_parts_is_put_together_and_taken_apart() {
        let counter = counter(&["M.Low", "M.High"], None).unwrap();
        let mut data = [0; 8];
        counter.write(&mut data, 0b1101);
        assert_eq!((data[1] >> 6, data[3] >> 6), (0b01, 0b11));
        assert_eq!(counter.read(&data), Some(0b1101));
        assert_eq!(counter.next(15), 0);
    }

    #[test]
    fn frozen_jumping_and_impossible_counters_are_told_apart() {
        let counter = counter(&["M.Cnt"], Some(15)).unwrap();
        let mut track = CounterTrack::default();
        let mut at = |ms, value| track.judge(&counter, Micros::from_millis(ms), value);
        assert_eq!(at(0, 13), Progress::Fresh);
        assert_eq!(at(20, 14), Progress::Fresh);
        assert_eq!(at(40, 0), Progress::Fresh);
        assert_eq!(at(60, 0), Progress::Repeated);
        assert_eq!(at(80, 3), Progress::Jumped);
        assert_eq!(at(100, 15), Progress::Jumped);
        // However long it is frozen, as long as frames come it stays frozen; after a silence it is new.
        assert_eq!(at(120, 4), Progress::Jumped);
        for ms in (140..2000).step_by(20) {
            assert_eq!(at(ms, 4), Progress::Repeated);
        }
        assert_eq!(at(2500, 4), Progress::Fresh);
        assert!(super::Counter::new(Vec::new(), None).is_none());
    }

    #[test]
    fn a_modulo_that_the_bits_cannot_count_to_is_refused() {
        assert!(counter(&["M.Cnt"], Some(17)).is_none());
        assert!(counter(&["M.Cnt"], Some(1)).is_none());
    }
}
