//! Numbers as the ordinary car's fit gives them, and which of them recordings tell.

use super::fit::FreeFit;
use super::inputs::FreeDrive;
use super::numbers::{Free, Scope};
use crate::explain::doubt::doubt;
use crate::explain::result::Estimate;
use identify::{Doubt, Parameter, against, far_from_limit};

/// A number of the car or of a recording's measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Its name: a key of `[vehicle]`, an effect's as `kind.parameter`, or of the measurement.
    pub name: String,
    /// The recording that it is of; none: the car's.
    pub recording: Option<String>,
    /// Value and standard deviation.
    pub estimate: Estimate,
    /// What was thought of it before.
    pub prior: Estimate,
    /// Does it end at what it can be at most or least? Then it is no estimate.
    pub is_at_bound: bool,
    /// Why it is not to be taken over as it is.
    pub doubt: Option<Doubt>,
    /// Why the drives cannot tell it: a friction that they are far from.
    pub out_of_reach: Option<String>,
    /// Where the searches began, where their first steps ended, and the cost there.
    pub starts: Vec<[f64; 3]>,
}

impl Number {
    /// Why the recordings do not tell it, or what they say is not to be believed; none where it is.
    pub fn untold(&self) -> Option<String> {
        if self.is_at_bound {
            return Some(format!(
                "the search ends at the bound {:.4}: the equations do not fit here",
                self.estimate.value
            ));
        }
        if let Some(far) = &self.out_of_reach {
            return Some(far.clone());
        }
        if self.estimate.std > LEAST_TOLD * self.prior.std {
            return Some("the recordings add little to what was known before".to_owned());
        }
        if let Some(doubt) = &self.doubt {
            return Some(format!("recordings and table contradict each other: {}", doubt.why));
        }
        against(Parameter::named(&self.name)?, self.estimate.value, self.estimate.std)
    }
}

/// A number whose deviation is still this share of the one before was not told by the recordings.
pub(super) const LEAST_TOLD: f64 = 0.7;

pub(super) fn numbers(found: &FreeFit<'_>, drives: &[FreeDrive]) -> Vec<Number> {
    let used = drives.iter().filter_map(FreeDrive::used_friction).reduce(f64::max);
    let of = |(i, free): (usize, &Free)| {
        let (name, value, slope) = free.named(&found.model, found.at[i]);
        let (_, mean, slope_there) = free.named(&found.model, free.prior.0);
        let estimate = Estimate { value, std: found.covariance[(i, i)].max(0.0).sqrt() * slope.abs() };
        let is_at_bound = free.is_at_bound(found.at[i]);
        let is_friction = Parameter::named(&name) == Some(Parameter::Friction);
        Number {
            out_of_reach: used.filter(|_| is_friction).and_then(|used| far_from_limit(value, used)),
            doubt: doubt(&name, estimate, &found.model.vehicle, is_at_bound),
            name,
            recording: match free.of {
                Scope::Recording(drive) => drives.get(drive).map(|drive| drive.name.clone()),
                Scope::Car | Scope::Since(_) | Scope::Growing { .. } => None,
            },
            estimate,
            prior: Estimate { value: mean, std: free.prior.1 * slope_there.abs() },
            is_at_bound,
            starts: found
                .starts
                .iter()
                .map(|(from, to, cost)| {
                    let value = |coordinate| free.named(&found.model, coordinate).1;
                    [value(from[i]), value(to[i]), *cost]
                })
                .collect(),
        }
    };
    found.free.iter().enumerate().map(of).collect()
}
