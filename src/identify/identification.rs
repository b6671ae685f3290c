//! The whole job: from records and a vehicle to parameters with their uncertainty.

use std::borrow::Cow;

use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::axles::{self, against};
use super::config::IdentifyConfig;
use super::doubt::Doubt;
use super::error::IdentifyError;
use super::excitation;
use super::fit::{Ahead, Fit, Noise, Search};
use super::free::{Free, Tied};
use super::free_run;
use super::held::{self, Freed};
use super::input_noise;
use super::longitudinal_input::LongitudinalInput;
use super::motion::Output;
use super::parameter::{Parameter, Values};
use super::prepare;
use super::profile;
use super::record::Record;
use super::result::{Identification, Identified, Path};
use super::segment::Segment;
use super::setup;
use super::slips;
use super::stages::{PROFILING, PROFILING_LAST};
use super::uncertainty::{self, Shift, Uncertainty};
use physics::model::Vehicle;

/// Records, prepared for searching.
#[derive(Clone, Debug)]
pub struct Identifier<'a> {
    vehicle: &'a Vehicle,
    config: &'a IdentifyConfig,
    records: Cow<'a, [Record]>,
    values: Values,
    free: Vec<Free>,
    /// What would be free, too, if not only some parameters had been asked for.
    held: Vec<Free>,
    segments: Vec<Segment>,
    drive: LongitudinalInput,
    noise: Noise,
    is_steered: bool,
    /// Both axles' stiffnesses, where one value for both is asked for.
    each_axle: Option<[Free; 2]>,
    /// How much of a friction of 1 was used in what is fitted to.
    used: Option<f64>,
}

impl<'a> Identifier<'a> {
    /// Prepares records.
    ///
    /// # Errors
    /// What is wrong with the settings, or why there is nothing to learn from.
    pub fn new(
        records: &'a [Record],
        vehicle: &'a Vehicle,
        config: &'a IdentifyConfig,
    ) -> Result<Self, IdentifyError> {
        config.validate()?;
        let has = |quantity| records.iter().any(|record| record.sensors.has(quantity));
        let slides = excitation::slides(records, vehicle);
        let drive = config.drive.unwrap_or_else(|| LongitudinalInput::usual(vehicle, has, slides));
        if drive == LongitudinalInput::Torque && slides {
            tracing::warn!(
                "tires slide in these recordings: with drive = \"torque\" stiffnesses come out too low"
            );
        }
        let measured_before = records.iter().all(setup::has_slips);
        if drive == LongitudinalInput::Slips && !measured_before && !slips::can_be_had(vehicle, has) {
            let reason = "no slip without an undriven wheel to compare with, and four wheel speeds; \
                          torque or wheel_speeds will do";
            return Err(IdentifyError::Setting { key: "drive", value: "\"slips\"".into(), reason });
        }
        let values = Values::of(vehicle);
        let free = setup::free(vehicle, config, has, drive)?;
        let held = setup::held(vehicle, config, has, drive, &free);
        let is_of_both = free.iter().any(|free| free.parameters == Tied::BothLateral);
        let each_axle = setup::each_axle(vehicle, config, has, drive).filter(|_| is_of_both);
        let records = setup::prepared(records, vehicle, drive);
        let segments =
            prepare::segments(&records, vehicle, &values, drive, config.segment_s, 0.5 * config.segment_s);
        if segments.is_empty() {
            let records = records.iter().map(|record| record.name.clone()).collect::<Vec<_>>().join(", ");
            let braking = match drive {
                LongitudinalInput::Torque => "only where its pressure is known",
                LongitudinalInput::Speed => "counted",
                LongitudinalInput::WheelSpeeds | LongitudinalInput::Slips => "left out",
            };
            return Err(IdentifyError::NothingUsable { least_s: 0.5 * config.segment_s, braking, records });
        }
        let noise = setup::first_noise(&records);
        let is_steered = excitation::is_steered(&records);
        let used = excitation::used_friction(&records, &segments, vehicle);
        Ok(Self {
            vehicle,
            config,
            records,
            values,
            free,
            held,
            segments,
            drive,
            noise,
            is_steered,
            each_axle,
            used,
        })
    }

    /// Names of the free parameters.
    pub fn names(&self) -> Vec<&'static str> {
        self.free.iter().map(|free| free.parameters.name()).collect()
    }

    /// Searches from one start, in the parameters' units; no uncertainty. `None` if it comes to no end.
    pub fn search(&self, from: &[f64]) -> Option<Path> {
        let fit = self.fit(from)?;
        Some(self.path(from, &fit))
    }

    /// Searches from several starts; a path that meets another goes on with it. Those that come to no end
    /// have an infinite cost.
    pub fn search_from(&self, starts: &[Vec<f64>]) -> Vec<Path> {
        self.searches(starts, &mut |_, _| ()).0
    }

    /// All paths, and the best end.
    fn searches(
        &self,
        starts: &[Vec<f64>],
        progress: &mut impl FnMut(&str, f64),
    ) -> (Vec<Path>, Option<Fit>) {
        let mut best: Option<(f64, Fit)> = None;
        let mut paths: Vec<Path> = Vec::new();
        let mut met: Vec<(Ahead, usize)> = Vec::new();
        let search = self.search_in();
        for (number, from) in starts.iter().enumerate() {
            // The first one goes all the way; most of the others meet it.
            let done = if number == 0 { 0 } else { number + 1 };
            progress("searching", done as f64 / (starts.len() + 1) as f64);
            let from = from.clone();
            let ahead = self.coordinates(&from).and_then(|theta| search.ahead(theta, &self.noise));
            let earlier = ahead.as_ref().and_then(|ahead| met.iter().find(|(other, _)| ahead.meets(other)));
            if let (Some(ahead), Some((_, path))) = (&ahead, earlier) {
                let same = Path { from, iterations: ahead.iterations, ..paths[*path].clone() };
                paths.push(same);
                continue;
            }
            let Some((ahead, fit)) = ahead.and_then(|a| search.finish(&a, &self.noise).map(|fit| (a, fit)))
            else {
                let to = vec![f64::NAN; from.len()];
                paths.push(Path { from, to, cost: f64::INFINITY, iterations: 0 });
                continue;
            };
            met.push((ahead, paths.len()));
            let path = self.path(&from, &fit);
            if best.as_ref().is_none_or(|(lowest, _)| path.cost < *lowest) {
                best = Some((path.cost, fit));
            }
            paths.push(path);
        }
        (paths, best.map(|(_, fit)| fit))
    }

    fn search_in(&self) -> Search<'_> {
        Search {
            vehicle: self.vehicle,
            values: &self.values,
            free: &self.free,
            segments: &self.segments,
            drive: self.drive,
            method: self.config.method,
        }
    }

    fn fit(&self, from: &[f64]) -> Option<Fit> {
        self.search_in().run(self.coordinates(from)?, &self.noise)
    }

    /// From the parameters' units; `None` where one of them cannot be.
    fn coordinates(&self, from: &[f64]) -> Option<DVector<f64>> {
        let coordinates = self.free.iter().zip(from).map(|(free, value)| free.parameters.coordinate(*value));
        if from.len() != self.free.len() {
            return None;
        }
        let theta = DVector::from_iterator(self.free.len(), coordinates);
        theta.iter().all(|coordinate| coordinate.is_finite()).then_some(theta)
    }

    fn path(&self, from: &[f64], fit: &Fit) -> Path {
        let ends = self.free.iter().zip(fit.point.theta.iter());
        Path {
            from: from.to_vec(),
            to: ends.map(|(free, theta)| free.value(*theta)).collect(),
            // Each end has its own noise: a likelihood makes them comparable.
            cost: self.minus_two_log_likelihood(fit),
            iterations: fit.iterations,
        }
    }

    /// −2 ln likelihood, up to a constant.
    fn minus_two_log_likelihood(&self, fit: &Fit) -> f64 {
        let mut sum = fit.all.cost;
        for segment in &self.segments {
            for row in &segment.measured[..segment.len()] {
                let there = row.iter().zip(&fit.noise).filter(|(value, _)| !value.is_nan());
                sum += there.map(|(_, std)| 2.0 * std.ln()).sum::<f64>();
            }
        }
        sum
    }

    /// The whole job. `progress` is told what is done, and how far it is (0–1).
    ///
    /// # Errors
    /// If no search comes to an end.
    pub fn run(&self, mut progress: impl FnMut(&str, f64)) -> Result<Identification, IdentifyError> {
        let count = self.config.starts.max(1);
        let starts: Vec<Vec<f64>> = (0..count).map(|number| self.start(number)).collect();
        let (paths, best) = self.searches(&starts, &mut progress);
        let reason = "nothing could be simulated with those values; check the vehicle's table";
        let fit = best.ok_or(IdentifyError::NoEnd { starts: count, reason })?;
        let fit = self.beside_table(fit);
        let reason = "the parameters are not determined; give them a std in the vehicle's table";
        let shift = self.shift(&fit, &mut progress);
        let sure = uncertainty::of(&fit, &self.free, &shift)
            .ok_or(IdentifyError::NoEnd { starts: count, reason })?;
        progress("without holding anything", 0.0);
        let freed = held::freed(&self.search_in(), &fit, &self.held, &self.noise);
        let profiling = if self.may_tell_stiffness(&fit, &sure) { PROFILING } else { PROFILING_LAST };
        let mut parameters = Vec::new();
        for place in 0..self.free.len() {
            progress(profiling, place as f64 / self.free.len() as f64);
            parameters.push(self.identified(place, &fit, &sure, freed.as_ref()));
        }
        axles::beside_what_cannot_be(&mut parameters);
        if let Some(each) = self.each_axle {
            let both = held::of_both(&self.search_in(), &fit, each, &self.noise);
            let its = parameters.iter_mut().find(|it| it.name == Tied::BothLateral.name());
            its.into_iter().for_each(|it| it.note(&both));
        }
        progress("free run", 0.0);
        let values = self.search_in().values_at(&self.corrected(&fit, &sure));
        let correlation = sure.correlation.row_iter().map(|row| row.iter().copied().collect()).collect();
        let there = Output::ALL.into_iter().zip(fit.left()).filter(|(channel, _)| self.is_measured(*channel));
        // A channel that has no say in the search leaves no residuals.
        let is_silent =
            |channel| self.drive.prescribes_acceleration() && channel == Output::LongitudinalAcceleration;
        let there = there.map(|(channel, std)| (channel, if is_silent(channel) { f64::NAN } else { std }));
        Ok(Identification {
            parameters,
            correlation,
            paths,
            before: free_run::fits(&self.records, self.vehicle, &self.values, self.drive),
            after: free_run::fits(&self.records, self.vehicle, &values, self.drive),
            values,
            drive: self.drive,
            seconds: self.segments.iter().map(|segment| segment.len() as f64 * segment.period_s).sum(),
            segments: self.segments.len(),
            noise: there.collect(),
            between: fit.tie.0.map(|std| std / fit.counts_less_by.sqrt()),
            weight: 1.0 / fit.counts_less_by,
        })
    }

    /// The same end with the table's numbers counted as they should: beside residuals that are no white noise (steps of a
    /// sensor, a road that is not flat) a likelihood that takes them for independent would drown any table.
    fn beside_table(&self, fit: Fit) -> Fit {
        let overstated = uncertainty::overstated(&fit, &self.free);
        tracing::debug!(?overstated, "how much more segments differ than noise explains");
        let overstated = overstated.filter(|by| *by > MOST_OVERSTATED);
        overstated.and_then(|by| self.search_in().counting_less(&fit, by)).unwrap_or(fit)
    }

    fn is_measured(&self, channel: Output) -> bool {
        let mut rows = self.segments.iter().flat_map(|segment| &segment.measured);
        rows.any(|row| !row[channel as usize].is_nan())
    }

    /// The coordinates without what the noise of the inputs has done, within their bounds.
    fn corrected(&self, fit: &Fit, sure: &Uncertainty) -> DVector<f64> {
        let mut theta = &fit.point.theta - &sure.correction;
        for (coordinate, free) in theta.iter_mut().zip(&self.free) {
            let (low, high) = free.coordinate_bounds();
            *coordinate = coordinate.clamp(low, high);
        }
        theta
    }

    /// What the noise of the inputs has done, by doing it again a few times.
    fn shift(&self, fit: &Fit, progress: &mut impl FnMut(&str, f64)) -> Shift {
        let draws = (0..Shift::DRAWS).filter_map(|draw| {
            progress("adding noise to the inputs", f64::from(draw) / f64::from(Shift::DRAWS));
            let seed = self.config.seed.wrapping_add(u64::from(draw));
            let noisier = input_noise::noisier(&self.segments, &self.records, self.drive, seed);
            Search { segments: &noisier, ..self.search_in() }.shifted(fit)
        });
        Shift::new(&draws.collect::<Vec<_>>(), self.free.len())
    }

    /// The first start is the table; the others lie around it, farther than its standard deviations.
    fn start(&self, number: usize) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(self.config.seed);
        random.set_stream(number as u64);
        let around = |free: &Free, random: &mut ChaCha8Rng| {
            let by: f64 = random.sample(StandardNormal);
            let std = if free.std.is_finite() { 2.0 * free.std } else { 0.7 };
            free.value(free.mean + by * std)
        };
        let starts = self.free.iter();
        match number {
            0 => starts.map(|free| free.value(free.mean)).collect(),
            _ => starts.map(|free| around(free, &mut random)).collect(),
        }
    }

    fn identified(&self, place: usize, fit: &Fit, sure: &Uncertainty, freed: Option<&Freed>) -> Identified {
        let free = &self.free[place];
        let at = self.corrected(fit, sure)[place];
        let half = sure.factor * sure.std[place];
        let end = |coordinate: f64| free.value(coordinate);
        let ends = (end(at - half), end(at + half));
        let value = free.value(at);
        let std = sure.std[place] * free.parameters.value_by_coordinate(at);
        let by_curvature = sure.by_curvature[place];
        let profile = if self.config.profile {
            profile::of(&self.search_in(), place, fit, by_curvature)
        } else {
            Vec::new()
        };
        let first = free.parameters.first();
        let prior = first.prior(self.vehicle);
        let (mut identifiable, mut reason) = self.verdict(place, fit, sure);
        if let Some(open) = open_end(free.bounds, ends, &profile).filter(|_| identifiable) {
            (identifiable, reason) = (false, open);
        }
        let held = freed.and_then(|freed| freed.against(place, free, (at, half, sure.std[place])));
        if let Some(held) = held.filter(|_| identifiable) {
            (identifiable, reason) = (false, held);
        }
        if let Some(unsure) = against(first, value, std).filter(|_| identifiable) {
            (identifiable, reason) = (false, unsure);
        }
        let doubt = Doubt::of_parameter(first, (value, std), self.vehicle, self.is_at_bound(place, fit));
        let is_clear = identifiable;
        if let Some(doubt) = doubt.as_ref().filter(|_| is_clear) {
            (identifiable, reason) =
                (false, format!("recordings and table contradict each other: {}", doubt.why));
        }
        Identified {
            name: free.parameters.name(),
            unit: free.parameters.first().unit(),
            value,
            std,
            ci95: ends,
            identifiable,
            reason,
            is_clear,
            doubt,
            prior: (prior.value, prior.std),
            profile,
        }
    }

    /// Will any axle's stiffness be told, as far as is known before its profile is?
    fn may_tell_stiffness(&self, fit: &Fit, sure: &Uncertainty) -> bool {
        let may = |place: usize| {
            let free = &self.free[place];
            let at = fit.point.theta[place];
            let std = sure.std[place] * free.parameters.value_by_coordinate(at);
            matches!(free.parameters.first(), Parameter::LateralFront | Parameter::LateralRear)
                && self.verdict(place, fit, sure).0
                && axles::too_unsure(free.value(at), std).is_none()
        };
        (0..self.free.len()).any(may)
    }

    fn is_at_bound(&self, place: usize, fit: &Fit) -> bool {
        let (low, high) = self.free[place].coordinate_bounds();
        [low, high].iter().any(|bound| (fit.point.theta[place] - bound).abs() < 1e-6)
    }

    /// Does the recording say something of a parameter, and if not, why not?
    fn verdict(&self, place: usize, fit: &Fit, sure: &Uncertainty) -> (bool, String) {
        let free = &self.free[place];
        if self.is_at_bound(place, fit) {
            let value = number(free.value(fit.point.theta[place]));
            return (false, format!("the search ends at the bound {value}: the equations do not fit here"));
        }
        if !self.is_steered && excitation::needs_steering(free.parameters.first()) {
            return (false, "the steering wheel is not moved by more than its own noise".into());
        }
        let friction = Some(free.value(fit.point.theta[place]))
            .filter(|_| free.parameters.first() == Parameter::Friction);
        if let Some(far) = friction.zip(self.used).and_then(|(it, used)| excitation::far_from_limit(it, used))
        {
            return (false, far);
        }
        if sure.decided_by_noise[place] {
            return (false, "the noise of steering or wheel speeds decides it: too little excitation".into());
        }
        let logarithmic = free.parameters.first().is_logarithmic();
        let by_data = sure.by_data[place];
        let vague = if logarithmic { by_data > 0.5 } else { by_data > 50.0 };
        let partner = (0..self.free.len())
            .filter(|other| *other != place)
            .max_by(|a, b| {
                sure.correlation[(place, *a)].abs().total_cmp(&sure.correlation[(place, *b)].abs())
            })
            .filter(|other| sure.correlation[(place, *other)].abs() > 0.9)
            .map(|other| self.free[other].parameters.name());
        let with = partner.map_or(String::new(), |name| format!("; it goes with {name}"));
        if free.std.is_finite() && by_data > 1.5 * free.std {
            return (false, format!("the recording says less of it than the vehicle's table{with}"));
        }
        if vague {
            return (false, format!("the recording leaves it open by more than half of its value{with}"));
        }
        if !fit.converged {
            return (false, "the search stopped before it had come to rest".into());
        }
        (true, partner.map_or(String::new(), |name| format!("its error goes with that of {name}")))
    }
}

/// Segments of white noise differ by chance, too. Statistical: of 20 segments by a third, and what is less than twofold moves
/// no number by much. Noise of inputs, which is not in the likelihood, makes 70 to 110 of a simulated drive, and surfaces that
/// change 500 to 800; the RAV4's minute in steps of the yaw rate has 23.
const MOST_OVERSTATED: f64 = 2.0;

/// 2 ln(likelihood ratio) at the ends of a 95 % interval.
const RATIO_95: f64 = 3.84;

/// Why an interval has no end: at what the parameter can be at all it is not yet excluded.
fn open_end((low, high): (f64, f64), ends: (f64, f64), profile: &[(f64, f64)]) -> Option<String> {
    let is_open = |bound: f64, end: f64, last: Option<&(f64, f64)>| {
        end == bound || last.is_some_and(|(value, ratio)| *value == bound && *ratio < RATIO_95)
    };
    let open = match () {
        () if is_open(low, ends.0, profile.first()) => low,
        () if is_open(high, ends.1, profile.last()) => high,
        () => return None,
    };
    Some(format!("no interval: the recording does not exclude {}, where its bound is", number(open)))
}

/// A bound in three or four digits.
fn number(value: f64) -> String {
    let digits = (3 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_that_is_flat_at_the_bound_has_no_end() {
        let bounds = (0.5, 60.0);
        let closed = [(10.0, 4.5), (12.0, 0.0), (15.0, 5.0)];
        assert_eq!(open_end(bounds, (10.5, 14.5), &closed), None);
        let flat = [(10.0, 4.5), (12.0, 0.0), (60.0, 2.0)];
        let why = open_end(bounds, (10.5, 14.5), &flat).unwrap();
        assert_eq!(why, "no interval: the recording does not exclude 60, where its bound is");
        // Excluded there, the bound is only where the profile was ended.
        assert_eq!(open_end(bounds, (10.5, 14.5), &[(10.0, 4.5), (12.0, 0.0), (60.0, 9.0)]), None);
        assert!(open_end(bounds, (0.5, 14.5), &[]).unwrap().contains("0.5"));
    }
}
