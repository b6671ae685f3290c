//! What could be there beside the ordinary car, and when.

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use super::super::fit::FreeFit;
use super::super::inputs::FreeDrive;
use super::super::numbers::{Free, Number, Scope, placed};
use super::changed::{changed, is_of_sensor, speed_changed};
use crate::explain::candidates::{self, Candidate, library, onsets};
use crate::explain::model::{Chosen, Model, Place};
use crate::explain::naming::ways;
use identify::Parameter;
use physics::Quantity;
use physics::model::effect::{Course, Kind, Scale, Series, Spec, named};

/// Patches of another road are tried at every so many seconds …
const PATCH_EVERY_S: f64 = 3.0;

/// … of these lengths, s, and to the end.
const PATCHES_S: [f64; 4] = [3.0, 6.0, 12.0, 24.0];

/// Those to the end begin at so many moments at most. Numerical: three minutes have as many.
const MOST_STAYING: f64 = 60.0;

/// What begins earlier is there from the start: little has been driven before. Tuned: `a_load_is_named`.
const EARLIEST_S: f64 = 2.5;

/// A patch's friction is thought to be off by this share.
const PATCH_FRICTION: f64 = 0.5;

/// Something that could be, and of which recordings.
#[derive(Clone)]
pub struct Trial {
    /// What.
    pub what: What,
    /// Of which recordings.
    pub of: Scope,
    /// Of a patch, one over the friction beside it.
    inverse_friction: f64,
    /// Of a course, the moments, s, between which it is a straight line.
    pub(super) points: Vec<f64>,
}

/// What could be.
#[derive(Clone)]
pub enum What {
    /// An effect: of what, and when.
    Effect(Candidate),
    /// A number of the ordinary car is another one than in the other recordings.
    Number {
        /// Its key, or the effect of a sensor that does the same.
        name: String,
        /// By how much.
        change: Free,
    },
}

/// The recordings that a search is about.
pub(super) fn own(drives: &[FreeDrive], of: Scope) -> impl Iterator<Item = &FreeDrive> {
    drives.iter().enumerate().filter(move |(number, _)| of.has(*number)).map(|(_, drive)| drive)
}

/// Do they have a quantity?
pub(super) fn has(drives: &[FreeDrive], of: Scope, quantity: Quantity) -> bool {
    match quantity {
        Quantity::LateralAcceleration => own(drives, of).any(|drive| drive.lateral.is_some()),
        Quantity::YawRate | Quantity::SteeringWheelAngle => true,
        wheel if (wheel as usize) < 4 => {
            own(drives, of).any(|drive| drive.axles[wheel as usize / 2].is_some())
        }
        _ => false,
    }
}

/// All laws of a grammar that no library has.
pub fn laws(drives: &[FreeDrive], of: Scope) -> Vec<Trial> {
    let candidates = candidates::laws(|quantity| has(drives, of, quantity));
    let trial = |candidate| Trial::new(What::Effect(candidate), of, 0.0);
    candidates.into_iter().map(trial).collect()
}

/// The kinds that a model does not have.
pub(super) fn new_kinds(kinds: &[&'static Kind], model: &Model<'_>) -> Vec<&'static Kind> {
    let is_new = |kind: &&'static Kind| model.effects.iter().all(|chosen| chosen.kind != *kind);
    kinds.iter().copied().filter(is_new).collect()
}

/// All that could be there of a fitted car in these recordings.
pub fn trials(found: &FreeFit<'_>, drives: &[FreeDrive], kinds: &[&'static Kind], of: Scope) -> Vec<Trial> {
    let (model, _) = placed(&found.model, &found.free, &found.at, 0);
    let has = |quantity: Quantity| has(drives, of, quantity);
    let seconds = own(drives, of).map(|drive| drive.time(drive.points())).fold(0.0, f64::max);
    let kinds = new_kinds(kinds, &model);
    let inverse_friction = model.values.get(Parameter::Friction).recip();
    let mut all: Vec<Trial> = Vec::new();
    let mut patches = BTreeSet::new();
    for candidate in library(&kinds, &model, has, &onsets(seconds)) {
        let Some(course) = candidate.kind.course else {
            all.push(Trial::new(What::Effect(candidate), of, inverse_friction));
            continue;
        };
        // What varies as it likes is searched apart (`courses`). Left and right apart take the wheels' torques; without them
        // that imitates the load transfer of an ordinary car.
        let sides = candidate.kind.parameters.iter().filter(|spec| spec.is_main).count();
        if course.sign == 0.0 || sides > 1 || !patches.insert(candidate.kind.name) {
            continue;
        }
        let free: Vec<usize> = (0..candidate.kind.parameters.len()).collect();
        // What is there from the beginning is the ordinary road, where there is no other to compare it with.
        let whole = matches!(of, Scope::Since(1..)).then_some([f64::NEG_INFINITY, f64::INFINITY]);
        for stretch in stretches(seconds).into_iter().chain(whole) {
            let candidate = Candidate {
                free: free.clone(),
                fixed: Vec::new(),
                live: None,
                stretches: vec![stretch],
                ..candidate.clone()
            };
            all.push(Trial::new(What::Effect(candidate), of, inverse_friction));
        }
    }
    if of != Scope::Car {
        let changes =
            found.free.iter().zip(&found.at).filter_map(|(free, at)| changed(found, (free, *at), of));
        all.extend(changes.chain(speed_changed(of)).map(|what| Trial::new(what, of, inverse_friction)));
    }
    all
}

/// Of a drive a patch covers no more than this share. Tuned by `shared/trials/realistic`, where one of 98 % took the place of tires that
/// the ordinary car took for too soft.
const MOST_COVERED: f64 = 0.9;

/// Where a patch could be, s.
fn stretches(seconds: f64) -> Vec<[f64; 2]> {
    let begins = |every: f64| (1..).map(move |i| f64::from(i) * every).take_while(move |t| t + 3.0 < seconds);
    let of = |begin: f64| PATCHES_S.map(|length| [begin, begin + length]);
    let patches = begins(PATCH_EVERY_S).flat_map(of).filter(|[_, end]| *end < seconds);
    // What stays takes longest to compute, and where it begins shows from far.
    let staying = begins(PATCH_EVERY_S.max(seconds / MOST_STAYING)).map(|begin| [begin, f64::INFINITY]);
    patches.chain(staying).collect()
}

impl Trial {
    pub(super) fn new(what: What, of: Scope, inverse_friction: f64) -> Self {
        Self { what, of, inverse_friction, points: Vec::new() }
    }

    /// Its name, with its channel.
    pub fn name(&self) -> String {
        match &self.what {
            What::Effect(candidate) => candidate.name(),
            What::Number { name, .. } => name.clone(),
        }
    }

    /// The car with it where it makes no difference.
    pub fn put_into<'a>(&self, model: &Model<'a>) -> Model<'a> {
        match &self.what {
            What::Effect(candidate) => model.with(self.chosen(candidate)),
            What::Number { .. } => model.clone(),
        }
    }

    fn chosen(&self, candidate: &Candidate) -> Chosen {
        let mut chosen = candidate.chosen(0);
        if self.is_patch() {
            for (place, spec) in candidate.kind.parameters.iter().enumerate() {
                chosen.numbers[place] = self.neutral(spec);
            }
        }
        if self.is_course() {
            let (t, value) = (self.points.clone(), vec![0.0; self.points.len()]);
            chosen.course = Course::Series(Series { t, value });
        }
        chosen
    }

    /// The same of other recordings.
    pub fn within(&self, of: Scope) -> Self {
        let mut trial = Self { of, ..self.clone() };
        if let What::Number { change, .. } = &mut trial.what {
            change.of = of;
        }
        trial
    }

    /// The effect.
    pub fn candidate(&self) -> Option<&Candidate> {
        match &self.what {
            What::Effect(candidate) => Some(candidate),
            What::Number { .. } => None,
        }
    }

    /// Is it none of the library's effects, but a law?
    pub fn is_law(&self) -> bool {
        self.candidate().is_some_and(|candidate| candidate.kind.is_law())
    }

    /// Is it no effect, but another number of the car?
    pub fn is_number(&self) -> bool {
        matches!(self.what, What::Number { .. })
    }

    /// Is it there within some stretches only?
    pub fn is_patch(&self) -> bool {
        self.candidate().is_some_and(|candidate| !candidate.stretches.is_empty())
    }

    /// Is it there from a moment on, or within stretches, or at any time? Then decoys at other times are no decoys.
    pub fn has_time(&self) -> bool {
        self.is_patch()
            || self.is_course()
            || self.candidate().is_some_and(|candidate| candidate.kind.onset().is_some())
    }

    /// Is it there from the first to the last moment?
    pub fn is_always_there(&self) -> bool {
        !self.is_course()
            && self.onset().is_none()
            && self.stretches().iter().all(|[from, _]| *from == f64::NEG_INFINITY)
    }

    /// Is it there for nearly all of a drive, though not always? Then it is no patch: it takes the place of the car's own number,
    /// free of what is thought of that.
    pub fn is_nearly_always_there(&self, drive: &FreeDrive) -> bool {
        let (first, last) = (drive.time(0), drive.time(drive.points()));
        let within = |[from, to]: &[f64; 2]| (to.min(last) - from.max(first)).max(0.0);
        let covered: f64 = self.stretches().iter().map(within).sum();
        !self.is_always_there() && covered > MOST_COVERED * (last - first)
    }

    /// When it is there; nothing: always, or from its onset on.
    pub fn stretches(&self) -> &[[f64; 2]] {
        self.candidate().map_or(&[], |candidate| &candidate.stretches)
    }

    /// Does every car have it?
    pub fn is_of_every_car(&self) -> bool {
        self.candidate().is_some_and(|candidate| candidate.kind.search.every_car_has)
    }

    /// The road beside the patch, of a number of a patch.
    fn neutral(&self, spec: &Spec) -> f64 {
        if spec.scale == Scale::Inverse { self.inverse_friction } else { spec.mean }
    }

    /// What is free of it in the car that it was put into.
    pub fn free(&self, model: &Model<'_>) -> Vec<Free> {
        let candidate = match &self.what {
            What::Effect(candidate) => candidate,
            What::Number { change, .. } => return vec![*change],
        };
        let effect = model.effects.len() - 1;
        let of = |(place, spec): (usize, Spec)| {
            let is_friction = self.is_patch() && spec.scale == Scale::Inverse;
            let (mean, std, step) = if is_friction {
                let mean = self.inverse_friction;
                (mean, PATCH_FRICTION * mean, 0.05 * mean)
            } else {
                (spec.mean, spec.std, spec.step)
            };
            // A road softens tires; it does not make them stiffer.
            let is_factor = self.is_patch() && spec.scale == Scale::Logarithmic;
            let most = if is_factor { spec.mean } else { spec.bounds.1 };
            // References may have been loaded, and a simulation may be of a loaded car.
            let is_size = spec.is_main && self.of == Scope::Car && candidate.is_from_start();
            let least = if is_size { spec.mean } else { spec.bounds.0 };
            Free {
                number: Number::Of(Place::Effect(effect, place)),
                of: self.of,
                prior: (mean, std),
                bounds: (least, most),
                step: if is_factor { -step } else { step },
            }
        };
        let is_free = |(place, _): &(usize, Spec)| candidate.free.contains(place);
        let numbers = model.effects[effect].specs().enumerate().filter(is_free).map(of);
        numbers.chain(self.free_points(effect)).collect()
    }

    /// Does it vanish with this number of it?
    pub fn is_main(&self, free: &Free) -> bool {
        match (&self.what, free.number) {
            (What::Effect(candidate), Number::Of(Place::Effect(_, number))) => {
                candidate.kind.parameters[number].is_main
            }
            _ => true,
        }
    }

    /// Is it the same with the same numbers free: of one wheel, and not of another?
    pub fn is_of_same_number(&self, other: &Self) -> bool {
        let free = |trial: &Self| trial.candidate().map(|candidate| candidate.free.clone());
        free(self) == free(other)
    }

    /// Key and unit of a number of it, and by how much that changes with its coordinate from where it makes no difference.
    pub fn size(&self, model: &Model<'_>, free: &Free, by: f64) -> (String, String, f64) {
        let here = free.prior.0;
        match (&self.what, free.number) {
            (What::Effect(candidate), Number::Of(Place::Effect(_, number))) => {
                match candidate.kind.spec(number, candidate.channel) {
                    Some(spec) => {
                        let change = spec.value(here + by) - spec.value(here);
                        (spec.name.into(), spec.unit.into(), change.abs())
                    }
                    None => (self.name(), String::new(), by.abs()),
                }
            }
            (What::Number { name, .. }, Number::Change(place)) if !is_of_sensor(name) => {
                let at = model.get(place);
                let (name, now, _) = free.named(model, at);
                let (_, then, _) = free.named(model, at + by);
                let unit = match place {
                    Place::Ordinary(parameter) => parameter.unit(),
                    Place::Effect(effect, number) => {
                        let chosen = &model.effects[effect];
                        chosen.kind.spec(number, chosen.channel).map_or("", |spec| spec.unit)
                    }
                    Place::Delay(_) | Place::BendAlong | Place::Course(..) => "",
                };
                (name.rsplit('.').next().unwrap_or_default().into(), unit.into(), (then - now).abs())
            }
            (_, Number::SpeedDelayChange) => ("delay_s".into(), "s".into(), by.abs()),
            _ => ("relative_error".into(), "1".into(), by.abs()),
        }
    }

    /// The value of a number of it where it makes no difference; of a changed number of the car, no change.
    pub fn neutral_value(&self, free: &Free) -> f64 {
        match (&self.what, free.number) {
            (What::Effect(candidate), Number::Of(Place::Effect(_, number))) => {
                let spec = candidate.kind.spec(number, candidate.channel);
                spec.map_or(0.0, |spec| spec.value(free.prior.0))
            }
            _ => 0.0,
        }
    }

    /// Between which moments it acts, s; none: always.
    pub fn acts(&self) -> Option<[f64; 2]> {
        if let Some((at, _)) = self.onset() {
            return Some([at, f64::INFINITY]);
        }
        let (first, last) = (self.stretches().first()?, self.stretches().last()?);
        Some([first[0], last[1]])
    }

    /// From when it is there, s; none: always.
    pub fn begins(&self) -> Option<f64> {
        self.acts().map(|[from, _]| from).filter(|from| from.is_finite())
    }

    /// The steps, in deviations of the prior, that tell how it acts; nothing: the number's own step.
    pub fn ways(&self) -> &'static [Option<f64>] {
        match &self.what {
            What::Effect(candidate) => ways(candidate.kind),
            // In somebody's simulation there may be no load transfer, and then a little of it changes nothing.
            What::Number { name, .. } if self.of == Scope::Since(0) => {
                let kind = name.split_once('.').and_then(|(kind, _)| named(kind));
                kind.map_or(&[None], ways)
            }
            What::Number { .. } => &[None],
        }
    }

    /// When it begins, s, and the key of that.
    pub fn onset(&self) -> Option<(f64, &'static str)> {
        let candidate = self.candidate()?;
        let place = candidate.kind.onset()?;
        let (_, at) = candidate.fixed.iter().find(|(fixed, _)| *fixed == place)?;
        (*at > 0.0).then_some((*at, Spec::AT_S.name))
    }

    /// The same with its beginning or end moved by so many seconds either way.
    pub fn moved(&self, by: f64) -> Vec<Self> {
        let Some(candidate) = self.candidate() else { return Vec::new() };
        let with = |candidate: Candidate| Self { what: What::Effect(candidate), ..self.clone() };
        let mut all = Vec::new();
        if let Some(place) = candidate.kind.onset() {
            for by in [-by, by] {
                let mut moved = candidate.clone();
                let fixed = moved.fixed.iter_mut().find(|(fixed, at)| *fixed == place && *at > 0.0);
                if let Some((_, at)) = fixed.filter(|(_, at)| *at + by > EARLIEST_S) {
                    *at += by;
                    all.push(with(moved));
                }
            }
        }
        for (number, [from, to]) in candidate.stretches.iter().enumerate() {
            let edges = [[from - by, *to], [from + by, *to], [*from, to - by], [*from, to + by]];
            for edges in edges.into_iter().filter(|[from, to]| to - from > 1.0 && *from > EARLIEST_S) {
                let mut moved = candidate.clone();
                moved.stretches[number] = edges;
                all.push(with(moved));
            }
        }
        all
    }
}
