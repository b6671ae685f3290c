//! A model of the car as a search sees it: its numbers, its effects, and which of them are free.

use std::borrow::Cow;

use super::correction::is_disturbance;
use super::tuning::TUNING;
use identify::{Parameter, Values};
use physics::model::effect::{Channel, Course, EffectConfig, KINDS, Kind, Series, Setting, Spec};
use physics::model::{TireKind, Vehicle};
use physics::{Quantity, Wheel};
use predict::car::MOST_LIVE;
use predict::delay::{Delayed, Delays};
use predict::{ExtendedCar, Settings, Torque};

/// An effect with its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// What it is.
    pub kind: &'static Kind,
    /// What it is of.
    pub channel: Option<Channel>,
    /// The coordinate of each of its parameters ([`Spec::scale`]).
    pub numbers: Vec<f64>,
    /// Which of them a search may change.
    pub free: Vec<usize>,
    /// What a configuration says of the deviation of each coordinate; empty, where none does.
    pub told: Vec<f64>,
    /// How it varies.
    pub course: Course,
}

impl Chosen {
    /// With the usual numbers, at which nothing happens; all of them free.
    pub fn usual(kind: &'static Kind, channel: Option<Channel>, course: Course) -> Self {
        let (numbers, free, told) = (Vec::new(), Vec::new(), Vec::new());
        let mut chosen = Self { kind, channel, numbers, free, told, course };
        chosen.numbers = chosen.specs().map(|spec| spec.mean).collect();
        chosen.free = (0..chosen.numbers.len()).collect();
        chosen
    }

    /// As a configuration has it; nothing of it is free.
    pub fn configured(config: &EffectConfig) -> Self {
        let (numbers, told) =
            config.coordinates().iter().map(|coordinate| (coordinate.value, coordinate.std)).unzip();
        Self {
            kind: config.kind(),
            channel: config.channel(),
            numbers,
            free: Vec::new(),
            told,
            course: config.course().clone(),
        }
    }

    /// The same with those main numbers free that the configuration calls uncertain.
    pub fn free_where_uncertain(mut self) -> Self {
        let uncertain = self.specs().zip(&self.told).enumerate();
        let uncertain = uncertain.filter(|(_, (spec, std))| spec.is_main && **std > 0.0);
        self.free = uncertain.map(|(place, _)| place).collect();
        self
    }

    /// What is known of its numbers.
    pub fn specs(&self) -> impl Iterator<Item = Spec> + '_ {
        (0..self.kind.parameters.len()).filter_map(|place| self.kind.spec(place, self.channel))
    }

    /// Is a number of it called so?
    pub fn is(&self, number: usize, name: &str) -> bool {
        self.kind.place_of(name) == Some(number)
    }

    /// When it begins, s; long ago, where it is always there.
    pub fn onset(&self) -> f64 {
        self.kind.onset().map_or(f64::NEG_INFINITY, |place| self.numbers[place])
    }

    /// Its course, where that is points in time.
    pub fn series(&self) -> Option<&Series> {
        match &self.course {
            Course::Series(series) => Some(series),
            _ => None,
        }
    }

    /// Its numbers in their units.
    pub fn values(&self) -> Vec<f64> {
        self.specs().zip(&self.numbers).map(|(spec, number)| spec.value(*number)).collect()
    }

    /// Where it stands in the list of all effects: they act in that order.
    fn order(&self) -> usize {
        KINDS.iter().position(|kind| std::ptr::eq(*kind, self.kind)).unwrap_or(usize::MAX)
    }
}

/// The plain model with any effects.
#[derive(Clone, Debug)]
pub struct Model<'a> {
    /// What does not change.
    pub vehicle: Cow<'a, Vehicle>,
    /// What is known of drive and brake torques.
    pub torque: Torque,
    /// Ordinary numbers.
    pub values: Values,
    /// How late sensors and torques are, s.
    pub delays: Delays,
    /// How much of the lateral curve's bend the longitudinal one has.
    pub bend_along: f64,
    /// Physics beyond the plain model.
    pub effects: Vec<Chosen>,
}

/// A number that a search may change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Of the vehicle, or a sensor's offset.
    Ordinary(Parameter),
    /// How late something is.
    Delay(Delayed),
    /// How much of the lateral curve's bend the longitudinal one has: friction along and across are
    /// seldom the same, and one limit is all that the vehicle's table has.
    BendAlong,
    /// Of an effect: which effect, which number.
    Effect(usize, usize),
    /// Of the course of an effect: which effect, which of its points.
    Course(usize, usize),
}

/// A free number: its place, its prior and a step, all in the coordinate that is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Where it is.
    pub place: Place,
    /// Mean of the prior.
    pub mean: f64,
    /// Standard deviation of the prior.
    pub std: f64,
    /// Step of differences.
    pub step: f64,
}

/// Mean and standard deviation of what is thought of the longitudinal curve's bend.
/// Physical: from no bend to the same as of the lateral curve, and nothing more is known.
const BEND_ALONG: (f64, f64) = (0.5, 0.5);

impl<'a> Model<'a> {
    /// The plain model as the vehicle's table has it.
    pub fn plain(vehicle: &'a Vehicle, torque: Torque) -> Self {
        Self {
            vehicle: Cow::Borrowed(vehicle),
            torque,
            values: Values::of(vehicle),
            delays: Delayed::usual(),
            bend_along: BEND_ALONG.0,
            effects: Vec::new(),
        }
    }

    /// The same with another table of the car.
    pub fn of(&self, vehicle: Vehicle) -> Self {
        Self { vehicle: Cow::Owned(vehicle), ..self.clone() }
    }

    /// The same with effects that a configuration switches on, as it has them.
    pub fn with_configured(&self, effects: &[EffectConfig]) -> Self {
        let mut model = self.clone();
        model.effects.extend(effects.iter().map(Chosen::configured));
        model
    }

    /// How many courses are no effect's, but of what nobody knows: torques, disturbances. They come first.
    pub fn own_courses(&self) -> usize {
        let disturbances = self.effects.iter().filter(|chosen| is_disturbance(chosen.kind));
        self.torque.courses() + disturbances.count()
    }

    /// Can a filter estimate another course?
    pub fn has_room(&self) -> bool {
        let courses = self.effects.iter().filter(|chosen| matches!(chosen.course, Course::Live(_)));
        self.torque.courses() + courses.count() < MOST_LIVE
    }

    /// The car it describes.
    pub fn car(&self) -> ExtendedCar {
        let mut effects: Vec<&Chosen> = self.effects.iter().collect();
        effects.sort_by_key(|chosen| chosen.order());
        let effects = effects.into_iter().map(|chosen| {
            let values = chosen.values();
            chosen.kind.effect(&Setting { values: &values, channel: chosen.channel, course: &chosen.course })
        });
        ExtendedCar::new(Settings {
            vehicle: &self.vehicle,
            values: &self.values,
            torque: self.torque,
            delays: self.delays,
            bend_along: self.bend_along,
            effects: effects.collect(),
        })
    }

    /// The same with another effect.
    pub fn with(&self, chosen: Chosen) -> Self {
        let mut model = self.clone();
        model.effects.push(chosen);
        model
    }

    /// What is free in the plain model: all that the vehicle's table calls uncertain, and the sensors'
    /// offsets.
    pub fn ordinary(&self, has: impl Fn(Quantity) -> bool) -> Vec<Free> {
        let drive = if self.torque.is_known() {
            identify::LongitudinalInput::Torque
        } else if Wheel::ALL.into_iter().any(|wheel| has(Quantity::wheel_speed(wheel))) {
            identify::LongitudinalInput::WheelSpeeds
        } else {
            identify::LongitudinalInput::Speed
        };
        let is_slip_offset = |p: &Parameter| {
            use Parameter::{SlipOffsetFl, SlipOffsetFr, SlipOffsetRl, SlipOffsetRr};
            matches!(p, SlipOffsetFl | SlipOffsetFr | SlipOffsetRl | SlipOffsetRr)
        };
        let usual = Parameter::usual(&self.vehicle, drive, &has);
        let mut parameters: Vec<Parameter> = usual.into_iter().filter(|p| !is_slip_offset(p)).collect();
        if !self.torque.is_known() && has(Quantity::LongitudinalAcceleration) {
            parameters.push(Parameter::LongitudinalAccelerationOffset);
        }
        let mut free: Vec<Free> = parameters.into_iter().map(|p| self.free_ordinary(p)).collect();
        let late = Delayed::ALL.into_iter().filter(|late| has(late.quantity()));
        free.extend(late.filter(|late| self.torque.is_known() || *late != Delayed::Torque).map(|late| {
            let (mean, std) = late.prior();
            Free { place: Place::Delay(late), mean, std, step: 0.001 }
        }));
        // Linear tires have a bend once an effect gives them a limit.
        if self.torque.is_known() {
            free.push(Free { place: Place::BendAlong, mean: BEND_ALONG.0, std: BEND_ALONG.1, step: 0.05 });
        }
        free
    }

    fn free_ordinary(&self, parameter: Parameter) -> Free {
        let prior = parameter.prior(&self.vehicle);
        let place = Place::Ordinary(parameter);
        if is_logarithmic(parameter) {
            let std = prior.std / prior.value;
            return Free { place, mean: prior.value.ln(), std, step: (0.1 * std).clamp(1e-3, 0.05) };
        }
        Free { place, mean: prior.value, std: prior.std, step: 0.05 * prior.std }
    }

    /// The numbers of one of its effects that a search may change.
    pub fn free_of_effect(&self, effect: usize) -> Vec<Free> {
        let chosen = &self.effects[effect];
        let free = chosen.specs().enumerate().filter(|(place, _)| chosen.free.contains(place));
        let free = free.map(|(place, spec)| Free {
            place: Place::Effect(effect, place),
            mean: spec.mean,
            std: spec.std,
            step: spec.step,
        });
        free.collect()
    }

    /// The coordinate of a free number.
    pub fn get(&self, place: Place) -> f64 {
        match place {
            Place::Ordinary(p) if is_logarithmic(p) => self.values.get(p).ln(),
            Place::Ordinary(p) => self.values.get(p),
            Place::Delay(late) => self.delays[late as usize],
            Place::BendAlong => self.bend_along,
            Place::Effect(effect, number) => self.effects[effect].numbers[number],
            Place::Course(effect, point) => {
                self.effects[effect].series().map_or(0.0, |series| series.value[point])
            }
        }
    }

    /// Name and value of an ordinary number in its unit, and how the value changes with the coordinate;
    /// none of an effect's.
    pub fn ordinary_number(&self, place: Place) -> Option<(String, f64, f64)> {
        Some(match place {
            Place::Ordinary(p) => {
                let value = self.values.get(p);
                (p.name().into(), value, if is_logarithmic(p) { value } else { 1.0 })
            }
            Place::Delay(late) => (late.name().into(), self.delays[late as usize], 1.0),
            Place::BendAlong => ("longitudinal_bend".into(), self.bend_along, 1.0),
            Place::Effect(..) | Place::Course(..) => return None,
        })
    }

    /// What the coordinate of a number can be at least and at most.
    fn bounds(&self, place: Place) -> (f64, f64) {
        let around = |mean: f64, most: f64| (mean - most, mean + most);
        match place {
            Place::Ordinary(p) => {
                let Free { mean, std, .. } = self.free_ordinary(p);
                let (low, high) = around(mean, TUNING.selection.ordinary_stds * std);
                let (least, most) = p.bounds();
                let of = |bound: f64| if is_logarithmic(p) { bound.ln() } else { bound };
                (low.max(of(least)), high.min(of(most)))
            }
            Place::Delay(late) => {
                let (mean, std) = late.prior();
                around(mean, TUNING.selection.ordinary_delay_stds * std)
            }
            Place::BendAlong => (0.0, 1.2),
            Place::Effect(effect, number) => {
                let chosen = &self.effects[effect];
                let spec = chosen.kind.spec(number, chosen.channel);
                spec.map_or((f64::NEG_INFINITY, f64::INFINITY), |spec| spec.bounds)
            }
            Place::Course(..) => (f64::NEG_INFINITY, f64::INFINITY),
        }
    }

    /// Is a number at what it can be at most or least?
    pub fn is_at_bound(&self, place: Place) -> bool {
        is_at_either(self.get(place), self.bounds(place))
    }

    /// How far a coordinate may go, down and up.
    pub fn room(&self, place: Place) -> (f64, f64) {
        let (at, (low, high)) = (self.get(place), self.bounds(place));
        ((low - at).min(0.0), (high - at).max(0.0))
    }

    /// Changes a free number, within its bounds.
    pub fn set(&mut self, place: Place, coordinate: f64) {
        let (low, high) = self.bounds(place);
        // A table's own value may be outside of what is thought of any car.
        self.put(place, coordinate.max(low).min(high.max(low)));
    }

    /// Puts a number where it is told, whatever is thought of it.
    pub fn put(&mut self, place: Place, coordinate: f64) {
        match place {
            Place::Ordinary(p) => {
                self.values.set(p, if is_logarithmic(p) { coordinate.exp() } else { coordinate });
            }
            Place::Delay(late) => self.delays[late as usize] = coordinate,
            Place::BendAlong => self.bend_along = coordinate,
            Place::Effect(effect, number) => self.effects[effect].numbers[number] = coordinate,
            Place::Course(effect, point) => {
                if let Course::Series(series) = &mut self.effects[effect].course {
                    series.value[point] = coordinate;
                }
            }
        }
    }

    /// Until when another model says the same, s: what begins later makes no difference before. (No effect that
    /// begins later has states of its own.)
    pub fn same_until(&self, other: &Self) -> f64 {
        let is_straight = |model: &Self| model.vehicle.tire == TireKind::Linear && model.effects.is_empty();
        let bends_alike = self.bend_along == other.bend_along || (is_straight(self) && is_straight(other));
        let is_plain_alike = self.values == other.values
            && self.delays == other.delays
            && bends_alike
            && self.torque == other.torque;
        if !is_plain_alike {
            return f64::NEG_INFINITY;
        }
        let count = self.effects.len().max(other.effects.len());
        let pairs = (0..count).map(|place| (self.effects.get(place), other.effects.get(place)));
        let different = pairs.filter(|(one, another)| one != another);
        different
            .flat_map(|(one, another)| [one, another])
            .flatten()
            .map(Chosen::onset)
            .fold(f64::INFINITY, f64::min)
    }

    /// Between which moments, s, a point of a course makes a difference; none of other numbers.
    pub fn course_between(&self, place: Place) -> Option<[f64; 2]> {
        let Place::Course(effect, point) = place else { return None };
        let t = &self.effects[effect].series()?.t;
        let before = point.checked_sub(1).map_or(f64::NEG_INFINITY, |before| t[before]);
        Some([before, t.get(point + 1).copied().unwrap_or(f64::INFINITY)])
    }

    /// The same, one number changed by so much (in the other direction at its bound). Returns the change
    /// made.
    pub fn varied(&self, free: &Free) -> (Self, f64) {
        let back = Free { step: -free.step, ..*free };
        self.moved(free).or_else(|| self.moved(&back)).unwrap_or_else(|| (self.clone(), free.step))
    }

    /// The same, one number changed by its step, and the change made; none where its bounds forbid it.
    pub fn moved(&self, free: &Free) -> Option<(Self, f64)> {
        let at = self.get(free.place);
        let mut model = self.clone();
        model.set(free.place, at + free.step);
        let made = model.get(free.place) - at;
        (made.abs() > 0.5 * free.step.abs()).then_some((model, made))
    }
}

/// Is a coordinate at one of its bounds?
pub fn is_at_either(coordinate: f64, (low, high): (f64, f64)) -> bool {
    (coordinate - low).min(high - coordinate) < 1e-3 * (high - low)
}

/// Is its logarithm searched for?
fn is_logarithmic(parameter: Parameter) -> bool {
    use Parameter::{Drag, DriveTorqueRatio, MagicCurvature, RollingResistance};
    !parameter.is_offset()
        && !matches!(parameter, DriveTorqueRatio | Drag | RollingResistance | MagicCurvature)
}

#[cfg(test)]
mod tests {
    use super::super::bench::recorded;
    use super::*;
    use physics::Quantity;
    use physics::model::effect::{Channel, Course, KINDS, Setting};
    use predict::pass::{Beside, Other, pass};
    use predict::{GriddedDrive, noise::Noise, sums::PassOptions};

    #[test]
    fn a_linear_tire_bends_along_as_it_likes_once_it_has_a_limit() {
        let vehicle = Vehicle { tire: TireKind::Linear, ..Vehicle::thesis() };
        let plain = Model::plain(&vehicle, Torque::Recorded);
        let free = plain.ordinary(|_| true);
        let bend = free.iter().find(|free| free.place == Place::BendAlong).unwrap();
        // Until then nothing is different.
        assert_eq!(plain.same_until(&plain.varied(bend).0), f64::INFINITY);
        let limit = KINDS.iter().find(|kind| kind.name == "tire_saturation").unwrap();
        let limited = plain.with(Chosen::usual(limit, None, Course::None));
        assert_eq!(limited.same_until(&limited.varied(bend).0), f64::NEG_INFINITY);
        // Without a torque its slips are measured.
        assert!(
            Model::plain(&vehicle, Torque::Unknown)
                .ordinary(|_| true)
                .iter()
                .all(|f| f.place != Place::BendAlong)
        );
    }

    #[test]
    fn what_begins_late_needs_no_lane_until_then() {
        let (vehicle, recording) = recorded("");
        let drives = [GriddedDrive::new(&recording, &vehicle)];
        let plain = Model::plain(&vehicle, Torque::Recorded);
        let kind = KINDS.iter().find(|kind| kind.name == "sensor_bias").unwrap();
        let steering = Some(Channel::One(Quantity::SteeringWheelAngle));
        let mut jump = Chosen::usual(kind, steering, Course::None);
        jump.numbers[kind.onset().unwrap()] = 22.0;
        jump.numbers[kind.place_of("bias").unwrap()] = 0.02;
        let jumps = plain.with(jump);
        assert_eq!(plain.same_until(&jumps), 22.0);
        assert_eq!(jumps.same_until(&jumps), f64::INFINITY);
        let sums = |same_until: f64| {
            let others = [Other { car: jumps.car(), by: 0.02, same_until }];
            let beside = Beside { together: &others, alone: &others };
            pass((0, &drives[0]), &plain.car(), beside, &Noise::first(&drives), PassOptions::default())
        };
        let (own, late) = (sums(f64::NEG_INFINITY), sums(22.0));
        for (own, late) in own.iter().zip(&late) {
            assert!((&own.gram - &late.gram).amax() <= 1e-9 * own.gram.amax(), "{:?}", own.t);
            assert_eq!(own.gram[(1, 1)] > 0.0, own.t.1 > 22.0, "{:?}", own.t);
            // Alone, it has the same products with the innovations, with itself together with others, and with itself.
            let expected = [late.gram[(1, 0)], late.gram[(1, 1)], late.gram[(1, 1)]];
            for (product, expected) in late.alone.iter().zip(expected) {
                assert!((product - expected).abs() <= 1e-9 * expected.abs(), "{:?}", late.t);
            }
        }
    }

    #[test]
    fn nothing_that_begins_late_has_states_of_its_own() {
        let late: Vec<_> = KINDS.iter().filter(|kind| kind.onset().is_some()).collect();
        assert!(late.len() >= 3);
        for kind in late {
            let channel = kind.channels.first().copied();
            let chosen = Chosen::usual(kind, channel, Course::None);
            let values = chosen.values();
            let effect = kind.effect(&Setting { values: &values, channel, course: &chosen.course });
            assert_eq!(effect.states(), 0, "{}", kind.name);
        }
    }
}
