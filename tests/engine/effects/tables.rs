//! What an `[[effect]]` table may say; the table of the guide.

use std::path::Path;

use gripd::Config;
use gripd::model::Scenario;
use gripd::model::effect::{EffectConfig, KINDS};

use super::support::*;
use super::together::MANY;

/// What is wrong, and what the message must name.
const WRONG: &[(&str, &[&str])] = &[
    ("kind = \"flux_capacitor\"", &["line", "flux_capacitor", "load_transfer", "wheel_alignment"]),
    ("cg_height_m = 0.5", &["line", "kind is missing", "load_transfer"]),
    ("kind = \"load_transfer\"", &["line", "load_transfer", "cg_height_m", "is missing"]),
    (
        "kind = \"load_transfer\"\ncg_hight_m = 0.5",
        &[
            "cg_hight_m",
            "no such key",
            "cg_height_m, load_sensitivity, load_sensitivity_along, front_roll_share, radius_loss_m_per_n, load_sensitivity_growth",
        ],
    ),
    ("cg_hight_m = 0.5\nkind = \"load_transfer\"", &["cg_hight_m", "no such key", "cg_height_m"]),
    ("name = \"load_transfer\"\ncg_height_m = 0.5", &["kind is missing", "load_transfer"]),
    ("kind = \"load_transfer\"\nname = \"my car's\"", &["name", "no such key", "cg_height_m"]),
    ("kind = \"load_transfer\"\ncg_height_m = -0.5", &["cg_height_m", "-0.5", "0 to 1.5 m"]),
    ("kind = \"load_transfer\"\ncg_height_m = nan", &["cg_height_m", "finite"]),
    ("kind = \"load_transfer\"\ncg_height_m = \"high\"", &["line", "a number or"]),
    ("kind = \"load_transfer\"\ncg_height_m = { value = 0.5, std = -1 }", &["cg_height_m", "std = -1"]),
    ("kind = \"load_transfer\"\ncg_height_m = { value = 0.5, stdd = 1 }", &["line"]),
    ("kind = \"load_transfer\"\ncg_height_m = 0.5\nvalue = 1", &["value", "no such key"]),
    ("kind = \"load_transfer\"\ncg_height_m = 0.5\nchannel = \"yaw_rate\"", &["channel", "takes none"]),
    ("kind = \"sensor_bias\"\nbias = 0.1", &["sensor_bias", "channel", "is missing", "yaw_rate"]),
    ("kind = \"sensor_bias\"\nchannel = \"yaw\"\nbias = 0.1", &["channel", "`yaw`"]),
    (
        "kind = \"sensor_bias\"\nchannel = \"vehicle_speed\"\nbias = 0.1",
        &["channel", "vehicle_speed", "yaw_rate"],
    ),
    ("kind = \"sensor_bias\"\nchannel = \"yaw_rate\"\nbias = 9", &["bias", "-0.2 to 0.2 rad/s"]),
    ("kind = \"channel_swap\"\nchannel = \"yaw_rate\"", &["channel", "wheel_speed_fl/wheel_speed_fr"]),
    ("kind = \"road_bank\"", &["road_bank", "value", "intervals", "series"]),
    ("kind = \"road_bank\"\nvalue = inf", &["value", "inf"]),
    ("kind = \"road_bank\"\nvalue = 5", &["value", "5", "-3 to 3 rad"]),
    ("kind = \"road_bank\"\nintervals = [[1, 2]]", &["value", "missing"]),
    ("kind = \"road_bank\"\nvalue = 0.1\nintervals = [[2, 1]]", &["intervals", "[2, 1]"]),
    ("kind = \"road_bank\"\nvalue = 0.1\nintervals = [[1, 3], [2, 4]]", &["intervals", "[2, 4]", "3 s"]),
    ("kind = \"road_bank\"\nvalue = 0.1\nintervals = []", &["intervals", "empty"]),
    (
        "kind = \"road_bank\"\nvalue = 0.1\nintervals = [[1, 2, 3]]",
        &["intervals", "[1.0, 2.0, 3.0]", "from, to"],
    ),
    ("kind = \"road_bank\"\nseries = { t = [0, 1], value = [0] }", &["series", "2 times and 1 values"]),
    ("kind = \"road_bank\"\nseries = { t = [0], value = [0] }", &["series", "two points"]),
    (
        "kind = \"road_bank\"\nseries = { t = [0, 2, 1], value = [0, 0, 0] }",
        &["series", "t = 1 comes after 2"],
    ),
    ("kind = \"road_bank\"\nseries = { t = [0, nan], value = [0, 0] }", &["series", "NaN"]),
    ("kind = \"road_bank\"\nseries = { t = [0, 1], value = [0, inf] }", &["series", "inf"]),
    ("kind = \"road_bank\"\nseries = { t = [0, 1], values = [0, 0] }", &["line", "values"]),
    (
        "kind = \"road_bank\"\nvalue = 0.1\nseries = { t = [0, 1], value = [0, 0] }",
        &["series", "remove value"],
    ),
    ("kind = \"friction_change\"\nfriction = 0.3\nvalue = 80", &["value", "80", "0 to 1"]),
    ("kind = \"friction_change\"\nvalue = 1", &["friction", "is missing"]),
    ("kind = \"friction_change\"\nfriction = 0\nvalue = 1", &["friction", "0.0303 or more"]),
    ("kind = \"friction_split\"\nfriction_left = 0.3\nvalue = 1", &["friction_right", "is missing"]),
    (
        "kind = \"air_drag\"\ndrag_coefficient_kg_per_m = 1\n[[effect]]\nkind = \"air_drag\"\ndrag_coefficient_kg_per_m = 2",
        &["effect[1].kind", "air_drag is there already, as effect[0]"],
    ),
    (
        "kind = \"sensor_delay\"\nchannel = \"yaw_rate\"\ndelay_s = -0.05",
        &["sensors.yaw_rate.delay_ms", "50.0 ms early"],
    ),
];

#[test]
fn what_cannot_be_is_refused_by_key_and_with_what_can() {
    for (table, parts) in WRONG {
        let text = format!(
            "duration_s = 1\ninitial_speed_mps = 20\nsensors.yaw_rate.period_ms = 10\n{CAR}\n[[effect]]\n{table}"
        );
        let message = match Scenario::parse(&text) {
            Ok(_) => panic!("accepted:\n{table}"),
            Err(error) => error.to_string(),
        };
        for part in *parts {
            assert!(message.contains(part), "{table}\n\n{message}\n\nshould name {part}");
        }
    }
}

const CONFIG: &str = r#"
    dbc.input = ["car.dbc"]
    [signals]
    wheel_speed_fl = "A.B"
    wheel_speed_fr = "A.B"
    wheel_speed_rl = "A.B"
    wheel_speed_rr = "A.B"
    yaw_rate = "A.B"
    lateral_acceleration = "A.B"
    steering_wheel_angle = "A.B"
"#;

#[test]
fn the_configuration_takes_the_same_tables() {
    let car = CAR.replace("seed = 1", "");
    let config = Config::parse(&format!("{CONFIG}{car}{MANY}"), Path::new("car.toml")).unwrap();
    assert_eq!(config.effect.len(), 7);
    let names: Vec<_> =
        EffectConfig::in_order(&config.effect).iter().map(|config| config.kind().name).collect();
    assert_eq!(names[0], "steering_lag", "in the order in which they act");
    assert_eq!(EffectConfig::effects(&config.effect).len(), 7);
    let written = EffectConfig::write_all(&config.effect);
    let again = Config::parse(&format!("{CONFIG}{car}{written}"), Path::new("car.toml")).unwrap();
    assert_eq!(again.effect, config.effect);

    let refused = |table: &str| {
        let text = format!("{CONFIG}{car}[[effect]]\n{table}");
        Config::parse(&text, Path::new("garage/car.toml")).unwrap_err().to_string()
    };
    let message = refused("kind = \"payload\"\nmas_kg = 3");
    for part in ["garage/car.toml", "line", "mas_kg", "mass_kg"] {
        assert!(message.contains(part), "{message}");
    }
    let twice = "kind = \"air_drag\"\ndrag_coefficient_kg_per_m = 1\n";
    assert!(refused(&format!("{twice}[[effect]]\n{twice}")).contains("effect[1].kind"));
}

/// A scenario with effects survives being written.
#[test]
fn scenarios_with_effects_are_written_and_read() {
    let scenario = scenario(1.0, 20.0, "linear", "", MANY);
    let text = toml::to_string(&scenario).unwrap();
    assert_eq!(Scenario::parse(&text).unwrap(), scenario);
}

/// The table of the guide, from what the kinds say of themselves.
fn table_of_kinds() -> String {
    let mut text =
        String::from("| `kind` | `channel` | keys (unit; usual value) | what it is |\n|---|---|---|---|\n");
    for kind in KINDS {
        let channel = match kind.channels.first() {
            None => "",
            Some(channel) if channel.quantity().is_some() => "one",
            Some(_) => "two",
        };
        let unit = |unit: &str| match unit {
            "1" => None,
            gripd::model::effect::OF_CHANNEL => Some("the channel's".to_owned()),
            unit => Some(unit.to_owned()),
        };
        let parameters = kind.parameters.iter().map(|spec| {
            let usual = (!spec.is_main).then(|| match spec.name {
                "at_s" => "from the start".to_owned(),
                _ => spec.value(spec.mean).to_string(),
            });
            let notes: Vec<_> = unit(spec.unit).into_iter().chain(usual).collect();
            let notes = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join("; ")) };
            format!("`{}`{notes}", spec.name)
        });
        let course = kind.course.map(|course| match (course.sign > 0.0, unit(course.unit)) {
            (true, _) => "course of the share, 0 to 1".to_owned(),
            (false, of) => format!("course ({})", of.unwrap_or_default()),
        });
        let keys = parameters.chain(course).collect::<Vec<_>>().join(", ");
        text +=
            &format!("| `{}` | {channel} | {keys} | {} |\n", kind.name, kind.about).replace("|  |", "| |");
    }
    text
}

#[test]
fn the_guide_lists_every_kind() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/src/guide/explain-a-mismatch.md");
    let guide = std::fs::read_to_string(page).unwrap();
    let table = table_of_kinds();
    assert!(guide.contains(&table), "the guide should have this table:\n\n{table}");
}
