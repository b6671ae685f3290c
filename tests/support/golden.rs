//! Golden series: small CSV files beside the tests, so that a change of behaviour is a diff of its commit.

use std::path::Path;

use crate::cells::{differences, renew};
use crate::program::project;

/// Numbers may differ so much, relative: other processors round otherwise, other behaviour does not hide in it.
const TOLERANCE: f64 = 1e-3;

/// Compares a table with the file that is kept of it (below the project's folder); `GRIPD_RENEW=1` writes the file.
/// `again` is the command that a person says to renew it.
#[track_caller]
pub fn compare(file: &str, header: &str, rows: &[Vec<String>], again: &str) {
    let path = project(file);
    if renew() {
        write(&path, header, rows);
        return;
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    let mut lines = kept.lines();
    let renewing = format!("If that is meant: GRIPD_RENEW=1 {again}");
    assert_eq!(lines.next(), Some(header), "{file} has other columns or is not there. {renewing}");
    let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let kept: Vec<Vec<String>> = lines.map(cells).collect();
    if let Some(differences) = differences(&cells(header), &kept, rows, TOLERANCE) {
        panic!("{file} is another one:\n{differences}{renewing}");
    }
}

fn write(path: &Path, header: &str, rows: &[Vec<String>]) {
    let lines: String = rows.iter().map(|row| row.join(",") + "\n").collect();
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, format!("{header}\n{lines}")).unwrap();
}
