//! Do the sensors agree? Checks across quantities, on the uniform samples.
//!
//! Range and rate of single values are judged as they come (`limits.rs`). These checks look for sensors
//! that do not move although they must, and for sensors that contradict the others. A false alarm costs
//! more than a subtle fault missed, so they speak up only where physics leaves no other explanation.

mod motion;
mod stuck;
mod wheels;

use std::fmt;

use physics::{Faults, Micros, Quantity, Sample};

/// Below this speed wheel speeds and yaw rates of many cars are not what they seem, m/s.
const SLOW: f64 = 3.0;
/// Any passenger car's track width; only orders of magnitude are compared with it, m.
const TRACK: f64 = 1.5;

/// Which sensors contradict each other, and by what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contradiction {
    /// A sensor does not move although others show that it must.
    Stuck {
        /// Which.
        quantity: Quantity,
        /// Where it stands, SI.
        value: f64,
    },
    /// A wheel turns as none can beside the other three.
    Wheel {
        /// Its speed.
        quantity: Quantity,
    },
    /// Two witnesses of the car's turning move against each other.
    Motion {
        /// Who they are.
        between: [&'static str; 2],
        /// Of their movements; 1 where they agree.
        correlation: f64,
    },
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stuck { quantity, value } => {
                write!(f, "{} stands still at {value:.4}, and the others move", quantity.name())
            }
            Self::Wheel { quantity } => write!(f, "{} contradicts the other three", quantity.name()),
            Self::Motion { between: [one, other], correlation } => {
                write!(f, "{one} and {other} move against each other (correlation {correlation:.2})")
            }
        }
    }
}

/// Since when a quantity has had the very same value, and in how many frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Run {
    pub(super) since: Micros,
    pub(super) until: Micros,
    pub(super) frames: u32,
    pub(super) value: f64,
}

impl Run {
    /// Takes the next value.
    #[inline]
    pub(super) fn follow(&mut self, time: Micros, value: f64) {
        if self.frames > 0 && self.value.to_bits() == value.to_bits() {
            self.until = time;
            self.frames = self.frames.saturating_add(1);
        } else {
            *self = Self { since: time, until: time, frames: 1, value };
        }
    }
}

/// All checks across quantities.
#[derive(Clone, Debug)]
pub(super) struct CrossChecks {
    /// To be brought up to date before each check.
    pub(super) runs: [Run; Quantity::COUNT],
    wheel_radius_m: f64,
    stuck: stuck::StuckCheck,
    wheels: wheels::WheelCheck,
    motion: motion::MotionCheck,
}

impl CrossChecks {
    pub(super) fn new(wheel_radius_m: f64) -> Self {
        Self {
            runs: [Run::default(); Quantity::COUNT],
            wheel_radius_m,
            stuck: stuck::StuckCheck::default(),
            wheels: wheels::WheelCheck::default(),
            motion: motion::MotionCheck::default(),
        }
    }

    pub(super) fn forget(&mut self) {
        *self = Self::new(self.wheel_radius_m);
    }

    /// What the last check found, the first of it.
    pub(super) fn reason(&self) -> Option<Contradiction> {
        self.stuck.reason().or_else(|| self.wheels.reason()).or_else(|| self.motion.reason())
    }

    /// Checks a sample. Values that are certainly wrong are taken out of it.
    pub(super) fn check(&mut self, sample: &mut Sample) -> Faults {
        let kinematics = Kinematics::of(sample, self.wheel_radius_m);
        let mut faults = self.stuck.check(sample, &kinematics, &self.runs);
        faults |= self.wheels.check(sample, self.wheel_radius_m);
        faults | self.motion.check(sample, &kinematics)
    }
}

/// What the wheels alone say of the motion.
#[derive(Clone, Copy, Debug, Default)]
struct Kinematics {
    /// Mean of the four, m/s.
    speed: Option<f64>,
    /// From the difference of left and right, rad/s; `None` where the axles contradict each other.
    yaw_rate: Option<f64>,
}

impl Kinematics {
    fn of(sample: &Sample, wheel_radius_m: f64) -> Self {
        let Some([fl, fr, rl, rr]) = sample.wheel_speeds() else { return Self::default() };
        let speed = 0.25 * (fl + fr + rl + rr).abs() * wheel_radius_m;
        let (front, rear) = (fr - fl, rr - rl);
        // A spinning or locking wheel moves one axle's difference only.
        let agree = front * rear >= 0.0;
        let yaw_rate = 0.5 * (front + rear) * wheel_radius_m / TRACK;
        Self { speed: Some(speed), yaw_rate: agree.then_some(yaw_rate) }
    }
}
