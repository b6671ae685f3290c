//! What must hold of any bytes that are read from outside: no panic, no endless loop, an error with words, and what is taken is
//! sound. Both who mutate with a grammar (`tests/formats/fuzz`) and who are guided by coverage (`tests/fuzz`) ask it.

pub mod config;
pub mod dbc;
pub mod recording;
pub mod state;

use gripd::fmu::foreign::Description;
use gripd::model::Scenario;
use gripd::tire_file::{AtLoad, TireFile};

/// Reads these bytes, and panics where something of that does not hold.
pub type Reader = fn(&[u8]);

/// All of them, by name.
pub const READERS: [(&str, Reader); 7] = [
    ("recording", recording::check),
    ("dbc", dbc::check),
    ("config", config::check),
    ("state", |contents| state::check(&state::sealed(contents))),
    ("scenario", scenario),
    ("tires", tires),
    ("fmu", fmu),
];

/// A scenario of `gripd simulate`.
pub fn scenario(bytes: &[u8]) {
    if let Err(error) = Scenario::parse(&String::from_utf8_lossy(bytes)) {
        assert!(!error.to_string().is_empty());
    }
}

/// Tires (.tir): those that are taken have numbers at each load.
pub fn tires(bytes: &[u8]) {
    let file = match TireFile::parse(&String::from_utf8_lossy(bytes), "fuzz.tir") {
        Ok(file) => file,
        Err(error) => return assert!(error.to_string().contains("fuzz.tir"), "{error}"),
    };
    let [least, most] = file.loads();
    for share in 0..=4 {
        match file.at(least + 0.25 * f64::from(share) * (most - least)) {
            Ok(tire) => {
                let AtLoad { shape, curvature, friction, lateral_stiffness, longitudinal_stiffness } = tire;
                let numbers =
                    [shape, curvature, friction, lateral_stiffness, longitudinal_stiffness.unwrap_or(1.0)];
                assert!(numbers.iter().all(|number| number.is_finite()), "{tire:?}");
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

/// What a foreign FMU says of itself.
pub fn fmu(bytes: &[u8]) {
    if let Err(error) = Description::parse(&String::from_utf8_lossy(bytes)) {
        assert!(!error.is_empty());
    }
}
