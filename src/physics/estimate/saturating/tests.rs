use super::*;
use crate::estimates::Estimate;
use crate::model::{Scenario, Simulation, Vehicle};
use crate::{Quantity, Sample};

/// That is known but the data sheet.
fn nothing() -> Known {
    let offset = Estimate { value: 0.0, std: 1e-3, age_s: 0.0 };
    Known { stiffness: [None; 2], offsets: [offset; 3], is_braked: false }
}

/// Drives with this friction and steers to and fro, the wheel turned by so much (rad); what is left of each friction at the end,
/// and how often there was evidence.
fn left(friction: f64, steering: f64, sheet: impl Fn(&mut Vehicle)) -> (Likelihood, usize) {
    let scenario = Scenario::parse(&format!(
        "duration_s = 20.0\nseed = 1\ninitial_speed_mps = 15.0\n\
         [driver]\n[[driver.speed_mps]]\nkind = \"constant\"\nvalue = 15.0\n\
         [[steering_wheel_angle]]\nkind = \"sine\"\namplitude = {steering}\nfrequency_hz = 0.3\n\
         [vehicle]\n{}[[road]]\nfrom_s = 0.0\nfriction = {friction}\n",
        toml::to_string(&Vehicle { tire: crate::model::TireKind::MagicFormula, ..Vehicle::thesis() })
            .unwrap()
    ))
    .unwrap();
    let mut vehicle = Vehicle::thesis();
    sheet(&mut vehicle);
    let car = Car::new(&vehicle);
    let mut tires = SaturatingTires::new(&car, 4.0);
    let nothing = nothing();
    let (mut last, mut count) = (None, 0);
    let mut simulation = Simulation::new(&scenario, 1).unwrap();
    let mut before = None;
    while let Some(tick) = simulation.next_tick() {
        let truth = tick.truth;
        let elapsed_s = truth.time.seconds() - before.unwrap_or(truth.time.seconds() - 0.01);
        if elapsed_s < 0.0099 {
            continue;
        }
        before = Some(truth.time.seconds());
        let mut sample = Sample::empty(truth.time, elapsed_s);
        for (quantity, value) in [
            (Quantity::VehicleSpeed, truth.longitudinal_velocity),
            (Quantity::YawRate, truth.yaw_rate),
            (Quantity::LateralAcceleration, truth.lateral_acceleration),
            (Quantity::SteeringWheelAngle, truth.steering_wheel_angle),
        ] {
            sample.set(quantity, value);
        }
        let mut heard = super::super::kinematics::Heard::default();
        heard.hear(&sample);
        let now = Kinematics::of(&sample, &car, heard);
        let motion = LateralMotion {
            lateral_velocity: truth.lateral_velocity,
            lateral_velocity_std: 0.02,
            slip_angles: [truth.slip_angle_front, truth.slip_angle_rear],
        };
        tires.step(&now, Some(truth.longitudinal_acceleration), Some(motion), &nothing, [0.003, 0.07]);
        if let Some(likelihood) = tires.likelihood() {
            (last, count) = (Some(likelihood), count + 1);
        }
    }
    (last.unwrap(), count)
}

#[test]
fn tires_near_their_limit_leave_no_higher_friction() {
    let (left, count) = left(0.4, 0.08, |_| ());
    assert!(count > 300, "{count}");
    assert!(left.of(0.4) > 0.2, "{left:?}");
    assert!(left.of(0.7) < 0.02 && left.of(1.0) < 0.02, "{left:?}");
    // What is below is not its business.
    assert_eq!(left.of(0.1), 1.0);
}

#[test]
fn gentle_steering_says_nothing_even_of_tires_softer_than_the_sheet() {
    for stiffer in [1.0, 1.3] {
        let (left, _) = left(0.9, 0.02, |sheet| {
            for stiffness in [&mut sheet.lateral_stiffness_front, &mut sheet.lateral_stiffness_rear] {
                stiffness.value *= stiffer;
            }
        });
        for friction in [0.3, 0.6, 0.9, 1.2] {
            assert!(left.of(friction) > 0.3, "{stiffer} {friction}: {left:?}");
        }
    }
}

#[test]
fn another_road_and_a_stop_leave_no_evidence() {
    let car = Car::new(&Vehicle::thesis());
    let mut tires = SaturatingTires::new(&car, 4.0);
    tires.evidence[3][1] = -5.0;
    tires.surface_changed();
    assert!(tires.evidence.as_flattened().iter().all(|evidence| *evidence == 0.0));
    let standing = Sample::empty(crate::Micros(0), 0.01);
    tires.driving_s = 7.0;
    let nothing = nothing();
    tires.step(&Kinematics::new(&standing, &car), None, None, &nothing, [0.003, 0.07]);
    assert_eq!((tires.driving_s, tires.likelihood()), (0.0, None));
}
