//! Sim3 as an experiment of its own: what a straight drive tells of slope and friction.

use super::{Claim, Experiment, Outcome, Picture, SIM3, SIM3_LIMIT, SimulatedDrive};
use crate::report::{Color, Mark, Plot, Span};
use physics::Estimates;
use physics::estimate::{EstimatorsConfig, Pipeline};
use physics::estimates::MuSource;
use physics::model::{Scenario, Truth, Uncertain, Vehicle};

/// The experiment; the thesis shows Sim3 in Fig. 8.3 only.
pub const SIM3_EXPERIMENT: Experiment =
    Experiment { figure: "Sim3", title: "Slope and friction on a straight drive", run };

/// Drives that the claims stand on.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=20;

/// Seconds within which a change has to be found.
const WITHIN_S: f64 = 2.0;

/// What the pipeline published beside what was true.
pub type Rows = Vec<(Truth, Estimates)>;

/// Runs the pipeline over a drive. The car's data sheet is known, its tires are not.
pub fn published(drive: &SimulatedDrive) -> Rows {
    let unknown = Uncertain { value: 30.0, std: 15.0 };
    let vehicle = Vehicle { longitudinal_stiffness: unknown, ..drive.vehicle.clone() };
    let mut pipeline = Pipeline::new(&vehicle, &drive.sensors, &EstimatorsConfig::default());
    drive.samples.iter().zip(&drive.truth).map(|(sample, truth)| (*truth, *pipeline.step(sample))).collect()
}

/// Simulates and runs one of the test cases.
pub fn drive(text: &str, seed: u64) -> Result<Rows, String> {
    let scenario = Scenario::parse(text).map_err(|e| e.to_string())?;
    Ok(published(&SimulatedDrive::simulate(&scenario, seed)?))
}

/// Seconds of driving with |μ_x| > 0.05 between a change of surface and its being noticed, for each
/// change that was; and how many were noticed that were none.
pub fn noticed(rows: &Rows, changes: &[f64]) -> (Vec<f64>, u32) {
    let (mut found, mut wrong, mut count) = (Vec::new(), 0, 0);
    let mut changes = changes.iter().copied().peekable();
    let mut waiting = None;
    for (truth, estimates) in rows {
        if changes.next_if(|change| truth.time.seconds() >= *change).is_some() {
            waiting = Some(0.0);
        }
        if let Some(informative) = &mut waiting
            && (truth.fx[0] / truth.fz[0]).abs() > 0.05
        {
            *informative += 0.01;
        }
        if estimates.surface_changes > count {
            count = estimates.surface_changes;
            match waiting.take() {
                Some(informative) => found.push(informative),
                None => wrong += 1,
            }
        }
    }
    (found, wrong)
}

/// What the drives beyond the limit showed.
#[derive(Default)]
pub struct AtTheLimit {
    /// Drives.
    drives: u32,
    /// Drives in which a valid value came.
    found: u32,
    /// Latest first valid value after the limit was reached, s.
    latest_s: f64,
    /// Largest relative error of a valid value.
    worst: f64,
    /// Valid values before the limit was reached.
    early: u32,
}

impl AtTheLimit {
    /// Over these seeds.
    pub fn measure(seeds: impl Iterator<Item = u64>) -> Result<Self, String> {
        let mut all = Self::default();
        for seed in seeds {
            all.add(&drive(SIM3_LIMIT, seed)?);
        }
        Ok(all)
    }

    fn add(&mut self, rows: &Rows) {
        self.drives += 1;
        let mut reached = None;
        let mut first = None;
        for (truth, estimates) in rows {
            let t = truth.time.seconds();
            if truth.mu_used >= 0.999 * truth.mu_max {
                reached = reached.or(Some(t));
            }
            let (true, Some(mu)) = (estimates.friction.valid, estimates.friction.max) else { continue };
            match reached {
                Some(reached) => first = first.or(Some(t - reached)),
                None => self.early += 1,
            }
            self.worst = self.worst.max((mu / truth.mu_max - 1.0).abs());
        }
        if let Some(first) = first {
            self.found += 1;
            self.latest_s = self.latest_s.max(first);
        }
    }

    /// As a claim of ours.
    pub fn claim(&self) -> Claim {
        Claim::better(
            "at the halved limit the friction is a value, found from slip that grows while the force does not",
            format!(
                "{}/{} drives, within {:.2} s of reaching it, off by {:.1} % at most, {} values before",
                self.found,
                self.drives,
                self.latest_s,
                100.0 * self.worst,
                self.early
            ),
            self.found == self.drives && self.latest_s <= WITHIN_S && self.worst <= 0.05 && self.early == 0,
            "wanted: within 2 s and 5 %",
        )
    }
}

/// The claim that below the limit nothing but a bound is published.
pub fn bound_claim(drives: &[Rows]) -> Claim {
    let all = drives.iter().flatten();
    let values = all.clone().filter(|(_, e)| e.friction.max.is_some() || e.friction.valid).count();
    let above = all.clone().filter(|(t, e)| e.friction.low.is_some_and(|low| low > t.mu_max)).count();
    let bounds = all.clone().filter(|(_, e)| e.friction.source == MuSource::LowerBound).count();
    let most = all.map(|(t, _)| t.mu_used).fold(0.0, f64::max);
    Claim::better(
        "with μ_x below the limit the friction is a lower bound, never a value",
        format!("{values} values, {above} bounds above the truth in {bounds}; μ_x ≤ {most:.2}"),
        values == 0 && above == 0 && bounds > 0,
        "a piecewise linear tire is exactly linear there: nothing in the data depends on μ_max",
    )
}

fn run() -> Result<Outcome, String> {
    let drives = SEEDS.map(|seed| drive(SIM3, seed)).collect::<Result<Vec<_>, _>>()?;
    let outcomes: Vec<_> = drives.iter().map(|rows| noticed(rows, &[100.0, 150.0])).collect();
    let missed: usize = outcomes.iter().map(|(found, _)| 2 - found.len().min(2)).sum();
    let wrong: u32 = outcomes.iter().map(|(_, wrong)| wrong).sum();
    let slowest = outcomes.iter().flat_map(|(found, _)| found).copied().fold(0.0, f64::max);
    let claims = vec![
        Claim::better(
            "both steps of the slope are found, and no others",
            format!(
                "{} drives: within {slowest:.2} s of driving with |μ_x| > 0.05, {missed} missed, {wrong} wrong",
                drives.len()
            ),
            missed == 0 && wrong == 0 && slowest <= WITHIN_S,
            "wanted: within 2 s",
        ),
        bound_claim(&drives),
        AtTheLimit::measure(SEEDS)?.claim(),
    ];
    let limit = drive(SIM3_LIMIT, 1)?;
    let pictures = match drives.first() {
        Some(rows) => vec![
            slope_picture(rows),
            friction_picture("sim3_friction", "Sim3", rows),
            friction_picture("sim3_limit_friction", "Sim3 beyond the halved limit", &limit),
        ],
        None => vec![],
    };
    Ok(Outcome { claims, pictures })
}

/// The halved stretch.
pub fn halved() -> [Span; 1] {
    [Span { x: 100.0..150.0, label: "halved".into(), color: Color::Surface(1) }]
}

fn series(
    rows: &Rows,
    value: impl Fn(&Truth, &Estimates) -> Option<f64>,
) -> impl Iterator<Item = (f64, f64)> {
    rows.iter().map(move |(t, e)| (t.time.seconds(), value(t, e).unwrap_or(f64::NAN)))
}

fn slope_picture(rows: &Rows) -> Picture {
    let mut changes = 0;
    let marks: Vec<Mark> = rows
        .iter()
        .filter_map(|(t, e)| {
            let new = std::mem::replace(&mut changes, e.surface_changes) < e.surface_changes;
            new.then(|| Mark { x: t.time.seconds(), label: "noticed".into() })
        })
        .collect();
    let band = rows.iter().filter_map(|(t, e)| {
        let (low, high) = e.slope[0]?.ci95();
        Some((t.time.seconds(), low, high))
    });
    let plot = Plot::new("Sim3: slip slope of the front left wheel", "k, 1", 0.0..200.0, 0.0..100.0)
        .spans(&halved())
        .marks(&marks)
        .band("95 % interval", Color::First, band)
        .line("true", Color::Truth, series(rows, |t, _| Some(t.slope[0])))
        .line("estimated", Color::First, series(rows, |_, e| e.slope[0].map(|slope| slope.value)));
    Picture {
        name: "sim3_slope".into(),
        heading: "Sim3: the slip slope".into(),
        plot,
        caption:
            "Both steps are found within a second. While the torque is near zero (t around 37 and 87 s) \
                  nothing is learnt, and the interval widens."
                .into(),
    }
}

fn friction_picture(name: &str, title: &str, rows: &Rows) -> Picture {
    let band = rows.iter().filter_map(|(t, e)| Some((t.time.seconds(), e.friction.low?, e.friction.high?)));
    let plot = Plot::new(&format!("{title}: friction"), "μ, 1", 0.0..200.0, 0.0..1.1)
        .spans(&halved())
        .band("95 % interval of the value", Color::Second, band)
        .line("μ_max, true", Color::Truth, series(rows, |t, _| Some(t.mu_max)))
        .line("used, true", Color::OtherTruth, series(rows, |t, _| Some(t.mu_used)))
        .line("lower bound", Color::First, series(rows, |_, e| e.friction.low))
        .line("value", Color::Second, series(rows, |_, e| e.friction.max));
    Picture {
        name: name.into(),
        heading: format!("{title}: friction, used and available"),
        plot,
        caption: "A bound where the tires are below their limit; a value, with its interval, only where the \
                  driven wheels reached it. It widens as it ages, and is given up after 20 s."
            .into(),
    }
}
