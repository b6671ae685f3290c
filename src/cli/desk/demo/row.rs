//! What the demo keeps of each round.

use bus::watch::Round;

/// A round, and what is not published but worth comparing with.
pub struct Row {
    /// From the frames.
    pub round: Round,
    /// Lateral velocity by the bicycle model, m/s.
    pub bicycle: f64,
}
