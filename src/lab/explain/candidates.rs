//! The candidates: every effect of the library that this bus and this drive could show.

use super::model::{Chosen, Model};
use super::tuning::TUNING;
use physics::model::TireKind;
use physics::model::effect::law::{self, Law};
use physics::model::effect::{Channel, Course, Kind, Needs};
use physics::{Quantity, Wheel};
use predict::GriddedDrive;
use predict::grid::STEP_S;
use predict::noise::Live;

/// One thing that could be missing.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What.
    pub kind: &'static Kind,
    /// Of what.
    pub channel: Option<Channel>,
    /// The parameters that a search may change.
    pub free: Vec<usize>,
    /// Parameters fixed beforehand: place and coordinate.
    pub fixed: Vec<(usize, f64)>,
    /// It varies while one drives, so.
    pub live: Option<Live>,
    /// It is there within these stretches only, s; none: always.
    pub stretches: Vec<[f64; 2]>,
}

impl Candidate {
    /// The effect at which nothing happens; `slot` is the place of its course among those estimated.
    pub fn chosen(&self, slot: usize) -> Chosen {
        let course = match self.live {
            Some(_) => Course::Live(slot),
            None if self.stretches.is_empty() => Course::None,
            None => Course::Stretches { intervals: self.stretches.clone(), value: 1.0 },
        };
        let mut chosen = Chosen::usual(self.kind, self.channel, course);
        for (place, number) in &self.fixed {
            chosen.numbers[*place] = *number;
        }
        chosen.free.clone_from(&self.free);
        chosen
    }

    /// Is it something that is added in the course of time: a drift, a jump of a sensor's zero, wind, the road's bank? Nothing
    /// of it follows from inputs and motion.
    pub fn is_added_in_time(&self) -> bool {
        let is_jump = self.kind.is_of_measurement() && self.begins_later();
        is_jump || self.kind.disturbance(self.channel).is_some_and(|course| course.sign == 0.0)
    }

    /// Is it there from the start, of a kind that may as well begin later? Then nobody has taken out what never was in: its
    /// size is not negative.
    pub fn is_from_start(&self) -> bool {
        self.kind.search.from_start && !self.begins_later()
    }

    fn begins_later(&self) -> bool {
        self.fixed.iter().any(|(place, at)| Some(*place) == self.kind.onset() && *at > 0.0)
    }

    /// What it begins a fit with: where nothing at all has no derivative, a little.
    pub fn begun(&self) -> Chosen {
        let mut chosen = self.chosen(0);
        for (spec, number) in self.kind.parameters.iter().zip(&mut chosen.numbers) {
            if spec.is_main && *number == 0.0 {
                *number += spec.step;
            }
        }
        chosen
    }

    /// Has every car something of it, always?
    pub fn could_be_ordinary(&self) -> bool {
        self.live.is_none() && (self.kind.search.every_car_has || self.kind.usual(self.channel).is_some())
    }

    /// Its name, with its channel.
    pub fn name(&self) -> String {
        match self.channel {
            Some(channel) => format!("{}:{channel}", self.kind.name),
            None => self.kind.name.to_owned(),
        }
    }
}

/// When something could have begun, s, in a recording of so many seconds.
pub fn onsets(seconds: f64) -> Vec<f64> {
    let step = (seconds / (TUNING.selection.most_onsets + 1) as f64).max(TUNING.selection.between_onsets_s);
    (1..).map(|i| f64::from(i) * step).take_while(|t| *t < seconds - 0.5 * step).collect()
}

/// The same in the longest of some drives of which only an excerpt is gone over: between its runs any moment is
/// as good as another, which the next run's beginning stands for.
pub fn onsets_within(drives: &[GriddedDrive]) -> Vec<f64> {
    let Some(longest) = drives.iter().max_by(|a, b| a.used_seconds().total_cmp(&b.used_seconds())) else {
        return Vec::new();
    };
    let mut all: Vec<f64> = longest.runs.iter().skip(1).map(|(from, _)| *from as f64 * STEP_S).collect();
    let mut before = 0.0;
    let used = onsets(longest.used_seconds());
    for (from, to) in &longest.runs {
        let (from, seconds) = (*from as f64 * STEP_S, (to - from) as f64 * STEP_S);
        let within = used.iter().map(|used| used - before).filter(|used| (3.0..seconds - 3.0).contains(used));
        all.extend(within.map(|used| from + used));
        before += seconds;
    }
    all.sort_by(f64::total_cmp);
    all
}

/// All candidates of these kinds for a model, of a recording in which something could have begun at these moments, s.
pub fn library(
    kinds: &[&'static Kind],
    model: &Model<'_>,
    has: impl Fn(Quantity) -> bool,
    onsets: &[f64],
) -> Vec<Candidate> {
    let mut all = Vec::new();
    for kind in kinds.iter().copied() {
        let of: Vec<Option<Channel>> = match kind.channels {
            [] => vec![None],
            channels => {
                channels.iter().filter(|channel| is_there(**channel, &has)).map(|c| Some(*c)).collect()
            }
        };
        for channel in of {
            if !makes_sense(kind, channel, model) {
                continue;
            }
            let everything: Vec<usize> = (0..kind.parameters.len()).collect();
            let plain = Candidate {
                kind,
                channel,
                free: everything.clone(),
                fixed: Vec::new(),
                live: None,
                stretches: Vec::new(),
            };
            if let Some(course) = kind.disturbance(channel) {
                if !model.has_room() {
                    continue;
                }
                let live = Live {
                    size: course.size,
                    length_s: course.length_s,
                    least_s: course.shortest_s,
                    difference: if course.sign == 0.0 { 0.02 * course.size } else { 0.5 * course.size },
                };
                if course.sign == 0.0 {
                    all.push(Candidate { live: Some(live), ..plain });
                    continue;
                }
                // How much of the road is different is estimated; how different, is set.
                for setting in course.settings {
                    let fixed = setting.iter().copied().enumerate().collect();
                    all.push(Candidate { live: Some(live), free: Vec::new(), fixed, ..plain.clone() });
                }
                continue;
            }
            if kind.search.each_number_alone {
                all.extend(
                    everything.iter().map(|number| Candidate { free: vec![*number], ..plain.clone() }),
                );
                continue;
            }
            match kind.onset() {
                Some(at) => {
                    let free: Vec<usize> = everything.iter().copied().filter(|place| *place != at).collect();
                    for onset in onsets {
                        all.push(Candidate {
                            free: free.clone(),
                            fixed: vec![(at, *onset)],
                            ..plain.clone()
                        });
                    }
                    if kind.search.from_start {
                        all.push(Candidate { free, fixed: vec![(at, -1.0)], ..plain });
                    }
                }
                None => all.push(plain),
            }
        }
    }
    all
}

/// All laws that these sensors could show.
pub fn laws(has: impl Fn(Quantity) -> bool) -> Vec<Candidate> {
    let channels = Law::all().map(Channel::Law).filter(|channel| is_there(*channel, &has));
    let of = |channel| Candidate {
        kind: &law::KIND,
        channel: Some(channel),
        free: vec![0],
        fixed: Vec::new(),
        live: None,
        stretches: Vec::new(),
    };
    channels.map(of).collect()
}

fn is_there(channel: Channel, has: &impl Fn(Quantity) -> bool) -> bool {
    match channel {
        Channel::One(quantity) => has(quantity),
        Channel::Pair(a, b) => has(a) && has(b),
        Channel::Law(law) => {
            let wheel = law.place.wheel().map(|wheel| Quantity::wheel_speed(Wheel::ALL[wheel]));
            law.place.sensor().into_iter().chain(wheel).all(has)
        }
    }
}

/// Could it be told from the ordinary numbers at all?
fn makes_sense(kind: &Kind, channel: Option<Channel>, model: &Model<'_>) -> bool {
    let is_left_out =
        channel.and_then(Channel::quantity).is_some_and(|quantity| kind.search.not_of.contains(&quantity));
    let has_what_it_needs = match kind.search.needs {
        Needs::Nothing => true,
        Needs::LinearTire => model.vehicle.tire == TireKind::Linear,
        Needs::KnownTorque => model.torque.is_known(),
    };
    // Without a number there is nothing to search: the audit of the measurement chain looks for those.
    !kind.is_all_or_nothing() && !is_left_out && has_what_it_needs
}
