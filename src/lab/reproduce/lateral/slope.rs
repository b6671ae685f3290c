//! Figure 5.9: the lateral slope (5.20) on each lateral velocity.

use super::course::{AS_FIXED, GENTLE, HALVED, LateralDrive, STIFFNESS, halved, mean, scenario};
use super::ekf::{Behaviour, Track};
use super::map;
use super::regression::{Source, over};
use crate::report::{Color, Plot};
use crate::reproduce::{Claim, Outcome, Picture, SIM2};

fn truth(course: &LateralDrive) -> impl Iterator<Item = (f64, f64)> {
    course.line(|point| Some(0.5 * (point.truth.cornering_front + point.truth.cornering_rear)))
}

/// The original's picture for one steering.
fn picture(course: &LateralDrive, name: &str, heading: &str, caption: &str) -> Picture {
    let line = |source| over(course, source).into_iter();
    let plot = Plot::new(heading, "C_yN, 1/rad", 0.0..200.0, 0.0..15.0)
        .height(280)
        .spans(&halved())
        .line("method 3", Color::First, line(Source::Bicycle))
        .line("method 2", Color::Third, line(Source::Kinematic))
        .line("v_y = 0", Color::Notice, line(Source::Zero))
        .line("true v_y", Color::Second, line(Source::Truth))
        .line("true C_yN", Color::Truth, truth(course));
    Picture { name: name.into(), heading: heading.into(), plot, caption: caption.into() }
}

pub(super) fn run() -> Result<Outcome, String> {
    let fixed = scenario(SIM2, AS_FIXED)?;
    let fixed = LateralDrive::run(&fixed, fixed.seed)?;
    let gentle = scenario(SIM2, GENTLE)?;
    let gentle = LateralDrive::run(&gentle, gentle.seed)?;
    let track = |course: &LateralDrive, source| Track::new(over(course, source).iter().copied());
    let cells = map::cells()?;
    let (sliding_before, sliding_halved) = (fixed.sliding(0.0..100.0), fixed.sliding(HALVED));
    let told = track(&gentle, Source::Truth);
    let told_sliding = track(&fixed, Source::Truth);
    let bicycle = track(&gentle, Source::Bicycle);
    // With v_y from a model of stiffness C the rear tires' slip angle is that model's a_y/(C g).
    let circular = mean(gentle.during(HALVED).filter_map(|point| {
        let [_, rear] = point.slip_angles.bicycle?;
        let mu = point.now.lateral_acceleration? / physics::model::GRAVITY;
        (mu.abs() > 0.1).then_some(mu / rear)
    }));
    let ours = Track::new(gentle.points.iter().map(|p| (p.t, p.ours.mean_stiffness().unwrap_or(f64::NAN))));
    let ours_fixed =
        Track::new(fixed.points.iter().map(|p| (p.t, p.ours.mean_stiffness().unwrap_or(f64::NAN))));
    let zero_gentle = track(&gentle, Source::Zero);
    let zero = track(&fixed, Source::Zero);
    let (kinematic, kinematic_gentle) = (track(&fixed, Source::Kinematic), track(&gentle, Source::Kinematic));
    let fails = |track: &Track| track.behaviour != Behaviour::Follows && track.behaviour != Behaviour::Late;
    let slow = cells.iter().filter(|cell| cell.grips());
    let (count, follow) = slow.fold((0, 0), |(count, follow), cell| {
        (count + 1, follow + i32::from(cell.slopes[0].behaviour == Behaviour::Follows))
    });
    let missed = map::names(cells, |cell| cell.grips() && cell.slopes[0].behaviour != Behaviour::Follows);
    let secant = "a sliding tire's secant is below its slope; (5.20) has no saturation";
    Ok(Outcome {
        claims: vec![
            Claim::new(
                "With the true v_y the true slope comes out",
                "very close to the true one in all of Sim2",
                format!(
                    "C_yN {} at the ends of the phases for {STIFFNESS}, {}, {STIFFNESS}; {:.0} s and {:.0} s \
                     after the changes (0.5 Hz, 0.01 rad); follows within 10 s in {follow} of {count} \
                     steerings without sliding (not: {missed})",
                    told,
                    0.5 * STIFFNESS,
                    told.delays_s[0],
                    told.delays_s[1]
                ),
                told.behaviour == Behaviour::Follows,
                "(5.20) leaves the yaw acceleration out: front and rear differ by it, their mean is right",
            ),
            Claim::new(
                "… at ±0.1 rad, too",
                "very close",
                format!(
                    "C_yN {}, a tire slides {:.0} % of the time before and {:.0} % while halved",
                    told_sliding,
                    100.0 * sliding_before,
                    100.0 * sliding_halved
                ),
                told_sliding.behaviour == Behaviour::Follows,
                secant,
            ),
            Claim::new(
                "With method 3's v_y it is not found",
                "does not follow the halving",
                format!("C_yN {} (0.5 Hz, 0.01 rad)", bicycle),
                fails(&bicycle),
                "",
            ),
            Claim::new(
                "Why: method 3 hands back the stiffness it was given",
                "its v_y is not robust against errors in C_y",
                format!(
                    "μ/α_R on its own slip angle while halved: {circular:.1} 1/rad for a model of {STIFFNESS} \
                     and a truth of {}",
                    0.5 * STIFFNESS
                ),
                (circular / STIFFNESS).ln().abs() < (2.0 * circular / STIFFNESS).ln().abs(),
                "nearer to what the filter believes than to what is true",
            ),
            Claim::new(
                "With method 2's v_y it is not found either",
                "not in a satisfactory way",
                format!("C_yN {kinematic} at ±0.1 rad; {kinematic_gentle} at 0.01 rad"),
                fails(&kinematic),
                "in gentle, quick steering method 2 is right (5.5), and so is the slope on it: on sensors \
                 without offsets",
            ),
            Claim::new(
                "With v_y = 0 it has very little to do with the truth",
                "little correlation, if any",
                format!("C_yN {} at ±0.1 rad; {} at 0.01 rad", zero, zero_gentle),
                fails(&zero) && fails(&zero_gentle),
                "",
            ),
            Claim::better(
                "The joint filter, which is told no v_y",
                format!(
                    "C_yN {} at 0.01 rad, {:.0} s and {:.0} s after the changes; {} at ±0.1 rad",
                    ours, ours.delays_s[0], ours.delays_s[1], ours_fixed
                ),
                ours.behaviour == Behaviour::Follows,
                "",
            ),
        ],
        pictures: vec![
            picture(
                &fixed,
                "figure_5_9",
                "5.9 Lateral slope in Sim2, steering ±0.1 rad at 0.5 Hz",
                "Tires slide at times, most of all while halved: there even the true v_y gives the secant \
                 of the sliding tire, not its slope.",
            ),
            picture(
                &gentle,
                "figure_5_9_gentle",
                "5.9 Lateral slope in Sim2, steering ±0.01 rad at 0.5 Hz",
                "No tire slides: with the true v_y the slope follows; with method 3's it stays near what \
                 method 3 was given; with v_y = 0 it is off the scale.",
            ),
        ],
    })
}
