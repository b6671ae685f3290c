//! Cars that the tests make up: DBC, truth and a recorded drive.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use gripd::Quantity;
use gripd::propose::Proposal;

use super::{gripd, of_files};
pub use testing::town::DRIVE;

/// One signal of a car that the test makes up.
pub struct Line {
    pub quantity: Quantity,
    pub name: &'static str,
    /// Factor, unit in the file, and the true unit where the file has none or a wrong one.
    pub factor: f64,
    pub unit: &'static str,
    pub truth: Option<&'static str>,
    /// −1: the sensor is the wrong way round.
    pub gain: f64,
}

fn line(quantity: Quantity, name: &'static str, factor: f64, unit: &'static str) -> Line {
    Line { quantity, name, factor, unit, truth: None, gain: 1.0 }
}

/// A car of 16-bit signals, four to a message in their order, and beside them things that are none of these.
pub struct Car {
    pub lines: Vec<Line>,
    pub messages: [&'static str; 3],
}

impl Car {
    pub fn german() -> Self {
        use Quantity::*;
        Self {
            messages: ["Brems_4", "Sensor_2", "Antrieb_1"],
            lines: vec![
                line(WheelSpeedFl, "Raddrehz_VL", 0.05, "U/min"),
                line(WheelSpeedFr, "Raddrehz_VR", 0.05, "U/min"),
                line(WheelSpeedRl, "Raddrehz_HL", 0.05, "U/min"),
                line(WheelSpeedRr, "Raddrehz_HR", 0.05, "U/min"),
                line(YawRate, "Giergeschwindigkeit", 0.01, "Grad/s"),
                line(LateralAcceleration, "Querbeschl", 0.001, "g"),
                line(LongitudinalAcceleration, "Laengsbeschl", 0.002, "m/s2"),
                line(SteeringWheelAngle, "Lenkradwinkel", 0.05, "Grad"),
                line(DriveTorque, "Antriebsmoment_Achse", 1.0, "Nm"),
                line(BrakePressure, "Bremsdruck_HZ", 0.1, "bar"),
            ],
        }
    }

    pub fn nameless() -> Self {
        let mut car = Self::german();
        car.messages = ["M1", "M2", "M3"];
        let names = ["S07", "S02", "S05", "S01", "S11", "S09", "S10", "S12", "S21", "S22"];
        // The wheels in an order of their own: rear right, front left, rear left, front right.
        for (line, name) in car.lines.iter_mut().zip(names) {
            line.name = name;
        }
        car.lines.swap(0, 3);
        car.lines.swap(1, 3);
        car
    }

    pub fn of(&mut self, quantity: Quantity) -> &mut Line {
        self.lines.iter_mut().find(|line| line.quantity == quantity).unwrap()
    }

    pub fn place(&self, quantity: Quantity) -> String {
        let place = self.lines.iter().position(|line| line.quantity == quantity).unwrap();
        format!("{}.{}", self.messages[place / 4], self.lines[place].name)
    }

    pub fn dbc(&self) -> String {
        let mut text = String::from("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: A B\n");
        for (message, name) in self.messages.iter().enumerate() {
            let length = if message == 2 { 6 } else { 8 };
            write!(text, "\nBO_ {} {name}: {length} A\n", 0x120 + 16 * message).unwrap();
            for (place, line) in self.lines.iter().enumerate().filter(|(place, _)| place / 4 == message) {
                let (start, name, factor, unit) = (16 * (place % 4), line.name, line.factor, line.unit);
                writeln!(text, " SG_ {name} : {start}|16@1- ({factor},0) [0|0] \"{unit}\" B").unwrap();
            }
            if message == 2 {
                writeln!(text, " SG_ Zaehler : 32|4@1+ (1,0) [0|15] \"\" B\n SG_ Temperatur : 40|8@1+ (1,-40) [0|0] \"C\" B").unwrap();
            }
        }
        text
    }

    /// What is true of it, as a configuration that the simulator writes frames with.
    pub fn truth(&self) -> String {
        let mut text = String::from("[dbc]\ninput = [\"car.dbc\"]\n[signals]\n");
        for line in &self.lines {
            let unit = line.truth.map_or_else(String::new, |unit| format!(", unit = \"{unit}\""));
            let counter = if line.quantity == Quantity::DriveTorque {
                format!(", counter = \"{}.Zaehler\"", self.messages[2])
            } else {
                String::new()
            };
            writeln!(
                text,
                "{} = {{ signal = \"{}\", gain = {:?}{unit}{counter} }}",
                line.quantity,
                self.place(line.quantity),
                line.gain
            )
            .unwrap();
        }
        text + "[vehicle]\nmass_kg = 1550.0\nwheelbase_m = 2.68\ncg_to_front_m = 1.1\nwheel_radius_m = 0.316\n\
            steering_ratio = 15.5\ndriven_axle = \"front\"\n"
    }

    /// Writes DBC, truth and a recorded drive.
    pub fn record(&self, folder: &Path, scenario: &str) -> (PathBuf, PathBuf) {
        let [dbc, truth, drive, log] =
            ["car.dbc", "truth.toml", "drive.toml", "drive.log"].map(|name| folder.join(name));
        std::fs::write(&dbc, self.dbc()).unwrap();
        std::fs::write(&truth, self.truth()).unwrap();
        std::fs::write(&drive, scenario).unwrap();
        let simulated = gripd(&[&"simulate", &drive, &"-c", &truth, &"-o", &log, &"--seed", &"3"]);
        assert!(simulated.status.success(), "{}", String::from_utf8_lossy(&simulated.stderr));
        (dbc, log)
    }

    /// Proposes from names and drive.
    pub fn propose(&self) -> Proposal {
        let folder = tempfile::tempdir().unwrap();
        let (dbc, log) = self.record(folder.path(), DRIVE);
        of_files(&dbc, &[log])
    }
}
