//! Figures 5.6 and 5.7: method 3 is right while its stiffness is.

use super::course::{AS_FIXED, GENTLE, HALVED, LateralDrive, Point, WHOLE, halved, scenario};
use super::map::{self, Cell};
use crate::report::{Color, Plot, Span};
use crate::reproduce::{Claim, Outcome, Picture, SIM1, SIM2};

/// After sliding the linear model finds back within this time, s.
const RECOVERED_S: f64 = 1.0;

fn picture(
    course: &LateralDrive,
    name: &str,
    heading: &str,
    y: f64,
    spans: &[Span],
    caption: &str,
) -> Picture {
    let plot = Plot::new(heading, "v_y, m/s", 0.0..200.0, -y..y)
        .height(260)
        .spans(spans)
        .line("true", Color::Truth, course.truth())
        .line("method 3", Color::First, course.line(|p| p.velocities.bicycle));
    Picture { name: name.into(), heading: heading.into(), plot, caption: caption.into() }
}

fn bicycle(point: &Point) -> Option<f64> {
    point.velocities.bicycle
}

pub(super) fn run() -> Result<Outcome, String> {
    let course = |text, steering| {
        let scenario = scenario(text, steering)?;
        LateralDrive::run(&scenario, scenario.seed)
    };
    let (sim1, sim1_gentle) = (course(SIM1, AS_FIXED)?, course(SIM1, GENTLE)?);
    let (sim2, sim2_gentle) = (course(SIM2, AS_FIXED)?, course(SIM2, GENTLE)?);
    let all = 20.0..200.0;
    let relative = |course: &LateralDrive, time: &std::ops::Range<f64>| {
        course.error(time.clone(), bicycle) / course.lateral_velocity(time.clone())
    };
    let (error, vy) = (sim1.error(all.clone(), bicycle), sim1.lateral_velocity(all.clone()));
    let gripping = sim1.rms(all.clone(), |point| {
        (point.grip_s > RECOVERED_S).then(|| Some(bicycle(point)? - point.truth.lateral_velocity))?
    });
    let cells = map::cells()?;
    let share = |cell: &Cell, phase: usize| cell.errors[phase][2] / cell.vy[phase];
    let grips = || cells.iter().filter(|cell| cell.grips());
    let at_first = || cells.iter().filter(|cell| cell.sliding[0] == 0.0);
    let (_, worst) = map::range(at_first(), |cell| share(cell, 0));
    let (least_halved, most_halved) = map::range(grips(), |cell| share(cell, 1));
    let (_, ours_worst) = map::range(grips(), |cell| cell.errors[1][3] / cell.vy[1]);
    let (_, ours_against) = map::range(grips(), |cell| cell.errors[1][3] / cell.errors[1][2]);
    let (slowest, _) = map::range(cells.iter(), |cell| cell.speeds.0);
    let (_, fastest) = map::range(cells.iter(), |cell| cell.speeds.1);
    let sliding = [0, 1].map(|phase| map::names(cells, |cell| cell.sliding[phase] > 0.0));
    let over = "Share of the time in which a tire slides while halved";
    let gentle = "±0.01 rad, 0.5 Hz";
    let top = |course: &LateralDrive| {
        let peak = course.points.iter().map(|p| p.truth.lateral_velocity.abs()).fold(0.0, f64::max);
        peak.ceil().clamp(2.0, 8.0)
    };
    Ok(Outcome {
        claims: vec![
            Claim::new(
                "Method 3 is accurate on Sim1",
                "accurate",
                format!(
                    "error {:.3} m/s rms of {:.2} m/s ({gentle}); at most {:.1} % of v_y over the {} steerings \
                     of the map without sliding",
                    sim1_gentle.error(all.clone(), bicycle),
                    sim1_gentle.lateral_velocity(all.clone()),
                    100.0 * worst,
                    at_first().count()
                ),
                relative(&sim1_gentle, &all) < 0.1 && worst < 0.1,
                "",
            ),
            Claim::new(
                "… at ±0.1 rad and 0.5 Hz, too",
                "accurate",
                format!(
                    "error {error:.2} m/s rms of {vy:.2} m/s; {gripping:.3} m/s once no tire has slid for a \
                     second (one slides {:.0} % of the time)",
                    100.0 * sim1.sliding(all.clone())
                ),
                error < 0.1 * vy,
                "the tires slide at times, which a linear tire denies; the thesis's steering frequency is not \
                 printed",
            ),
            Claim::new(
                "Method 3 is wrong in Sim2 while C_y is halved",
                "differs significantly for t in [100, 150]",
                format!(
                    "error {:.0} % of v_y before, {:.0} % while halved ({gentle}); {:.0}–{:.0} % over the \
                     steerings without sliding",
                    100.0 * relative(&sim2_gentle, &WHOLE),
                    100.0 * relative(&sim2_gentle, &HALVED),
                    100.0 * least_halved,
                    100.0 * most_halved
                ),
                relative(&sim2_gentle, &HALVED) > 5.0 * relative(&sim2_gentle, &WHOLE) && least_halved > 0.2,
                "",
            ),
            Claim::new(
                "… at ±0.1 rad, too",
                "differs significantly",
                format!(
                    "error {:.2} m/s rms of {:.2} m/s before, {:.2} of {:.2} m/s while halved",
                    sim2.error(WHOLE, bicycle),
                    sim2.lateral_velocity(WHOLE),
                    sim2.error(HALVED, bicycle),
                    sim2.lateral_velocity(HALVED)
                ),
                relative(&sim2, &HALVED) > 0.4,
                "",
            ),
            Claim::better(
                "The joint filter in the same halved phase",
                format!(
                    "error {:.0} % of v_y ({gentle}); at most {:.0} % over the steerings without sliding; \
                     {:.2} m/s at ±0.1 rad",
                    100.0 * sim2_gentle.error(HALVED, |p| p.velocities.joint)
                        / sim2_gentle.lateral_velocity(HALVED),
                    100.0 * ours_worst,
                    sim2.error(HALVED, |p| p.velocities.joint)
                ),
                ours_against < 0.7,
                "its tires are linear: where they slide it is not right either",
            ),
        ],
        pictures: vec![
            picture(
                &sim1,
                "figure_5_6",
                "5.6 Method 3 on Sim1, steering ±0.1 rad at 0.5 Hz",
                top(&sim1),
                &[],
                "Right, except where tires slide. The axis is longer than the original's: this car's v_y is \
                 larger.",
            ),
            picture(
                &sim1_gentle,
                "figure_5_6_gentle",
                "5.6 Method 3 on Sim1, steering ±0.01 rad at 0.5 Hz",
                1.5,
                &[],
                "v_y nearly as small as in the original; no tire slides.",
            ),
            picture(
                &sim2,
                "figure_5_7",
                "5.7 Method 3 on Sim2, steering ±0.1 rad at 0.5 Hz",
                top(&sim2),
                &halved(),
                "While halved a tire slides half of the time; what is beyond the axis is drawn at its end.",
            ),
            picture(
                &sim2_gentle,
                "figure_5_7_gentle",
                "5.7 Method 3 on Sim2, steering ±0.01 rad at 0.5 Hz",
                2.0,
                &halved(),
                "Right before and after, too small while halved.",
            ),
            Picture {
                name: "figure_5_7_sliding".into(),
                heading: over.into(),
                plot: map::plot(over, "share", cells, 1.0, |cell| cell.sliding[1]),
                caption: format!(
                    "Sim2, speeds of {slowest:.0} to {fastest:.0} m/s. Tires slide before 100 s with {}; while \
                     halved with {}.",
                    sliding[0], sliding[1]
                ),
            },
        ],
    })
}
