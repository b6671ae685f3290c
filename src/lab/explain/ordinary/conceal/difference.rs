//! The difference that effects make to the ordinary car on its drive.

use physics::model::Vehicle;
use physics::model::effect::{Channel, EffectConfig, Setting};
use physics::{Quantity, Wheel};

use super::super::answer::{LEAST_FIT, as_configured};
use super::super::choice::fit_ordinary;
use super::super::fit::FreeFit;
use super::super::fitted_number::{Number, numbers};
use super::super::grid::{STEP_S, resampled};
use super::super::inputs::{FreeDrive, Held, compared_mean};
use super::super::numbers::placed;
use super::super::run::{SpeedSensing, along, later};
use super::{Asked, Refusal, titles};
use crate::explain::Recording;
use crate::explain::model::{Chosen, Model};
use crate::explain::proof::ErrorSums;
use identify::Parameter;
use predict::ExtendedCar;
use predict::car::{Compute, EFFECT_STATES};

/// The ordinary car as this recording has it.
#[derive(Clone, Debug)]
pub struct Car {
    /// How much of the yaw rate its free run gives, %.
    pub fit: f64,
    /// Its numbers.
    pub numbers: Vec<Number>,
    /// See [`super::Concealment::unexplained`].
    pub(super) unexplained: [Option<f64>; Quantity::COUNT],
}

/// What is added to the recorded quantities at the grid points.
#[derive(Clone, Debug)]
pub(super) struct Difference {
    from_s: f64,
    /// Empty where nothing is.
    added: [Vec<f64>; Quantity::COUNT],
    /// What drives and brakes take along the wheels without the effects, and how much more with them, N.
    force: Vec<f64>,
    more_force: Vec<f64>,
    /// N m on the bus per N along the wheels.
    torque_per_force: Option<f64>,
    /// N m per N.
    radius: f64,
    /// A force of braking at which all of the change is the brakes', N.
    braking: f64,
}

/// A fit takes some seconds for a minute of driving: of a longer drive the liveliest part is taken, s.
const FITTED_S: f64 = 300.0;

/// The difference grows and fades over so long at both ends of the run, s.
const FADE_S: f64 = 1.0;

/// Below the first speed a free run means nothing, from the second one on it does, m/s.
const SPEEDS: (f64, f64) = (2.0, 4.0);

/// Where less than this is left of the yaw rate, rad/s, the car only hardly turned: what a gyroscope of series production
/// is off by.
const SMALL_YAW_RATE: f64 = 0.01;

/// A car that slides by this angle (rad) where it had less than half of it does not come back by itself.
const SPINNING: f64 = 0.35;

/// With a change by more than this share of the yaw rate's deviation the same steering leads off the road.
const ELSEWHERE: f64 = 0.4;

/// The same of any so many seconds.
const ELSEWHERE_FOR_A_WHILE: (f64, f64) = (0.75, 3.0);

/// What changes by less than this share of a sensor's usual error is not seen.
const VISIBLE: f64 = 0.01;

/// This share of the friction is more than a wheel transmits along.
const MOST_FORCE: f64 = 0.98;

/// Deceleration above which the brakes do all of it, m/s²: an engine alone drags with about so much.
const BRAKING_MPS2: f64 = 0.8;

/// A pressure at which brakes begin to grip, bar.
const GRIPPING_BAR: f64 = 1.0;

/// Everything along one free run.
#[derive(Debug, Default)]
struct Courses {
    of: [Vec<f64>; Quantity::COUNT],
    force: Vec<f64>,
    mass: Vec<f64>,
    sideslip: Vec<f64>,
}

/// The ordinary car as it drove, before anything is put in.
#[derive(Debug)]
pub struct Base<'a> {
    found: FreeFit<'a>,
    whole: FreeDrive,
    sensing: SpeedSensing,
    without: Courses,
    /// What is told of it.
    pub car: Car,
}

impl<'a> Base<'a> {
    /// Fits the car; `own` is the vehicle with tires that bend ([`with_bend`](super::with_bend)).
    ///
    /// # Errors
    /// Why there is no free run.
    pub fn of(own: &'a Vehicle, asked: &Asked<'_>) -> Result<Self, Refusal> {
        let no_run = |why: super::super::inputs::Unusable| Refusal::NoRun {
            effect: titles(asked.effects),
            why: why.to_string(),
        };
        let drive = |most_s| FreeDrive::new(asked.recording, own, Held::Nothing, most_s).map_err(no_run);
        let drives = [drive(FITTED_S)?];
        let found = fit_ordinary(&as_configured(own, asked.configured), own, &drives, None);
        let (model, sensing) = placed(&found.model, &found.free, &found.at, 0);
        let whole = drive(f64::INFINITY)?;
        let without = courses(&whole, &model.car(), sensing);
        let car = Car {
            fit: yaw_fit(&whole, &without),
            numbers: numbers(&found, &drives),
            unexplained: Quantity::ALL
                .map(|quantity| unexplained(quantity, &whole, &without, asked.recording)),
        };
        Ok(Self { found, whole, sensing, without, car })
    }

    /// What effects of runs do to it.
    ///
    /// # Errors
    /// Why the car cannot have them.
    pub(super) fn difference(
        &self,
        effects: &[EffectConfig],
        vehicle: &Vehicle,
    ) -> Result<Option<Difference>, Refusal> {
        if effects.is_empty() {
            return Ok(None);
        }
        let left = self.car.unexplained[Quantity::YawRate as usize].unwrap_or(f64::INFINITY);
        if (self.car.fit.is_nan() || self.car.fit < LEAST_FIT) && left > SMALL_YAW_RATE {
            return Err(Refusal::NotThisCar { fit: self.car.fit, left });
        }
        let (model, _) = placed(&self.found.model, &self.found.free, &self.found.at, 0);
        let changed = with(&model, effects)?;
        let with = courses(&self.whole, &changed.car(), self.sensing);
        check(&self.found, &self.whole, (&self.without, &with), effects)?;
        Ok(Some(Difference::new(&self.whole, self.sensing, (&self.without, with), vehicle)))
    }
}

/// The model with the effects. A kind that it has already takes the numbers that are given.
fn with<'a>(model: &Model<'a>, effects: &[EffectConfig]) -> Result<Model<'a>, Refusal> {
    let mut model = model.clone();
    for effect in effects {
        let coordinates = effect.coordinates();
        let has_it =
            |chosen: &&mut Chosen| chosen.kind == effect.kind() && chosen.channel == effect.channel();
        let repeats = effect.kind().course.is_some() || effect.kind().onset().is_some();
        match model.effects.iter_mut().find(has_it).filter(|_| !repeats) {
            Some(chosen) => {
                // What a table does not give stands there as usual, and uncertain.
                let given = coordinates.iter().enumerate().filter(|(_, coordinate)| coordinate.std == 0.0);
                for (place, coordinate) in given {
                    chosen.numbers[place] = coordinate.value;
                }
            }
            None => model.effects.push(Chosen::configured(effect)),
        }
    }
    let states = |chosen: &Chosen| {
        let values = chosen.values();
        let setting = Setting { values: &values, channel: chosen.channel, course: &chosen.course };
        chosen.kind.effect(&setting).states()
    };
    if model.effects.iter().map(states).sum::<usize>() > EFFECT_STATES {
        return Err(Refusal::TooMany { effect: titles(effects) });
    }
    Ok(model)
}

/// A free run with everything that sensors could say of it.
fn courses(drive: &FreeDrive, car: &ExtendedCar, sensing: SpeedSensing) -> Courses {
    let mut all = Courses::default();
    along(drive, car, sensing, Compute::Motion, |point| {
        let (now, rate) = (point.now, point.state().live[0]);
        let mut put = |quantity: Quantity, value: f64| all.of[quantity as usize].push(value);
        put(Quantity::YawRate, now.readings[Quantity::YawRate as usize]);
        put(Quantity::LateralAcceleration, now.readings[Quantity::LateralAcceleration as usize]);
        // The car accelerates as it did, whatever that takes.
        let missing = rate - now.rate.body[0];
        put(
            Quantity::LongitudinalAcceleration,
            now.readings[Quantity::LongitudinalAcceleration as usize] + missing,
        );
        let force = now.drive_force + (now.mass + now.turning_mass) * missing;
        let mut driven = *point.state();
        driven.live[0] = force / now.mass;
        let wheels = car.instant(
            point.t,
            &driven,
            point.input,
            point.steering_rate,
            point.before(),
            Compute::Readings,
        );
        for wheel in Wheel::ALL.map(Quantity::wheel_speed) {
            put(wheel, wheels.readings[wheel as usize] / sensing.scale);
        }
        all.force.push(force);
        all.mass.push(now.mass);
        all.sideslip.push(point.state().body[1].atan2(point.state().body[0]));
    });
    let along = Quantity::LongitudinalAcceleration;
    let lateral = Quantity::LateralAcceleration;
    for quantity in [Quantity::YawRate, lateral, along] {
        // Both accelerometers are in one unit.
        let of = if quantity == along { lateral } else { quantity };
        let course = std::mem::take(&mut all.of[quantity as usize]);
        all.of[quantity as usize] = later(course, car.delay(of as usize));
    }
    // They are on the bus by which the speed was measured.
    for wheel in Wheel::ALL.map(Quantity::wheel_speed) {
        let course = std::mem::take(&mut all.of[wheel as usize]);
        all.of[wheel as usize] = later(course, sensing.delay_s);
    }
    all.force = later(all.force, sensing.delay_s);
    all
}

/// How much of the yaw rate a free run gives, %; not a number where there is too little of it.
fn yaw_fit(drive: &FreeDrive, courses: &Courses) -> f64 {
    let said = &courses.of[Quantity::YawRate as usize];
    let counts = (0..drive.points()).filter(|i| drive.counts[*i] && drive.yaw_rate[*i].is_finite());
    let mut sums = ErrorSums::default();
    counts.for_each(|i| sums.add(drive.yaw_rate[i], said[i]));
    sums.fit().unwrap_or(f64::NAN)
}

/// Not-a-number of nothing.
fn average(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// What is left of a quantity, rms about its mean.
fn unexplained(
    quantity: Quantity,
    drive: &FreeDrive,
    courses: &Courses,
    recording: &Recording,
) -> Option<f64> {
    let said = &courses.of[quantity as usize];
    if said.is_empty() || !recording.has(quantity) {
        return None;
    }
    let measured = resampled(&recording.tracks[quantity as usize], drive.from_s, drive.points());
    let error: Vec<f64> = measured.iter().zip(said).map(|(measured, said)| measured - said).collect();
    let is_acceleration =
        matches!(quantity, Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration);
    let error = if is_acceleration { compared_mean(&error) } else { error };
    let counts = || {
        let all = error.iter().zip(&drive.counts);
        all.filter(|(error, counts)| **counts && error.is_finite()).map(|(error, _)| *error)
    };
    let mean = average(counts());
    Some(average(counts().map(|error| (error - mean).powi(2))).sqrt()).filter(|rms| rms.is_finite())
}

/// Does the car still drive there?
fn check(
    found: &FreeFit<'_>,
    drive: &FreeDrive,
    (without, with): (&Courses, &Courses),
    effects: &[EffectConfig],
) -> Result<(), Refusal> {
    let counts = || (0..drive.points()).filter(|i| drive.counts[*i]);
    let effect = titles(effects);
    let spins = |i: &usize| {
        let (was, is) = (without.sideslip[*i].abs(), with.sideslip[*i].abs());
        !is.is_finite() || (is > SPINNING && was < 0.5 * is)
    };
    if let Some(i) = counts().find(spins) {
        return Err(Refusal::Spins { effect, at: drive.time(i), degrees: with.sideslip[i].to_degrees() });
    }
    let of = |courses: &Courses, i: usize| courses.of[Quantity::YawRate as usize][i];
    let squares: Vec<f64> = counts().map(|i| (of(with, i) - of(without, i)).powi(2)).collect();
    let yaw_rates = || counts().map(|i| drive.yaw_rate[i]).filter(|yaw_rate| yaw_rate.is_finite());
    let mean = average(yaw_rates());
    let all = average(yaw_rates().map(|yaw_rate| (yaw_rate - mean).powi(2))).sqrt();
    let (most, seconds) = ELSEWHERE_FOR_A_WHILE;
    let whiles = squares.chunks((seconds / STEP_S) as usize).map(|part| (part, most));
    for (part, most) in whiles.chain([(&squares[..], ELSEWHERE)]) {
        let change = average(part.iter().copied()).sqrt();
        if change > (most * all).max(SMALL_YAW_RATE) {
            return Err(Refusal::Elsewhere { effect, change, all });
        }
    }
    let friction = placed(&found.model, &found.free, &found.at, 0).0.values.get(Parameter::Friction);
    let used = |courses: &Courses, i: usize| {
        courses.force[i].abs() / (friction * courses.mass[i] * physics::model::GRAVITY)
    };
    // Who brakes at the limit anyway may go on doing so.
    let slides = |i: &usize| used(with, *i) > MOST_FORCE.max(1.1 * used(without, *i));
    match counts().find(slides) {
        Some(i) => Err(Refusal::TooStrong { effect, needed: with.force[i], at: drive.time(i), friction }),
        None => Ok(()),
    }
}

impl Difference {
    fn new(
        drive: &FreeDrive,
        sensing: SpeedSensing,
        (without, with): (&Courses, Courses),
        vehicle: &Vehicle,
    ) -> Self {
        let points = drive.points();
        let weight = |i: usize| {
            let from_end = i.min(points - 1 - i) as f64 * STEP_S / FADE_S;
            let (speed, _) = drive.driven(drive.time(i), 0.0, sensing.scale);
            from_end.min((speed - SPEEDS.0) / (SPEEDS.1 - SPEEDS.0)).clamp(0.0, 1.0)
        };
        let weights: Vec<f64> = (0..points).map(weight).collect();
        let difference = |without: &[f64], with: &[f64]| -> Vec<f64> {
            let of = without.iter().zip(with).zip(&weights);
            of.map(|((without, with), weight)| weight * (with - without)).collect()
        };
        let added = std::array::from_fn(|place| difference(&without.of[place], &with.of[place]));
        let more_force = difference(&without.force, &with.force);
        let (radius, ratio) = (vehicle.wheel_radius_m.value, vehicle.drive_torque_ratio.value);
        Self {
            from_s: drive.from_s,
            added,
            more_force,
            torque_per_force: Some(radius / ratio).filter(|share| share.is_finite()),
            radius,
            braking: BRAKING_MPS2 * average(without.mass.iter().copied()),
            force: without.force.clone(),
        }
    }

    /// Does it change a quantity at all?
    pub(super) fn changes(&self, quantity: Quantity) -> bool {
        let course = match quantity {
            Quantity::DriveTorque if self.torque_per_force.is_some() => &self.more_force,
            _ => &self.added[quantity as usize],
        };
        let usual = Channel::from(quantity).usual_error().map_or(1.0, |(_, size)| size);
        course.iter().any(|change| change.abs() > VISIBLE * usual)
    }

    /// A quantity with the difference; `recorded` says what else was recorded at a time.
    pub(super) fn of(
        &self,
        quantity: Quantity,
        t: f64,
        value: f64,
        recorded: impl Fn(Quantity, f64) -> Option<f64>,
    ) -> f64 {
        let more = self.at(&self.more_force, t);
        if more == 0.0 {
            return value + self.at(&self.added[quantity as usize], t);
        }
        let force = self.at(&self.force, t);
        // What the brakes do, they do more of in proportion: so nobody needs to know how strong they are.
        let pressure = || {
            let pressure = recorded(Quantity::BrakePressure, t).map(|bar| bar / GRIPPING_BAR);
            let torque =
                || recorded(Quantity::BrakeTorque, t).map(|torque| torque.abs() / (self.radius * 100.0));
            pressure.or_else(torque).unwrap_or(0.0).clamp(0.0, 1.0)
        };
        let braking = (-force / self.braking).clamp(0.0, 1.0);
        match quantity {
            Quantity::DriveTorque => {
                let by_torque = 1.0 - braking * pressure();
                value + self.torque_per_force.unwrap_or(0.0) * by_torque * more
            }
            Quantity::BrakePressure | Quantity::BrakeTorque if braking > 0.0 => {
                value * (1.0 + braking * more / force).max(0.0)
            }
            _ => value + self.at(&self.added[quantity as usize], t),
        }
    }

    /// On a straight line between grid points; zero outside.
    fn at(&self, course: &[f64], t: f64) -> f64 {
        let place = (t - self.from_s) / STEP_S;
        if place < 0.0 || place.is_nan() {
            return 0.0;
        }
        let before = place as usize;
        match course.get(before..before + 2) {
            Some([from, to]) => from + (place - before as f64) * (to - from),
            _ => 0.0,
        }
    }
}
