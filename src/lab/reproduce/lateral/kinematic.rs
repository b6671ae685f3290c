//! Figure 5.5: method 2 is poor, and why.

use super::course::{AS_FIXED, GENTLE, LateralDrive, WHOLE, scenario};
use super::information::{kinematic_rank, kinematic_std};
use super::map::{self, Cell};
use crate::report::{Color, Plot};
use crate::reproduce::{Claim, Outcome, Picture, SIM1};
use physics::Sensors;
use physics::estimate::thesis::{KinematicObserver, SpeedDerivative};

/// Noise of the speed from two rear wheels: 0.05 rad/s each at 0.31 m, m/s.
const SPEED_NOISE: f64 = 0.011;

/// Error, m/s, after a minute straight on with an accelerometer that is off by 0.02 m/s².
fn straight_on() -> f64 {
    let mut observer = KinematicObserver::new(&Sensors::default());
    let mut derivative = SpeedDerivative::default();
    let step = |_: i32| observer.step(20.0, 0.0, [derivative.step(20.0, 0.01), 0.02], 0.01);
    (0..6000).map(step).last().unwrap_or(f64::NAN)
}

pub(super) fn run() -> Result<Outcome, String> {
    let fixed = scenario(SIM1, AS_FIXED)?;
    let course = LateralDrive::run(&fixed, fixed.seed)?;
    let gentle = scenario(SIM1, GENTLE)?;
    let gentle = LateralDrive::run(&gentle, gentle.seed)?;
    let all = 20.0..200.0;
    let vy = course.lateral_velocity(all.clone());
    let derived = course.error(all.clone(), |p| p.velocities.kinematic);
    let told = course.error(all.clone(), |p| Some(p.kinematic_true_ax));
    let measured = course.error(all.clone(), |p| p.kinematic_accelerometer);
    let ours = course.error(all.clone(), |p| p.velocities.joint);
    // What (5.13) leaves out of a_x, and what a_x is.
    let dropped = course.rms(all.clone(), |p| Some(p.truth.lateral_velocity * p.truth.yaw_rate));
    let ax = course.rms(all.clone(), |p| Some(p.truth.longitudinal_acceleration));
    let cells = map::cells()?;
    let share = |cell: &Cell| cell.errors[0][0] / cell.vy[0];
    let (least, most) = map::range(cells.iter(), share);
    let (_, told_most) = map::range(cells.iter(), |cell| cell.errors[0][1].max(cell.errors[1][1]));
    let drifted = straight_on();
    let ranks = [kinematic_rank(0.0), kinematic_rank(0.3)];
    let stds = [0.0, 0.05, 0.3].map(|r| kinematic_std(r, 1.0, SPEED_NOISE));
    let plot = |heading: &str, name: &str, value: fn(&super::course::Point) -> Option<f64>| {
        Plot::new(heading, "v_y, m/s", 0.0..200.0, -3.0..3.0)
            .height(260)
            .line("true", Color::Truth, course.truth())
            .line(name, Color::First, course.line(value))
    };
    let poor = "5.5 Method 2 on Sim1, a_x by (5.13)";
    let good = "5.5 Method 2 on Sim1, true a_x";
    let over = "Error of method 2 with (5.13) / true v_y";
    Ok(Outcome {
        claims: vec![
            Claim::new(
                "Method 2 is unsatisfactory on Sim1",
                "does not converge to the truth",
                format!("error {derived:.2} m/s rms of {vy:.2} m/s"),
                derived > 0.3 * vy,
                "",
            ),
            Claim::new(
                "Why, first: without yaw rate v_y cannot be observed",
                "",
                format!(
                    "rank {} at r = 0, {} at 0.3 rad/s; by the Gramian the least std of v_y from a second of \
                     speeds is {}, {:.2}, {:.3} m/s at r = 0, 0.05, 0.3 rad/s; straight on, an offset of 0.02 \
                     m/s² becomes {drifted:.2} m/s in a minute",
                    ranks[0],
                    ranks[1],
                    if stds[0].is_infinite() { "infinite".into() } else { format!("{:.2}", stds[0]) },
                    stds[1],
                    stds[2]
                ),
                ranks == [1, 2] && stds[0].is_infinite() && stds[1] > 5.0 * stds[2] && drifted > 1.0,
                "not named by the thesis",
            ),
            Claim::new(
                "Why, above all: (5.13) drops −v_y r and so tells the filter that r v_y = 0",
                "",
                format!(
                    "with the true a_x {told:.3} m/s rms, with (5.13) {derived:.2} m/s; dropped: {dropped:.2} \
                     m/s² rms of a_x's {ax:.2} m/s²"
                ),
                told < 0.05 && derived > 10.0 * told,
                "not named by the thesis",
            ),
            Claim::new(
                "Over steering frequency and amplitude",
                "poor",
                format!(
                    "error of {:.0}–{:.0} % of v_y; over half in {}; with the true a_x at most {told_most:.3} m/s \
                     anywhere",
                    100.0 * least,
                    100.0 * most,
                    map::names(cells, |cell| share(cell) > 0.5)
                ),
                least > 0.3,
                "fast or gentle steering: r v_y is small and quick, so hardly any of what it is wrongly told \
                 enters; there method 2 is method 1 with a leak, good on sensors without offsets",
            ),
            Claim::better(
                "With a longitudinal accelerometer (noise 0.07 m/s²) instead of (5.13)",
                format!("error {measured:.3} m/s rms; the joint filter, without one: {ours:.3} m/s"),
                measured < 0.05 * vy,
                "needs a level road: gravity's part along a slope is taken for a_x",
            ),
        ],
        pictures: vec![
            Picture {
                name: "figure_5_5".into(),
                heading: poor.into(),
                plot: plot(poor, "method 2", |p| p.velocities.kinematic),
                caption: "Steering ±0.1 rad at 0.5 Hz. As in the original it does not converge. The axis is \
                          twice the original's: this car's v_y is larger."
                    .into(),
            },
            Picture {
                name: "figure_5_5_true_ax".into(),
                heading: good.into(),
                plot: plot(good, "method 2 with the true a_x", |p| Some(p.kinematic_true_ax)),
                caption: "The same filter, −v_y r not left out.".into(),
            },
            Picture {
                name: "figure_5_5_map".into(),
                heading: over.into(),
                plot: map::plot(over, "rms error / rms v_y", cells, 1.2, share),
                caption: format!(
                    "Sim2 before 100 s (as Sim1). At ±0.01 rad and 0.5 Hz it is {:.0} %: {:.3} m/s of {:.2} m/s.",
                    100.0 * gentle.error(WHOLE, |p| p.velocities.kinematic) / gentle.lateral_velocity(WHOLE),
                    gentle.error(WHOLE, |p| p.velocities.kinematic),
                    gentle.lateral_velocity(WHOLE)
                ),
            },
        ],
    })
}
