//! Effects at work in a simulation.
//!
//! Effects change the right-hand side of the car's equations at every stage of every substep, and their
//! own states are integrated together with the car's by the same Runge–Kutta steps: a tire's slip angle
//! that lags behind and the body that it moves are one fast system (a relaxation length of 0.3 m at
//! 40 m/s is 7 ms), and holding one of them still for a step would make it first order in the step and
//! less damped. What an effect takes from a moment ago ([`Now::ax`], [`Now::ay`], [`Now::front_force`])
//! is that of the substep's start, because the forces it is made of follow from it.

use std::sync::Arc;

use crate::Quantity;
use crate::model::effect::{
    Acting, Before, Course, EffectConfig, EffectList, Felt, MOST_STATES, Now, Readings,
};
use crate::model::integrate;
use crate::model::plant::Between;
use crate::model::tire::ellipse::{self, EllipseFactors};
use crate::model::tire::{Contact, Tire};
use crate::model::{Conditions, Controls, Plant, Response, State};

/// States that all effects may have together.
pub(in crate::model) const OWN_STATES: usize = 4 * MOST_STATES;

/// The effects' own states, one after the other.
type Own = [f64; OWN_STATES];

/// Fastest rate of a state of an effect, 1/s: lags are 5 ms or more.
const FASTEST_RATE: f64 = 200.0;

/// The effects of a drive, their own states, and what was a moment ago.
#[derive(Clone, Debug)]
pub(super) struct Effects {
    list: Arc<EffectList>,
    /// Of each effect, if it has one.
    courses: Arc<[Option<Course>]>,
    own: Own,
    before: Before,
    steering_ratio: f64,
}

/// The car without effects, on the road as it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain<'a> {
    pub(super) plant: &'a Plant,
    pub(super) contact: &'a [Contact; 4],
}

/// The car as effects make it at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shaped {
    pub(super) plant: Plant,
    pub(super) conditions: Conditions,
    /// Angle of the front wheels, rad.
    pub(super) steer: f64,
    gravity: [f64; 2],
    /// What each brake gives, relative to the plain car's.
    brake_gain: [f64; 4],
    /// Torque of brakes that nobody records, N m; negative where it drives.
    hidden_brake: [f64; 4],
    ellipse: EllipseFactors,
}

/// What came of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    pub(super) response: Response,
    pub(super) felt: Felt,
}

/// What effects do between motion and tire force.
struct Through<'a> {
    list: &'a EffectList,
    now: &'a Now<'a>,
    own: &'a Own,
    ellipse: EllipseFactors,
}

impl Between for Through<'_> {
    fn answered(&self, mut slip_angle: [f64; 4]) -> [f64; 4] {
        self.list.slip_angles(self.now, self.own, &mut slip_angle);
        slip_angle
    }

    /// With shares of the friction ellipse below the limit each force is what the effect says, then the limit holds. A
    /// brush has its combined slip already, and a linear tire no limit.
    fn force(&self, tire: &Tire, contact: &Contact, slip: f64, slip_angle: f64) -> [f64; 2] {
        let bounded = matches!(tire, Tire::PiecewiseLinear(_) | Tire::MagicFormula(_));
        let [x, y] = if bounded {
            [tire.longitudinal(contact, slip), tire.lateral(contact, slip_angle)]
        } else {
            tire.combined(contact, slip, slip_angle)
        };
        let x = x * self.ellipse.left_along(tire, tire, contact, slip_angle);
        let forces = [x, y * self.ellipse.left_across(tire, contact, x)];
        if bounded { ellipse::scaled_back(contact, forces) } else { forces }
    }
}

impl Effects {
    /// The effects of these tables; none if there are no tables.
    pub(super) fn new(configs: &[EffectConfig], steering_ratio: f64) -> Option<Self> {
        if configs.is_empty() {
            return None;
        }
        let course = |config: &EffectConfig| config.kind().course.map(|_| config.course().clone());
        Some(Self {
            list: Arc::new(EffectList::new(EffectConfig::effects(configs))),
            courses: EffectConfig::in_order(configs).into_iter().map(course).collect(),
            own: [0.0; OWN_STATES],
            before: Before::default(),
            steering_ratio,
        })
    }

    /// The same kinds with other numbers: their states stay.
    pub(super) fn going_on_from(self, old: &Self) -> Self {
        Self { own: old.own, before: old.before, ..self }
    }

    /// Free rolling straight ahead, on wheels of the radius they have; the own states begin there.
    pub(super) fn begin(&mut self, plain: &Plain<'_>, speed: f64, steering_wheel: f64) -> State {
        let mut state = State::rolling(plain.plant, speed);
        let mut own = self.own;
        let now = self.now(plain, 0.0, &state, steering_wheel);
        self.list.begin(&now, &mut own);
        let radius = self.shaped(plain, &now, &own).plant.radius;
        self.own = own;
        state.wheel_speed = radius.map(|radius| speed / radius);
        state
    }

    fn now<'a>(&self, plain: &Plain<'a>, t: f64, state: &State, steering_wheel: f64) -> Now<'a> {
        let now = Now::new(plain.plant, self.steering_ratio, t, state.velocity, &self.before);
        Now { steering_wheel, ..now }
    }

    /// What the effects make of the car before its tires' forces are known.
    fn shaped(&self, plain: &Plain<'_>, now: &Now<'_>, own: &Own) -> Shaped {
        let mut on = Acting::plain(plain.plant, now.steering_wheel, now.steering_ratio);
        on.contact = *plain.contact;
        self.list.act(now, own, &mut on);
        let (steer, external) = (on.steer(), on.external());
        let Acting { body, tire, radius, contact, load, toe, brake_gain, brake, gravity, ellipse, .. } = on;
        Shaped {
            plant: Plant { body, tire, radius, ..*plain.plant },
            conditions: Conditions { contact, load, toe, external },
            steer,
            gravity,
            brake_gain,
            hidden_brake: std::array::from_fn(|i| brake[i] * radius[i]),
            ellipse,
        }
    }

    fn through<'a>(&'a self, shaped: &Shaped, now: &'a Now<'a>, own: &'a Own) -> Through<'a> {
        Through { list: &self.list, now, own, ellipse: shaped.ellipse }
    }

    /// How the own states change, per second.
    fn rates(&self, now: &Now<'_>, felt: &Felt, own: &Own) -> Own {
        let mut rates = [0.0; OWN_STATES];
        self.list.rates(now, felt, own, &mut rates);
        rates
    }

    /// Evaluates a state, and remembers what effects look back at.
    pub(super) fn observe(
        &mut self,
        plain: &Plain<'_>,
        t: f64,
        state: &State,
        controls: &Controls,
    ) -> (Shaped, Outcome) {
        let now = self.now(plain, t, state, self.steering_wheel(controls));
        let shaped = self.shaped(plain, &now, &self.own);
        let between = self.through(&shaped, &now, &self.own);
        let controls = shaped.steered(controls);
        let response = shaped.plant.respond_through(state, &controls, &shaped.conditions, &between);
        let outcome = shaped.outcome(response);
        self.before = Before::of(&outcome.felt);
        (shaped, outcome)
    }

    /// What the sensors make of the truth.
    pub(super) fn sense(
        &self,
        plain: &Plain<'_>,
        t: f64,
        state: &State,
        felt: &Felt,
        readings: &mut Readings,
    ) {
        let now = self.now(plain, t, state, readings[Quantity::SteeringWheelAngle as usize]);
        self.list.sense(&now, felt, &self.own, readings);
    }

    /// The state after `h` seconds from `t` on, with the controls going linearly from `from` to `to`, in as
    /// many substeps as wheels and effects need.
    pub(super) fn advance(
        &mut self,
        plain: &Plain<'_>,
        t: f64,
        h: f64,
        state: &State,
        [from, to]: [&Controls; 2],
    ) -> State {
        let now = self.now(plain, t, state, self.steering_wheel(from));
        let shaped = self.shaped(plain, &now, &self.own);
        let wheels = integrate::substeps(&shaped.plant, state, &shaped.conditions, h);
        let substeps = wheels.max((FASTEST_RATE * h).ceil() as u32);
        let share = 1.0 / f64::from(substeps);
        let mut state = *state;
        let mut start = *from;
        for i in 0..substeps {
            let middle = from.towards(to, share * (f64::from(i) + 0.5));
            let end = from.towards(to, share * f64::from(i + 1));
            let t = t + h * share * f64::from(i);
            state = self.runge_kutta(plain, t, h * share, &state, [&start, &middle, &end]);
            start = end;
        }
        state
    }

    /// One step, with the controls at its start, middle and end: that of [`integrate`] with the own states.
    fn runge_kutta(
        &mut self,
        plain: &Plain<'_>,
        t: f64,
        h: f64,
        state: &State,
        [start, middle, end]: [&Controls; 3],
    ) -> State {
        let own = self.own;
        let braking = {
            let now = self.now(plain, t, state, self.steering_wheel(start));
            let shaped = self.shaped(plain, &now, &own);
            let between = self.through(&shaped, &now, &own);
            let controls = shaped.steered(start);
            shaped.plant.braking(state, &controls, &shaped.conditions, &between)
        };
        let stage = |effects: &Self, t: f64, state: &State, own: &Own, controls: &Controls| {
            let now = effects.now(plain, t, state, effects.steering_wheel(controls));
            let shaped = effects.shaped(plain, &now, own);
            let between = effects.through(&shaped, &now, own);
            let controls = shaped.steered(controls);
            let response = shaped.plant.braked(state, &controls, &shaped.conditions, &braking, &between);
            let outcome = shaped.outcome(response);
            (effects.rates(&now, &outcome.felt, own), outcome)
        };
        let (own1, first) = stage(self, t, state, &own, start);
        self.before = Before::of(&first.felt);
        let k1 = first.response.rate;
        let next =
            |own_rate: &Own, rate: &State, h: f64| (advanced(&own, own_rate, h), state.advanced(rate, h));
        let (own_at, at) = next(&own1, &k1, 0.5 * h);
        let (own2, second) = stage(self, t + 0.5 * h, &at, &own_at, middle);
        let k2 = second.response.rate;
        let (own_at, at) = next(&own2, &k2, 0.5 * h);
        let (own3, third) = stage(self, t + 0.5 * h, &at, &own_at, middle);
        let k3 = third.response.rate;
        let (own_at, at) = next(&own3, &k3, h);
        let (own4, fourth) = stage(self, t + h, &at, &own_at, end);
        let k4 = fourth.response.rate;
        for (i, own) in self.own.iter_mut().enumerate() {
            *own += h / 6.0 * (own1[i] + 2.0 * (own2[i] + own3[i]) + own4[i]);
        }
        let mut next =
            state.advanced(&k1, h / 6.0).advanced(&k2, h / 3.0).advanced(&k3, h / 3.0).advanced(&k4, h / 6.0);
        for (i, brake) in braking.iter().enumerate() {
            next.wheel_speed[i] = brake.stopped(next.wheel_speed[i], end.brake_torque[i]);
        }
        next
    }

    fn steering_wheel(&self, controls: &Controls) -> f64 {
        controls.steer * self.steering_ratio
    }

    /// The courses at `t` and the own states, in the order of [`crate::model::effect::column_names`].
    pub(super) fn series(&self, t: f64, series: &mut Vec<f64>) {
        series.clear();
        for (course, own) in self.courses.iter().zip(self.list.places()) {
            series.extend(course.as_ref().map(|course| course.at_time(t)));
            series.extend_from_slice(&self.own[own]);
        }
    }
}

fn advanced(own: &Own, rate: &Own, h: f64) -> Own {
    std::array::from_fn(|i| own[i] + h * rate[i])
}

impl Shaped {
    /// The controls with the front wheels and the brakes as the effects make them.
    fn steered(&self, controls: &Controls) -> Controls {
        let mut controls = Controls { steer: self.steer, ..*controls };
        for (i, hidden) in self.hidden_brake.into_iter().enumerate() {
            controls.brake_torque[i] = self.brake_gain[i] * controls.brake_torque[i] + hidden.max(0.0);
            controls.drive_torque[i] -= hidden.min(0.0);
        }
        controls
    }

    fn outcome(&self, response: Response) -> Outcome {
        let Response { acceleration, slip_angle, fx, fy, .. } = &response;
        let felt = Felt::new(acceleration, self.gravity, *slip_angle, *fx, *fy);
        Outcome { response, felt }
    }
}
