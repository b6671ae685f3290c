//! The split into training and held-out blocks. It is fixed before any model is fitted.

use predict::GriddedDrive;

/// A part of the recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// What numbers are fitted to and causes are chosen by.
    Train,
    /// What is only predicted.
    Holdout,
}

/// Which stretches of the recordings belong to which part.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// Of each drive.
    drives: Vec<Blocks>,
    /// Blocks that were given to the training part all the same (drive and number)…
    released: Vec<(usize, usize)>,
    /// …and blocks that are held out in their place.
    instead: Vec<(usize, usize)>,
}

/// The blocks of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Blocks {
    /// Of each, s.
    length: f64,
    count: usize,
    held: Held,
}

/// What is held out of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Held {
    Nothing,
    Everything,
    /// Every third block, beginning with the third.
    EveryThird,
}

/// Blocks are so long, s, as the free simulation's are.
/// The free simulation's is the contract's.
pub const BLOCK_S: f64 = 20.0;

impl Split {
    /// Of drives, the last `held_out` of which the user has set apart. Without any, every third block of
    /// each is held out; of drives shorter than two blocks, every third drive.
    pub fn new(drives: &[GriddedDrive], held_out: usize) -> Self {
        let first_held = drives.len() - held_out.min(drives.len());
        let is_short = |drive: &GriddedDrive| drive.seconds() < 2.0 * BLOCK_S;
        let all_short = drives.len() > 2 && drives.iter().all(is_short);
        let of = |(number, drive): (usize, &GriddedDrive)| {
            let length = if drive.seconds() < 3.0 * BLOCK_S { drive.seconds() / 3.0 } else { BLOCK_S };
            let held = match (held_out > 0, all_short) {
                (true, _) if number >= first_held => Held::Everything,
                (true, _) => Held::Nothing,
                (false, true) if number % 3 == 2 => Held::Everything,
                (false, true) => Held::Nothing,
                (false, false) => Held::EveryThird,
            };
            Blocks { length, count: (drive.seconds() / length).round() as usize, held }
        };
        Self {
            drives: drives.iter().enumerate().map(of).collect(),
            released: Vec::new(),
            instead: Vec::new(),
        }
    }

    /// Is this instant of a drive held out?
    pub fn is_held_out(&self, drive: usize, t: f64) -> bool {
        match self.drives.get(drive) {
            Some(Blocks { length, held: Held::EveryThird, .. }) => {
                let block = (t / length) as usize;
                let of_drive = (drive, block);
                block % 3 == 2 && !self.released.contains(&of_drive) || self.instead.contains(&of_drive)
            }
            Some(blocks) => blocks.held == Held::Everything,
            None => false,
        }
    }

    /// The split with every held-out block within some seconds of an instant given to the training part:
    /// when something began can only be learnt where it began. The block after it is held out in its place.
    /// None, if there is no such block.
    pub fn released(&self, t: f64, within_s: f64) -> Option<Self> {
        let mut split = self.clone();
        for (drive, blocks) in self.drives.iter().enumerate() {
            let length = blocks.length;
            let near = [t - within_s, t, t + within_s].map(|t| (t.max(0.0) / length) as usize);
            for block in near {
                if self.is_held_out(drive, (block as f64 + 0.5) * length)
                    && !split.released.contains(&(drive, block))
                {
                    split.released.push((drive, block));
                    split.instead.retain(|other| *other != (drive, block));
                    let after = (block + 1..blocks.count).find(|other| !near.contains(other));
                    let other = after.or_else(|| (0..block).rev().find(|other| !near.contains(other)));
                    split.instead.extend(other.map(|other| (drive, other)));
                }
            }
        }
        (split != *self).then_some(split)
    }

    /// Does it belong to this part?
    pub fn counts(&self, part: Part, drive: usize, t: f64) -> bool {
        self.is_held_out(drive, t) == (part == Part::Holdout)
    }

    /// All blocks of a drive of so many seconds: from, to, held out.
    pub fn blocks(&self, drive: usize, seconds: f64) -> Vec<(f64, f64, bool)> {
        let length = self.drives.get(drive).map_or(BLOCK_S, |blocks| blocks.length.max(1.0));
        let count = (seconds / length).ceil() as usize;
        (0..count)
            .map(|i| {
                let from = i as f64 * length;
                let to = (from + length).min(seconds);
                (from, to, self.is_held_out(drive, 0.5 * (from + to)))
            })
            .filter(|(from, to, _)| to - from > 0.5)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_block_in_which_something_began_changes_places_with_the_next() {
        let of = |count| Split {
            drives: vec![Blocks { length: 20.0, count, held: Held::EveryThird }],
            released: Vec::new(),
            instead: Vec::new(),
        };
        let split = of(5);
        assert!(split.is_held_out(0, 50.0) && !split.is_held_out(0, 70.0));
        assert!(split.released(30.0, 3.0).is_none());
        let released = split.released(50.0, 3.0).expect("the block is held out");
        assert!(!released.is_held_out(0, 50.0) && released.is_held_out(0, 70.0));
        assert!(released.released(50.0, 3.0).is_none());
        // At the border both sides are needed.
        let at_border = split.released(59.0, 3.0).expect("the block is held out");
        assert!(
            !at_border.is_held_out(0, 50.0)
                && !at_border.is_held_out(0, 61.0)
                && at_border.is_held_out(0, 90.0)
        );
        // Behind the last block there is none; the one before is held out instead.
        let short = of(3).released(50.0, 3.0).expect("the block is held out");
        assert!(!short.is_held_out(0, 50.0) && short.is_held_out(0, 30.0));
    }
}
