//! The configuration with other numbers of the car: what `--apply` writes.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use crate::cli::Failure;
use bus::Config;
use lab::explain::found::rounded;
use lab::identify::Doubt;
use lab::report::wrapped;
use physics::model::effect::EffectConfig;

/// A configuration that is being rewritten.
pub struct Applied<'p> {
    from: &'p Path,
    table: Table,
    /// What is said above it.
    head: String,
    /// What was left as it was, and what was taken over though it is in doubt.
    doubted: [Vec<String>; 2],
}

impl<'p> Applied<'p> {
    /// The configuration that was used, its paths as they are from where it will be.
    pub fn read(from: &'p Path, to: &Path) -> Result<Self, Failure> {
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
        let mut applied = Self { from, table, head: String::new(), doubted: [const { Vec::new() }; 2] };
        applied.put_tires()?;
        Ok(applied)
    }

    /// Its name without a folder.
    pub fn name(&self) -> String {
        self.from.file_name().unwrap_or(self.from.as_os_str()).to_string_lossy().into_owned()
    }

    /// Says something above it.
    pub fn say(&mut self, words: &str) {
        self.head += &wrapped("# ", 0, words).trim_end().replace('\n', "\n# ");
        self.head.push('\n');
    }

    fn vehicle(&mut self) -> Option<&mut Table> {
        self.table.get_mut("vehicle").and_then(Value::as_table_mut)
    }

    /// Does its `[vehicle]` have this number?
    pub fn has(&mut self, key: &str) -> bool {
        self.vehicle().is_some_and(|vehicle| vehicle.contains_key(key))
    }

    /// Puts a number of the car: value and standard deviation.
    pub fn put(&mut self, key: &str, (value, std): (f64, f64)) {
        let uncertain = [("value", value), ("std", std)];
        let uncertain = uncertain.map(|(key, number)| (key.to_owned(), Value::Float(rounded(number))));
        if let Some(vehicle) = self.vehicle() {
            vehicle.insert(key.into(), Value::Table(Table::from_iter(uncertain)));
        }
    }

    /// The same of a number that is in doubt: only by force.
    pub fn put_doubtful(&mut self, key: &str, doubt: &Doubt, force: bool) {
        let (value, std) = (rounded(doubt.value), rounded(doubt.std));
        self.doubted[usize::from(force)].push(format!("{key} = {value} ± {std}: {}", doubt.why));
        if force {
            self.put(key, (doubt.value, doubt.std));
        }
    }

    /// Tires that bend as a magic formula does.
    pub fn bend_tires(&mut self) {
        let Some(vehicle) = self.vehicle() else { return };
        vehicle.insert("tire".into(), Value::String("magic_formula".into()));
        for (name, value) in [("magic_formula_shape", 1.3), ("magic_formula_curvature", 0.0)] {
            vehicle.entry(name).or_insert(Value::Float(value));
        }
    }

    /// The numbers of a tire file in its place: they may have been fitted, and its path would be another one.
    fn put_tires(&mut self) -> Result<(), Failure> {
        const KEYS: [&str; 6] = [
            "friction",
            "magic_formula_shape",
            "magic_formula_curvature",
            "lateral_stiffness_front",
            "lateral_stiffness_rear",
            "longitudinal_stiffness",
        ];
        let from = self.from;
        let Some(vehicle) = self.vehicle() else { return Ok(()) };
        if vehicle.remove("tire_file").is_none() {
            return Ok(());
        }
        let config = Config::load(from)?;
        vehicle.insert("tire".into(), Value::String("magic_formula".into()));
        for (key, number) in config.vehicle.parameters() {
            if KEYS.contains(&key) && config.is_given(key) && !vehicle.contains_key(key) {
                vehicle.insert(key.into(), Value::try_from(number).map_err(Failure::work)?);
            }
        }
        Ok(())
    }

    /// The whole text, with these effects instead of its own, where there are any.
    pub fn text(mut self, effects: Option<&[EffectConfig]>) -> Result<String, Failure> {
        let [left, forced] = std::mem::take(&mut self.doubted);
        let heads =
            ["In doubt, left as they were (--force takes them over):", "In doubt, taken over by --force:"];
        for (head, lines) in heads.into_iter().zip([left, forced]).filter(|(_, lines)| !lines.is_empty()) {
            self.say(head);
            lines.iter().for_each(|line| self.say(line));
        }
        if effects.is_some() {
            self.table.remove("effect");
        }
        let rest = toml::to_string(&self.table).map_err(Failure::work)?;
        Ok(format!("{}{rest}\n{}", self.head, EffectConfig::write_all(effects.unwrap_or_default())))
    }
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
