//! Rows as signals of an ASAM MF4 file, for MDF viewers: a channel with its unit for each column, the time their master.
//!
//! Where there is no value the channel's invalidation bit is set, and the number is not a number; flags are 0 and 1.

use std::io::{self, Seek, Write};

use super::Table;
use super::rows::{Column, Kind, Rows};
use bus::can::recording::mdf::{self, Channel, Group, MdfFile, Records, TIME};
use physics::Micros;

/// Bytes of a word: those that there are have twelve at most.
const WORD: usize = 16;

/// Writes a block of rows at a time.
pub struct Mf4<W: Write + Seek> {
    file: MdfFile<W>,
    group: Group,
    records: Records,
    start: Option<Micros>,
    row: Vec<u8>,
    /// Which of the row's values are not there.
    invalid: Vec<u8>,
    /// The bit of the next number.
    next: usize,
}

impl<W: Write + Seek> Mf4<W> {
    /// Begins the file; `title` is the name of the table. The first column is the time.
    pub fn new(output: W, title: &str, columns: &[Column]) -> io::Result<Self> {
        let (mut byte, mut bits) = (TIME, 0);
        let mut channels = Vec::new();
        for column in columns.iter().skip(1) {
            let (kind, size) = match column.kind {
                Kind::Real => (mdf::Kind::Real, 8),
                Kind::Count => (mdf::Kind::Unsigned, 4),
                Kind::Flag => (mdf::Kind::Unsigned, 1),
                Kind::Word => (mdf::Kind::Text, WORD),
            };
            let invalid = (column.kind == Kind::Real).then_some(bits);
            bits += u32::from(invalid.is_some());
            let (name, unit) = (column.name.clone(), column.unit.clone().into_owned());
            channels.push(Channel { name, unit, kind, byte, size, invalid });
            byte += size;
        }
        let invalid_size = bits.div_ceil(8) as usize;
        let group = Group { name: title.to_owned(), frame: None, channels, size: byte, invalid_size };
        let records = Records::of(&group);
        let file = MdfFile::new(output)?;
        Ok(Self {
            file,
            group,
            records,
            start: None,
            row: Vec::new(),
            invalid: vec![0; invalid_size],
            next: 0,
        })
    }
}

impl<W: Write + Seek> Rows for Mf4<W> {
    fn time(&mut self, time: Micros) {
        // The file's own time begins with the second of the first row.
        let whole = time.0.div_euclid(Micros::PER_SECOND) * Micros::PER_SECOND;
        let start = *self.start.get_or_insert(Micros(whole.max(0)));
        self.row.clear();
        self.row.extend((time - start).0.to_le_bytes());
        self.invalid.fill(0);
        self.next = 0;
    }

    fn number(&mut self, value: Option<f64>) {
        self.row.extend(value.unwrap_or(f64::NAN).to_le_bytes());
        if value.is_none()
            && let Some(byte) = self.invalid.get_mut(self.next / 8)
        {
            *byte |= 1 << (self.next % 8);
        }
        self.next += 1;
    }

    fn count(&mut self, value: u32) {
        self.row.extend(value.to_le_bytes());
    }

    fn flag(&mut self, value: bool) {
        self.row.push(value.into());
    }

    fn word(&mut self, word: &'static str) {
        let mut bytes = [0; WORD];
        // One that does not fit leaves the row too short, which is an error at its end.
        if let Some(start) = bytes.get_mut(..word.len()) {
            start.copy_from_slice(word.as_bytes());
            self.row.extend(bytes);
        }
    }

    fn end(&mut self) -> io::Result<()> {
        if self.row.len() != self.group.size {
            return Err(io::Error::other("a row does not have the values of its columns"));
        }
        self.row.extend_from_slice(&self.invalid);
        self.records.push(&self.row, &mut self.file)
    }
}

impl<W: Write + Seek> Table<W> for Mf4<W> {
    fn into_inner(self: Box<Self>) -> io::Result<W> {
        let Self { mut file, group, records, start, .. } = *self;
        file.group(&group, records)?;
        file.finish(start.unwrap_or_default())
    }
}
