//! DBC files, and payloads for what they describe.

use std::sync::OnceLock;

use gripd::dbc::Database;

use super::mutate::Mutator;
use super::run::{contents, fuzz, known};
use testing::dice::Dice;
use testing::hostile::dbc::{check, decode_one};

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

#[test]
fn files() {
    known("dbc", check);
    let mutator = Mutator { seeds: &contents("dbc"), words: &WORDS, longest: 8000 };
    fuzz("dbc", 400, |dice| mutator.make(dice), |text| check(text));
}

#[test]
fn payloads() {
    static DATABASES: OnceLock<Vec<Database>> = OnceLock::new();
    let databases = DATABASES.get_or_init(|| {
        contents("dbc").iter().filter_map(|text| Database::parse(text, "corpus").ok()).collect()
    });
    fuzz("payloads", 20_000, Dice::draw, |seed| {
        let mut dice = Dice::new("payloads", *seed, 0);
        let database = dice.of(databases);
        let message = dice.of(database.messages());
        let length = *dice.of(&[message.length, message.length, 64, message.length / 2, 0]);
        decode_one(message, length, &mut dice);
    });
}
