//! Everything that can be hidden in a recording: physics the plain model leaves out, and faults of sensors.
//! A field at its default changes nothing.

use super::road::Road;

/// Channels of a recording: wheel speeds FL FR RL RR, yaw rate, lateral and longitudinal acceleration, steering wheel
/// angle, drive torque, brake pressure.
pub const CHANNELS: usize = 10;

/// One smooth bump: amplitude · sin²(π (t − start)/(end − start)).
#[derive(Clone, Copy, Debug)]
pub struct Bump {
    pub start: f64,
    pub end: f64,
    pub amplitude: f64,
}

/// A sum of bumps.
pub type Series = Vec<Bump>;

/// The series' value at a time.
pub fn at(series: &[Bump], t: f64) -> f64 {
    series
        .iter()
        .filter(|b| t > b.start && t < b.end)
        .map(|b| b.amplitude * (std::f64::consts::PI * (t - b.start) / (b.end - b.start)).sin().powi(2))
        .sum()
}

/// A stretch of road: the front axle meets it at `start`, the rear one a wheelbase later.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub start: f64,
    pub end: f64,
    pub left: f64,
    pub right: f64,
}

/// Load transfer without suspension dynamics (Milliken 1995, ch. 18; Guiggiani 2018, ch. 3).
#[derive(Clone, Copy, Debug)]
pub struct LoadTransfer {
    /// Height of the centre of gravity, m.
    pub height: f64,
    /// The front axle's share of the lateral transfer.
    pub front_share: f64,
    /// Cornering stiffness against load: sin(2 atan(λ/p)) of Pacejka 2012 eq. 4.E25, λ = load/static load.
    pub peak_load: f64,
}

/// What one sensor channel does wrong.
#[derive(Clone, Debug, Default)]
pub struct SensorFault {
    pub delay: f64,
    /// Relative error of its scale.
    pub scale: f64,
    pub negative: bool,
    /// Extra offset from a time on.
    pub step: Option<(f64, f64)>,
    pub drift: Vec<(f64, f64, f64)>,
    /// Clips beyond this magnitude.
    pub clip: Option<f64>,
}

impl SensorFault {
    /// The sum of slow sines (amplitude, angular frequency, phase) that its offset wanders by.
    pub fn wander(&self, t: f64) -> f64 {
        self.drift.iter().map(|(amplitude, w, phase)| amplitude * (w * t + phase).sin()).sum()
    }
}

#[derive(Clone, Debug, Default)]
pub struct Hidden {
    /// What disturbs every drive, and is not to be found.
    pub road: Option<Road>,
    // Body and tires.
    pub load_transfer: Option<LoadTransfer>,
    /// Roll angle per lateral acceleration seen by the accelerometer as gravity, rad/(m/s²).
    pub roll_leak: f64,
    /// Steer of the front wheels per roll angle, rad/rad, and the roll gain it works with.
    pub roll_steer: f64,
    pub roll_gain: f64,
    pub bank: Series,
    pub grade: Series,
    /// kg/m
    pub drag: f64,
    pub rolling: f64,
    pub relaxation: f64,
    pub steering_lag: f64,
    /// rad per N m of aligning moment of the front axle, with a trail of 0.05 m.
    pub compliance: f64,
    /// ratio = ratio0 (1 − c swa²)
    pub ratio_curvature: f64,
    /// Rear angle per front angle at standstill, to the other side, and the speed at which it passes through none, m/s.
    pub rear_steer: Option<(f64, f64)>,
    pub radius_error: [f64; 4],
    pub radius_growth: f64,
    /// (time, rearward shift)
    pub cg_shift: Option<(f64, f64)>,
    pub payload: f64,
    /// Friction (left, right) on patches.
    pub friction_patches: Vec<Patch>,
    /// A tire that saturates though the user calls it linear.
    pub saturation: Option<f64>,
    /// (factor, friction it is measured by)
    pub ellipse: Option<(f64, f64)>,
    /// Factor of all stiffnesses on patches.
    pub stiffness_patches: Vec<Patch>,
    /// Torque put on one front wheel by the brakes, unseen in the pressure, N m: (wheel, series).
    pub esp: Vec<(usize, Bump)>,
    /// Torque moved between the wheels of the driven axle, N m, half of it to the right, half from the left.
    pub vectoring: Series,
    /// Of each axle: the left brake gives 1 + e of what it shall, the right one 1 − e.
    pub brake_imbalance: [f64; 2],
    pub wind: Series,
    /// Where the wind acts, m forward of the centre of gravity.
    pub wind_at: f64,
    /// Toe of each wheel, rad, as a steer angle.
    pub toe: [f64; 4],
    // Sensors.
    pub faults: [SensorFault; CHANNELS],
    pub swap: Option<(usize, usize)>,
    /// Accelerometer forward of the centre of gravity, m.
    pub accelerometer_at: f64,
    // What no library has.
    pub freeplay: f64,
    pub slosh: f64,
    pub shimmy: f64,
    pub judder: f64,
    pub lock: f64,
    pub torque_limit: Option<f64>,
}
