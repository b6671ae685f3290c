//! How far a long fit is, from what it has computed so far.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is done of a fit, and what it will be at most, in grid points that are searched by. Recordings share it with the one
/// who waits; it may be counted from any thread.
#[derive(Clone, Debug, Default)]
pub struct Work(Arc<Counts>);

#[derive(Debug, Default)]
struct Counts {
    done: AtomicU64,
    expected: AtomicU64,
}

impl Work {
    /// A fit begins that takes so much.
    pub fn begin(&self, expected: usize) {
        self.0.done.store(0, Ordering::Relaxed);
        self.0.expected.store(expected as u64, Ordering::Relaxed);
    }

    /// It turns out to take so much more.
    pub fn expect(&self, more: usize) {
        self.0.expected.fetch_add(more as u64, Ordering::Relaxed);
    }

    /// So much more of it is done.
    pub fn add(&self, done: usize) {
        self.0.done.fetch_add(done as u64, Ordering::Relaxed);
    }

    /// The share that is done, 0 to 1; none before anything was counted.
    pub fn share(&self) -> Option<f64> {
        let [done, expected] = [&self.0.done, &self.0.expected].map(|count| count.load(Ordering::Relaxed));
        (expected > 0 && done > 0).then(|| (done as f64 / expected as f64).min(1.0))
    }
}
