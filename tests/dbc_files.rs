//! GIVEN real DBC files WHEN they are loaded THEN each loads, and names the line of what it cannot use.

use std::path::PathBuf;

use gripd::dbc::Database;

fn shared(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("GRIPD_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let found = root.join(path);
    if !found.exists() {
        eprintln!("skipped: {} is not there", found.display());
        return None;
    }
    Some(found)
}

#[test]
fn print() {
    let Some(folder) = shared("dbc") else { return };
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.extend(shared("recordings/rav4/_toyota_2017.dbc"));
    files.extend(shared("recordings/recording.dbc"));
    files.sort();
    for f in files.iter().filter(|f| f.extension().is_some_and(|e| e == "dbc")) {
        let t = std::time::Instant::now();
        let db = Database::load(f).unwrap();
        println!(
            "{} {} messages {} signals, {} warnings {:?}",
            f.display(),
            db.messages().len(),
            db.messages().iter().map(|m| m.signals.len()).sum::<usize>(),
            db.warnings().len(),
            t.elapsed()
        );
        for w in db.warnings() {
            println!("   {w}");
        }
    }
}
