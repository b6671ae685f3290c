//! Section 5.2.2 and 5.3.1: lateral velocity, slip angles and stiffness on line.
//!
//! The thesis does not print the frequency of its steering; so every result is also shown over
//! 0.05–1 Hz and 0.01–0.1 rad ([`map`]).

mod course;
mod ekf;
mod information;
mod integration;
mod joint_ekf;
mod kinematic;
mod linear;
mod map;
mod ours;
mod regression;
mod slip_angle;
mod slope;

use super::Experiment;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment { figure: "5.4", title: "Lateral velocity by integration (method 1)", run: integration::run },
    Experiment {
        figure: "5.5",
        title: "Lateral velocity by the kinematic observer (method 2)",
        run: kinematic::run,
    },
    Experiment {
        figure: "5.6–5.7",
        title: "Lateral velocity by the bicycle model (method 3)",
        run: linear::run,
    },
    Experiment { figure: "5.8", title: "Rear slip angle", run: slip_angle::run },
    Experiment {
        figure: "5.9",
        title: "Lateral slope by regression on each lateral velocity",
        run: slope::run,
    },
    Experiment {
        figure: "5.10",
        title: "Joint extended Kalman filter of lateral velocity and stiffness",
        run: joint_ekf::run,
    },
];
