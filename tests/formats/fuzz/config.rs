//! Configurations: refused with the place named, or good for an engine that works.

use super::mutate::Mutator;
use super::run::{contents, fuzz, known};
use testing::hostile::config::check;

const WORDS: [&str; 24] = [
    "[vehicle]\n",
    "[signals]\n",
    "[publish]\n",
    "[publish.ids]\n",
    "[[effect]]\n",
    "[estimators]\n",
    "[signals.sampling]\n",
    "[service]\n",
    "gain = ",
    "offset = ",
    "std = ",
    "delay_ms = ",
    "timeout_ms = ",
    "not_available = [1, 2]",
    "valid_when = ",
    "period_ms = ",
    "{ value = 1.0, std = 0.1 }",
    "\"WHEELS.SpeedFL\"",
    "\"INERTIAL.Crc\"",
    "kind = \"load_transfer\"\n",
    "kind = \"sensor_delay\"\n",
    "true",
    "[",
    "interpolate = true",
];

#[test]
fn configurations() {
    known("toml", check);
    let mutator = Mutator { seeds: &contents("toml"), words: &WORDS, longest: 20_000 };
    fuzz("toml", 400, |dice| mutator.make(dice), |toml| check(toml));
}
