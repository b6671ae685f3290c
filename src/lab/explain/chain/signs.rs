//! Signs of yaw rate, lateral acceleration and steering: five witnesses of every curve, outvoted.

use super::relations::{Link, Relation, link};
use super::report::{AuditFinding, ChainReport, Confidence};
use super::series::Series;
use physics::Quantity;

/// How unlikely each error is, as costs. A first flipped sign costs one; others with it less, because a
/// whole sensor box or a whole convention is turned round. Wheels are rarely mixed up.
const FIRST_FLIP: f64 = 1.0;
const FURTHER_FLIP: f64 = 0.5;
const SWAPPED_AXLE: f64 = 2.0;
const BOTH_AXLES: f64 = 2.5;
/// Two explanations nearer than this cannot be told apart.
const CLEARLY: f64 = 0.9;

/// What may be turned round: yaw rate, lateral acceleration, steering, rear wheels, front wheels.
type Flips = [bool; 5];

const FLIPPABLE: [Quantity; 3] =
    [Quantity::YawRate, Quantity::LateralAcceleration, Quantity::SteeringWheelAngle];

fn cost(flips: Flips) -> f64 {
    let flipped = flips[..3].iter().filter(|flip| **flip).count();
    let signs = if flipped > 0 { FIRST_FLIP + FURTHER_FLIP * (flipped - 1) as f64 } else { 0.0 };
    signs
        + match (flips[3], flips[4]) {
            (false, false) => 0.0,
            (true, true) => BOTH_AXLES,
            _ => SWAPPED_AXLE,
        }
}

/// Does a relation's slope turn negative?
fn turned(flips: Flips, relation: Relation) -> bool {
    let other = match relation {
        Relation::Lateral => flips[1],
        Relation::Steering => flips[2],
        Relation::RearWheels => flips[3],
        Relation::FrontWheels => flips[4],
        Relation::Longitudinal => return false,
    };
    flips[0] != other
}

/// Finds signals that are turned round and turns them back in the series. Swapped wheels are left to the
/// wheels' own check.
pub(super) fn lateral(series: &mut Series, report: &mut ChainReport) {
    let witnesses = [Relation::RearWheels, Relation::FrontWheels, Relation::Lateral, Relation::Steering];
    let links: Vec<Link> = witnesses.into_iter().filter_map(|relation| link(series, relation)).collect();
    let links: Vec<Link> = links.into_iter().filter(|link| link.is_clear).collect();
    let mut explanations: Vec<(f64, Flips)> = (0u8..32)
        .map(|bits| std::array::from_fn(|i| bits & (1 << i) != 0))
        .filter(|flips| links.iter().all(|link| turned(*flips, link.relation) == link.is_negative))
        .map(|flips| (cost(flips), flips))
        .collect();
    explanations.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(least, flips)) = explanations.first() else { return };
    // Turning round what no relation speaks of only costs: such rivals are none.
    let rival = explanations.iter().find(|(_, other)| opposes(&links, flips, *other));
    let sure = rival.is_none_or(|(cost, _)| cost - least > CLEARLY) && links.len() >= 3;
    for (i, quantity) in FLIPPABLE.into_iter().enumerate().filter(|(i, _)| flips[*i]) {
        let own: Vec<&Link> = links.iter().filter(|link| concerns(link.relation, i)).collect();
        let strongest = own.iter().map(|link| (link.gain / link.gain_std).abs()).fold(0.0, f64::max);
        let or = rival.filter(|_| !sure).map(|(_, other)| words(*other));
        report.findings.push(AuditFinding {
            effect: "sensor_sign",
            channel: quantity.name().to_owned(),
            value: None,
            std: None,
            t: strongest,
            evidence: own
                .iter()
                .map(|link| {
                    format!("{}: slope {:+.3} ± {:.3}", link.relation.name(), link.gain, link.gain_std)
                })
                .collect::<Vec<_>>()
                .join("; "),
            confidence: if sure { Confidence::Certain } else { Confidence::Likely },
            repair: "multiply its gain by -1 (gain = -1.0 if there is none; its offset changes sign with it)"
                .into(),
            or: or.into_iter().collect(),
        });
        series.scale(quantity, -1.0);
    }
    series.refresh();
}

fn concerns(relation: Relation, flippable: usize) -> bool {
    flippable == 0 || turned(std::array::from_fn(|i| i == flippable), relation)
}

/// Do two explanations differ in something that a relation speaks of?
fn opposes(links: &[Link], one: Flips, other: Flips) -> bool {
    let heard =
        |i: usize| i == 0 || links.iter().any(|link| turned(std::array::from_fn(|k| k == i), link.relation));
    (0..5).any(|i| one[i] != other[i] && heard(i))
}

fn words(flips: Flips) -> String {
    let names = ["yaw_rate", "lateral_acceleration", "steering_wheel_angle", "rear wheels", "front wheels"];
    let turned: Vec<&str> = names.into_iter().zip(flips).filter(|(_, flip)| *flip).map(|(n, _)| n).collect();
    format!("turned round instead: {}", turned.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cheapest(negative: &[Relation]) -> Flips {
        let all = [Relation::RearWheels, Relation::FrontWheels, Relation::Lateral, Relation::Steering];
        (0u8..32)
            .map(|bits| -> Flips { std::array::from_fn(|i| bits & (1 << i) != 0) })
            .filter(|flips| all.iter().all(|r| turned(*flips, *r) == negative.contains(r)))
            .min_by(|a, b| cost(*a).total_cmp(&cost(*b)))
            .unwrap()
    }

    #[test]
    fn one_cause_is_preferred_and_wheels_are_rarely_it() {
        // One witness against all others is wrong itself.
        assert_eq!(cheapest(&[Relation::Lateral]), [false, true, false, false, false]);
        assert_eq!(cheapest(&[Relation::RearWheels]), [false, false, false, true, false]);
        // The yaw rate against all: itself.
        let all = [Relation::RearWheels, Relation::FrontWheels, Relation::Lateral, Relation::Steering];
        assert_eq!(cheapest(&all), [true, false, false, false, false]);
        // Everything else against the wheels: another convention, rather than both axles mixed up.
        let wheels = [Relation::FrontWheels, Relation::RearWheels];
        assert_eq!(cheapest(&wheels), [true, true, true, false, false]);
    }
}
