//! Section 5.3.2: identification off line.

use super::numeric::within;
use super::{Claim, Experiment, Outcome, Picture, SIM1, SimulatedDrive};
use crate::report::{Color, Marker, Plot};
use identify::{
    Identified, Identifier, IdentifyConfig, LongitudinalInput, Method, Path, Record, Row, free_run,
};
use physics::model::scenario::thesis::steered;
use physics::model::{Scenario, TireKind, Uncertain, Vehicle};
use physics::time::Clock;
use physics::{Quantity, Sensors};

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment { figure: "5.11", title: "The error over C_y has one minimum", run: one_minimum },
    Experiment { figure: "5.12", title: "Identification of Sim1 from many starts", run: many_starts },
    Experiment { figure: "5.13", title: "Identification without lateral excitation", run: straight_on },
    Experiment { figure: "5.26", title: "The textbook example of this model", run: textbook },
];

/// N/rad or N per unit slip of one wheel, from what is normalized by its static load.
const NEWTON: f64 = 1700.0 * physics::model::GRAVITY / 4.0;
/// Steering amplitudes, rad: nothing slides; everything does.
const AMPLITUDES: [f64; 2] = [0.01, 0.1];

/// Sim1 with this steering amplitude; without noise unless asked for.
fn sim1(amplitude: f64, noisy: bool) -> Result<(Record, Vehicle), String> {
    let scenario = steered(SIM1, amplitude, noisy).map_err(|e| e.to_string())?;
    let driven = SimulatedDrive::simulate(&scenario, 11)?;
    Ok((Record::new("Sim1", &driven.samples, &driven.sensors), scenario.vehicle))
}

/// C_x and C_y (front and rear as one) from one start.
fn two_parameters(drive: LongitudinalInput) -> IdentifyConfig {
    IdentifyConfig {
        parameters: vec!["longitudinal_stiffness".into(), "lateral_stiffness".into()],
        drive: Some(drive),
        starts: 1,
        profile: false,
        ..IdentifyConfig::default()
    }
}

fn one_minimum() -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let mut plot = Plot::new("Error over C_y", "V / V(1e5 N/rad)", 0.9e4..1.01e5, 0.0..1.05)
        .x_label("C_y, N/rad")
        .height(300);
    let colors = [Color::First, Color::Second, Color::Third];
    let cases = [
        ("nothing slides (0.01 rad), piecewise linear tire", 0.01, TireKind::Piecewise),
        ("sliding (0.1 rad), piecewise linear tire", 0.1, TireKind::Piecewise),
        ("sliding (0.1 rad), linear tire as in (5.18)", 0.1, TireKind::Linear),
    ];
    for ((name, amplitude, tire), color) in cases.into_iter().zip(colors) {
        let (record, vehicle) = sim1(amplitude, false)?;
        let grid: Vec<f64> = (0..=72).map(|step| 1e4 + 1.25e3 * f64::from(step)).collect();
        let errors: Vec<f64> =
            grid.iter().map(|stiffness| error(&record, &vehicle, tire, *stiffness)).collect();
        let lowest = (0..grid.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b])).unwrap_or(0);
        let minima = errors.windows(3).filter(|e| e[1] < e[0] && e[1] < e[2]).count();
        let truth = 11.5 * NEWTON;
        let at_truth = (grid[lowest] - truth).abs() <= 1.25e3;
        let found = format!("{minima} minimum at {:.2}e4 N/rad (truth 4.80e4)", grid[lowest] / 1e4);
        if tire == TireKind::Piecewise {
            let what = format!("V(C_y) has its only minimum at the truth: {name}");
            let thesis = "one minimum, 5e4";
            outcome.claims.push(Claim::new(&what, thesis, found, minima == 1 && at_truth, ""));
        } else {
            let what = format!("V(C_y) of the linear bicycle has it there, too: {name}");
            let note = "the tires slide; a linear tire explains that by being softer (what their forces are \
                        per slip angle), so identification needs a tire that saturates";
            outcome.claims.push(Claim::new(&what, "one minimum, 5e4", found, minima == 1 && at_truth, note));
        }
        let scale = errors.last().copied().unwrap_or(1.0);
        plot = plot.line(name, color, grid.iter().zip(&errors).map(|(x, y)| (*x, y / scale)));
    }
    outcome.pictures.push(Picture {
        name: "figure_5_11".into(),
        heading: "Error of a simulation over C_y (figure 5.11)".into(),
        plot,
        caption: "Sum of squared errors of yaw rate and lateral acceleration (each by its variance) of a \
                  simulation of Sim1 with this C_y at all wheels."
            .into(),
    });
    Ok(outcome)
}

/// V(C_y): squared errors of yaw rate and lateral acceleration of a simulation, relative to their spread.
fn error(record: &Record, vehicle: &Vehicle, tire: TireKind, stiffness: f64) -> f64 {
    let normalized = Uncertain::known(stiffness / NEWTON);
    let vehicle = Vehicle {
        tire,
        lateral_stiffness_front: normalized,
        lateral_stiffness_rear: normalized,
        ..vehicle.clone()
    };
    let fits = free_run(std::slice::from_ref(record), &vehicle, LongitudinalInput::WheelSpeeds);
    let both = ["yaw_rate", "lateral_acceleration"];
    let fits = fits.percent.iter().filter(|(name, _)| both.contains(name));
    fits.map(|(_, percent)| (1.0 - percent / 100.0).powi(2)).sum()
}

/// The thesis's grid: C_x 1e5 to 1e6, C_y 1e4 to 1e5, ten by ten, corners included.
fn grid() -> impl Iterator<Item = [f64; 2]> {
    (0..10).flat_map(|i| {
        (0..10).map(move |j| [1e5 + 1e5 * f64::from(i), 1e4 + 1e4 * f64::from(j)].map(|c| c / NEWTON))
    })
}

fn many_starts() -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    for amplitude in AMPLITUDES {
        let (record, vehicle) = sim1(amplitude, false)?;
        let records = [record];
        let config = two_parameters(LongitudinalInput::WheelSpeeds);
        let identifier = Identifier::new(&records, &vehicle, &config).map_err(|e| e.to_string())?;
        let starts: Vec<Vec<f64>> = grid().map(Vec::from).collect();
        let paths = identifier.search_from(&starts);
        let off = |path: &Path| (path.to[0] / 50.0 - 1.0).abs().max((path.to[1] / 11.5 - 1.0).abs());
        let worst = paths.iter().map(off).fold(0.0, f64::max);
        let there = paths.iter().filter(|path| off(path) < 0.005).count();
        let ours = format!("{there} of 100 starts end within 0.5 %; the farthest {}", within(worst));
        let what = format!("Sim1 at {amplitude} rad: starts near enough end at the truth, some are stuck");
        let thesis = "near (2e5, 5e4) if started close, else local minima";
        let note =
            "segments simulated from starts of their own keep residuals nearly linear: nothing gets stuck";
        outcome.claims.push(Claim::better(&what, ours, there == 100, note));
        if let Some(claim) = outcome.claims.last_mut() {
            claim.thesis = thesis.into();
        }
        outcome.pictures.push(starts_picture(
            &format!("figure_5_12_{}", if amplitude < 0.05 { "gentle" } else { "sliding" }),
            &format!("Starts and ends, Sim1 at {amplitude} rad (figure 5.12)"),
            &paths,
            (0.0..1.05e6, 0.0..1.05e5),
        ));
    }
    let (record, vehicle) = sim1(0.01, true)?;
    let records = [record];
    for drive in [LongitudinalInput::Torque, LongitudinalInput::WheelSpeeds] {
        let config = two_parameters(drive);
        let identifier = Identifier::new(&records, &vehicle, &config).map_err(|e| e.to_string())?;
        let result = identifier.run(|_, _| ()).map_err(|e| e.to_string())?;
        let holds = result.parameters.iter().zip([50.0, 11.5]).all(|(p, truth)| covers(p, truth));
        let ours = result.parameters.iter().map(newtons).collect::<Vec<_>>().join(", ");
        let by = if drive == LongitudinalInput::Torque { "torque" } else { "the driven wheels' speeds" };
        let what = format!("with the noise of an ESP cluster, driven by {by}: intervals hold the truth");
        outcome.claims.push(Claim::better(
            &what,
            ours,
            holds,
            "one seed; 95 % intervals are wrong one time in ten here",
        ));
    }
    Ok(outcome)
}

fn covers(parameter: &Identified, truth: f64) -> bool {
    (parameter.ci95.0..=parameter.ci95.1).contains(&truth)
}

/// A stiffness in N or N/rad with its interval.
fn newtons(parameter: &Identified) -> String {
    let (low, high) = parameter.ci95;
    let name = if parameter.name == "longitudinal_stiffness" { "C_x" } else { "C_y" };
    format!("{name} {:.4e} ({:.4e} to {:.4e})", parameter.value * NEWTON, low * NEWTON, high * NEWTON)
}

fn starts_picture(
    name: &str,
    heading: &str,
    paths: &[Path],
    (x, y): (std::ops::Range<f64>, std::ops::Range<f64>),
) -> Picture {
    let point = |values: &Vec<f64>| (values[0] * NEWTON, values[1] * NEWTON);
    let starts: Vec<_> = paths.iter().map(|path| point(&path.from)).collect();
    let ends: Vec<_> = paths.iter().map(|path| point(&path.to)).collect();
    let plot = Plot::new(heading, "C_y, N/rad", x, y)
        .x_label("C_x, N")
        .height(420)
        .points("starts", Color::Muted, Marker::Cross, starts.into_iter())
        .points("ends", Color::First, Marker::Dot, ends.into_iter());
    Picture {
        name: name.into(),
        heading: heading.into(),
        plot,
        caption: "Where each search began and where it ended.".into(),
    }
}

/// Nearly straight on, with torque to and fro, as on a country road.
fn straight_on() -> Result<Outcome, String> {
    let mut scenario = Scenario::parse(SIM1).map_err(|e| e.to_string())?;
    scenario.steering_wheel_angle.clear();
    scenario.initial_speed_mps = 20.0;
    let driven = SimulatedDrive::simulate(&scenario, 5)?;
    let records = [Record::new("straight on", &driven.samples, &driven.sensors)];
    let config = IdentifyConfig {
        drive: Some(LongitudinalInput::WheelSpeeds),
        ..two_parameters(LongitudinalInput::WheelSpeeds)
    };
    let vehicle = &scenario.vehicle;
    let identifier = Identifier::new(&records, vehicle, &config).map_err(|e| e.to_string())?;
    let few = grid().enumerate().filter(|(place, _)| place % 3 == 0 && (place / 10) % 3 == 0);
    let starts: Vec<Vec<f64>> = few.map(|(_, from)| from.to_vec()).collect();
    let paths = identifier.search_from(&starts);
    let result = identifier.run(|_, _| ()).map_err(|e| e.to_string())?;
    let [along, across] = result.parameters.as_slice() else { return Err("two parameters".into()) };
    let spread = |place: usize| {
        let ends = || paths.iter().map(|path| path.to[place]);
        ends().fold(0.0, f64::max) / ends().fold(f64::INFINITY, f64::min)
    };
    let mut outcome = Outcome::default();
    outcome.claims.push(Claim::new(
        "C_x comes out the same from every start",
        "a line near C_x = 1e5",
        format!("ends differ by a factor of {:.3}; {}", spread(0), newtons(along)),
        spread(0) < 1.01 && along.identifiable,
        "",
    ));
    let far = spread(1) > 1.5 || (across.ci95.1 / across.ci95.0) > 2.0;
    outcome.claims.push(Claim::new(
        "C_y cannot be had without lateral excitation",
        "ends scatter from 0 to 8e5",
        format!(
            "ends differ by a factor of {:.2}; 95 % interval {:.1e} to {:.1e} N/rad",
            spread(1),
            across.ci95.0 * NEWTON,
            across.ci95.1 * NEWTON
        ),
        far,
        "here the noise of the steering sensor decides: all starts end at tires so soft that it does no harm",
    ));
    outcome.claims.push(Claim::better(
        "it is not sold as a number",
        format!("identifiable: C_x {}, C_y {} ({})", along.identifiable, across.identifiable, across.reason),
        along.identifiable && !across.identifiable,
        "the same noise added once more moves C_y: the recording does not know it",
    ));
    outcome.pictures.push(starts_picture(
        "figure_5_13",
        "Starts and ends without lateral excitation (figure 5.13)",
        &paths,
        (0.0..1.05e6, 0.0..8e5),
    ));
    Ok(outcome)
}

/// The example of a vehicle with two unknown stiffnesses that system identification software is shown
/// with: this thesis's model (5.26) with linear tires, m 1700 kg, a = b = 1.5 m, J = m ((a+b)/2)²,
/// C_A 0.5 kg/m, 10 Hz, from C_x 1.5e5 N, C_y 4e4 N/rad. Its data are not to be had; they are simulated
/// here by equations written down once more.
fn textbook() -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    for (case, truth) in [("high stiffness", [2e5, 5e4]), ("low stiffness", [1e5, 2.5e4])] {
        for noisy in [false, true] {
            let record = textbook_record(truth, noisy);
            let vehicle = Vehicle {
                tire: TireKind::Linear,
                yaw_inertia_kgm2: Some(Uncertain::known(1700.0 * 1.5 * 1.5)),
                longitudinal_stiffness: Uncertain::known(1.5e5 / NEWTON),
                lateral_stiffness_front: Uncertain::known(4e4 / NEWTON),
                lateral_stiffness_rear: Uncertain::known(4e4 / NEWTON),
                ..Vehicle::thesis()
            };
            let config =
                IdentifyConfig { method: Method::FreeRun, ..two_parameters(LongitudinalInput::Slips) };
            let records = [record];
            let identifier = Identifier::new(&records, &vehicle, &config).map_err(|e| e.to_string())?;
            let result = identifier.run(|_, _| ()).map_err(|e| e.to_string())?;
            let pairs = || result.parameters.iter().zip(truth);
            let worst = pairs().map(|(p, t)| (p.value * NEWTON / t - 1.0).abs()).fold(0.0, f64::max);
            let ours = result.parameters.iter().map(newtons).collect::<Vec<_>>().join(", ");
            let noise = if noisy { "with noise" } else { "without noise" };
            let what = format!(
                "{case} ({:.0e} N, {:.1e} N/rad), {noise}: found from (1.5e5, 4e4)",
                truth[0], truth[1]
            );
            let good = if noisy { pairs().all(|(p, t)| covers(p, t / NEWTON)) } else { worst < 0.005 };
            outcome.claims.push(Claim::better(
                &what,
                format!("{ours}; off by {}", within(worst)),
                good,
                "a free run through all 60 s",
            ));
        }
    }
    Ok(outcome)
}

/// 60 s at 10 Hz of (5.26): slips of all wheels, steering; speed, lateral acceleration and yaw rate.
fn textbook_record([cx, cy]: [f64; 2], noisy: bool) -> Record {
    use rand::{RngExt, SeedableRng};
    let (m, a, b, drag) = (1700.0, 1.5, 1.5, 0.5);
    let inertia = m * 1.5 * 1.5;
    // Inputs go straight from sample to sample, as the example's own do.
    let straight = |t: f64, input: &dyn Fn(f64) -> f64| {
        let from = (10.0 * t + 1e-9).floor();
        let share = 10.0 * t - from;
        (1.0 - share) * input(0.1 * from) + share * input(0.1 * (from + 1.0))
    };
    let steer = |t: f64| straight(t, &|t| 0.03 * (0.9 * t).sin() + 0.02 * (2.3 * t + 1.0).sin());
    let slip = |t: f64| straight(t, &|t| 1e-3 + 1.5e-3 * (0.4 * t).sin());
    let rate = |[vx, vy, r]: [f64; 3], t: f64| {
        let (delta, s) = (steer(t), slip(t));
        let (sin, cos) = delta.sin_cos();
        let front = 2.0 * cy * (delta - ((vy + a * r) / vx).atan());
        let rear = -2.0 * cy * ((vy - b * r) / vx).atan();
        let along = 2.0 * cx * s;
        let ay = (along * sin + front * cos + rear) / m;
        let ax = (along * cos - front * sin + along - drag * vx * vx) / m;
        ([ax + vy * r, ay - vx * r, (a * (along * sin + front * cos) - b * rear) / inertia], ay)
    };
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut gauss = |std: f64| {
        let z: f64 = random.sample(rand_distr::StandardNormal);
        if noisy { std * z } else { 0.0 }
    };
    let mut state = [12.0, 0.0, 0.0];
    let mut rows = Vec::new();
    for step in 0..600 {
        let t = 0.1 * f64::from(step);
        let (_, ay) = rate(state, t);
        let nothing = f64::NAN;
        rows.push(Row {
            t,
            steering: steer(t),
            wheel_speed: [nothing; 4],
            yaw_rate: state[2] + gauss(0.01),
            lateral_acceleration: ay + gauss(0.1),
            longitudinal_acceleration: nothing,
            drive_torque: nothing,
            brake_pressure: nothing,
            vehicle_speed: state[0] + gauss(0.05),
            slip: [slip(t); 4],
            braking: false,
        });
        // A hundred Heun steps to each sample: another integrator than the one that is tested.
        for inner in 0..100 {
            let t = t + 1e-3 * f64::from(inner);
            let (k1, _) = rate(state, t);
            let ahead = std::array::from_fn(|i| state[i] + 1e-3 * k1[i]);
            let (k2, _) = rate(ahead, t + 1e-3);
            state = std::array::from_fn(|i| state[i] + 0.5e-3 * (k1[i] + k2[i]));
        }
    }
    let mut sensors = Sensors::default();
    for (quantity, std) in [
        (Quantity::YawRate, 0.01),
        (Quantity::LateralAcceleration, 0.1),
        (Quantity::VehicleSpeed, 0.05),
        (Quantity::SteeringWheelAngle, 1e-4),
    ] {
        sensors.add(quantity, Some(std));
    }
    Record { name: "textbook".into(), clock: Clock::default(), period_s: 0.1, rows, sensors }
}
