//! When a drive was nearly steady.

/// What was measured at one instant. Not-a-number: not available.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// When, s.
    pub t: f64,
    /// Speed, m/s.
    pub speed: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Lateral acceleration, m/s².
    pub lateral_acceleration: f64,
    /// Steering wheel angle over the steering ratio, rad.
    pub road_angle: f64,
}

/// The means of a second of nearly steady driving.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Its middle, s.
    pub t: f64,
    /// Lateral acceleration, m/s².
    pub lateral_acceleration: f64,
    /// Steering wheel angle over the steering ratio, rad.
    pub road_angle: f64,
    /// The curve's geometry: yaw rate / speed, 1/m.
    pub curvature: f64,
}

/// What counts as nearly steady. A car answers to steering within 0.2 s or so; what changes by less than this in a second
/// is then off by less than the sensors' own noise (0.07 m/s², 0.1 °).
struct Tuning {
    /// Length of a moment, s.
    length_s: f64,
    /// Slowest driving, m/s: below it curves are tight, and the geometry is all there is.
    least_speed: f64,
    /// Between the first and the second half, per s.
    most_speed_change: f64,
    most_lateral_change: f64,
    most_angle_change: f64,
}

const TUNING: Tuning = Tuning {
    length_s: 1.0,
    least_speed: 6.0,
    most_speed_change: 1.0,
    most_lateral_change: 0.6,
    most_angle_change: 0.0105,
};

/// All nearly steady moments of a drive, in order.
pub fn moments(drive: impl Iterator<Item = Instant>) -> Vec<Moment> {
    let mut found = Vec::new();
    let mut part: Vec<Instant> = Vec::new();
    for now in drive {
        let is_whole = [now.speed, now.yaw_rate, now.lateral_acceleration, now.road_angle]
            .iter()
            .all(|value| value.is_finite());
        // A pause, or a value that is missing: what was collected is too short.
        if !is_whole || part.last().is_some_and(|last| !(0.0..=0.2).contains(&(now.t - last.t))) {
            part.clear();
        }
        if !is_whole {
            continue;
        }
        if part.first().is_some_and(|first| now.t - first.t >= TUNING.length_s) {
            found.extend(steady(&part));
            part.clear();
        }
        part.push(now);
    }
    found
}

/// The part as a moment, if it was nearly steady.
fn steady(part: &[Instant]) -> Option<Moment> {
    let (early, late) = part.split_at(part.len() / 2);
    let (early, late, whole) = (mean(early)?, mean(late)?, mean(part)?);
    // The halves' middles are half the length apart.
    let changes =
        |of: fn(&Instant) -> f64, most: f64| (of(&late) - of(&early)).abs() > most * TUNING.length_s / 2.0;
    let is_steady = whole.speed >= TUNING.least_speed
        && !changes(|it| it.speed, TUNING.most_speed_change)
        && !changes(|it| it.lateral_acceleration, TUNING.most_lateral_change)
        && !changes(|it| it.road_angle, TUNING.most_angle_change);
    is_steady.then(|| Moment {
        t: whole.t,
        lateral_acceleration: whole.lateral_acceleration,
        road_angle: whole.road_angle,
        curvature: whole.yaw_rate / whole.speed,
    })
}

fn mean(part: &[Instant]) -> Option<Instant> {
    let of = |of: fn(&Instant) -> f64| part.iter().map(of).sum::<f64>() / part.len() as f64;
    (!part.is_empty()).then(|| Instant {
        t: of(|it| it.t),
        speed: of(|it| it.speed),
        yaw_rate: of(|it| it.yaw_rate),
        lateral_acceleration: of(|it| it.lateral_acceleration),
        road_angle: of(|it| it.road_angle),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(angle: impl Fn(f64) -> f64) -> Vec<Moment> {
        let at = |t: f64| Instant {
            t,
            speed: 20.0,
            yaw_rate: 0.1,
            lateral_acceleration: 2.0,
            road_angle: angle(t),
        };
        moments((0..1000).map(|place| at(f64::from(place) * 0.01)))
    }

    #[test]
    fn steady_driving_is_found_and_steering_is_not() {
        let all = drive(|_| 0.02);
        assert_eq!(all.len(), 9);
        assert!((all[0].curvature - 0.005).abs() < 1e-12 && (all[0].t - 0.495).abs() < 0.01);
        assert_eq!(drive(|t| 0.02 * t), []);
        assert_eq!(drive(|t| if (3.2..4.1).contains(&t) { f64::NAN } else { 0.02 }).len(), 8);
    }
}
