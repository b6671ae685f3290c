//! GIVEN real, damaged and hostile DBC files WHEN they are loaded THEN all that is usable is there, and
//! everything else is named by its line.

use std::time::{Duration, Instant};

use gripd::can::CanId;
use gripd::dbc::{Database, DbcError, LookupError};
use proptest::prelude::*;

fn parse(text: &str) -> Result<Database, DbcError> {
    Database::parse(text.as_bytes(), "test.dbc")
}

fn warnings(database: &Database) -> Vec<(usize, &str)> {
    database.warnings().iter().map(|w| (w.line, w.message.as_str())).collect()
}

/// File, messages, signals, lines of the warnings, and signals that an estimator needs from it.
type Expected = (&'static str, usize, usize, &'static [usize], &'static [&'static str]);

const REAL: [Expected; 8] = [
    (
        "fca_giorgio.dbc",
        36,
        155,
        &[228],
        &["ABS_1.WHEEL_SPEED_FL", "ABS_1.WHEEL_SPEED_RR", "ABS_2.LATERAL_ACCEL", "ABS_2.YAW_RATE"],
    ),
    (
        "ford_lincoln_base_pt.dbc",
        331,
        2150,
        &[],
        &["WheelSpeed.WhlFl_W_Meas", "WheelSpeed.WhlRr_W_Meas", "SteeringPinion_Data.StePinComp_An_Est"],
    ),
    (
        "hyundai_2015_ccan.dbc",
        113,
        1154,
        &[],
        &["WHL_SPD11.WHL_SPD_FL", "WHL_SPD11.WHL_SPD_AliveCounter_MSB", "ESP12.LAT_ACCEL", "SAS11.SAS_Angle"],
    ),
    (
        "hyundai_canfd_generated.dbc",
        88,
        761,
        &[],
        &["WHEEL_SPEEDS.WHL_SpdFLVal", "IMU_01_10ms.IMU_YawRtVal", "IMU_01_10ms.IMU_LatAccelVal"],
    ),
    (
        "tesla_model3_party.dbc",
        21,
        240,
        &[],
        &[
            "ESP_wheelSpeeds.ESP_wheelSpeedFrL",
            "SCCM_steeringAngleSensor.SCCM_steeringAngle",
            "ESP_B.ESP_wheelSpeedsQF",
        ],
    ),
    (
        "toyota_nodsu_pt_generated.dbc",
        60,
        380,
        &[],
        &[
            "WHEEL_SPEEDS.WHEEL_SPEED_FL",
            "KINEMATICS.YAW_RATE",
            "KINEMATICS.ACCEL_Y",
            "STEER_ANGLE_SENSOR.STEER_ANGLE",
            "STEER_ANGLE_SENSOR.STEER_FRACTION",
        ],
    ),
    (
        "vw_mqb.dbc",
        113,
        1348,
        &[],
        &[
            "ESP_02.ESP_Gierrate",
            "ESP_02.ESP_VZ_Gierrate",
            "ESP_02.ESP_QBit_Gierrate",
            "LWI_01.LWI_Lenkradwinkel",
            "LWI_01.LWI_VZ_Lenkradwinkel",
            "ESP_19.ESP_VL_Radgeschw_02",
            "ESP_19.ESP_VR_Radgeschw_02",
            "ESP_19.ESP_HL_Radgeschw_02",
            "ESP_19.ESP_HR_Radgeschw_02",
        ],
    ),
    (
        "vw_pq.dbc",
        86,
        1317,
        &[553, 554, 555, 556, 557, 558, 559, 560, 561, 562, 563, 564, 565, 566],
        &["Bremse_2.Querbeschleunigung", "Bremse_3.Radgeschw__VL_4_1", "Bremse_5.BR5_Giergeschw"],
    ),
];

#[test]
fn every_real_file_loads_and_names_what_it_cannot_use() {
    let Some(folder) = testing::shared("dbc") else { return };
    for (file, messages, signals, lines, needed) in REAL {
        let database = Database::load(&folder.join(file)).unwrap();
        assert_eq!(database.messages().len(), messages, "{file}");
        assert_eq!(database.messages().iter().map(|m| m.signals.len()).sum::<usize>(), signals, "{file}");
        assert_eq!(database.warnings().iter().map(|w| w.line).collect::<Vec<_>>(), lines, "{file}");
        for name in needed {
            database.signal(name).unwrap_or_else(|error| panic!("{file}: {error}"));
        }
    }
}

#[test]
fn a_truncated_identifier_does_not_take_the_place_of_another() {
    let Some(folder) = testing::shared("dbc") else { return };
    let database = Database::load(&folder.join("fca_giorgio.dbc")).unwrap();
    assert!(database.message("CAM_UNKNOWN_6").is_none());
    assert_eq!(database.message_with_id(CanId::standard(0x1E).unwrap()), None);
    let error = database.signal("CAM_UNKNOWN_6.x").unwrap_err().to_string();
    assert!(error.contains("fca_giorgio.dbc:228: ") && error.contains("0x1E36001E"), "{error}");
}

#[test]
fn a_multiplexed_signal_is_there_only_on_its_page() {
    let Some(folder) = testing::shared("dbc") else { return };
    let database = Database::load(&folder.join("vw_pq.dbc")).unwrap();
    let (_, lateral) = database.signal("Bremse_2.Querbeschleunigung").unwrap();
    assert_eq!(lateral.decode(&[227, 0, 0, 0, 0, 0, 0, 0]), Some(227.0 * 0.01 - 1.27));
    assert_eq!(lateral.decode(&[227, 1, 0, 0, 0, 0, 0, 0]), None);
}

#[test]
fn the_damaged_file_loses_only_what_is_damaged() {
    let database = Database::load(&testing::data("damaged.dbc")).unwrap();
    let names: Vec<_> = database.messages().iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["Good", "Collides", "TwoSelectors", "AfterTheDamage"]);
    let signals: Vec<_> = database.messages()[0].signals.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(signals, ["first", "wrong_range"]);
    let expected = [
        (3, "not a DBC statement"),
        (6, "signal `garbled` skipped: cannot be parsed"),
        (
            7,
            "`Good.beyond` skipped: its 8 bits from start bit 60 (Intel) are not within the message's 8 bytes",
        ),
        (8, "`Good.motorola_beyond` skipped: its 9 bits from start bit 56 (Motorola)"),
        (9, "`Good.no_size` skipped: a size of 0 bits"),
        (10, "`Good.too_wide` skipped: a size of 65 bits"),
        (11, "`Good.no_factor` skipped: a factor of 0"),
        (12, "`Good.infinite` skipped: a factor of inf"),
        (13, "`Good.first` skipped: its name is already taken by the signal of line 5"),
        (14, "`Good.short_float` skipped: line 35 makes it a 32-bit float, but it has 16 bits"),
        (15, "`Good.orphan` skipped: it is multiplexed, but the message has no usable selector"),
        (17, "`TooWide` skipped: identifier 506855454 (0x1E36001E) is wider than a standard"),
        (21, "`TwelveBits` skipped: identifier 2048"),
        (22, "`ThirtyBits` skipped: identifier 3758096384 (0xE0000000) is wider than an extended"),
        (23, "`SameId` skipped: identifier 001 is already taken by the message of line 4"),
        (24, "`Good` skipped: its name is already taken by the message of line 4"),
        (25, "`VeryLong` skipped: 65 bytes"),
        (26, "`NoNumber` skipped"),
        (27, "`HugeNumber` skipped"),
        (31, "`TwoSelectors.whose` skipped: the message has several selectors"),
        (32, "`TwoSelectors.circle1` skipped: its selectors select each other in a circle"),
        (33, "`TwoSelectors.circle2` skipped: its selectors select each other in a circle"),
        (34, "`TwoSelectors.stranger` skipped: line 38 names `nobody` as its selector"),
        (40, "a quoted text is not closed"),
        (44, "SIG_VALTYPE_ statement ignored: message 005 has no signal `fein`"),
    ];
    let found = warnings(&database);
    for ((line, text), (found_line, found_text)) in expected.iter().zip(&found) {
        assert!(
            line == found_line && found_text.contains(text),
            "{line}: {text}\n{found_line}: {found_text}"
        );
    }
    assert_eq!(found.len(), expected.len());
    // What belongs to a skipped message must not stick to one with the same truncated identifier, and
    // what follows an open quotation mark is still read.
    assert_eq!(database.signal("Collides.x").unwrap().1.values, []);
    assert_eq!(database.signal("Good.wrong_range").unwrap().1.value_named("not_available"), Some(255));
    assert_eq!(
        database.signal("Good.wrong_range").unwrap().1.decode(&[0, 0, 0, 200, 0, 0, 0, 0]),
        Some(200.0)
    );
}

#[test]
fn texts_names_kinds_and_codes_of_the_peculiar_file() {
    let database = Database::load(&testing::data("peculiar.dbc")).unwrap();
    assert_eq!(warnings(&database), []);
    assert_eq!(database.signal("Intel.Temperature").unwrap().1.unit, "°C");
    let long = "ShortenedNameOfThisMessage_WhichIsLongerThan32.ShortenedNameOfThisSignal_WhichIsLongerThan32";
    assert!(database.signal(long).is_ok());
    assert!(database.message("VECTOR__INDEPENDENT_SIG_MSG").is_none());
    let fd: Vec<_> = database.messages().iter().filter(|m| m.is_fd).map(|m| m.name.as_str()).collect();
    assert_eq!(fd, ["Intel", "Floats", "Fd"], "by VFrameFormat or by length");
    let last = database.signal("Intel.Last").unwrap().1;
    assert_eq!((last.value_named("not_available"), last.value_named("no such")), (Some(15), None));
    assert_eq!(database.signal("Intel.Temperature").unwrap().1.value_named("not_available"), Some(0x80));
    let twin = database.message_with_id(CanId::extended(100).unwrap()).unwrap();
    assert_eq!(twin.name, "ExtendedTwin");
    assert_eq!(database.message_with_id(CanId::standard(100).unwrap()).unwrap().name, "Motorola");
}

#[test]
fn wrong_names_get_the_nearest_ones() {
    let database = Database::load(&testing::data("peculiar.dbc")).unwrap();
    let text = |name: &str| database.signal(name).unwrap_err().to_string();
    assert_eq!(text("Temperature"), "`Temperature` names no signal; write MESSAGE.Signal");
    assert_eq!(text("intel.Odd"), "no message `intel` in the DBC; did you mean Intel?");
    assert_eq!(
        text("Intel.Temprature"),
        "no signal `Temprature` in message `Intel`; did you mean Intel.Temperature?"
    );
    assert_eq!(
        text("Motorola.Twin"),
        "no signal `Twin` in message `Motorola`; did you mean ExtendedTwin.Twin?"
    );
    assert!(matches!(database.signal("Nothing.like.it"), Err(LookupError::UnknownMessage { .. })));
}

#[test]
fn several_files_are_one_database_and_the_first_wins() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let a = write("a.dbc", "BO_ 1 A: 1 X\n SG_ s : 0|8@1+ (1,0) [0|0] \"\" X\nBO_ 9 Z: 1 X\n");
    let b = write("b.dbc", "BO_ 9 B: 1 X\n\nBO_ 3 A: 1 X\nBO_ 2147483649 C: 1 X\nBO_ 5 D: 1 X\n");
    let database = Database::load_all(&[a, b.clone()]).unwrap();
    let names: Vec<_> = database.messages().iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["A", "Z", "C", "D"]);
    let found: Vec<String> = database.warnings().iter().map(ToString::to_string).collect();
    assert!(
        found[0].starts_with(&format!("{}:1: message `B` skipped: its identifier 009", b.display())),
        "{found:?}"
    );
    assert!(found[1].starts_with(&format!("{}:3: message `A` skipped: its name", b.display())), "{found:?}");
    assert!(matches!(database.signal("B.s"), Err(LookupError::Skipped { .. })));
    assert_eq!(database.message_with_id(CanId::standard(5).unwrap()).unwrap().name, "D");
}

#[test]
fn what_is_no_dbc_is_refused_with_a_place() {
    let message = |bytes: &[u8]| Database::parse(bytes, "x.dbc").unwrap_err().to_string();
    assert!(message(b"").starts_with("x.dbc:1: not a DBC file"));
    assert!(message(b"\x7FELF\x02\x01\x01\0\0\0").starts_with("x.dbc:1: not a DBC file"));
    assert!(message(&[0xFF; 100_000]).starts_with("x.dbc:1: not a DBC file"));
    assert!(message(b"VERSION \"\"\n").contains("it has no BO_ line"));
    let broken = message(b"VERSION \"\"\n\nBO_ what is this\n");
    assert!(
        broken.starts_with("x.dbc:3: no usable message") && broken.contains("cannot be parsed"),
        "{broken}"
    );
    let missing = Database::load("/no/such.dbc".as_ref()).unwrap_err().to_string();
    assert!(missing.starts_with("/no/such.dbc: cannot be read"), "{missing}");
}

#[test]
fn great_nonsense_is_dealt_with_in_reasonable_time() {
    let started = Instant::now();
    let cases = [
        "A".repeat(20 << 20),
        "\n".repeat(5 << 20),
        "CM_ \"".repeat(1 << 20),
        "CM_ \"\n".repeat(1 << 18),
        "BO_ 1 M: 8 X\n".repeat(1 << 14),
        "BO_ 1 M: 8 X ".repeat(1 << 18),
        format!("BO_ 1 M: 8 X\n{}", " SG_ s : \n".repeat(1 << 14)),
        format!("BO_ 1 M: 8 X\n{}", " SG_ s : 0|8@1+ (1,0) [0|0] \"\" X\n".repeat(1 << 14)),
        format!("VAL_ 1 s {}", "1 \"x\" ".repeat(1 << 18)),
    ];
    for text in cases {
        // It need not be refused; it must come back.
        let _ = parse(&text);
    }
    assert!(started.elapsed() < Duration::from_secs(60), "{:?}", started.elapsed());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_input_panics(bytes in proptest::collection::vec(any::<u8>(), 0..2000)) {
        let _ = Database::parse(&bytes, "random");
    }

    /// Real text with a few bytes turned into others: most of it must survive.
    #[test]
    fn no_damage_panics_or_costs_more_than_its_surroundings(
        places in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)
    ) {
        let mut bytes = std::fs::read(testing::data("peculiar.dbc")).unwrap();
        for (place, byte) in places {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        let database = Database::parse(&bytes, "damaged").unwrap();
        prop_assert!(database.messages().len() >= 5);
    }
}
