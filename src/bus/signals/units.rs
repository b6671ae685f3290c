//! Units as DBC files spell them, and their factors to SI.

use thiserror::Error;

use physics::Quantity;

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Dimension {
    AngularVelocity,
    Velocity,
    Angle,
    Acceleration,
    Torque,
    Pressure,
    Share,
    Number,
}

/// Why a unit cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum UnitError {
    /// The DBC has none and none was given.
    #[error("the DBC gives no unit; add unit = \"…\" ({accepted})")]
    Missing {
        /// What would be accepted.
        accepted: &'static str,
    },
    /// Not a unit gripd knows.
    #[error("unit \"{unit}\" is not known; add unit = \"…\" ({accepted})")]
    Unknown {
        /// As it is spelled.
        unit: String,
        /// What would be accepted.
        accepted: &'static str,
    },
    /// A unit of something else.
    #[error("unit \"{unit}\" does not measure this quantity; add unit = \"…\" ({accepted})")]
    Unfitting {
        /// As it is spelled.
        unit: String,
        /// What would be accepted.
        accepted: &'static str,
    },
}

/// The factor from `unit` to the quantity's SI unit ([`Quantity::unit`]).
///
/// A wheel speed given as the speed of its circumference is divided by `wheel_radius_m`. Flags have no
/// unit: any is accepted.
///
/// # Errors
/// If the unit is missing, unknown or measures something else; the message lists what is accepted.
pub fn to_si(quantity: Quantity, unit: &str, wheel_radius_m: f64) -> Result<f64, UnitError> {
    let accepted = accepted(quantity);
    if matches!(quantity, Quantity::BrakeActive | Quantity::AbsActive) {
        return Ok(1.0);
    }
    let parsed = parse(unit).ok_or_else(|| {
        if unit.trim().is_empty() {
            UnitError::Missing { accepted }
        } else {
            UnitError::Unknown { unit: unit.to_owned(), accepted }
        }
    });
    let (dimension, factor) = parsed?;
    let fits = |wanted| dimension == wanted;
    let factor = match quantity {
        _ if quantity.wheel().is_some() && fits(Dimension::AngularVelocity) => factor,
        _ if quantity.wheel().is_some() && fits(Dimension::Velocity) => factor / wheel_radius_m,
        Quantity::YawRate if fits(Dimension::AngularVelocity) => factor,
        Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration
            if fits(Dimension::Acceleration) =>
        {
            factor
        }
        Quantity::SteeringWheelAngle if fits(Dimension::Angle) => factor,
        Quantity::DriveTorque | Quantity::BrakeTorque if fits(Dimension::Torque) => factor,
        Quantity::BrakePressure if fits(Dimension::Pressure) => factor,
        Quantity::VehicleSpeed if fits(Dimension::Velocity) => factor,
        _ if fits(Dimension::Number) => return Err(UnitError::Missing { accepted }),
        _ => return Err(UnitError::Unfitting { unit: unit.to_owned(), accepted }),
    };
    Ok(factor)
}

fn accepted(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::WheelSpeedFl | Quantity::WheelSpeedFr | Quantity::WheelSpeedRl | Quantity::WheelSpeedRr => {
            "rad/s, deg/s, rpm, 1/s; or km/h, mph, m/s at the circumference"
        }
        Quantity::YawRate => "rad/s, deg/s, rpm",
        Quantity::LateralAcceleration | Quantity::LongitudinalAcceleration => "m/s^2, g",
        Quantity::SteeringWheelAngle => "rad, deg",
        Quantity::DriveTorque | Quantity::BrakeTorque => "Nm, kNm; scale anything else to Nm with gain",
        Quantity::BrakePressure => "bar, mbar, Pa, kPa, MPa, psi",
        Quantity::VehicleSpeed => "m/s, km/h, mph",
        Quantity::BrakeActive | Quantity::AbsActive => "any",
    }
}

/// Dimension and factor to SI (bar for pressures) of a unit, however it is spelled.
fn parse(unit: &str) -> Option<(Dimension, f64)> {
    use Dimension::*;
    const DEGREE: f64 = std::f64::consts::PI / 180.0;
    const REVOLUTION: f64 = 2.0 * std::f64::consts::PI;
    const G: f64 = 9.806_65;
    Some(match normalize(unit).as_str() {
        "rad/s" => (AngularVelocity, 1.0),
        "mrad/s" => (AngularVelocity, 1e-3),
        "°/s" | "degreofarcpersecon" | "degreeofarcpersecon" => (AngularVelocity, DEGREE),
        "°/min" => (AngularVelocity, DEGREE / 60.0),
        "rpm" | "1/min" | "min-1" | "u/min" | "umin" | "upm" | "rev/min" | "r/min" | "minutinver" => {
            (AngularVelocity, REVOLUTION / 60.0)
        }
        "rps" | "1/s" | "s-1" | "u/s" | "rev/s" | "r/s" | "hz" | "hertz" => (AngularVelocity, REVOLUTION),
        "m/s" | "mps" | "meterpersecon" => (Velocity, 1.0),
        "cm/s" => (Velocity, 1e-2),
        "mm/s" => (Velocity, 1e-3),
        "km/h" | "kph" | "kmh" | "kmph" | "kilometerperhour" => (Velocity, 1.0 / 3.6),
        "mph" | "mi/h" | "mileperhour" => (Velocity, 0.447_04),
        "kn" | "kt" | "knot" | "knots" => (Velocity, 1852.0 / 3600.0),
        "rad" => (Angle, 1.0),
        "mrad" => (Angle, 1e-3),
        "°" | "degreofarc" | "degreeofarc" => (Angle, DEGREE),
        "rev" | "turn" | "turns" => (Angle, REVOLUTION),
        "m/s2" | "mps2" | "m/s/s" | "ms-2" | "meterperseconsquar" => (Acceleration, 1.0),
        "mm/s2" => (Acceleration, 1e-3),
        "g" | "forceofgravi" => (Acceleration, G),
        "mg" => (Acceleration, 1e-3 * G),
        "%g" | "percentofforceofgravi" => (Acceleration, 1e-2 * G),
        "nm" | "newtonm" | "newtonmeter" | "newtonmetre" | "newtometer" => (Torque, 1.0),
        "knm" | "kilonewtometer" => (Torque, 1e3),
        "cnm" | "centinewtometer" => (Torque, 1e-2),
        "lbft" | "ftlb" | "lbfft" | "ftlbf" => (Torque, 1.355_817_948),
        "bar" => (Pressure, 1.0),
        "mbar" | "hpa" | "millibar" => (Pressure, 1e-3),
        "pa" | "pascal" => (Pressure, 1e-5),
        "kpa" | "kilopascal" => (Pressure, 1e-2),
        "mpa" | "megapascal" => (Pressure, 10.0),
        "psi" => (Pressure, 0.068_947_572_9),
        "%" | "percent" | "percen" => (Share, 0.01),
        "" | "1" | "-" | "unitless" | "none" | "number" | "sed" | "raw" => (Number, 1.0),
        _ => return None,
    })
}

/// One spelling for all spellings of a unit: lower case, `°` for degrees, `2` for squares, `s` for seconds.
fn normalize(unit: &str) -> String {
    // MPa and mPa would become one; nobody measures brakes in mPa.
    let lower = unit.trim().to_lowercase();
    let lower = lower.strip_prefix("unit_").unwrap_or(&lower);
    // A UTF-8 degree sign or square read as Latin-1 carries a stray Â.
    let mut text: String = lower
        .chars()
        .filter(|c| !matches!(c, ' ' | '_' | '\\' | '^' | 'â' | '·' | '*' | '.' | '(' | ')' | '[' | ']'))
        .map(|c| match c {
            '²' => '2',
            'º' | '˚' => '°',
            '⁻' | '−' => '-',
            '¹' => '1',
            other => other,
        })
        .collect();
    // In km^h the caret is a mistyped slash.
    if text == "kmh" {
        text = "km/h".to_owned();
    }
    for (from, to) in [
        ("°grad", "°"),
        ("degrees", "°"),
        ("degree", "°"),
        ("radians", "rad"),
        ("radian", "rad"),
        ("metres", "m"),
        ("meters", "m"),
        ("/seconds", "/s"),
        ("/second", "/s"),
        ("/sec", "/s"),
        ("/sek", "/s"),
        ("/minute", "/min"),
        ("/hour", "/h"),
    ] {
        // The truncated words of VW files ("degreeofarc") are matched whole.
        if !text.contains("ofarc") {
            text = text.replace(from, to);
        }
    }
    match text.strip_prefix("deg").or_else(|| text.strip_prefix("grad")) {
        Some(rest) if rest.is_empty() || rest.starts_with('/') => format!("°{rest}"),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Quantity::*;

    fn factor(quantity: Quantity, unit: &str) -> f64 {
        to_si(quantity, unit, 0.3).unwrap_or_else(|e| panic!("{quantity} in {unit}: {e}"))
    }

    #[test]
    fn spellings_of_real_files_mean_what_their_authors_meant() {
        let degree = std::f64::consts::PI / 180.0;
        for unit in [
            "deg/s",
            "Deg/s",
            "°/s",
            "º/s",
            "Â°/s",
            "degrees/sec",
            "degrees/second",
            "deg/sek",
            "°Grad/s",
            "Grad/sec",
            "Unit_DegreOfArcPerSecon",
        ] {
            assert!((factor(YawRate, unit) - degree).abs() < 1e-12, "{unit}");
        }
        for unit in ["rad/s", "radians/sec", "radians/second", "rad/sec"] {
            assert_eq!(factor(YawRate, unit), 1.0, "{unit}");
        }
        for unit in ["deg", "Deg", "degrees", "Degrees", "°", "°Grad", "Unit_DegreOfArc", "Unit_DegreeOfArc"]
        {
            assert!((factor(SteeringWheelAngle, unit) - degree).abs() < 1e-12, "{unit}");
        }
        for unit in ["m/s2", "m/s^2", "m/s²", "m/sec^2", "Unit_MeterPerSeconSquar"] {
            assert_eq!(factor(LateralAcceleration, unit), 1.0, "{unit}");
        }
        for unit in ["g", "G", "Unit_ForceOfGravi"] {
            assert!((factor(LateralAcceleration, unit) - 9.80665).abs() < 1e-12, "{unit}");
        }
        for unit in ["km/h", "kph", "KPH", "Km/h", "km^h", "Unit_KiloMeterPerHour"] {
            assert!((factor(VehicleSpeed, unit) - 1.0 / 3.6).abs() < 1e-12, "{unit}");
        }
        for unit in ["m/s", "meters/sec"] {
            assert_eq!(factor(VehicleSpeed, unit), 1.0, "{unit}");
        }
        for unit in ["rpm", "RPM", "1/min", "U/min", "Umin", "upm", "rev/min", "Unit_MinutInver"] {
            assert!((factor(WheelSpeedFl, unit) - std::f64::consts::PI / 30.0).abs() < 1e-12, "{unit}");
        }
        for unit in ["Nm", "N m", "Nm\\", "N·m", "Unit_NewtoMeter"] {
            assert_eq!(factor(DriveTorque, unit), 1.0, "{unit}");
        }
        assert_eq!(factor(DriveTorque, "Unit_centiNewtoMeter"), 0.01);
        assert_eq!(factor(DriveTorque, "kNm"), 1000.0);
        for unit in ["bar", "Bar", "Unit_Bar"] {
            assert_eq!(factor(BrakePressure, unit), 1.0, "{unit}");
        }
        for unit in ["hPa", "mbar", "Millibar", "Unit_MilliBar"] {
            assert_eq!(factor(BrakePressure, unit), 1e-3, "{unit}");
        }
        assert_eq!(factor(BrakePressure, "kilopascal"), 0.01);
        assert_eq!(factor(BrakePressure, "MPa"), 10.0);
        assert!((factor(BrakePressure, "psi") * 14.5038 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn circumferential_speeds_become_angular_ones() {
        assert!((factor(WheelSpeedRr, "m/s") - 1.0 / 0.3).abs() < 1e-12);
        assert!((factor(WheelSpeedRr, "mph") - 0.44704 / 0.3).abs() < 1e-12);
        assert_eq!(factor(WheelSpeedRr, "rad/s"), 1.0);
    }

    #[test]
    fn what_has_no_clear_unit_is_asked_for() {
        let missing = to_si(YawRate, "", 0.3).unwrap_err();
        assert!(matches!(missing, UnitError::Missing { .. }));
        assert!(missing.to_string().contains("unit = "), "{missing}");
        assert!(matches!(to_si(YawRate, "unitless", 0.3), Err(UnitError::Missing { .. })));
        // One Tesla signal is either, as another signal says.
        assert!(matches!(to_si(VehicleSpeed, "kph/mph", 0.3), Err(UnitError::Unknown { .. })));
        assert!(matches!(to_si(VehicleSpeed, "km/h or MPH", 0.3), Err(UnitError::Unknown { .. })));
        assert!(matches!(to_si(YawRate, "bar", 0.3), Err(UnitError::Unfitting { .. })));
        assert!(matches!(to_si(BrakePressure, "m/s^3", 0.3), Err(UnitError::Unknown { .. })));
        assert_eq!(to_si(AbsActive, "", 0.3), Ok(1.0));
    }
}
