//! The road's course out of an accelerometer: gravity along a grade, beside the sensor's own zero, scale and
//! what else it errs by, and noise that soon forgets. A Kalman filter over means of half a second, its course smoothed
//! backwards.

use std::ops::Range;

use nalgebra::{SMatrix, SVector};

/// Gravity in the sensor's direction, m/s², and how it changes with the way; noise that lasts; and numbers of the sensor.
const STATES: usize = 3 + NUMBERS;
type Values = SVector<f64, STATES>;
type Square = SMatrix<f64, STATES, STATES>;

/// Where the numbers of the sensor stand.
const OWN: Range<usize> = 3..STATES;

/// Numbers of the sensor: its zero, m/s²; by what share it reads too much; how late it is, s; and two that its user chooses.
pub const NUMBERS: usize = 5;

/// Of these the scale.
pub const SCALE: usize = 1;

/// What is thought of them before anything is seen: mean and standard deviation.
pub type Thought = [(f64, f64); NUMBERS];

/// A row is a mean over so much, s. In shorter ones a change of speed is mostly the wheel sensors' noise, and an accelerometer
/// that does not follow that seems to read too little. Tuned by the RAV4's hills: of 0.2, 0.5 and 1 s, the scale is 27, 93 and
/// 98 %.
pub const ROW_S: f64 = 0.5;

/// Fewer rows say nothing of a road: 15 s.
pub const LEAST_ROWS: usize = 30;

/// What a course of the road is paid for its two sizes, in −2 ln likelihood for each.
pub fn price(rows: usize) -> f64 {
    2.0 * (rows.max(1) as f64).ln()
}

/// A mean over half a second.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// When, s from the recording's start.
    pub t: f64,
    /// How far the car has come, m.
    pub way: f64,
    /// What the accelerometer reads beyond what the motion tells, m/s².
    pub excess: f64,
    /// How that changes with the sensor's numbers.
    pub by: [f64; NUMBERS],
}

/// Sizes of what is random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Gravity in the sensor's direction, m/s²; 0 on a level road.
    pub slope: f64,
    /// The road changes within so many metres.
    pub length_m: f64,
    /// Noise that lasts, m/s² …
    pub noise: f64,
    /// … so many seconds.
    pub lasting_s: f64,
    /// Noise that does not, m/s².
    pub white: f64,
}

/// What a shape can be, in the order of its fields: noise lasts a second at most, and what lasts longer is the road's or an
/// unusual sensor's.
const BOUNDS: [(f64, f64); 5] = [(0.02, 3.0), (0.0, 500.0), (0.01, 3.0), (0.2, 1.0), (0.01, 3.0)];

/// What it is first thought to be. Numerical: where the search begins.
const FIRST: Shape = Shape { slope: 0.3, length_m: 100.0, noise: 0.15, lasting_s: 0.4, white: 0.05 };

/// Steps of the search, of the logarithms. Numerical.
const STEPS: [f64; 4] = [0.8, 0.4, 0.2, 0.1];

/// Moves of the search: what is multiplied by a step's factor, as powers. A slope over a longer way is as steep as a smaller one
/// over a shorter.
const MOVES: [[f64; 5]; 7] = [
    [0.0, 0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0, 0.0],
    [1.0, -1.0, 0.0, 0.0, 0.0],
];

/// Those of a level road.
const OF_NOISE: usize = 3;

impl Shape {
    /// The likeliest of rows; of a road that changes within so many metres at least, or of a level one. With −2 ln likelihood.
    pub fn of(
        rows: &[Row],
        counts: &dyn Fn(usize) -> bool,
        thought: &Thought,
        shortest_m: Option<f64>,
    ) -> (Self, f64) {
        let cost = |shape: &Self| Filtered::of(rows, counts, shape, thought).cost;
        let Some(shortest_m) = shortest_m else {
            return Self { slope: 0.0, ..FIRST }.improved(&MOVES[..OF_NOISE], FIRST.length_m, &cost);
        };
        // The search may end at either.
        let starts = [1.2 * shortest_m, 5.0 * shortest_m].map(|length_m| Self { length_m, ..FIRST });
        let ends = starts.map(|start| start.improved(&MOVES, shortest_m, &cost));
        if ends[0].1 < ends[1].1 { ends[0] } else { ends[1] }
    }

    fn improved(self, moves: &[[f64; 5]], shortest_m: f64, cost: &dyn Fn(&Self) -> f64) -> (Self, f64) {
        let mut at = self;
        let mut least = cost(&at);
        for step in STEPS {
            loop {
                let before = least;
                for powers in moves {
                    for step in [step, -step] {
                        while let Some(other) = at.moved(powers, step, shortest_m) {
                            let other_cost = cost(&other);
                            if other_cost >= least {
                                break;
                            }
                            (at, least) = (other, other_cost);
                        }
                    }
                }
                if before - least < 0.1 {
                    break;
                }
            }
        }
        (at, least)
    }

    /// None where its bounds keep it where it is.
    fn moved(&self, powers: &[f64; 5], step: f64, shortest_m: f64) -> Option<Self> {
        let mut fields = [self.slope, self.length_m, self.noise, self.lasting_s, self.white];
        for (place, (field, (low, high))) in fields.iter_mut().zip(BOUNDS).enumerate() {
            let low = if place == 1 { shortest_m } else { low };
            if powers[place] != 0.0 {
                *field = (*field * (powers[place] * step).exp()).clamp(low, high);
            }
        }
        let [slope, length_m, noise, lasting_s, white] = fields;
        let other = Self { slope, length_m, noise, lasting_s, white };
        (other != *self).then_some(other)
    }
}

/// What rows say of a road.
pub struct Road {
    /// Gravity at each row, m/s², and its standard deviation; about its mean, which nobody can tell from the sensor's
    /// zero.
    pub slope: Vec<(f64, f64)>,
    /// The sensor's numbers.
    pub sensor: [(f64, f64); NUMBERS],
}

impl Road {
    /// By those rows that count.
    pub fn of(rows: &[Row], counts: &dyn Fn(usize) -> bool, thought: &Thought, shape: &Shape) -> Self {
        let sensor = Filtered::of(rows, counts, shape, thought).sensor();
        // The mean is the zero's: with that known, the rest is as sharp as it is.
        let mut zero_known = *thought;
        zero_known[0] = (sensor[0].0, 1e-6);
        let slope = Filtered::of(rows, counts, shape, &zero_known).smoothed();
        Self { slope, sensor }
    }

    /// What the accelerometer reads beyond the motion, without noise.
    pub fn excess(&self, row: usize, rows: &[Row]) -> f64 {
        let own = self.sensor.iter().zip(rows[row].by);
        self.slope[row].0 + own.map(|((value, _), by)| value * by).sum::<f64>()
    }
}

/// What is known before a row, and what the row says.
struct Step {
    to: Square,
    before: (Values, Square),
    told: Option<Told>,
}

struct Told {
    by: Values,
    /// Innovation and its variance.
    innovation: (f64, f64),
    gain: Values,
}

struct Filtered {
    steps: Vec<Step>,
    last: (Values, Square),
    /// −2 ln likelihood.
    cost: f64,
}

impl Filtered {
    fn of(rows: &[Row], counts: &dyn Fn(usize) -> bool, shape: &Shape, thought: &Thought) -> Self {
        let rate = 3f64.sqrt() / shape.length_m;
        let variances = [shape.slope, shape.slope * rate, shape.noise].map(|std| std * std);
        let mut mean = Values::zeros();
        let mut covariance = Square::zeros();
        for (place, variance) in variances.into_iter().enumerate() {
            covariance[(place, place)] = variance;
        }
        // What is forgotten comes anew; the sensor's numbers stay.
        let stays = covariance;
        for (place, (value, std)) in OWN.zip(*thought) {
            (mean[place], covariance[(place, place)]) = (value, std * std);
        }
        let mut steps = Vec::with_capacity(rows.len());
        let mut cost = 0.0;
        for (number, row) in rows.iter().enumerate() {
            let before = number.checked_sub(1).map_or(row, |before| &rows[before]);
            let to = moved(shape, rate, row.way - before.way, row.t - before.t);
            mean = to * mean;
            covariance = to * covariance * to.transpose();
            covariance += stays - to * stays * to.transpose();
            let before = (mean, covariance);
            let told = counts(number).then(|| {
                let mut by = Values::zeros();
                (by[0], by[2]) = (1.0, 1.0);
                OWN.zip(row.by).for_each(|(place, slope)| by[place] = slope);
                let with = covariance * by;
                let variance = by.dot(&with) + shape.white * shape.white;
                let innovation = row.excess - by.dot(&mean);
                let gain = with / variance;
                mean += gain * innovation;
                covariance -= gain * with.transpose();
                covariance = 0.5 * (covariance + covariance.transpose());
                cost += innovation * innovation / variance + variance.ln();
                Told { by, innovation: (innovation, variance), gain }
            });
            steps.push(Step { to, before, told });
        }
        Self { steps, last: (mean, covariance), cost }
    }

    fn sensor(&self) -> [(f64, f64); NUMBERS] {
        let (mean, covariance) = &self.last;
        std::array::from_fn(|number| {
            let place = OWN.start + number;
            (mean[place], covariance[(place, place)].max(0.0).sqrt())
        })
    }

    /// Gravity at each row by all rows (Bierman 1973: the adjoint of the filter, without any inverse).
    fn smoothed(&self) -> Vec<(f64, f64)> {
        let mut all = Vec::with_capacity(self.steps.len());
        let (mut pull, mut sure) = (Values::zeros(), Square::zeros());
        for step in self.steps.iter().rev() {
            if let Some(Told { by, innovation: (innovation, variance), gain }) = &step.told {
                let keeps = Square::identity() - gain * by.transpose();
                pull = keeps.transpose() * pull - by * (*innovation / *variance);
                sure = keeps.transpose() * sure * keeps + by * by.transpose() / *variance;
            }
            let (mean, covariance) = &step.before;
            let value = mean - covariance * pull;
            let left = covariance - covariance * sure * covariance;
            all.push((value[0], left[(0, 0)].max(0.0).sqrt()));
            pull = step.to.transpose() * pull;
            sure = step.to.transpose() * sure * step.to;
        }
        all.reverse();
        all
    }
}

/// How the state goes on over some way, m, and time, s.
fn moved(shape: &Shape, rate: f64, way: f64, time: f64) -> Square {
    let mut to = Square::identity();
    let (way, keeps) = (way.max(0.0), (-rate * way.max(0.0)).exp());
    to[(0, 0)] = keeps * (1.0 + rate * way);
    to[(0, 1)] = keeps * way;
    to[(1, 0)] = -keeps * rate * rate * way;
    to[(1, 1)] = keeps * (1.0 - rate * way);
    to[(2, 2)] = (-time.max(0.0) / shape.lasting_s).exp();
    to
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    const THOUGHT: Thought = [(0.0, 10.0), (0.03, 0.07), (0.0, 0.05), (0.0, 0.5), (0.0, 0.5)];

    /// Two minutes at 15 m/s with stops and starts, on a road of this grade.
    fn driven(slope: &dyn Fn(f64) -> f64) -> Vec<Row> {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let (mut way, mut lasts) = (0.0, 0.0);
        let mut rows = Vec::new();
        for i in 0..600 {
            let t = 0.2 * f64::from(i);
            let faster = 1.5 * (0.5 * t).sin();
            let speed = 15.0 - 3.0 * (0.5 * t).cos();
            way += 0.2 * speed;
            lasts = 0.6 * lasts + 0.8 * 0.1 * random.sample::<f64, _>(StandardNormal);
            let excess = slope(way) + 0.3 + 0.04 * faster + lasts;
            rows.push(Row { t, way, excess, by: [1.0, faster, 0.0, 0.0, 0.0] });
        }
        rows
    }

    #[test]
    fn hills_come_out_with_their_course_and_the_sensors_numbers() {
        let truth = |way: f64| 0.35 * (way / 60.0).sin();
        let rows = driven(&truth);
        let all = |_| true;
        let (level, without) = Shape::of(&rows, &all, &THOUGHT, None);
        let (hilly, with) = Shape::of(&rows, &all, &THOUGHT, Some(30.0));
        assert!(without - with > 100.0 && level.noise > hilly.noise, "{without} {with} {hilly:?}");
        let road = Road::of(&rows, &all, &THOUGHT, &hilly);
        let mean = rows.iter().map(|row| truth(row.way)).sum::<f64>() / rows.len() as f64;
        let errors: Vec<(f64, f64)> = rows
            .iter()
            .zip(&road.slope)
            .map(|(row, (slope, std))| (slope - (truth(row.way) - mean), *std))
            .collect();
        let rms = |of: &dyn Fn(&(f64, f64)) -> f64| {
            (errors.iter().map(|it| of(it).powi(2)).sum::<f64>() / errors.len() as f64).sqrt()
        };
        assert!(rms(&|it| it.0) < 0.08, "{}", rms(&|it| it.0));
        let apart = rms(&|it| it.0 / it.1);
        assert!((0.6..1.5).contains(&apart), "deviations are what they say: {apart}");
        let scale = road.sensor[SCALE];
        assert!((scale.0 - 0.04).abs() < 3.0 * scale.1 && scale.1 < 0.02, "{scale:?}");
        // What was not looked at lies between its neighbours.
        let some = |row: usize| (row / 30) % 3 != 2;
        let guessed = Road::of(&rows, &some, &THOUGHT, &hilly);
        let square = |of: &dyn Fn(usize) -> f64| -> f64 {
            (0..rows.len()).filter(|row| !some(*row)).map(|row| of(row).powi(2)).sum()
        };
        let [without, with] = [
            square(&|row| rows[row].excess - 0.3),
            square(&|row| rows[row].excess - guessed.excess(row, &rows)),
        ];
        assert!(with < 0.5 * without, "{with} of {without}");
    }

    #[test]
    fn a_level_road_gains_nothing_by_a_slope() {
        let rows = driven(&|_| 0.0);
        let [level, hilly] =
            [None, Some(30.0)].map(|shortest| Shape::of(&rows, &|_| true, &THOUGHT, shortest).1);
        assert!(level - hilly < 6.0, "{level} {hilly}");
    }
}
