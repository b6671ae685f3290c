//! `gripd export --tir` and `[vehicle] tire_file`: tires to a property file and back, those of other programs, and what is
//! refused.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Output, Stdio};

use gripd::Config;
use gripd::model::tire::{Closest, Curve, Tire};
use gripd::model::{Scenario, TireKind, Uncertain, Vehicle};
use testing::program::{gripd, gripd_in, project};

/// A car whose tires are `tires`: lines of its `[vehicle]` table.
fn car(tires: &str) -> String {
    format!(
        "[dbc]\ninput = ['{}']\n[signals]\nyaw_rate = 'INERTIAL.YawRate'\nsteering_wheel_angle = 'STEERING.Angle'\n\
         wheel_speed_rl = 'WHEELS.SpeedRL'\n[vehicle]\nmass_kg = 1450\nwheelbase_m = 2.65\ncg_to_front_m = 1.2\n\
         wheel_radius_m = 0.31\nsteering_ratio = 15.5\ndriven_axle = 'front'\n{tires}\n",
        project("dbc/demo.dbc").display()
    )
}

/// A tire as other programs write it: their case, quotes, comments in another code page, sections and tables of no use
/// here, and scales.
const FOREIGN: &[u8] = b"! Reifen 205/55 R16 \xfcber alles $\r\n\
    [MDI_HEADER]\r\nFILE_TYPE='tir'\r\nFILE_VERSION =3.0\r\n\
    [units]\r\n length   = 'Meter'  $ SI\r\nForce='NEWTON'\r\nangle = \"radians\"\r\n\
    [Model]\r\nproperty_file_format = 'PAC2002' ! car's\r\nTYPE = 'CAR'\r\nTYRESIDE = 'LEFT'\r\nUSE_MODE = 14\r\n\
    [SHAPE]\r\n{radial width}\r\n 1.0 0.0\r\n 1.0 0.4\r\n\
    [VERTICAL]\r\nvertical_stiffness = 2.1e+005\r\nFnomin = 4.0D+003 $ N\r\n\
    [SCALING_COEFFICIENTS]\r\nLFZO=1.05\r\nLCY=1.1\r\nLMUY = 0.8\r\nLEY = 0.5\r\nLKY = 0.9\r\nLKX = 0.7\r\nLMUX = 3\r\n\
    [LATERAL_COEFFICIENTS]\r\npcy1 = 1.25\r\nPDY1 = 1.05\r\nPDY2 = -0.15\r\nPDY3 = 2\r\nPEY1 = -0.9\r\nPEY2 = -0.3\r\n\
    PEY3 = 0.2\r\nPKY1 = -22.0\r\nPKY2 = 1.7\r\nPKY3 = 0.1\r\nPHY1 = 0.003\r\nPVY1 = 0.02\r\n\
    [LONGITUDINAL_COEFFICIENTS]\r\nPCX1 = 1.7\r\nPDX1 = 1.1\r\nPKX1 = 24\r\nPKX2 = -0.3\r\nPKX3 = 0.2\r\n\
    [ALIGNING_COEFFICIENTS]\r\nQBZ1 = 10\r\nQBZ9 = nonsense\r\n";

fn load(folder: &Path, text: &str) -> Result<Config, String> {
    fs::write(folder.join("car.toml"), text).unwrap();
    Config::load(&folder.join("car.toml")).map_err(|error| error.to_string())
}

fn told(output: &Output) -> String {
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!told.contains("panicked"), "{told}");
    told
}

/// The table without what it says of its tires, and with a tire file in its place.
fn with_tire_file(config: &str, tire_file: &str) -> String {
    let is_tire = |line: &&str| {
        ["tire ", "tire=", "friction", "magic_formula", "lateral_stiffness", "longitudinal_stiffness"]
            .iter()
            .any(|key| line.starts_with(key))
    };
    let rest: Vec<_> = config.lines().filter(|line| !is_tire(line)).collect();
    let key = format!("\n[vehicle]\ntire_file = {tire_file}\n");
    rest.join("\n").replacen("\n[vehicle]\n", &key, 1).replace("../dbc", project("dbc").to_str().unwrap())
}

/// Forces of each axle over slip angles and slips: of what was exported, and of what was read.
fn assert_same_forces(exported: &Vehicle, read: &Vehicle) {
    assert_eq!(read.tire, TireKind::MagicFormula);
    let Closest { formula, .. } = Tire::new(exported).closest_magic_formula();
    let [was, is] = [Tire::MagicFormula(formula), Tire::new(read)];
    let close = |was: f64, is: f64, at: f64| {
        assert!((was - is).abs() <= 1e-6 * was.abs(), "{was} became {is} at {at}");
    };
    for front in [true, false] {
        let load = exported.static_wheel_load(front);
        let lateral = |vehicle: &Vehicle| vehicle.wheel_cornering_stiffness(front) / load;
        let longitudinal = |vehicle: &Vehicle| vehicle.wheel_longitudinal_stiffness() / load;
        for place in -60..=60 {
            let slip = 0.01 * f64::from(place);
            close(
                was.force(lateral(exported), exported.friction.value, slip),
                is.force(lateral(read), read.friction.value, slip),
                slip,
            );
            close(
                was.force(longitudinal(exported), exported.friction.value, slip),
                is.force(longitudinal(read), read.friction.value, slip),
                slip,
            );
        }
    }
}

/// GIVEN the configurations of this repository WHEN their tires are exported and read THEN the forces are the same, and
/// what is not as the table has it is said.
#[test]
fn tires_come_back_with_the_same_forces() {
    for (name, files, said) in [
        ("demo", &["x.tir"][..], &["closest magic formula", "piecewise linear"][..]),
        (
            "rav4",
            &["x.tir"],
            &["closest magic formula", "friction is not given", "1.0", "longitudinal_stiffness"],
        ),
        ("thesis", &["x_front.tir", "x_rear.tir"], &["x_front.tir", "x_rear.tir"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = project(&format!("config/{name}.toml"));
        let output = gripd_in(folder.path(), &format!("export -c {} --tir x.tir", path.display()));
        let stderr = told(&output);
        assert_eq!(output.status.code(), Some(0), "{stderr}");
        for word in said {
            assert!(stderr.contains(word), "no `{word}` in {stderr}");
        }
        let mut there: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        there.sort();
        assert_eq!(there, files);
        let text = fs::read_to_string(folder.path().join(files[0])).unwrap();
        assert!(text.is_ascii() && text.contains("closest magic formula") && text.contains("+-"), "{text}");
        let exported = Config::load(&path).unwrap().vehicle;
        let again = with_tire_file(
            &fs::read_to_string(&path).unwrap(),
            &format!("{files:?}").replace("[\"x.tir\"]", "'x.tir'"),
        );
        assert_same_forces(&exported, &load(folder.path(), &again).unwrap().vehicle);
    }
}

/// GIVEN magic formula tires WHEN they are exported THEN nothing needs to be said, and they come back, whichever axle is
/// the stiffer one.
#[test]
fn a_magic_formula_is_written_as_it_is() {
    for (front, rear, file) in [(12.0, 14.0, "'x.tir'"), (14.0, 12.0, "['x_front.tir', 'x_rear.tir']")] {
        let folder = tempfile::tempdir().unwrap();
        let own = car(&format!(
            "tire = 'magic_formula'\nmagic_formula_shape = 1.45\nmagic_formula_curvature = -0.8\nfriction = 0.93\n\
             lateral_stiffness_front = {{ value = {front}, std = 0.4 }}\nlateral_stiffness_rear = {rear}\n\
             longitudinal_stiffness = 33.3"
        ));
        let exported = load(folder.path(), &own).unwrap().vehicle;
        let output = gripd_in(folder.path(), "-q export -c car.toml --tir x.tir");
        assert_eq!((output.status.code(), told(&output)), (Some(0), String::new()));
        let read = load(folder.path(), &with_tire_file(&own, file)).unwrap();
        assert_same_forces(&exported, &read.vehicle);
        assert!(read.is_given("friction") && !read.is_given("track_front_m"));
        // A file knows no deviation: the axle's is that of the class of car.
        let std = read.vehicle.lateral_stiffness_front.std;
        assert!((std / front - 1.0 / 3.0).abs() < 1e-9, "{std}");
    }
}

/// GIVEN a file of another program THEN its numbers are those of the equations at this car's loads.
#[test]
fn files_of_other_programs_are_read() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("tires")).unwrap();
    fs::write(folder.path().join("tires/own.TIR"), FOREIGN).unwrap();
    let config = load(folder.path(), &car("tire_file = 'tires/own.TIR'")).unwrap();
    let vehicle = &config.vehicle;
    assert_eq!((vehicle.tire, &vehicle.tire_file), (TireKind::MagicFormula, &None));
    assert!(config.files().any(|file| file.ends_with("tires/own.TIR")));
    let nominal = 1.05 * 4000.0;
    let loads: [f64; 2] = [1450.0 * 9.81 * 1.45 / 2.65 / 2.0, 1450.0 * 9.81 * 1.2 / 2.65 / 2.0];
    let [d_front, d_rear] = loads.map(|load| (load - nominal) / nominal);
    let cornering = loads.map(|load| {
        let z = load / (1.7 * nominal);
        22.0 * nominal * (2.0 * z / (1.0 + z * z)) * 0.9 / load
    });
    let mean = 0.5 * (d_front + d_rear);
    let slope = loads[0] * (24.0 - 0.3 * d_front) * (0.2 * d_front).exp() * 0.7 / (1450.0 * 9.81 / 4.0);
    for (name, is, should) in [
        ("shape", vehicle.magic_formula_shape, 1.25 * 1.1),
        ("curvature", vehicle.magic_formula_curvature, (-0.9 - 0.3 * mean) * 0.5),
        ("friction", vehicle.friction, (1.05 - 0.15 * mean) * 0.8),
        ("front", vehicle.lateral_stiffness_front, cornering[0]),
        ("rear", vehicle.lateral_stiffness_rear, cornering[1]),
        ("slope", vehicle.longitudinal_stiffness, slope),
    ] {
        assert!((is.value - should).abs() < 1e-9, "{name}: {is:?}, not {should}");
    }
    let checked = gripd_in(folder.path(), "check -c car.toml");
    let stderr = told(&checked);
    assert_eq!(checked.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("own.TIR: 21 lines used, 19 of no use here"), "{stderr}");
}

/// GIVEN a tire file and numbers in the table THEN the table's count, a model that is no magic formula is refused, and two
/// files are one for each axle.
#[test]
fn the_table_is_above_its_tire_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("own.tir"), FOREIGN).unwrap();
    let softer = String::from_utf8_lossy(FOREIGN).replace("-22.0", "-11.0").replace("PCX1", "pcx1");
    fs::write(folder.path().join("softer.tir"), softer.replace("PKX1", "PKX9")).unwrap();
    let of = |tires: &str| load(folder.path(), &car(tires)).unwrap().vehicle;
    let plain = of("tire_file = 'own.tir'");
    let told = of("tire_file = 'own.tir'\ntire = 'magic_formula'\nfriction = { value = 0.7, std = 0.1 }\n\
         magic_formula_shape = 1.1\nlateral_stiffness_rear = 17");
    assert_eq!(told.friction, Uncertain { value: 0.7, std: 0.1 });
    assert_eq!(told.magic_formula_shape, Uncertain::known(1.1));
    assert_eq!(told.lateral_stiffness_rear, Uncertain::known(17.0));
    assert_eq!(told.lateral_stiffness_front, plain.lateral_stiffness_front);
    let two = of("tire_file = ['own.tir', 'softer.tir']");
    assert_eq!(two.lateral_stiffness_front, plain.lateral_stiffness_front);
    assert!((two.lateral_stiffness_rear.value - 0.5 * plain.lateral_stiffness_rear.value).abs() < 1e-9);
    assert_eq!(two.longitudinal_stiffness, plain.longitudinal_stiffness, "of the driven axle");
    let none = of("tire_file = ['softer.tir', 'own.tir']");
    assert_eq!(none.longitudinal_stiffness, Uncertain { value: 30.0, std: 15.0 }, "the default");
    let error = load(folder.path(), &car("tire_file = 'own.tir'\ntire = 'brush'")).unwrap_err();
    assert!(error.contains("vehicle.tire") && error.contains("leave one of them out"), "{error}");
}

/// GIVEN tire files that cannot be used THEN every command ends with 2 and names file, line, key and what to do.
#[test]
fn what_cannot_be_a_tire_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text = String::from_utf8_lossy(FOREIGN).into_owned();
    let write = |name: &str, text: &[u8]| fs::write(folder.path().join(name), text).unwrap();
    write("none.tir", b"");
    write("garbage.tir", &[0u8, 255, 7, 13, 200, b'=', b'['].repeat(1000));
    write("large.tir", &b"A = 1\n".repeat(200_000));
    write(
        "pac94.tir",
        b"[MODEL]\nPROPERTY_FILE_FORMAT = 'PAC94'\n[VERTICAL]\nFNOMIN = 4000\n[LATERAL]\nA0 = 1.4\n",
    );
    for (name, from, to) in [
        ("nan.tir", "PKY1 = -22.0", "PKY1 = nan"),
        ("word.tir", "PDY1 = 1.05", "PDY1 = high"),
        ("twice.tir", "PDY1 = 1.05", "PDY1 = 1.05\r\nPDY1 = 1.06"),
        ("kilo.tir", "Force='NEWTON'", "Force='kN'"),
        ("stone.tir", "Force='NEWTON'", "Force='stone'"),
        ("degrees.tir", "radians", "degrees"),
        ("slack.tir", "PKY1 = -22.0", "PKY1 = -0.001"),
        ("zero.tir", "LMUY = 0.8", "LMUY = 0"),
    ] {
        assert!(text.contains(from), "{from}");
        write(name, text.replacen(from, to, 1).as_bytes());
    }
    for (file, named) in [
        ("'missing.tir'", &["vehicle.tire_file", "missing.tir", "cannot read"][..]),
        ("'.'", &["cannot read the tire file", "ordinary file"]),
        ("'none.tir'", &["none.tir: FNOMIN: is missing", "5.2 or 6.1"]),
        ("'garbage.tir'", &["garbage.tir", "FNOMIN"]),
        ("'large.tir'", &["large.tir", "1024 KiB"]),
        ("'pac94.tir'", &["pac94.tir", "is missing", "this is 'PAC94'"]),
        ("'nan.tir'", &["nan.tir:37: PKY1 = nan", "finite number"]),
        ("'word.tir'", &["word.tir:31: PDY1 = high", "finite number"]),
        ("'twice.tir'", &["twice.tir:32: PDY1 = 1.06 again, and line 31 has 1.05"]),
        ("'kilo.tir'", &["kilo.tir:20: FNOMIN = 4.0D+003", "FORCE in [UNITS]"]),
        ("'stone.tir'", &["stone.tir:7: FORCE = stone", "write 'newton'"]),
        ("'degrees.tir'", &["degrees.tir:8: ANGLE = degrees", "write 'radians'"]),
        (
            "'slack.tir'",
            &["slack.tir:37: PKY1 = -0.001", "cornering stiffness / load of", "a tire has 0.5 to 300"],
        ),
        ("'zero.tir'", &["zero.tir:24: LMUY = 0: must be positive"]),
        ("['nan.tir']", &["car.toml", "line", "front.tir"]),
        ("7", &["car.toml", "line", "a file's name"]),
    ] {
        fs::write(folder.path().join("car.toml"), car(&format!("tire_file = {file}"))).unwrap();
        for command in ["check -c car.toml", "export -c car.toml --tir x.tir", "run -c car.toml"] {
            let output = gripd_in(folder.path(), command);
            let stderr = told(&output);
            assert_eq!(output.status.code(), Some(2), "{file}: {stderr}");
            for word in named {
                assert!(stderr.contains(word), "{file}: no `{word}` in {stderr}");
            }
        }
    }
    assert!(!folder.path().join("x.tir").exists());
    let scenario = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let error = Scenario::parse(&scenario.replacen("\n[vehicle]\n", "\n[vehicle]\ntire_file = 'x.tir'\n", 1))
        .unwrap_err();
    assert!(
        error.to_string().contains("vehicle.tire_file: is read in a car's configuration only"),
        "{error}"
    );
}

/// GIVEN a result's name that cannot be THEN it is refused and nothing is touched; `-` is the standard output.
#[test]
fn results_go_where_they_may() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("own.tir"), FOREIGN).unwrap();
    let text = car("tire_file = 'own.tir'");
    fs::write(folder.path().join("car.toml"), &text).unwrap();
    for (arguments, code, named) in [
        ("export -c car.toml", 2, "--tir"),
        ("export --tir x.tir", 2, "--config"),
        ("export -c none.toml --tir x.tir", 2, "none.toml"),
        ("export -c car.toml --tir car.toml", 2, "another name"),
        ("export -c car.toml --tir own.tir", 2, "another name"),
        ("check -c car.toml --json own.tir", 2, "another name"),
        ("export -c car.toml --tir no/such/x.tir", 1, "no/such"),
    ] {
        let output = gripd_in(folder.path(), arguments);
        let stderr = told(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {stderr}");
        assert!(stderr.contains(named), "{arguments}: {stderr}");
    }
    assert_eq!(fs::read(folder.path().join("own.tir")).unwrap(), FOREIGN);
    assert_eq!(fs::read_to_string(folder.path().join("car.toml")).unwrap(), text);
    let output = gripd_in(folder.path(), "export -c car.toml --tir -");
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&output.stdout).starts_with("[MDI_HEADER]\n"));
    // Two files do not fit into one stream.
    let thesis = format!("export -c {} --tir -", project("config/thesis.toml").display());
    let output = gripd_in(folder.path(), &thesis);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0));
    assert!(told(&output).contains("two files"));
    // Who reads may stop.
    let mut child = gripd()
        .current_dir(folder.path())
        .args(["-q", "export", "-c", "car.toml", "--tir", "-"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!((child.wait().unwrap().code(), stderr.as_str()), (Some(0), ""));
}
