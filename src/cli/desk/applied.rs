//! The configuration with other numbers of the car: what `--apply` writes. What does not change stays as it was written,
//! comments included.

mod kept;

use std::path::Path;

use toml_edit::{ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, TomlError, Value, value};

use super::map::relative;
use crate::cli::Failure;
use bus::Config;
use identify::Doubt;
use lab::explain::found::rounded;
use lab::report::wrapped;
use physics::model::effect::EffectConfig;
use physics::model::{TireKind, Uncertain};

/// Keys that are paths, by their tables. Relative ones are so to the file that they stand in.
const PATHS: [(&str, &[&str]); 2] =
    [("dbc", &["input", "output"]), ("service", &["state_file", "record_faults", "metrics"])];

/// A configuration that is being rewritten.
pub struct Applied<'p> {
    from: &'p Path,
    document: DocumentMut,
    /// Do its lines end as those of Windows do?
    has_returns: bool,
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
        let mut document: DocumentMut = without_head(&text)
            .parse()
            .map_err(|error: TomlError| Failure::usage(format_args!("{}: {error}", from.display())))?;
        for (table, keys) in PATHS {
            let table = document.get_mut(table).and_then(Item::as_table_like_mut);
            let Some(table) = table.filter(|_| !is_same_folder(from, to)) else { continue };
            for key in keys {
                if let Some(Item::Value(path)) = table.get_mut(key) {
                    move_path(path, from, to);
                }
            }
        }
        let has_returns = text.contains("\r\n");
        let doubted = [const { Vec::new() }; 2];
        let mut applied = Self { from, document, has_returns, head: String::new(), doubted };
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

    fn vehicle(&mut self) -> Option<&mut dyn TableLike> {
        self.document.get_mut("vehicle").and_then(Item::as_table_like_mut)
    }

    /// Does its `[vehicle]` have this number?
    pub fn has(&mut self, key: &str) -> bool {
        self.vehicle().is_some_and(|vehicle| vehicle.contains_key(key))
    }

    /// Puts a number of the car: value and standard deviation.
    pub fn put(&mut self, key: &str, (value, std): (f64, f64)) {
        if let Some(vehicle) = self.vehicle() {
            kept::put(vehicle, key, number(Uncertain { value: rounded(value), std: rounded(std) }));
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

    /// Tires that bend as those of the ordinary car do.
    pub fn bend_tires(&mut self, tire: TireKind) {
        let Some(vehicle) = self.vehicle() else { return };
        kept::put(vehicle, "tire", value(tire.name()));
        if tire != TireKind::MagicFormula {
            return;
        }
        for (name, number) in [("magic_formula_shape", 1.3), ("magic_formula_curvature", 0.0)] {
            if !vehicle.contains_key(name) {
                vehicle.insert(name, value(number));
            }
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
        if !self.has("tire_file") {
            return Ok(());
        }
        let config = Config::load(self.from)?;
        let Some(vehicle) = self.vehicle() else { return Ok(()) };
        let comments = kept::take_out(vehicle, "tire_file");
        kept::put(vehicle, "tire", value("magic_formula"));
        if let Some(mut tire) = vehicle.key_mut("tire") {
            kept::comment_above(tire.leaf_decor_mut(), &comments);
        }
        for (key, given) in config.vehicle.parameters() {
            if KEYS.contains(&key) && config.is_given(key) && !vehicle.contains_key(key) {
                vehicle.insert(key, number(given));
            }
        }
        Ok(())
    }

    /// Puts effects beside its own, which the recordings were explained with. One that says again what its own does takes
    /// that one's place.
    fn put_effects(&mut self, effects: &[EffectConfig]) -> Result<(), Failure> {
        for effect in effects {
            let text: DocumentMut = effect.to_toml().parse().map_err(Failure::work)?;
            let new = text.get("effect").and_then(Item::as_array_of_tables).and_then(|all| all.get(0));
            let Some(mut new) = new.cloned() else { continue };
            match self.document.get_mut("effect") {
                Some(Item::ArrayOfTables(own)) => {
                    // Behind the last of its own, wherever that stands.
                    new.decor_mut().set_prefix("\n");
                    new.set_position(own.iter().filter_map(Table::position).max());
                    let place = own.iter().position(|own| is_same_effect(own, &new));
                    match place.and_then(|place| own.get_mut(place)) {
                        Some(own) => kept::put_all(own, new),
                        None => own.push(new),
                    }
                }
                Some(Item::Value(Value::Array(own))) => {
                    let same =
                        |own: &Value| own.as_inline_table().is_some_and(|own| is_same_effect(own, &new));
                    let place = own.iter().position(same);
                    let new = Value::InlineTable(new.into_inline_table());
                    match place {
                        Some(place) => drop(own.replace(place, new)),
                        None => own.push(new),
                    }
                }
                _ => {
                    new.decor_mut().set_prefix("\n");
                    new.set_position(None);
                    self.document.insert("effect", Item::ArrayOfTables(ArrayOfTables::from_iter([new])));
                }
            }
        }
        Ok(())
    }

    /// The whole text, with these effects.
    pub fn text(mut self, effects: &[EffectConfig]) -> Result<String, Failure> {
        let [left, forced] = std::mem::take(&mut self.doubted);
        let heads =
            ["In doubt, left as they were (--force takes them over):", "In doubt, taken over by --force:"];
        for (head, lines) in heads.into_iter().zip([left, forced]).filter(|(_, lines)| !lines.is_empty()) {
            self.say(head);
            lines.iter().for_each(|line| self.say(line));
        }
        self.put_effects(effects)?;
        let text = format!("{}\n{}", self.head, self.document).replace("\r\n", "\n");
        Ok(if self.has_returns { text.replace('\n', "\r\n") } else { text })
    }
}

/// As `[vehicle]` has its numbers.
fn number(Uncertain { value: number, std }: Uncertain) -> Item {
    if std == 0.0 {
        return value(number);
    }
    let mut table = InlineTable::new();
    table.insert("value", number.into());
    table.insert("std", std.into());
    value(table)
}

fn is_same_effect(a: &dyn TableLike, b: &dyn TableLike) -> bool {
    let is_same = |key: &str| a.get(key).and_then(Item::as_str) == b.get(key).and_then(Item::as_str);
    ["kind", "channel", "place", "expression"].into_iter().all(is_same)
}

/// Without what an earlier `--apply` said above it: that was of its own recordings.
fn without_head(text: &str) -> &str {
    let is_ours =
        ["explain", "identify"].iter().any(|by| text.starts_with(&format!("# Written by gripd {by}: ")));
    if !is_ours {
        return text;
    }
    let head = text.split_inclusive('\n').take_while(|line| line.starts_with('#'));
    let rest = &text[head.map(str::len).sum()..];
    rest.strip_prefix('\n').or(rest.strip_prefix("\r\n")).unwrap_or(rest)
}

fn is_same_folder(from: &Path, to: &Path) -> bool {
    let folder = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        std::fs::canonicalize(folder.unwrap_or(Path::new(".")))
    };
    matches!((folder(from), folder(to)), (Ok(from), Ok(to)) if from == to)
}

/// A path, or each of several, as it is from where the file will be.
fn move_path(path: &mut Value, from: &Path, to: &Path) {
    if let Some(paths) = path.as_array_mut() {
        paths.iter_mut().for_each(|path| move_path(path, from, to));
        return;
    }
    // An empty name, and an address of the network, are no files.
    let is_file = |name: &&str| !name.is_empty() && name.parse::<std::net::SocketAddr>().is_err();
    let Some(name) = path.as_str().filter(is_file).map(Path::new).filter(|name| name.is_relative()) else {
        return;
    };
    let folder = from.parent().unwrap_or(Path::new(""));
    let moved = relative(&folder.join(name), to).display().to_string();
    let decor = path.decor().clone();
    *path = moved.into();
    *path.decor_mut() = decor;
}
