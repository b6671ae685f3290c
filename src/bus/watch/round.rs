//! What a receiver on the bus knows from the published frames, and from nothing else.

use crate::can::Frame;
use crate::signals::publish::Incoming;
use physics::estimates::{MuSource, State};
use physics::{Faults, Wheel};

/// What the published frames said last, SI. What was sent as not available is not a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Round {
    /// Time of its frames, s.
    pub time: f64,
    /// m/s.
    pub speed: f64,
    /// m/s, positive to the left.
    pub lateral_velocity: f64,
    /// rad, positive to the left.
    pub sideslip: f64,
    /// Front and rear, rad.
    pub slip_angle: [f64; 2],
    /// The lateral motion may be acted upon.
    pub motion_valid: bool,
    /// In the order of [`Wheel::ALL`].
    pub slope: [f64; 4],
    /// Of the least certain slope.
    pub slope_std: f64,
    /// The slopes may be acted upon.
    pub slope_valid: bool,
    /// s.
    pub slope_age: f64,
    /// Slip at zero force, in the order of [`Wheel::ALL`].
    pub offset: [f64; 4],
    /// Of the least certain offset.
    pub offset_std: f64,
    /// Front and rear, 1/rad.
    pub cornering: [f64; 2],
    /// Front and rear, 1/rad.
    pub cornering_std: [f64; 2],
    /// The cornering stiffnesses may be acted upon.
    pub cornering_valid: bool,
    /// s.
    pub cornering_age: f64,
    /// Friction available.
    pub mu_max: f64,
    /// Lower end of its 95 % interval.
    pub mu_low: f64,
    /// Upper end.
    pub mu_high: f64,
    /// Friction in use.
    pub mu_used: f64,
    /// The friction may be acted upon.
    pub mu_valid: bool,
    /// s.
    pub mu_age: f64,
    /// Where the friction comes from; none before it was told.
    pub mu_source: Option<MuSource>,
    /// What the service can do; none before it was told.
    pub state: Option<State>,
    /// Longitudinal and lateral, 0–1.
    pub excitation: [f64; 2],
    /// Since the service started.
    pub surface_changes: u32,
    /// Of the last status.
    pub faults: Faults,
    /// Frames lost before the service saw them.
    pub dropped_frames: u32,
}

impl Round {
    /// Nothing received yet.
    pub fn at(time: f64) -> Self {
        Self {
            time,
            speed: f64::NAN,
            lateral_velocity: f64::NAN,
            sideslip: f64::NAN,
            slip_angle: [f64::NAN; 2],
            motion_valid: false,
            slope: [f64::NAN; 4],
            slope_std: f64::NAN,
            slope_valid: false,
            slope_age: f64::NAN,
            offset: [f64::NAN; 4],
            offset_std: f64::NAN,
            cornering: [f64::NAN; 2],
            cornering_std: [f64::NAN; 2],
            cornering_valid: false,
            cornering_age: f64::NAN,
            mu_max: f64::NAN,
            mu_low: f64::NAN,
            mu_high: f64::NAN,
            mu_used: f64::NAN,
            mu_valid: false,
            mu_age: f64::NAN,
            mu_source: None,
            state: None,
            excitation: [f64::NAN; 2],
            surface_changes: 0,
            faults: Faults::empty(),
            dropped_frames: 0,
        }
    }

    /// Takes the signals of one frame of this message. Whether the frame is sound was asked before.
    pub fn read(&mut self, message: &Incoming, frame: &Frame) {
        let get = |name: &str| message.number(frame, name).unwrap_or(f64::NAN);
        let flag = |name: &str| get(name) == 1.0;
        let word = |name: &str| message.word(frame, name);
        let wheels =
            |prefix: &str| Wheel::ALL.map(|wheel| get(&format!("{prefix}{}", wheel.name().to_uppercase())));
        match message.name() {
            "GRIP_FRICTION" => {
                self.mu_max = get("MuMax");
                self.mu_low = get("MuMaxLow");
                self.mu_high = get("MuMaxHigh");
                self.mu_used = get("MuUsed");
                self.mu_valid = flag("MuValid");
                self.mu_age = get("MuAge");
                self.mu_source = word("MuSource").and_then(MuSource::named);
            }
            "GRIP_STIFFNESS_LONG" => {
                self.slope = wheels("Slope");
                self.slope_std = get("SlopeStd");
                self.slope_valid = flag("SlopeValid");
            }
            "GRIP_SLIP_OFFSET" => {
                self.offset = wheels("Offset");
                self.offset_std = get("OffsetStd");
                self.slope_age = get("SlopeAge");
            }
            "GRIP_STIFFNESS_LAT" => {
                self.cornering = [get("CorneringFront"), get("CorneringRear")];
                self.cornering_std = [get("CorneringStdFront"), get("CorneringStdRear")];
                self.cornering_valid = flag("CorneringValid");
                self.cornering_age = get("CorneringAge");
            }
            "GRIP_MOTION" => {
                self.speed = get("Speed");
                self.lateral_velocity = get("LateralVelocity");
                self.sideslip = get("Sideslip");
                self.slip_angle = [get("SlipAngleFront"), get("SlipAngleRear")];
                self.motion_valid = flag("MotionValid");
            }
            "GRIP_STATUS" => {
                self.state = word("State").and_then(State::named);
                self.excitation = [get("ExcitationLong"), get("ExcitationLat")];
                self.surface_changes = get("SurfaceChanges") as u32;
                self.faults |= Faults::from_bits_truncate(get("Faults") as u32);
                self.dropped_frames = get("DroppedFrames") as u32;
            }
            "GRIP_STATUS_2" => self.faults |= Faults::from_bits_truncate((get("Faults") as u32) << 16),
            _ => {}
        }
    }
}
