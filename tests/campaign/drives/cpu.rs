//! What a sample costs each peer. Printed, never asserted: machines differ.

use std::hint::black_box;
use std::time::Instant;

use gripd::estimate::thesis::{DahlEkf, JointEkf, LateralSlopeEstimator};
use gripd::estimate::{Car, EstimatorsConfig, Kinematics, Pipeline};

use super::learner::Learner;
use super::peers::Driven;

/// Each peer goes through a drive so often; the fastest time counts, what is slower was disturbed.
const TIMES: usize = 5;

/// Nanoseconds per sample.
fn time(samples: usize, mut through: impl FnMut()) -> f64 {
    let once = |_| {
        let start = Instant::now();
        through();
        start.elapsed().as_secs_f64()
    };
    1e9 * (0..TIMES).map(once).fold(f64::INFINITY, f64::min) / samples as f64
}

/// Each peer with its time per sample on this drive, ns.
pub fn times(drive: &Driven) -> Vec<(&'static str, f64)> {
    let Driven { sheet, sensors, samples, rows } = drive;
    let car = Car::new(sheet);
    let config = EstimatorsConfig::default();
    let slow = config.minimum_speed_mps;
    let kinematics: Vec<_> = samples.iter().map(|sample| Kinematics::new(sample, &car)).collect();
    let count = samples.len();
    vec![
        ("thesis (5.20), v_y given", {
            time(count, || {
                let mut peer = LateralSlopeEstimator::new(&car, slow);
                for (now, row) in kinematics.iter().zip(rows) {
                    peer.step(now, row.ours.thesis.lateral_velocities.kinematic);
                }
                black_box(peer.slopes());
            })
        }),
        ("thesis (5.21)", {
            time(count, || {
                let mut peer = JointEkf::new(&car, sensors, &config.joint_ekf, slow);
                kinematics.iter().for_each(|now| peer.step(now));
                black_box(peer.stiffness());
            })
        }),
        ("thesis 8.2, Dahl", {
            time(count, || {
                let mut peer = DahlEkf::new(&car, sensors, slow);
                kinematics.iter().for_each(|now| peer.step(now, &car));
                black_box(peer.friction());
            })
        }),
        ("learner", {
            time(count, || {
                let mut peer = Learner::new(sheet);
                kinematics.iter().for_each(|now| peer.step(now));
                black_box(peer.factor());
            })
        }),
        ("gripd, all of it, the thesis's filters too", {
            time(count, || {
                let mut peer = Pipeline::new(sheet, sensors, &config);
                samples.iter().for_each(|sample| {
                    black_box(peer.step(sample));
                });
            })
        }),
    ]
}
