//! What a receiver on the bus reads from the published frames, through the output DBC and nothing else.

use crate::can::Frame;
use crate::dbc::{Database, Message};
use crate::{Faults, Wheel};

/// One round of published frames. What was sent as not available is not a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Round {
    /// Time of its frames, s.
    pub time: f64,
    /// m/s.
    pub speed: f64,
    /// m/s.
    pub lateral_velocity: f64,
    /// rad.
    pub sideslip: f64,
    pub motion_valid: bool,
    pub slope: [f64; 4],
    pub slope_std: f64,
    pub slope_valid: bool,
    pub offset: [f64; 4],
    pub offset_std: f64,
    /// Front and rear, 1/rad.
    pub cornering: [f64; 2],
    pub cornering_std: [f64; 2],
    pub cornering_valid: bool,
    pub mu_max: f64,
    pub mu_low: f64,
    pub mu_high: f64,
    pub mu_used: f64,
    pub mu_valid: bool,
    /// As the value table calls it.
    pub mu_source: String,
    /// As the value table calls it.
    pub state: String,
    /// Longitudinal and lateral, %.
    pub excitation: [f64; 2],
    pub surface_changes: u32,
    pub faults: Faults,
}

impl Round {
    /// Nothing received yet.
    pub fn at(time: f64) -> Self {
        Self {
            time,
            speed: f64::NAN,
            lateral_velocity: f64::NAN,
            sideslip: f64::NAN,
            motion_valid: false,
            slope: [f64::NAN; 4],
            slope_std: f64::NAN,
            slope_valid: false,
            offset: [f64::NAN; 4],
            offset_std: f64::NAN,
            cornering: [f64::NAN; 2],
            cornering_std: [f64::NAN; 2],
            cornering_valid: false,
            mu_max: f64::NAN,
            mu_low: f64::NAN,
            mu_high: f64::NAN,
            mu_used: f64::NAN,
            mu_valid: false,
            mu_source: String::new(),
            state: String::new(),
            excitation: [f64::NAN; 2],
            surface_changes: 0,
            faults: Faults::empty(),
        }
    }

    /// Takes the signals of one frame.
    pub fn read(&mut self, frame: &Frame, database: &Database) {
        let Some(message) = database.message_with_id(frame.id) else { return };
        let get = |name: &str| number(message, frame, name);
        let flag = |name: &str| get(name) == 1.0;
        let wheels =
            |prefix: &str| Wheel::ALL.map(|wheel| get(&format!("{prefix}{}", wheel.name().to_uppercase())));
        match message.name.as_str() {
            "GRIP_FRICTION" => {
                self.mu_max = get("MuMax");
                self.mu_low = get("MuMaxLow");
                self.mu_high = get("MuMaxHigh");
                self.mu_used = get("MuUsed");
                self.mu_valid = flag("MuValid");
                self.mu_source = name(message, frame, "MuSource");
            }
            "GRIP_STIFFNESS_LONG" => {
                self.slope = wheels("Slope");
                self.slope_std = get("SlopeStd");
                self.slope_valid = flag("SlopeValid");
            }
            "GRIP_SLIP_OFFSET" => {
                self.offset = wheels("Offset");
                self.offset_std = get("OffsetStd");
            }
            "GRIP_STIFFNESS_LAT" => {
                self.cornering = [get("CorneringFront"), get("CorneringRear")];
                self.cornering_std = [get("CorneringStdFront"), get("CorneringStdRear")];
                self.cornering_valid = flag("CorneringValid");
            }
            "GRIP_MOTION" => {
                self.speed = get("Speed");
                self.lateral_velocity = get("LateralVelocity");
                self.sideslip = get("Sideslip");
                self.motion_valid = flag("MotionValid");
            }
            "GRIP_STATUS" => {
                self.state = name(message, frame, "State");
                self.excitation = [get("ExcitationLong"), get("ExcitationLat")];
                self.surface_changes = get("SurfaceChanges") as u32;
                self.faults = Faults::from_bits_truncate(get("Faults") as u16);
            }
            _ => {}
        }
    }
}

fn number(message: &Message, frame: &Frame, name: &str) -> f64 {
    let Some(signal) = message.signal(name) else { return f64::NAN };
    match signal.bits(frame.data()) {
        Some(bits) if signal.value_named("not_available") != Some(bits) => signal.physical(bits),
        _ => f64::NAN,
    }
}

fn name(message: &Message, frame: &Frame, name: &str) -> String {
    let signal = message.signal(name);
    let text = signal.and_then(|signal| signal.bits(frame.data()).and_then(|bits| signal.value_name(bits)));
    text.unwrap_or_default().to_owned()
}
