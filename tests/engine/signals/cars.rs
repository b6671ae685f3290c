//! Mappings of real cars, and those that are shipped.

use std::path::Path;

use gripd::dbc::Database;
use gripd::signals::{Inputs, Outputs};
use gripd::{Config, Quantity};
use testing::small_car as car;

/// Mappings of the needed signals of real cars: they must compile against the real files.
#[test]
fn real_files_can_be_mapped() {
    let Some(folder) = testing::shared("dbc") else { return };
    let cars = [
        (
            "vw_pq.dbc",
            r#"
            wheel_speed_fl = "Bremse_3.Radgeschw__VL_4_1"
            wheel_speed_fr = "Bremse_3.Radgeschw__VR_4_1"
            wheel_speed_rl = "Bremse_3.Radgeschw__HL_4_1"
            wheel_speed_rr = "Bremse_3.Radgeschw__HR_4_1"
            yaw_rate = { signal = "Bremse_5.BR5_Giergeschw", sign = "Bremse_5.BR5_Vorzeichen", valid = "Bremse_5.BR5_Sta_Gierrate" }
            lateral_acceleration = "Bremse_2.Querbeschleunigung"
            steering_wheel_angle = { signal = "Lenkwinkel_1.LW1_LRW", sign = "Lenkwinkel_1.LW1_LRW_Sign", not_available = 0x7FFF, counter = "Lenkwinkel_1.LW1_Zaehler" }
        "#,
        ),
        (
            "hyundai_2015_ccan.dbc",
            r#"
            wheel_speed_fl = { signal = "WHL_SPD11.WHL_SPD_FL", counter = ["WHL_SPD11.WHL_SPD_AliveCounter_LSB", "WHL_SPD11.WHL_SPD_AliveCounter_MSB"] }
            wheel_speed_fr = "WHL_SPD11.WHL_SPD_FR"
            wheel_speed_rl = "WHL_SPD11.WHL_SPD_RL"
            wheel_speed_rr = "WHL_SPD11.WHL_SPD_RR"
            yaw_rate = { signal = "ESP12.YAW_RATE", unit = "deg/s", valid = ["ESP12.YAW_RATE_STAT", "ESP12.YAW_RATE_DIAG"] }
            lateral_acceleration = { signal = "ESP12.LAT_ACCEL", counter = "ESP12.ESP12_AliveCounter" }
            steering_wheel_angle = "SAS11.SAS_Angle"
            brake_pressure = "ESP12.CYL_PRES"
        "#,
        ),
        (
            "hyundai_canfd_generated.dbc",
            r#"
            wheel_speed_fl = "WHEEL_SPEEDS.WHL_SpdFLVal"
            wheel_speed_fr = "WHEEL_SPEEDS.WHL_SpdFRVal"
            wheel_speed_rl = "WHEEL_SPEEDS.WHL_SpdRLVal"
            wheel_speed_rr = "WHEEL_SPEEDS.WHL_SpdRRVal"
            yaw_rate = { signal = "IMU_01_10ms.IMU_YawRtVal", valid = "IMU_01_10ms.IMU_YawSigSta" }
            lateral_acceleration = "IMU_01_10ms.IMU_LatAccelVal"
            steering_wheel_angle = "STEERING_SENSORS.STEERING_ANGLE"
        "#,
        ),
        (
            "ford_lincoln_base_pt.dbc",
            r#"
            wheel_speed_fl = "WheelSpeed.WhlFl_W_Meas"
            wheel_speed_fr = "WheelSpeed.WhlFr_W_Meas"
            wheel_speed_rl = "WheelSpeed.WhlRl_W_Meas"
            wheel_speed_rr = "WheelSpeed.WhlRr_W_Meas"
            yaw_rate = { signal = "Yaw_Data_FD1.VehYaw_W_Actl", valid = "Yaw_Data_FD1.VehYawWActl_D_Qf", valid_when = 3 }
            lateral_acceleration = "BrakeSnData_3.VehLatComp_A_Actl"
            steering_wheel_angle = { signal = "SteeringPinion_Data.StePinComp_An_Est", valid = "SteeringPinion_Data.StePinCompAnEst_D_Qf", valid_when = 3 }
        "#,
        ),
        (
            "tesla_model3_party.dbc",
            r#"
            wheel_speed_fl = { signal = "ESP_wheelSpeeds.ESP_wheelSpeedFrL", valid = "ESP_B.ESP_wheelSpeedsQF", valid_when = 1, counter = "ESP_wheelSpeeds.ESP_wheelSpeedsCounter" }
            wheel_speed_fr = "ESP_wheelSpeeds.ESP_wheelSpeedFrR"
            wheel_speed_rl = "ESP_wheelSpeeds.ESP_wheelSpeedReL"
            wheel_speed_rr = "ESP_wheelSpeeds.ESP_wheelSpeedReR"
            steering_wheel_angle = "SCCM_steeringAngleSensor.SCCM_steeringAngle"
        "#,
        ),
        (
            "fca_giorgio.dbc",
            r#"
            wheel_speed_fl = "ABS_1.WHEEL_SPEED_FL"
            wheel_speed_fr = "ABS_1.WHEEL_SPEED_FR"
            wheel_speed_rl = "ABS_1.WHEEL_SPEED_RL"
            wheel_speed_rr = "ABS_1.WHEEL_SPEED_RR"
            yaw_rate = "ABS_2.YAW_RATE"
            lateral_acceleration = "ABS_2.LATERAL_ACCEL"
            steering_wheel_angle = "EPS_1.STEERING_ANGLE"
        "#,
        ),
    ];
    for (file, text) in cars {
        let database = Database::load(&folder.join(file)).unwrap();
        // Outputs, because not every file has all that Inputs requires.
        let outputs = Outputs::compile(&car::config(text), &database, 0.32);
        assert!(outputs.is_ok(), "{file}: {}", outputs.unwrap_err());
    }
}

/// A shipped configuration.
fn shipped(name: &str) -> Config {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("config").join(name);
    Config::load(&path).unwrap_or_else(|e| panic!("{e}"))
}

fn inputs(config: &Config, database: &Database) -> Inputs {
    let radius = config.vehicle.wheel_radius_m.value;
    Inputs::compile(&config.signals, database, radius).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn shipped_configurations_fit_their_dbc_files() {
    for name in ["demo.toml", "rav4.toml", "thesis.toml"] {
        let config = shipped(name);
        let database = config.input_database().unwrap();
        assert_eq!(database.warnings(), &[], "{name}");
        inputs(&config, &database);
    }
}

#[test]
fn the_volkswagen_example_fits_a_real_mqb_file() {
    let Some(path) = testing::shared("dbc/vw_mqb.dbc") else { return };
    let inputs = inputs(&shipped("vw_mqb.toml"), &Database::load(&path).unwrap());
    assert!(inputs.has(Quantity::BrakePressure));
}

#[test]
fn the_demo_car_can_be_simulated_with_all_its_quantities() {
    let config = shipped("demo.toml");
    let database = config.input_database().unwrap();
    let outputs = Outputs::compile(&config.signals, &database, config.vehicle.wheel_radius_m.value).unwrap();
    let wanted = [Quantity::DriveTorque, Quantity::BrakePressure, Quantity::AbsActive, Quantity::YawRate];
    assert!(wanted.into_iter().all(|quantity| outputs.has(quantity)));
}
