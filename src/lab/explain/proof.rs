//! The proof on held-out data: a free simulation with and without the findings.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::fit::Fit;
use super::model::Model;
use super::result::{ByChannel, Parts};
use super::smooth::courses;
use super::split::Split;
use physics::Quantity;
use physics::model::effect::{Course, Series};
use predict::free::run;
use predict::sums::{Comparison, UsedReadings};
use predict::{GriddedDrive, grid::COMPARED};

/// What a free simulation says of all drives.
pub type Comparisons = Vec<Vec<Comparison>>;

/// Simulates all drives freely, each course of the model told by readings of other seconds than those it
/// is compared with.
pub fn simulate(drives: &[GriddedDrive], fit: &Fit<'_>) -> Comparisons {
    let model = &fit.model;
    let keeps = model.own_courses();
    let has_courses = fit.noise.live.len() > keeps;
    drives
        .par_iter()
        .map(|drive| {
            let held = model.car();
            if !has_courses {
                return run(drive, &held, &held, &fit.noise);
            }
            let of = |odd: bool| {
                let informed = with_courses(drive, model, fit, keeps, UsedReadings::EveryOther(odd));
                let others = UsedReadings::EveryOther(!odd);
                let mut compared = run(drive, &held, &informed.car(), &fit.noise);
                compared.retain(|compared| others.include(compared.t));
                compared
            };
            let (mut compared, odd) = rayon::join(|| of(false), || of(true));
            compared.extend(odd);
            compared.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.channel.cmp(&b.channel)));
            compared
        })
        .collect()
}

/// The model with the courses that some of the readings tell.
pub fn with_courses<'a>(
    drive: &GriddedDrive,
    model: &Model<'a>,
    fit: &Fit<'_>,
    keeps: usize,
    readings: UsedReadings,
) -> Model<'a> {
    let courses = courses(drive, model, &fit.noise, readings);
    let mut informed = model.clone();
    for chosen in &mut informed.effects {
        if let Course::Live(place) = chosen.course
            && place >= keeps
            && let Some(course) = courses.get(place)
        {
            chosen.course = Course::Series(Series { t: course.t.clone(), value: course.value.clone() });
        }
    }
    informed
}

/// Sums for a fit.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorSums {
    count: f64,
    value: f64,
    square: f64,
    error: f64,
}

impl ErrorSums {
    /// Adds a value, and what was said of it.
    pub fn add(&mut self, measured: f64, simulated: f64) {
        self.count += 1.0;
        self.value += measured;
        self.square += measured * measured;
        self.error += (measured - simulated).powi(2);
    }

    fn plus(self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            value: self.value + other.value,
            square: self.square + other.square,
            error: self.error + other.error,
        }
    }

    /// Fewer values say nothing. Tuned, no test on record.
    const LEAST: f64 = 20.0;

    /// √mean (y − ŷ)², if there is enough to say.
    pub fn root_mean_square(&self) -> Option<f64> {
        (self.count > Self::LEAST).then(|| (self.error / self.count).sqrt())
    }

    /// 100 (1 − |y − ŷ|/|y − mean y|), if there is enough to say.
    pub fn fit(&self) -> Option<f64> {
        let spread = self.square - self.value * self.value / self.count.max(1.0);
        (self.count > Self::LEAST && spread > 0.0).then(|| 100.0 * (1.0 - (self.error / spread).sqrt()))
    }
}

/// By channel.
pub type Sums = BTreeMap<String, ErrorSums>;

/// Sums of both parts.
pub fn sums(comparisons: &Comparisons, split: &Split) -> Parts<Sums> {
    let mut parts: Parts<Sums> = Parts::default();
    for channel in COMPARED {
        let of = |(drive, compared): (usize, &Vec<Comparison>)| {
            let own = compared.iter().filter(|compared| compared.channel == channel as u8);
            own.map(|it| (split.is_held_out(drive, it.t), it.measured, it.simulated)).collect::<Vec<_>>()
        };
        parts.add(channel, comparisons.iter().enumerate().flat_map(of));
    }
    parts
}

impl Parts<Sums> {
    /// Adds what was held out or not, measured and simulated of a channel.
    pub fn add(&mut self, channel: Quantity, all: impl Iterator<Item = (bool, f64, f64)>) {
        let [mut train, mut holdout] = [ErrorSums::default(); 2];
        for (is_held, measured, simulated) in all {
            if is_held { &mut holdout } else { &mut train }.add(measured, simulated);
        }
        for (part, sums) in [(&mut self.train, train), (&mut self.holdout, holdout)] {
            let own = part.entry(channel.name().into()).or_default();
            *own = own.plus(&sums);
        }
    }

    /// Fit in %.
    pub fn fits(&self) -> Parts<ByChannel> {
        self.each(ErrorSums::fit)
    }

    /// Root mean square error, SI.
    pub fn errors(&self) -> Parts<ByChannel> {
        self.each(ErrorSums::root_mean_square)
    }

    fn each(&self, of: fn(&ErrorSums) -> Option<f64>) -> Parts<ByChannel> {
        let all = |sums: &Sums| {
            sums.iter().filter_map(|(channel, sums)| Some((channel.clone(), of(sums)?))).collect()
        };
        Parts { train: all(&self.train), holdout: all(&self.holdout) }
    }
}

/// Is the mean fit of the channels better after than before?
pub fn is_better(before: &ByChannel, after: &ByChannel) -> bool {
    let mean = |fits: &ByChannel| fits.values().sum::<f64>() / fits.len().max(1) as f64;
    mean(after) > mean(before)
}

/// Blocks of the bootstrap, s. Statistical: longer than what is left is correlated.
const BOOTSTRAP_S: f64 = 4.0;
/// Draws of the bootstrap. Statistical: ten of them lie beyond each end of the 95 % interval.
const DRAWS: usize = 400;

/// 95 % interval of the improvement of the held-out fit, percentage points, by channel: blocks of seconds
/// are drawn with replacement.
pub fn improvement(
    before: &Comparisons,
    after: &Comparisons,
    split: &Split,
    seed: u64,
) -> BTreeMap<String, [f64; 2]> {
    let mut all = BTreeMap::new();
    for channel in COMPARED {
        let blocks = |comparisons: &Comparisons| -> BTreeMap<(usize, i64), ErrorSums> {
            let mut blocks: BTreeMap<(usize, i64), ErrorSums> = BTreeMap::new();
            for (drive, comparisons) in comparisons.iter().enumerate() {
                let held = comparisons
                    .iter()
                    .filter(|s| s.channel == channel as u8 && split.is_held_out(drive, s.t));
                for compared in held {
                    let block = blocks.entry((drive, (compared.t / BOOTSTRAP_S) as i64)).or_default();
                    block.add(compared.measured, compared.simulated);
                }
            }
            blocks
        };
        let (before, after) = (blocks(before), blocks(after));
        let pairs: Vec<(ErrorSums, ErrorSums)> =
            before.iter().filter_map(|(key, sums)| Some((*sums, *after.get(key)?))).collect();
        if pairs.len() < 3 {
            continue;
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(channel as u64);
        let mut gains: Vec<f64> = (0..DRAWS)
            .filter_map(|_| {
                let (mut a, mut b) = (ErrorSums::default(), ErrorSums::default());
                for _ in 0..pairs.len() {
                    let pair = &pairs[random.random_range(0..pairs.len())];
                    (a, b) = (a.plus(&pair.0), b.plus(&pair.1));
                }
                Some(b.fit()? - a.fit()?)
            })
            .collect();
        if gains.len() < DRAWS / 2 {
            continue;
        }
        gains.sort_by(f64::total_cmp);
        let at = |share: f64| gains[((gains.len() - 1) as f64 * share).round() as usize];
        all.insert(channel.name().to_owned(), [at(0.025), at(0.975)]);
    }
    all
}

/// Share of the free simulation's squared error above the sensors' noise that is left, by channel, on what
/// was held out.
pub fn unexplained(
    before: &Comparisons,
    after: &Comparisons,
    split: &Split,
    noise: &[f64; Quantity::COUNT],
) -> ByChannel {
    let mut all = ByChannel::new();
    for channel in COMPARED {
        let error = |comparisons: &Comparisons| {
            let mut sums = ErrorSums::default();
            for (drive, comparisons) in comparisons.iter().enumerate() {
                for compared in
                    comparisons.iter().filter(|s| s.channel == channel as u8 && split.is_held_out(drive, s.t))
                {
                    sums.add(compared.measured, compared.simulated);
                }
            }
            let variance = noise[channel as usize].powi(2);
            (sums.count > ErrorSums::LEAST).then(|| sums.error / sums.count - variance)
        };
        if let Some((before, after)) = error(before).zip(error(after))
            && before > 0.0
        {
            all.insert(channel.name().to_owned(), (after / before).max(0.0));
        }
    }
    all
}
