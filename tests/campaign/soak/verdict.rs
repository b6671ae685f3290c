//! What is flagged valid, against the truth of the simulation.

use std::collections::BTreeMap;
use std::fmt;

use gripd::estimates::Estimate;
use gripd::model::Truth;
use gripd::{Estimates, Micros};

/// What is judged.
const NAMES: [&str; 4] = ["slope", "cornering stiffness", "sideslip", "friction"];
/// Off by more is wrong: two of stiffness, relative; sideslip, rad; friction. As tests/engine/faults and tests/campaign/drives have it.
const LIMITS: [f64; 4] = [0.35, 0.35, 0.05, 0.1];

/// In so much of the time they may be wrong by the faults, percent.
const MOST_BY_FAULTS: [f64; 4] = [3.0, 4.0, 0.5, 0.2];

/// Of each: how far what is valid is off, and what it should be; `None` where nothing is valid.
pub type Offs = [Option<(f64, f64)>; 4];

/// What is published as slope is that of the straight line through the slips in use, which lies below a brush tire's
/// slope at zero slip.
#[derive(Default)]
pub struct Secant {
    /// The largest share of the friction that was in use lately.
    used: f64,
    friction: f64,
    unchanged_s: f64,
}

impl Secant {
    /// For so many rows of truth a use of friction counts: half a minute.
    const MEMORY: f64 = 3000.0;

    fn unchanged_s(&mut self, truth: &Truth) -> f64 {
        // Over a tenth of a second; a slippery side under a car that leans changes little.
        let before = self.friction;
        self.friction += 0.1 * (truth.mu_max - self.friction);
        let changes = (truth.mu_max / before - 1.0).abs() > 0.1;
        self.unchanged_s = if changes { 0.0 } else { self.unchanged_s + 0.01 };
        self.unchanged_s
    }

    /// The least share of the slope at zero slip that may be found after this row.
    fn share(&mut self, truth: &Truth) -> f64 {
        let used = (truth.mu_used / truth.mu_max).clamp(0.0, 1.0);
        self.used = used.max(self.used * (1.0 - 1.0 / Self::MEMORY));
        // Brush: F/μ = 1 − (1 − x)³ with x = C s/(3 μ).
        let x = 1.0 - (1.0 - self.used).cbrt();
        if x > 0.0 { self.used / (3.0 * x) } else { 1.0 }
    }
}

/// What is true, as far as it is judged.
#[derive(Clone, Copy, Debug)]
pub struct True {
    pub time: Micros,
    slope: [f64; 4],
    /// The share of the slope that the straight line through a bent curve may have.
    secant: f64,
    cornering: [f64; 2],
    sideslip: f64,
    friction: f64,
    /// Since the road became another one, s.
    pub unchanged_s: f64,
}

impl True {
    /// At one instant, the next after those that the secant has seen.
    pub fn of(truth: &Truth, secant: &mut Secant) -> Self {
        Self {
            time: truth.time,
            slope: truth.slope,
            secant: secant.share(truth),
            cornering: [truth.cornering_front, truth.cornering_rear],
            sideslip: truth.sideslip,
            friction: truth.mu_max,
            unchanged_s: secant.unchanged_s(truth),
        }
    }
}

/// Judges a sample.
pub fn offs(truth: &True, estimates: &Estimates) -> Offs {
    let slope = |is: &Option<Estimate>, slope: f64| {
        let ratio = is.as_ref()?.value / slope;
        // Anywhere between the secant and the slope at zero slip it is right.
        Some((ratio - ratio.clamp(truth.secant, 1.0), slope))
    };
    let slopes = estimates.slope.iter().zip(truth.slope).filter_map(|(is, truth)| slope(is, truth));
    let relative = |is: &[Option<Estimate>], truth: &[f64]| {
        let both =
            is.iter().zip(truth).filter_map(|(is, truth)| Some((is.as_ref()?.value / truth - 1.0, *truth)));
        both.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
    };
    let Estimates { motion, friction, .. } = estimates;
    let sideslip = motion.sideslip.map(|sideslip| (sideslip - truth.sideslip, truth.sideslip));
    let max = friction.max.map(|max| (max - truth.friction, truth.friction));
    [
        slopes.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).filter(|_| estimates.slope_valid),
        relative(&estimates.cornering, &truth.cornering).filter(|_| estimates.cornering_valid),
        sideslip.filter(|_| motion.valid),
        max.filter(|_| friction.valid),
    ]
    .map(|off| off.filter(|(off, _)| off.is_finite()))
}

/// Is it so far off that it is wrong?
fn is_wrong(which: usize, off: Option<(f64, f64)>) -> bool {
    off.is_some_and(|(off, _)| off.abs() > LIMITS[which])
}

/// Samples of one quantity.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    valid: u64,
    wrong: u64,
}

/// What became wrong after a fault began, though it was not without.
#[derive(Clone, Copy, Debug)]
struct Blame {
    samples: u64,
    most_off: f64,
    truth: f64,
    at_s: f64,
}

/// All that was judged.
#[derive(Clone, Debug, Default)]
pub struct Verdict {
    samples: u64,
    without: [Count; 4],
    with: [Count; 4],
    /// Wrong with faults, and not without them.
    by_faults: [u64; 4],
    /// Of these, within two minutes after the road became another one.
    on_another_road: [u64; 4],
    blamed: BTreeMap<(&'static str, usize), Blame>,
    /// Pieces that began with each fault.
    pub faults: BTreeMap<&'static str, u64>,
}

impl Verdict {
    /// A sample of the drive without faults.
    pub fn without(&mut self, offs: &Offs) {
        self.samples += 1;
        count(&mut self.without, offs);
    }

    /// A sample of the drive with them, beside the same without.
    pub fn with(&mut self, offs: &Offs, clean: &Offs, blamed: &'static str, at: Micros, unchanged_s: f64) {
        count(&mut self.with, offs);
        for which in 0..NAMES.len() {
            let Some((off, truth)) = offs[which].filter(|_| is_wrong(which, offs[which])) else { continue };
            if is_wrong(which, clean[which]) {
                continue;
            }
            self.by_faults[which] += 1;
            self.on_another_road[which] += u64::from(unchanged_s < 120.0);
            let none = Blame { samples: 0, most_off: 0.0, truth, at_s: 0.0 };
            let blame = self.blamed.entry((blamed, which)).or_insert(none);
            blame.samples += 1;
            if off.abs() > blame.most_off.abs() {
                *blame = Blame { samples: blame.samples, most_off: off, truth, at_s: at.seconds() };
            }
        }
    }

    fn share(part: u64, all: u64) -> f64 {
        100.0 * part as f64 / all.max(1) as f64
    }

    /// What holds today: little becomes wrong that is not wrong without faults. Nothing should.
    #[track_caller]
    pub fn is_good(&self) {
        assert!(self.samples > 10_000 && !self.faults.is_empty(), "{self}");
        for (which, by_faults) in self.by_faults.into_iter().enumerate() {
            assert!(self.with[which].valid > 0, "{self}");
            assert!(Self::share(by_faults, self.samples) < MOST_BY_FAULTS[which], "{}: {self}", NAMES[which]);
        }
    }
}

fn count(counts: &mut [Count; 4], offs: &Offs) {
    for (which, count) in counts.iter_mut().enumerate() {
        count.valid += u64::from(offs[which].is_some());
        count.wrong += u64::from(is_wrong(which, offs[which]));
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "| flagged valid | without faults | of it wrong | with faults | of it wrong | wrong by the faults | of it within 2 minutes of a change of road |"
        )?;
        writeln!(f, "|---|---|---|---|---|---|---|")?;
        for (which, name) in NAMES.iter().enumerate() {
            let (without, with) = (self.without[which], self.with[which]);
            writeln!(
                f,
                "| {name} | {:.2} % | {:.3} % | {:.2} % | {:.3} % | {:.1} s | {:.0} % |",
                Self::share(without.valid, self.samples),
                Self::share(without.wrong, without.valid),
                Self::share(with.valid, self.samples),
                Self::share(with.wrong, with.valid),
                0.01 * self.by_faults[which] as f64,
                Self::share(self.on_another_road[which], self.by_faults[which])
            )?;
        }
        let mut blamed: Vec<_> = self.blamed.iter().collect();
        blamed.sort_by_key(|(_, blame)| std::cmp::Reverse(blame.samples));
        for ((fault, which), blame) in blamed {
            writeln!(
                f,
                "  {} wrong for {:.2} s after \"{fault}\" ({} times), most by {:+.3} (truth {:.3}) at {:.1} s",
                NAMES[*which],
                0.01 * blame.samples as f64,
                self.faults.get(fault).copied().unwrap_or(0),
                blame.most_off,
                blame.truth,
                blame.at_s
            )?;
        }
        Ok(())
    }
}
