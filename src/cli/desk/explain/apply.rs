//! The configuration with what was found: effects, and the ordinary numbers as they are beside them.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use crate::cli::Failure;
use bus::Config;
use lab::explain::found::{self, rounded};
use lab::explain::{Answer, Verdict};
use physics::model::Uncertain;
use physics::model::effect::{Course, EffectConfig, Series};

/// Points of a course in a file, per second.
const POINTS_PER_S: f64 = 5.0;

/// The whole configuration, ready for every other command.
pub fn toml(from: &Path, to: &Path, answer: &Answer<'_>) -> Result<String, Failure> {
    let text = std::fs::read_to_string(from).map_err(|error| {
        Failure::usage(format_args!("cannot read the configuration {}: {error}", from.display()))
    })?;
    let mut table: Table =
        text.parse().map_err(|error: toml::de::Error| Failure::usage(error.to_string()))?;
    if let Some(dbc) = table.get_mut("dbc").and_then(Value::as_table_mut) {
        for key in ["input", "output"] {
            if let Some(value) = dbc.get_mut(key) {
                *value = from_there(value, from, to);
            }
        }
    }
    let explanation = &answer.explanation;
    if let Some(vehicle) = table.get_mut("vehicle").and_then(Value::as_table_mut) {
        if vehicle.remove("tire_file").is_some() {
            put_tires(vehicle, from)?;
        }
        let ordinary = explanation.parameters.ordinary.as_ref().filter(|_| explanation.is_by_ordinary);
        if ordinary.is_some() {
            // Its tires bend as a magic formula does.
            vehicle.insert("tire".into(), Value::String("magic_formula".into()));
            for (name, value) in [("magic_formula_shape", 1.3), ("magic_formula_curvature", 0.0)] {
                vehicle.entry(name).or_insert(Value::Float(value));
            }
        }
        for (name, estimate) in ordinary.unwrap_or(&explanation.parameters.extended) {
            if let Some(place) = vehicle.get_mut(name) {
                let mut uncertain = Table::new();
                uncertain.insert("value".into(), Value::Float(rounded(estimate.value)));
                uncertain.insert("std".into(), Value::Float(rounded(estimate.std)));
                *place = Value::Table(uncertain);
            }
        }
    }
    let effects = match explanation.verdict {
        _ if explanation.is_by_ordinary => found::effects(&explanation.findings).map_err(Failure::work)?,
        Verdict::MissingPhysics => effects(answer)?,
        _ => Vec::new(),
    };
    table.remove("effect");
    let rest = toml::to_string(&table).map_err(Failure::work)?;
    let about = format!(
        "# Written by gripd explain: {} with the numbers fitted to {:.0} s of recordings{}.\n",
        from.file_name().unwrap_or(from.as_os_str()).to_string_lossy(),
        explanation.seconds,
        if effects.is_empty() { "; nothing was found missing" } else { " and what was found missing" },
    );
    Ok(format!("{about}{rest}\n{}", EffectConfig::write_all(&effects)))
}

/// The numbers of a tire file in its place: they may have been fitted, and its path would be another one.
fn put_tires(vehicle: &mut Table, from: &Path) -> Result<(), Failure> {
    const KEYS: [&str; 6] = [
        "friction",
        "magic_formula_shape",
        "magic_formula_curvature",
        "lateral_stiffness_front",
        "lateral_stiffness_rear",
        "longitudinal_stiffness",
    ];
    let config = Config::load(from)?;
    vehicle.insert("tire".into(), Value::String("magic_formula".into()));
    for (key, number) in config.vehicle.parameters() {
        if KEYS.contains(&key) && config.is_given(key) && !vehicle.contains_key(key) {
            vehicle.insert(key.into(), Value::try_from(number).map_err(Failure::work)?);
        }
    }
    Ok(())
}

/// What was found, as the configuration's tables.
fn effects(answer: &Answer<'_>) -> Result<Vec<EffectConfig>, Failure> {
    let mut all = Vec::new();
    let own = answer.model.effects.len() - answer.explanation.findings.len();
    for (number, chosen) in answer.model.effects.iter().enumerate() {
        // The configuration's own effects come first.
        let finding = number.checked_sub(own).and_then(|number| answer.explanation.findings.get(number));
        let numbers = chosen.specs().zip(&chosen.numbers).map(|(spec, coordinate)| {
            let estimate = finding.and_then(|finding| finding.parameters.get(spec.name));
            let std = estimate.map_or(0.0, |estimate| estimate.std);
            let (low, high) = spec.range();
            Uncertain { value: rounded(spec.value(*coordinate).clamp(low, high)), std: rounded(std) }
        });
        let course = match &chosen.course {
            Course::Series(series) => Course::Series(thinned(series)),
            other => other.clone(),
        };
        let effect = EffectConfig::new(chosen.kind, chosen.channel, numbers.collect(), course);
        all.push(effect.map_err(Failure::work)?);
    }
    Ok(all)
}

/// As many points as a smooth course needs.
fn thinned(series: &Series) -> Series {
    let seconds = series.t.last().zip(series.t.first()).map_or(0.0, |(last, first)| last - first);
    let every = ((series.t.len() as f64 / (seconds * POINTS_PER_S).max(1.0)).round() as usize).max(1);
    let some = |values: &[f64]| values.iter().step_by(every).map(|value| rounded(*value)).collect();
    Series { t: some(&series.t), value: some(&series.value) }
}

/// Paths are relative to the file they stand in.
fn from_there(value: &Value, from: &Path, to: &Path) -> Value {
    let folder = |path: &Path| path.parent().map(Path::to_owned).unwrap_or_default();
    let (old, new) = (folder(from), folder(to));
    let same = |a: &Path, b: &Path| {
        let real = |path: &Path| {
            std::fs::canonicalize(if path.as_os_str().is_empty() { Path::new(".") } else { path })
        };
        matches!((real(a), real(b)), (Ok(a), Ok(b)) if a == b)
    };
    let moved = |path: &str| {
        if same(&old, &new) || Path::new(path).is_absolute() {
            return path.to_owned();
        }
        let there: PathBuf = old.join(path);
        std::fs::canonicalize(&there).unwrap_or(there).display().to_string()
    };
    match value {
        Value::String(path) => Value::String(moved(path)),
        Value::Array(paths) => Value::Array(paths.iter().map(|path| from_there(path, from, to)).collect()),
        other => other.clone(),
    }
}
