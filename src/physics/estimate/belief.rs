//! What is believed of mu_max: a weight for each friction that a road can have.
//!
//! Three things change it. Evidence rules frictions out: what was measured ([`Belief::learn_measured`]) or used
//! ([`Belief::learn_used`]). It repeats itself while a wheel stays at its limit, and with the same error (of a model,
//! of a sensor's offset), so that the same evidence must not count twice: each friction keeps the least weight that
//! any evidence left it. Time passes, and the road may change unseen: every friction gets back some of the average
//! weight ([`Belief::forget`]). Evidence contradicts the belief: the road is another one, and only the newest
//! evidence counts.

use super::saturating::Likelihood;

/// Lowest friction that there is a cell for. Physical: no road is more slippery than wet ice.
const LOWEST: f64 = 0.02;
/// Width of a cell. A cell is half of what the sensors can tell apart.
const CELL: f64 = 0.02;
/// How many there are.
const CELLS: usize = 65;

/// Highest friction that there is a cell for.
pub const HIGHEST: f64 = LOWEST + CELL * CELLS as f64;

/// Evidence that leaves no friction more than this share of the weight it had contradicts what was believed. Tuned
/// with the test `campaign`.
const CONTRADICTED: f64 = 0.05;

/// A friction with this weight or more, relative to the likeliest one, is inside the interval, however much weight
/// lies beyond it: after a use of friction all that it leaves is equally likely. Tuned with the test `campaign`.
const LIKELY: f64 = 0.5;

/// How likely a side that slips has a slippery road of its own under it, against one that all wheels are on. Tuned with the test
/// `campaign`: a seventh of its roads have one slippery side, and there most wheels slip.
const SPLIT: f64 = 0.3;

/// On either side of the interval there is this share of the weight, or less. Statistical: the interval is one of
/// 95 %.
const TAIL: f64 = 0.025;

/// A weight for each friction; that of the likeliest is 1 when something was learned, and less as it is forgotten.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    weight: [f64; CELLS],
    /// The sum of the weights, and the largest.
    sum: f64,
    most: f64,
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

/// A friction with standard deviations downwards and upwards.
struct Measured {
    mu: f64,
    std: [f64; 2],
}

impl Measured {
    fn new(mu: f64, std: [f64; 2]) -> Self {
        // A deviation narrower than a cell would fall between two.
        Self { mu: mu.clamp(middle(0), middle(CELLS - 1)), std: std.map(|std| std.max(0.5 * CELL)) }
    }

    /// How likely it is measured where this is the friction, against the likeliest.
    fn likelihood(&self, friction: f64) -> f64 {
        let std = self.std[usize::from(friction >= self.mu)];
        (-0.5 * ((friction - self.mu) / std).powi(2)).exp()
    }
}

impl Belief {
    /// Any friction is as likely as any other.
    pub const UNKNOWN: Self = Self { weight: [1.0; CELLS], sum: CELLS as f64, most: 1.0 };

    /// In this time the road became another one with this probability.
    pub fn forget(&mut self, probability: f64) {
        // The mean goes to the mean: what all have on average stays.
        let (kept, share) = (1.0 - probability, probability * self.sum / CELLS as f64);
        for weight in &mut self.weight {
            *weight = kept * *weight + share;
        }
        self.most = kept * self.most + share;
    }

    /// Each friction keeps at most the weight that the evidence leaves it. True if the evidence contradicted what
    /// was believed.
    fn learn(&mut self, possible: impl Fn(f64) -> f64) -> bool {
        self.learn_weights(&std::array::from_fn(|cell| possible(middle(cell))))
    }

    /// The same, cell by cell.
    fn learn_weights(&mut self, evidence: &[f64; CELLS]) -> bool {
        let mut left = self.weight;
        for (weight, possible) in left.iter_mut().zip(evidence) {
            *weight = weight.min(*possible);
        }
        let is_contradicted = largest(&left) < CONTRADICTED;
        self.weight = if is_contradicted { *evidence } else { left };
        self.normalize();
        is_contradicted
    }

    /// Makes the largest weight 1.
    fn normalize(&mut self) {
        let factor = 1.0 / largest(&self.weight).max(1e-9);
        for weight in &mut self.weight {
            *weight *= factor;
        }
        (self.sum, self.most) = (total(&self.weight), 1.0);
    }

    /// At least this much is in use, within half a cell. Where more was known to be there, the weight ruled out below is spread
    /// evenly between this use and that: the road may have got worse, and this use may be all there is.
    pub fn learn_used(&mut self, used: f64) -> Use {
        // A use beyond the highest cell counts as that cell.
        let used = used.min(middle(CELLS - 1));
        let known = self.low();
        // The first cell of which a part is possible.
        let place = ((used - LOWEST) / CELL).max(0.0);
        let first = place as usize;
        let part = 1.0 - place.fract();
        let ruled_out = total(&self.weight[..first]) + (self.weight[first] - part).max(0.0);
        self.weight[..first].fill(0.0);
        self.weight[first] = self.weight[first].min(part);
        if largest(&self.weight[first..]) < CONTRADICTED {
            self.weight[first..].fill(1.0);
            self.weight[first] = part;
            self.normalize();
            return Use::Another;
        }
        // Where more is in use than was known, what is left is as likely as it was.
        if let Some((at_first, further)) = self.weight[first..cells_below(known).max(first)].split_first_mut()
        {
            let share = ruled_out / (part + further.len() as f64).max(1.0);
            *at_first += share * part;
            for weight in further {
                *weight += share;
            }
        }
        self.normalize();
        if used > known { Use::More } else { Use::Known }
    }

    /// This was measured, with standard deviations downwards and upwards. True if it contradicted what was believed.
    pub fn learn_measured(&mut self, mu: f64, std: [f64; 2]) -> bool {
        let measured = Measured::new(mu, std);
        self.learn(|other| measured.likelihood(other))
    }

    /// The same of one side of the car. The other side is alike, or it may be any road that gives more: the car has the mean of
    /// both. So it is bounded even if that is the best road there is.
    pub fn learn_one_sided(&mut self, mu: f64, std: [f64; 2]) -> bool {
        let side = Measured::new(mu, std);
        let most = 0.5 * (side.mu + 2.0 * side.std[1] + HIGHEST);
        let beyond = |other: f64| if other > side.mu && other < most { SPLIT } else { 0.0 };
        self.learn(|other| side.likelihood(other).max(beyond(other)))
    }

    /// Another belief, in what was seen alone, is evidence. True if that contradicted what was believed.
    pub fn learn_belief(&mut self, other: &Belief) -> bool {
        self.learn_weights(&other.weight)
    }

    /// What one believes who knows nothing else.
    pub fn of(likelihood: &Likelihood) -> Self {
        let weight = std::array::from_fn(|cell| likelihood.of(middle(cell)));
        let mut belief = Self { weight, ..Self::UNKNOWN };
        belief.normalize();
        belief
    }

    /// The mean friction.
    pub fn mean(&self) -> f64 {
        let weighted = self.weight.iter().enumerate().map(|(cell, weight)| weight * middle(cell));
        weighted.sum::<f64>() / self.sum
    }

    /// How likely the friction is at most this.
    pub fn at_most(&self, mu: f64) -> f64 {
        let mut below = 0.0;
        for (cell, weight) in self.weight.iter().enumerate() {
            below += weight * ((mu - middle(cell)) / CELL + 0.5).clamp(0.0, 1.0);
        }
        below / self.sum
    }

    /// Means and variances of functions of the friction. `of` gives a further weight and the values at a friction.
    /// `None` if nothing has weight.
    pub fn expect<const K: usize>(&self, of: impl Fn(f64) -> (f64, [f64; K])) -> Option<[(f64, f64); K]> {
        let (mut sum, mut first, mut second) = (0.0, [0.0; K], [0.0; K]);
        for (cell, believed) in self.weight.iter().enumerate() {
            let (weight, values) = of(middle(cell));
            let weight = weight * believed;
            sum += weight;
            for k in 0..K {
                first[k] += weight * values[k];
                second[k] += weight * values[k] * values[k];
            }
        }
        let moments = |k: usize| {
            let mean = first[k] / sum;
            (mean, (second[k] / sum - mean * mean).max(0.0))
        };
        (sum > 1e-6).then(|| std::array::from_fn(moments))
    }

    /// The 95 % interval.
    pub fn interval(&self) -> (f64, f64) {
        let last = self.weight.iter().rposition(|weight| *weight >= self.likely());
        let high = last.map_or(0.0, |cell| {
            let (inside, beyond) = self.weight.split_at(cell + 1);
            self.end(inside[cell], beyond, beyond.iter().rev())
        });
        (self.low(), HIGHEST - CELL * high)
    }

    /// Its lower end.
    fn low(&self) -> f64 {
        let first = self.weight.iter().position(|weight| *weight >= self.likely());
        let low = first.map_or(0.0, |cell| {
            let (beyond, inside) = self.weight.split_at(cell);
            self.end(inside[0], beyond, beyond.iter())
        });
        LOWEST + CELL * low
    }

    fn likely(&self) -> f64 {
        LIKELY * self.most
    }

    /// How many cells from the outermost one the interval begins: at the first likely weight, or before that, where
    /// more than a tail's weight is `beyond` it (`inwards`: from the outermost cell on).
    fn end<'a>(
        &self,
        weight: f64,
        beyond: &[f64],
        inwards: impl DoubleEndedIterator<Item = &'a f64> + Clone,
    ) -> f64 {
        let tail = TAIL * self.sum;
        let cell = beyond.len() as f64;
        // Weights go in straight lines from the middle of one cell to that of the next.
        let before = inwards.clone().next_back().copied().unwrap_or(0.0);
        let by_likelihood = cell - 0.5 + (self.likely() - before) / (weight - before);
        let sum = total(beyond);
        let by_weight = if sum + weight <= tail {
            f64::INFINITY
        } else if sum <= tail {
            cell + (tail - sum) / weight
        } else {
            filled(inwards, tail)
        };
        by_weight.min(by_likelihood).max(0.0)
    }
}

/// After how many of these weights there is as much as this.
fn filled<'a>(weights: impl Iterator<Item = &'a f64>, enough: f64) -> f64 {
    let mut sum = 0.0;
    for (cell, weight) in weights.enumerate() {
        if sum + weight > enough {
            return cell as f64 + (enough - sum) / weight;
        }
        sum += weight;
    }
    f64::INFINITY
}

/// The friction in the middle of a cell.
fn middle(cell: usize) -> f64 {
    LOWEST + CELL * (cell as f64 + 0.5)
}

/// Cells whose middles are below this friction.
fn cells_below(mu: f64) -> usize {
    (((mu - LOWEST) / CELL - 0.5).ceil().max(0.0) as usize).min(CELLS)
}

/// Numbers summed side by side: in a single chain each addition would wait for the one before.
const ABREAST: usize = 8;

/// Their sum.
fn total(weights: &[f64]) -> f64 {
    let (rows, rest) = weights.as_chunks::<ABREAST>();
    let mut sums = [0.0; ABREAST];
    for row in rows {
        for (sum, weight) in sums.iter_mut().zip(row) {
            *sum += weight;
        }
    }
    sums.iter().chain(rest).sum()
}

/// The largest of them, zero or more.
fn largest(weights: &[f64]) -> f64 {
    let (rows, rest) = weights.as_chunks::<ABREAST>();
    let mut most = [0.0; ABREAST];
    for row in rows {
        for (most, &weight) in most.iter_mut().zip(row) {
            *most = if weight > *most { weight } else { *most };
        }
    }
    most.iter().chain(rest).fold(0.0, |most, weight| f64::max(most, *weight))
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
    fn one_side_bounds_both_even_if_the_other_is_the_best_road() {
        let mut belief = Belief::UNKNOWN;
        belief.learn_one_sided(0.2, [0.02; 2]);
        let (low, high) = belief.interval();
        assert!((low - 0.16).abs() < 0.02 && (0.6..0.79).contains(&high), "{low} {high}");
        // Of both sides much more is known.
        belief.learn_measured(0.2, [0.02; 2]);
        assert!(belief.interval().1 < 0.26, "{:?}", belief.interval());
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
    fn a_little_more_in_use_than_was_known_leaves_the_upper_bound() {
        let mut belief = Belief::UNKNOWN;
        belief.learn_measured(0.4, [0.03; 2]);
        belief.learn_used(0.41);
        let (low, high) = belief.interval();
        assert!((low - 0.41).abs() < 0.02 && high < 0.5, "{low} {high}");
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
