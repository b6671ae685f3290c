//! What is fitted to and what is kept for the proof: fixed before anything is looked at.

use super::predict::Drive;

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
    /// Of each drive: its blocks' length, s, and which blocks are held out.
    drives: Vec<(f64, Held)>,
    /// Blocks that were given to the training part all the same: drive and number.
    released: Vec<(usize, usize)>,
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
pub const BLOCK_S: f64 = 20.0;

impl Split {
    /// Of drives, the last `held_out` of which the user has set apart. Without any, every third block of
    /// each is held out; of drives shorter than two blocks, every third drive.
    pub fn new(drives: &[Drive], held_out: usize) -> Self {
        let first_held = drives.len() - held_out.min(drives.len());
        let is_short = |drive: &Drive| drive.seconds() < 2.0 * BLOCK_S;
        let all_short = drives.len() > 2 && drives.iter().all(is_short);
        let of = |(number, drive): (usize, &Drive)| {
            let length = if drive.seconds() < 3.0 * BLOCK_S { drive.seconds() / 3.0 } else { BLOCK_S };
            let held = match (held_out > 0, all_short) {
                (true, _) if number >= first_held => Held::Everything,
                (true, _) => Held::Nothing,
                (false, true) if number % 3 == 2 => Held::Everything,
                (false, true) => Held::Nothing,
                (false, false) => Held::EveryThird,
            };
            (length, held)
        };
        Self { drives: drives.iter().enumerate().map(of).collect(), released: Vec::new() }
    }

    /// Is this instant of a drive held out?
    pub fn is_held_out(&self, drive: usize, t: f64) -> bool {
        match self.drives.get(drive) {
            Some((length, Held::EveryThird)) => {
                let block = (t / length) as usize;
                block % 3 == 2 && !self.released.contains(&(drive, block))
            }
            Some((_, held)) => *held == Held::Everything,
            None => false,
        }
    }

    /// The split with every held-out block within some seconds of an instant given to the training part:
    /// when something began can only be learnt where it began. None, if there is no such block.
    pub fn released(&self, t: f64, within_s: f64) -> Option<Self> {
        let mut split = self.clone();
        for (drive, (length, held)) in self.drives.iter().enumerate() {
            let blocks = [t - within_s, t, t + within_s].map(|t| (t.max(0.0) / length) as usize);
            for block in blocks {
                let is_held = *held == Held::EveryThird && block % 3 == 2;
                if is_held && !split.released.contains(&(drive, block)) {
                    split.released.push((drive, block));
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
        let length = self.drives.get(drive).map_or(BLOCK_S, |(length, _)| length.max(1.0));
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
