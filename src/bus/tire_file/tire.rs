//! A tire as a property file has it, and what the plain car takes of it at a load.

use std::io::Read;
use std::path::Path;

use super::TireFileError;
use super::entries::Entries;

/// No real tire property file comes near this, KiB.
const LARGEST_FILE_KIB: u64 = 1024;

/// The coefficients of one file that are used. What they mean: the room's own page.
#[derive(Debug)]
pub struct TireFile {
    entries: Entries,
    /// Nominal load, scaled, N.
    nominal: f64,
    /// (pressure − nominal pressure) / nominal pressure.
    pressure: f64,
    shape: f64,
    friction: [f64; 2],
    curvature: [f64; 2],
    cornering: Cornering,
    longitudinal: Option<[f64; 3]>,
    by_pressure: ByPressure,
    scales: Scales,
    /// The loads that it was measured at, N.
    loads: [f64; 2],
}

#[derive(Debug)]
struct Cornering {
    largest: f64,
    at: f64,
    bend: f64,
}

#[derive(Debug)]
struct ByPressure {
    longitudinal: [f64; 2],
    cornering: [f64; 2],
    friction: [f64; 2],
}

#[derive(Debug)]
struct Scales {
    shape: f64,
    friction: f64,
    curvature: f64,
    cornering: f64,
    longitudinal: f64,
}

/// A tire at one load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtLoad {
    /// Shape C of the lateral force.
    pub shape: f64,
    /// Curvature E of the lateral force.
    pub curvature: f64,
    /// Friction of the lateral force.
    pub friction: f64,
    /// Cornering stiffness / load, 1/rad.
    pub lateral_stiffness: f64,
    /// Longitudinal stiffness / load, per unit slip; where the file has it.
    pub longitudinal_stiffness: Option<f64>,
}

impl TireFile {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, lacks what is needed, or has there what cannot be; with line and key.
    pub fn load(path: &Path) -> Result<Self, TireFileError> {
        let file = path.display().to_string();
        let read = || {
            let mut bytes = Vec::new();
            crate::plain_file::open(path)?.take(LARGEST_FILE_KIB * 1024 + 1).read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        let bytes = read().map_err(|source| TireFileError::Read { file: file.clone(), source })?;
        if bytes.len() as u64 > LARGEST_FILE_KIB * 1024 {
            return Err(TireFileError::TooLarge { file, limit_kib: LARGEST_FILE_KIB });
        }
        // Comments have letters of whatever code page; keys and numbers are ASCII.
        Self::parse(&String::from_utf8_lossy(&bytes), &file)
    }

    /// The same from text; `file` is what errors name.
    ///
    /// # Errors
    /// As [`Self::load`], but for reading.
    pub fn parse(text: &str, file: &str) -> Result<Self, TireFileError> {
        let entries = Entries::parse(text, file);
        let newton = force_unit(&entries)?;
        angles_in_rad(&entries)?;
        for key in ["PROPERTY_FILE_FORMAT", "TYPE"] {
            let text = entries.text(key)?.unwrap_or_default().to_ascii_uppercase();
            if text.contains("MC") || text.contains("MOTORCYCLE") {
                let reason = "is a motorcycle's, whose coefficients mean something else; give a car's tire";
                return Err(entries.wrong(key, reason.into()));
            }
        }
        let number = |key, otherwise| Ok(entries.number(key)?.unwrap_or(otherwise));
        let nominal = needed(&entries, "FNOMIN")? * newton;
        if !(10.0..=1e6).contains(&nominal) {
            let reason = "gives a nominal load that no tire of a road vehicle has (10 N to 1e6 N); look at FORCE in [UNITS]";
            return Err(entries.wrong("FNOMIN", reason.into()));
        }
        let scale = positive(&entries, "LFZO", 1.0)?;
        let (pressure, at_rest) = (number("INFLPRES", 0.0)?, number("NOMPRES", 0.0)?);
        let pressure = if pressure > 0.0 && at_rest > 0.0 { (pressure - at_rest) / at_rest } else { 0.0 };
        if !(-0.8..=2.0).contains(&pressure) {
            let reason = "is far from NOMPRES; give both in the same unit, or leave INFLPRES out";
            return Err(entries.wrong("INFLPRES", reason.into()));
        }
        let at = needed(&entries, "PKY2")?;
        if at.abs() < 1e-9 {
            return Err(
                entries.wrong("PKY2", "must not be zero: it is the load of the largest stiffness".into())
            );
        }
        let longitudinal = match entries.number("PKX1")? {
            Some(first) => Some([first, number("PKX2", 0.0)?, number("PKX3", 0.0)?]),
            None => None,
        };
        Ok(Self {
            nominal: nominal * scale,
            pressure,
            shape: needed(&entries, "PCY1")?,
            friction: [needed(&entries, "PDY1")?, number("PDY2", 0.0)?],
            curvature: [number("PEY1", 0.0)?, number("PEY2", 0.0)?],
            cornering: Cornering { largest: needed(&entries, "PKY1")?, at, bend: number("PKY4", 2.0)? },
            longitudinal,
            by_pressure: ByPressure {
                longitudinal: [number("PPX1", 0.0)?, number("PPX2", 0.0)?],
                cornering: [number("PPY1", 0.0)?, number("PPY2", 0.0)?],
                friction: [number("PPY3", 0.0)?, number("PPY4", 0.0)?],
            },
            scales: Scales {
                shape: positive(&entries, "LCY", 1.0)?,
                friction: positive(&entries, "LMUY", 1.0)?,
                curvature: number("LEY", 1.0)?,
                cornering: positive(&entries, "LKY", 1.0)?,
                longitudinal: positive(&entries, "LKX", 1.0)?,
            },
            loads: [number("FZMIN", 0.0)? * newton, number("FZMAX", f64::INFINITY)? * newton],
            entries,
        })
    }

    /// What the tire is at a load, N.
    ///
    /// # Errors
    /// If a number comes out that no tire has; with the line of its first coefficient.
    pub fn at(&self, load: f64) -> Result<AtLoad, TireFileError> {
        let (nominal, pressure) = (self.nominal, self.pressure);
        let d = (load - nominal) / nominal;
        let by_pressure = |[first, second]: [f64; 2]| 1.0 + first * pressure + second * pressure * pressure;
        let [friction, friction_by_load] = self.friction;
        let [curvature, curvature_by_load] = self.curvature;
        let [largest_by_pressure, at_by_pressure] = self.by_pressure.cornering.map(|by| 1.0 + by * pressure);
        let bent = (load / (self.cornering.at * nominal * at_by_pressure)).atan();
        let cornering = self.cornering.largest
            * nominal
            * largest_by_pressure
            * (self.cornering.bend * bent).sin()
            * self.scales.cornering;
        let longitudinal = self.longitudinal.map(|[first, by_load, bend]| {
            (first + by_load * d)
                * (bend * d).exp()
                * by_pressure(self.by_pressure.longitudinal)
                * self.scales.longitudinal
        });
        let at = AtLoad {
            shape: self.shape * self.scales.shape,
            // Beyond 1 the formula folds back; the book limits it so.
            curvature: ((curvature + curvature_by_load * d) * self.scales.curvature).min(1.0),
            friction: (friction + friction_by_load * d)
                * by_pressure(self.by_pressure.friction)
                * self.scales.friction,
            lateral_stiffness: cornering.abs() / load,
            longitudinal_stiffness: longitudinal,
        };
        self.possible("PCY1", "a shape", at.shape, [0.1, 2.0], "PCY1 and LCY", load)?;
        self.possible("PEY1", "a curvature", at.curvature, [-200.0, 1.0], "PEY1, PEY2 and LEY", load)?;
        self.possible("PDY1", "a friction", at.friction, [0.02, 5.0], "PDY1, PDY2 and LMUY", load)?;
        let of = "PKY1, PKY2, LKY, FNOMIN and the units";
        self.possible("PKY1", "a cornering stiffness / load", at.lateral_stiffness, [0.5, 300.0], of, load)?;
        if let Some(stiffness) = at.longitudinal_stiffness {
            let of = "PKX1, PKX2, PKX3, LKX and FNOMIN";
            self.possible("PKX1", "a longitudinal stiffness / load", stiffness, [0.5, 1000.0], of, load)?;
        }
        Ok(at)
    }

    /// Is a number one that a tire can have?
    fn possible(
        &self,
        key: &str,
        what: &str,
        value: f64,
        [least, most]: [f64; 2],
        of: &str,
        load: f64,
    ) -> Result<(), TireFileError> {
        if (least..=most).contains(&value) {
            return Ok(());
        }
        let reason = format!(
            "gives {what} of {value:.4} at the car's static wheel load of {load:.0} N, and a tire has {least} to {most}; look at {of}"
        );
        Err(self.entries.wrong(key, reason))
    }

    /// The file, as errors name it.
    pub fn name(&self) -> &str {
        self.entries.file()
    }

    /// How many lines of it were used, and how many were not: other coefficients, and what is no coefficient.
    pub fn counts(&self) -> (usize, usize) {
        self.entries.counts()
    }

    /// Was it measured at such loads, N, as far as it says so?
    pub fn covers(&self, load: f64) -> bool {
        let [least, most] = self.loads;
        // Of a file that we have written, the load is the car's own but for the last digit.
        (least * (1.0 - 1e-9)..=most * (1.0 + 1e-9)).contains(&load)
    }

    /// The loads that it says it was measured at, N.
    pub fn loads(&self) -> [f64; 2] {
        self.loads
    }
}

/// A number without which there is no tire.
fn needed(entries: &Entries, key: &str) -> Result<f64, TireFileError> {
    if let Some(number) = entries.number(key)? {
        return Ok(number);
    }
    let format = entries.text("PROPERTY_FILE_FORMAT")?.map(|text| format!(", and this is '{text}'"));
    let reason = format!(
        "is missing, and no tire comes without it; give a magic formula file of version 5.2 or 6.1{}",
        format.unwrap_or_default()
    );
    Err(entries.wrong(key, reason))
}

/// A scale.
fn positive(entries: &Entries, key: &str, otherwise: f64) -> Result<f64, TireFileError> {
    match entries.number(key)? {
        Some(number) if number <= 0.0 => {
            Err(entries.wrong(key, "must be positive; 1 leaves the tire as it is".into()))
        }
        number => Ok(number.unwrap_or(otherwise)),
    }
}

/// Newtons per unit of force. SI where the file does not say.
fn force_unit(entries: &Entries) -> Result<f64, TireFileError> {
    const KEY: &str = "UNITS.FORCE";
    let unit = entries.text(KEY)?.unwrap_or("newton").to_ascii_lowercase();
    match unit.as_str() {
        "newton" | "newtons" | "n" => Ok(1.0),
        "kilonewton" | "kilonewtons" | "knewton" | "kn" => Ok(1e3),
        "kilogram_force" | "kg_force" | "kgf" => Ok(9.80665),
        "pound_force" | "lbf" => Ok(4.448_221_615_260_5),
        _ => {
            Err(entries
                .wrong(KEY, "is a unit that is not known here; write 'newton', and FNOMIN in it".into()))
        }
    }
}

/// Stiffnesses per degree would need to be known for such: some programs convert them, others do not.
fn angles_in_rad(entries: &Entries) -> Result<(), TireFileError> {
    const KEY: &str = "UNITS.ANGLE";
    let unit = entries.text(KEY)?.unwrap_or("radian").to_ascii_lowercase();
    if matches!(unit.as_str(), "radian" | "radians" | "rad") {
        return Ok(());
    }
    let reason = "whether stiffnesses are per rad then is not certain; write 'radians', and PKY1 per rad";
    Err(entries.wrong(KEY, reason.into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PLAIN: &str = "FNOMIN = 4000\nPCY1 = 1.3\nPDY1 = 0.9\nPKY1 = -20\nPKY2 = 1.5\n";

    fn at(text: &str, load: f64) -> Result<AtLoad, String> {
        TireFile::parse(text, "x.tir").and_then(|tire| tire.at(load)).map_err(|error| error.to_string())
    }

    #[test]
    fn five_numbers_are_a_tire() {
        let tire = at(PLAIN, 4000.0).unwrap();
        // sin(2 atan z) = 2 z / (1 + z²)
        let z = 1.0 / 1.5;
        assert!((tire.lateral_stiffness - 20.0 * 2.0 * z / (1.0 + z * z)).abs() < 1e-12);
        assert_eq!((tire.shape, tire.curvature, tire.friction), (1.3, 0.0, 0.9));
        assert_eq!(tire.longitudinal_stiffness, None);
    }

    #[test]
    fn loads_and_pressures_change_it_as_the_book_says() {
        let text = format!(
            "{PLAIN}PDY2 = -0.2\nPEY1 = -1\nPEY2 = 0.5\nPKX1 = 20\nPKX2 = 2\nPKX3 = 0.1\nINFLPRES = 2.2e5\nNOMPRES = 2e5\n\
             PPX1 = -0.3\nPPX2 = 0.1\nPPY1 = -0.6\nPPY2 = -0.1\nPPY3 = 0.05\nPPY4 = -0.1\n"
        );
        let tire = at(&text, 6000.0).unwrap();
        let close = |is: f64, should: f64| assert!((is - should).abs() < 1e-12, "{is} {should}");
        close(tire.friction, (0.9 - 0.1) * (1.0 + 0.005 - 0.001));
        close(tire.curvature, -0.75);
        close(tire.longitudinal_stiffness.unwrap(), 21.0 * 0.05f64.exp() * (1.0 - 0.03 + 0.001));
        let z: f64 = 1.5 / (1.5 * 0.99);
        close(tire.lateral_stiffness, 20.0 * 4000.0 * 0.94 * 2.0 * z / (1.0 + z * z) / 6000.0);
    }

    #[test]
    fn what_is_missing_or_absurd_is_named() {
        for key in ["FNOMIN", "PCY1", "PDY1", "PKY1", "PKY2"] {
            let text: String =
                PLAIN.lines().filter(|line| !line.starts_with(key)).flat_map(|line| [line, "\n"]).collect();
            let error = at(&text, 4000.0).unwrap_err();
            assert!(error.starts_with(&format!("x.tir: {key}: is missing")), "{error}");
        }
        for (line, named) in [
            ("LMUY = 0", "x.tir:6: LMUY = 0: must be positive"),
            ("LMUY = 100", "x.tir:3: PDY1 = 0.9: gives a friction of 90"),
            ("LKY = 1e-3", "x.tir:4: PKY1 = -20: gives a cornering stiffness / load of 0.01"),
            ("PKX1 = -20", "x.tir:6: PKX1 = -20: gives a longitudinal stiffness / load of -20"),
            ("LCY = 1.7", "x.tir:2: PCY1 = 1.3: gives a shape of 2.21"),
            ("PKY4 = nan", "x.tir:6: PKY4 = nan: is not a finite number"),
            ("TYPE = 'MOTORCYCLE'", "x.tir:6: TYPE = MOTORCYCLE: is a motorcycle's"),
            ("[UNITS]\nANGLE = 'degrees'", "x.tir:7: ANGLE = degrees: "),
            ("[UNITS]\nFORCE = 'stone'", "x.tir:7: FORCE = stone: is a unit that is not known"),
            ("[UNITS]\nFORCE = 'kN'", "x.tir:1: FNOMIN = 4000: gives a nominal load"),
            ("INFLPRES = 2.2\nNOMPRES = 220000", "x.tir:6: INFLPRES = 2.2: is far from NOMPRES"),
        ] {
            let error = at(&format!("{PLAIN}{line}\n"), 4000.0).unwrap_err();
            assert!(error.starts_with(named), "{line}: {error}");
        }
        assert!(at("no tire at all", 4000.0).unwrap_err().contains("FNOMIN: is missing"));
    }

    #[test]
    fn forces_come_in_the_units_that_the_file_names() {
        let plain = at(PLAIN, 4000.0).unwrap();
        for (unit, nominal) in [("kN", "4"), ("kilogram_force", "407.88648"), ("LBF", "899.23577")] {
            let text = format!("[UNITS]\nFORCE = '{unit}'\n[VERTICAL]\n{}", PLAIN.replace("4000", nominal));
            let tire = at(&text, 4000.0).unwrap();
            assert!((tire.lateral_stiffness - plain.lateral_stiffness).abs() < 1e-4, "{unit}: {tire:?}");
        }
    }

    proptest! {
        /// Whatever stands behind its keys, a file gives finite numbers or an error.
        #[test]
        fn no_file_is_a_surprise(
            numbers in prop::collection::vec((0..14usize, prop_oneof![-1e3..1e3, any::<f64>()]), 0..20),
            garbage in "[ -~\\[\\]='\"!$é\\n]{0,60}",
            load in 100.0..20_000.0,
        ) {
            const KEYS: [&str; 14] = [
                "FNOMIN", "PCY1", "PDY1", "PDY2", "PEY1", "PEY2", "PKY1", "PKY2", "PKY4", "PKX1", "PKX3", "LFZO",
                "INFLPRES", "NOMPRES",
            ];
            let lines: String = numbers.iter().map(|(key, number)| format!("{} = {number:?}\n", KEYS[*key])).collect();
            for text in [format!("{PLAIN}{garbage}\n{lines}"), format!("{lines}{garbage}"), garbage] {
                if let Ok(tire) = at(&text, load) {
                    let all = [tire.shape, tire.curvature, tire.friction, tire.lateral_stiffness];
                    prop_assert!(all.iter().all(|number| number.is_finite()), "{tire:?}");
                }
            }
        }
    }
}
