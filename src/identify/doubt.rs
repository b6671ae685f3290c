//! Numbers that a search ended with and that are not to be believed as they are: at what the search allows, or far from
//! what the vehicle's table says.

use super::parameter::Parameter;
use physics::model::{Uncertain, Vehicle};
use serde::Serialize;

/// So many of the table's standard deviations are more than a table is usually wrong by: one number in 370, if the table's
/// own deviations are honest.
pub const MOST_DEVIATIONS: f64 = 3.0;

/// Why a number is in doubt.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Doubt {
    /// What was found, in the number's unit.
    pub value: f64,
    /// Its standard deviation, of the same unit.
    pub std: f64,
    /// Value and standard deviation of the vehicle's table; none of what is not in it.
    pub table: Option<Told>,
    /// Does it end at what the search allows?
    pub at_bound: bool,
    /// How many of the table's standard deviations it is from the table's value.
    pub deviations: Option<f64>,
    /// The same in words.
    pub why: String,
    /// What may be behind it; empty where nobody knows.
    pub behind: &'static str,
}

/// What a table says of a number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Told {
    /// In the number's unit.
    pub value: f64,
    /// Of the same unit.
    pub std: f64,
}

impl Doubt {
    /// Of a value ± its standard deviation beside what the table says; none where it can be believed.
    pub fn of((value, std): (f64, f64), table: Option<Uncertain>, at_bound: bool) -> Option<Self> {
        let table = table.filter(|table| table.std > 0.0 && table.value.is_finite());
        let deviations = table.map(|table| (value - table.value).abs() / table.std);
        let far = deviations.filter(|deviations| *deviations > MOST_DEVIATIONS);
        if !at_bound && far.is_none() {
            return None;
        }
        let bound = at_bound.then(|| "at the bound of the search".to_owned());
        let far = far.map(|by| format!("{by:.1} standard deviations from the table's value"));
        let why = bound.into_iter().chain(far).collect::<Vec<_>>().join(", ");
        let table = table.map(|Uncertain { value, std }| Told { value, std });
        Some(Self { value, std, table, at_bound, deviations, why, behind: "" })
    }

    /// The same of one of the car's numbers; offsets are in no table.
    pub fn of_parameter(
        parameter: Parameter,
        estimate: (f64, f64),
        vehicle: &Vehicle,
        at_bound: bool,
    ) -> Option<Self> {
        let table = (!parameter.is_offset()).then(|| parameter.prior(vehicle));
        let doubt = Self::of(estimate, table, at_bound)?;
        Some(Self { behind: parameter.what_else(), ..doubt })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_far_from_its_table_or_at_its_bound_is_in_doubt() {
        let table = Some(Uncertain { value: 1000.0, std: 250.0 });
        assert_eq!(Doubt::of((1740.0, 30.0), table, false), None);
        let far = Doubt::of((3490.0, 30.0), table, true).unwrap();
        assert_eq!(far.why, "at the bound of the search, 10.0 standard deviations from the table's value");
        // What no table says, or takes for known, is in doubt at a bound only.
        assert_eq!(Doubt::of((0.009, 0.001), None, false), None);
        assert_eq!(Doubt::of((2.0, 0.1), Some(Uncertain::known(1.0)), false), None);
        let bound = Doubt::of((0.01, 0.001), None, true).unwrap();
        assert_eq!((bound.why.as_str(), bound.deviations), ("at the bound of the search", None));
    }
}
