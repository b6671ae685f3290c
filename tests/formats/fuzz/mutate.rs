//! Makes bad input of good input: bytes as a broken disk or wire would, lines, words and numbers as people would.

use testing::dice::Dice;

/// Numbers that programs stumble over.
const NUMBERS: [&str; 28] = [
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "7",
    "8",
    "15",
    "63",
    "64",
    "65",
    "255",
    "256",
    "511",
    "65535",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "1e308",
    "-1e308",
    "1e309",
    "1e-320",
    "nan",
    "inf",
    "0.5",
    "99999999999999999999999999999999999999",
];

pub struct Mutator<'a> {
    pub seeds: &'a [Vec<u8>],
    /// Words of the grammar.
    pub words: &'a [&'a str],
    /// Bytes that an input may have.
    pub longest: usize,
}

impl Mutator<'_> {
    /// One of the seeds with a few changes.
    pub fn make(&self, dice: &mut Dice) -> Vec<u8> {
        let mut text = dice.of(self.seeds).clone();
        for _ in 0..=dice.length(8) {
            self.change(dice, &mut text);
        }
        text.truncate(self.longest);
        text
    }

    fn change(&self, dice: &mut Dice, text: &mut Vec<u8>) {
        let place = dice.below(text.len() + 1);
        match dice.below(14) {
            0 => with(text, place, |byte| *byte ^= 1 << dice.below(8)),
            1 => with(text, place, |byte| *byte = dice.draw() as u8),
            2 => text.insert(place, dice.draw() as u8),
            3 => drop(text.drain(place..(place + dice.length(64)).min(text.len()))),
            4 => {
                let piece = text[place..(place + dice.length(64)).min(text.len())].to_vec();
                insert(text, dice.below(text.len() + 1), &piece);
            }
            5 => {
                let other = dice.of(self.seeds);
                let from = dice.below(other.len());
                let piece = &other[from..(from + dice.length(256)).min(other.len())];
                insert(text, place, piece);
            }
            6..=8 => replace_number(dice, text, place),
            9 => {
                let word = dice.of(self.words);
                insert(text, place, word.as_bytes());
            }
            10 => with_lines(text, |lines| {
                let (one, other) = (dice.below(lines.len()), dice.below(lines.len()));
                lines.swap(one, other);
            }),
            11 => with_lines(text, |lines| drop(lines.remove(dice.below(lines.len())))),
            12 => with_lines(text, |lines| {
                let line = dice.of(lines).clone();
                lines.insert(dice.below(lines.len()), line);
            }),
            _ => {
                let byte = *dice.of(b"[{(\"0 \n.#,=-");
                insert(text, place, &vec![byte; dice.length(2000)]);
            }
        }
    }
}

fn with(text: &mut [u8], place: usize, change: impl FnOnce(&mut u8)) {
    if let Some(byte) = text.get_mut(place) {
        change(byte);
    }
}

fn insert(text: &mut Vec<u8>, place: usize, piece: &[u8]) {
    text.splice(place..place, piece.iter().copied());
}

fn with_lines(text: &mut Vec<u8>, change: impl FnOnce(&mut Vec<Vec<u8>>)) {
    let mut lines: Vec<Vec<u8>> = text.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    change(&mut lines);
    *text = lines.join(&b'\n');
}

/// The next number after a place becomes another one: often of another size, else one to stumble over.
fn replace_number(dice: &mut Dice, text: &mut Vec<u8>, place: usize) {
    let is_number = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
    let Some(start) = text[place..].iter().position(is_number).map(|found| place + found) else { return };
    let end =
        text[start..].iter().position(|byte| !is_number(byte)).map_or(text.len(), |found| start + found);
    let was = std::str::from_utf8(&text[start..end]).ok().and_then(|number| number.parse::<f64>().ok());
    let number = match was.filter(|_| dice.once_in(2)) {
        Some(was) => format!("{}", was * 10f64.powi(dice.below(9) as i32 - 4)),
        None => (*dice.of(&NUMBERS)).to_owned(),
    };
    text.splice(start..end, number.bytes());
}
