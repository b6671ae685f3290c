//! What the process and the engine hold.

use std::fmt;
use testing::allocator::{Asked, asked_by};

/// What the engine asked of the allocator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// Requests while frames went through.
    pub requests: u64,
    /// Bytes held since the first stretch, less those given back.
    pub grown_bytes: i64,
    /// Resident memory of the process after the first hour (or stretch), and at the end, KiB.
    pub resident: [u64; 2],
}

impl Memory {
    /// A frame: none at all.
    pub fn frame(&mut self, work: impl FnOnce()) {
        let Asked { requests, bytes } = asked_by(work);
        self.requests += requests;
        self.grown_bytes += bytes;
    }

    /// A reload or a restart: gives back what it takes.
    pub fn exchange(&mut self, work: impl FnOnce()) {
        self.grown_bytes += asked_by(work).bytes;
    }
}

impl fmt::Display for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [early, late] = self.resident.map(|kib| kib as f64 / 1024.0);
        write!(
            f,
            "the engine asked {} times for memory and holds {} bytes more than at first; the process {early:.0} MB \
             early, {late:.0} MB at the end",
            self.requests, self.grown_bytes
        )
    }
}

/// Resident memory of this process, KiB.
pub fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
