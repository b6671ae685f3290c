//! For how long sensors have contradicted each other, and what of the estimates that has spoiled.

/// Tuned: `spoils_s` with `one_channel` and, for the steering, with `a_foreign_steering_tells_no_friction`, `forgotten_s`
/// with that.
struct Tuning {
    /// Sensors that were doubted for so long have spoiled what was learned of the tires, s.
    spoils_s: f64,
    /// A steering that has agreed for so long is trusted again, however long it did not, s.
    forgotten_s: f64,
}

const TUNING: Tuning = Tuning { spoils_s: 4.0, forgotten_s: 30.0 };

/// What contradicts something at the moment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubts {
    /// Any sensor that the motion is told by.
    pub any: bool,
    /// The steering: nobody knows how the wheels stand.
    pub steering: bool,
}

/// For how long sensors have been doubted.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubted {
    now: Doubts,
    /// Any of them, s.
    any_s: f64,
    /// The steering, less the driving in which it has agreed since, s.
    steering_s: f64,
}

impl Doubted {
    /// Goes on by some time, s; at standstill nothing agrees. Returns whether doubts have ended that spoiled what was learned.
    pub fn step(&mut self, now: Doubts, drives: bool, elapsed_s: f64) -> bool {
        self.now = now;
        let by = match (now.steering, drives) {
            (true, _) => elapsed_s,
            (false, true) => -elapsed_s,
            (false, false) => 0.0,
        };
        self.steering_s = (self.steering_s + by).clamp(0.0, TUNING.forgotten_s);
        if now.any {
            self.any_s += elapsed_s;
            return false;
        }
        std::mem::take(&mut self.any_s) > TUNING.spoils_s
    }

    /// Is what tires say of the road spoiled? At once where nobody knows how the wheels stand, and after a long doubt of the
    /// steering until it has agreed for about as long; otherwise after a while, but not where both axles slide, of which
    /// sensors tell differently.
    pub fn has_spoiled_the_curve(&self, both_slide: bool) -> bool {
        let lasts = self.any_s >= TUNING.spoils_s && !both_slide;
        lasts || self.now.steering || self.steering_s > TUNING.spoils_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEERING: Doubts = Doubts { any: true, steering: true };
    const OTHERS: Doubts = Doubts { any: true, steering: false };
    const NONE: Doubts = Doubts { any: false, steering: false };

    fn after(times: &[(Doubts, bool, u32)]) -> Doubted {
        let mut doubted = Doubted::default();
        for (doubts, drives, seconds) in times {
            (0..10 * seconds).for_each(|_| {
                doubted.step(*doubts, *drives, 0.1);
            });
        }
        doubted
    }

    /// GIVEN a steering that was doubted for ten seconds THEN the curve is spoiled until it has agreed for most of that, driving:
    /// standing still it agrees with nothing.
    #[test]
    fn a_steering_has_to_agree_about_as_long() {
        let spoiled = |times: &[(Doubts, bool, u32)]| after(times).has_spoiled_the_curve(false);
        assert!(spoiled(&[(STEERING, true, 1)]));
        assert!(!spoiled(&[(STEERING, true, 3), (NONE, true, 1)]));
        assert!(spoiled(&[(STEERING, true, 10), (NONE, true, 5)]));
        assert!(!spoiled(&[(STEERING, true, 10), (NONE, true, 7)]));
        assert!(spoiled(&[(STEERING, true, 10), (NONE, false, 60)]));
        assert!(!spoiled(&[(STEERING, true, 300), (NONE, true, 27)]));
    }

    /// GIVEN other sensors that are doubted THEN the curve is spoiled after some seconds, not where both axles slide; and it is
    /// said once when doubts end that were long enough.
    #[test]
    fn other_sensors_spoil_it_after_a_while() {
        let mut long = after(&[(OTHERS, true, 6)]);
        assert!(long.has_spoiled_the_curve(false) && !long.has_spoiled_the_curve(true));
        assert!(!after(&[(OTHERS, true, 3)]).has_spoiled_the_curve(false));
        assert!(long.step(NONE, true, 0.1) && !long.step(NONE, true, 0.1));
        assert!(!after(&[(OTHERS, true, 3)]).step(NONE, true, 0.1));
    }
}
