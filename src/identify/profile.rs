//! The profile likelihood of a parameter: how much worse everything fits where it is held elsewhere, the others being
//! fitted again.

use std::collections::VecDeque;

use super::fit::{Fit, Search};
use super::normal_equations::Point;

/// Where it is computed, in standard deviations from the optimum: the last ones for profiles that are flatter than
/// their curvature at the optimum.
const AT: [f64; 5] = [1.0, 2.0, 3.0, 5.0, 9.0];
/// Further than this it need not go: twice the limit of a 95 % interval.
const FAR_ENOUGH: f64 = 7.7;

/// The parameter is held at a coordinate.
struct Held {
    coordinate: f64,
    /// 2 ln(likelihood ratio).
    ratio: f64,
    /// Where the others, and the segments' starts, fit best.
    others: Point,
}

/// Value and 2 ln(likelihood ratio) of the parameter at `place` around the optimum. Steps are of the standard deviation
/// that the curvature tells: so they span the profile's own 95 % limit, however wide the interval has become
/// for other reasons.
pub(super) fn of(search: &Search<'_>, place: usize, fit: &Fit, std: f64) -> Vec<(f64, f64)> {
    let mut others = search.free.to_vec();
    let free = others.remove(place);
    let optimum = fit.point.theta[place];
    let (low, high) = free.coordinate_bounds();
    let mut values = search.values_at(&fit.point.theta);
    let mut held_at = |coordinate: f64, near: &Held, beyond: Option<&Held>| {
        free.parameters.put(&mut values, free.value(coordinate));
        let search = Search { values: &values, free: &others, ..*search };
        // Beginning where the others would be if they went on as they went.
        let begin = beyond.map_or_else(
            || near.others.clone(),
            |beyond| {
                let times = (coordinate - near.coordinate) / (near.coordinate - beyond.coordinate);
                near.others.moved(&near.others.way_from(&beyond.others), times)
            },
        );
        let (cost, others) = search.lowest_cost(fit, begin)?;
        let off = (coordinate - free.mean) / free.std;
        let prior = if free.std.is_finite() { off * off } else { 0.0 };
        Some(Held { coordinate, ratio: cost + prior - fit.all.cost, others })
    };
    let theta = fit.point.theta.clone().remove_row(place);
    let others = Point { theta, starts: fit.point.starts.clone() };
    // In order of the coordinate.
    let mut profile = VecDeque::from([Held { coordinate: optimum, ratio: 0.0, others }]);
    for side in [-1.0, 1.0] {
        for by in AT {
            let coordinate = (optimum + side * by * std).clamp(low, high);
            let last = profile.len() - 1;
            let (near, beyond) = if side < 0.0 { (0, 1) } else { (last, last.wrapping_sub(1)) };
            let (near, beyond) = (&profile[near], profile.get(beyond));
            if near.coordinate == coordinate {
                break;
            }
            let Some(held) = held_at(coordinate, near, beyond) else { break };
            let is_far = held.ratio > FAR_ENOUGH;
            if side < 0.0 {
                profile.push_front(held)
            } else {
                profile.push_back(held)
            }
            if is_far {
                break;
            }
        }
    }
    profile.iter().map(|held| (free.value(held.coordinate), held.ratio)).collect()
}
