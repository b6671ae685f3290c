//! The measurement chain: what of the truth reaches the bus, and when.

use super::bus::Timing;
use super::car::G;
use super::dice::Dice;
use super::hidden::{CHANNELS, Hidden};
use super::physics::Moment;
use super::road::Course;

/// White noise of each channel, SI: wheels, yaw rate, accelerations, steering, drive torque, brake pressure.
pub const NOISE: [f64; CHANNELS] = [0.05, 0.05, 0.05, 0.05, 0.003_141_6, 0.07, 0.07, 0.000_872_7, 8.0, 0.0];
const TEETH: usize = 48;
/// The wheel speed is an average over this time, s, and leaves the unit a little later.
const GATE: f64 = 0.010;
const GATE_LATE: f64 = 0.001;

/// What is ordinary and constant about the sensors of one car.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    /// Offsets of each channel.
    pub offset: [f64; CHANNELS],
    /// Angle errors of the teeth of each wheel, rad; empty for ideal wheels.
    pub teeth: [Vec<f64>; 4],
    /// What each channel shows beside the drive and its white noise.
    pub colour: [Course; CHANNELS],
    pub timing: Timing,
}

impl Chain {
    pub fn random(dice: &mut Dice) -> Self {
        let mut offset = [0.0; CHANNELS];
        offset[4] = 0.005 * dice.normal();
        offset[5] = 0.05 * dice.normal();
        offset[6] = 0.05 * dice.normal();
        offset[7] = 0.015 * dice.normal();
        // Pitch errors of a tenth of a per cent: what the practice recordings show (their third differences leave
        // no room for more beside the white noise).
        let pitch = std::f64::consts::TAU / TEETH as f64;
        let teeth = std::array::from_fn(|_| {
            (0..TEETH).map(|_| dice.between(0.0004, 0.0012) * pitch * dice.normal()).collect()
        });
        Chain { offset, teeth, ..Chain::default() }
    }

    fn tooth_error(&self, wheel: usize, angle: f64) -> f64 {
        let teeth = &self.teeth[wheel];
        if teeth.is_empty() {
            return 0.0;
        }
        let x = angle / std::f64::consts::TAU * TEETH as f64;
        let (i, f) = (x.floor(), x - x.floor());
        let i = i.rem_euclid(TEETH as f64) as usize % TEETH;
        teeth[i] * (1.0 - f) + teeth[(i + 1) % TEETH] * f
    }

    /// What a channel shows of a drive at a time: everything but noise and quantisation.
    /// The moments are `step` seconds apart.
    pub fn shows(&self, moments: &[Moment], step: f64, hidden: &Hidden, channel: usize, t: f64) -> f64 {
        let source = match hidden.swap {
            Some((i, j)) if channel == i => j,
            Some((i, j)) if channel == j => i,
            _ => channel,
        };
        let fault = &hidden.faults[channel];
        let seen = t - fault.delay;
        let ideal = match source {
            0..=3 => {
                let turned = |t: f64| {
                    let angle = if t < 0.0 {
                        moments[0].omega[source] * t
                    } else {
                        interpolate(moments, step, t, |m| m.angle[source])
                    };
                    angle + self.tooth_error(source, angle)
                };
                (turned(seen - GATE_LATE) - turned(seen - GATE_LATE - GATE)) / GATE
            }
            4 => interpolate(moments, step, seen, |m| m.r),
            5 => interpolate(moments, step, seen, |m| {
                let lateral = m.force[1] + hidden.accelerometer_at * m.r_dot;
                if hidden.roll_leak == 0.0 { lateral } else { lateral * m.roll.cos() + G * m.roll.sin() }
            }),
            6 => interpolate(moments, step, seen, |m| m.force[0] - hidden.accelerometer_at * m.r * m.r),
            7 => interpolate(moments, step, seen, |m| m.input.steering),
            8 => interpolate(moments, step, seen, |m| m.input.torque),
            _ => interpolate(moments, step, seen, |m| m.input.pressure),
        };
        let mut value = ideal * (1.0 + fault.scale) + self.offset[channel] + fault.wander(t);
        if let Some((when, step)) = fault.step
            && t >= when
        {
            value += step;
        }
        if let Some(limit) = fault.clip {
            value = value.clamp(-limit, limit);
        }
        if fault.negative { -value } else { value }
    }
}

fn interpolate(moments: &[Moment], step: f64, t: f64, value: impl Fn(&Moment) -> f64) -> f64 {
    let x = (t / step).max(0.0);
    let i = (x as usize).min(moments.len() - 2);
    let f = (x - i as f64).min(1.0);
    value(&moments[i]) * (1.0 - f) + value(&moments[i + 1]) * f
}
