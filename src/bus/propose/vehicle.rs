//! A `[vehicle]` table of what was told, what a recording tells, and a class of cars for the rest.

use std::fmt::Write;

use super::class::CarClass;
use super::table::comment;
use physics::Quantity;
use physics::model::{DrivenAxle, Uncertain};

/// Where a number comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// The user.
    Told,
    /// The class of the car: a guess.
    Class,
    /// The recording; how, in words.
    Recording(String),
}

/// A number of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Its key.
    pub key: &'static str,
    /// What is known.
    pub value: Uncertain,
    /// By whom.
    pub source: Source,
}

/// The table.
#[derive(Clone, Debug, PartialEq)]
pub struct VehicleTable {
    class: CarClass,
    driven: (DrivenAxle, Source),
    numbers: Vec<Number>,
}

/// The order in the file.
const KEYS: [&str; 19] = [
    "mass_kg",
    "wheelbase_m",
    "cg_to_front_m",
    "yaw_inertia_kgm2",
    "track_front_m",
    "track_rear_m",
    "cg_height_m",
    "wheel_radius_m",
    "wheel_inertia_kgm2",
    "steering_ratio",
    "drive_torque_ratio",
    "brake_torque_per_bar_front_nm",
    "brake_torque_per_bar_rear_nm",
    "drag_coefficient_kg_per_m",
    "rolling_resistance",
    "longitudinal_stiffness",
    "lateral_stiffness_front",
    "lateral_stiffness_rear",
    "friction",
];

impl VehicleTable {
    /// Of a class, with what was told. `has` says which signals there are.
    pub fn new(
        class: CarClass,
        driven: Option<DrivenAxle>,
        told: &[(&'static str, Uncertain)],
        has: impl Fn(Quantity) -> bool,
    ) -> Self {
        let driven = driven.map_or((class.driven(), Source::Class), |axle| (axle, Source::Told));
        let mut table = Self { class, driven, numbers: Vec::new() };
        let told_of = |key: &str| told.iter().find(|(told, _)| *told == key).map(|(_, value)| *value);
        for (key, guess) in class.numbers() {
            let (value, source) = told_of(key).map_or((guess, Source::Class), |value| (value, Source::Told));
            if key != "drive_torque_ratio" || has(Quantity::DriveTorque) || source == Source::Told {
                table.numbers.push(Number { key, value, source });
            }
        }
        if let Some(value) = told_of("cg_to_front_m") {
            table.numbers.push(Number { key: "cg_to_front_m", value, source: Source::Told });
        }
        if has(Quantity::BrakePressure) {
            let front = Uncertain { value: 22.0, std: 8.0 };
            let rear = Uncertain { value: 9.0, std: 4.0 };
            for (key, value) in
                [("brake_torque_per_bar_front_nm", front), ("brake_torque_per_bar_rear_nm", rear)]
            {
                table.numbers.push(Number { key, value, source: Source::Class });
            }
        }
        table.derive();
        table
    }

    /// What a recording tells replaces a guess, and never what was told; true if it did.
    pub fn learn(&mut self, key: &str, value: Uncertain, how: &str) -> bool {
        let Some(number) = self.numbers.iter_mut().find(|number| number.key == key) else { return false };
        if number.source == Source::Told || !(value.value.is_finite() && value.std.is_finite()) {
            return false;
        }
        // A drive that tells less than the class of the car does is no better than a guess.
        let share = |of: Uncertain| of.std / of.value.abs();
        if number.source == Source::Class && share(value) > share(number.value) {
            return false;
        }
        (number.value, number.source) = (rounded(value), Source::Recording(how.to_owned()));
        self.derive();
        true
    }

    /// The same of the driven axle.
    pub fn learn_driven(&mut self, axle: DrivenAxle, how: &str) -> bool {
        if self.driven.1 == Source::Told {
            return false;
        }
        self.driven = (axle, Source::Recording(how.to_owned()));
        self.derive();
        true
    }

    /// The driven axle, and who says so.
    pub fn driven(&self) -> (DrivenAxle, &Source) {
        (self.driven.0, &self.driven.1)
    }

    /// The class.
    pub fn class(&self) -> CarClass {
        self.class
    }

    /// A number by its key.
    pub fn number(&self, key: &str) -> Option<&Number> {
        self.numbers.iter().find(|number| number.key == key)
    }

    /// All numbers in the order of the file.
    pub fn numbers(&self) -> impl Iterator<Item = &Number> {
        KEYS.into_iter().filter_map(|key| self.number(key))
    }

    /// What follows from wheelbase, mass and driven axle, where nobody told it.
    fn derive(&mut self) {
        let value = |key: &str| self.number(key).map(|number| number.value);
        let (Some(mass), Some(base)) = (value("mass_kg"), value("wheelbase_m")) else { return };
        let told = |key: &str| self.number(key).is_some_and(|number| number.source == Source::Told);
        if !told("cg_to_front_m") {
            let share = self.class.balance(self.driven.0);
            let spread = (base.value * share.std).hypot(base.std * share.value);
            self.guess("cg_to_front_m", Uncertain { value: base.value * share.value, std: spread });
        }
        let Some(front) = self.number("cg_to_front_m").map(|number| number.value) else { return };
        let share = self.class.inertia_share();
        let inertia = share.value * mass.value * front.value * (base.value - front.value);
        let spread = (share.std / share.value).hypot(mass.std / mass.value);
        let inertia = Uncertain { value: inertia, std: inertia.abs() * spread };
        if !self.number("yaw_inertia_kgm2").is_some_and(|number| number.source == Source::Told) {
            self.guess("yaw_inertia_kgm2", inertia);
        }
    }

    fn guess(&mut self, key: &'static str, value: Uncertain) {
        let number = Number { key, value: rounded(value), source: Source::Class };
        match self.numbers.iter_mut().find(|number| number.key == key) {
            Some(there) => *there = number,
            None => self.numbers.push(number),
        }
    }

    /// The guesses that matter most for the answers, worst first: key, how uncertain (relative), and what goes with it.
    pub fn matters(&self, has: impl Fn(Quantity) -> bool) -> Vec<(&'static str, f64, &'static str)> {
        let weigh = |number: &Number| {
            let share = number.value.std / number.value.value.abs();
            let (weight, what) = influence(number.key, &has)?;
            (number.source == Source::Class).then_some((weight * share, (number.key, share, what)))
        };
        let mut all: Vec<_> = self.numbers().filter_map(weigh).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all.into_iter().map(|(_, words)| words).take(4).collect()
    }

    /// As it is written.
    pub fn text(&self, has: impl Fn(Quantity) -> bool) -> String {
        let mut out = String::from("[vehicle]\n");
        let class = self.class;
        comment(
            &mut out,
            &format!(
                "A car of the class `{class}`, where nobody told more and no recording did. The std of a guess is wide: \
                 put in what the data sheet says."
            ),
        );
        let matters = self.matters(&has);
        if !matters.is_empty() {
            comment(&mut out, "Of the guesses these matter most for the answers:");
            for (key, share, what) in matters {
                comment(&mut out, &format!("- {key} (± {:.0} %): {what}", 100.0 * share));
            }
        }
        for Number { key, value, source } in self.numbers() {
            let value = match value.std {
                0.0 => format!("{key} = {:?}", value.value),
                std => format!("{key} = {{ value = {:?}, std = {std:?} }}", value.value),
            };
            entry(&mut out, &value, &words(source, class));
        }
        let axle = self.driven.0.name();
        entry(&mut out, &format!("driven_axle = \"{axle}\""), &words(&self.driven.1, class));
        entry(&mut out, "tire = \"brush\"", "tires that slide at their limit");
        out
    }
}

fn entry(out: &mut String, value: &str, words: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{value:<60} # {words}");
}

fn words(source: &Source, class: CarClass) -> String {
    match source {
        Source::Told => "told by you".to_owned(),
        Source::Class => format!("class {class}"),
        Source::Recording(how) => format!("this recording: {how}"),
    }
}

/// How much the answers change with a relative error of a number, and what does. What is learned while driving
/// (stiffness, friction) matters little as a start.
fn influence(key: &str, has: &impl Fn(Quantity) -> bool) -> Option<(f64, &'static str)> {
    let torque = has(Quantity::DriveTorque) || has(Quantity::BrakePressure) || has(Quantity::BrakeTorque);
    Some(match key {
        "mass_kg" if torque => (1.0, "forces, and what drive and brake torque say of friction, go with it"),
        "mass_kg" => (0.7, "forces in N go with it"),
        "wheelbase_m" => (1.5, "slip angles, and how the load divides"),
        "cg_to_front_m" => (1.5, "how the load divides, and with it each axle's stiffness"),
        "yaw_inertia_kgm2" => (0.3, "how fast the yaw rate follows the steering"),
        "steering_ratio" => (1.5, "the front slip angle, and with it the front axle's stiffness"),
        "wheel_radius_m" => (1.0, "speed and slip, where wheels tell revolutions"),
        "track_front_m" | "track_rear_m" => (0.5, "the yaw rate as the wheels tell it"),
        "cg_height_m" => (0.2, "how the load moves in curves and brakings"),
        "drive_torque_ratio" => (1.0, "the drive force, and so the slip slope"),
        "brake_torque_per_bar_front_nm" => (0.2, "the brake force"),
        _ => return None,
    })
}

/// Three digits of the deviation, and as many decimals of the value.
fn rounded(number: Uncertain) -> Uncertain {
    let std = number.std.abs();
    if !(std > 0.0 && std.is_finite()) {
        return number;
    }
    let power = 10f64.powi((1 - std.log10().floor() as i32).clamp(0, 9));
    Uncertain { value: (power * number.value).round() / power, std: (power * std).round() / power }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::model::Vehicle;

    fn table(text: &str) -> Vehicle {
        #[derive(serde::Deserialize)]
        struct File {
            vehicle: Vehicle,
        }
        toml::from_str::<File>(text).unwrap().vehicle
    }

    fn all(_: Quantity) -> bool {
        true
    }

    #[test]
    fn every_class_is_a_car() {
        for class in CarClass::ALL {
            assert_eq!(class.name().parse(), Ok(class));
            for driven in [DrivenAxle::Front, DrivenAxle::Rear, DrivenAxle::All] {
                let vehicle = VehicleTable::new(class, Some(driven), &[], all);
                let text = vehicle.text(all);
                let vehicle = table(&text);
                assert_eq!(vehicle.validate(), Ok(()), "{text}");
                assert_eq!(vehicle.driven_axle, driven);
                assert!(vehicle.mass_kg.std > 0.1 * vehicle.mass(), "nobody told it");
                assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
            }
        }
        assert!("bus".parse::<CarClass>().unwrap_err().contains("compact, midsize, suv, van, race"));
    }

    #[test]
    fn what_was_told_stands_and_what_follows_follows() {
        let told = [
            ("mass_kg", Uncertain { value: 790.0, std: 20.0 }),
            ("wheelbase_m", Uncertain::known(2.981)),
            ("steering_ratio", Uncertain::known(15.0)),
        ];
        let mut vehicle = VehicleTable::new(CarClass::Race, None, &told, |_| false);
        assert!(!vehicle.learn("steering_ratio", Uncertain { value: 14.0, std: 0.5 }, "by curves"));
        assert!(vehicle.learn("track_rear_m", Uncertain { value: 1.5234, std: 0.0212 }, "by wheels"));
        assert!(vehicle.learn_driven(DrivenAxle::Front, "by slip"));
        let text = vehicle.text(|_| false);
        let read = table(&text);
        assert_eq!(read.mass_kg, Uncertain { value: 790.0, std: 20.0 });
        assert_eq!(read.wheelbase_m, Uncertain::known(2.981));
        assert_eq!(read.track_rear_m, Uncertain { value: 1.523, std: 0.021 });
        assert!((read.cg_to_front_m.value - 0.57 * 2.981).abs() < 0.01);
        assert_eq!(read.brake_torque_per_bar_front_nm, None, "there is no such signal");
        assert_eq!(read.driven_axle, DrivenAxle::Front);
        let line = |key: &str| text.lines().find(|line| line.starts_with(key)).unwrap();
        assert!(line("mass_kg").ends_with("# told by you"));
        assert!(line("track_rear_m").ends_with("# this recording: by wheels"));
        assert!(line("cg_to_front_m").ends_with("# class race"));
        // What was told does not matter any more.
        let matters: Vec<&str> = vehicle.matters(|_| true).into_iter().map(|(key, ..)| key).collect();
        assert!(matters.contains(&"cg_to_front_m") && !matters.contains(&"mass_kg"), "{matters:?}");
    }
}
