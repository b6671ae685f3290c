//! Versions: of FMI, and of what is built together.

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
