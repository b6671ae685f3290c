//! Scenarios, tires, and descriptions of FMUs.

use testing::hostile::{fmu, scenario, tires};
use testing::program::project;

use super::mutate::Mutator;
use super::run::{contents, fuzz, known};

/// Mutations of these files.
fn run(name: &str, seeds: &[Vec<u8>], words: &[&str], check: fn(&[u8])) {
    let mutator = Mutator { seeds, words, longest: 30_000 };
    fuzz(name, 2000, |dice| mutator.make(dice), |bytes| check(bytes));
}

#[test]
fn scenarios() {
    let demo = std::fs::read(project("config/scenarios/demo.toml")).unwrap();
    let words = [
        "[[road]]\n",
        "[[effect]]\n",
        "kind = ",
        "points = [",
        "-1e308",
        "inf",
        "0.0",
        "[sensors.yaw_rate]\n",
        "]",
    ];
    run("scenario", &[demo], &words, scenario);
}

#[test]
fn tire_files() {
    known("tires", tires);
    let words = ["[UNITS]\n", "ANGLE = 'degree'", "$", "PKY1 = ", "FNOMIN = ", "-0", "1e308", "nan", "'"];
    run("tires", &contents("tires"), &words, tires);
}

#[test]
fn descriptions_of_fmus() {
    known("fmu", fmu);
    let words = [
        "<Float64 name=\"",
        "<ScalarVariable ",
        "</",
        "causality=\"input\"",
        "<!DOCTYPE ",
        "&lt;",
        "start=\"",
        "valueReference=\"-1\"",
        "declaredType=\"",
    ];
    run("fmu", &contents("fmu"), &words, fmu);
}
