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
        .then(|| format!("σ is {:.1} % of it, more than 15 %", 100.0 * share))
}

/// The rule of 15 % as a reason against a number; none where it is no stiffness.
pub fn against(parameter: Parameter, value: f64, std: f64) -> Option<String> {
    let is_stiffness =
        matches!(parameter, Parameter::LateralFront | Parameter::LateralRear | Parameter::Longitudinal);
    too_unsure(value, std).filter(|_| is_stiffness)
}

/// Stiffnesses of a search that moved numbers far from the table of which the recordings tell less than the table: the
/// equations do not fit there, and the stiffnesses are those of a car that cannot be.
pub(super) fn beside_what_cannot_be(parameters: &mut [Identified]) {
    let moved = |it: &Identified| {
        let deviations = it.doubt.as_ref()?.deviations.filter(|_| !it.is_clear)?;
        Some(format!("{} by {deviations:.1}", it.name))
    };
    let moved: Vec<String> = parameters.iter().filter_map(moved).collect();
    if moved.is_empty() {
        return;
    }
    let is_stiffness = |it: &&mut Identified| it.name.contains("stiffness") && it.identifiable;
    for it in parameters.iter_mut().filter(is_stiffness) {
        it.identifiable = false;
        it.reason = format!(
            "the same search moves {} standard deviations from the table, though the recordings tell less of it: the equations \
             do not fit here",
            moved.join(", ")
        );
    }
}

/// Stiffnesses that another car, which has more, tells otherwise.
fn beside_another(parameters: &mut [Identified], car: &CorneringStiffness) {
    let axles = [(Parameter::LateralFront, &car.front), (Parameter::LateralRear, &car.rear)];
    for (parameter, axle) in axles {
        let Some(axle) = axle.as_ref().filter(|axle| axle.told) else { continue };
        let own = parameters.iter_mut().find(|it| it.name == parameter.name() && it.identifiable);
        let Some(own) = own else { continue };
        if (own.value - axle.value).abs() > AGREE * own.std.hypot(axle.std) {
            own.identifiable = false;
            own.reason = format!(
                "with relaxation, compliance and roll, as every car has them, it is {:.1} ± {:.1} (--method ordinary)",
                axle.value, axle.std
            );
        }
    }
}

/// Two tools agree within so many deviations of their difference. Statistical: 95 % of the time, if both are right.
const AGREE: f64 = 2.0;

impl Identification {
    /// Does any axle's stiffness stand as told by the recordings?
    pub fn tells_stiffness(&self) -> bool {
        let stiffness = self.cornering_stiffness();
        [stiffness.front, stiffness.rear].into_iter().flatten().any(|axle| axle.told)
    }

    /// Takes back what contradicts a car with relaxation, compliance and roll that predicts the same recordings: without
    /// these the stiffness stands for them, too.
    pub fn beside_ordinary(&mut self, car: &CorneringStiffness) {
        beside_another(&mut self.parameters, car);
    }

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

    /// A number of 1.0 ± 0.1, so many deviations from the table's.
    fn of(name: &'static str, is_clear: bool, deviations: Option<f64>) -> Identified {
        Identified {
            name,
            unit: "1",
            value: 1.0,
            std: 0.1,
            ci95: (0.8, 1.2),
            identifiable: is_clear,
            reason: String::new(),
            is_clear,
            doubt: deviations.and_then(|by| {
                let table = physics::model::Uncertain { value: 1.0 + 0.1 * by, std: 0.1 };
                crate::Doubt::of((1.0, 0.1), Some(table), false)
            }),
            prior: (1.0, 0.1),
            profile: Vec::new(),
        }
    }

    #[test]
    fn what_a_car_with_more_tells_otherwise_is_not_told() {
        let told = |value: f64, std: f64| {
            let mut all =
                [of("lateral_stiffness_front", true, None), of("lateral_stiffness_rear", true, None)];
            let rear = Some(AxleStiffness::of((value, std), None));
            beside_another(&mut all, &CorneringStiffness { front: None, rear });
            assert!(all[0].identifiable, "of the front axle nothing was said");
            (all[1].identifiable, all[1].reason.clone())
        };
        assert!(told(1.2, 0.1).0);
        let (is_told, why) = told(0.6, 0.05);
        assert!(!is_told && why.contains("0.6 ± 0.1"), "{why}");
        assert!(told(0.6, 0.2).0, "not told itself, it takes nothing back");
    }

    #[test]
    fn a_car_that_cannot_be_has_no_stiffness() {
        let told = |ratio: Identified| {
            let mut all = [of("lateral_stiffness_front", true, None), ratio];
            beside_what_cannot_be(&mut all);
            (all[0].identifiable, all[0].reason.clone())
        };
        assert!(told(of("steering_ratio", false, None)).0);
        // What the recordings tell against the table stands for itself.
        assert!(told(of("steering_ratio", true, Some(8.0))).0);
        let (is_told, why) = told(of("steering_ratio", false, Some(8.0)));
        assert!(!is_told && why.contains("moves steering_ratio by 8.0 standard deviations"), "{why}");
    }

    #[test]
    fn a_sixth_of_it_is_too_much() {
        assert!(AxleStiffness::of((12.0, 1.8), None).told);
        let unsure = AxleStiffness::of((12.0, 2.0), None);
        assert!(!unsure.told && unsure.reason.contains("16.7 %"), "{unsure:?}");
        assert!(!AxleStiffness::of((12.0, f64::NAN), None).told);
        assert_eq!(AxleStiffness::of((12.0, 1.0), Some("bound".into())).reason, "bound");
        assert_eq!(against(Parameter::SteeringRatio, 15.0, 5.0), None);
    }
}
