//! `--json`. What is no number, or infinite, is `null`.

use serde::{Serialize, Serializer};

use super::Story;
use identify::{CorneringStiffness, Doubt, Fits, Identified, LongitudinalInput, Method, Path};

/// Everything, in an order that reads well.
#[derive(Serialize)]
pub struct Report {
    parameters: Named<Parameter>,
    /// Of the axles, as explain and replay tell it.
    cornering_stiffness: CorneringStiffness,
    starts: Vec<Start>,
    fit: Fit,
    /// Standard deviations of the noise that is left, by channel, in its SI unit.
    noise: Named<f64>,
    /// Correlations of the parameters' errors, in their order.
    correlation: Vec<Vec<f64>>,
    /// What comes between two segments beyond the equations: m/s, m/s, rad/s; `null`: not tied.
    between: [f64; 3],
    /// How much the recordings count beside the table.
    weight: f64,
    seconds: f64,
    segments: usize,
    drive: LongitudinalInput,
    /// What the recordings cannot tell, for what they lack.
    untold: Vec<&'static str>,
    method: Method,
    recordings: Vec<Recording>,
    /// To be put into the configuration.
    toml: String,
}

#[derive(Serialize)]
struct Parameter {
    value: f64,
    std: f64,
    ci95: [f64; 2],
    identifiable: bool,
    reason: String,
    unit: &'static str,
    prior: Prior,
    /// Why it is not to be taken over; `null` where it can be.
    doubt: Option<Doubt>,
    /// [value, 2 ln(likelihood ratio) to the optimum, all others refitted].
    profile: Vec<[f64; 2]>,
}

#[derive(Serialize)]
struct Prior {
    value: f64,
    std: f64,
}

#[derive(Serialize)]
struct Start {
    from: Named<f64>,
    to: Named<f64>,
    /// −2 ln(likelihood) up to a constant; `null`: came to no end.
    cost: f64,
    iterations: u32,
}

/// Free run, restarted each 20 s: per cent, by channel.
#[derive(Serialize)]
struct Fit {
    before: Named<f64>,
    after: Named<f64>,
    /// The same of recordings that nothing was fitted to, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    holdout: Option<Box<Fit>>,
}

impl Fit {
    fn of([before, after]: [&Fits; 2]) -> Self {
        let named = |fits: &Fits| Named(fits.percent.clone());
        Self { before: named(before), after: named(after), holdout: None }
    }
}

#[derive(Serialize)]
struct Recording {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    begins_utc: Option<String>,
    samples: usize,
    period_s: f64,
}

/// A map in the order of its entries.
struct Named<T>(Vec<(&'static str, T)>);

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

/// As the contract has it, and more.
pub fn report(story: &Story<'_>) -> Report {
    let found = story.found;
    let names: Vec<&'static str> = found.parameters.iter().map(|parameter| parameter.name).collect();
    let named = |values: &[f64]| Named(names.iter().copied().zip(values.iter().copied()).collect());
    let start = |path: &Path| Start {
        from: named(&path.from),
        to: named(&path.to),
        cost: path.cost,
        iterations: path.iterations,
    };
    Report {
        parameters: Named(found.parameters.iter().map(|it| (it.name, parameter(it))).collect()),
        cornering_stiffness: found.cornering_stiffness(),
        starts: found.paths.iter().map(start).collect(),
        fit: Fit {
            holdout: (!story.held_out.is_empty()).then(|| Box::new(Fit::of(story.predicted.each_ref()))),
            ..Fit::of([&found.before, &found.after])
        },
        noise: Named(found.noise.iter().map(|(channel, std)| (channel.name(), *std)).collect()),
        correlation: found.correlation.clone(),
        between: found.between,
        weight: found.weight,
        seconds: found.seconds,
        segments: found.segments,
        drive: found.drive,
        untold: story.untold(),
        method: story.used.method,
        recordings: story
            .records
            .iter()
            .map(|record| Recording {
                name: record.name.clone(),
                begins_utc: record.clock.utc(0.0),
                samples: record.rows.len(),
                period_s: record.period_s,
            })
            .collect(),
        toml: super::snippet::toml(story),
    }
}

fn parameter(it: &Identified) -> Parameter {
    Parameter {
        value: it.value,
        std: it.std,
        ci95: [it.ci95.0, it.ci95.1],
        identifiable: it.identifiable,
        reason: it.reason.clone(),
        unit: it.unit,
        prior: Prior { value: it.prior.0, std: it.prior.1 },
        doubt: it.doubt.clone(),
        profile: it.profile.iter().map(|(value, cost)| [*value, *cost]).collect(),
    }
}
