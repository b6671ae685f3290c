//! Effects as a command line gives them.

use std::path::Path;

use toml::{Table, Value};

use crate::cli::Failure;
use lab::explain::ordinary::conceal::drawn;
use physics::model::effect::{EffectConfig, Kind, named};

/// A table of an effect, and a course that is to be drawn for it.
pub struct Wanted {
    table: Table,
    kind: &'static Kind,
    /// Root of the mean square, or the peak where the kind is told by that.
    pub drawn: Option<f64>,
}

/// All that was asked for, in the order of the command line.
pub fn read(effects: &[String], sets: &[String]) -> Result<Vec<Wanted>, Failure> {
    let mut tables = Vec::new();
    for text in effects {
        tables.extend(of_text(text)?);
    }
    if !sets.is_empty() {
        let [table] = &mut tables[..] else {
            return Err(Failure::usage(
                "--set is for one effect; of several, give each as a table: --effect 'kind = \"…\", … = …'",
            ));
        };
        for set in sets {
            let (name, value) = set.split_once('=').ok_or_else(|| {
                Failure::usage(format_args!("--set {set}: write NAME=VALUE, such as --set mass_kg=350"))
            })?;
            table.insert(name.trim().to_owned(), value_of(value.trim()));
        }
    }
    if tables.is_empty() {
        return Err(Failure::usage("there is no [[effect]] table in what --effect gives"));
    }
    let wanted = tables.into_iter().map(Wanted::new).collect::<Result<Vec<_>, _>>()?;
    // What is wrong with the numbers is better known before the work than after it.
    Wanted::configs(&wanted, 1.0, 1)?;
    Ok(wanted)
}

/// A kind's name, tables, or a file of them.
fn of_text(text: &str) -> Result<Vec<Table>, Failure> {
    if text.contains('=') {
        let one_line = || format!("effect = [{{ {} }}]", text.trim()).parse::<Table>();
        let table = text.parse::<Table>().or_else(|error| one_line().map_err(|_| error));
        let table = table.map_err(|error| Failure::usage(format_args!("--effect {text}: {error}")))?;
        return tables(table, text);
    }
    if named(text).is_some() {
        return Ok(vec![Table::from_iter([("kind".to_owned(), Value::String(text.to_owned()))])]);
    }
    let content = std::fs::read_to_string(Path::new(text)).map_err(|error| {
        Failure::usage(format_args!(
            "--effect {text}: there is no such kind (`gripd conceal --list` lists them), and no file of that name: {error}"
        ))
    })?;
    let table = content.parse::<Table>().map_err(|error| Failure::usage(format_args!("{text}: {error}")))?;
    tables(table, text)
}

/// One table, or those of `[[effect]]`.
fn tables(mut table: Table, whose: &str) -> Result<Vec<Table>, Failure> {
    let wrong = || {
        Failure::usage(format_args!(
            "{whose}: write [[effect]] tables, each with kind = \"…\" and its numbers"
        ))
    };
    match table.remove("effect") {
        None if table.contains_key("kind") => Ok(vec![table]),
        Some(Value::Array(all)) => {
            all.into_iter().map(|one| one.as_table().cloned().ok_or_else(wrong)).collect()
        }
        Some(Value::Table(one)) => Ok(vec![one]),
        _ => Err(wrong()),
    }
}

/// A number or whatever else TOML has, else a word.
fn value_of(text: &str) -> Value {
    let table = format!("x = {text}").parse::<Table>().ok();
    table.and_then(|mut table| table.remove("x")).unwrap_or_else(|| Value::String(text.to_owned()))
}

impl Wanted {
    fn new(mut table: Table) -> Result<Self, Failure> {
        let name = table.get("kind").and_then(Value::as_str).unwrap_or_default();
        let Some(kind) = named(name) else {
            return Err(match name {
                "" => Failure::usage("an effect needs its kind = \"…\"; `gripd conceal --list` lists them"),
                _ => Failure::usage(format_args!(
                    "effect kind `{name}`: there is no such kind; `gripd conceal --list` lists them"
                )),
            });
        };
        let name = kind.name;
        let mut drawn = None;
        if let Some(key) = drawn_key(kind)
            && let Some(value) = table.remove(key)
        {
            let number = value.as_float().or_else(|| value.as_integer().map(|number| number as f64));
            let sized = number.filter(|number| number.is_finite() && *number >= 0.0);
            drawn = Some(sized.ok_or_else(|| {
                Failure::usage(format_args!("effect {name}: {key} = {value}: must be a number, zero or more"))
            })?);
            if let Some(other) = ["value", "intervals", "series"].into_iter().find(|k| table.contains_key(*k))
            {
                return Err(Failure::usage(format_args!(
                    "effect {name}: {key} draws a course at random; {other} gives one: take one of the two"
                )));
            }
        }
        Ok(Self { table, kind, drawn })
    }

    /// The effects, for a recording of so many seconds.
    pub fn configs(wanted: &[Self], seconds: f64, seed: u64) -> Result<Vec<EffectConfig>, Failure> {
        let all = wanted.iter().enumerate();
        let configs = all.map(|(number, wanted)| wanted.config(seconds, seed, number as u64));
        let configs = configs.collect::<Result<Vec<_>, _>>()?;
        match EffectConfig::problem_among(&configs) {
            Some((place, key, reason)) => {
                Err(Failure::usage(format_args!("effect[{place}].{key}: {reason}")))
            }
            None => Ok(configs),
        }
    }

    fn config(&self, seconds: f64, seed: u64, number: u64) -> Result<EffectConfig, Failure> {
        let mut table = self.table.clone();
        if let (Some(size), Some(course)) = (self.drawn, self.kind.course) {
            let mut series = drawn(1.0, course.length_s, seconds, seed, number);
            let peak = series.value.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
            let scale = if course.is_told_by_its_peak { size / peak.max(1e-9) } else { size };
            series.value.iter_mut().for_each(|value| *value *= scale);
            table.insert("series".to_owned(), Value::try_from(series).map_err(Failure::usage)?);
        }
        let config: Result<EffectConfig, toml::de::Error> = Value::Table(table).try_into();
        config.map_err(|error| Failure::usage(error.message()))
    }
}

/// The key that asks for a course drawn at random, where the kind has one that may be anything.
pub fn drawn_key(kind: &Kind) -> Option<&'static str> {
    kind.course.filter(|course| course.sign == 0.0).map(|course| course.rms_name)
}
