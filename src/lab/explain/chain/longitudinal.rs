//! Along the car: acceleration, drive torque and brake against the change of the wheels' speed.

use super::regression::{FREE, fit};
use super::relations::{Relation, link, rows};
use super::report::{AuditFinding, ChainReport, Confidence};
use super::series::Series;
use super::tuning::TUNING;
use physics::Quantity;
use physics::model::GRAVITY;

fn correlation(series: &Series, a: &[f64], b: &[f64]) -> f64 {
    let rows = (0..series.len()).filter(|i| series.moves(*i) && a[*i].is_finite() && b[*i].is_finite());
    let (mut n, mut sa, mut sb, mut saa, mut sbb, mut sab) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for i in rows {
        n += 1.0;
        sa += a[i];
        sb += b[i];
        saa += a[i] * a[i];
        sbb += b[i] * b[i];
        sab += a[i] * b[i];
    }
    let covariance = sab - sa * sb / n;
    let variances = (saa - sa * sa / n) * (sbb - sb * sb / n);
    if variances > 0.0 { covariance / variances.sqrt() } else { 0.0 }
}

/// Lateral taken for longitudinal acceleration and the other way round. Put right in the series.
pub(super) fn swapped_accelerations(series: &mut Series, report: &mut ChainReport) {
    let (lateral, longitudinal) = (Quantity::LateralAcceleration, Quantity::LongitudinalAcceleration);
    if !series.has(longitudinal) {
        return;
    }
    let (ay, ax) = (series.smooth(lateral), series.smooth(longitudinal));
    let curve = [correlation(series, &ay, &series.vr), correlation(series, &ax, &series.vr)];
    let thrust = [correlation(series, &ax, &series.v_dot), correlation(series, &ay, &series.v_dot)];
    let exchanged = |own: f64, other: f64| other.abs() > 0.6 && own.abs() < 0.5 * other.abs();
    if !(exchanged(curve[0], curve[1]) && exchanged(thrust[0], thrust[1])) {
        return;
    }
    report.findings.push(AuditFinding {
        effect: "channel_swap",
        channel: format!("{lateral}/{longitudinal}"),
        value: None,
        std: None,
        // Fisher's transform; a block of seconds says the same.
        t: curve[1].abs().min(0.9999).atanh() * (series.moving_seconds() / 3.0).sqrt(),
        evidence: format!(
            "correlation with speed x yaw rate: {:.2} and {:.2}, with the wheels' acceleration: {:.2} and {:.2}",
            curve[0], curve[1], thrust[1], thrust[0]
        ),
        confidence: Confidence::Certain,
        repair: format!("exchange the signals of {lateral} and {longitudinal}"),
        or: Vec::new(),
    });
    series.swap(lateral, longitudinal);
}

/// The longitudinal acceleration's sign. Put right in the series.
pub(super) fn signs(series: &mut Series, report: &mut ChainReport) {
    let quantity = Quantity::LongitudinalAcceleration;
    let Some(link) = link(series, Relation::Longitudinal).filter(|link| link.is_clear && link.is_negative)
    else {
        return;
    };
    report.findings.push(sign(
        quantity,
        (link.gain / link.gain_std).abs(),
        format!("{}: slope {:+.3} ± {:.3}", link.relation.name(), link.gain, link.gain_std),
    ));
    series.scale(quantity, -1.0);
}

fn sign(quantity: Quantity, t: f64, evidence: String) -> AuditFinding {
    AuditFinding {
        effect: "sensor_sign",
        channel: quantity.name().to_owned(),
        value: None,
        std: None,
        t,
        evidence,
        confidence: Confidence::Certain,
        repair: "multiply its gain by -1 (gain = -1.0 if there is none; its offset changes sign with it)"
            .into(),
        or: Vec::new(),
    }
}

/// The middle of the values at which a pedal is pressed.
fn middle_of_what_is_pressed(values: &[f64]) -> f64 {
    let most = values.iter().copied().fold(0.0, f64::max);
    let mut pressed: Vec<f64> = values.iter().copied().filter(|value| *value > PRESSED * most).collect();
    pressed.sort_by(f64::total_cmp);
    pressed.get(pressed.len() / 2).copied().unwrap_or(most)
}

/// Of the largest value; less is what a pedal says that nobody touches. Numerical.
const PRESSED: f64 = 0.03;

/// Drive torque and brake against the acceleration: sign and order of magnitude.
pub(super) fn torques(series: &Series, report: &mut ChainReport) {
    let vehicle = &series.vehicle;
    let radius = vehicle.wheel_radius_m.value;
    let mass = vehicle.mass() + 4.0 * vehicle.wheel_inertia_kgm2.value / radius.powi(2);
    let smooth_or_zero = |quantity: Quantity| {
        if series.has(quantity) { series.smooth(quantity) } else { vec![0.0; series.len()] }
    };
    let drive = smooth_or_zero(Quantity::DriveTorque);
    let pressure = smooth_or_zero(Quantity::BrakePressure);
    let torque = smooth_or_zero(Quantity::BrakeTorque);
    let per_bar = vehicle.brake_torque_per_bar_front_nm.zip(vehicle.brake_torque_per_bar_rear_nm);
    let per_bar_nm = per_bar.map_or(50.0, |(front, rear)| 2.0 * (front.value + rear.value));
    let to_a = 1.0 / (radius * mass);
    let drag = vehicle.drag_coefficient_kg_per_m;
    let priors =
        [FREE, FREE, FREE, (drag.value.max(0.3), 0.3), (-vehicle.rolling_resistance.value * GRAVITY, 0.5)];
    let fitted = |valid: &dyn Fn(usize) -> bool| {
        let rows = rows(series, &series.v_dot, 0.0, valid, |row| {
            let v = series.v[row];
            [
                drive[row] * vehicle.drive_torque_ratio.value * to_a,
                -pressure[row] * per_bar_nm * to_a,
                -torque[row] * to_a,
                -v * v / vehicle.mass(),
                1.0,
            ]
        });
        fit(&rows, priors)
    };
    let Some(fit) = fitted(&|_| true) else { return };
    let quantities = [Quantity::DriveTorque, Quantity::BrakePressure, Quantity::BrakeTorque];
    // What the vehicle's table leaves open is no error of the sensor.
    let share = |u: physics::model::Uncertain| u.std / u.value.abs();
    let open = [
        share(vehicle.drive_torque_ratio),
        per_bar.map_or(0.0, |(front, rear)| share(front).max(share(rear))),
        0.0,
    ];
    for (index, quantity) in quantities.into_iter().enumerate().filter(|(_, q)| series.has(*q)) {
        let (gain, std) = (fit.value[index], fit.std[index]);
        if !fit.is_significant(index) || fit.explained < TUNING.explained {
            report.unclear(
                format!("{quantity} against the car's acceleration"),
                "accelerate and brake firmly, several times, on a level road",
            );
            continue;
        }
        let evidence = format!("{gain:+.3} ± {std:.3} times the acceleration that it should give");
        let is_off = |gain: f64, std: f64| {
            gain.ln().abs() > TUNING.torque_map.max(2.0 * open[index]) && (gain - 1.0).abs() > 4.0 * std
        };
        // At the limit of the tires a car does not brake as hard as the pedal is pressed.
        let is_off_gently = || {
            let of = [&drive, &pressure, &torque][index];
            let gently = middle_of_what_is_pressed(of);
            let fit = fitted(&|row| of[row] <= gently).filter(|fit| fit.is_significant(index));
            fit.is_some_and(|fit| is_off(fit.value[index], fit.std[index]))
        };
        if gain < 0.0 {
            report.findings.push(sign(quantity, fit.t(index).abs(), evidence));
        } else if is_off(gain, std) && (quantity != Quantity::BrakePressure || per_bar.is_some()) {
            if quantity != Quantity::DriveTorque && !is_off_gently() {
                report.unclear(
                    format!(
                        "{quantity} against the car's acceleration: the harder it brakes, the less it obeys"
                    ),
                    "brake gently and firmly, several times, on a level dry road",
                );
                continue;
            }
            report.findings.push(AuditFinding {
                effect: "sensor_scale",
                channel: quantity.name().to_owned(),
                value: Some(1.0 / gain - 1.0),
                std: Some(std / (gain * gain)),
                t: (gain - 1.0).abs() / std,
                evidence,
                confidence: Confidence::Likely,
                repair: match quantity {
                    Quantity::DriveTorque => {
                        format!(
                            "[vehicle] drive_torque_ratio = {:.3}",
                            vehicle.drive_torque_ratio.value * gain
                        )
                    }
                    Quantity::BrakePressure => {
                        format!("multiply brake_torque_per_bar_front_nm and …_rear_nm by {gain:.2}")
                    }
                    _ => format!("multiply its gain by {gain:.3}"),
                },
                or: vec!["mass_kg, wheel_radius_m or the gear ratio is off".to_owned()],
            });
        }
    }
}
