//! The tables of `src/guide/results.md`: written by what measures them, and compared with it ever after.
//!
//! A table stands between two comments, of which the first one tells when, where and with which seeds it was measured:
//!
//! ```text
//! <!-- results accuracy; 2026-11-24; 2 cores, Some CPU; seeds 1 to 8 -->
//! | drive | error |
//! |---|---|
//! | asphalt | 3 % |
//! <!-- end of accuracy -->
//! ```

use std::fs::{self, File};
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::cells::{differences, renew};
use crate::program::{project, target};

const PAGE: &str = "src/guide/results.md";

/// A table of the page.
pub struct Section<'a> {
    pub name: &'a str,
    /// What chance it was measured with, as it is told.
    pub seed: &'a str,
    /// Numbers may differ so much, relative.
    pub tolerance: f64,
    /// Its columns, separated by `|`.
    pub header: &'a str,
}

impl Section<'_> {
    /// Compares rows, their cells separated by `|`, with the page; `GRIPD_RENEW=1` writes them into it.
    #[track_caller]
    pub fn check(&self, rows: &[String]) {
        if renew() {
            return self.write(rows);
        }
        let (page, name) = (fs::read_to_string(project(PAGE)).unwrap(), self.name);
        let renewing = "To take over what was found: GRIPD_RENEW=1 and this test again.";
        let Some(place) = place(&page, name) else {
            panic!("{PAGE} has no section `{name}`. {renewing}");
        };
        let mut kept = page[place].lines().skip(1).filter(|line| line.starts_with('|')).map(cells);
        let header = cells(self.header);
        assert_eq!(
            kept.next().as_ref(),
            Some(&header),
            "{PAGE}, section `{name}`: other columns. {renewing}"
        );
        let (kept, found): (Vec<_>, Vec<_>) =
            (kept.skip(1).collect(), rows.iter().map(|row| cells(row)).collect());
        if let Some(differences) = differences(&header, &kept, &found, self.tolerance) {
            panic!("{PAGE}, section `{name}`, is not what was found:\n{differences}{renewing}");
        }
    }

    /// Writes rows into the page, at its end where it has no such section. What is the same keeps its date.
    pub fn write(&self, rows: &[String]) {
        // Several tests may come here at once.
        let lock = File::create(target("tmp").join("results.lock")).unwrap();
        lock.lock().unwrap();
        let mut page = fs::read_to_string(project(PAGE)).unwrap();
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let columns = cells(self.header);
        let rule = format!("|{}\n", "---|".repeat(columns.len()));
        let rows: String = rows.iter().map(|row| line(cells(row))).collect();
        let table = format!("{}{rule}{rows}", line(columns));
        let section = format!(
            "<!-- results {}; {}; {}; {} -->\n{table}<!-- end of {} -->\n",
            self.name,
            date(),
            machine(),
            self.seed,
            self.name
        );
        match place(&page, self.name) {
            Some(place) if page[place.clone()].contains(&table) => return,
            Some(place) => page.replace_range(place, &section),
            None => page.push_str(&format!("\n## {}\n\n{section}", self.name)),
        }
        fs::write(project(PAGE), page).unwrap();
    }
}

/// Rows of what criterion measured in a group of benchmarks: its name, and the time that one element takes; with bytes,
/// how many a second.
pub fn measured(group: &str) -> Vec<String> {
    let mut folders: Vec<_> = fs::read_dir(target("criterion").join(group))
        .unwrap()
        .map(|entry| entry.unwrap().path().join("new"))
        .collect();
    folders.retain(|folder| folder.join("benchmark.json").exists());
    folders.sort();
    let row = |folder: PathBuf| {
        let read = |name| -> Value { serde_json::from_slice(&fs::read(folder.join(name)).unwrap()).unwrap() };
        let (about, times) = (read("benchmark.json"), read("estimates.json"));
        let nanoseconds = times["median"]["point_estimate"].as_f64().unwrap();
        let each = match (about["throughput"]["Elements"].as_f64(), about["throughput"]["Bytes"].as_f64()) {
            (Some(elements), _) => format!("{:.0} ns each", nanoseconds / elements),
            (_, Some(bytes)) => format!("{:.0} MB/s", bytes / nanoseconds * 1e3),
            _ => format!("{:.3} ms", nanoseconds / 1e6),
        };
        format!("{group}: {} | {each}", about["function_id"].as_str().unwrap_or_default())
    };
    folders.into_iter().map(row).collect()
}

/// Where a section stands, its comments included.
fn place(page: &str, name: &str) -> Option<std::ops::Range<usize>> {
    let begin = page.find(&format!("<!-- results {name};"))?;
    let end = format!("<!-- end of {name} -->\n");
    Some(begin..begin + page[begin..].find(&end)? + end.len())
}

fn cells(line: &str) -> Vec<String> {
    let line = line.trim();
    let line = line.strip_prefix('|').unwrap_or(line);
    let line = line.strip_suffix('|').unwrap_or(line);
    line.split('|').map(|cell| cell.trim().to_owned()).collect()
}

fn date() -> String {
    let output = Command::new("date").args(["-u", "+%F"]).output().unwrap();
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

/// Cores and processor, as results depend on them.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model =
        text.lines().find_map(|line| line.strip_prefix("model name")).and_then(|line| line.split_once(':'));
    format!("{cores} cores, {}", model.map_or("unknown processor", |(_, model)| model.trim()))
}
