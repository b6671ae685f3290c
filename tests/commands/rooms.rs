//! The map of the rooms: which folder of a crate may use which other one. The compiler keeps the crates apart, and this
//! test keeps the folders inside them apart. It reads the sources, so that an arrow in the wrong direction fails here
//! before it becomes a circle.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

/// A crate: its folder, the crates of ours that it uses, and its rooms; none where the crate is one room.
struct Member {
    folder: &'static str,
    uses: &'static [&'static str],
    rooms: &'static [Room],
}

/// A folder or file at the top of a crate, and the rooms of the same crate that it may use.
type Room = (&'static str, &'static [&'static str]);

/// The map. A room may use only rooms that stand above it, so there can be no circle.
const MAP: &[Member] = &[
    Member {
        folder: "src/physics",
        uses: &[],
        rooms: &[
            ("time", &[]),
            ("faults", &[]),
            ("sample", &["time", "faults"]),
            ("estimates", &["time", "faults"]),
            ("filter", &[]),
            ("model", &["time", "sample"]),
            ("estimate", &["time", "faults", "sample", "estimates", "filter", "model"]),
        ],
    },
    Member {
        folder: "src/bus",
        uses: &["physics"],
        rooms: &[
            ("new_file", &[]),
            ("plain_file", &[]),
            ("can", &["new_file"]),
            ("dbc", &["plain_file", "can"]),
            ("signals", &["can", "dbc"]),
            ("propose", &["can", "dbc", "signals"]),
            ("tire_file", &["plain_file"]),
            ("config", &["plain_file", "dbc", "signals", "tire_file"]),
            ("service", &["new_file", "plain_file", "can", "dbc", "signals", "config"]),
            ("watch", &["can", "dbc", "signals", "config", "service"]),
        ],
    },
    Member { folder: "src/identify", uses: &["physics"], rooms: &[] },
    Member { folder: "src/predict", uses: &["identify", "physics"], rooms: &[] },
    Member {
        folder: "src/lab",
        uses: &["identify", "physics", "predict"],
        rooms: &[
            ("report", &[]),
            ("chance", &[]),
            ("explain", &["chance"]),
            ("pages", &["report", "explain"]),
            ("reproduce", &["report"]),
        ],
    },
    Member {
        folder: "src/fmu",
        uses: &["physics"],
        rooms: &[
            ("version", &[]),
            ("quantities", &[]),
            ("car", &[]),
            ("variables", &["quantities", "car"]),
            ("description", &["version", "quantities", "car", "variables"]),
            ("instance", &["car", "variables"]),
            ("export", &["version", "car", "description", "instance"]),
            ("foreign", &["version", "car", "description", "export"]),
            ("abi", &["version", "car", "description", "instance"]),
        ],
    },
    Member {
        folder: "src/python",
        uses: &["bus", "physics"],
        rooms: &[
            ("columns", &[]),
            ("frames", &[]),
            ("failure", &[]),
            ("log", &[]),
            ("stream", &["failure"]),
            ("decode", &["columns", "failure", "stream"]),
            ("drive", &["columns", "frames", "failure", "stream"]),
            ("search", &["failure"]),
            ("simulate", &["columns", "failure", "stream"]),
        ],
    },
    Member {
        folder: "src",
        uses: &["bus", "fmu", "identify", "lab", "physics"],
        rooms: &[("cli", &[]), ("guide", &[])],
    },
];

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Everything in a folder, by name.
fn within(folder: &Path) -> Vec<PathBuf> {
    let mut all: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    all.sort();
    all
}

/// The Rust files of a room: `NAME.rs`, and all that is in the folder `NAME`.
fn files(member: &str, room: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut waiting = vec![project(member).join(room).with_extension("rs"), project(member).join(room)];
    while let Some(path) = waiting.pop() {
        if path.is_dir() {
            waiting.extend(within(&path));
        } else if path.extension().is_some_and(|end| end == "rs") && path.is_file() {
            found.push(path);
        }
    }
    found
}

/// A source without its comments, which may name what they like.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

fn word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// The first names of a path, or of each path in a group: `a::b` gives a, `{a::b, c::{d, e}}` gives a and c.
fn first_names(path: &str) -> Vec<&str> {
    let Some(group) = path.strip_prefix('{') else { return vec![word(path)] };
    let (mut names, mut depth, mut is_start) = (Vec::new(), 0, true);
    for (place, c) in group.char_indices() {
        match c {
            '}' if depth == 0 => break,
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => is_start = true,
            c if is_start && !c.is_whitespace() => {
                names.push(word(&group[place..]));
                is_start = false;
            }
            _ => {}
        }
    }
    names
}

/// What stands behind each `crate::` of a source.
fn from_the_crate(code: &str) -> Vec<&str> {
    code.match_indices("crate::")
        .flat_map(|(place, found)| first_names(&code[place + found.len()..]))
        .collect()
}

/// What a crate's root gives out under another name, as `pub use estimates::Estimates`: name and room.
fn given_out(member: &str) -> Vec<(String, String)> {
    let root = code(&project(member).join("lib.rs"));
    let mut all = Vec::new();
    for (place, found) in root.match_indices("pub use ") {
        let path = &root[place + found.len()..];
        let room = word(path);
        let names = path[room.len()..].strip_prefix("::").map_or(Vec::new(), first_names);
        all.extend(names.into_iter().map(|name| (name.to_owned(), room.to_owned())));
    }
    all
}

/// How deep below the crate's root a file's module is: 1 for a room itself.
fn depth(member: &str, path: &Path) -> usize {
    let below = path.strip_prefix(project(member)).unwrap();
    let is_folder = below.file_name().is_some_and(|name| name == "mod.rs");
    below.components().count() - usize::from(is_folder)
}

/// The longest chain of `super::` that leaves the room, if any does. Tests stand one module deeper.
fn climbs_out(code: &str, depth: usize) -> bool {
    let tests = code.find("mod tests {").unwrap_or(code.len());
    let mut rest = 0;
    while let Some(found) = code[rest..].find("super::") {
        let start = rest + found;
        let mut end = start;
        while code[end..].starts_with("super::") {
            end += "super::".len();
        }
        let steps = (end - start) / "super::".len();
        let is_indented = code[..start].rsplit('\n').next().is_some_and(|line| line.starts_with(' '));
        if steps >= depth + usize::from(start > tests && is_indented) {
            return true;
        }
        rest = end;
    }
    false
}

#[test]
fn rooms_use_only_what_the_map_allows() {
    let mut problems = Vec::new();
    for member in MAP {
        let given_out = given_out(member.folder);
        for (room, may_use) in member.rooms {
            let files = files(member.folder, room);
            assert!(!files.is_empty(), "{}/{room} is on the map and has no file", member.folder);
            for path in files {
                let (code, name) =
                    (code(&path), path.strip_prefix(project("")).unwrap().display().to_string());
                if climbs_out(&code, depth(member.folder, &path)) {
                    problems.push(format!("{name}: `super::` leaves the room; write `crate::`"));
                }
                for used in from_the_crate(&code) {
                    let other = given_out.iter().find(|(name, _)| name == used);
                    let other = other.map_or(used, |(_, room)| room);
                    if other != *room && !may_use.contains(&other) {
                        problems.push(format!("{name}: {room} must not use {other} (`crate::{used}`)"));
                    }
                }
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn the_map_has_every_room_and_no_circle() {
    let crates: Vec<_> = MAP.iter().map(|member| project(member.folder)).collect();
    for member in MAP.iter().filter(|member| !member.rooms.is_empty()) {
        let mut above = Vec::new();
        for (room, may_use) in member.rooms {
            let unknown = may_use.iter().find(|other| !above.contains(*other));
            assert_eq!(unknown, None, "{}/{room} may use only rooms that stand above it", member.folder);
            above.push(*room);
        }
        for path in within(&project(member.folder)) {
            let name = path.file_stem().unwrap().to_str().unwrap();
            let is_source = path.extension().is_some_and(|end| end == "rs");
            let is_crate = crates.contains(&path);
            // A folder without sources, as that of the Python package, is no room.
            let has_sources = path.is_dir() && !files(member.folder, name).is_empty();
            if (is_source || has_sources) && !is_crate && !matches!(name, "lib" | "main") {
                assert!(above.contains(&name), "{} is not on the map", path.display());
            }
        }
    }
}

/// The compiler refuses circles of crates; which arrow there is, their manifests say.
#[test]
fn crates_use_only_what_the_map_allows() {
    let ours: Vec<_> = MAP.iter().filter_map(|member| member.folder.strip_prefix("src/")).collect();
    for member in MAP {
        let manifest = if member.folder == "src" {
            "Cargo.toml".into()
        } else {
            format!("{}/Cargo.toml", member.folder)
        };
        let text = fs::read_to_string(project(&manifest)).unwrap();
        let parts = text.split("\n[").filter(|part| {
            ["dependencies]", "dev-dependencies]", "build-dependencies]"]
                .iter()
                .any(|head| part.starts_with(head))
        });
        let mut used: Vec<_> = parts
            .flat_map(str::lines)
            .filter_map(|line| ours.iter().copied().find(|ours| word(line) == *ours))
            .collect();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used, member.uses, "{manifest}");
    }
}

#[test]
fn arrows_are_found_in_whatever_way_they_are_written() {
    let code = "use crate::dbc::{Database, Mux};\nuse crate::{\n    can::{self, Frame},\n    signals,\n};\nfn f(x: crate::Config) {}";
    assert_eq!(from_the_crate(code), ["dbc", "can", "signals", "Config"]);
    assert!(climbs_out("use super::super::dbc;", 2), "from a file of a room to the crate's root");
    assert!(!climbs_out("use super::Frame;\nmod tests {\n use super::super::frame;", 2));
    assert!(climbs_out("mod tests {\n}\nuse super::super::frame;", 2), "below the tests");
    assert!(climbs_out("use super::Config;", 1), "from the room's own file");
}
