//! How each cause is made for a drive: how strong it is at factor one, and what a perfect answer would say.

use serde_json::{Value, json};

use super::car::Car;
use super::cause::{Cause, Sort};
use super::dice::Dice;
use super::drive::Plan;
use super::hidden::{Bump, Hidden, LoadTransfer, Patch};

/// A cause made concrete.
#[derive(Clone, Debug)]
pub struct Made {
    pub hidden: Hidden,
    /// Amplitude and unit as this generator has them.
    pub amplitude: f64,
    pub unit: &'static str,
    /// In the contract's parameter names, `Null` where it does not translate.
    pub parameters: Value,
    /// Where a local cause acts; empty for one that is there throughout.
    pub intervals: Vec<(f64, f64)>,
    pub accept: Vec<String>,
    pub fair: Vec<String>,
}

/// Windows apart from each other, placed where the plan excites what the cause needs.
fn windows(
    plan: &Plan,
    count: usize,
    length: (f64, f64),
    need: impl Fn(f64, f64) -> f64,
    dice: &mut Dice,
) -> Vec<(f64, f64)> {
    let mut tries: Vec<(f64, f64, f64)> = (0..60)
        .map(|_| {
            let duration = dice.between(length.0, length.1);
            let start = dice.between(5.0, plan.seconds - duration - 4.0);
            (need(start, start + duration) * dice.between(0.6, 1.0), start, start + duration)
        })
        .collect();
    tries.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut taken: Vec<(f64, f64)> = Vec::new();
    for (_, start, end) in tries {
        if taken.len() < count && taken.iter().all(|w| end + 4.0 < w.0 || start > w.1 + 4.0) {
            taken.push((start, end));
        }
    }
    taken.sort_by(|x, y| x.0.total_cmp(&y.0));
    taken
}

fn bumps(windows: &[(f64, f64)], amplitude: f64, dice: &mut Dice) -> Vec<Bump> {
    windows
        .iter()
        .map(|&(start, end)| Bump { start, end, amplitude: dice.sign() * amplitude * dice.between(0.7, 1.0) })
        .collect()
}

fn drift(amplitude: f64, dice: &mut Dice) -> Vec<(f64, f64, f64)> {
    (0..3)
        .map(|_| {
            let period = dice.between(25.0, 80.0);
            (
                amplitude * (2.0f64 / 3.0).sqrt(),
                std::f64::consts::TAU / period,
                dice.between(0.0, std::f64::consts::TAU),
            )
        })
        .collect()
}

fn rms(series: &[Bump], seconds: f64) -> f64 {
    // The mean square of sin⁴ is 3/8.
    (series.iter().map(|b| b.amplitude * b.amplitude * 0.375 * (b.end - b.start)).sum::<f64>() / seconds)
        .sqrt()
}

fn channel(name: &str) -> usize {
    match name {
        "yaw_rate" => 4,
        "lateral_acceleration" => 5,
        "longitudinal_acceleration" => 6,
        "steering_wheel_angle" => 7,
        other => panic!("no channel {other}"),
    }
}

/// Makes `cause` at `factor` times its ordinary strength, for a drive and a car, beside what is hidden already.
pub fn make((cause, factor): (&Cause, f64), plan: &Plan, car: &Car, beside: Hidden, dice: &mut Dice) -> Made {
    let mut h = beside;
    let mut parameters = Value::Null;
    let mut intervals: Vec<(f64, f64)> = Vec::new();
    let mut accept: Vec<String> =
        if cause.sort == Sort::Library { vec![cause.key.to_owned()] } else { Vec::new() };
    let mut fair: Vec<String> = Vec::new();
    let lateral = |s: f64, e: f64| plan.excitation(s, e).0;
    let any = |s: f64, e: f64| plan.excitation(s, e).0 + plan.excitation(s, e).1;
    let calm = |_: f64, _: f64| 1.0;
    let spread = dice.between(0.85, 1.15) * factor;
    let (effect, sensor) = cause.key.split_once(':').unwrap_or((cause.key, ""));
    let (amplitude, unit) = match effect {
        "control" => (0.0, ""),
        "load_transfer" => {
            let height = 0.55 * spread;
            h.load_transfer =
                Some(LoadTransfer { height, front_share: dice.between(0.5, 0.6), peak_load: 2.0 });
            parameters = json!({ "cg_height_m": height });
            (height, "m")
        }
        "body_roll" => {
            h.roll_leak = 0.006 * spread;
            parameters = json!({ "roll_gain_rad_per_mps2": h.roll_leak });
            fair.push("sensor_scale:lateral_acceleration".into());
            (h.roll_leak, "rad/(m/s2)")
        }
        "roll_steer" => {
            h.roll_steer = 0.25 * spread;
            h.roll_gain = 0.006;
            parameters = json!({ "roll_steer_rad_per_rad": h.roll_steer });
            (h.roll_steer, "rad/rad")
        }
        "road_bank" => {
            let w = windows(plan, 3 + dice.below(2), (5.0, 9.0), calm, dice);
            h.bank = bumps(&w, 0.035 * spread, dice);
            intervals = w;
            parameters = json!({ "bank_rms_rad": rms(&h.bank, plan.seconds) });
            (0.035 * spread, "rad")
        }
        "road_grade" => {
            let w = windows(plan, 3 + dice.below(2), (6.0, 13.0), calm, dice);
            h.grade = bumps(&w, 0.025 * spread, dice);
            intervals = w;
            parameters = json!({ "grade_rms_rad": rms(&h.grade, plan.seconds) });
            (0.025 * spread, "rad")
        }
        "air_drag" => {
            h.drag = 0.38 * spread;
            parameters = json!({ "drag_coefficient_kg_per_m": h.drag });
            (h.drag, "kg/m")
        }
        "rolling_resistance" => {
            h.rolling = 0.012 * spread;
            parameters = json!({ "coefficient": h.rolling });
            (h.rolling, "-")
        }
        "relaxation_length" => {
            h.relaxation = 0.5 * spread;
            parameters = json!({ "length_m": h.relaxation });
            (h.relaxation, "m")
        }
        "steering_lag" => {
            h.steering_lag = 0.07 * spread;
            parameters = json!({ "time_constant_s": h.steering_lag });
            (h.steering_lag, "s")
        }
        "steering_compliance" => {
            // A third of the steer angle lost to the column at full linear force.
            h.compliance = 0.35 * spread / (super::physics::TRAIL * car.cornering[0]);
            parameters = json!({ "compliance_rad_per_nm": h.compliance });
            (h.compliance, "rad/Nm")
        }
        "steering_ratio" => {
            h.ratio_curvature = 0.20 * spread;
            parameters = json!({ "curvature_per_rad2": h.ratio_curvature });
            (h.ratio_curvature, "1/rad2")
        }
        "rear_steer" => {
            // 5° at the rear beside 33° at the front; makers pass through none at 50 to 65 km/h.
            let (ratio, crossover) = (0.15 * spread, dice.between(14.0, 18.0));
            h.rear_steer = Some((ratio, crossover));
            parameters = json!({ "low_speed_ratio": ratio, "crossover_speed_mps": crossover });
            (ratio, "rad/rad")
        }
        "sensor_delay" => {
            let delay = 0.05 * spread;
            h.faults[channel(sensor)].delay = delay;
            parameters = json!({ "delay_s": delay });
            (delay, "s")
        }
        "sensor_scale" => {
            let error = dice.sign() * 0.08 * spread;
            h.faults[channel(sensor)].scale = error;
            parameters = json!({ "relative_error": error });
            (error, "-")
        }
        "sensor_drift" => {
            let size = spread * [0.006, 0.20, 0.15, 0.03][channel(sensor) - 4];
            let fault = &mut h.faults[channel(sensor)];
            fault.drift = drift(size, dice);
            // What came of it within the drive; the sines' size is that of an endless one.
            let every = 0.1;
            let count = (plan.seconds / every) as usize;
            let square = (0..count).map(|i| fault.wander(every * i as f64).powi(2)).sum::<f64>();
            parameters = json!({ "drift_rms": (square / count as f64).sqrt() });
            (size, "SI")
        }
        "sensor_bias" => {
            let size = dice.sign() * spread * [0.012, 0.25, 0.20, 0.04][channel(sensor) - 4];
            let when = dice.between(0.3, 0.7) * plan.seconds;
            h.faults[channel(sensor)].step = Some((when, size));
            intervals = vec![(when, plan.seconds)];
            parameters = json!({ "bias": size });
            (size, "SI")
        }
        "sensor_sign" => {
            h.faults[channel(sensor)].negative = true;
            (1.0, "-")
        }
        "channel_swap" => {
            let names = ["fl", "fr", "rl", "rr"];
            let (i, j) = *dice.pick(&[(0, 1), (2, 3), (0, 2), (1, 3), (0, 3), (1, 2)]);
            h.swap = Some((i, j));
            accept = vec![format!("channel_swap:wheel_speed_{}/wheel_speed_{}", names[i], names[j])];
            (1.0, "-")
        }
        "tire_radius" => {
            let wheel = dice.below(4);
            let error = -0.006 * spread;
            h.radius_error[wheel] = error;
            let name = ["fl", "fr", "rl", "rr"][wheel];
            fair.push(format!("sensor_scale:wheel_speed_{name}"));
            parameters = json!({ format!("relative_difference_{name}"): error });
            (error, "-")
        }
        "radius_growth" => {
            h.radius_growth = 2.5e-5 * spread;
            parameters = json!({ "relative_per_mps_squared": h.radius_growth });
            (h.radius_growth, "1/(m/s)2")
        }
        "cg_shift" => {
            let when = dice.between(0.35, 0.65) * plan.seconds;
            let shift = 0.08 * spread;
            h.cg_shift = Some((when, shift));
            intervals = vec![(when, plan.seconds)];
            parameters = json!({ "shift_m": shift, "at_s": when });
            (shift, "m")
        }
        "payload" => {
            h.payload = 0.32 * car.mass * spread;
            parameters = json!({ "mass_kg": h.payload });
            (h.payload, "kg")
        }
        "friction_change" => {
            let w = windows(plan, 3, (4.0, 7.0), any, dice);
            let friction = 0.35 / spread;
            h.friction_patches =
                w.iter().map(|&(start, end)| Patch { start, end, left: friction, right: friction }).collect();
            intervals = w;
            parameters = json!({ "friction": friction });
            (friction, "-")
        }
        "friction_split" => {
            // Where the car turns and hardly brakes: nobody countersteers here.
            let w =
                windows(plan, 3, (4.0, 7.0), |s, e| lateral(s, e) - 2.0 * (any(s, e) - lateral(s, e)), dice);
            let low = 0.35 / spread;
            let left_low = dice.chance(0.5);
            // The other side stays as it is.
            let (left, right) = if left_low { (low, f64::INFINITY) } else { (f64::INFINITY, low) };
            h.friction_patches = w.iter().map(|&(start, end)| Patch { start, end, left, right }).collect();
            intervals = w;
            parameters = json!({ if left_low { "friction_left" } else { "friction_right" }: low });
            if let Some(high) = car.friction {
                parameters[if left_low { "friction_right" } else { "friction_left" }] = json!(high);
            }
            (low, "-")
        }
        "tire_saturation" => {
            let friction = 0.92 / spread;
            h.saturation = Some(friction).filter(|mu| mu.is_finite());
            parameters = json!({ "friction": friction });
            (friction, "-")
        }
        "combined_slip" => {
            h.ellipse = Some((spread, 0.95));
            parameters = json!({ "ellipse_factor": spread });
            (spread, "-")
        }
        "surface_stiffness" => {
            let w = windows(plan, 3, (5.0, 9.0), any, dice);
            let loss = 1.0 - 0.4 * spread;
            let value = loss.max(0.15);
            h.stiffness_patches =
                w.iter().map(|&(start, end)| Patch { start, end, left: value, right: value }).collect();
            intervals = w;
            parameters = json!({ "stiffness_factor": value });
            (value, "-")
        }
        "brake_yaw_moment" => {
            let w = windows(plan, 5, (0.5, 1.2), calm, dice);
            intervals = w.clone();
            let moment = 500.0 * spread;
            let mut peak = moment;
            if dice.chance(0.5) {
                // A brake on one front wheel.
                for &(start, end) in &w {
                    let torque = moment * car.radius * 2.0 / car.track[0];
                    h.esp.push((dice.below(2), Bump { start, end, amplitude: torque }));
                }
            } else {
                let axle = if car.front_driven { 0 } else { 1 };
                // ±T/2 on the two wheels, half a track apart: M = T t/(2 R).
                let torque = 2.0 * car.radius / car.track[axle];
                h.vectoring = bumps(&w, torque * moment, dice);
                peak = h.vectoring.iter().map(|bump| bump.amplitude.abs()).fold(0.0, f64::max) / torque;
            }
            parameters = json!({ "moment_peak_nm": peak });
            (moment, "Nm")
        }
        "brake_imbalance" => {
            let axle = usize::from(dice.chance(0.3));
            let left_more = dice.sign() * 0.15 * spread;
            h.brake_imbalance[axle] = left_more;
            parameters = json!({ ["left_more_front", "left_more_rear"][axle]: left_more });
            (left_more, "-")
        }
        "accelerometer_position" => {
            h.accelerometer_at = dice.sign() * 0.7 * spread;
            parameters = json!({ "forward_of_cg_m": h.accelerometer_at });
            (h.accelerometer_at, "m")
        }
        "crosswind" => {
            let w = windows(plan, 5, (1.5, 4.5), calm, dice);
            h.wind = bumps(&w, 500.0 * spread, dice);
            h.wind_at = dice.between(0.2, 0.45);
            intervals = w;
            parameters = json!({ "force_rms_n": rms(&h.wind, plan.seconds) });
            (500.0 * spread, "N")
        }
        "wheel_alignment" => {
            let toe = 0.014 * spread;
            // Toe-in of the front axle: the left wheel points right, the right one left.
            h.toe = [-toe, toe, 0.0, 0.0];
            parameters = json!({ "toe_rad": toe });
            (toe, "rad")
        }
        "everything" => {
            h.load_transfer = Some(LoadTransfer { height: 0.55 * spread, front_share: 0.55, peak_load: 2.0 });
            h.roll_leak = 0.005 * spread;
            h.roll_steer = 0.10 * spread;
            h.roll_gain = 0.005;
            h.relaxation = 0.4 * spread;
            h.drag = 0.35 * spread;
            h.rolling = 0.010 * spread;
            h.ellipse = Some((spread, 0.95));
            accept = [
                "load_transfer",
                "body_roll",
                "roll_steer",
                "relaxation_length",
                "air_drag",
                "rolling_resistance",
                "combined_slip",
            ]
            .map(String::from)
            .to_vec();
            fair.push("sensor_scale:lateral_acceleration".into());
            (spread, "x physical")
        }
        "freeplay" => {
            h.freeplay = 0.04 * spread;
            (h.freeplay, "rad sw")
        }
        "slosh" => {
            h.slosh = 0.10 * car.mass * spread;
            (h.slosh, "kg")
        }
        "shimmy" => {
            h.shimmy = 150.0 * spread;
            (h.shimmy, "Nm")
        }
        "brake_judder" => {
            h.judder = 0.5 * spread;
            (h.judder, "-")
        }
        "differential_lock" => {
            h.lock = 120.0 * spread;
            (h.lock, "Nm")
        }
        "sensor_clip" => {
            // Yaw rate or lateral acceleration, at a share of what the drive aims at.
            let peak = plan.lateral.iter().fold(0.0f64, |m, a| m.max(a.abs()));
            let speed = plan.speed.iter().sum::<f64>() / plan.speed.len() as f64;
            let share = (1.0 - 0.45 * spread).max(0.2);
            if dice.chance(0.5) {
                h.faults[5].clip = Some(share * peak);
            } else {
                h.faults[4].clip = Some(share * peak / speed);
            }
            (share, "of peak")
        }
        "torque_limit" => {
            let limit = car.mass * car.radius * (2.2 - 1.1 * spread).max(0.3);
            h.torque_limit = Some(limit);
            (limit, "Nm")
        }
        "payload_within_doubt" => {
            h.payload = 0.03 * car.mass * spread;
            accept = vec!["payload".into()];
            parameters = json!({ "mass_kg": h.payload });
            (h.payload, "kg")
        }
        "radius_within_doubt" => {
            h.radius_growth = 1.0e-6 * spread;
            accept = vec!["radius_growth".into()];
            parameters = json!({ "relative_per_mps_squared": h.radius_growth });
            (h.radius_growth, "1/(m/s)2")
        }
        other => panic!("no recipe for {other}"),
    };
    Made { hidden: h, amplitude, unit, parameters, intervals, accept, fair }
}
