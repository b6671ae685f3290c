//! What holds of all that the estimators say, whatever they are given.

use gripd::Estimates;
use gripd::estimates::Estimate;

/// Every number is one, every interval has its ends in order, and nothing is valid that is not there.
pub fn sound(estimates: &Estimates) {
    let is_number = |value: Option<f64>| value.is_none_or(f64::is_finite);
    let is_estimate = |e: &Option<Estimate>| {
        e.is_none_or(|e| e.value.is_finite() && e.std >= 0.0 && e.std.is_finite() && e.age_s >= 0.0)
    };
    let Estimates { motion, thesis, friction: mu, offsets, .. } = estimates;
    let v = &thesis.lateral_velocities;
    let lateral = [v.zero, v.integration, v.kinematic, v.bicycle, v.joint];
    let motions = [
        motion.speed,
        motion.lateral_velocity,
        motion.sideslip,
        motion.slip_angle_front,
        motion.slip_angle_rear,
    ];
    let frictions = [
        mu.max,
        mu.low,
        mu.high,
        mu.used,
        mu.age_s,
        mu.brush,
        mu.brush_std,
        mu.abs,
        mu.map,
        thesis.friction_dahl,
    ];
    assert!(lateral.into_iter().all(is_number), "{v:?}");
    assert!(motions.into_iter().all(is_number), "{motion:?}");
    assert!(frictions.into_iter().all(is_number), "{mu:?}");
    let all = estimates.slope.iter().chain(&estimates.slip_offset).chain(&estimates.cornering);
    let more = thesis.cornering_regression.iter().chain([&thesis.cornering_ekf]);
    let of_sensors = [&offsets.road_angle, &offsets.lateral_acceleration, &offsets.yaw_rate];
    assert!(all.chain(more).chain(of_sensors).all(is_estimate), "{estimates:?}");
    let ordered = |low: Option<f64>, high: Option<f64>| low.zip(high).is_none_or(|(low, high)| low <= high);
    assert!(ordered(mu.low, mu.max) && ordered(mu.max, mu.high) && ordered(mu.low, mu.high), "{mu:?}");
    assert!(mu.low.is_none_or(|low| low >= 0.0), "{mu:?}");
    assert!(!mu.valid || mu.max.is_some(), "{mu:?}");
    assert!(!motion.valid || motion.sideslip.is_some(), "{motion:?}");
    assert!(!estimates.slope_valid || estimates.slope.iter().any(Option::is_some), "{estimates:?}");
    assert!(!estimates.cornering_valid || estimates.cornering.iter().any(Option::is_some), "{estimates:?}");
    for share in [estimates.excitation_long, estimates.excitation_lat] {
        assert!((0.0..=1.0).contains(&share), "{estimates:?}");
    }
}
