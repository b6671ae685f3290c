//! The `[publish]` table.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::can::CanId;

/// The `[publish]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PublishConfig {
    /// Publish at all?
    pub enabled: bool,
    /// Time between two rounds of frames, ms, 1–10000.
    pub period_ms: u32,
    /// Interface to publish on; the one of `[bus]` if it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interface: Option<String>,
    /// Messages to publish; all that the output DBC has if it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub messages: Option<Vec<String>>,
    /// Identifiers to use in place of the output DBC's.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub ids: BTreeMap<String, IdConfig>,
}

impl Default for PublishConfig {
    fn default() -> Self {
        Self { enabled: true, period_ms: 20, interface: None, messages: None, ids: BTreeMap::new() }
    }
}

/// An identifier: a number, extended if it is above 0x7FF, or `{ id = 0x123, extended = true }`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "an identifier such as 0x6A0, or { id = 0x123, extended = true }")]
pub enum IdConfig {
    /// Just the number; above 0x7FF it is an extended identifier.
    Number(u32),
    /// The number, and whether it is an extended identifier.
    Explicit(ExplicitId),
}

/// An identifier whose kind is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExplicitId {
    /// The number.
    pub id: u32,
    /// 29 bits rather than 11.
    pub extended: bool,
}

impl IdConfig {
    /// The identifier; `None` if it does not fit its kind.
    pub fn id(self) -> Option<CanId> {
        match self {
            Self::Number(id) => CanId::standard(id).or_else(|| CanId::extended(id)),
            Self::Explicit(ExplicitId { id, extended: false }) => CanId::standard(id),
            Self::Explicit(ExplicitId { id, extended: true }) => CanId::extended(id),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_of_both_kinds() {
        let config: PublishConfig = toml::from_str(
            "period_ms = 10\n[ids]\nA = 0x6A0\nB = 0x18FF0000\nC = { id = 0x123, extended = true }\nD = { id = 0x800, extended = false }\n",
        )
        .unwrap();
        let id = |name: &str| config.ids[name].id();
        assert_eq!(id("A"), CanId::standard(0x6A0));
        assert_eq!(id("B"), CanId::extended(0x18FF_0000));
        assert_eq!(id("C"), CanId::extended(0x123));
        assert_eq!(id("D"), None);
        assert_eq!((config.period_ms, config.enabled), (10, true));
    }

    #[test]
    fn unknown_keys_and_wrong_kinds_are_errors() {
        assert!(toml::from_str::<PublishConfig>("periode_ms = 10").is_err());
        assert!(toml::from_str::<PublishConfig>("ids = { A = { id = 1, extendet = true } }").is_err());
        let error = toml::from_str::<PublishConfig>("ids = { A = \"0x6A0\" }").unwrap_err();
        assert!(error.to_string().contains("an identifier such as 0x6A0"), "{error}");
    }
}
