//! Simulated drives of cars with names of all kinds, and with none.

use std::fmt::Write as _;

use gripd::Quantity;
use gripd::propose::Confidence;

use super::car::{Car, DRIVE};
use super::{all_right, gripd, live, of_files, tell};

#[test]
fn a_car_with_names_is_found_and_sure() {
    let car = Car::german();
    let proposal = car.propose();
    all_right(&car, &proposal);
    for quantity in Quantity::ALL.into_iter().filter(|q| Quantity::basic(u16::MAX) & q.bit() != 0) {
        assert_eq!(proposal.choice(quantity).unwrap().confidence, Confidence::Sure, "{quantity}");
    }
    let counted = live(&proposal, Quantity::DriveTorque).unwrap();
    assert_eq!((counted.counter.len(), counted.counter_modulo), (1, None));
}

#[test]
fn sensors_that_are_the_wrong_way_round_are_turned() {
    for turned in [
        &[Quantity::YawRate][..],
        &[Quantity::LateralAcceleration, Quantity::LongitudinalAcceleration],
        &[Quantity::SteeringWheelAngle, Quantity::YawRate],
    ] {
        let mut car = Car::german();
        for quantity in turned {
            car.of(*quantity).gain = -1.0;
        }
        all_right(&car, &car.propose());
    }
}

#[test]
fn units_that_the_file_lacks_or_has_wrong_come_from_the_drive() {
    let mut car = Car::german();
    for (quantity, factor, unit, truth) in [
        (Quantity::YawRate, 0.0002, "", "rad/s"),
        (Quantity::LateralAcceleration, 0.002, "g", "m/s^2"),
        (Quantity::SteeringWheelAngle, 0.001, "deg", "rad"),
    ] {
        let line = car.of(quantity);
        (line.factor, line.unit, line.truth) = (factor, unit, Some(truth));
    }
    all_right(&car, &car.propose());
}

#[test]
fn wheels_whose_names_are_exchanged_are_exchanged_back() {
    // One axle; then both, which three sensors are against.
    let exchanged = [&[(0, 1)][..], &[(2, 3)], &[(0, 1), (2, 3)]];
    for pairs in exchanged {
        let mut car = Car::german();
        for (left, right) in pairs {
            let name = car.lines[*left].name;
            car.lines[*left].name = car.lines[*right].name;
            car.lines[*right].name = name;
        }
        let proposal = car.propose();
        all_right(&car, &proposal);
        assert_eq!(proposal.notes.len(), pairs.len(), "{:?}", proposal.notes);
    }
}

#[test]
fn a_car_without_names_is_known_by_its_drive() {
    let car = Car::nameless();
    let proposal = car.propose();
    tell(&proposal);
    for quantity in Quantity::ALL.into_iter().take(8) {
        let Some(mapped) = live(&proposal, quantity) else { panic!("{quantity} is not found") };
        assert_eq!(mapped.signals, [car.place(quantity)], "{quantity}");
        assert!(proposal.choice(quantity).unwrap().confidence < Confidence::Sure, "{quantity}");
    }
    // Torque and pressure do not follow a law of their own: nothing is made up.
    assert!(
        live(&proposal, Quantity::DriveTorque).is_none()
            && live(&proposal, Quantity::BrakePressure).is_none()
    );
}

#[test]
fn a_name_that_lies_is_reported_and_what_is_right_is_found() {
    let mut car = Car::german();
    car.of(Quantity::YawRate).name = "Wert_3";
    car.of(Quantity::BrakePressure).name = "Giergeschwindigkeit";
    (car.of(Quantity::BrakePressure).unit, car.of(Quantity::BrakePressure).truth) = ("", Some("bar"));
    let proposal = car.propose();
    tell(&proposal);
    assert_eq!(live(&proposal, Quantity::YawRate).unwrap().signals, ["Sensor_2.Wert_3"]);
    let yaw_rate = proposal.choice(Quantity::YawRate).unwrap();
    assert_eq!(yaw_rate.contradicted[0].signal, "Antrieb_1.Giergeschwindigkeit");
    assert_eq!(yaw_rate.names, 0.0);
}

#[test]
fn what_is_not_there_is_not_found() {
    let mut car = Car::german();
    car.lines.retain(|line| {
        line.quantity != Quantity::LongitudinalAcceleration && line.quantity != Quantity::YawRate
    });
    let proposal = {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("car.dbc"), car.dbc()).unwrap();
        of_files(&folder.path().join("car.dbc"), &[])
    };
    tell(&proposal);
    assert_eq!(proposal.missing(), [[Quantity::YawRate]]);
    for quantity in [Quantity::LongitudinalAcceleration, Quantity::BrakeActive, Quantity::VehicleSpeed] {
        assert!(live(&proposal, quantity).is_none(), "{quantity}");
    }
}

#[test]
fn a_drive_straight_on_leaves_it_at_the_names() {
    let car = Car::german();
    let folder = tempfile::tempdir().unwrap();
    let straight = DRIVE.replace("[[steering_wheel_angle]]\n    kind = \"points\"", "[[unused]]").to_owned();
    let start = straight.find("[[unused]]").unwrap();
    let end = straight.find("[sensors]").unwrap();
    let straight = format!("{}{}", &straight[..start], &straight[end..]);
    let (dbc, log) = car.record(folder.path(), &straight);
    let proposal = of_files(&dbc, &[log]);
    tell(&proposal);
    let yaw_rate = proposal.choice(Quantity::YawRate).unwrap();
    assert_eq!(yaw_rate.confidence, Confidence::Likely);
    assert_eq!(yaw_rate.mapping.as_ref().unwrap().gain, None);
    // Speed and its change are told all the same.
    assert_eq!(proposal.choice(Quantity::LongitudinalAcceleration).unwrap().confidence, Confidence::Sure);
    let mut nameless = Car::nameless();
    nameless.messages = car.messages;
    let folder = tempfile::tempdir().unwrap();
    let (dbc, log) = nameless.record(folder.path(), &straight);
    let proposal = of_files(&dbc, &[log]);
    tell(&proposal);
    assert!(Quantity::ALL[..7].iter().all(|q| live(&proposal, *q).is_none()), "a guess");
}

#[test]
fn a_sign_in_a_bit_of_its_own_is_found_by_name_and_by_drive() {
    // Amount and sign are written as two signals; nothing but the drive says which bit belongs to it in the second.
    for [amount, sign] in [["Gierrate", "Gierrate_VZ"], ["S3", "B7"]] {
        let mut car = Car::german();
        car.of(Quantity::YawRate).name = amount;
        let folder = tempfile::tempdir().unwrap();
        let (dbc, truth) = (folder.path().join("car.dbc"), folder.path().join("truth.toml"));
        let bits = format!(
            " SG_ {amount} : 0|15@1+ (0.01,0) [0|0] \"\" B\n SG_ {sign} : 15|1@1+ (1,0) [0|1] \"\" B\n"
        );
        let whole = format!(" SG_ {amount} : 0|16@1- (0.01,0) [0|0] \"Grad/s\" B\n");
        let text = car.dbc();
        assert!(text.contains(&whole));
        std::fs::write(&dbc, text.replace(&whole, &bits)).unwrap();
        let written = format!("signal = \"Sensor_2.{amount}\", sign = \"Sensor_2.{sign}\", unit = \"deg/s\"");
        let text = car.truth().replace(&format!("signal = \"Sensor_2.{amount}\""), &written);
        std::fs::write(&truth, text).unwrap();
        let (drive, log) = (folder.path().join("drive.toml"), folder.path().join("drive.log"));
        std::fs::write(&drive, DRIVE).unwrap();
        let simulated = gripd(&[&"simulate", &drive, &"-c", &truth, &"-o", &log]);
        assert!(simulated.status.success(), "{}", String::from_utf8_lossy(&simulated.stderr));
        let proposal = of_files(&dbc, &[log]);
        tell(&proposal);
        let mapped = live(&proposal, Quantity::YawRate).unwrap();
        assert_eq!(mapped.signals, [format!("Sensor_2.{amount}")]);
        assert_eq!(mapped.sign, Some(format!("Sensor_2.{sign}")));
        assert_eq!((mapped.gain, mapped.unit.as_deref()), (None, Some("deg/s")));
    }
}

#[test]
fn comments_name_what_names_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let dbc = folder.path().join("car.dbc");
    let mut text = Car::nameless().dbc();
    for (message, signal, comment) in [
        (0x130, "S11", "yaw rate, positive to the left"),
        (0x130, "S12", "angle of the steering wheel"),
        (0x120, "S02", "front right wheel speed"),
        (0x120, "S07", "front left wheel speed"),
        (0x120, "S05", "rear left wheel speed"),
        (0x120, "S01", "rear right wheel speed"),
    ] {
        writeln!(text, "CM_ SG_ {message} {signal} \"{comment}\";").unwrap();
    }
    std::fs::write(&dbc, text).unwrap();
    let proposal = of_files(&dbc, &[]);
    tell(&proposal);
    for (quantity, name) in [
        (Quantity::WheelSpeedFl, "M1.S07"),
        (Quantity::WheelSpeedRr, "M1.S01"),
        (Quantity::YawRate, "M2.S11"),
        (Quantity::SteeringWheelAngle, "M2.S12"),
    ] {
        assert_eq!(live(&proposal, quantity).unwrap().signals, [name]);
    }
}

#[test]
fn a_long_recording_takes_no_more_memory_and_says_the_same() {
    let car = Car::german();
    let folder = tempfile::tempdir().unwrap();
    let (dbc, log) = car.record(folder.path(), DRIVE);
    // An hour: whole stretches are left out.
    let proposal = of_files(&dbc, &vec![log; 24]);
    all_right(&car, &proposal);
    let seconds = proposal.driven_s.unwrap();
    assert!((300.0..1300.0).contains(&seconds), "{seconds}");
}

/// GIVEN a car of whose speed only one signal tells THEN what turns confirms one another, and is turned the right way.
#[test]
fn without_wheels_the_vehicles_speed_tells() {
    let mut car = Car::german();
    car.of(Quantity::LateralAcceleration).gain = -1.0;
    let folder = tempfile::tempdir().unwrap();
    let (dbc, log) = car.record(folder.path(), DRIVE);
    let text = std::fs::read_to_string(&dbc).unwrap();
    // A wheel's revolutions as the speed of the car: 2π/60 · 0.316 m · 3.6.
    let mut speed = text.replace(
        "Raddrehz_VL : 0|16@1- (0.05,0) [0|0] \"U/min\"",
        "Fzg_Geschw : 0|16@1- (0.0059565,0) [0|0] \"km/h\"",
    );
    assert_ne!(speed, text);
    speed = speed.lines().filter(|line| !line.contains("Raddrehz")).collect::<Vec<_>>().join("\n");
    std::fs::write(&dbc, speed).unwrap();
    let proposal = of_files(&dbc, &[log]);
    tell(&proposal);
    for quantity in [Quantity::VehicleSpeed, Quantity::YawRate, Quantity::SteeringWheelAngle] {
        assert_eq!(proposal.choice(quantity).unwrap().confidence, Confidence::Sure, "{quantity}");
        assert_eq!(live(&proposal, quantity).unwrap().gain, None, "{quantity}");
    }
    assert_eq!(live(&proposal, Quantity::LateralAcceleration).unwrap().gain, Some(-1.0));
    assert!(live(&proposal, Quantity::BrakePressure).is_some());
    assert!(proposal.notes.is_empty(), "{:?}", proposal.notes);
}

/// GIVEN a rear axle that is locked THEN its wheels are not exchanged, and the front ones tell the yaw rate.
#[test]
fn a_locked_axle_is_left_out_and_not_exchanged() {
    let car = Car::german();
    let folder = tempfile::tempdir().unwrap();
    let (dbc, log) = car.record(folder.path(), DRIVE);
    let text = std::fs::read_to_string(&log).unwrap();
    let mut alternating = false;
    let locked: Vec<String> = text
        .lines()
        .map(|line| match line.split_once(" 120#") {
            // Rear left and rear right are bytes 4 and 5, 6 and 7; one step apart, so that they are two sensors.
            Some((head, data)) if data.len() >= 16 => {
                let low = u8::from_str_radix(&data[8..10], 16).unwrap();
                alternating = !alternating;
                let other = low ^ u8::from(alternating);
                format!("{head} 120#{}{other:02X}{}", &data[..12], &data[10..12])
            }
            _ => line.to_owned(),
        })
        .collect();
    std::fs::write(&log, locked.join("\n")).unwrap();
    all_right(&car, &of_files(&dbc, &[log]));
}

/// GIVEN a yaw rate that reads twice what it should THEN it is taken with doubt: what is called so and turns with the car
/// is one.
#[test]
fn a_sensor_whose_scale_is_wrong_is_taken_with_doubt() {
    let car = Car::german();
    let folder = tempfile::tempdir().unwrap();
    let (dbc, log) = car.record(folder.path(), DRIVE);
    let text = std::fs::read_to_string(&dbc).unwrap();
    let twice = text.replace("(0.01,0) [0|0] \"Grad/s\"", "(0.02,0) [0|0] \"Grad/s\"");
    assert_ne!(twice, text);
    std::fs::write(&dbc, twice).unwrap();
    let proposal = of_files(&dbc, &[log]);
    tell(&proposal);
    let yaw_rate = proposal.choice(Quantity::YawRate).unwrap();
    assert_eq!(yaw_rate.confidence, Confidence::Unsure);
    assert_eq!(live(&proposal, Quantity::YawRate).unwrap().signals, [car.place(Quantity::YawRate)]);
    // The wheels tell how the car turned all the same.
    assert_eq!(proposal.choice(Quantity::LateralAcceleration).unwrap().confidence, Confidence::Sure);
}
