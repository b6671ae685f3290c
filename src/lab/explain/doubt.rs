//! Numbers of an answer that are in doubt. What a finding says of its own numbers is not: a load is more than a table knows.

use std::collections::BTreeMap;

use super::fit::Fit;
use super::model::Free;
use super::result::{Estimate, Finding};
use identify::{Doubt, Parameter};
use physics::model::Vehicle;

/// Why a number of this name is not to be taken over; none where it can be. Only the vehicle's own numbers are in a table.
pub fn doubt(name: &str, estimate: Estimate, vehicle: &Vehicle, is_at_bound: bool) -> Option<Doubt> {
    let estimate = (estimate.value, estimate.std);
    match Parameter::named(name) {
        Some(parameter) => Doubt::of_parameter(parameter, estimate, vehicle, is_at_bound),
        None => Doubt::of(estimate, None, is_at_bound),
    }
}

/// Those of a fit, by name; `numbers` are its ordinary ones.
pub fn of_fit(fit: &Fit<'_>, numbers: &BTreeMap<String, Estimate>) -> BTreeMap<String, Doubt> {
    let of = |free: &Free| {
        let (name, ..) = fit.model.ordinary_number(free.place)?;
        let is_at_bound = fit.model.is_at_bound(free.place);
        let doubt = doubt(&name, *numbers.get(&name)?, &fit.model.vehicle, is_at_bound)?;
        Some((name, doubt))
    };
    fit.free.iter().filter_map(of).collect()
}

/// Is a number what one of the findings is about?
pub fn is_of_a_finding(name: &str, findings: &[Finding]) -> bool {
    findings.iter().any(|finding| finding.reference_value.is_some() && finding.parameters.contains_key(name))
}
