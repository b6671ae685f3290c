//! Figure 5.4: method 1 drifts.

use super::course::{AS_FIXED, LateralDrive, scenario};
use crate::report::{Color, Plot};
use crate::reproduce::{Claim, Outcome, Picture, SIM1};
use physics::model::Scenario;

/// As long as the thesis's recording, s.
const DURATION_S: f64 = 1000.0;
/// Offsets of the sensors: a good ESP cluster at constant temperature; its data sheet allows about
/// five times as much. Lateral acceleration m/s², yaw rate rad/s (0.03 °/s).
const OFFSETS: (f64, f64) = (-0.02, 0.0005);

/// Sim1, longer; sensors with this share of their noise and of [`OFFSETS`].
fn drive(noise: f64, offsets: f64) -> Result<LateralDrive, String> {
    let mut scenario: Scenario = scenario(SIM1, AS_FIXED)?;
    scenario.duration_s = DURATION_S;
    for (name, sensor) in &mut scenario.sensors.by_name {
        sensor.noise_std *= noise;
        sensor.offset = match name.as_str() {
            "lateral_acceleration" => offsets * OFFSETS.0,
            "yaw_rate" => offsets * OFFSETS.1,
            _ => 0.0,
        };
    }
    LateralDrive::run(&scenario, scenario.seed)
}

/// Mean error over the last ten seconds: the drift without the swing, m/s.
fn drift(course: &LateralDrive) -> f64 {
    let late = DURATION_S - 10.0..DURATION_S;
    super::course::mean(
        course
            .during(late)
            .filter_map(|point| Some(point.velocities.integration? - point.truth.lateral_velocity)),
    )
}

pub(super) fn run() -> Result<Outcome, String> {
    let (ideal, noisy, real) = (drive(0.0, 0.0)?, drive(1.0, 0.0)?, drive(1.0, 1.0)?);
    let all = 0.0..DURATION_S;
    let error = |course: &LateralDrive| course.error(all.clone(), |point| point.velocities.integration);
    let (with_offsets, with_noise, vy) = (drift(&real), error(&noisy), ideal.lateral_velocity(all.clone()));
    let ours = real.error(20.0..DURATION_S, |point| point.velocities.joint);
    // What the offsets alone must give: ∫ (offset of a_y − v_x · offset of r) dt.
    let expected: f64 = real
        .points
        .iter()
        .map(|point| point.now.elapsed_s * (OFFSETS.0 - point.truth.longitudinal_velocity * OFFSETS.1))
        .sum();
    let range = -35.0..10.0;
    let plot = Plot::new("Lateral velocity by integration", "v_y, m/s", 0.0..DURATION_S, range)
        .line(
            "method 1, sensors with noise and offsets",
            Color::Notice,
            real.line(|p| p.velocities.integration),
        )
        .line("method 1, noise only", Color::Second, noisy.line(|p| p.velocities.integration))
        .line("ours, noise and offsets", Color::First, real.line(|p| p.velocities.joint))
        .line("true", Color::Truth, real.truth());
    Ok(Outcome {
        claims: vec![
            Claim::new(
                "Method 1 drifts away on sensors as they are",
                "to about −30 m/s within 1000 s (measured)",
                format!(
                    "{with_offsets:.1} m/s after {DURATION_S:.0} s, with offsets of {} m/s² and {} rad/s; \
                     true v_y: {vy:.2} m/s rms",
                    OFFSETS.0, OFFSETS.1
                ),
                with_offsets.abs() > 10.0,
                "",
            ),
            Claim::new(
                "The offsets are why: they are integrated",
                "offsets, drifts and noise are named",
                format!(
                    "the offsets alone must give {expected:.1} m/s; noise alone gives an error of \
                     {with_noise:.2} m/s rms"
                ),
                (expected - with_offsets).abs() < 0.1 * with_offsets.abs() + 3.0 * with_noise
                    && with_noise < 0.1 * with_offsets.abs(),
                "noise alone makes a random walk, slower by two orders",
            ),
            Claim::new(
                "Without noise and offsets it is very good",
                "very good",
                format!("error {:.3} m/s rms", error(&ideal)),
                error(&ideal) < 0.1 * vy,
                "what is left comes less from Euler's rule than from rear wheels that slide: they turn a little \
                 slower than the car drives",
            ),
            Claim::better(
                "The joint filter on the same sensors: it learns the offsets",
                format!("error {ours:.3} m/s rms over {DURATION_S:.0} s"),
                ours < 0.2 * vy,
                "its tires are linear; at ±0.1 rad they slide now and then",
            ),
        ],
        pictures: vec![Picture {
            name: "figure_5_4".into(),
            heading: "5.4 Lateral velocity by method 1".into(),
            plot,
            caption: "Integrated offsets run away; the thesis drove a real car, here it is Sim1 over 1000 s \
                      with offsets put in."
                .into(),
        }],
    })
}
