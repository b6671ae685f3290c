//! Configurations.

use std::path::Path;
use std::sync::OnceLock;

use gripd::dbc::Database;
use gripd::service::Engine;
use gripd::service::saved::{fingerprint, parse, text};
use gripd::signals::publish::built_in_database;
use gripd::{Config, Quantity};

use crate::{demo_car as car, heard};

fn databases() -> &'static [Database; 2] {
    static BOTH: OnceLock<[Database; 2]> = OnceLock::new();
    BOTH.get_or_init(|| [car::config().input_database().unwrap(), built_in_database().unwrap()])
}

/// An error names the file; what is accepted works for three seconds of driving, and what it has learned then can
/// be kept.
pub fn check(toml: &[u8]) {
    let toml = String::from_utf8_lossy(toml);
    let config = match Config::parse(&toml, Path::new("/etc/gripd/fuzz.toml")) {
        Ok(config) => config.corrected(),
        Err(error) => return assert!(error.to_string().contains("fuzz.toml"), "{error}"),
    };
    let [input, output] = databases();
    let mut engine = match Engine::with_databases(&config, input, output) {
        Ok(engine) => engine,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let mut heard = heard::Heard::default();
    car::drive()[..1000].iter().for_each(|frame| engine.frame(frame, &mut heard));
    engine.finish(&mut heard);
    for sample in &heard.samples {
        assert!(Quantity::ALL.iter().all(|q| sample.get(*q).is_none_or(f64::is_finite)), "{sample:?}");
    }
    let learned = engine.learned();
    let kept = text(&learned, &fingerprint(&config)).unwrap();
    assert_eq!(parse(kept.as_bytes(), &fingerprint(&config)).unwrap(), learned);
}
