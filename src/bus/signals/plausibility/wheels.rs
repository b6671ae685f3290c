//! One wheel against the other three.

use super::{Contradiction, SLOW, TRACK};
use physics::{Faults, Quantity, Sample, Wheel};

/// A difference beyond any curve, tire radius (an emergency spare included) or normal slip: so much of
/// the speed …
const FAR: f64 = 0.2;
/// … and so much besides, rad/s.
const FAR_RAD_PER_S: f64 = 1.0;
/// The three others agree to so much of the speed …
const NEAR: f64 = 0.07;
/// … and so much besides, rad/s.
const NEAR_RAD_PER_S: f64 = 0.5;
/// A wheel may spin or lock as long as this before anything intervenes, s.
const SLIDING_S: f64 = 2.0;
/// A wheel too slow without any braking needs little patience …
const UNBRAKED_S: f64 = 0.3;
/// … if nobody has braked for so long: on ice a wheel takes long to turn again, s.
const RECOVERED_S: f64 = 2.0;

/// A wheel once found out is believed again after it has agreed with its side for so long, s …
const AGREED_S: f64 = 1.0;
/// … while the car moves, rad/s.
const MOVING_RAD_PER_S: f64 = 5.0;

/// Finds the wheel whose speed the other three contradict.
///
/// Slip explains a lot: a wheel that spins on ice, or locks. So a wheel counts as contradicting only
/// after two seconds, or at once when it is slow though nobody brakes or has braked.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WheelCheck {
    /// Time without braking, as far as the bus tells, s.
    unbraked_s: f64,
    /// Wheel, too slow rather than too fast, and for how long, s.
    suspect: Option<(Wheel, bool, f64)>,
    /// A wheel found out, and for how long it has agreed again, s.
    excluded: Option<(Wheel, f64)>,
}

impl WheelCheck {
    /// The wheel that is not believed, if there is one.
    pub(super) fn reason(&self) -> Option<Contradiction> {
        self.excluded.map(|(wheel, _)| Contradiction::Wheel { quantity: Quantity::wheel_speed(wheel) })
    }

    pub(super) fn check(&mut self, sample: &mut Sample, wheel_radius_m: f64) -> Faults {
        let elapsed_s = sample.elapsed_s.min(0.1);
        if let Some((wheel, agreed_s)) = self.excluded {
            let agrees = agrees_with_its_side(sample, wheel);
            // Without speeds nothing speaks for the wheel, and nothing more against it.
            let agreed_s = agrees.map_or(agreed_s, |agrees| if agrees { agreed_s + elapsed_s } else { 0.0 });
            if agreed_s < AGREED_S {
                self.excluded = Some((wheel, agreed_s));
                sample.clear(Quantity::wheel_speed(wheel));
                return Faults::WHEEL_MISMATCH;
            }
            *self = Self::default();
        }
        let braking = braking(sample);
        self.unbraked_s = if braking == Some(false) { self.unbraked_s + elapsed_s } else { 0.0 };
        let odd = odd_one(sample, wheel_radius_m);
        // However long it lasts, a braked wheel may be locked.
        let Some((wheel, slow)) = odd.filter(|(_, slow)| !(*slow && braking == Some(true))) else {
            self.suspect = None;
            return Faults::empty();
        };
        let before = match self.suspect {
            Some((suspect, was_slow, time)) if (suspect, was_slow) == (wheel, slow) => time,
            _ => 0.0,
        };
        let lasted = before + elapsed_s;
        self.suspect = Some((wheel, slow, lasted));
        let patience = if slow && self.unbraked_s > RECOVERED_S { UNBRAKED_S } else { SLIDING_S };
        if lasted < patience {
            return Faults::empty();
        }
        self.excluded = Some((wheel, 0.0));
        sample.clear(Quantity::wheel_speed(wheel));
        Faults::WHEEL_MISMATCH
    }
}

/// Does the wheel turn as the other one of its side does? `None` while standing or without speeds.
fn agrees_with_its_side(sample: &Sample, wheel: Wheel) -> Option<bool> {
    let speed = sample.get(Quantity::wheel_speed(wheel))?;
    let other = sample.get(Quantity::wheel_speed(wheel.same_side()))?;
    let near = NEAR * other.abs() + NEAR_RAD_PER_S;
    (other.abs() > MOVING_RAD_PER_S).then_some((speed - other).abs() < near)
}

/// The wheel that contradicts the others, and whether it is too slow.
fn odd_one(sample: &Sample, wheel_radius_m: f64) -> Option<(Wheel, bool)> {
    let speeds = sample.wheel_speeds()?;
    let [a, b, c, d] = speeds.map(f64::abs);
    // The higher of two pairs' lower ones and the lower of their higher ones are the two in the middle.
    let median = 0.5 * (a.min(b).max(c.min(d)) + a.max(b).min(c.max(d)));
    if median * wheel_radius_m < SLOW {
        return None;
    }
    let far = FAR * median + FAR_RAD_PER_S;
    let near = NEAR * median + NEAR_RAD_PER_S;
    let [fl, fr, rl, rr] = speeds;
    // One side's wheels must agree; it tells, with the yaw rate, how fast the other side's should be.
    let left_is_right = (fl - rl).abs() < near;
    let right_is_right = (fr - rr).abs() < near;
    if left_is_right == right_is_right {
        return None;
    }
    let spread = sample.get(Quantity::YawRate).unwrap_or(0.0) * TRACK / wheel_radius_m;
    let (expected, suspects) = if left_is_right {
        (0.5 * (fl + rl) + spread, [Wheel::Fr, Wheel::Rr])
    } else {
        (0.5 * (fr + rr) - spread, [Wheel::Fl, Wheel::Rl])
    };
    let deviation = |wheel: Wheel| speeds[wheel as usize] - expected;
    let [front, rear] = suspects;
    let (odd, other) =
        if deviation(front).abs() > deviation(rear).abs() { (front, rear) } else { (rear, front) };
    let certain = deviation(odd).abs() > far && deviation(other).abs() < near;
    certain.then_some((odd, deviation(odd) < 0.0))
}

/// Is anyone braking? `None` if the bus does not tell.
fn braking(sample: &Sample) -> Option<bool> {
    let told = [
        sample.get(Quantity::BrakePressure).map(|bar| bar > 3.0),
        sample.get(Quantity::BrakeTorque).map(|torque| torque > 50.0),
        sample.get(Quantity::BrakeActive).map(|active| active > 0.5),
        sample.get(Quantity::AbsActive).filter(|active| *active > 0.5).map(|_| true),
    ];
    told.into_iter().flatten().reduce(|a, b| a || b)
}
