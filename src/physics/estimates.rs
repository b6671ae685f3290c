//! The hinge between the physics and the bus: everything the estimators know at one instant.

use crate::{Faults, Micros};

/// A stiffness whose standard deviation is a larger share of it is not told by a drive: two surfaces, or two tires, differ by as
/// much. The service, a replay, identify and explain all hold to it.
pub const TOLD_RELATIVE_STD: f64 = 0.15;

/// A number with its standard deviation and the age of the information in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Best value.
    pub value: f64,
    /// Standard deviation, in the value's unit.
    pub std: f64,
    /// Seconds since the last measurement that told something about it.
    pub age_s: f64,
}

impl Estimate {
    /// The 95 % interval of a normal distribution.
    pub fn ci95(&self) -> (f64, f64) {
        (self.value - 1.96 * self.std, self.value + 1.96 * self.std)
    }
}

/// What the service as a whole can do at the moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// No sample yet.
    #[default]
    Starting,
    /// All required quantities are there.
    Running,
    /// Some required quantity is missing or doubtful.
    Degraded,
    /// Nothing usable comes from the bus.
    NoInput,
}

impl State {
    /// All, each in the place of its number on the bus.
    pub const ALL: [Self; 4] = [Self::Starting, Self::Running, Self::Degraded, Self::NoInput];

    /// As in the DBC's value table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::Running => "running",
            Self::Degraded => "degraded",
            Self::NoInput => "no_input",
        }
    }

    /// The one that the value table calls so.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }
}

/// Where the published friction comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MuSource {
    /// Nothing is known.
    #[default]
    None,
    /// Only that this much friction has just been used.
    LowerBound,
    /// Mapped from the slip slope.
    SlopeMap,
    /// The brush model's curvature.
    Brush,
    /// The tires' curve sideways: forces and slip angles of both axles.
    Joint,
    /// Deceleration during ABS braking.
    Abs,
    /// The driven wheels were at their limit, slip grew and the force did not; or the car skids.
    Limit,
}

impl MuSource {
    /// All, each in the place of its number on the bus.
    pub const ALL: [Self; 7] =
        [Self::None, Self::LowerBound, Self::SlopeMap, Self::Brush, Self::Joint, Self::Abs, Self::Limit];

    /// The one that the value table calls so.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|source| source.name() == name)
    }

    /// As in the CSV and in the DBC's value table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::LowerBound => "lower_bound",
            Self::SlopeMap => "slope_map",
            Self::Brush => "brush",
            Self::Joint => "joint",
            Self::Abs => "abs",
            Self::Limit => "limit",
        }
    }
}

/// Friction: what is used, what is available, and what is not known about it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Friction {
    /// Best value of the available friction mu_max.
    pub max: Option<f64>,
    /// Lower end of the 95 % interval.
    pub low: Option<f64>,
    /// Upper end of the 95 % interval; absent when nothing bounds it from above.
    pub high: Option<f64>,
    /// Friction in use, of the most loaded direction.
    pub used: Option<f64>,
    /// Where `max` comes from.
    pub source: MuSource,
    /// `max` may be acted upon.
    pub valid: bool,
    /// Seconds since friction was last used enough to tell.
    pub age_s: Option<f64>,
    /// Brush regression (thesis 8.1).
    pub brush: Option<f64>,
    /// Its standard deviation, if the tire were a brush.
    pub brush_std: Option<f64>,
    /// Last ABS braking (thesis 6.1).
    pub abs: Option<f64>,
    /// Mapped from the slope (thesis 6.3).
    pub map: Option<f64>,
    /// Its 95 % interval.
    pub map_interval: Option<(f64, f64)>,
}

/// Motion in the road plane. Slip angles are positive when they give a positive lateral force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Speed of the centre of gravity, m/s.
    pub speed: Option<f64>,
    /// Lateral velocity at the centre of gravity, m/s, positive to the left.
    pub lateral_velocity: Option<f64>,
    /// Sideslip atan(v_y / v_x), rad, positive to the left.
    pub sideslip: Option<f64>,
    /// Front slip angle, rad.
    pub slip_angle_front: Option<f64>,
    /// Rear slip angle, rad.
    pub slip_angle_rear: Option<f64>,
    /// The lateral motion may be acted upon.
    pub valid: bool,
}

/// Lateral velocity, m/s, by each of the ways of thesis 5.2.2 and by the joint filter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LateralVelocities {
    /// Taken as zero.
    pub zero: Option<f64>,
    /// Method 1: integrated accelerometer.
    pub integration: Option<f64>,
    /// Method 2: kinematic observer.
    pub kinematic: Option<f64>,
    /// Method 3: bicycle model.
    pub bicycle: Option<f64>,
    /// Joint estimation with the stiffness.
    pub joint: Option<f64>,
}

/// What the thesis's estimators say: kept beside what is published, to be compared with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThesisEstimates {
    /// Each way to the lateral velocity.
    pub lateral_velocities: LateralVelocities,
    /// Cornering stiffness by the regression of thesis (5.20), front and rear, 1/rad.
    pub cornering_regression: [Option<Estimate>; 2],
    /// Cornering stiffness C_y = C_F = C_R by the EKF of thesis (5.21), normalized, 1/rad.
    pub cornering_ekf: Option<Estimate>,
    /// Friction by the Dahl EKF on one wheel (thesis 8.2).
    pub friction_dahl: Option<f64>,
}

/// Offsets of the sensors the lateral motion stands on, as the joint filter learned them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorOffsets {
    /// Of the road wheel angle, rad.
    pub road_angle: Option<Estimate>,
    /// Of the lateral acceleration (mounting and road bank), m/s².
    pub lateral_acceleration: Option<Estimate>,
    /// Of the yaw rate, rad/s.
    pub yaw_rate: Option<Estimate>,
}

/// Everything known at one instant. Absent means: not available, not zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimates {
    /// The instant of the sample they are computed from.
    pub time: Micros,
    /// What the service can do.
    pub state: State,
    /// Motion as published.
    pub motion: Motion,
    /// Longitudinal slip slope per wheel: force per slip, normalized by the static wheel load.
    pub slope: [Option<Estimate>; 4],
    /// Slip at zero force per wheel (tire radius against the reference wheel's).
    pub slip_offset: [Option<Estimate>; 4],
    /// The slopes may be acted upon.
    pub slope_valid: bool,
    /// Cornering stiffness front and rear, normalized by axle load, 1/rad, by the joint filter.
    pub cornering: [Option<Estimate>; 2],
    /// The cornering stiffnesses may be acted upon.
    pub cornering_valid: bool,
    /// Sensor offsets.
    pub offsets: SensorOffsets,
    /// How rough the road is: by how much the wheels' rims scatter about their rolling, m/s.
    pub roughness: Option<Estimate>,
    /// Friction.
    pub friction: Friction,
    /// The thesis's estimators, where somebody asked for them; no frame is made of these.
    pub thesis: ThesisEstimates,
    /// How well the longitudinal use of the tires tells the slope, 0–1.
    pub excitation_long: f64,
    /// How well the lateral use of the tires tells the cornering stiffness, 0–1.
    pub excitation_lat: f64,
    /// Surface changes noticed since start.
    pub surface_changes: u32,
    /// What is wrong.
    pub faults: Faults,
    /// Frames lost before gripd could see them, since start.
    pub dropped_frames: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names_on_the_bus_are_the_places_and_their_own() {
        for (place, source) in MuSource::ALL.into_iter().enumerate() {
            assert_eq!((source as usize, MuSource::named(source.name())), (place, Some(source)));
        }
        for (place, state) in State::ALL.into_iter().enumerate() {
            assert_eq!((state as usize, State::named(state.name())), (place, Some(state)));
        }
        assert_eq!((MuSource::named(""), State::named("")), (None, None));
    }
}
