//! The simulated car as an FMU (Functional Mock-up Interface, [fmi-standard.org](https://fmi-standard.org), 2.0 and 3.0,
//! co-simulation), and FMUs of other programs.
//!
//! ```text
//! Car ─► variables ─► description ─► export ─► archive: modelDescription.xml, resources/car.toml, binaries/…/gripd.so
//!                                                            │                    │
//! importing program ◄─► abi (this crate as a library) ◄─► instance ◄──────────────┘
//! ```
//!
//! The crate is built twice: as a part of the program, which writes archives, and as the library that lies in every
//! archive. No compiler is needed to export a car: the library finds it in the resources.

pub mod abi;
pub mod car;
pub mod description;
pub mod export;
pub mod foreign;
pub mod instance;
mod quantities;
pub mod variables;

use std::fmt;
use std::str::FromStr;

/// Versions of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// 2.0.
    Two,
    /// 3.0.
    Three,
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Two => "2.0",
            Self::Three => "3.0",
        })
    }
}

impl FromStr for Version {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "2" | "2.0" => Ok(Self::Two),
            "3" | "3.0" => Ok(Self::Three),
            _ => Err("the versions are 2 and 3".into()),
        }
    }
}

/// Stands in the library, so that a program finds out whether it is its own.
pub const MARK: &str = concat!("gripd FMU library ", env!("CARGO_PKG_VERSION"));
