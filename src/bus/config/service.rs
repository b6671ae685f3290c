//! The `[service]` table.

use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;

use serde::Deserialize;

/// `[service]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ServiceConfig {
    /// A line with counts goes to the log this often, s; 0: never.
    pub report_every_s: u64,
    /// Where what was learned is kept between drives, relative to the configuration. Default: `learned.toml`
    /// in systemd's `STATE_DIRECTORY`, if there is one; `""`: nowhere.
    pub state_file: Option<PathBuf>,
    /// It is written after so many seconds of driving, and at the end, s; 0: at the end only.
    pub state_every_s: u64,
    /// Where Prometheus can read counts: the path of a Unix socket, relative to the configuration, or
    /// `127.0.0.1:PORT`. Default: nowhere.
    pub metrics: Option<Address>,
    /// Where the frames around each new fault and each change of surface are kept, relative to the configuration: a
    /// folder of this service's own. Default, or `""`: nowhere.
    pub record_faults: Option<PathBuf>,
    /// So many of these recordings at most; the oldest go first.
    pub record_files: u64,
    /// So many bytes of them at most.
    pub record_bytes: u64,
    /// Keep all memory in RAM: no page is waited for while a frame is handled.
    pub lock_memory: bool,
}

impl Default for ServiceConfig {
    fn default() -> Self {
        Self {
            report_every_s: 60,
            state_file: None,
            state_every_s: 60,
            metrics: None,
            record_faults: None,
            record_files: 50,
            record_bytes: 20_000_000,
            lock_memory: false,
        }
    }
}

/// A place for others of this machine only.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub enum Address {
    /// A socket in the file system; whoever may open it may read.
    Unix(PathBuf),
    /// A port of the loopback interface.
    Loopback(SocketAddr),
}

impl TryFrom<String> for Address {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        match text.parse::<SocketAddr>() {
            Ok(address) if address.ip().is_loopback() => Ok(Self::Loopback(address)),
            Ok(_) => {
                Err(format!("`{text}` can be reached from outside: name a Unix socket, or 127.0.0.1:PORT"))
            }
            Err(_) if text.is_empty() => Err("an empty path: leave the key out to have no endpoint".into()),
            Err(_) => Ok(Self::Unix(text.into())),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unix(path) => path.display().fmt(f),
            Self::Loopback(address) => address.fmt(f),
        }
    }
}
