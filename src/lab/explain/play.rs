//! What is lost in a steering with play.

/// What of the steering wheel's angles, rad, one after the other, does not reach the wheels with a play of this width; nothing where
/// an angle is not known.
pub fn lost_in_play(angles: impl IntoIterator<Item = f64>, width: f64) -> Vec<f64> {
    let half = 0.5 * width;
    let mut behind = f64::NAN;
    let lost = |angle: f64| {
        if !angle.is_finite() {
            return 0.0;
        }
        behind = if behind.is_nan() { angle } else { behind.clamp(angle - half, angle + half) };
        angle - behind
    };
    angles.into_iter().map(lost).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// GIVEN a wheel that is turned, held, not told, and turned back THEN half of the play is lost to one side, then to the other.
    #[test]
    fn half_of_it_is_lost_to_either_side() {
        let lost = lost_in_play([0.0, 0.25, 1.0, 1.0, f64::NAN, 0.75, -1.0], 1.0);
        assert_eq!(lost, [0.0, 0.25, 0.5, 0.5, 0.0, 0.25, -0.5]);
        assert_eq!(lost_in_play([], 1.0), [0.0; 0]);
    }
}
