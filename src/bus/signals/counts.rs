//! How often each fault occurred.

use std::fmt;

use physics::Faults;

/// Occurrences of each fault since the start. Conditions that last (a time-out, a stuck sensor) count
/// once each time they begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaultCounts([u64; Faults::COUNT]);

impl FaultCounts {
    /// Counts every fault in the set once.
    #[inline]
    pub fn record(&mut self, faults: Faults) {
        let mut bits = (faults & Faults::all()).bits();
        while bits != 0 {
            self.0[bits.trailing_zeros() as usize] += 1;
            bits &= bits - 1;
        }
    }

    /// Occurrences of one fault; of several, their sum.
    pub fn get(&self, faults: Faults) -> u64 {
        (0..Faults::COUNT).filter(|bit| faults.bits() & (1 << bit) != 0).map(|bit| self.0[bit]).sum()
    }

    /// What was counted here and there.
    pub fn plus(mut self, other: &Self) -> Self {
        for (count, more) in self.0.iter_mut().zip(other.0) {
            *count += more;
        }
        self
    }

    /// Every fault that occurred, by its name in `--stats`, in bit order.
    pub fn iter(&self) -> impl Iterator<Item = (String, u64)> + '_ {
        Faults::all().iter_names().filter_map(|(name, fault)| {
            let count = self.get(fault);
            (count > 0).then(|| (name.to_ascii_lowercase(), count))
        })
    }
}

/// As in `timeout 2, checksum 1`; `none` if there were none.
impl fmt::Display for FaultCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all: Vec<_> = self.iter().map(|(name, count)| format!("{name} {count}")).collect();
        if all.is_empty() { f.write_str("none") } else { f.write_str(&all.join(", ")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_of_a_set_is_counted_and_named() {
        let mut counts = FaultCounts::default();
        assert_eq!(counts.to_string(), "none");
        counts.record(Faults::TIMEOUT | Faults::CONFIG);
        counts.record(Faults::TIMEOUT);
        assert_eq!(counts.to_string(), "timeout 2, config 1");
        assert_eq!(counts.get(Faults::TIMEOUT | Faults::CONFIG), 3);
    }
}
