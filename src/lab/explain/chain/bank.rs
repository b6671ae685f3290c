//! A banked road beside a wrong accelerometer. On an oval the bank comes with the curve: it takes from the lateral acceleration what
//! a sensor that reads too little would, and later, where the bank begins or ends later. Quick corrections would tell the two
//! apart, as no road follows them; long curves alone do not.

use std::ops::Range;

use super::relations::{Link, Relation};
use super::report::ChainReport;
use super::series::Series;

/// Slower than this is a curve of the road, quicker is what the driver does in it, s. Physical: a bank comes and goes over 50 to
/// 100 m, a second or two on a fast road.
const LONG_S: f64 = 4.0;

/// What is quick must have this share of the variance of speed × yaw rate, lest long curves say it all. Tuned: it has 0.09 on a
/// simulated oval whose bank was called a scale of 0.66, 0.05 to 0.08 on a race track, 0.19 and more on a lot and in a city.
const LEAST_QUICK: f64 = 0.15;

/// Roads are banked towards the inside of a curve: a sensor reads so many times what it should, and up to 15° at 1 g. Roll of the
/// body makes it read more.
const SCALES: Range<f64> = 0.4..0.9;

/// A delay that is shorter is none of a road's, s.
const LEAST_DELAY_S: f64 = 0.1;

/// Leaves out what lateral acceleration and yaw rate say of scales or delays, where a banked road may say it as well.
pub(super) fn without_banks(series: &Series, mut links: Vec<Link>, report: &mut ChainReport) -> Vec<Link> {
    let Some(link) = links.iter().find(|link| link.relation == Relation::Lateral) else { return links };
    let claims = SCALES.contains(&link.gain) || link.delay.abs() > LEAST_DELAY_S;
    if !claims || quick_share(series) > LEAST_QUICK {
        return links;
    }
    links.retain(|link| link.relation != Relation::Lateral);
    if !std::mem::replace(&mut report.may_be_banked, true) {
        let relation = Relation::Lateral.name();
        report.unclear(
            format!("{relation}: a road that is banked in its long curves does this, or the sensor"),
            "drive quick curves to both sides on level ground: no bank follows them",
        );
    }
    links
}

/// The share of what varies in speed × yaw rate that does so within seconds.
fn quick_share(series: &Series) -> f64 {
    let half = (0.5 * LONG_S / series.dt).round() as usize;
    let counts = |row: usize| series.moves(row) && series.vr[row].is_finite();
    // Sums up to each row, for means around it.
    let mut sums = vec![(0.0, 0.0)];
    for row in 0..series.len() {
        let (sum, count) = sums[row];
        sums.push(if counts(row) { (sum + series.vr[row], count + 1.0) } else { (sum, count) });
    }
    let mean = |from: usize, to: usize| {
        let ((first, before), (last, after)) = (sums[from], sums[to]);
        (last - first) / f64::max(after - before, 1.0)
    };
    let whole = mean(0, series.len());
    let (mut quick, mut all) = (0.0, 0.0);
    for row in (0..series.len()).filter(|row| counts(*row)) {
        let around = mean(row.saturating_sub(half), (row + half + 1).min(series.len()));
        quick += (series.vr[row] - around).powi(2);
        all += (series.vr[row] - whole).powi(2);
    }
    if all > 0.0 { quick / all } else { 0.0 }
}
