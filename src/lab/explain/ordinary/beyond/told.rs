//! What was found as findings of the answer: effects of the search, and what the ordinary car itself says of physics that
//! every car has and of how its sensors measure.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::super::numbers::{Free, Number, Scope};
use super::Search;
use super::changed::is_of_sensor;
use super::climb::{Start, State};
use super::colour::{CHANNELS, Series};
use super::course::clear_stretches;
use super::refit::Refitted;
use super::round::LEAST_CLEAR;
use super::trial::What;
use crate::explain::finding::{TOLD_APART, probability_among};
use crate::explain::lateness::LEAST_DELAY_S;
use crate::explain::model::Place;
use crate::explain::result::{ByChannel, Estimate, Finding, FoundLaw, Nature, Where};
use crate::explain::select::LEAST_EVIDENCE;
use identify::Parameter;
use physics::Quantity;
use physics::model::effect::{Channel, Kind, Spec, named};
use predict::delay::Delayed;

/// A moment is searched in steps of an eighth of a second, on errors of which ten say as much as three.
const ONSET_STD_S: f64 = 0.5;

/// One car in a hundred has an unusual effect, before anything is seen: 2 ln of that.
const RARER: f64 = 9.2;

/// So many deviations from what was thought before are more than such sensors have.
const UNUSUAL: f64 = 3.0;

/// Every sensor has a zero that is a little off: below so many deviations that is not worth a line.
const LEAST_OFFSET: f64 = 2.0;

/// A number of the ordinary car is worth a line if it explains so much of the plain model's held-out squared error.
const LEAST_SHARE: f64 = 0.01;

/// Where each channel's error shows.
pub(super) const SHOWN_IN: [Quantity; CHANNELS] =
    [Quantity::YawRate, Quantity::LateralAcceleration, Quantity::WheelSpeedFl, Quantity::WheelSpeedRl];

impl Refitted<'_> {
    /// Is a number of the effect at what it can be at most or least?
    pub fn is_at_bound(&self) -> bool {
        self.own().any(|place| self.free[place].is_at_bound(self.at[place]))
    }

    /// Is it more than decoys to first order, in what was fitted to and in what was held out? A simulation may be so far off that
    /// the first order says little. Tuned by `beside_a_single_track`: a yaw inertia that is a third larger has 55 to first
    /// order, decoys 71, and 278 when it is fitted, 281 of it held out.
    pub fn is_above(&self, decoys: f64) -> bool {
        self.evidence.min(self.held_gain) > decoys
    }

    /// How many deviations the clearest of its main numbers is from where it makes no difference: a search that found a
    /// better place for all other numbers has evidence, too. Of a course it is its clearest point: with the deviations of its
    /// rms instead, a bank of 0.06 rad was called a drift of the gyroscope (`concealed_in_real_drives`).
    pub fn clearest(&self) -> f64 {
        self.clearest_place().map_or(0.0, |place| self.clear(place))
    }

    /// Coordinate and deviation of that number.
    pub fn clearest_main(&self) -> Estimate {
        let of = |place: usize| Estimate { value: self.at[place], std: self.std(place) };
        self.clearest_place().map_or(Estimate { value: 0.0, std: 0.0 }, of)
    }

    /// Where that number stands.
    pub fn clearest_place(&self) -> Option<usize> {
        let main = self.own().filter(|place| self.trial.is_main(&self.free[*place]));
        main.max_by(|a, b| self.clear(*a).total_cmp(&self.clear(*b)))
    }

    fn clear(&self, place: usize) -> f64 {
        (self.at[place] - self.free[place].prior.0).abs() / self.std(place)
    }

    fn std(&self, place: usize) -> f64 {
        self.covariance[(place, place)].max(1e-300).sqrt()
    }

    /// Is it, which few cars have, clearly likelier than this explanation, which every car has? One that is at a bound, or
    /// that hardly moves, explains nothing.
    pub fn is_told_from(&self, other: &Self) -> bool {
        let explains = !other.is_at_bound() && other.clearest() > LEAST_CLEAR;
        !explains || other.evidence < self.evidence - TOLD_APART - RARER
    }

    /// The places of its own numbers.
    fn own(&self) -> std::ops::Range<usize> {
        self.free.len() - self.own..self.free.len()
    }

    /// Its numbers, in their units, and when it began.
    pub fn parameters(&self) -> BTreeMap<String, Estimate> {
        let mut all: BTreeMap<String, Estimate> = self
            .own()
            .filter_map(|place| self.number(place))
            .map(|(name, is)| (name.to_owned(), is))
            .collect();
        all.extend(self.course_size().map(|(name, is)| (name.to_owned(), is)));
        if let Some((at, name)) = self.trial.onset() {
            all.insert(name.to_owned(), Estimate { value: at, std: ONSET_STD_S });
        }
        all
    }

    /// The number of its own that stands at this place.
    fn number(&self, place: usize) -> Option<(&str, Estimate)> {
        let (at, std) = (self.at[place], self.std(place));
        Some(match (&self.trial.what, self.free[place].number) {
            (What::Effect(candidate), Number::Of(Place::Effect(_, number))) => {
                let spec = candidate.kind.spec(number, candidate.channel)?;
                let value = spec.value(at);
                let std = (std * spec.scale.slope(at)).hypot(model_error(&spec) * value);
                (spec.name, Estimate { value, std })
            }
            (What::Number { name, .. }, Number::Change(of)) if !is_of_sensor(name) => {
                (last_of(name), self.changed(of, place))
            }
            // A ratio's logarithm: the reading is so many times the angle.
            (What::Number { .. }, Number::Change(_)) => {
                ("relative_error", Estimate { value: at.exp_m1(), std: std * at.exp() })
            }
            // The true speed is so many times the recorded one.
            (What::Number { .. }, Number::SpeedScaleChange) => {
                ("relative_error", Estimate { value: -at, std })
            }
            (What::Number { .. }, Number::SpeedDelayChange) => ("delay_s", Estimate { value: at, std }),
            _ => return None,
        })
    }

    /// A number of the car as it is with its change, which stands at this place of the free ones.
    fn changed(&self, of: Place, change: usize) -> Estimate {
        let Some((common, free)) = self.common(of) else { return Estimate { value: 0.0, std: 0.0 } };
        let (_, value, slope) = free.named(&self.model, self.at[common] + self.at[change]);
        let both = [(common, common), (change, change), (common, change), (change, common)];
        let variance: f64 = both.iter().map(|entry| self.covariance[*entry]).sum();
        Estimate { value, std: variance.max(0.0).sqrt() * slope.abs() }
    }

    /// The same number as the other recordings have it.
    pub fn unchanged(&self) -> Option<Estimate> {
        let What::Number { name, change } = &self.trial.what else { return None };
        let Number::Change(of) = change.number else { return None };
        if is_of_sensor(name) {
            return None;
        }
        let (common, free) = self.common(of)?;
        let (_, value, slope) = free.named(&self.model, self.at[common]);
        Some(Estimate { value, std: self.std(common) * slope.abs() })
    }

    /// The car's number of a place.
    fn common(&self, of: Place) -> Option<(usize, &Free)> {
        self.free.iter().enumerate().find(|(_, free)| free.number == Number::Of(of) && free.of == Scope::Car)
    }
}

/// Share of a number by which it is uncertain because the equations are simple. Free runs know no force along the car: there
/// a mass shows in what loads do to stiffness and inertia only. Tuned: `a_load_is_named` finds 320 to 420 kg for 300.
fn model_error(spec: &Spec) -> f64 {
    if spec.unit == "kg" { 0.25 } else { spec.model_error }
}

/// `kind.number` is called by its number.
fn last_of(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

impl Search<'_> {
    /// What is told of an effect that was taken, of all that were fitted in its round.
    pub(super) fn finding(&self, state: &State<'_>, best: &Refitted<'_>, all: &[(String, f64)]) -> Finding {
        let own = best.trial.name();
        let others = || all.iter().filter(|(name, _)| *name != own);
        let rivals = others().filter(|(_, evidence)| *evidence > best.evidence - TOLD_APART);
        let course = best.course();
        let end = self.drives.iter().map(|drive| drive.time(drive.points())).fold(0.0, f64::max);
        let intervals = match best.trial.onset() {
            Some((at, _)) => vec![[at, end]],
            None if course.is_some() => course.iter().flat_map(clear_stretches).collect(),
            None => best.trial.stretches().iter().map(|[from, to]| [from.max(0.0), to.min(end)]).collect(),
        };
        let mut gains: Vec<(Quantity, f64)> = SHOWN_IN.into_iter().zip(best.gains).collect();
        gains.retain(|(_, gain)| *gain > 1.0);
        gains.sort_by(|a, b| b.1.total_cmp(&a.1));
        let channels = gains.into_iter().map(|(channel, _)| channel.name().to_owned()).collect();
        let mut finding = match &best.trial.what {
            What::Effect(candidate) => Finding::of(candidate.kind, candidate.channel),
            What::Number { name, .. } => another_number(name, self.is_simulated),
        };
        finding.reference_value = best.unchanged();
        finding.probability = probability_among(best.evidence, others().map(|(_, evidence)| *evidence));
        finding.evidence = best.evidence;
        finding.indistinguishable_from = rivals.map(|(name, _)| name.clone()).collect();
        finding.series = course;
        finding.parameters = best.parameters();
        let channel = best.trial.candidate().and_then(|candidate| candidate.channel);
        if let (Some(Channel::Law(law)), Some(coefficient)) = (channel, finding.parameters.values().next()) {
            let found = FoundLaw::new(law, *coefficient);
            finding.about = format!(
                "the {} changes in proportion to {}, as no effect of the library has it",
                found.place,
                law.feature.name()
            );
            finding.equation = format!("Δ({}) = {}", found.place, found.expression);
            finding.place.equation.clone_from(&found.place);
            finding.law = Some(found);
        }
        finding.explained_share = self.share(&state.errors, &best.errors);
        finding.place.channels = channels;
        finding.place.intervals = intervals;
        if let Some(drive) = self.drives.get(self.references).filter(|_| !finding.place.intervals.is_empty())
        {
            finding.place.recording.clone_from(&drive.name);
        }
        finding
    }

    /// By how much held-out squares fall, as a share of the plain model's; all of it at most, for what the plain model has
    /// as well.
    pub(super) fn share(&self, before: &[Series], after: &[Series]) -> ByChannel {
        let share = |(channel, plain): (usize, f64)| {
            let fall = self.held_square(before, channel) - self.held_square(after, channel);
            (plain > 0.0).then(|| (SHOWN_IN[channel].name().to_owned(), (fall / plain).min(1.0)))
        };
        self.plain.into_iter().enumerate().filter_map(share).collect()
    }

    /// What the ordinary car says of physics that every car has, and of its sensors; with whether that is more than such a
    /// car and such sensors have.
    pub(super) fn usual(&self, state: &State<'_>) -> Vec<(Finding, bool)> {
        let mut all: Vec<(Finding, bool)> =
            (0..state.free.len()).into_par_iter().filter_map(|place| self.usual_one(state, place)).collect();
        all.sort_by(|a, b| b.0.evidence.total_cmp(&a.0.evidence));
        let mut told: Vec<(Finding, bool)> = Vec::new();
        for (finding, is_unusual) in all {
            // The same in several recordings is told once, of where it is clearest.
            let same = |(other, _): &&mut (Finding, bool)| {
                other.effect == finding.effect && other.channel == finding.channel
            };
            match told.iter_mut().find(same) {
                Some((other, was_unusual)) => {
                    other.place.recording += ", ";
                    other.place.recording += &finding.place.recording;
                    *was_unusual |= is_unusual;
                }
                None => told.push((finding, is_unusual)),
            }
        }
        told
    }

    fn usual_one(&self, state: &State<'_>, place: usize) -> Option<(Finding, bool)> {
        let free = &state.free[place];
        let told = Told::of(state, free)?;
        let at = state.at[place];
        let is_any_sensors = told.kind.name == "sensor_delay" && at.abs() < LEAST_DELAY_S;
        if free.is_at_bound(at) || is_any_sensors {
            return None;
        }
        // The same car without it, all else free.
        let mut without = state.clone();
        without.free.remove(place);
        without.at.remove(place);
        without.slopes.remove(place);
        without.errors = {
            let mut neutral = state.at.clone();
            neutral[place] = told.neutral;
            self.errors(&state.model, &state.free, &neutral)
        };
        let mut numbers = without.free.clone();
        numbers.push(free.held_at(told.neutral));
        let mut from = without.at.clone();
        from.push(told.neutral);
        let from = Start { at: from, errors: without.errors.clone(), ..Start::default() };
        let climbed = self.climb(&without, &state.colour, &state.model, &numbers, from);
        let evidence = climbed.cost - state.cost;
        let prior = (at - free.prior.0) / free.prior.1;
        let is_offset = told.kind.name == "sensor_bias";
        let std = state.covariance[(place, place)].max(0.0).sqrt();
        // By the slope here, too: a search may stop halfway.
        let from_neutral = ((at - told.neutral) / std).powi(2);
        if evidence.min(from_neutral) < LEAST_EVIDENCE || is_offset && prior.abs() < LEAST_OFFSET {
            return None;
        }
        let mut finding = Finding::of(told.kind, told.channel);
        if is_offset {
            finding.about = "the sensor reads too much (or too little) by a constant, all the time".into();
        }
        finding.probability = 1.0 / (1.0 + (-0.5 * evidence).exp());
        finding.evidence = evidence;
        let (value, slope) = told.value(free, at);
        // What of the effect its number alone does not tell.
        let by_model = told.model_error(free) * value;
        finding.parameters.insert(told.number.into(), Estimate { value, std: (std * slope).hypot(by_model) });
        finding.explained_share = self.share(&climbed.errors, &state.errors);
        // On driving that was not fitted to.
        if finding.explained_share.values().all(|share| *share < LEAST_SHARE) {
            return None;
        }
        if let Scope::Recording(drive) = free.of {
            finding.place.recording.clone_from(&self.drives[drive].name);
        }
        Some((finding, told.off_usual(free, at).abs() > UNUSUAL))
    }
}

/// A number of the ordinary car that is another one than in the references, or than in somebody's simulation.
fn another_number(name: &str, is_simulated: bool) -> Finding {
    if let Some((kind, channel)) = name.split_once(':')
        && let Some(kind) = named(kind)
    {
        return Finding::of(kind, channel.parse().ok());
    }
    if let Some(kind) = name.split_once('.').and_then(|(kind, _)| named(kind)) {
        let how =
            if is_simulated { "the simulation has none, or another one" } else { "now it is another one" };
        return Finding { about: format!("{}; {how}", kind.about), ..Finding::of(kind, None) };
    }
    let (what, equation) = match name {
        "lateral_stiffness_front" => ("the cornering stiffness of the front axle", "front slip angle"),
        "lateral_stiffness_rear" => ("the cornering stiffness of the rear axle", "rear slip angle"),
        "yaw_inertia_kgm2" => ("the yaw inertia", "yaw moment"),
        "friction" => ("the friction of tires and road", "limit of the tires"),
        "magic_formula_shape" => ("the shape of the tires' curve", "limit of the tires"),
        "cg_to_front_m" => ("the place of the centre of gravity", "loads of the axles"),
        _ => ("the mass", "lateral force"),
    };
    let how = if is_simulated { "is another one than in the simulation" } else { "has changed" };
    let place = Where { equation: equation.into(), ..Where::default() };
    Finding {
        effect: name.into(),
        kind: Nature::Ordinary,
        about: format!("{what} {how}"),
        place,
        ..Finding::default()
    }
}

/// A number of the ordinary car as an effect of the library.
pub(super) struct Told {
    pub(super) kind: &'static Kind,
    pub(super) channel: Option<Channel>,
    /// The effect's number.
    number: &'static str,
    /// The coordinate at which it makes no difference.
    neutral: f64,
}

impl Told {
    pub(super) fn of(state: &State<'_>, free: &Free) -> Option<Self> {
        use Parameter::{LateralAccelerationOffset, SteeringOffset, YawRateOffset};
        let sensor = |kind: &str, number: &'static str, quantity: Quantity, neutral: f64| {
            Some(Self { kind: named(kind)?, channel: Some(quantity.into()), number, neutral })
        };
        let late = |quantity| sensor("sensor_delay", "delay_s", quantity, 0.0);
        let bias = |quantity| sensor("sensor_bias", "bias", quantity, 0.0);
        match free.number {
            Number::SpeedDelay => late(Quantity::VehicleSpeed),
            // The true speed is so many times the recorded one.
            Number::SpeedScale => sensor("sensor_scale", "relative_error", Quantity::VehicleSpeed, 1.0),
            Number::Of(Place::Delay(Delayed::Steering)) => late(Quantity::SteeringWheelAngle),
            Number::Of(Place::Delay(Delayed::LateralAcceleration)) => late(Quantity::LateralAcceleration),
            Number::Of(Place::Ordinary(YawRateOffset)) => bias(Quantity::YawRate),
            Number::Of(Place::Ordinary(SteeringOffset)) => bias(Quantity::SteeringWheelAngle),
            Number::Of(Place::Ordinary(LateralAccelerationOffset)) => bias(Quantity::LateralAcceleration),
            Number::Of(Place::Effect(effect, number)) => {
                let chosen = &state.model.effects[effect];
                let spec = chosen.kind.spec(number, chosen.channel)?;
                let is_ordinary = chosen.kind.search.every_car_has && spec.is_main;
                is_ordinary.then_some(Self {
                    kind: chosen.kind,
                    channel: None,
                    number: spec.name,
                    neutral: spec.mean,
                })
            }
            Number::Of(_) | Number::Change(_) | Number::SpeedScaleChange | Number::SpeedDelayChange => None,
        }
    }

    /// Share by which the number is uncertain because the equation is simple; of what a sensor does, nothing.
    fn model_error(&self, free: &Free) -> f64 {
        match free.number {
            Number::Of(Place::Effect(_, number)) => {
                self.kind.spec(number, self.channel).map_or(0.0, |spec| spec.model_error)
            }
            _ => 0.0,
        }
    }

    /// By how many deviations it is another one than usual.
    pub(super) fn off_usual(&self, free: &Free, at: f64) -> f64 {
        let (value, slope) = self.value(free, at);
        slope * (at - free.prior.0) / (slope * free.prior.1).hypot(self.model_error(free) * value)
    }

    /// The effect's number, and how it changes with the coordinate.
    fn value(&self, free: &Free, at: f64) -> (f64, f64) {
        match free.number {
            Number::SpeedScale => (at.recip() - 1.0, -at.powi(-2)),
            Number::Of(Place::Effect(_, number)) => {
                let spec = self.kind.spec(number, self.channel);
                spec.map_or((at, 1.0), |spec| (spec.value(at), spec.scale.slope(at)))
            }
            _ => (at, 1.0),
        }
    }
}
