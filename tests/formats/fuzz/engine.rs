//! The whole way: frames in, estimates, frames out.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use gripd::can::{CanId, Frame};
use gripd::service::{Engine, Sink};
use gripd::{Estimates, Sample};

use super::run::{Input, fuzz};
use testing::dice::Dice;
use testing::frames::{at, traffic};
use testing::sound::sound;
use testing::{demo_car as car, heard};

/// Engines after 0, 5, 10 … seconds of good driving, and how many frames that were.
fn warmed_up() -> &'static [(Engine, usize)] {
    static ENGINES: OnceLock<Vec<(Engine, usize)>> = OnceLock::new();
    ENGINES.get_or_init(|| {
        let mut engine = car::engine(&car::config()).with_thesis();
        let mut engines = Vec::new();
        for (number, frame) in car::drive().iter().enumerate() {
            if number % 1750 == 0 {
                engines.push((engine.clone(), number));
            }
            engine.frame(frame, &mut Watch::default());
        }
        engines
    })
}

/// Looks at all that comes out.
#[derive(Default)]
struct Watch {
    counters: BTreeMap<CanId, u8>,
    round: Vec<Frame>,
}

impl Sink for Watch {
    fn estimates(&mut self, _: &Sample, estimates: &Estimates) {
        sound(estimates);
    }

    fn publish(&mut self, frame: &Frame) {
        let counter = heard::bits(frame, "Counter") as u8;
        if let Some(before) = self.counters.insert(frame.id, counter) {
            assert_eq!(counter, gripd::signals::e2e::next_counter(before));
        }
        self.round.clear();
        self.round.push(*frame);
        heard::protected(&self.round);
    }
}

/// A stretch of spoiled traffic after so much good driving.
struct Drive {
    engine: usize,
    frames: Vec<Frame>,
}

impl Input for Drive {
    fn bytes(&self) -> Vec<u8> {
        let good = &car::drive()[..warmed_up()[self.engine].1];
        [good, &self.frames].concat().bytes()
    }
}

fn drive(dice: &mut Dice) -> Drive {
    let engines = warmed_up();
    let engine = dice.below(engines.len());
    // Where it left off, or anywhere else.
    let from = if dice.once_in(4) { 0 } else { engines[engine].1 };
    let rest = &car::drive()[from..];
    let rest = if rest.len() > 2000 { &rest[..2000] } else { car::drive() };
    Drive { engine, frames: traffic(dice, rest) }
}

#[test]
fn drives() {
    fuzz("engine", 200, drive, |drive| {
        let mut engine = warmed_up()[drive.engine].0.clone();
        let mut watch = Watch::default();
        drive.frames.iter().for_each(|frame| engine.frame(frame, &mut watch));
        // Good driving afterwards: whatever came before is over.
        let good = &car::drive()[5000..6500];
        let Some(last) = drive.frames.last() else { return };
        let shift = last.time - good[0].time;
        for frame in good {
            engine.frame(&at(frame.time + shift, frame), &mut watch);
        }
        engine.finish(&mut watch);
        assert_eq!(engine.learned().problem(), None);
    });
}
