//! Figure 9.2: what normal driving shows of the slip curve.

use nalgebra::{Matrix3, Vector3, vector};

use super::slip_slope::normal_driving;
use super::{Claim, Experiment, Outcome, Picture, SimulatedDrive};
use crate::report::{Color, Marker, Plot, Stroke};
use physics::model::scenario::WheelNumbers;
use physics::model::{GRAVITY, TireKind};
use physics::{Quantity, Sample};

/// The experiment.
pub const FIGURE_9_2: Experiment =
    Experiment { figure: "9.2", title: "Slip and force in normal driving", run: scatter };

/// True slope and friction.
const TRUE: (f64, f64) = (50.0, 1.0);

/// Points are means over this many samples: a quarter of a second.
const SAMPLES: usize = 25;

/// A fit stands on so many points: half a minute.
const WINDOW: usize = 120;

/// Slip and normalized force of the front left wheel.
type Point = (f64, f64);

/// The brush curve with θ = (C, 1/μ, slip offset), where 1/μ = 0 is a line without limit, and its derivative.
fn brush(theta: &Vector3<f64>, slip: f64) -> (f64, Vector3<f64>) {
    let [c, m] = [theta[0], theta[1]];
    let s = slip - theta[2];
    let force = c * s - c * c * s * s.abs() * m / 3.0 + c.powi(3) * s.powi(3) * m * m / 27.0;
    let by_c = s - 2.0 * c * s * s.abs() * m / 3.0 + 3.0 * c * c * s.powi(3) * m * m / 27.0;
    let by_m = -c * c * s * s.abs() / 3.0 + 2.0 * c.powi(3) * s.powi(3) * m / 27.0;
    let by_s = c - 2.0 * c * c * s.abs() * m / 3.0 + 3.0 * c.powi(3) * s * s * m * m / 27.0;
    (force, vector![by_c, by_m, -by_s])
}

/// Least squares by Gauss–Newton from a line; returns θ and its standard deviations.
fn fitted(points: &[Point]) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let mut theta = vector![TRUE.0, 0.5, 0.0];
    let mut covariance = Matrix3::zeros();
    for _ in 0..30 {
        let (mut normal, mut right, mut cost) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
        for (slip, force) in points {
            let (predicted, gradient) = brush(&theta, *slip);
            normal += gradient * gradient.transpose();
            right += gradient * (force - predicted);
            cost += (force - predicted).powi(2);
        }
        let inverse = normal.try_inverse()?;
        covariance = inverse * (cost / (points.len() as f64 - 3.0));
        let step = inverse * right;
        theta += step * (1.0 / (1.0 + step[1].abs()));
    }
    let std = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
    theta.iter().chain(std.iter()).all(|x| x.is_finite()).then_some((theta, std))
}

/// The line through points: slope, and the share of the force's variance that it explains.
fn line(points: &[Point]) -> (f64, f64) {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let sum = |f: &dyn Fn(&Point) -> f64| points.iter().map(f).sum::<f64>();
    let xx = sum(&|p| (p.0 - x).powi(2));
    let xy = sum(&|p| (p.0 - x) * (p.1 - y));
    let yy = sum(&|p| (p.1 - y).powi(2));
    (xy / xx, xy * xy / (xx * yy))
}

fn points(drive: &SimulatedDrive) -> Vec<Point> {
    let vehicle = &drive.vehicle;
    let scale = 0.5 * vehicle.drive_torque_ratio.value
        / vehicle.wheel_radius_m.value
        / (0.25 * vehicle.mass() * GRAVITY);
    let point = |samples: &[Sample]| {
        let mut mean = (0.0, 0.0);
        for sample in samples {
            let [front, _, rear, _] = sample.wheel_speeds()?;
            if sample.get(Quantity::BrakeActive) != Some(0.0) {
                return None;
            }
            mean.0 += (front / rear - 1.0) / samples.len() as f64;
            mean.1 += scale * sample.get(Quantity::DriveTorque)? / samples.len() as f64;
        }
        Some(mean)
    };
    drive.samples.chunks_exact(SAMPLES).filter_map(point).collect()
}

fn scatter() -> Result<Outcome, String> {
    let mut scenario = normal_driving(1200.0)?;
    scenario.road.truncate(1);
    if let Some(road) = scenario.road.first_mut() {
        (road.slope, road.friction) = (Some(TRUE.0), Some(TRUE.1));
    }
    scenario.vehicle.tire = TireKind::Brush;
    scenario.radius_difference = WheelNumbers::default();
    let drive = SimulatedDrive::simulate(&scenario, 2)?;
    let points = points(&drive);
    let most = points.iter().map(|(_, mu)| *mu).fold(0.0, f64::max);
    let half = points.iter().filter(|(_, mu)| mu.abs() > 0.5 * TRUE.1).count() as f64 / points.len() as f64;
    let (slope, explained) = line(&points);
    let fits: Vec<_> = points.chunks_exact(WINDOW).filter_map(fitted).collect();
    let unbounded = fits.iter().filter(|(theta, std)| theta[1] - 1.96 * std[1] <= 0.0).count();
    let count = fits.len() as f64;
    let mean_std = fits.iter().map(|(_, std)| std[1]).sum::<f64>() / count;
    let useful = fits.iter().filter(|(theta, std)| 1.96 * std[1] < 0.2 * theta[1]).count();
    // The same drive on a tire of the same slope and friction, but another curve.
    scenario.vehicle.tire = TireKind::MagicFormula;
    let other = fitted(&self::points(&SimulatedDrive::simulate(&scenario, 2)?))
        .ok_or("the brush cannot be fitted")?;
    let with_its_own = fitted(&points).ok_or("the brush cannot be fitted")?;
    let [own, wrong] = [with_its_own, other].map(|(theta, std)| {
        [theta[1] + 1.96 * std[1], theta[1] - 1.96 * std[1]]
            .map(|m| if m > 0.0 { 1.0 / m } else { f64::INFINITY })
    });

    let slips = || (0..=200).map(|i| f64::from(i) * 1e-4);
    let (true_theta, fit_line) = (vector![TRUE.0, 1.0 / TRUE.1, 0.0], slope);
    let plot = Plot::new("Figure 9.2: normal driving", "μ_x", 0.0..0.02, 0.0..1.0)
        .x_label("slip s")
        .height(420)
        .points("means over 0.25 s", Color::First, Marker::Dot, points.iter().copied())
        .curve("true curve", Color::Truth, Stroke::Solid, slips().map(|s| (s, brush(&true_theta, s).0)))
        .curve("fitted line", Color::Second, Stroke::Dashed, slips().map(|s| (s, fit_line * s)));
    let claims = vec![
        Claim::new(
            "normal driving on a good road stays far below half of the friction",
            "rarely reached",
            format!(
                "{:.1} % of {} points above 0.5 μ_max; largest μ_x {most:.2}",
                100.0 * half,
                points.len()
            ),
            half < 0.01,
            "",
        ),
        Claim::new(
            "a line is easily fitted",
            "by eye",
            format!(
                "explains {:.0} % of the variance, slope {slope:.1} (true {:.0})",
                100.0 * explained,
                TRUE.0
            ),
            explained > 0.8 && (slope / TRUE.0 - 1.0).abs() < 0.15,
            "",
        ),
        Claim::new(
            "an entire slip curve is not",
            "hard to decide on",
            format!(
                "of {count:.0} fits to 30 s {unbounded} have no upper bound of μ and {useful} know it to 20 %; std of 1/μ \
                 {mean_std:.1} (true 1/μ: {:.1})",
                1.0 / TRUE.1
            ),
            3 * unbounded > fits.len() && 10 * useful < fits.len(),
            "",
        ),
        Claim::new(
            "more data at low slip do not help: they say what the assumed curve makes of them",
            "points along the curve needed",
            format!(
                "20 minutes, brush fitted: μ {:.2} to {:.2} (95 %) on a brush tire, {:.2} to {:.2} on a magic formula; \
                 true {:.1} on both",
                own[0], own[1], wrong[0], wrong[1], TRUE.1
            ),
            !(wrong[0]..=wrong[1]).contains(&TRUE.1) && (wrong[0] > 1.2 * TRUE.1 || wrong[1] < TRUE.1 / 1.2),
            "",
        ),
    ];
    let picture = Picture {
        name: "figure_9_2".into(),
        heading: "Figure 9.2: data of normal driving".into(),
        plot,
        caption: "All of it lies where the curve cannot be told from its tangent.".into(),
    };
    Ok(Outcome { claims, pictures: vec![picture] })
}
