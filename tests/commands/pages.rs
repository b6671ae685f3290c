//! README, changelog and guide: every link leads somewhere, every file that they name is there, and every page of the
//! guide stands in the library's documentation.

use std::fs;
use std::path::{Path, PathBuf};

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// All pages, by their path.
fn pages() -> Vec<PathBuf> {
    let mut pages = vec![project("README.md"), project("CHANGELOG.md")];
    let guide = fs::read_dir(project("src/guide")).unwrap().map(|entry| entry.unwrap().path());
    pages.extend(guide.filter(|path| path.extension().is_some_and(|end| end == "md")));
    pages.sort();
    pages
}

/// The lines of a page that are prose: not within a fenced or an indented block of code.
fn prose(text: &str) -> Vec<&str> {
    let mut is_code = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if !is_code && !line.starts_with("    ") {
            lines.push(line);
        }
    }
    lines
}

/// A heading's anchor, as forges and rustdoc make it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn anchors(text: &str) -> Vec<String> {
    let headings = prose(text).into_iter().filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).collect()
}

/// The targets of a line's links.
fn links(line: &str) -> Vec<&str> {
    line.match_indices("](")
        .filter_map(|(place, _)| line[place + 2..].split_once(')').map(|(to, _)| to))
        .collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut problems = Vec::new();
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for link in prose(&text).into_iter().flat_map(links).filter(|link| !link.contains("://")) {
            let (file, place) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            if !target.exists() {
                problems.push(format!("{}: {link}: there is no such file", page.display()));
                continue;
            }
            // Pictures are no text, and have no headings.
            let there = || anchors(&fs::read_to_string(&target).unwrap_or_default());
            if !place.is_empty() && !there().iter().any(|known| known == place) {
                problems.push(format!("{}: {link}: there is no such heading", page.display()));
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// What of a line stands in backticks and is a path of this repository. `NAME` in it stands for a name to be chosen.
fn paths(line: &str) -> impl Iterator<Item = &str> {
    const FOLDERS: [&str; 8] =
        ["src/", "tests/", "config/", "dbc/", "systemd/", "benches/", ".ci/", "Cargo.toml"];
    let quoted = line.split('`').skip(1).step_by(2).flat_map(str::split_whitespace);
    quoted.filter(|text| FOLDERS.iter().any(|folder| text.starts_with(folder)) && !text.contains("NAME"))
}

/// A path may name several files, as `src/{a,b}.rs`.
fn spelled_out(path: &str) -> Vec<String> {
    let group = path.split_once('{').and_then(|(before, rest)| {
        let (names, after) = rest.split_once('}')?;
        Some(names.split(',').map(|name| format!("{before}{name}{after}")).collect())
    });
    group.unwrap_or_else(|| vec![path.to_owned()])
}

/// The changelog is left out: what it names may be gone by now.
#[test]
fn every_file_that_is_named_is_there() {
    let mut problems = Vec::new();
    for page in pages().into_iter().filter(|page| !page.ends_with("CHANGELOG.md")) {
        let text = fs::read_to_string(&page).unwrap();
        for path in prose(&text).into_iter().flat_map(paths).flat_map(spelled_out) {
            let there = project(path.trim_end_matches('/'));
            if !there.exists() && !there.with_extension("rs").exists() {
                problems.push(format!("{}: {path}: there is no such file", page.display()));
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn every_page_of_the_guide_is_in_the_documentation() {
    let guide = fs::read_to_string(project("src/guide.rs")).unwrap();
    for page in
        pages().into_iter().filter(|page| page.parent().is_some_and(|folder| folder.ends_with("guide")))
    {
        let name = page.file_name().unwrap().to_str().unwrap();
        assert!(guide.contains(&format!("include_str!(\"guide/{name}\")")), "src/guide.rs leaves out {name}");
    }
}

#[test]
fn the_readme_is_short() {
    let text = fs::read_to_string(project("README.md")).unwrap();
    assert!(text.lines().count() <= 150, "{} lines; the guide has room for more", text.lines().count());
    let longest = text.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(longest <= 300, "a line of {longest} characters; a cell is no place for a story");
}
