//! GIVEN the mapping of what is published to COVESA's VSS WHEN the KUKSA CAN provider's libraries apply it THEN friction is told
//! in percent, clamped, and what is not available or not valid is not told at all.

use std::fs;
use std::process::Command;

use gripd::dbc::Database;
use gripd::signals::publish::built_in_database;
use serde_json::Value;
use testing::program::project;

/// All leaves of a tree of VSS.
fn leaves<'v>(node: &'v Value, path: &str, found: &mut Vec<(String, &'v Value)>) {
    for (name, child) in node.as_object().unwrap() {
        let path = format!("{path}{name}");
        match child.get("children") {
            Some(children) => leaves(children, &format!("{path}."), found),
            None => found.push((path, child)),
        }
    }
}

#[test]
fn the_mapping_names_what_is_published() {
    let text = fs::read_to_string(project("config/vss/vss_dbc.json")).unwrap();
    let tree: Value = serde_json::from_str(&text).unwrap();
    let mut found = Vec::new();
    leaves(&tree, "", &mut found);
    assert_eq!(found.len(), 3);
    let database = built_in_database().unwrap();
    let friction = database.message("GRIP_FRICTION").unwrap();
    for (path, leaf) in found {
        assert!(path.starts_with("Vehicle.ADAS.ESC.RoadFriction."), "{path}");
        let rule = &leaf["dbc2vss"];
        let name = rule["signal"].as_str().unwrap();
        // The provider finds signals by their names alone.
        let with_that_name = database.messages().iter().filter(|message| message.signal(name).is_some());
        assert_eq!(with_that_name.count(), 1, "{name}");
        let signal = friction.signal(name).unwrap();
        assert!(signal.value_named("not_available").is_some(), "{name}");
        for condition in rule.get("multiplexer").and_then(Value::as_array).into_iter().flatten() {
            assert!(friction.signal(condition["signal"].as_str().unwrap()).is_some());
        }
        assert_eq!((&leaf["unit"], &leaf["min"], &leaf["max"]), (&"percent".into(), &0.into(), &100.into()));
    }
}

#[test]
fn the_providers_layout_is_that_of_what_is_published() {
    let ours = built_in_database().unwrap();
    let theirs = Database::load(&project("config/vss/friction.dbc")).unwrap();
    let [ours, theirs] = [&ours, &theirs].map(|database| database.message("GRIP_FRICTION").unwrap());
    assert_eq!((ours.id, ours.length), (theirs.id, theirs.length));
    assert_eq!(ours.signals.len(), theirs.signals.len());
    for (ours, theirs) in ours.signals.iter().zip(&theirs.signals) {
        assert_eq!((&ours.name, &ours.unit, ours.codec()), (&theirs.name, &theirs.unit, theirs.codec()));
        assert_eq!(ours.value_named("not_available"), theirs.value_named("not_available"), "{}", ours.name);
    }
    assert!(theirs.signal("MuValid").unwrap().values.is_empty(), "the provider compares it with a number");
}

#[test]
fn the_provider_tells_percent_and_nothing_that_is_not_known() {
    let Some(python) = testing::python() else { return };
    let output = Command::new(python).arg(project("tests/peers/vss.py")).arg(project(".")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "6144");
}
