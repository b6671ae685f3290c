//! What was found against what was true.

use std::ops::Range;

use super::row::Row;
use physics::estimate::EstimatorsConfig;
use physics::model::{Scenario, Truth};
use physics::{Wheel, model};

/// A stretch of one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    pub name: String,
    /// From and to, s.
    pub time: Range<f64>,
}

/// A surface change that really was one.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// When, s.
    pub at: f64,
    /// To which surface.
    pub to: String,
    /// Until it was noticed, s; not at all on this surface: none.
    pub delay: Option<f64>,
}

/// Slip slopes as a perfect measurement with a linear tire would find them: the straight line through
/// all forces and slips of the drive on this surface so far.
///
/// A tire's curve bends down from the first newton on. So this is below the stiffness at zero slip, by
/// the more the more of the friction is used; and it is what a linear estimate can find at best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InUse {
    /// Of each wheel, by its static load; not a number until there was force enough.
    pub slope: [f64; 4],
}

/// How good one published number was.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    pub name: &'static str,
    /// Share of the drive in which it was published as valid.
    pub valid: f64,
    /// Share of the valid ones whose 95 % interval has the truth in it; not a number where no interval
    /// is published.
    pub covered: f64,
    /// Root mean square of the error of the valid ones.
    pub rms: f64,
    /// Mean of the error of the valid ones.
    pub bias: f64,
    /// Of the error, and how many decimals of it are worth printing.
    pub unit: &'static str,
    pub decimals: usize,
}

/// Everything that is told of a drive.
pub struct Findings {
    pub surfaces: Vec<Surface>,
    pub changes: Vec<Change>,
    /// When surface changes were noticed, s, and whether there was one.
    pub notices: Vec<(f64, bool)>,
    /// Beside the rows of truth.
    pub in_use: Vec<InUse>,
    pub quality: Vec<Quality>,
}

impl Findings {
    /// Compares.
    pub fn new(scenario: &Scenario, truth: &[Truth], rows: &[Row], config: &EstimatorsConfig) -> Self {
        let surfaces = surfaces(scenario);
        let in_use = in_use(scenario, truth, &surfaces, config);
        let (changes, notices) = changes(&surfaces, rows);
        let quality = quality(truth, &in_use, rows);
        Self { surfaces, changes, notices, in_use, quality }
    }

    /// Notices that nothing had changed for.
    pub fn false_notices(&self) -> usize {
        self.notices.iter().filter(|(_, right)| !right).count()
    }
}

/// The last row of truth that is not after this time.
pub fn at(truth: &[Truth], time: f64) -> Option<usize> {
    truth.partition_point(|row| row.time.seconds() <= time).checked_sub(1)
}

fn surfaces(scenario: &Scenario) -> Vec<Surface> {
    let mut starts: Vec<(f64, &str)> = Vec::new();
    if scenario.road.iter().all(|stretch| stretch.from_s > 0.0) {
        starts.push((0.0, "road"));
    }
    starts.extend(scenario.road.iter().map(|stretch| (stretch.from_s, stretch.name.as_str())));
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ends = starts.iter().skip(1).map(|start| start.0).chain([scenario.duration_s]);
    let surface =
        |((from, name), to): (&(f64, &str), f64)| Surface { name: (*name).to_owned(), time: *from..to };
    starts.iter().zip(ends).map(surface).filter(|surface| !surface.time.is_empty()).collect()
}

fn changes(surfaces: &[Surface], rows: &[Row]) -> (Vec<Change>, Vec<(f64, bool)>) {
    let mut count = 0;
    let mut notices: Vec<(f64, bool)> = Vec::new();
    for Row { round, .. } in rows {
        if round.surface_changes > count {
            notices.push((round.time, false));
        }
        count = round.surface_changes;
    }
    let change = |surface: &Surface| {
        let noticed = notices.iter_mut().find(|(time, _)| surface.time.contains(time));
        let delay = noticed.map(|(time, right)| {
            *right = true;
            *time - surface.time.start
        });
        Change { at: surface.time.start, to: surface.name.clone(), delay }
    };
    let changes = surfaces.iter().skip(1).map(change).collect();
    (changes, notices)
}

/// Sums for the line through the origin.
#[derive(Clone, Copy, Default)]
struct Line {
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Line {
    /// Below this much Σ force² (3 % of the load for a second) the line is not told.
    const ENOUGH: f64 = 0.03 * 0.03 * 100.0;

    fn add(&mut self, x: f64, y: f64) {
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    fn slope(&self) -> f64 {
        if self.yy < Self::ENOUGH { f64::NAN } else { self.xy / self.xx }
    }
}

fn in_use(
    scenario: &Scenario,
    truth: &[Truth],
    surfaces: &[Surface],
    config: &EstimatorsConfig,
) -> Vec<InUse> {
    let vehicle = &scenario.vehicle;
    let load = Wheel::ALL.map(|wheel| vehicle.static_wheel_load(wheel.is_front()));
    let mut now = usize::MAX;
    let mut along = [Line::default(); 4];
    let row = |truth: &Truth| {
        let time = truth.time.seconds();
        let surface = surfaces.iter().rposition(|surface| surface.time.start <= time).unwrap_or(0);
        if surface != now {
            now = surface;
            along = [Line::default(); 4];
        }
        let is_straight = truth.lateral_acceleration.abs() < config.slope.max_lateral_acceleration_mps2;
        if truth.speed > config.minimum_speed_mps && truth.brake_torque == 0.0 && is_straight {
            for (i, line) in along.iter_mut().enumerate() {
                line.add(truth.slip[i], truth.fx[i] / load[i]);
            }
        }
        let driven = |wheel: Wheel| {
            if vehicle.driven_axle.drives(wheel) { along[wheel as usize].slope() } else { f64::NAN }
        };
        InUse { slope: Wheel::ALL.map(driven) }
    };
    truth.iter().map(row).collect()
}

/// One comparison: estimate, half-width of the 95 % interval, truth.
type Compared = (f64, f64, f64);

fn quality(truth: &[Truth], in_use: &[InUse], rows: &[Row]) -> Vec<Quality> {
    let judge = |name, (unit, decimals), compare: &dyn Fn(&Row, &Truth, &InUse) -> Option<Compared>| {
        let compared: Vec<Compared> = rows
            .iter()
            .filter_map(|row| {
                let index = at(truth, row.round.time)?;
                let (estimate, half, true_) = compare(row, truth.get(index)?, in_use.get(index)?)?;
                (estimate.is_finite() && true_.is_finite()).then_some((estimate, half, true_))
            })
            .collect();
        let count = compared.len() as f64;
        let mean = |value: &dyn Fn(&Compared) -> f64| compared.iter().map(value).sum::<f64>() / count;
        let intervals = compared.iter().all(|(_, half, _)| half.is_finite());
        Quality {
            name,
            valid: count / rows.len().max(1) as f64,
            covered: if intervals {
                mean(&|(estimate, half, truth)| f64::from(u8::from((estimate - truth).abs() <= *half)))
            } else {
                f64::NAN
            },
            rms: mean(&|(estimate, _, truth)| (estimate - truth).powi(2)).sqrt(),
            bias: mean(&|(estimate, _, truth)| estimate - truth),
            unit,
            decimals,
        }
    };
    let slope = |wheel: usize| {
        move |row: &Row, _: &Truth, in_use: &InUse| {
            let round = &row.round;
            round.slope_valid.then(|| (round.slope[wheel], 1.96 * round.slope_std, in_use.slope[wheel]))
        }
    };
    let offset = |wheel: usize| {
        move |row: &Row, truth: &Truth, _: &InUse| {
            let round = &row.round;
            let published = (round.offset[wheel], 1.96 * round.offset_std, truth.slip_offset[wheel]);
            round.slope_valid.then_some(published)
        }
    };
    let cornering = |axle: usize| {
        move |row: &Row, truth: &Truth, _: &InUse| {
            let round = &row.round;
            let half = 1.96 * round.cornering_std[axle];
            let truth = [truth.cornering_front, truth.cornering_rear][axle];
            round.cornering_valid.then_some((round.cornering[axle], half, truth))
        }
    };
    let degrees = |row: &Row, truth: &Truth, _: &InUse| {
        let [estimate, truth] = [row.round.sideslip, truth.sideslip].map(f64::to_degrees);
        row.round.motion_valid.then_some((estimate, f64::NAN, truth))
    };
    vec![
        judge("Slip slope, front left", ("", 1), &slope(0)),
        judge("Slip slope, front right", ("", 1), &slope(1)),
        judge("Slip offset, front left", ("", 5), &offset(0)),
        judge("Slip offset, front right", ("", 5), &offset(1)),
        judge("Cornering stiffness, front", ("1/rad", 1), &cornering(0)),
        judge("Cornering stiffness, rear", ("1/rad", 1), &cornering(1)),
        judge("Sideslip", ("°", 2), &degrees),
        friction(truth, rows),
        lower_bound(truth, rows),
    ]
}

/// The friction and its interval, which need not be symmetrical.
fn friction(truth: &[Truth], rows: &[Row]) -> Quality {
    let valid: Vec<_> = rows.iter().filter(|row| row.round.mu_valid).collect();
    let errors: Vec<(f64, bool)> = valid
        .iter()
        .filter_map(|row| {
            let (round, mu) = (&row.round, truth.get(at(truth, row.round.time)?)?.mu_max);
            // Without an end the interval is open.
            let inside = !(mu < round.mu_low || mu > round.mu_high);
            Some((round.mu_max - mu, inside))
        })
        .collect();
    let count = errors.len() as f64;
    Quality {
        name: "Friction available",
        valid: count / rows.len().max(1) as f64,
        covered: errors.iter().filter(|(_, inside)| *inside).count() as f64 / count,
        rms: (errors.iter().map(|(error, _)| error * error).sum::<f64>() / count).sqrt(),
        bias: errors.iter().map(|(error, _)| error).sum::<f64>() / count,
        unit: "",
        decimals: 2,
    }
}

/// Friction is at least so much: told nearly always, and true or not.
fn lower_bound(truth: &[Truth], rows: &[Row]) -> Quality {
    let told: Vec<bool> = rows
        .iter()
        .filter(|row| row.round.mu_low.is_finite())
        .filter_map(|row| Some(row.round.mu_low <= truth.get(at(truth, row.round.time)?)?.mu_max))
        .collect();
    let count = told.len() as f64;
    Quality {
        name: "Friction, lower bound",
        valid: count / rows.len().max(1) as f64,
        covered: told.iter().filter(|right| **right).count() as f64 / count,
        rms: f64::NAN,
        bias: f64::NAN,
        unit: "",
        decimals: 2,
    }
}

/// Wheels that are driven, for plots and tables.
pub fn driven(vehicle: &model::Vehicle) -> Vec<Wheel> {
    Wheel::ALL.into_iter().filter(|wheel| vehicle.driven_axle.drives(*wheel)).collect()
}
