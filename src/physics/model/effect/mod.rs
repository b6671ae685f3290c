//! Physics beyond the plain model, one file for each effect.
//!
//! An [`Effect`] acts on the car from wherever it can: it changes what driver and road do to the body
//! and tires ([`Effect::act`]), has states of its own ([`Effect::rates`]), and changes what the sensors
//! say of it all ([`Effect::sense`], [`Effect::undo`], [`Effect::delay`]). A `[[effect]]` table switches one on.
//! Simulation, explanation and `identify --method ordinary` take the same list of effects. The live estimators, whose
//! equations are those of a plain car, have it taken out of what they read, as far as that goes
//! ([`PlainReadings`](crate::estimate::PlainReadings)). The other methods of identification take only what the configuration
//! can put into other tables.
//!
//! Adding an effect is adding its file, with a [`Kind`] that says what it is, and its line in [`KINDS`].

mod accelerometer_position;
mod air_drag;
#[cfg(test)]
mod bench;
mod body_roll;
mod brake_imbalance;
mod brake_yaw_moment;
mod cg_shift;
mod channel;
mod channel_swap;
mod combined_slip;
mod config;
mod course;
mod crosswind;
mod disturbance;
mod downforce;
mod friction_change;
mod friction_split;
mod grip;
mod kind;
mod lag;
pub mod law;
mod limited_slip_differential;
mod list;
mod load;
mod load_transfer;
mod payload;
mod radius_growth;
mod rear_steer;
mod relaxation_length;
mod road_bank;
mod road_grade;
mod roll;
mod roll_steer;
mod rolling_resistance;
mod search;
mod sensor_bias;
mod sensor_delay;
mod sensor_drift;
mod sensor_scale;
mod sensor_sign;
mod spec;
pub mod steering_compliance;
mod steering_lag;
mod steering_ratio;
mod surface_stiffness;
mod surroundings;
mod table;
mod tire_radius;
mod tire_saturation;
mod wheel_alignment;

pub use channel::Channel;
pub use config::{EffectConfig, EffectError, column_names};
pub use course::{Course, Series};
pub use disturbance::Disturbance;
pub use kind::{Kind, Setting};
pub use list::EffectList;
pub use search::{Growth, Needs, SearchHints, Usual};
pub use spec::{OF_CHANNEL, Scale, Spec};
pub use surroundings::{Acting, Before, Felt, Now, Readings, Recorded};

use crate::Quantity;

/// Physics beyond the plain model, with its numbers.
pub trait Effect: Send + Sync + std::fmt::Debug {
    /// How many states of its own it has, at most [`MOST_STATES`].
    fn states(&self) -> usize {
        0
    }

    /// What each of its states is, as a column's name.
    fn state_names(&self) -> &'static [&'static str] {
        &[]
    }

    /// Where its states begin, the car rolling as it does.
    fn begin(&self, _now: &Now<'_>, states: &mut [f64]) {
        states.fill(0.0);
    }

    /// What it changes before the tires' forces are known.
    fn act(&self, _now: &Now<'_>, _states: &[f64], _on: &mut Acting) {}

    /// What it changes of the tires' slip angles, rad.
    fn slip_angles(&self, _now: &Now<'_>, _states: &[f64], _angles: &mut [f64; 4]) {}

    /// How its states change, per second.
    fn rates(&self, _now: &Now<'_>, _felt: &Felt, _states: &[f64], _rates: &mut [f64]) {}

    /// The fastest rate of its states at a speed, 1/s: who integrates them needs steps to match.
    fn fastest_rate(&self, vx: f64) -> f64 {
        self.lag_rate(vx).unwrap_or(0.0)
    }

    /// The rate at a speed, 1/s, if each of its states follows an input as a first-order lag: then who integrates them knows
    /// where they go.
    fn lag_rate(&self, _vx: f64) -> Option<f64> {
        None
    }

    /// Do its states follow the steering wheel? A driver may turn it by much within a step: where they go is then no matter of where
    /// they went.
    fn follows_steering(&self) -> bool {
        false
    }

    /// What the sensors make of the truth.
    fn sense(&self, _now: &Now<'_>, _felt: &Felt, _states: &[f64], _readings: &mut Readings) {}

    /// From what was recorded of steering wheel, torque and brakes to what was: the inverse of
    /// [`Effect::sense`] for the inputs.
    fn undo(&self, _t: f64, _recorded: &mut Recorded) {}

    /// A sensor that is late, and how much, s.
    fn delay(&self) -> Option<(Quantity, f64)> {
        None
    }
}

/// States that one effect may have.
pub const MOST_STATES: usize = 4;

/// All effects, in the order in which they act where they meet: the steering from the driver to the
/// tires, the loads before what depends on them, the sensors last ([`Effect::undo`] goes backwards).
pub static KINDS: &[&Kind] = &[
    &steering_lag::KIND,
    &steering_ratio::KIND,
    &rear_steer::KIND,
    &payload::KIND,
    &cg_shift::KIND,
    &air_drag::KIND,
    &load_transfer::KIND,
    &downforce::KIND,
    &rolling_resistance::KIND,
    &tire_radius::KIND,
    &radius_growth::KIND,
    &tire_saturation::KIND,
    &friction_change::KIND,
    &friction_split::KIND,
    &surface_stiffness::KIND,
    &combined_slip::KIND,
    &limited_slip_differential::KIND,
    &relaxation_length::KIND,
    &roll_steer::KIND,
    &wheel_alignment::KIND,
    &steering_compliance::KIND,
    &road_bank::KIND,
    &road_grade::KIND,
    &crosswind::KIND,
    &brake_yaw_moment::KIND,
    &brake_imbalance::KIND,
    &accelerometer_position::KIND,
    &body_roll::KIND,
    &sensor_delay::KIND,
    &sensor_scale::KIND,
    &sensor_bias::KIND,
    &sensor_drift::KIND,
    &sensor_sign::KIND,
    &channel_swap::KIND,
];

/// The effect of this name: one of the library, or a [`law`].
pub fn named(name: &str) -> Option<&'static Kind> {
    KINDS.iter().copied().chain([&law::KIND]).find(|kind| kind.name == name)
}

#[cfg(test)]
mod tests {
    use super::bench::{Bench, made};
    use super::*;

    #[test]
    fn every_effect_of_the_contract_is_there_once() {
        let mut names: Vec<_> = KINDS.iter().map(|kind| kind.name).collect();
        names.sort_unstable();
        let contract = "accelerometer_position air_drag body_roll brake_imbalance brake_yaw_moment cg_shift channel_swap \
                        combined_slip crosswind downforce friction_change friction_split \
                        limited_slip_differential load_transfer payload radius_growth rear_steer \
                        relaxation_length road_bank road_grade roll_steer rolling_resistance sensor_bias \
                        sensor_delay sensor_drift sensor_scale sensor_sign steering_compliance steering_lag \
                        steering_ratio surface_stiffness tire_radius tire_saturation wheel_alignment";
        assert_eq!(names, contract.split_whitespace().collect::<Vec<_>>());
    }

    #[test]
    fn what_is_known_of_each_makes_sense() {
        for kind in KINDS {
            let has_main = kind.parameters.iter().any(|spec| spec.is_main);
            assert!(has_main || kind.course.is_some() || kind.is_all_or_nothing(), "{}", kind.name);
            let patch = kind.course.filter(|course| course.sign != 0.0);
            assert_eq!(patch.is_some(), kind.course.is_some_and(|course| !course.settings.is_empty()));
            for setting in patch.map_or(&[][..], |patch| patch.settings) {
                assert_eq!(setting.len(), kind.parameters.len(), "{}", kind.name);
            }
            for spec in kind.parameters {
                let (low, high) = spec.bounds;
                assert!(low <= spec.mean && spec.mean <= high, "{} {}", kind.name, spec.name);
                assert!(spec.step > 0.0 && spec.step <= 0.4 * spec.std, "{} {}", kind.name, spec.name);
                assert!(spec.mean + spec.std <= high, "{} {}", kind.name, spec.name);
                // What is usual is said of the numbers as they are.
                let is_plain = spec.scale == Scale::Linear && spec.mean == 0.0;
                assert!(is_plain || kind.search.usual.is_none() || !spec.is_main, "{}", kind.name);
            }
        }
    }

    /// Where the main numbers are at their mean and the course is zero, the car is the plain one, in
    /// whatever way it drives.
    #[test]
    fn at_its_mean_every_effect_vanishes() {
        for kind in KINDS.iter().filter(|kind| !kind.is_all_or_nothing()) {
            let mut bench = Bench::driving(23.0);
            bench.now.t = 12.0;
            (bench.now.ax, bench.now.ay, bench.now.front_force) = (-2.0, 4.0, 3000.0);
            (bench.now.velocity.vy, bench.now.velocity.yaw_rate) = (-0.3, 0.2);
            bench.now.steering_wheel = 0.05;
            let values: Vec<_> = kind.parameters.iter().map(|spec| spec.value(spec.mean)).collect();
            let channel = kind.channels.first().copied();
            let effect = made(kind, &values, channel, &Course::None);
            assert!(effect.states() <= MOST_STATES);
            let states = bench.begun(&*effect);
            assert_eq!(bench.acted(&*effect, &states), bench.plain(), "{}", kind.name);
            let mut angles = [0.01, 0.02, 0.03, 0.04];
            effect.slip_angles(&bench.now, &states, &mut angles);
            assert_eq!(angles, [0.01, 0.02, 0.03, 0.04], "{}", kind.name);
            let mut readings = [1.5; Quantity::COUNT];
            effect.sense(&bench.now, &Felt::default(), &states, &mut readings);
            assert_eq!(readings, [1.5; Quantity::COUNT], "{}", kind.name);
            let mut recorded = Recorded { steering_wheel: 1.0, drive_torque: 2.0, brake_pressure: 3.0 };
            let before = recorded;
            effect.undo(12.0, &mut recorded);
            assert_eq!(recorded, before, "{}", kind.name);
            assert!(effect.delay().is_none_or(|(_, delay)| delay == 0.0));
        }
    }
}
