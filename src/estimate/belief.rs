//! What is believed of mu_max: a weight for each friction that a road can have.
//!
//! Three things happen to it. What was measured ([`Belief::learn_measured`]) or used ([`Belief::learn_used`])
//! rules frictions out. Such evidence goes on for as long as a wheel is at its limit, and its error is the same
//! all the while: a model that is off, a sensor's offset. So the same evidence again changes nothing: each
//! friction keeps the least weight that any of it left. Time passes, and the road may have become another one,
//! unseen: every friction gets back some of what all have on average ([`Belief::forget`]). And evidence may
//! contradict all that was believed: then the road has become another one, and the newest is believed alone.

/// Frictions of roads: from, and the width of each cell.
const LOWEST: f64 = 0.02;
const CELL: f64 = 0.02;
const CELLS: usize = 65;

/// Highest friction that there is a cell for.
pub const HIGHEST: f64 = LOWEST + CELL * CELLS as f64;

/// Evidence that leaves no friction more than this share of the weight it had contradicts what was believed.
const CONTRADICTED: f64 = 0.05;

/// A friction of this weight or more beside the likeliest one's is within the interval, however much weight is
/// beyond it: all that a use of friction leaves is as likely, and of that nothing is taken off.
const LIKELY: f64 = 0.5;

/// On either side of the interval there is this share of the weight, or less.
const TAIL: f64 = 0.025;

/// A weight for each friction, the largest of them 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    weight: [f64; CELLS],
}

/// What a use of friction says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// That much was known to be there.
    Known,
    /// More is there than was known.
    More,
    /// More than was believed possible: it is another road.
    Another,
}

impl Belief {
    /// Any friction is as likely as any other.
    pub const UNKNOWN: Self = Self { weight: [1.0; CELLS] };

    /// In this time the road became another one with this probability.
    pub fn forget(&mut self, probability: f64) {
        let all: f64 = self.weight.iter().sum();
        let share = probability * all / CELLS as f64;
        for weight in &mut self.weight {
            *weight += share - probability * *weight;
        }
    }

    /// Each friction keeps at most the weight that the evidence leaves it; what was ruled out, if asked for, goes
    /// evenly, as far as the evidence allows, to where there is `room` for it. True if the evidence contradicted
    /// what was believed.
    fn learn(&mut self, possible: impl Fn(f64) -> f64, room: Option<&dyn Fn(f64) -> bool>) -> bool {
        let evidence: [f64; CELLS] = std::array::from_fn(|cell| possible(middle(cell)));
        let (mut ruled_out, mut most) = (0.0, 0.0f64);
        let mut left = self.weight;
        for (weight, possible) in left.iter_mut().zip(evidence) {
            ruled_out += (*weight - possible).max(0.0);
            *weight = weight.min(possible);
            most = most.max(*weight);
        }
        if most < CONTRADICTED {
            self.weight = evidence;
            self.normalize();
            return true;
        }
        if let Some(is_room) = room {
            let evidence: [f64; CELLS] =
                std::array::from_fn(|cell| if is_room(middle(cell)) { evidence[cell] } else { 0.0 });
            let share = ruled_out / evidence.iter().sum::<f64>().max(1.0);
            for (weight, possible) in left.iter_mut().zip(evidence) {
                *weight += share * possible;
            }
        }
        self.weight = left;
        self.normalize();
        false
    }

    /// Makes the largest weight 1.
    fn normalize(&mut self) {
        let most = self.weight.iter().copied().fold(1e-9, f64::max);
        for weight in &mut self.weight {
            *weight /= most;
        }
    }

    /// At least this much is in use, give or take half a cell. What is ruled out below that goes between it and
    /// what was known to be there: if the road got worse since, what is in use now may be all of it.
    pub fn learn_used(&mut self, used: f64) -> Use {
        // More than any road has is all of it.
        let used = used.min(middle(CELLS - 1));
        let known = self.interval().0;
        let possible = |mu: f64| ((mu - used) / CELL + 0.5).clamp(0.0, 1.0);
        if self.learn(possible, Some(&|mu| known < used + CELL || mu < known)) {
            Use::Another
        } else if used > known {
            Use::More
        } else {
            Use::Known
        }
    }

    /// This was measured, with standard deviations downwards and upwards. True if it contradicted what was believed.
    pub fn learn_measured(&mut self, mu: f64, std: [f64; 2]) -> bool {
        // Narrower than a cell it would fall between two.
        let [down, up] = std.map(|std| std.max(0.5 * CELL));
        let mu = mu.clamp(middle(0), middle(CELLS - 1));
        let possible = |other: f64| {
            let std = if other < mu { down } else { up };
            (-0.5 * ((other - mu) / std).powi(2)).exp()
        };
        self.learn(possible, None)
    }

    /// It is between these, give or take. True if that contradicted what was believed.
    pub fn learn_between(&mut self, (low, high): (f64, f64), std: f64) -> bool {
        let possible = |mu: f64| (-0.5 * ((low - mu).max(mu - high).max(0.0) / std).powi(2)).exp();
        self.learn(possible, None)
    }

    /// How likely the friction is at most this.
    pub fn at_most(&self, mu: f64) -> f64 {
        let (mut below, mut all) = (0.0, 0.0);
        for (cell, weight) in self.weight.into_iter().enumerate() {
            below += weight * ((mu - middle(cell)) / CELL + 0.5).clamp(0.0, 1.0);
            all += weight;
        }
        below / all
    }

    /// Mean and variance of something that depends on the friction; `of` says its weight beside the belief's, and
    /// its value. `None` if nothing has weight.
    pub fn expect(&self, of: impl Fn(f64) -> (f64, f64)) -> Option<(f64, f64)> {
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        for (cell, believed) in self.weight.into_iter().enumerate() {
            let (weight, value) = of(middle(cell));
            let weight = weight * believed;
            sum += weight;
            first += weight * value;
            second += weight * value * value;
        }
        (sum > 1e-6).then(|| (first / sum, (second / sum - (first / sum).powi(2)).max(0.0)))
    }

    /// The 95 % interval.
    pub fn interval(&self) -> (f64, f64) {
        let (mut sum, mut most) = (0.0, 0.0f64);
        for weight in self.weight {
            sum += weight;
            most = most.max(weight);
        }
        let (tail, likely) = (TAIL * sum, LIKELY * most);
        let low = LOWEST + CELL * end(self.weight.into_iter(), tail, likely);
        let high = HIGHEST - CELL * end(self.weight.into_iter().rev(), tail, likely);
        (low, high)
    }
}

/// The friction in the middle of a cell.
fn middle(cell: usize) -> f64 {
    LOWEST + CELL * (cell as f64 + 0.5)
}

/// How many cells from the first one the interval begins: where weights become likely, or before that, where more
/// than a tail's weight is before it.
fn end(weights: impl Iterator<Item = f64>, tail: f64, likely: f64) -> f64 {
    let (mut sum, mut before, mut by_weight) = (0.0, 0.0, f64::INFINITY);
    for (cell, weight) in weights.enumerate() {
        let cell = cell as f64;
        if sum <= tail && sum + weight > tail {
            by_weight = cell + (tail - sum) / weight;
        }
        if weight >= likely {
            // Weights go in straight lines from the middle of one cell to that of the next.
            let by_likelihood = cell - 0.5 + (likely - before) / (weight - before);
            return by_weight.min(by_likelihood).max(0.0);
        }
        (sum, before) = (sum + weight, weight);
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_measured_has_the_interval_of_its_deviation() {
        let mut belief = Belief::UNKNOWN;
        assert!(!belief.learn_measured(0.6, [0.05; 2]));
        let (low, high) = belief.interval();
        assert!((low - 0.502).abs() < 0.008 && (high - 0.698).abs() < 0.008, "{low} {high}");
        // Again the same says no more.
        for _ in 0..1000 {
            belief.learn_measured(0.6, [0.05; 2]);
        }
        assert_eq!(belief.interval(), (low, high));
    }

    #[test]
    fn what_is_used_is_there_and_nothing_is_above_all() {
        let mut belief = Belief::UNKNOWN;
        assert_eq!(belief.interval().1, HIGHEST);
        belief.learn_used(0.4);
        let (low, high) = belief.interval();
        assert!((low - 0.4).abs() < 0.02 && high > HIGHEST - 0.02, "{low} {high}");
    }

    #[test]
    fn more_than_any_road_has_leaves_the_best_road() {
        let mut belief = Belief::UNKNOWN;
        for used in [1.0, 2.0, 1e30, f64::INFINITY] {
            belief.learn_used(used);
            let (low, high) = belief.interval();
            assert!(low > 0.9 && low < high && high <= HIGHEST, "{used}: {low} {high}");
        }
    }

    #[test]
    fn what_is_old_may_be_of_another_road() {
        let mut belief = Belief::UNKNOWN;
        belief.learn_measured(0.6, [0.02; 2]);
        let fresh = belief.interval();
        let mut width = fresh.1 - fresh.0;
        for _ in 0..50 {
            belief.forget(0.01);
            let (low, high) = belief.interval();
            assert!(high - low > width - 0.002, "{low} {high}");
            width = high - low;
        }
        assert!(width > 1.0, "{width}");
        // The bound of a use ages as the share of the roads below it has it.
        let mut belief = Belief::UNKNOWN;
        belief.learn_used(0.8);
        belief.forget(0.1);
        let (low, _) = belief.interval();
        assert!((low - (LOWEST + TAIL / 0.1 * (HIGHEST - LOWEST))).abs() < 0.02, "{low}");
    }

    #[test]
    fn a_contradiction_is_another_road() {
        let mut belief = Belief::UNKNOWN;
        belief.learn_used(0.8);
        assert!(belief.learn_measured(0.2, [0.02; 2]));
        let (low, high) = belief.interval();
        assert!(low > 0.1 && high < 0.3, "{low} {high}");
        assert_eq!(belief.learn_used(0.5), Use::Another);
        assert!((belief.interval().0 - 0.5).abs() < 0.02);
    }

    #[test]
    fn one_of_two_evidences_counts_where_it_says_more() {
        let mut belief = Belief::UNKNOWN;
        belief.learn_used(0.58);
        assert!(!belief.learn_measured(0.6, [0.1; 2]));
        let (low, high) = belief.interval();
        assert!((low - 0.58).abs() < 0.03 && (high - 0.8).abs() < 0.02, "{low} {high}");
    }
}
