//! Signals that do not belong to the others: of another drive, another car, or another thing altogether.
//!
//! Yaw rate, lateral acceleration, steering and the wheels' differences all tell of the same curves. However wrong their
//! scales, signs and delays are, they move together: in real drives with curves their best correlation is above 0.8.
//! One that shares next to nothing with the others, while those agree, tells of other curves.

use super::report::{AuditFinding, ChainReport, Confidence};
use super::series::Series;
use physics::{Quantity, Wheel};

/// Rows are this far apart, s. Numerical: less than half of the smoothing.
const STRIDE_S: f64 = 0.04;
/// Delays up to this are looked through, s. Physical: twice the bound of `sensor_delay`.
const LONGEST_DELAY_S: f64 = 1.0;
/// Correlations above this are of signals of one drive, below that of two. Measured: of 33 real recordings those that
/// belong together have 0.82 and more where the car turns, the foreign ones 0.31 at most.
const TOGETHER: f64 = 0.7;
const APART: f64 = 0.4;
/// A witness that moves by less than this tells of no curves, rad/s as a yaw rate. Physical: gentle motorway curves.
const TURNING: f64 = 0.05;
/// Less driving is too little to tell, s: some curves.
const LEAST_S: f64 = 20.0;

/// Who tells of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Witness {
    Yaw,
    Lateral,
    Steering,
    RearWheels,
    FrontWheels,
}

impl Witness {
    const ALL: [Self; 5] = [Self::Yaw, Self::Lateral, Self::Steering, Self::RearWheels, Self::FrontWheels];

    fn name(self) -> &'static str {
        match self {
            Self::Yaw => Quantity::YawRate.name(),
            Self::Lateral => Quantity::LateralAcceleration.name(),
            Self::Steering => Quantity::SteeringWheelAngle.name(),
            Self::RearWheels => "rear wheels' difference",
            Self::FrontWheels => "front wheels' difference",
        }
    }

    /// A locked differential or a slipping wheel keeps wheels from telling of curves: alone they are never foreign.
    fn is_wheels(self) -> bool {
        matches!(self, Self::RearWheels | Self::FrontWheels)
    }

    /// As a yaw rate, without what goes with the speed: zeros of sensors, unequal radii.
    fn movement(self, series: &Series) -> Option<Vec<f64>> {
        let vehicle = &series.vehicle;
        let per_angle = 1.0 / (vehicle.steering_ratio.value * vehicle.wheelbase_m.value);
        let difference = |left: Wheel, right: Wheel, track: f64| {
            let (left, right) = (Quantity::wheel_speed(left), Quantity::wheel_speed(right));
            let to_yaw = vehicle.wheel_radius_m.value / track;
            series.smoothed(|row| to_yaw * (series.raw(right)[row] - series.raw(left)[row]))
        };
        let whole = match self {
            Self::Yaw => series.r.clone(),
            Self::Lateral => {
                let felt = series.smooth(Quantity::LateralAcceleration);
                felt.iter().zip(&series.v).map(|(felt, v)| felt / v).collect()
            }
            Self::Steering => {
                let angle = series.smooth(Quantity::SteeringWheelAngle);
                // Understeer of an ordinary car, as elsewhere: 0.0025 s²/m².
                let gain = |v: f64| v * per_angle / (1.0 + 0.0025 * v * v);
                angle.iter().zip(&series.v).map(|(angle, v)| angle * gain(*v)).collect()
            }
            Self::RearWheels => difference(Wheel::Rl, Wheel::Rr, vehicle.track_rear_m.value),
            Self::FrontWheels => difference(Wheel::Fl, Wheel::Fr, vehicle.track_front_m.value),
        };
        let stride = (STRIDE_S / series.dt).round().max(1.0) as usize;
        let rows = (0..series.len()).step_by(stride);
        let rows =
            rows.map(|row| if series.moves(row) { [whole[row], series.v[row]] } else { [f64::NAN; 2] });
        let own = without_speed(&rows.collect::<Vec<_>>())?;
        (spread(&own) > TURNING).then_some(own)
    }
}

/// What is left of each row's value without multiples of 1, v and 1/v.
fn without_speed(rows: &[[f64; 2]]) -> Option<Vec<f64>> {
    let regressors = |v: f64| nalgebra::Vector3::new(1.0, v, 1.0 / v);
    let mut a = nalgebra::Matrix3::zeros();
    let mut b = nalgebra::Vector3::zeros();
    let mut count = 0;
    for [value, v] in rows.iter().filter(|[value, v]| value.is_finite() && v.is_finite()) {
        let x = regressors(*v);
        a += x * x.transpose();
        b += x * *value;
        count += 1;
    }
    // The speed may not change at all: then one of the three is enough.
    a += nalgebra::Matrix3::identity() * (1e-9 * a.trace().max(1e-9));
    let theta = a.cholesky()?.solve(&b);
    let left = rows.iter().map(|[value, v]| value - regressors(*v).dot(&theta)).collect();
    (f64::from(count) * STRIDE_S > LEAST_S).then_some(left)
}

fn spread(values: &[f64]) -> f64 {
    let there = values.iter().filter(|value| value.is_finite());
    let (sum, count) = there.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
}

/// The largest correlation of two over all delays, its sign left out: which is which way round is asked later.
fn closeness(one: &[f64], other: &[f64]) -> f64 {
    let reach = (LONGEST_DELAY_S / STRIDE_S) as usize;
    let at = |later: &[f64], sooner: &[f64], lag: usize| {
        let pairs = later.iter().skip(lag).zip(sooner).filter(|(a, b)| a.is_finite() && b.is_finite());
        let (mut n, mut a, mut b, mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (x, y) in pairs {
            n += 1.0;
            a += x;
            b += y;
            aa += x * x;
            bb += y * y;
            ab += x * y;
        }
        let variances = (aa - a * a / n) * (bb - b * b / n);
        if variances > 0.0 { ((ab - a * b / n) / variances.sqrt()).abs() } else { 0.0 }
    };
    (0..=reach).flat_map(|lag| [at(one, other, lag), at(other, one, lag)]).fold(0.0, f64::max)
}

/// Finds the signals that share nothing with those that agree, and takes them out of the series: nothing can be told of
/// their scale or delay.
pub(super) fn signals(series: &mut Series, report: &mut ChainReport) {
    let witnesses: Vec<(Witness, Vec<f64>)> =
        Witness::ALL.into_iter().filter_map(|w| w.movement(series).map(|own| (w, own))).collect();
    let count = witnesses.len();
    let mut close = vec![vec![1.0; count]; count];
    for i in 0..count {
        for k in 0..i {
            let found = closeness(&witnesses[i].1, &witnesses[k].1);
            (close[i][k], close[k][i]) = (found, found);
        }
    }
    let with = |first: usize| {
        let mut group = vec![first];
        let mut at = 0;
        while at < group.len() {
            let next = (0..count).filter(|k| close[group[at]][*k] > TOGETHER && !group.contains(k));
            group.extend(next.collect::<Vec<_>>());
            at += 1;
        }
        group
    };
    // Those that the yaw rate agrees with; without any, the others that agree among themselves.
    let groups: Vec<Vec<usize>> = (0..count).map(with).filter(|group| group.len() > 1).collect();
    let Some(agreeing) = groups.first() else { return };
    let most = |of: usize| agreeing.iter().map(|k| close[of][*k]).fold(0.0, f64::max);
    let foreign: Vec<usize> = (0..count)
        .filter(|i| !agreeing.contains(i) && most(*i) < APART && !witnesses[*i].0.is_wheels())
        .collect();
    let name = |i: &usize| witnesses[*i].0.name();
    for i in &foreign {
        let those: Vec<_> = agreeing.iter().map(name).collect();
        let least = agreeing
            .iter()
            .flat_map(|a| agreeing.iter().filter(move |b| *b != a).map(|b| close[*a][*b]))
            .fold(1.0, f64::min);
        let company: Vec<_> = with(*i).iter().filter(|k| *k != i).map(name).collect();
        let also = if company.is_empty() {
            String::new()
        } else {
            format!("; it agrees with {}, which are foreign, too", company.join(" and "))
        };
        report.findings.push(AuditFinding {
            effect: AuditFinding::FOREIGN,
            channel: name(i).to_owned(),
            value: None,
            std: None,
            t: least.min(0.9999).atanh() * (series.moving_seconds() / LONGEST_DELAY_S).sqrt(),
            evidence: format!(
                "it tells of other curves than {}: of its movement they share {:.0} % at most, with each other {:.0} % \
                 and more{also}",
                those.join(", "),
                100.0 * most(*i).powi(2),
                100.0 * least.powi(2),
            ),
            confidence: Confidence::Certain,
            repair: "look for its right signal; if it is the right one, it was recorded on another drive than the \
                     others: join what belongs together"
                .to_owned(),
            or: Vec::new(),
        });
        // Wheels that go with it tell of the other drive's speed.
        let wheels = with(*i).iter().any(|k| witnesses[*k].0.is_wheels());
        series.forget(match witnesses[*i].0 {
            Witness::Yaw => Quantity::YawRate,
            Witness::Lateral => Quantity::LateralAcceleration,
            _ => Quantity::SteeringWheelAngle,
        });
        if wheels {
            Wheel::ALL.into_iter().for_each(|wheel| series.forget(Quantity::wheel_speed(wheel)));
        }
    }
    if !foreign.is_empty() {
        series.refresh();
    }
}
