//! Which recordings can be used, and for what.

use super::answer::Asked;
use super::inputs::{FreeDrive, Held};
use physics::model::Vehicle;
use predict::Recording;

/// Of all recordings together so many seconds are run, of each at least so many: a fit takes some seconds of computing
/// for a minute of driving, and tires do not change.
pub(super) const MOST_S: f64 = 600.0;
const LEAST_OF_EACH_S: f64 = 60.0;

/// Recordings that can be used.
pub(super) struct Drives {
    pub drives: Vec<FreeDrive>,
    /// So many of them, the first ones, are references.
    pub references: usize,
    /// Recordings and parts of them that cannot, and why.
    pub left_out: Vec<String>,
}

impl Drives {
    /// None without one, or without one beside its references.
    pub fn of(own: &Vehicle, recordings: &[Recording], asked: Asked<'_>) -> Option<Self> {
        let first_held = recordings.len() - asked.held_out.min(recordings.len());
        let most_s = (MOST_S / recordings.len().max(1) as f64).max(LEAST_OF_EACH_S);
        let mut all = Self { drives: Vec::new(), references: 0, left_out: Vec::new() };
        for (number, recording) in recordings.iter().enumerate() {
            let is_reference = number < asked.references;
            let held = match asked.held_out {
                _ if is_reference => Held::Nothing,
                0 => Held::EveryThird,
                _ if number >= first_held => Held::Everything,
                _ => Held::Nothing,
            };
            match FreeDrive::new(recording, own, held, most_s) {
                Ok(drive) => {
                    all.left_out.extend(drive.frozen.iter().map(|[from, to]| {
                        format!(
                            "{}, {from:.1} to {to:.1} s: the steering angle stays the same, though the car turns otherwise",
                            recording.name
                        )
                    }));
                    all.references += usize::from(is_reference);
                    all.drives.push(drive);
                }
                Err(why) => all.left_out.push(format!("{}: {why}", recording.name)),
            }
        }
        let has_both = all.drives.len() > all.references && (asked.references == 0 || all.references > 0);
        has_both.then_some(all)
    }
}
