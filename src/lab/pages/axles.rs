//! The cornering stiffness of each axle, said the same way by every command.

use crate::report::{Page, number};
use identify::{AxleStiffness, CorneringStiffness, understeer};
use physics::model::Uncertain;

/// What it is.
pub const WHAT: &str = "Cornering stiffness of the axles: initial slope of the lateral force over the slip angle, per static axle \
                        load, with all that gives way between steering wheel and road in it";

/// A line for each axle that has a number.
pub fn lines(stiffness: &CorneringStiffness) -> Vec<String> {
    [("front", &stiffness.front), ("rear", &stiffness.rear)]
        .into_iter()
        .filter_map(|(axle, of)| line(axle, of))
        .collect()
}

/// The line of an axle, if it has a number.
pub fn line(axle: &str, of: &Option<AxleStiffness>) -> Option<String> {
    let AxleStiffness { value, std, told, reason } = of.as_ref()?;
    let decimals = usize::from(*std < 10.0) + usize::from(*std < 0.5);
    let why = if *told { String::new() } else { format!("; not told by this drive: {reason}") };
    Some(format!("{axle} {} ± {} 1/rad{why}", number(*value, decimals), number(*std, decimals)))
}

/// The understeer gradient (rad per m/s²) that they come to, where both are told.
pub fn gradient(stiffness: &CorneringStiffness) -> Option<Uncertain> {
    let of = |axle: &Option<AxleStiffness>| {
        let axle = axle.as_ref().filter(|axle| axle.told)?;
        Some(Uncertain { value: axle.value, std: axle.std })
    };
    Some(understeer::of_stiffness(of(&stiffness.front)?, of(&stiffness.rear)?))
}

/// The same as a part of a page.
pub fn section(page: &mut Page, stiffness: &CorneringStiffness) {
    let lines = lines(stiffness);
    if !lines.is_empty() {
        page.paragraph(&format!("{WHAT}: {}.", lines.join("; ")));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_told_says_why() {
        let of = |value, std| Some(AxleStiffness::of((value, std), None));
        let both = CorneringStiffness { front: of(12.04, 0.42), rear: of(15.0, 4.0) };
        let lines = lines(&both);
        assert_eq!(lines[0], "front 12.04 ± 0.42 1/rad");
        assert_eq!(
            lines[1],
            "rear 15.0 ± 4.0 1/rad; not told by this drive: σ is 26.7 % of it, more than 15 %"
        );
        assert!(super::lines(&CorneringStiffness::default()).is_empty());
    }
}
