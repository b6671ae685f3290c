//! Tire property files of a car's `[vehicle]` table.

use super::page::{Page, ascii, with_std};
use super::{AtLoad, TireFile, TireFileError};
use physics::model::tire::{Closest, MagicFormula, Tire};
use physics::model::{TireKind, Vehicle};

/// With the largest stiffness at so many times the nominal load, stiffness is proportional to load: to 1e-8 at loads
/// that wheels have.
const PROPORTIONAL: f64 = 1e4;
/// Axles whose stiffness / load differs by less are equal.
const EQUAL: f64 = 1e-9;
/// Formatted numbers lose nothing; what is reckoned with them a few last digits.
const SAME: f64 = 1e-6;

/// What is to be said of a car besides its table.
pub struct About<'a> {
    /// Where the table comes from.
    pub source: &'a str,
    /// Is this key of the table given, or a default?
    pub is_given: &'a dyn Fn(&str) -> bool,
    /// Effects beside the table, which a tire file cannot hold.
    pub effects: Vec<&'a str>,
}

/// The wheels that a file is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axle {
    /// All: one tire that has each axle's stiffness at that axle's load.
    Both,
    /// The front ones.
    Front,
    /// The rear ones.
    Rear,
}

/// The files of a car.
#[derive(Clone, Debug)]
pub struct Written {
    /// Each file's text: one for both axles, or front and rear.
    pub files: Vec<(Axle, String)>,
    /// What does not come out as the table has it, or is a default; it stands in the files, too.
    pub notes: Vec<String>,
}

/// Writes a car's tires.
///
/// One file serves where one tire can have the cornering stiffnesses of both axles at their loads: a tire's stiffness
/// grows slower than its load. Else each axle has its own, in which stiffness is proportional to load.
///
/// # Errors
/// If the table has numbers that no tire has.
pub fn of_vehicle(vehicle: &Vehicle, about: &About<'_>) -> Result<Written, TireFileError> {
    let Closest { formula, difference } = Tire::new(vehicle).closest_magic_formula();
    let notes = notes(vehicle, about, difference);
    let loads = [true, false].map(|front| vehicle.static_wheel_load(front));
    let normalized = [vehicle.lateral_stiffness_front.value, vehicle.lateral_stiffness_rear.value];
    let sheet = |axle, nominal, cornering, by_load| {
        let longitudinal = [vehicle.wheel_longitudinal_stiffness() / nominal, by_load];
        (axle, Sheet { axle, nominal, cornering, longitudinal, formula }.text(vehicle, about, &notes))
    };
    let files = match one_tire(loads, normalized) {
        Some(cornering) => vec![sheet(Axle::Both, loads[0], cornering, constant_over(loads))],
        None => {
            let each = |place: usize| [proportional(normalized[place]), PROPORTIONAL];
            vec![sheet(Axle::Front, loads[0], each(0), 0.0), sheet(Axle::Rear, loads[1], each(1), 0.0)]
        }
    };
    for (place, load) in loads.into_iter().enumerate() {
        let (axle, text) = files.get(place).or(files.first()).ok_or_else(|| nothing("there is no file"))?;
        let name = match axle {
            Axle::Both => "the tires of both axles",
            Axle::Front => "the front tires",
            Axle::Rear => "the rear tires",
        };
        let read = TireFile::parse(text, name)?.at(load)?;
        let should = AtLoad {
            shape: formula.shape,
            curvature: formula.curvature,
            friction: vehicle.friction.value,
            lateral_stiffness: normalized[place],
            longitudinal_stiffness: Some(vehicle.wheel_longitudinal_stiffness() / load),
        };
        if !is_same(&read, &should) {
            return Err(nothing("these numbers do not come back from a file; give such as a tire can have"));
        }
    }
    Ok(Written { files, notes })
}

fn nothing(reason: &str) -> TireFileError {
    TireFileError::Whole { file: "the tires".into(), reason: reason.into() }
}

fn is_same(read: &AtLoad, should: &AtLoad) -> bool {
    let numbers = |at: &AtLoad| {
        let longitudinal = at.longitudinal_stiffness.unwrap_or(0.0);
        [at.shape, at.curvature, at.friction, at.lateral_stiffness, longitudinal]
    };
    numbers(read).iter().zip(numbers(should)).all(|(is, should)| (is - should).abs() <= SAME * should.abs())
}

/// PKY1 and PKY2 of the tire that has these stiffnesses / load at these loads, of a front and a rear wheel; the nominal
/// load is the front one's.
///
/// sin(2 atan z) = 2 z / (1 + z²) with z = load / (PKY2 nominal load) makes the ratio of the two
/// (1 + z_r²) / (1 + z_f²), and z_f is z_r by the ratio of the loads. Both loads must be below that of the largest
/// stiffness: beyond it a tire that carries more would be softer.
fn one_tire([front, rear]: [f64; 2], [stiffness, of_rear]: [f64; 2]) -> Option<[f64; 2]> {
    let (ratio, by_load) = (stiffness / of_rear, front / rear);
    if (ratio - 1.0).abs() < EQUAL {
        return Some([proportional(stiffness), PROPORTIONAL]);
    }
    let rear_square = (1.0 - ratio) / (ratio * by_load * by_load - 1.0);
    let z = by_load * rear_square.sqrt();
    // Not a number where the axle with more load is the stiffer one.
    let is_possible = z > 1.0 / PROPORTIONAL && z <= 1.0 && rear_square <= 1.0;
    is_possible.then(|| [-stiffness * (1.0 + z * z) / (2.0 * z), 1.0 / z])
}

/// PKY1 of a tire with this stiffness / load at every load.
fn proportional(stiffness: f64) -> f64 {
    let z = 1.0 / PROPORTIONAL;
    -stiffness * (1.0 + z * z) / (2.0 * z)
}

/// PKX3 with which a front and a rear wheel have the same longitudinal stiffness, in N per unit slip, as the plain car's.
fn constant_over([front, rear]: [f64; 2]) -> f64 {
    let d = rear / front - 1.0;
    if d.abs() < EQUAL { 0.0 } else { -d.ln_1p() / d }
}

/// What a reader should know.
fn notes(vehicle: &Vehicle, about: &About<'_>, difference: f64) -> Vec<String> {
    let mut notes = Vec::new();
    let in_place_of = match vehicle.tire {
        TireKind::MagicFormula => None,
        TireKind::Brush => Some("the brush model"),
        TireKind::Piecewise => Some("the piecewise linear model"),
        TireKind::Linear => Some("the linear model, which has no limit,"),
    };
    if let Some(model) = in_place_of {
        notes.push(format!(
            "the closest magic formula in place of {model}: same initial slope and limit, up to {:.0} % of the friction apart between",
            100.0 * difference
        ));
    }
    if !(about.is_given)("friction") {
        notes.push("friction is not given in [vehicle]: 1.0 in its place".into());
    }
    let defaults: Vec<_> = ["lateral_stiffness_front", "lateral_stiffness_rear", "longitudinal_stiffness"]
        .into_iter()
        .filter(|key| !(about.is_given)(key))
        .collect();
    if !defaults.is_empty() {
        notes.push(format!("not given in [vehicle], a usual car's in place: {}", defaults.join(", ")));
    }
    if !about.effects.is_empty() {
        notes.push(format!(
            "the plain tires; left out is what [[effect]] tables add: {}",
            about.effects.join(", ")
        ));
    }
    notes
}

/// The numbers of one file.
struct Sheet {
    axle: Axle,
    /// Nominal load, N.
    nominal: f64,
    /// PKY1, PKY2.
    cornering: [f64; 2],
    /// PKX1, PKX3.
    longitudinal: [f64; 2],
    formula: MagicFormula,
}

impl Sheet {
    fn text(&self, vehicle: &Vehicle, about: &About<'_>, notes: &[String]) -> String {
        let mut page = Page::new();
        let wheels = match self.axle {
            Axle::Both => "all wheels",
            Axle::Front => "the front wheels",
            Axle::Rear => "the rear wheels",
        };
        page.section("MDI_HEADER");
        page.words("FILE_TYPE", "tir");
        page.number("FILE_VERSION", 3.0, "");
        page.words("FILE_FORMAT", "ASCII");
        page.comment(&format!("Tires of {wheels}, written by gripd export from {}", ascii(about.source)));
        page.comment("A subset of MF-Tyre 5.2 and 6.1: pure slip, no camber. Pacejka, Tire and Vehicle");
        page.comment("Dynamics, 3rd edition 2012, chapter 4. Coefficients that are not here are zero.");
        page.comment("Right at the static loads of the car's wheels; axle and steering give way within");
        page.comment("the stiffnesses. Angles in ISO axes: a positive slip angle has a negative force.");
        notes.iter().for_each(|note| page.comment(&ascii(note)));
        page.section("UNITS");
        for (key, unit) in [
            ("LENGTH", "meter"),
            ("FORCE", "newton"),
            ("ANGLE", "radians"),
            ("MASS", "kg"),
            ("TIME", "second"),
        ] {
            page.words(key, unit);
        }
        page.section("MODEL");
        page.words("PROPERTY_FILE_FORMAT", "MF-TYRE");
        page.words("TYPE", "CAR");
        page.integer("FITTYP", 61, "magic formula 6.1");
        page.section("DIMENSION");
        let radius = with_std(
            "nothing is known of the unloaded radius, which is larger; rolling radius",
            vehicle.wheel_radius_m,
        );
        page.number("UNLOADED_RADIUS", vehicle.wheel_radius_m.value, &radius);
        page.section("VERTICAL");
        let of = if self.axle == Axle::Rear {
            "static load of a rear wheel, N"
        } else {
            "static load of a front wheel, N"
        };
        page.number("FNOMIN", self.nominal, of);
        page.section("SCALING_COEFFICIENTS");
        for key in
            ["LFZO", "LCX", "LMUX", "LEX", "LKX", "LHX", "LVX", "LCY", "LMUY", "LEY", "LKY", "LHY", "LVY"]
        {
            page.number(key, 1.0, "");
        }
        self.longitudinal(&mut page, vehicle);
        self.lateral(&mut page, vehicle);
        page.into_text()
    }

    fn longitudinal(&self, page: &mut Page, vehicle: &Vehicle) {
        page.section("LONGITUDINAL_COEFFICIENTS");
        page.number("PCX1", self.formula.shape, "shape C: the lateral force's");
        page.number("PDX1", vehicle.friction.value, &with_std("friction", vehicle.friction));
        page.zeros(&["PDX2", "PDX3"]);
        page.number("PEX1", self.formula.curvature, "curvature E: the lateral force's");
        page.zeros(&["PEX2", "PEX3", "PEX4"]);
        let stiffness = with_std("longitudinal stiffness / (m g / 4)", vehicle.longitudinal_stiffness);
        page.number("PKX1", self.longitudinal[0], &stiffness);
        page.zeros(&["PKX2"]);
        page.number("PKX3", self.longitudinal[1], "");
        page.zeros(&["PHX1", "PHX2", "PVX1", "PVX2"]);
    }

    fn lateral(&self, page: &mut Page, vehicle: &Vehicle) {
        let is_own = vehicle.tire == TireKind::MagicFormula;
        let of_formula = |name: &str, number| if is_own { with_std(name, number) } else { name.to_owned() };
        page.section("LATERAL_COEFFICIENTS");
        page.number("PCY1", self.formula.shape, &of_formula("shape C", vehicle.magic_formula_shape));
        page.number("PDY1", vehicle.friction.value, &with_std("friction", vehicle.friction));
        page.zeros(&["PDY2", "PDY3"]);
        page.number(
            "PEY1",
            self.formula.curvature,
            &of_formula("curvature E", vehicle.magic_formula_curvature),
        );
        page.zeros(&["PEY2", "PEY3", "PEY4", "PEY5"]);
        let [front, rear] =
            [("front", vehicle.lateral_stiffness_front), ("rear", vehicle.lateral_stiffness_rear)].map(
                |(axle, number)| with_std(&format!("{axle} cornering stiffness / load, 1/rad:"), number),
            );
        match self.axle {
            Axle::Both => {
                page.comment(&front);
                page.comment(&rear);
            }
            Axle::Front => page.comment(&front),
            Axle::Rear => page.comment(&rear),
        }
        let by_load = if self.cornering[1] >= PROPORTIONAL {
            "so large that stiffness is proportional to load"
        } else {
            "by which it has both axles' stiffness at their loads"
        };
        page.number("PKY1", self.cornering[0], "");
        page.number("PKY2", self.cornering[1], by_load);
        page.zeros(&["PKY3"]);
        page.number("PKY4", 2.0, "");
        page.zeros(&["PKY5", "PKY6", "PKY7", "PHY1", "PHY2", "PVY1", "PVY2", "PVY3", "PVY4"]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::model::Uncertain;
    use proptest::prelude::*;

    fn about(given: &dyn Fn(&str) -> bool) -> About<'_> {
        About { source: "car.toml", is_given: given, effects: Vec::new() }
    }

    fn car(front: f64, rear: f64, to_front: f64) -> Vehicle {
        let mut vehicle = Vehicle::thesis();
        vehicle.cg_to_front_m = Uncertain::known(to_front);
        vehicle.lateral_stiffness_front = Uncertain::known(front);
        vehicle.lateral_stiffness_rear = Uncertain::known(rear);
        vehicle
    }

    fn axles(vehicle: &Vehicle) -> Vec<Axle> {
        let written = of_vehicle(vehicle, &about(&|_| true)).unwrap();
        written.files.iter().map(|(axle, _)| *axle).collect()
    }

    #[test]
    fn one_file_serves_where_the_axle_with_more_load_is_softer_by_load() {
        assert_eq!(axles(&car(12.0, 14.0, 1.3)), [Axle::Both]);
        assert_eq!(axles(&car(14.0, 12.0, 1.7)), [Axle::Both]);
        assert_eq!(axles(&car(12.0, 12.0, 1.3)), [Axle::Both]);
        // No tire: more load and stiffer by load, so much softer that more load would be less force, or equal loads.
        for (front, rear, to_front) in [(14.0, 12.0, 1.3), (8.0, 16.0, 1.3), (12.0, 14.0, 1.5)] {
            assert_eq!(axles(&car(front, rear, to_front)), [Axle::Front, Axle::Rear]);
        }
    }

    #[test]
    fn other_models_and_defaults_are_said() {
        let mut vehicle = car(12.0, 14.0, 1.3);
        vehicle.tire = TireKind::Brush;
        let written = of_vehicle(&vehicle, &about(&|key| key != "friction")).unwrap();
        assert!(
            written.notes[0].contains("brush") && written.notes[0].contains("4 %"),
            "{:?}",
            written.notes
        );
        assert!(written.notes[1].contains("friction is not given"), "{:?}", written.notes);
        for note in &written.notes {
            assert!(written.files[0].1.contains(&format!("$ {note}\n")), "{note}");
        }
        vehicle.tire = TireKind::MagicFormula;
        assert!(of_vehicle(&vehicle, &about(&|_| true)).unwrap().notes.is_empty());
    }

    #[test]
    fn numbers_that_no_tire_has_are_refused() {
        let error = of_vehicle(&car(1e4, 1e4, 1.3), &about(&|_| true)).unwrap_err().to_string();
        assert!(error.contains("PKY1") && error.contains("cornering stiffness"), "{error}");
    }

    #[test]
    fn a_name_cannot_end_its_comment() {
        let about = About { source: "a\nPKY1 = 3 é", ..about(&|_| true) };
        let written = of_vehicle(&car(12.0, 14.0, 1.3), &about).unwrap();
        assert!(written.files[0].1.is_ascii() && written.files[0].1.contains("from a?PKY1 = 3 ?\n"));
    }

    proptest! {
        /// `of_vehicle` reads its files back by itself; here is that it finds no car for which they are wrong.
        #[test]
        fn every_car_comes_back(
            front in 4.0..60.0, rear in 4.0..60.0, to_front in 0.6..2.4, slope in 10.0..200.0,
            friction in 0.1..2.0, shape in 1.0..2.0, curvature in -10.0..1.0,
        ) {
            let mut vehicle = car(front, rear, to_front);
            let known = Uncertain::known;
            vehicle.tire = TireKind::MagicFormula;
            vehicle.longitudinal_stiffness = known(slope);
            vehicle.friction = known(friction);
            vehicle.magic_formula_shape = known(shape);
            vehicle.magic_formula_curvature = known(curvature);
            let written = of_vehicle(&vehicle, &about(&|_| true));
            prop_assert!(written.is_ok(), "{:?}", written.map_err(|error| error.to_string()));
        }
    }
}
