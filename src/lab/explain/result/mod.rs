//! What an explanation says. Serialized, it is the JSON of the contract.

mod drive;
mod finding;
mod second_pass;
mod to_drive;

use std::collections::BTreeMap;

use physics::model::{TireKind, Vehicle};
use serde::Serialize;

pub use drive::{Block, Driven, Trace};
pub use finding::{CourseEstimate, Estimate, Finding, FoundLaw, Nature, Ranked, Term, Where, full_name};
pub use second_pass::{OffBy, SecondPass, Without};
pub use to_drive::{Chance, ToDrive};

use super::chain::{AuditFinding, ChainReport, Confidence};
use super::confirm::Confirmed;
use super::doubt::is_of_a_finding;
use super::finding::says;
use super::history::History;
use super::ordinary::{Along, Number, Ordinary, Remaining, Simulated};
use super::used::Used;
use identify::{AxleStiffness, CorneringStiffness, Doubt, Parameter};

/// What the comparison came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Something is missing in the plain model, and it has a name.
    MissingPhysics,
    /// The plain model says all there is to say.
    Adequate,
    /// Something is missing that no effect of the library is.
    UnknownPhysics,
    /// The drive says too little.
    InsufficientExcitation,
    /// The car is as it was in the references.
    Unchanged,
}

/// Fit by channel, %, or a likelihood, of the two parts of the recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Parts<T> {
    /// What was fitted to.
    pub train: T,
    /// What was not looked at.
    pub holdout: T,
}

/// The same of both models.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Models<T> {
    /// The plain model, its uncertain numbers refitted.
    pub baseline: T,
    /// The ordinary car: with what every car has, by a free run with the measured speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ordinary: Option<T>,
    /// With the findings.
    pub extended: T,
}

/// What a model does not predict of a channel, as a random process.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Disturbance {
    /// Its size.
    pub std: f64,
    /// The unit of that.
    pub unit: String,
    /// How long it remembers, s.
    pub time_constant_s: f64,
}

/// By channel.
pub type ByChannel = BTreeMap<String, f64>;

/// The whole answer.
#[derive(Clone, Debug, Serialize)]
pub struct Explanation {
    /// What it came to.
    pub verdict: Verdict,
    /// What is missing, the most important first.
    pub findings: Vec<Finding>,
    /// Everything that was tried, best first.
    pub ranking: Vec<Ranked>,
    /// 100 (1 − |y − ŷ|/|y − mean y|) of a free simulation restarted every 20 s, %.
    pub fit: Models<Parts<ByChannel>>,
    /// Root mean square of the same simulation's error, SI.
    pub error: Models<Parts<ByChannel>>,
    /// Fit of predictions by one step.
    pub prediction_fit: Models<Parts<ByChannel>>,
    /// ln likelihood.
    pub log_likelihood: Models<Parts<f64>>,
    /// Percentage points that the fit on held-out data improves, by channel: 95 % interval.
    pub improvement_ci95: BTreeMap<String, [f64; 2]>,
    /// The ordinary numbers.
    pub parameters: Models<BTreeMap<String, Estimate>>,
    /// The axles, as identify and replay tell them: of the ordinary car where there is one, else of the extended model.
    pub cornering_stiffness: CorneringStiffness,
    /// Which of the extended model's ordinary numbers are at a bound or far from the vehicle's table, and so not taken over.
    pub in_doubt: BTreeMap<String, Doubt>,
    /// How the tires bend, where that is not as the configuration has it and less is missing so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tires_bend_as: Option<TireKind>,
    /// Share of the residual variance above the noise that is still left, by channel.
    pub unexplained: ByChannel,
    /// What the ordinary car does not predict, by channel.
    pub disturbances: BTreeMap<String, Disturbance>,
    /// Share of its held-out error that inputs and motion predict, by channel …
    pub remaining: ByChannel,
    /// … and the 95 % bound of that under decoys.
    pub remaining_null: ByChannel,
    /// The mismatch as a whole.
    #[serde(rename = "where")]
    pub place: Where,
    /// What to drive next, where that would help.
    pub to_drive: Vec<ToDrive>,
    /// How much each equation misses: diffusion, per √s, with twice the log-likelihood ratio against none.
    pub equations: Models<Vec<Missing>>,
    /// What the measurement chain's audit found, in words.
    pub measurement_chain: Vec<String>,
    /// What of that it is certain of and no finding says: more than a model can say, it stands before all else.
    pub certain: Vec<String>,
    /// Recordings that the others are compared with.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub references: Vec<String>,
    /// Somebody's simulation, where the answer is what that leaves out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulation: Option<Simulated>,
    /// Drives in time order, where the answer is what changed on the way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<History>,
    /// What was found, on other drives of the same car.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub confirm: Vec<Confirmed>,
    /// Which stretches were held out.
    pub split: Vec<Block>,
    /// Seconds that were used.
    pub seconds: f64,
    /// Of which recordings, and why not all of them; empty where references or a simulation were asked about.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub used: Vec<Used>,
    /// When recordings begin, in UTC, by their names; of those whose stamps are dates.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub begins_utc: BTreeMap<String, String>,
    /// For plots; not in the JSON.
    #[serde(skip)]
    pub traces: Vec<Trace>,
    /// How the car was driven; for plots, not in the JSON.
    #[serde(skip)]
    pub driven: Vec<Driven>,
    /// The car as configured, where the recordings are of one and the same.
    #[serde(skip)]
    pub vehicle: Option<Vehicle>,
    /// The ordinary car, where it could be fitted; what the JSON has of it stands above.
    #[serde(skip)]
    pub ordinary: Option<Ordinary>,
    /// Does it predict what the plain model does not?
    #[serde(skip)]
    pub needs_ordinary: bool,
    /// Is the answer its answer?
    #[serde(skip)]
    pub is_by_ordinary: bool,
}

impl Explanation {
    /// Nothing but the verdict yet.
    pub fn empty(verdict: Verdict) -> Self {
        Self {
            verdict,
            findings: Vec::new(),
            ranking: Vec::new(),
            fit: Models::default(),
            error: Models::default(),
            prediction_fit: Models::default(),
            log_likelihood: Models::default(),
            improvement_ci95: BTreeMap::new(),
            parameters: Models::default(),
            cornering_stiffness: CorneringStiffness::default(),
            in_doubt: BTreeMap::new(),
            tires_bend_as: None,
            unexplained: ByChannel::new(),
            disturbances: BTreeMap::new(),
            remaining: ByChannel::new(),
            remaining_null: ByChannel::new(),
            place: Where::default(),
            to_drive: Vec::new(),
            equations: Models::default(),
            measurement_chain: Vec::new(),
            certain: Vec::new(),
            references: Vec::new(),
            simulation: None,
            history: None,
            confirm: Vec::new(),
            split: Vec::new(),
            seconds: 0.0,
            used: Vec::new(),
            begins_utc: BTreeMap::new(),
            traces: Vec::new(),
            driven: Vec::new(),
            vehicle: None,
            ordinary: None,
            needs_ordinary: false,
            is_by_ordinary: false,
        }
    }
}

impl Explanation {
    /// Says what the audit of the measurement says, whatever the rest is. What it is certain of and no finding says stands
    /// before all else.
    pub fn take_chain(&mut self, chain: &[ChainReport]) {
        let all = || chain.iter().flat_map(|report| &report.findings);
        self.measurement_chain = all().map(AuditFinding::to_string).collect();
        self.certain = all()
            .filter(|audited| audited.confidence == Confidence::Certain)
            .filter(|audited| !self.findings.iter().any(|finding| says(finding, audited)))
            .map(AuditFinding::to_string)
            .collect();
        // Several recordings of one car have it all.
        self.certain.dedup();
    }

    /// The axles of the extended model, where there is no ordinary car to tell them.
    pub(super) fn take_axles(&mut self) {
        let of = |parameter: Parameter| {
            let it = self.parameters.extended.get(parameter.name())?;
            let doubt = self.in_doubt.get(parameter.name()).map(|doubt| doubt.why.clone());
            Some(AxleStiffness::of((it.value, it.std), doubt))
        };
        self.cornering_stiffness =
            CorneringStiffness { front: of(Parameter::LateralFront), rear: of(Parameter::LateralRear) };
    }

    /// Says what the ordinary car says. Where it decides, the plain model is compared with it in its own way: by one free
    /// run with the measured speed.
    pub fn take_ordinary(&mut self, ordinary: &Ordinary, decided: Option<Verdict>) {
        self.fit.ordinary = Some(ordinary.fit.clone());
        self.error.ordinary.clone_from(&ordinary.error.ordinary);
        if let Some(verdict) = decided {
            self.verdict = verdict;
            self.is_by_ordinary = true;
            // Those were of other forces.
            self.improvement_ci95.clear();
            self.findings.clone_from(&ordinary.beyond.findings);
            // Scores of a drive that says too little rank its noise.
            if verdict == Verdict::InsufficientExcitation || !ordinary.beyond.ranking.is_empty() {
                self.ranking.clone_from(&ordinary.beyond.ranking);
            }
            self.fit.baseline.clone_from(&ordinary.plain_fit);
            self.fit.extended.clone_from(&ordinary.found_fit);
            self.error.baseline.clone_from(&ordinary.error.baseline);
            self.error.extended.clone_from(&ordinary.error.extended);
            self.traces = ordinary.traces.iter().map(Trace::of).collect();
            self.driven.clone_from(&ordinary.driven);
            self.split.clone_from(&ordinary.split);
            let yaw_rate = |fit: &Parts<ByChannel>| fit.holdout.get("yaw_rate").copied().unwrap_or(f64::NAN);
            self.needs_ordinary = yaw_rate(&ordinary.fit) > yaw_rate(&ordinary.plain_fit);
        }
        let of_the_car = |number: &&Number| !number.is_at_bound;
        let name = |number: &Number| {
            // Of one recording everybody knows which.
            let several = number.recording.as_ref().filter(|_| ordinary.sideslip.len() > 1);
            let of = several.map_or(String::new(), |recording| format!(" of {recording}"));
            format!("{}{of}", number.name)
        };
        let named = |number: &Number| (name(number), number.estimate);
        let told = |numbers: &[Number]| numbers.iter().filter(of_the_car).map(named).collect();
        self.parameters.ordinary = Some(told(&ordinary.numbers));
        self.cornering_stiffness.clone_from(&ordinary.cornering_stiffness);
        if decided.is_some() {
            self.parameters.baseline = told(&ordinary.plain_numbers);
            self.parameters.extended = told(&ordinary.numbers);
            let in_doubt = |number: &Number| Some((name(number), number.doubt.clone()?));
            self.in_doubt = ordinary.numbers.iter().filter_map(in_doubt).collect();
            self.in_doubt.retain(|name, _| !is_of_a_finding(name, &self.findings));
        }
        self.disturbances.clone_from(&ordinary.disturbances);
        let shares = |of: fn(&Remaining) -> f64| {
            ordinary.remaining.iter().map(|(channel, remaining)| (channel.clone(), of(remaining))).collect()
        };
        self.remaining = shares(|remaining| remaining.share);
        self.remaining_null = shares(|remaining| remaining.null);
        self.ordinary = Some(ordinary.clone());
    }
}

impl Explanation {
    /// Says what the measured speed says along the road, beside what the ordinary car says across it.
    pub fn take_along(&mut self, along: &Along) {
        let add = |to: &mut Models<Parts<ByChannel>>, [plain, found]: [Parts<ByChannel>; 2]| {
            let ordinary = to.ordinary.iter_mut().map(|to| (to, &plain));
            for (to, from) in
                [(&mut to.baseline, &plain), (&mut to.extended, &found)].into_iter().chain(ordinary)
            {
                to.train.extend(from.train.clone());
                to.holdout.extend(from.holdout.clone());
            }
        };
        add(&mut self.fit, along.fits());
        add(&mut self.error, along.errors());
        let [plain, found] = [&self.error.baseline.holdout, &self.error.extended.holdout];
        let left = |(channel, found): (&String, &f64)| {
            let plain = plain.get(channel).filter(|plain| **plain > 0.0)?;
            Some((channel.clone(), (found / plain).powi(2)))
        };
        self.unexplained = found.iter().filter_map(left).collect();
        self.traces.extend(along.traces.iter().map(Trace::of));
        if let Some(grade) = &along.grade {
            // What is unusual stands before what every car has.
            let ordinary = self.findings.iter().position(|finding| finding.kind == Nature::Ordinary);
            self.findings.insert(ordinary.unwrap_or(self.findings.len()), grade.clone());
        }
    }
}

/// How much an equation misses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Missing {
    /// Which equation.
    pub equation: String,
    /// Unit of the diffusion.
    pub unit: String,
    /// Its diffusion, per √s.
    pub diffusion: f64,
    /// Twice the log-likelihood ratio against an equation that misses nothing.
    pub ratio: f64,
}
