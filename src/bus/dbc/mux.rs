//! Multiplexing: which signals a frame carries depends on selector signals in the same frame.

use std::sync::Arc;

use super::extract::Extractor;

/// One selector and the raw values of it that switch a signal on.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// The selector's bits.
    pub selector: Extractor,
    /// Inclusive ranges.
    pub ranges: Vec<(u64, u64)>,
}

/// When a signal is in the frame: always, or while every selector in its chain has a right value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mux {
    /// From the nearest selector to the outermost; shared by clones of the signal.
    conditions: Option<Arc<[Condition]>>,
}

impl Mux {
    /// From the nearest selector to the outermost.
    pub fn new(conditions: Vec<Condition>) -> Self {
        Self { conditions: if conditions.is_empty() { None } else { Some(conditions.into()) } }
    }

    /// Is the signal in every frame?
    #[inline]
    pub fn is_always(&self) -> bool {
        self.conditions.is_none()
    }

    /// Is the signal in this frame? A payload too short for a selector says no.
    #[inline]
    pub fn is_active(&self, data: &[u8]) -> bool {
        match &self.conditions {
            None => true,
            Some(conditions) => conditions.iter().all(|condition| {
                condition.selector.get(data).is_some_and(|value| {
                    condition.ranges.iter().any(|&(low, high)| low <= value && value <= high)
                })
            }),
        }
    }

    /// The conditions, nearest selector first; empty if the signal is in every frame.
    pub fn conditions(&self) -> &[Condition] {
        self.conditions.as_deref().unwrap_or_default()
    }
}
