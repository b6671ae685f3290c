//! What a simulated drive does: the ready scenarios, determinism, sensors.

use std::path::PathBuf;

use gripd::model::{Reading, Scenario, Simulation, TireKind, Truth, TruthWriter};
use gripd::{Micros, Quantity};

fn ready(name: &str) -> Scenario {
    let path =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("config/scenarios").join(format!("{name}.toml"));
    Scenario::parse(&std::fs::read_to_string(path).unwrap()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn drive(scenario: &Scenario, seed: u64) -> (Vec<Truth>, Vec<Reading>) {
    let mut simulation = Simulation::new(scenario, seed).unwrap();
    let (mut truth, mut readings) = (Vec::new(), Vec::new());
    while let Some(tick) = simulation.next_tick() {
        assert!(tick.readings.iter().all(|reading| reading.time <= tick.truth.time));
        assert!(tick.truth.is_finite(), "{:?}", tick.truth);
        truth.push(*tick.truth);
        readings.extend_from_slice(tick.readings);
    }
    (truth, readings)
}

fn of(readings: &[Reading], quantity: Quantity) -> Vec<Reading> {
    readings.iter().copied().filter(|reading| reading.quantity == quantity).collect()
}

fn mean_and_std(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (mean, (values.map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt())
}

/// A car on a straight road, with what a test adds.
fn car(duration_s: f64, speed: f64, rest: &str) -> Scenario {
    let text = format!(
        r#"
        duration_s = {duration_s}
        initial_speed_mps = {speed}
        vehicle.mass_kg = 1500
        vehicle.wheelbase_m = 2.7
        vehicle.cg_to_front_m = 1.2
        vehicle.wheel_radius_m = 0.3
        vehicle.steering_ratio = 15
        vehicle.driven_axle = "front"
        {rest}"#
    );
    Scenario::parse(&text).unwrap()
}

#[test]
fn the_thesis_cases_run_and_end_where_they_should() {
    let range = |truth: &[Truth], from: f64, to: f64| {
        let speeds =
            truth.iter().filter(|t| (from..to).contains(&t.time.seconds())).map(|t| t.longitudinal_velocity);
        speeds.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
    };
    let (sim1, _) = drive(&ready("sim1"), 1);
    let (low, high) = range(&sim1, 50.0, 200.0);
    assert!((13.0..16.0).contains(&low) && (19.0..23.0).contains(&high), "{low} to {high} m/s");
    assert!(sim1.iter().any(|t| t.mu_used > 0.99), "±0.1 rad at speed drives the tires into saturation");

    let (sim2, _) = drive(&ready("sim2"), 2);
    let same = sim1.iter().zip(&sim2).take_while(|(a, b)| a.yaw_rate == b.yaw_rate).count();
    assert!((9_999..=10_002).contains(&same), "the two part at 100 s, not at row {same}");
    let most = |from: f64, to: f64| {
        let rows = sim2.iter().filter(|t| (from..to).contains(&t.time.seconds()));
        rows.map(|t| t.mu_used).fold(0.0, f64::max)
    };
    assert!((most(100.0, 150.0) - 0.5).abs() < 1e-9 && most(150.0, 200.0) > 0.99);
    let halved = &sim2[12_000];
    assert!((halved.slope[0] - 25.0).abs() < 1e-9 && (halved.cornering_rear - 5.75).abs() < 1e-9);

    let (sim3, _) = drive(&ready("sim3"), 3);
    assert!(sim3.iter().all(|t| t.yaw_rate == 0.0 && t.lateral_velocity == 0.0));
    let used = sim3.iter().map(|t| t.mu_used).fold(0.0, f64::max);
    assert!((0.2..0.235).contains(&used), "300 N m use {used}");
}

/// Slope and offset of a driven wheel, by least squares over what the sensors say: μ = k (s − s0).
fn slope_and_offset(truth: &[Truth], readings: &[Reading], from: f64, to: f64) -> (f64, f64) {
    let front = of(readings, Quantity::WheelSpeedFl);
    let rear = of(readings, Quantity::WheelSpeedRl);
    let pairs: Vec<_> = front
        .iter()
        .zip(&rear)
        .filter(|(front, _)| (from..to).contains(&front.time.seconds()))
        .map(|(front, rear)| {
            // The wheel speeds are some 7 ms old.
            let row = &truth[((front.time.seconds() - 0.007) * 100.0).round() as usize];
            (row.fx[0] / row.fz[0], front.value / rear.value - 1.0)
        })
        .collect();
    let n = pairs.len() as f64;
    let (mu, slip) = (pairs.iter().map(|p| p.0).sum::<f64>() / n, pairs.iter().map(|p| p.1).sum::<f64>() / n);
    let covariance: f64 = pairs.iter().map(|p| (p.0 - mu) * (p.1 - slip)).sum();
    let variance: f64 = pairs.iter().map(|p| (p.0 - mu).powi(2)).sum();
    let compliance = covariance / variance;
    (1.0 / compliance, slip - compliance * mu)
}

#[test]
fn gravel_shows_in_the_measured_slip() {
    let scenario = ready("asphalt_gravel");
    let (truth, readings) = drive(&scenario, scenario.seed);
    for (from, to, expected) in [(0.0, 90.0, 95.0), (91.0, 180.0, 50.0), (181.0, 270.0, 95.0)] {
        let row = &truth[(from * 100.0) as usize + 100];
        assert_eq!(row.slope, [expected; 4]);
        assert!((row.slip_offset[0] - 0.015).abs() < 1e-12 && row.slip_offset[2].is_nan());
        let (slope, offset) = slope_and_offset(&truth, &readings, from, to);
        assert!((slope / expected - 1.0).abs() < 0.05, "{slope} against {expected}");
        assert!((offset - 0.015).abs() < 5e-4, "{offset}");
    }
    // The same drive on brush tires: their secant is less than their first slope (thesis 7.1).
    let mut brush = scenario.clone();
    brush.vehicle.tire = TireKind::Brush;
    let (brush_truth, brush_readings) = drive(&brush, scenario.seed);
    let (slope, _) = slope_and_offset(&brush_truth, &brush_readings, 91.0, 180.0);
    assert!((0.8..0.95).contains(&(slope / 50.0)), "{slope}");

    let mut used: Vec<_> = truth.iter().map(|t| (t.fx[0] / t.fz[0]).abs()).collect();
    used.sort_by(f64::total_cmp);
    let share = |share: f64| used[(share * used.len() as f64) as usize];
    assert!((0.03..0.1).contains(&share(0.5)), "median {}", share(0.5));
    assert!((0.12..0.25).contains(&share(0.95)), "95 % {}", share(0.95));
}

#[test]
fn the_demo_passes_three_surfaces_and_ends_in_an_abs_braking() {
    let scenario = ready("demo");
    let (truth, _) = drive(&scenario, scenario.seed);
    for (row, friction) in [(4_400, 1.0), (6_000, 0.6), (10_000, 0.2)] {
        assert!((truth[row].mu_max - friction).abs() < 1e-12);
    }
    let abs: Vec<_> = truth.iter().filter(|t| t.abs_active == 1.0).collect();
    assert!(abs.len() > 500 && abs[0].time > Micros::from_seconds(110.0));
    let seconds = abs.len() as f64 * 0.01;
    let deceleration = (abs[0].speed - abs[abs.len() - 1].speed) / seconds;
    // Friction, and what air and rolling add to it.
    assert!((1.0..1.15).contains(&(deceleration / (0.2 * 9.81))), "{deceleration} m/s²");
    assert!(abs.iter().all(|t| t.brake_active == 1.0 && t.brake_pressure > 1.0));
    assert!(abs.iter().filter(|t| t.speed > 3.0).all(|t| t.slip.iter().all(|slip| *slip > -0.3)));
    assert!(truth.iter().map(|t| t.sideslip.abs()).fold(0.0, f64::max) < 0.1, "it stays on the road");
    assert!(truth.iter().map(|t| t.lateral_acceleration.abs()).fold(0.0, f64::max) > 3.0, "and is no bore");
}

#[test]
fn traction_control_lets_spinning_wheels_go() {
    let fastest = |lets_go_at_slip: Option<f64>| {
        let mut scenario = ready("demo");
        scenario.duration_s = 10.0;
        scenario.initial_speed_mps = 5.0;
        scenario.road.drain(..2);
        scenario.road[0].from_s = 0.0;
        let driver = scenario.driver.as_mut().unwrap();
        driver.lets_go_at_slip = lets_go_at_slip;
        let (truth, _) = drive(&scenario, 1);
        let wheels = truth.iter().flat_map(|t| t.wheel_speed);
        (wheels.fold(0.0, f64::max) * scenario.vehicle.wheel_radius_m.value, truth[999].speed)
    };
    let ((spinning, slow), (held, fast)) = (fastest(None), fastest(Some(0.3)));
    assert!(spinning > 40.0 && held < 25.0, "{spinning} and {held} m/s");
    assert!(fast > slow - 1.0, "{fast} and {slow} m/s");
}

#[test]
fn with_any_seed_the_ready_drives_stay_on_the_road() {
    for name in ["demo", "asphalt_gravel"] {
        for seed in 10..18 {
            let (truth, _) = drive(&ready(name), seed);
            let sideslip = truth.iter().map(|t| t.sideslip.abs()).fold(0.0, f64::max);
            assert!(sideslip < 0.15, "{name}, seed {seed}: {sideslip} rad");
            assert!(truth.iter().all(|t| (1.0..35.0).contains(&t.speed)), "{name}, seed {seed}");
        }
    }
}

#[test]
fn a_seed_decides_everything() {
    let mut scenario = ready("demo");
    scenario.duration_s = 10.0;
    let (truth, readings) = drive(&scenario, 7);
    let (again, readings_again) = drive(&scenario, 7);
    assert!(readings == readings_again);
    assert!(
        truth.iter().zip(&again).all(|(a, b)| a
            .values()
            .iter()
            .zip(b.values())
            .all(|(a, b)| a.to_bits() == b.to_bits()))
    );
    let (other, other_readings) = drive(&scenario, 8);
    assert!(other.last().unwrap().speed != truth.last().unwrap().speed);
    assert!(other_readings != readings);
    // Taking one sensor away leaves the noise of the others as it was.
    scenario.sensors.by_name.remove("yaw_rate");
    let (_, fewer) = drive(&scenario, 7);
    assert_eq!(of(&fewer, Quantity::LateralAcceleration), of(&readings, Quantity::LateralAcceleration));
    assert!(of(&fewer, Quantity::YawRate).is_empty());
}

#[test]
fn readings_come_in_order_at_their_periods() {
    let mut scenario = ready("demo");
    scenario.duration_s = 20.0;
    let (_, readings) = drive(&scenario, 1);
    assert!(readings.windows(2).all(|pair| pair[0].time <= pair[1].time));
    let yaw = of(&readings, Quantity::YawRate);
    let lateral = of(&readings, Quantity::LateralAcceleration);
    assert_eq!(yaw.len(), 2000);
    assert!(
        yaw.iter().zip(&lateral).all(|(a, b)| a.time == b.time),
        "what travels together is late together"
    );
    // Late by half-normal jitter of 0.1 ms: 0.08 ms in the mean, and 20 ppm of clock.
    let late =
        yaw.iter().enumerate().map(|(i, r)| r.time.seconds() / (1.0 + 20e-6) - (5e-3 + 0.01 * i as f64));
    let (mean, std) = mean_and_std(late);
    assert!((mean - 0.08e-3).abs() < 0.01e-3 && (std - 0.06e-3).abs() < 0.01e-3, "{mean} {std}");
}

#[test]
fn a_sensor_makes_of_the_truth_what_its_table_says() {
    let scenario = car(
        100.0,
        20.0,
        "
        sensors.yaw_rate = { period_ms = 10, noise_std = 0.003, offset = 0.01 }
        sensors.lateral_acceleration = { period_ms = 10, noise_std = 0.07, quantum = 0.05 }
        sensors.vehicle_speed = { period_ms = 20, gain = 1.02 }
        sensors.wheel_speed = { period_ms = 10, noise_std = 0.05 }
        sensors.wheel_speed_fr = { period_ms = 40 }",
    );
    let (truth, readings) = drive(&scenario, 5);
    let speed = truth.last().unwrap().speed;
    let (mean, std) = mean_and_std(of(&readings, Quantity::YawRate).iter().map(|r| r.value));
    // 10⁴ draws: the mean is known to std/100, the std to std/141.
    assert!((mean - 0.01).abs() < 4.0 * 0.003 / 100.0 && (std / 0.003 - 1.0).abs() < 4.0 / 141.0);
    let lateral = of(&readings, Quantity::LateralAcceleration);
    assert!(lateral.iter().all(|r| ((r.value / 0.05).round() * 0.05 - r.value).abs() < 1e-12));
    let (_, std) = mean_and_std(lateral.iter().map(|r| r.value));
    let expected = (0.07f64.powi(2) + 0.05f64.powi(2) / 12.0).sqrt();
    assert!((std / expected - 1.0).abs() < 4.0 / 141.0, "{std}");
    // Noise of one reading tells nothing of the next, nor of another sensor.
    let lag = lateral.windows(2).map(|p| p[0].value * p[1].value).sum::<f64>() / 1e4;
    assert!(lag.abs() < 4.0 * std * std / 100.0, "{lag}");
    let vehicle_speed = of(&readings, Quantity::VehicleSpeed);
    assert_eq!(vehicle_speed.len(), 5001);
    assert!((vehicle_speed.last().unwrap().value / speed - 1.02).abs() < 1e-9);
    let fl = of(&readings, Quantity::WheelSpeedFl);
    let (mean, std) = mean_and_std(fl.iter().map(|r| r.value - 20.0 / 0.3));
    assert!(mean.abs() < 0.01 && (std / 0.05 - 1.0).abs() < 0.04, "{mean} {std}");
    assert_eq!(of(&readings, Quantity::WheelSpeedFr).len(), 2501);
}

#[test]
fn a_late_sensor_is_late_by_its_delay() {
    let scenario = car(
        20.0,
        20.0,
        r#"
        steering_wheel_angle = [{ kind = "sine", amplitude = 0.3, frequency_hz = 0.7 }]
        sensors.yaw_rate = { period_ms = 10, delay_ms = 50 }
        sensors.steering_wheel_angle = { period_ms = 10, delay_ms = 0.5 }"#,
    );
    let (truth, readings) = drive(&scenario, 1);
    for (i, reading) in of(&readings, Quantity::YawRate).iter().enumerate().skip(5) {
        assert!((reading.value - truth[i - 5].yaw_rate).abs() < 1e-12);
    }
    for reading in of(&readings, Quantity::SteeringWheelAngle).iter().skip(1) {
        let t = reading.time.seconds() - 0.5e-3;
        let expected = 0.3 * (std::f64::consts::TAU * 0.7 * t).sin();
        assert!((reading.value - expected).abs() < 1e-5, "{} {expected}", reading.value);
    }
}

#[test]
fn tooth_wheels_are_right_in_the_mean_and_repeat_with_the_revolution() {
    let scenario =
        car(60.0, 21.0, "sensors.wheel_speed = { period_ms = 10, tooth_wheel = { pitch_error_std = 0.01 } }");
    let (_, readings) = drive(&scenario, 2);
    let mut spreads = Vec::new();
    for wheel in gripd::Wheel::ALL {
        let speeds = of(&readings, Quantity::wheel_speed(wheel));
        // Four standard deviations, from the first reading on.
        let far = speeds.iter().find(|r| (r.value / 70.0 - 1.0).abs() > 0.01);
        assert_eq!(far, None);
        let (mean, std) = mean_and_std(speeds.iter().map(|r| r.value));
        assert!((mean / 70.0 - 1.0).abs() < 2e-4, "{mean}");
        spreads.push(std);
    }
    // Two tooth ends of 1 % of a pitch over the six pitches of 10 ms: √2 · 0.01/6 · 70 = 0.165 rad/s.
    assert!(spreads.iter().all(|std| (0.1..0.25).contains(std)), "{spreads:?}");
    assert!(spreads[0] != spreads[1], "each wheel has its own teeth");
}

#[test]
fn standing_rolling_back_and_parking_are_ordinary() {
    let all =
        "sensors.wheel_speed = { period_ms = 10, tooth_wheel = {} }\nsensors.yaw_rate = { period_ms = 10 }";
    let (truth, readings) = drive(&car(5.0, 0.0, all), 1);
    assert!(truth.iter().all(|t| t.speed == 0.0 && t.yaw_rate == 0.0 && t.x == 0.0));
    assert!(readings.iter().all(|r| r.value == 0.0));

    let reverse = format!(
        "steering_wheel_angle = [{{ kind = \"constant\", value = 3.0 }}]\n\
         drive_torque = [{{ kind = \"sine\", amplitude = 500, frequency_hz = 0.2 }}]\n{all}"
    );
    let (truth, _) = drive(&car(30.0, -4.0, &reverse), 1);
    assert!(truth[0].speed < 0.0 && truth[300].yaw_rate < 0.0, "reversing with the wheels left turns right");

    let stop = format!(
        "driver.speed_mps = [{{ kind = \"points\", points = [[0, 15], [2, 15], [8, 0], [15, 0], [25, 10]] }}]\n{all}"
    );
    let (truth, readings) = drive(&car(30.0, 15.0, &stop), 1);
    let parked = &truth[1400];
    assert!(parked.speed.abs() < 1e-6 && parked.wheel_speed == [0.0; 4], "{parked:?}");
    let parked = readings.iter().filter(|r| (13.0..15.0).contains(&r.time.seconds()));
    assert!(parked.clone().count() > 500 && parked.clone().all(|r| r.value.abs() < 1e-6));
    let end = truth.last().unwrap().speed;
    assert!((end - 10.0).abs() < 0.5, "drives off again to {end} m/s");
}

#[test]
fn the_driver_holds_the_speed_asked_for() {
    let scenario = car(
        60.0,
        15.0,
        r#"
        vehicle.drag_coefficient_kg_per_m = 0.4
        driver.speed_mps = [{ kind = "points", points = [[0, 15], [10, 25], [30, 25], [40, 10]] }]"#,
    );
    let (truth, _) = drive(&scenario, 1);
    for (row, speed) in [(1000, 25.0), (2900, 25.0), (5900, 10.0)] {
        assert!((truth[row].speed - speed).abs() < 0.5, "{} at row {row}", truth[row].speed);
    }
}

#[test]
fn one_slippery_side_turns_a_braking_car_to_the_other() {
    let scenario = car(
        3.0,
        20.0,
        r#"
        road = [{ friction = 0.8, right = { friction = 0.2 } }]
        abs = {}
        brake_torque = [{ kind = "ramp", from_s = 1.0, to_s = 1.2, value = 6000 }]"#,
    );
    let (truth, _) = drive(&scenario, 1);
    let braking = &truth[160];
    assert_eq!((braking.mu_max_left, braking.mu_max_right, braking.abs_active), (0.8, 0.2, 1.0));
    assert!((braking.mu_max - 0.5).abs() < 1e-12);
    assert!(braking.fx[0] < 2.0 * braking.fx[1] && braking.yaw_rate > 0.02, "{braking:?}");
}

#[test]
fn the_truth_is_written_as_csv() {
    let scenario = car(0.1, 20.0, "");
    let mut out = Vec::new();
    let mut writer = TruthWriter::new(&mut out).unwrap();
    let (truth, _) = drive(&scenario, 1);
    for row in &truth {
        writer.write(row).unwrap();
    }
    writer.into_inner().unwrap();
    let mut reader = csv::Reader::from_reader(out.as_slice());
    assert_eq!(reader.headers().unwrap().iter().collect::<Vec<_>>(), Truth::columns());
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 11);
    for (row, truth) in rows.iter().zip(&truth) {
        for (field, value) in row.iter().zip(truth.values()) {
            match field.parse::<f64>() {
                Ok(field) => assert!((field - value).abs() < 1e-9),
                Err(_) => assert!(field.is_empty() && value.is_nan()),
            }
        }
    }
}
