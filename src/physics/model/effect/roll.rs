//! The body leaning out of a turn: one mass on springs and dampers.

use super::{Scale, Spec};

/// Natural frequency of the roll: of cars 1 to 2 Hz (Gillespie 1992, ch. 6), of a laden van hardly below 0.8.
pub(super) const FREQUENCY: Spec = Spec {
    name: "roll_frequency_rad_per_s",
    words: "roll frequency",
    unit: "rad/s",
    scale: Scale::Linear,
    mean: 9.0,
    std: 2.5,
    bounds: (5.0, 25.0),
    step: 0.5,
    model_error: Spec::MODEL_ERROR,
    is_main: false,
};

/// Damping of the roll, as a share of the critical one.
pub(super) const DAMPING: Spec = Spec {
    name: "roll_damping",
    words: "roll damping",
    unit: "1",
    scale: Scale::Linear,
    mean: 0.3,
    std: 0.1,
    bounds: (0.05, 1.5),
    step: 0.03,
    model_error: Spec::MODEL_ERROR,
    is_main: false,
};

/// φ̈ = ω² (k a_y − φ) − 2 ζ ω φ̇; φ positive for leaning out of a left turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Roll {
    /// k, rad/(m/s²).
    pub(super) gain: f64,
    /// ω, rad/s.
    pub(super) frequency: f64,
    /// ζ.
    pub(super) damping: f64,
}

impl Roll {
    /// Angle, rad, and its rate: the lean of a steady turn.
    pub(super) fn begin(&self, ay: f64, states: &mut [f64]) {
        states.fill(0.0);
        if let Some(angle) = states.first_mut() {
            *angle = self.gain * ay;
        }
    }

    /// How both change.
    pub(super) fn rates(&self, ay: f64, states: &[f64], rates: &mut [f64]) {
        let ([angle, speed], [angle_rate, speed_rate]) = (states, rates) else { return };
        *angle_rate = *speed;
        *speed_rate = self.frequency * self.frequency * (self.gain * ay - angle)
            - 2.0 * self.damping * self.frequency * speed;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_settles_at_the_gain_and_overshoots_as_its_damping_says() {
        let roll = Roll { gain: 0.006, frequency: 9.0, damping: 0.3 };
        let (mut states, mut rates) = ([0.0; 2], [0.0; 2]);
        let h = 1e-4;
        let mut largest = 0.0f64;
        for _ in 0..100_000 {
            roll.rates(5.0, &states, &mut rates);
            states[1] += h * rates[1];
            states[0] += h * states[1];
            largest = largest.max(states[0]);
        }
        assert!((states[0] - 0.03).abs() < 1e-6 && states[1].abs() < 1e-6);
        let overshoot = (-std::f64::consts::PI * 0.3 / (1.0f64 - 0.09).sqrt()).exp();
        assert!((largest / 0.03 - 1.0 - overshoot).abs() < 1e-3, "{largest}");
        let mut steady = [1.0; 2];
        roll.begin(5.0, &mut steady);
        assert_eq!(steady, [0.03, 0.0]);
    }
}
