//! Section 8.2: one wheel with the Dahl model.

use nalgebra::vector;

use super::sim3::{AtTheLimit, bound_claim, halved, published};
use super::{Claim, Experiment, Outcome, Picture, SIM3, SimulatedDrive};
use crate::report::{Color, Plot};
use physics::estimate::thesis::{DahlEkf, DahlWheel};
use physics::estimate::{Car, EstimatorsConfig, Kinematics};
use physics::model::{Scenario, Truth};

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] =
    &[Experiment { figure: "8.3", title: "One wheel with the Dahl model as an EKF", run: figure }];

/// What the filter said at one instant.
struct Row {
    truth: Truth,
    stiffness: Option<f64>,
    friction: Option<f64>,
}

/// Runs the filter over a drive, starting from this σ₀ (1/m) and μ.
fn filtered(drive: &SimulatedDrive, stiffness: f64, friction: f64) -> Vec<Row> {
    let car = Car::new(&drive.vehicle);
    let slow = EstimatorsConfig::default().minimum_speed_mps;
    let mut filter = DahlEkf::new(&car, &drive.sensors, slow).starting_from(stiffness, friction);
    let row = |(sample, truth): (&_, &Truth)| {
        filter.step(&Kinematics::new(sample, &car), &car);
        Row { truth: *truth, stiffness: filter.stiffness(), friction: filter.friction() }
    };
    drive.samples.iter().zip(&drive.truth).map(row).collect()
}

/// Pearson's correlation.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (x, y) = pairs.iter().fold((0.0, 0.0), |(x, y), pair| (x + pair.0 / n, y + pair.1 / n));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for pair in pairs {
        let (dx, dy) = (pair.0 - x, pair.1 - y);
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
    }
    xy / (xx * yy).sqrt()
}

fn rms(differences: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = differences.fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
    f64::sqrt(sum / count)
}

/// σ₀ and μ of a true Dahl wheel, as the filter finds them within a minute of a torque that pushes it to
/// and fro below its limit, relative to the truth.
fn of_a_true_dahl_wheel(wheel: &DahlWheel) -> Option<[f64; 2]> {
    let (stiffness, friction) = (80.0, 0.35);
    let mut filter = DahlEkf::with(*wheel, [1e-6, 1e-5], 1.0);
    let mut x = vector![0.0, 20.0, 20.0 / wheel.radius, stiffness, friction];
    for i in 0..60_000 {
        let torque = 340.0 * (f64::from(i) * 1e-3 * 9.0).sin();
        x = wheel.advance(&x, torque, 1e-3);
        if i % 10 == 9 {
            filter.observe(torque, x[1], x[2], 0.01);
        }
    }
    Some([filter.stiffness()? / stiffness - 1.0, filter.friction()? / friction - 1.0])
}

/// The least relative standard deviations of σ₀ and μ that one second of steady slip allows (Cramér–Rao),
/// and the rank of what is seen.
fn of_steady_slip(wheel: &DahlWheel, noise: [f64; 2]) -> ([f64; 2], usize) {
    let (used, stiffness) = (0.2, 60.0);
    let x = vector![used / stiffness, 30.0, 30.0 * 1.004 / wheel.radius, stiffness, used];
    let force = used * wheel.load;
    let acceleration = (force - wheel.drag * 900.0) / wheel.mass;
    let torque = wheel.radius * force + wheel.inertia * acceleration / wheel.radius;
    let seen = wheel.observability(x, &[torque; 1000], 1e-3, noise);
    let spectrum = seen.spectrum(&x);
    ([spectrum.bound(3), spectrum.bound(4)], spectrum.rank(1e-7))
}

fn figure() -> Result<Outcome, String> {
    let scenario = Scenario::parse(SIM3).map_err(|e| e.to_string())?;
    let drive = SimulatedDrive::simulate(&scenario, scenario.seed)?;
    let rows = filtered(&drive, 50.0, 0.5);
    let settled = || rows.iter().filter(|row| row.truth.time.seconds() > 20.0);
    let pulling = || settled().filter(|row| row.truth.mu_used > 0.05);

    let stiffness_error = rms(pulling().filter_map(|r| Some(r.stiffness? / r.truth.slope[0] - 1.0)));
    let friction_error = rms(pulling().filter_map(|r| Some(r.friction? - r.truth.mu_max)));
    let pairs: Vec<_> = pulling().filter_map(|row| Some((row.friction?, row.truth.mu_used))).collect();
    let follows = correlation(&pairs);
    let off_used = rms(pairs.iter().map(|(dahl, used)| dahl - used));
    let available: Vec<_> = pulling().filter_map(|row| Some((row.friction?, row.truth.mu_max))).collect();
    let knows = correlation(&available);

    let ends: Vec<f64> = [20.0, 50.0, 100.0]
        .into_iter()
        .filter_map(|start| filtered(&drive, start, 0.5).last()?.stiffness)
        .collect();
    let mean_stiffness = |from: f64| {
        let part = rows.iter().filter(|row| (from..from + 40.0).contains(&row.truth.time.seconds()));
        let (sum, count) =
            part.filter_map(|row| row.stiffness).fold((0.0, 0.0), |(s, n), x| (s + x, n + 1.0));
        sum / count
    };
    let ratio = mean_stiffness(110.0) / mean_stiffness(60.0);

    let car = Car::new(&drive.vehicle);
    let wheel = DahlWheel::new(&car);
    let omega = 0.05 / std::f64::consts::SQRT_2;
    let ([stiffness_bound, friction_bound], rank) =
        of_steady_slip(&wheel, [(car.radius * omega).powi(2), omega * omega]);
    let [true_stiffness, true_friction] =
        of_a_true_dahl_wheel(&DahlWheel { drag: 0.0, ..wheel }).ok_or("the filter did not start")?;
    let bound = bound_claim(&[published(&drive)]);

    let claims = vec![
        Claim::new(
            "σ₀ is not the stiffness",
            "not estimated",
            format!(
                "off by {:.0} % rms; times {ratio:.2} where the stiffness is times 0.5; ends at {} from starts at 20, \
                 50, 100",
                100.0 * stiffness_error,
                ends.iter().map(|end| format!("{end:.1}")).collect::<Vec<_>>().join(", ")
            ),
            stiffness_error > 0.2,
            "",
        ),
        Claim::new(
            "μ does not converge to the friction",
            "not estimated",
            format!("off by {friction_error:.2} rms"),
            friction_error > 0.2,
            "",
        ),
        Claim::new(
            "why: a Dahl tire in steady slip gives F = μ F_N whatever the slip, so μ is the friction used",
            "",
            format!(
                "correlation {follows:.3} with the friction used (off by {off_used:.3} rms), {knows:.2} with μ_max"
            ),
            follows > 0.95 && off_used < 0.05,
            "",
        ),
        Claim::new(
            "why: in steady slip σ₀ is not observable; μ is, as the force",
            "",
            format!(
                "rank {rank} of 5; one second of it tells {} of σ₀, and μ {}",
                if stiffness_bound > 10.0 {
                    "nothing".into()
                } else {
                    format!("{:.0} %", 100.0 * stiffness_bound)
                },
                if friction_bound < 1e-3 {
                    "to better than 0.1 %".into()
                } else {
                    format!("to {:.1} %", 100.0 * friction_bound)
                }
            ),
            rank == 4 && stiffness_bound > 10.0 && friction_bound < 0.05,
            "",
        ),
        Claim::better(
            "what it can do: a wheel that truly is a Dahl wheel, pushed to and fro below its limit",
            format!("σ₀ off by {:.0} %, μ by {:.0} %", 100.0 * true_stiffness, 100.0 * true_friction),
            true_stiffness.abs() < 0.15 && true_friction.abs() < 0.15,
            "while z builds up both act on the force; a rolling tire has no such phase",
        ),
        bound,
        AtTheLimit::measure(1..=4)?.claim(),
    ];
    Ok(Outcome { claims, pictures: vec![stiffness_picture(&rows), friction_picture(&rows)] })
}

fn series(rows: &[Row], value: impl Fn(&Row) -> Option<f64>) -> impl Iterator<Item = (f64, f64)> {
    rows.iter().map(move |row| (row.truth.time.seconds(), value(row).unwrap_or(f64::NAN)))
}

fn stiffness_picture(rows: &[Row]) -> Picture {
    let plot = Plot::new("Figure 8.3: estimated σ₀", "σ₀, 1/m; k, 1", 0.0..200.0, 0.0..100.0)
        .spans(&halved())
        .line("slope k of the simulated tire", Color::Truth, series(rows, |r| Some(r.truth.slope[0])))
        .line("σ₀ by the Dahl EKF", Color::First, series(rows, |r| r.stiffness));
    Picture {
        name: "figure_8_3_stiffness".into(),
        heading: "Figure 8.3: σ₀ on Sim3".into(),
        plot,
        caption:
            "σ₀ sinks to a few 1/m wherever it starts, and takes no notice of the halved stiffness: in steady \
                  slip nothing measured depends on it. Nor could it be k: one is a force per deflection, the other \
                  per slip."
                .into(),
    }
}

fn friction_picture(rows: &[Row]) -> Picture {
    let plot = Plot::new("Figure 8.3: estimated μ_max", "μ, 1", 0.0..200.0, 0.0..1.1)
        .spans(&halved())
        .line("μ_max, true", Color::Truth, series(rows, |r| Some(r.truth.mu_max)))
        .line("friction used, true", Color::OtherTruth, series(rows, |r| Some(r.truth.mu_used)))
        .line("μ by the Dahl EKF", Color::First, series(rows, |r| r.friction));
    Picture {
        name: "figure_8_3_friction".into(),
        heading: "Figure 8.3: μ on Sim3".into(),
        plot,
        caption: "The filter's μ is the friction used, not the friction there is.".into(),
    }
}
