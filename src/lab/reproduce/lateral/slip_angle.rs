//! Figure 5.8: the rear slip angle with method 3 and with v_y = 0.

use super::course::{AS_FIXED, GENTLE, HALVED, LateralDrive, Point, WHOLE, halved, scenario};
use crate::report::{Color, Plot};
use crate::reproduce::{Claim, Outcome, Picture, SIM2};

/// Of the rear axle, degrees.
fn truth(point: &Point) -> f64 {
    point.truth.slip_angle_rear.to_degrees()
}

fn bicycle(point: &Point) -> Option<f64> {
    Some(point.slip_angles.bicycle?[1].to_degrees())
}

fn zero(point: &Point) -> Option<f64> {
    Some(point.slip_angles.zero?[1].to_degrees())
}

fn joint(point: &Point) -> Option<f64> {
    Some(point.slip_angles.joint?[1].to_degrees())
}

fn picture(course: &LateralDrive, name: &str, heading: &str, caption: &str) -> Picture {
    let plot = Plot::new(heading, "rear slip angle, °", 0.0..200.0, -5.0..5.0)
        .height(280)
        .spans(&halved())
        .line("true", Color::Truth, course.line(|point| Some(truth(point))))
        .line("method 3", Color::First, course.line(bicycle))
        .line("v_y = 0", Color::Notice, course.line(zero));
    Picture { name: name.into(), heading: heading.into(), plot, caption: caption.into() }
}

pub(super) fn run() -> Result<Outcome, String> {
    let course = |steering| {
        let scenario = scenario(SIM2, steering)?;
        LateralDrive::run(&scenario, scenario.seed)
    };
    let (fixed, gentle) = (course(AS_FIXED)?, course(GENTLE)?);
    type Angle = fn(&Point) -> Option<f64>;
    let share = |course: &LateralDrive, angle: Angle, time: &std::ops::Range<f64>| {
        course.rms(time.clone(), |point| Some(angle(point)? - truth(point)))
            / course.rms(time.clone(), |point| Some(truth(point)))
    };
    let percent = |course: &LateralDrive, angle: Angle, time| 100.0 * share(course, angle, &time);
    Ok(Outcome {
        claims: vec![
            Claim::new(
                "Method 3's slip angle is right while C_y is, and wrong while it is halved",
                "tracks well outside [100, 150] s, differs significantly inside",
                format!(
                    "error {:.0} % of α_R before, {:.0} % while halved (±0.01 rad); {:.0} % and {:.0} % (±0.1 rad)",
                    percent(&gentle, bicycle, WHOLE),
                    percent(&gentle, bicycle, HALVED),
                    percent(&fixed, bicycle, WHOLE),
                    percent(&fixed, bicycle, HALVED)
                ),
                share(&gentle, bicycle, &WHOLE) < 0.15 && share(&gentle, bicycle, &HALVED) > 0.3,
                "at ±0.1 rad tires slide before 100 s, too",
            ),
            Claim::new(
                "v_y = 0 gives a slip angle that differs greatly",
                "differs greatly",
                format!(
                    "error {:.0} % of α_R (±0.01 rad), {:.0} % (±0.1 rad)",
                    percent(&gentle, zero, WHOLE),
                    percent(&fixed, zero, WHOLE)
                ),
                share(&gentle, zero, &WHOLE) > 0.3 && share(&fixed, zero, &WHOLE) > 0.3,
                "",
            ),
            Claim::better(
                "The joint filter's slip angle",
                format!(
                    "error {:.0} % of α_R before, {:.0} % while halved (±0.01 rad); {:.0} % and {:.0} % (±0.1 rad)",
                    percent(&gentle, joint, WHOLE),
                    percent(&gentle, joint, HALVED),
                    percent(&fixed, joint, WHOLE),
                    percent(&fixed, joint, HALVED)
                ),
                share(&gentle, joint, &HALVED) < 0.5 * share(&gentle, bicycle, &HALVED),
                "the first seconds after the change count",
            ),
        ],
        pictures: vec![
            picture(
                &fixed,
                "figure_5_8",
                "5.8 Rear slip angle in Sim2, steering ±0.1 rad at 0.5 Hz",
                "A tire slides from 5.0° on. What is beyond the original's axis is drawn at its end.",
            ),
            picture(
                &gentle,
                "figure_5_8_gentle",
                "5.8 Rear slip angle in Sim2, steering ±0.01 rad at 0.5 Hz",
                "No tire slides.",
            ),
        ],
    })
}
