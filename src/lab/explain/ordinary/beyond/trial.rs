//! What could be there beside the ordinary car, and when.

use std::collections::BTreeSet;

use super::super::fit::FreeFit;
use super::super::inputs::FreeDrive;
use super::super::numbers::{Free, Number, placed};
use crate::explain::candidates::{Candidate, library, onsets};
use crate::explain::model::{Chosen, Place};
use crate::identify::Parameter;
use physics::Quantity;
use physics::model::effect::{Kind, Scale, Spec};

/// Patches of another road are tried at every so many seconds …
const PATCH_EVERY_S: f64 = 3.0;

/// … of these lengths, s, and to the end.
const PATCHES_S: [f64; 4] = [3.0, 6.0, 12.0, 24.0];

/// A patch's friction is thought to be off by this share.
const PATCH_FRICTION: f64 = 0.5;

/// A candidate, and what is free of it.
#[derive(Clone)]
pub struct Trial {
    /// What, of what, and when.
    pub candidate: Candidate,
    /// Of a patch, one over the friction beside it.
    inverse_friction: f64,
}

/// All that could be there of a fitted car.
pub fn trials(found: &FreeFit<'_>, drives: &[FreeDrive], kinds: &[&'static Kind]) -> Vec<Trial> {
    let (model, _) = placed(&found.model, &found.free, &found.at, 0);
    let has = |quantity: Quantity| match quantity {
        Quantity::LateralAcceleration => drives.iter().any(|drive| drive.lateral.is_some()),
        Quantity::YawRate | Quantity::SteeringWheelAngle => true,
        wheel if (wheel as usize) < 4 => drives.iter().any(|drive| drive.axles[wheel as usize / 2].is_some()),
        _ => false,
    };
    let end = |drive: &FreeDrive| drive.time(drive.points());
    let seconds = drives.iter().map(end).fold(0.0, f64::max);
    let is_new = |kind: &&'static Kind| model.effects.iter().all(|chosen| chosen.kind != *kind);
    let kinds: Vec<&'static Kind> = kinds.iter().copied().filter(is_new).collect();
    let inverse_friction = model.values.get(Parameter::Friction).recip();
    let mut all: Vec<Trial> = Vec::new();
    let mut patches = BTreeSet::new();
    for candidate in library(&kinds, &model, has, &onsets(seconds)) {
        let Some(course) = candidate.kind.course else {
            all.push(Trial { candidate, inverse_friction });
            continue;
        };
        // A course that may be anything looks like the road does. Left and right apart take the wheels' torques; without
        // them that imitates the load transfer of an ordinary car.
        let sides = candidate.kind.parameters.iter().filter(|spec| spec.is_main).count();
        if course.sign == 0.0 || sides > 1 || !patches.insert(candidate.kind.name) {
            continue;
        }
        let free: Vec<usize> = (0..candidate.kind.parameters.len()).collect();
        for stretch in stretches(seconds) {
            let candidate = Candidate {
                free: free.clone(),
                fixed: Vec::new(),
                live: None,
                stretches: vec![stretch],
                ..candidate.clone()
            };
            all.push(Trial { candidate, inverse_friction });
        }
    }
    all
}

/// Where a patch could be, s.
fn stretches(seconds: f64) -> Vec<[f64; 2]> {
    // What is there from the beginning is the ordinary road.
    let begins = (1..).map(|i| f64::from(i) * PATCH_EVERY_S).take_while(|begin| begin + 3.0 < seconds);
    let of = |begin: f64| {
        let ends = PATCHES_S.into_iter().map(move |length| begin + length).filter(|end| *end < seconds);
        ends.chain([f64::INFINITY]).map(move |end| [begin, end])
    };
    begins.flat_map(of).collect()
}

impl Trial {
    /// The effect where it makes no difference.
    pub fn chosen(&self) -> Chosen {
        let mut chosen = self.candidate.chosen(0);
        if self.is_patch() {
            for (place, spec) in self.candidate.kind.parameters.iter().enumerate() {
                chosen.numbers[place] = self.neutral(spec);
            }
        }
        chosen
    }

    /// Is it there within some stretches only?
    pub fn is_patch(&self) -> bool {
        !self.candidate.stretches.is_empty()
    }

    /// Is it there from a moment on, or within stretches? Then decoys at other times are no decoys.
    pub fn has_time(&self) -> bool {
        self.is_patch() || self.candidate.kind.onset().is_some()
    }

    /// The road beside the patch, of a number of a patch.
    fn neutral(&self, spec: &Spec) -> f64 {
        if spec.scale == Scale::Inverse { self.inverse_friction } else { spec.mean }
    }

    /// What is free, as the effect of this place in a model.
    pub fn free(&self, effect: usize, chosen: &Chosen) -> Vec<Free> {
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
            Free {
                number: Number::Of(Place::Effect(effect, place)),
                drive: None,
                prior: (mean, std),
                bounds: (spec.bounds.0, most),
                step: if is_factor { -step } else { step },
            }
        };
        let is_free = |(place, _): &(usize, Spec)| self.candidate.free.contains(place);
        chosen.specs().enumerate().filter(is_free).map(of).collect()
    }

    /// When it begins, s, and the key of that.
    pub fn onset(&self) -> Option<(f64, &'static str)> {
        let place = self.candidate.kind.onset()?;
        let (_, at) = self.candidate.fixed.iter().find(|(fixed, _)| *fixed == place)?;
        (*at > 0.0).then_some((*at, Spec::AT_S.name))
    }

    /// The same with its beginning or end moved by so many seconds either way.
    pub fn moved(&self, by: f64) -> Vec<Self> {
        let mut all = Vec::new();
        if let Some(place) = self.candidate.kind.onset() {
            for by in [-by, by] {
                let mut trial = self.clone();
                let fixed = trial.candidate.fixed.iter_mut().find(|(fixed, at)| *fixed == place && *at > 0.0);
                if let Some((_, at)) = fixed {
                    *at += by;
                    all.push(trial);
                }
            }
        }
        for (number, [from, to]) in self.candidate.stretches.iter().enumerate() {
            let edges = [[from - by, *to], [from + by, *to], [*from, to - by], [*from, to + by]];
            for edges in edges.into_iter().filter(|[from, to]| to - from > 1.0 && *from > 0.0) {
                let mut trial = self.clone();
                trial.candidate.stretches[number] = edges;
                all.push(trial);
            }
        }
        all
    }
}
