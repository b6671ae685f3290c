//! What an explanation says. Serialized, it is the JSON of the contract.

use std::collections::BTreeMap;

use physics::model::Vehicle;
use physics::model::effect::law::Law;
use physics::model::effect::{Channel, Kind};
use serde::Serialize;

use super::chain::{AuditFinding, ChainReport, Confidence};
use super::confirm::Confirmed;
use super::doubt::is_of_a_finding;
use super::finding::says;
use super::history::History;
use super::ordinary::{FreeTrace, Number, Ordinary, Remaining, Simulated};
use super::used::Used;
use crate::identify::{AxleStiffness, CorneringStiffness, Doubt, Parameter};

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

/// A number with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// In its unit.
    pub value: f64,
    /// Of the same unit.
    pub std: f64,
}

/// Where simulation and recording differ.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Where {
    /// The equation, or the sensor, in words.
    pub equation: String,
    /// Quantities in which it shows, the clearest one first.
    pub channels: Vec<String>,
    /// In which driving, in words.
    pub regimes: Vec<String>,
    /// When, s from the recording's start.
    pub intervals: Vec<[f64; 2]>,
    /// The same in UTC, where the recording's stamps are dates.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub intervals_utc: Vec<[String; 2]>,
    /// The recording that the intervals are of.
    pub recording: String,
}

/// What sort of a finding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Nature {
    /// Physics that not every car has.
    #[default]
    Unusual,
    /// How something is measured.
    Measurement,
    /// Physics that no effect of the library is.
    Law,
    /// Physics that every car has, and a plain model leaves out.
    Ordinary,
}

impl Nature {
    /// Of an effect.
    pub fn of(kind: &Kind) -> Self {
        if kind.is_law() {
            Self::Law
        } else if kind.is_of_measurement() {
            Self::Measurement
        } else if kind.search.every_car_has {
            Self::Ordinary
        } else {
            Self::Unusual
        }
    }
}

/// Something that is missing in the plain model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Finding {
    /// Its name in the library.
    pub effect: String,
    /// The quantity it is of.
    pub channel: Option<String>,
    /// What sort of a finding it is.
    pub kind: Nature,
    /// By how much held-out squared errors fall with it, as a share of the plain model's, by channel; where the ordinary
    /// car decides.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub explained_share: ByChannel,
    /// How probable it is among all that was tried.
    pub probability: f64,
    /// What this recording cannot tell it from.
    pub indistinguishable_from: Vec<String>,
    /// The manoeuvre that would.
    pub to_tell_apart: String,
    /// Its numbers.
    pub parameters: BTreeMap<String, Estimate>,
    /// When it began, in UTC, where `at_s` is among its numbers and the recording's stamps are dates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_utc: Option<String>,
    /// How it varied, if it did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub series: Option<CourseEstimate>,
    /// Where it shows.
    #[serde(rename = "where")]
    pub place: Where,
    /// In one sentence.
    pub about: String,
    /// Its equation.
    pub equation: String,
    /// Twice the logarithm of the odds for it.
    pub evidence: f64,
    /// Of a number of the car that has changed: what the references have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_value: Option<Estimate>,
    /// Of a law: what it says.
    #[serde(flatten)]
    pub law: Option<FoundLaw>,
}

/// What a law says, with its numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FoundLaw {
    /// What changes.
    pub place: String,
    /// By how much: numbers times what it follows.
    pub expression: String,
    /// The same one by one.
    pub terms: Vec<Term>,
}

/// A coefficient and what it is of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Term {
    /// What the car or the driver does.
    pub feature: String,
    /// The number before it.
    pub coefficient: Estimate,
    /// Its unit.
    pub unit: String,
}

impl FoundLaw {
    /// Of one term.
    pub fn new(law: Law, coefficient: Estimate) -> Self {
        let feature = law.feature.name().to_owned();
        Self {
            place: law.place.name().into(),
            expression: format!("{:.3e}*{feature}", coefficient.value),
            terms: vec![Term { feature, coefficient, unit: law.usual().0.into() }],
        }
    }
}

impl Finding {
    /// What is the same for all findings of a kind.
    pub fn of(kind: &Kind, channel: Option<Channel>) -> Self {
        let equation = match channel {
            Some(channel) => format!("{}: {channel}", kind.place),
            None => kind.place.into(),
        };
        Self {
            effect: kind.name.into(),
            channel: channel.map(|channel| channel.to_string()),
            kind: Nature::of(kind),
            to_tell_apart: kind.to_tell_apart.into(),
            place: Where { equation, ..Where::default() },
            about: kind.about.into(),
            equation: kind.equation.into(),
            ..Self::default()
        }
    }
}

/// How something varied, with what is known of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CourseEstimate {
    /// Times, s.
    pub t: Vec<f64>,
    /// Values.
    pub value: Vec<f64>,
    /// Standard deviations.
    pub std: Vec<f64>,
    /// Their unit.
    pub unit: String,
}

/// A candidate and its score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranked {
    /// Its name.
    pub effect: String,
    /// The quantity it is of.
    pub channel: Option<String>,
    /// Twice the logarithm of the odds for it, alone.
    pub score: f64,
    /// Was it fitted together with everything else, or judged to first order only?
    pub refitted: bool,
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
    /// What to drive, in words, where that would help.
    pub to_drive: Vec<String>,
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
            let take = |to: &mut Parts<ByChannel>, from: &Parts<ByChannel>| {
                to.train.extend(from.train.clone());
                to.holdout.extend(from.holdout.clone());
            };
            take(&mut self.fit.baseline, &ordinary.plain_fit);
            take(&mut self.fit.extended, &ordinary.found_fit);
            take(&mut self.error.baseline, &ordinary.error.baseline);
            take(&mut self.error.extended, &ordinary.error.extended);
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

/// A stretch of a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Block {
    /// Its recording.
    pub recording: String,
    /// From, to, s.
    pub t: [f64; 2],
    /// The same in UTC, where its stamps are dates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t_utc: Option<[String; 2]>,
    /// Was it held out?
    pub is_holdout: bool,
}

/// How a recorded car was driven.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Driven {
    /// The recording.
    pub recording: String,
    /// Time, s; speed, m/s; steering wheel angle, rad. Not-a-number: not available.
    pub rows: Vec<[f64; 3]>,
}

/// One channel of one recording, with both simulations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The recording.
    pub recording: String,
    /// The quantity.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Times, s.
    pub t: Vec<f64>,
    /// As recorded.
    pub measured: Vec<f64>,
    /// By the plain model, free-running from the start of each block.
    pub baseline: Vec<f64>,
    /// By the extended one.
    pub extended: Vec<f64>,
}

impl Trace {
    /// Of a free run.
    fn of(free: &FreeTrace) -> Self {
        let column = |place: usize| free.rows.iter().map(move |row| row[place]).collect();
        Self {
            recording: free.recording.clone(),
            channel: free.channel.name().into(),
            unit: free.channel.unit().into(),
            t: column(0),
            measured: column(1),
            baseline: column(3),
            extended: column(2),
        }
    }
}
