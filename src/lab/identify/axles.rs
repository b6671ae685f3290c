//! The cornering stiffness of each axle, the one quantity that identify, explain and replay all tell: the initial slope of the
//! axle's lateral force over its slip angle, per static axle load, 1/rad, with all that gives way between steering wheel and
//! road in it.

use serde::Serialize;

use physics::estimates::TOLD_RELATIVE_STD;

use super::result::Identified;
use super::{Identification, Parameter};

/// Both axles, as far as there is a number.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CorneringStiffness {
    /// Of the front axle.
    pub front: Option<AxleStiffness>,
    /// Of the rear axle.
    pub rear: Option<AxleStiffness>,
}

/// Of one axle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxleStiffness {
    /// 1/rad.
    pub value: f64,
    /// Standard deviation, 1/rad.
    pub std: f64,
    /// Do the recordings tell it?
    pub told: bool,
    /// If not, why not; else empty.
    pub reason: String,
}

impl AxleStiffness {
    /// With what speaks against it, if anything does. More than 15 % of uncertainty does in any case.
    pub fn of((value, std): (f64, f64), against: Option<String>) -> Self {
        let reason = against.or_else(|| too_unsure(value, std));
        Self { value, std, told: reason.is_none(), reason: reason.unwrap_or_default() }
    }
}

/// Why a stiffness is not told by a drive; none where its standard deviation is small enough.
pub fn too_unsure(value: f64, std: f64) -> Option<String> {
    let share = std / value.abs();
    (share.is_nan() || share > TOLD_RELATIVE_STD)
        .then(|| format!("σ is {:.0} % of it, more than 15 %", 100.0 * share))
}

/// The rule of 15 % as a reason against a number; none where it is no stiffness.
pub fn against(parameter: Parameter, value: f64, std: f64) -> Option<String> {
    let is_stiffness =
        matches!(parameter, Parameter::LateralFront | Parameter::LateralRear | Parameter::Longitudinal);
    too_unsure(value, std).filter(|_| is_stiffness)
}

impl Identification {
    /// Of the car that was identified, as far as the axles were free.
    pub fn cornering_stiffness(&self) -> CorneringStiffness {
        let of = |name: &str| {
            let is_its = |it: &&Identified| it.name == name || it.name == "lateral_stiffness";
            let it = self.parameters.iter().find(is_its)?;
            Some(AxleStiffness::of((it.value, it.std), (!it.identifiable).then(|| it.reason.clone())))
        };
        CorneringStiffness {
            front: of(Parameter::LateralFront.name()),
            rear: of(Parameter::LateralRear.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sixth_of_it_is_too_much() {
        assert!(AxleStiffness::of((12.0, 1.8), None).told);
        let unsure = AxleStiffness::of((12.0, 2.0), None);
        assert!(!unsure.told && unsure.reason.contains("17 %"), "{unsure:?}");
        assert!(!AxleStiffness::of((12.0, f64::NAN), None).told);
        assert_eq!(AxleStiffness::of((12.0, 1.0), Some("bound".into())).reason, "bound");
        assert_eq!(against(Parameter::SteeringRatio, 15.0, 5.0), None);
    }
}
