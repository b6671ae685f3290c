//! Real files and recordings, where they are there.

use std::path::{Path, PathBuf};

use gripd::dbc::Database;
use gripd::propose::Confidence;
use gripd::{Config, Quantity};

use super::{live, of_files, tell};

/// What a reader of the eight real DBC files would take, one of those beside `|`; `-` where there is nothing.
const REAL: [(&str, [&str; 14]); 8] = [
    (
        "fca_giorgio.dbc",
        [
            "ABS_1.WHEEL_SPEED_FL",
            "ABS_1.WHEEL_SPEED_FR",
            "ABS_1.WHEEL_SPEED_RL",
            "ABS_1.WHEEL_SPEED_RR",
            "ABS_2.YAW_RATE",
            "ABS_2.LATERAL_ACCEL",
            "EPS_1.STEERING_ANGLE",
            "ABS_2.LONG_ACCEL",
            "-",
            "-",
            "-",
            "NEW_MSG_11C.VEHICLE_SPEED",
            "ABS_3.BRAKE_PEDAL_SWITCH",
            "-",
        ],
    ),
    (
        "ford_lincoln_base_pt.dbc",
        [
            "WheelSpeed.WhlFl_W_Meas",
            "WheelSpeed.WhlFr_W_Meas",
            "WheelSpeed.WhlRl_W_Meas",
            "WheelSpeed.WhlRr_W_Meas",
            "Yaw_Data_FD1.VehYaw_W_Actl|BrakeSnData_3.VehYawComp_W_Actl",
            "Accel_Data_FD1.VehLat2_A_Actl|BrakeSnData_3.VehLatComp_A_Actl",
            "SteeringPinion_Data.StePinComp_An_Est",
            "Accel_Data_FD1.VehLong2_A_Actl|BrakeSnData_3.VehLongComp_A_Actl",
            "VehicleOperatingModes.PrplWhlTot2_Tq_Actl",
            "BrakeSnData_4.BrkTot_Tq_Actl",
            "-",
            "BrakeSysFeatures.Veh_V_ActlBrk|BrakeSnData_3.VehOverGnd_V_Est",
            "Gear_Shift_by_Wire_FD1.BrkSwtchPos_B_ActlGsm|-",
            "DesiredTorqBrk.AbsActv_B_Actl",
        ],
    ),
    (
        "hyundai_2015_ccan.dbc",
        [
            "WHL_SPD11.WHL_SPD_FL",
            "WHL_SPD11.WHL_SPD_FR",
            "WHL_SPD11.WHL_SPD_RL",
            "WHL_SPD11.WHL_SPD_RR",
            "ESP12.YAW_RATE",
            "ESP12.LAT_ACCEL",
            "SAS11.SAS_Angle",
            "ESP12.LONG_ACCEL",
            "-",
            "-",
            "ESP12.CYL_PRES",
            "EMS11.VS|TCU12.VS_TCU|EMS14.EMS_VS",
            "TCS13.DriverBraking|TCS13.BrakeLight",
            "TCS11.ABS_ACT|ABS11.ABS_ACT",
        ],
    ),
    (
        "hyundai_canfd_generated.dbc",
        [
            "WHEEL_SPEEDS.WHL_SpdFLVal",
            "WHEEL_SPEEDS.WHL_SpdFRVal",
            "WHEEL_SPEEDS.WHL_SpdRLVal",
            "WHEEL_SPEEDS.WHL_SpdRRVal",
            "IMU_01_10ms.IMU_YawRtVal|ESC_02_10ms.ESC_YawRtVal",
            "IMU_01_10ms.IMU_LatAccelVal|ESC_02_10ms.ESC_LatAccelVal",
            "STEERING_SENSORS.STEERING_ANGLE",
            "IMU_01_10ms.IMU_LongAccelVal|ESC_02_10ms.ESC_LongAccelVal",
            "-",
            "-",
            "-",
            "-",
            "ESP_STATUS.BRAKE_PRESSED|BRAKE.BRAKE_PRESSED|TCS.DriverBraking",
            "-",
        ],
    ),
    (
        "tesla_model3_party.dbc",
        [
            "ESP_wheelSpeeds.ESP_wheelSpeedFrL",
            "ESP_wheelSpeeds.ESP_wheelSpeedFrR",
            "ESP_wheelSpeeds.ESP_wheelSpeedReL",
            "ESP_wheelSpeeds.ESP_wheelSpeedReR",
            "-",
            "-",
            "SCCM_steeringAngleSensor.SCCM_steeringAngle",
            "-",
            "DI_torque.DI_torqueActual",
            "-",
            "-",
            "ESP_B.ESP_vehicleSpeed|DI_speed.DI_vehicleSpeed",
            "ESP_status.ESP_brakeApply|ESP_status.ESP_brakeLamp",
            "-",
        ],
    ),
    (
        "toyota_nodsu_pt_generated.dbc",
        [
            "WHEEL_SPEEDS.WHEEL_SPEED_FL",
            "WHEEL_SPEEDS.WHEEL_SPEED_FR",
            "WHEEL_SPEEDS.WHEEL_SPEED_RL",
            "WHEEL_SPEEDS.WHEEL_SPEED_RR",
            "KINEMATICS.YAW_RATE",
            "KINEMATICS.ACCEL_Y",
            "STEER_ANGLE_SENSOR.STEER_ANGLE",
            "KINEMATICS.ACCEL_X",
            "-",
            "-",
            "-",
            "SPEED.SPEED",
            "PCM_CRUISE_2.BRAKE_PRESSED|BRAKE_2.BRAKE_PRESSED|BRAKE_MODULE.BRAKE_PRESSED",
            "-",
        ],
    ),
    (
        "vw_mqb.dbc",
        [
            "ESP_19.ESP_VL_Radgeschw_02",
            "ESP_19.ESP_VR_Radgeschw_02",
            "ESP_19.ESP_HL_Radgeschw_02",
            "ESP_19.ESP_HR_Radgeschw_02",
            "ESP_02.ESP_Gierrate",
            "ESP_02.ESP_Querbeschleunigung",
            "LWI_01.LWI_Lenkradwinkel",
            "ESP_02.ESP_Laengsbeschl",
            "-",
            "-",
            "ESP_05.ESP_Bremsdruck",
            "ESP_21.ESP_v_Signal",
            "ESP_05.ESP_Fahrer_bremst|Motor_14.MO_Fahrer_bremst",
            "ESP_21.ABS_Bremsung",
        ],
    ),
    (
        "vw_pq.dbc",
        [
            "Bremse_3.Radgeschw__VL_4_1",
            "Bremse_3.Radgeschw__VR_4_1",
            "Bremse_3.Radgeschw__HL_4_1",
            "Bremse_3.Radgeschw__HR_4_1",
            "Bremse_5.BR5_Giergeschw",
            "Bremse_2.Querbeschleunigung",
            "Lenkwinkel_1.LW1_LRW",
            "Bremse_8.BR8_Laengsbeschl",
            "-",
            "-",
            "Bremse_5.BR5_Bremsdruck|Bremse_6.Bremsdruck__Bremse_6_",
            "Bremse_1.BR1_Rad_kmh",
            "Motor_2.MO2_BLS|Bremse_8.BR8_Fa_bremst",
            "Bremse_1.BR1_ABS_Brems",
        ],
    ),
];

#[test]
fn eight_real_files_by_their_names() {
    let Some(folder) = testing::shared("dbc") else { return };
    let mut wrong = Vec::new();
    for (file, expected) in REAL {
        let proposal = of_files(&folder.join(file), &[]);
        for (quantity, expected) in Quantity::ALL.into_iter().zip(expected) {
            let found = live(&proposal, quantity).map_or("-", |mapped| mapped.signals[0].as_str());
            if !expected.split('|').any(|name| name == found) {
                wrong.push(format!("{file}: {quantity} is {found} for {expected}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn what_stands_beside_the_values_of_real_files_is_found() {
    let Some(folder) = testing::shared("dbc") else { return };
    let beside = |file: &str, quantity| {
        let proposal = of_files(&folder.join(file), &[]);
        let mapped = live(&proposal, quantity).unwrap().clone();
        (
            mapped.sign.unwrap_or_default(),
            mapped.valid.join(" "),
            mapped.valid_when,
            mapped.unit.unwrap_or_default(),
        )
    };
    let text = |sign: &str, valid: &str, when: &[u64], unit: &str| {
        (sign.to_owned(), valid.to_owned(), when.to_vec(), unit.to_owned())
    };
    assert_eq!(
        beside("vw_mqb.dbc", Quantity::YawRate),
        text("ESP_02.ESP_VZ_Gierrate", "ESP_02.ESP_QBit_Gierrate", &[0], "")
    );
    assert_eq!(
        beside("vw_mqb.dbc", Quantity::SteeringWheelAngle),
        text("LWI_01.LWI_VZ_Lenkradwinkel", "LWI_01.LWI_QBit_Lenkradwinkel", &[0], "")
    );
    assert_eq!(beside("vw_pq.dbc", Quantity::YawRate), text("Bremse_5.BR5_Vorzeichen", "", &[], ""));
    assert_eq!(
        beside("ford_lincoln_base_pt.dbc", Quantity::YawRate),
        text("", "Yaw_Data_FD1.VehYawWActl_D_Qf", &[3], "")
    );
    assert_eq!(beside("hyundai_2015_ccan.dbc", Quantity::YawRate), text("", "", &[], "deg/s"));
    let toyota = of_files(&folder.join("toyota_nodsu_pt_generated.dbc"), &[]);
    assert_eq!(
        live(&toyota, Quantity::SteeringWheelAngle).unwrap().signals,
        ["STEER_ANGLE_SENSOR.STEER_ANGLE", "STEER_ANGLE_SENSOR.STEER_FRACTION"]
    );
    assert_eq!(live(&toyota, Quantity::WheelSpeedFl).unwrap().valid, ["WHEEL_SPEEDS.WHEEL_SPEED_FL_FAULT"]);
}

#[test]
fn the_rav4_is_mapped_as_it_was_by_hand() {
    let Some(folder) = testing::shared("recordings") else { return };
    let rav4 = folder.join("rav4");
    let proposal = of_files(&rav4.join("_toyota_2017.dbc"), &[rav4.join("bus0.log.gz")]);
    tell(&proposal);
    // config/rav4.toml names the same bits otherwise: what counts are places and signs.
    let by_hand = Config::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("config/rav4.toml")).unwrap();
    let (own, theirs) =
        (by_hand.input_database().unwrap(), Database::load(&rav4.join("_toyota_2017.dbc")).unwrap());
    for (quantity, config) in &by_hand.signals.quantities {
        let Some(mapped) = live(&proposal, *quantity) else { panic!("{quantity} is not found") };
        let names: Vec<&String> = config.signal.iter().chain(config.sum.iter().flatten()).collect();
        let place = |database: &Database, name: &str| {
            let (message, signal) = database.signal(name).unwrap();
            (message.id, signal.start_bit, signal.size)
        };
        let by_hand: Vec<_> = names.iter().map(|name| place(&own, name)).collect();
        let proposed: Vec<_> = mapped.signals.iter().map(|name| place(&theirs, name)).collect();
        assert_eq!(proposed, by_hand, "{quantity}");
        assert_eq!(mapped.gain, config.gain, "the sign of {quantity}");
    }
}

#[test]
fn the_zoe_and_the_car_on_the_proving_ground_are_mapped() {
    let Some(folder) = testing::shared("recordings") else { return };
    let mut zoe: Vec<PathBuf> =
        std::fs::read_dir(folder.join("zoe")).unwrap().map(|entry| entry.unwrap().path()).collect();
    zoe.retain(|path| path.to_string_lossy().ends_with(".log.gz"));
    zoe.sort();
    let names = [
        (Quantity::WheelSpeedFl, "WHEEL_SPEEDS.WheelSpeedFL"),
        (Quantity::WheelSpeedFr, "WHEEL_SPEEDS.WheelSpeedFR"),
        (Quantity::WheelSpeedRl, "WHEEL_SPEEDS.WheelSpeedRL"),
        (Quantity::WheelSpeedRr, "WHEEL_SPEEDS.WheelSpeedRR"),
        (Quantity::YawRate, "INERTIAL.YawRate"),
        (Quantity::LateralAcceleration, "INERTIAL.LateralAcceleration"),
        (Quantity::SteeringWheelAngle, "STEERING.SteeringWheelAngle"),
    ];
    let dbc = folder.join("recording.dbc");
    let zoe = of_files(&dbc, &zoe);
    tell(&zoe);
    let ground = of_files(&dbc, &[folder.join("revsted/obd.log.gz")]);
    tell(&ground);
    for (quantity, name) in names {
        for proposal in [&zoe, &ground] {
            assert_eq!(live(proposal, quantity).unwrap().signals, [name]);
            assert_eq!(proposal.choice(quantity).unwrap().confidence, Confidence::Sure, "{quantity}");
        }
        assert_eq!(live(&zoe, quantity).unwrap().gain, None, "{quantity}");
        let turned = quantity == Quantity::LateralAcceleration;
        assert_eq!(live(&ground, quantity).unwrap().gain, turned.then_some(-1.0), "{quantity}");
    }
    // The accelerometer's zero, known to be 5.17 m/s² off, to half a m/s²; torque of the motor, none of the brakes.
    let offset = live(&zoe, Quantity::LateralAcceleration).unwrap().offset.unwrap();
    assert!((offset - 5.17).abs() < 0.5, "{offset}");
    assert_eq!(live(&zoe, Quantity::DriveTorque).unwrap().signals, ["POWERTRAIN.DriveTorque"]);
    for absent in [Quantity::BrakePressure, Quantity::BrakeTorque, Quantity::VehicleSpeed] {
        assert!(live(&zoe, absent).is_none(), "{absent}");
    }
    for absent in [Quantity::LongitudinalAcceleration, Quantity::DriveTorque, Quantity::VehicleSpeed] {
        assert!(live(&ground, absent).is_none(), "{absent}");
    }
}

#[test]
fn another_cars_file_is_not_believed() {
    let (Some(files), Some(recordings)) = (testing::shared("dbc"), testing::shared("recordings")) else {
        return;
    };
    let log = recordings.join("rav4/bus0.log.gz");
    for file in ["vw_mqb", "vw_pq", "hyundai_2015_ccan", "ford_lincoln_base_pt", "tesla_model3_party"] {
        let proposal = of_files(&files.join(format!("{file}.dbc")), std::slice::from_ref(&log));
        tell(&proposal);
        for choice in &proposal.quantities {
            assert!(
                choice.confidence <= Confidence::Unsure,
                "{file}: {} {:?}",
                choice.quantity,
                choice.mapping
            );
        }
        assert!(!proposal.missing().is_empty(), "{file}");
        assert_eq!(proposal.notes.len(), 1, "{file}: {:?}", proposal.notes);
    }
}
