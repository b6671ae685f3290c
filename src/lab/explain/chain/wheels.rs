//! The wheels among themselves: one that is far off, channels mixed up, unequal radii.

use nalgebra::{DMatrix, DVector};

use super::attribution::{AHEAD, Cause, Evidence, FOUND, attribute};
use super::regression::{SIGNIFICANT, student};
use super::relations::{Relation, link};
use super::report::{AuditFinding, ChainReport, Confidence};
use super::sensor_group::SensorGroup;
use super::series::Series;
use super::units;
use super::wheel_model::{AS_LABELLED, Order, Residuals, model};
use physics::model::DrivenAxle;
use physics::{Quantity, Wheel};

/// No tires differ by more, whatever their wear and pressure. Physical.
const TIRES_DIFFER: f64 = 0.03;
/// Logarithm of the likelihood ratio: to be named, and to be sure. Statistical: likelihood ratios of e¹² and e²⁵.
const NAMED: f64 = 12.0;
const SURE: f64 = 25.0;
/// Radii that differ by this much matter to slip, and by that much are worn or of another kind. Physical.
const RADIUS_MATTERS: f64 = 0.003;
const RADIUS_SURE: f64 = 0.005;
/// How well radii can be seen within an axle and between axles: tooth wheels, free rolling. Physical.
const WITHIN_AXLE: f64 = 3e-4;
const BETWEEN_AXLES: f64 = 1.5e-3;

fn speed(wheel: Wheel) -> Quantity {
    Quantity::wheel_speed(wheel)
}

/// Factors between these are no unit and no sign: there curves have to be told from errors. Physical: what the inner and
/// the outer wheel of the tightest curve have.
const CURVES: std::ops::Range<f64> = 0.75..1.33;
/// Where the other axle's wheels differ by less, and would by the yaw rate, the car goes straight. Physical: radii of
/// 100 m and more.
const STRAIGHT: f64 = 0.015;
/// For so long, s. Statistical: some blocks.
const STRAIGHT_S: f64 = 8.0;
/// Rows that are too few to tell, and blocks of seconds. Statistical: a median, and that it is not one place's.
const LEAST_ROWS: usize = 200;
const LEAST_BLOCKS: usize = 3;

/// A wheel that is far from the others: sign, unit, wrong signal. Put right in the series.
pub(super) fn unit_factors(series: &mut Series, report: &mut ChainReport) {
    let track = series.vehicle.track_rear_m.value;
    for wheel in Wheel::ALL {
        let (mut everywhere, mut straight) = (Vec::new(), Vec::new());
        let mut blocks = std::collections::BTreeSet::new();
        for row in 0..series.len() {
            let speeds = Wheel::ALL.map(|wheel| series.raw(speed(wheel))[row]);
            let own = speeds[wheel as usize];
            let mut sorted = speeds;
            sorted.sort_by(f64::total_cmp);
            let middle = 0.5 * (sorted[1] + sorted[2]);
            // With a wheel missing there is no middle.
            if !(middle > 1.0 && speeds.iter().all(|speed| speed.is_finite())) {
                continue;
            }
            everywhere.push(own / middle);
            let [left, right] =
                if wheel.is_front() { [speeds[2], speeds[3]] } else { [speeds[0], speeds[1]] };
            let turning = track * series.r[row] / series.v[row];
            if (left - right).abs() < STRAIGHT * middle && turning.abs() < STRAIGHT {
                straight.push(own / middle);
                blocks.insert(series.block(row));
            }
        }
        if everywhere.len() < LEAST_ROWS {
            continue;
        }
        let mut ratios = everywhere;
        ratios.sort_by(f64::total_cmp);
        let mut place = "half of the time";
        if CURVES.contains(&ratios[ratios.len() / 2]) {
            if straight.len() < LEAST_ROWS || blocks.len() < LEAST_BLOCKS {
                continue;
            }
            ratios = straight;
            ratios.sort_by(f64::total_cmp);
            place = "going straight";
        }
        let median = ratios[ratios.len() / 2];
        let spread = 0.5 * (ratios[ratios.len() * 84 / 100] - ratios[ratios.len() * 16 / 100]);
        // A second of rows says the same.
        let std = spread * (series.dt.recip() / ratios.len() as f64).sqrt();
        if median > 0.0 && (median - 1.0).abs() < TIRES_DIFFER {
            continue;
        }
        if median < 0.01 && median > -0.01 {
            report
                .unclear(format!("{} stands still while the others turn", speed(wheel)), "check its signal");
            continue;
        }
        let negative = median < 0.0;
        let words = units::mistake(SensorGroup::Wheels, median.abs(), std, &series.vehicle);
        report.findings.push(AuditFinding {
            effect: if negative { "sensor_sign" } else { "sensor_scale" },
            channel: speed(wheel).name().to_owned(),
            value: (!negative).then_some(median - 1.0),
            std: (!negative).then_some(std),
            t: (median - 1.0).abs() / std.max(1e-9),
            evidence: format!("{median:.4} times the middle of the four wheel speeds, {place}"),
            confidence: if CURVES.contains(&median) && (median - 1.0).abs() < TIRES_DIFFER + 4.0 * std {
                Confidence::Likely
            } else {
                Confidence::Certain
            },
            repair: match words {
                Some(words) if !negative => words.to_owned(),
                _ => format!("multiply its gain by {:.4}", 1.0 / median),
            },
            or: Vec::new(),
        });
        series.scale(speed(wheel), 1.0 / median);
    }
}

/// A way in which channels may be mixed up, and how much more likely it is than no mistake.
#[derive(Clone)]
struct Candidate {
    /// Logarithm of the likelihood ratio.
    ratio: f64,
    /// The same without the block that speaks for it most.
    robust: f64,
    pairs: Vec<(Wheel, Wheel)>,
}

/// The ways in which channels are mixed up: one pair, or the same mistake twice.
fn orders() -> Vec<(Order, Vec<(Wheel, Wheel)>)> {
    use Wheel::{Fl, Fr, Rl, Rr};
    let swaps: [&[(Wheel, Wheel)]; 9] = [
        &[(Fl, Fr)],
        &[(Rl, Rr)],
        &[(Fl, Rl)],
        &[(Fr, Rr)],
        &[(Fl, Rr)],
        &[(Fr, Rl)],
        &[(Fl, Fr), (Rl, Rr)],
        &[(Fl, Rl), (Fr, Rr)],
        &[(Fl, Rr), (Fr, Rl)],
    ];
    swaps
        .into_iter()
        .map(|pairs| {
            let mut order = AS_LABELLED;
            pairs.iter().for_each(|(one, other)| order.swap(*one as usize, *other as usize));
            (order, pairs.to_vec())
        })
        .collect()
}

/// How much more likely the second is, as the logarithm of the ratio: in all, and without the block that
/// speaks for it most.
fn likelihood_ratio(labelled: &[Residuals; 3], swapped: &[Residuals; 3]) -> (f64, f64) {
    let mut blocks: std::collections::BTreeMap<usize, f64> = std::collections::BTreeMap::new();
    for (one, other) in labelled.iter().zip(swapped) {
        let variance = one.variance.min(other.variance);
        for ((block, a), (_, b)) in one.blocks.iter().zip(&other.blocks) {
            *blocks.entry(*block).or_default() += (a - b) / (2.0 * variance);
        }
    }
    let total: f64 = blocks.values().sum();
    (total, total - blocks.values().copied().fold(0.0, f64::max))
}

/// Channels that belong to other wheels than they are said to. Put right in the series.
pub(super) fn swaps(series: &mut Series, report: &mut ChainReport) {
    // A yaw rate in the wrong unit is still to be found out.
    let gains: Vec<f64> = [Relation::RearWheels, Relation::FrontWheels]
        .into_iter()
        .filter_map(|relation| link(series, relation))
        .filter(|link| link.is_clear)
        .map(|link| link.gain.abs())
        .collect();
    let gain = gains.iter().copied().reduce(|a, b| a.max(b)).unwrap_or(1.0);
    let turn = if (0.75..1.33).contains(&gain) { 1.0 } else { gain };
    let Some((_, labelled)) = model(series, AS_LABELLED, turn) else { return };
    let mut candidates: Vec<Candidate> = orders()
        .into_iter()
        .filter_map(|(order, pairs)| {
            let (_, residuals) = model(series, order, turn)?;
            let (ratio, robust) = likelihood_ratio(&labelled, &residuals);
            Some(Candidate { ratio, robust, pairs })
        })
        .collect();
    candidates.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    let Some(Candidate { ratio, robust, pairs }) = candidates.first().cloned() else { return };
    if ratio < NAMED || robust < 0.25 * NAMED {
        return;
    }
    let rivals: Vec<&Candidate> =
        candidates[1..].iter().filter(|rival| ratio - rival.ratio < NAMED && rival.ratio > NAMED).collect();
    let along = pairs.iter().all(|(one, other)| one.same_side() == *other);
    let mut or: Vec<String> =
        rivals.iter().map(|rival| format!("channel_swap of {}", names(&rival.pairs))).collect();
    if along && pairs.len() == 2 && series.vehicle.driven_axle != DrivenAxle::All {
        or.push("[vehicle] driven_axle names the wrong axle".to_owned());
    }
    let confidence = match (ratio > SURE && robust > NAMED, or.is_empty()) {
        (true, true) => Confidence::Certain,
        (_, true) => Confidence::Likely,
        _ if rivals.is_empty() => Confidence::Likely,
        _ => Confidence::Unclear,
    };
    for (one, other) in &pairs {
        report.findings.push(AuditFinding {
            effect: "channel_swap",
            channel: format!("{}/{}", speed(*one), speed(*other)),
            value: None,
            std: None,
            t: (2.0 * ratio).sqrt(),
            evidence: format!(
                "the wheels' differences in curves and under drive and brake forces fit the exchanged channels \
                 better by a likelihood ratio of exp({ratio:.0})"
            ),
            confidence,
            repair: format!("exchange the signals of {} and {}", speed(*one), speed(*other)),
            or: or.clone(),
        });
        series.swap(speed(*one), speed(*other));
    }
    series.refresh();
}

fn names(pairs: &[(Wheel, Wheel)]) -> String {
    pairs.iter().map(|(a, b)| format!("{}/{}", speed(*a), speed(*b))).collect::<Vec<_>>().join(" and ")
}

/// The difference of an axle's radii that is certain, where it is told with this standard deviation.
pub fn certain_radius(std: f64) -> f64 {
    RADIUS_SURE.max((2.0 * FOUND).sqrt() * std)
}

/// Did the car go straight for a while, or round both ways? Going round one way, a small wheel, a zero of the yaw rate
/// and a track that is a little wider look all the same.
fn tells_radii(series: &Series) -> bool {
    let track = series.vehicle.track_rear_m.value;
    let slopes: Vec<f64> = (0..series.len())
        .filter(|row| series.moves(*row))
        .map(|row| track * series.r[row] / series.v[row])
        .filter(|slope| slope.is_finite())
        .collect();
    let seconds =
        |of: &dyn Fn(f64) -> bool| slopes.iter().filter(|slope| of(**slope)).count() as f64 * series.dt;
    let straight = seconds(&|slope| slope.abs() < STRAIGHT);
    let curves = [1.0, -1.0].map(|side| seconds(&|slope| side * slope > STRAIGHT));
    straight > STRAIGHT_S || curves.iter().all(|seconds| *seconds > STRAIGHT_S)
}

/// Wheels whose tires are smaller or larger than the others.
pub(super) fn radii(series: &Series, report: &mut ChainReport) {
    let Some((fit, _)) = model(series, AS_LABELLED, 1.0) else { return };
    if !tells_radii(series) {
        report.unclear("radii of the tires", "drive straight ahead for a while, or curves to both sides");
        return;
    }
    let widened = student(fit.along.blocks) / SIGNIFICANT;
    let stds = [fit.axles[0].std[2], fit.axles[1].std[2], fit.along.std[3]].map(|std| widened * std);
    let mut seen = vec![fit.axles[0].value[2], fit.axles[1].value[2], fit.along.value[3]];
    let model_error = [WITHIN_AXLE, WITHIN_AXLE, BETWEEN_AXLES];
    let covariance =
        DMatrix::from_diagonal(&DVector::from_fn(3, |i, _| stds[i].powi(2) + model_error[i].powi(2)));
    report.radii = Some([0, 1].map(|axle| covariance[(axle, axle)].sqrt()));
    // A larger tire turns more slowly.
    let causes = |wheel: Wheel| -> Vec<f64> {
        let side = if wheel.is_left() { 1.0 } else { -1.0 };
        if wheel.is_front() { vec![side, 0.0, -0.5] } else { vec![0.0, side, 0.5] }
    };
    for _ in 0..2 {
        let evidence = Evidence { seen: seen.clone(), covariance: covariance.clone() };
        let all: Vec<Cause<Wheel>> =
            Wheel::ALL.iter().map(|wheel| Cause { channel: *wheel, pattern: causes(*wheel) }).collect();
        let Some((_, explanations)) = attribute(&evidence, &all) else { return };
        let Some(best) = explanations.first().copied() else { return };
        if best.gain < FOUND || best.value.abs() < RADIUS_MATTERS {
            return;
        }
        let rivals = || explanations[1..].iter().filter(|other| best.gain - other.gain < AHEAD);
        let ahead = rivals().next().is_none();
        // Of an axle's two wheels one too small and the other too large differ by little only.
        let axle_ahead = rivals().all(|other| other.channel.is_front() == best.channel.is_front());
        let sure = axle_ahead && best.value.abs() > certain_radius(best.std);
        report.findings.push(AuditFinding {
            effect: "tire_radius",
            channel: speed(best.channel).name().to_owned(),
            value: Some(best.value),
            std: Some(best.std),
            t: best.gain.sqrt(),
            evidence: format!(
                "straight ahead the wheels differ: front right − left {:+.3} %, rear right − left {:+.3} %, \
                 front − rear {:+.3} %{}",
                100.0 * seen[0],
                100.0 * seen[1],
                100.0 * seen[2],
                if axle_ahead && !ahead { "; which of the axle's two it is does not show" } else { "" }
            ),
            confidence: match (sure, ahead) {
                (true, _) => Confidence::Certain,
                (_, true) => Confidence::Likely,
                _ => Confidence::Unclear,
            },
            repair: format!(
                "multiply its gain by {:.5}; or check tire size, wear and pressure of this wheel",
                1.0 + best.value
            ),
            or: rivals()
                .map(|other| format!("{} ({:+.2} %)", speed(other.channel), 100.0 * other.value))
                .collect(),
        });
        for (value, part) in seen.iter_mut().zip(causes(best.channel)) {
            *value -= part * best.value;
        }
    }
}
