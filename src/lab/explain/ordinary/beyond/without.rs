//! What a model does wrong that lacks one of the findings, as numbers: where its yaw rate goes, and which tire gives too much.

use std::collections::BTreeMap;
use std::ops::Range;

use super::super::inputs::FreeDrive;
use super::super::numbers::placed;
use super::super::run::{Point, along};
use super::climb::State;
use super::colour::CHANNELS;
use super::rows::EVERY;
use crate::explain::result::{OffBy, Without};
use predict::car::Compute;

/// Hard turns of a drive: of its points those with so much lateral acceleration that this share has less, but for the last
/// few, which may be anything. Statistical.
const HARD: [f64; 2] = [0.90, 0.98];

/// A car that turns less does not turn, m/s². Physical: a motorway's curve.
const LEAST_TURNING: f64 = 0.5;

/// A yaw rate that is off by so much is that of a car that spins, rad/s. Physical: half a turn in two seconds.
const SLIDES: f64 = 1.5;

/// A drive's point in a turn.
struct InTurn {
    lateral: f64,
    speed: f64,
    /// Side force of each wheel with and without the finding at this motion, N: outer and inner front, outer and inner rear.
    with: [f64; 4],
    without: [f64; 4],
}

/// Of the first drive, by what one finding changes in each channel there.
pub(super) fn without(
    drives: &[FreeDrive],
    state: &State<'_>,
    own: &Range<usize>,
    changes: &[Vec<f64>; CHANNELS],
) -> Without {
    let Some(drive) = drives.first() else { return Without::default() };
    let turns = hard(in_turns(drive, state, own));
    let mean = |of: fn(&InTurn) -> f64| turns.iter().map(of).sum::<f64>() / turns.len().max(1) as f64;
    Without {
        yaw_rate: off_by(drive, &changes[0]),
        turning_mps2: mean(|turn| turn.lateral),
        turning_at_mps: mean(|turn| turn.speed),
        too_much_side_force: too_much(&turns),
    }
}

/// By how much the yaw rate is off, from the changes at each row; none where the car slides off.
fn off_by(drive: &FreeDrive, changes: &[f64]) -> Option<OffBy> {
    let known = || changes.iter().enumerate().filter(|(_, change)| change.is_finite());
    let (row, most) = known().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let square = known().map(|(_, change)| change * change).sum::<f64>() / known().count() as f64;
    (most.abs() < SLIDES).then(|| OffBy {
        rms: square.sqrt(),
        most: most.abs(),
        most_at_s: drive.time(row * EVERY),
    })
}

/// The points of a drive at which the car turns, with both cars' side forces there.
fn in_turns(drive: &FreeDrive, state: &State<'_>, own: &Range<usize>) -> Vec<InTurn> {
    let mut neutral = state.at.clone();
    for place in own.clone() {
        neutral[place] = state.free[place].prior.0;
    }
    let car = |at: &[f64]| {
        let (model, sensing) = placed(&state.model, &state.free, at, 0);
        (model.car(), sensing)
    };
    let ((with, sensing), (without, _)) = (car(&state.at), car(&neutral));
    let mut all = Vec::new();
    let mut row = 0;
    along(drive, &with, sensing, Compute::Motion, |point: &Point<'_>| {
        let counts = drive.counts[row] && row % EVERY == 0;
        row += 1;
        let lateral = point.now.felt.ay;
        if !counts || lateral.abs() < LEAST_TURNING {
            return;
        }
        let rate = point.steering_rate;
        let there =
            without.instant(point.t, point.state(), point.input, rate, point.before(), Compute::Rates);
        // In a turn to the left the right wheels are outside.
        let order = if lateral > 0.0 { [1, 0, 3, 2] } else { [0, 1, 2, 3] };
        let towards = |forces: [f64; 4]| order.map(|wheel: usize| lateral.signum() * forces[wheel]);
        all.push(InTurn {
            lateral: lateral.abs(),
            speed: point.state().body[0],
            with: towards(point.now.felt.fy),
            without: towards(there.felt.fy),
        });
    });
    all
}

/// The hard ones of them.
fn hard(mut all: Vec<InTurn>) -> Vec<InTurn> {
    all.sort_by(|a, b| a.lateral.total_cmp(&b.lateral));
    let [from, to] = HARD.map(|share| (share * all.len() as f64) as usize);
    all.into_iter().take(to.max(from + 1)).skip(from).collect()
}

/// By which share side forces are too large without the finding.
fn too_much(turns: &[InTurn]) -> BTreeMap<String, f64> {
    const PARTS: [(&str, &[usize]); 6] = [
        ("front_outer", &[0]),
        ("front_inner", &[1]),
        ("front", &[0, 1]),
        ("rear_outer", &[2]),
        ("rear_inner", &[3]),
        ("rear", &[2, 3]),
    ];
    let of = |(name, wheels): (&str, &[usize])| {
        let sum = |of: fn(&InTurn) -> &[f64; 4]| -> f64 {
            turns.iter().flat_map(|turn| wheels.iter().map(move |wheel| of(turn)[*wheel])).sum()
        };
        let share = sum(|turn| &turn.without) / sum(|turn| &turn.with) - 1.0;
        share.is_finite().then(|| (name.to_owned(), share))
    };
    PARTS.into_iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// GIVEN a model whose outer front tire gives a tenth too much, and whose inner one too little THEN the axle is in between.
    #[test]
    fn the_share_is_of_each_tire_and_of_the_axle() {
        let turn = InTurn {
            lateral: 6.0,
            speed: 15.0,
            with: [4000.0, 2000.0, 3000.0, 2000.0],
            without: [4400.0, 1800.0, 3000.0, 2000.0],
        };
        let all = too_much(&[turn]);
        let is = |name: &str, expected: f64| (all[name] - expected).abs() < 1e-12;
        assert!(is("front_outer", 0.1) && is("front_inner", -0.1) && is("front", 200.0 / 6000.0), "{all:?}");
        assert!(is("rear", 0.0));
    }

    #[test]
    fn hard_turns_are_neither_the_gentle_ones_nor_the_last_few() {
        let of = |lateral: f64| InTurn { lateral, speed: 10.0, with: [1.0; 4], without: [1.0; 4] };
        let hard = hard((0..100).map(|i| of(f64::from(i))).collect());
        assert_eq!((hard.len(), hard[0].lateral, hard[7].lateral), (8, 90.0, 97.0));
    }
}
