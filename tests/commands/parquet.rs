//! GIVEN a drive WHEN its tables are written as Parquet THEN any reader of Parquet finds the columns, numbers, gaps, units
//! and version that the CSV twin has, in a file that appears only when it is complete.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use testing::program::{gripd_in, project};

/// A cell as the CSV has it.
fn text(column: &str, field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Double(time) if column == "t" => format!("{time:.6}"),
        Field::Double(number) => number.to_string(),
        Field::Long(number) => number.to_string(),
        Field::Bool(flag) => u8::from(*flag).to_string(),
        Field::Str(word) => word.clone(),
        other => panic!("{column}: {other:?}"),
    }
}

fn compare(csv: &Path, parquet: &Path) -> SerializedFileReader<File> {
    let csv = fs::read_to_string(csv).unwrap();
    let reader = SerializedFileReader::new(File::open(parquet).unwrap()).unwrap();
    let mut lines = csv.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut rows = 0;
    for (row, line) in reader.get_row_iter(None).unwrap().zip(lines.by_ref()) {
        let row = row.unwrap();
        let cells: Vec<_> = row.get_column_iter().collect();
        assert_eq!(cells.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), names);
        let cells: Vec<String> = cells.iter().map(|(name, field)| text(name, field)).collect();
        assert_eq!(cells.join(","), line);
        rows += 1;
    }
    assert_eq!(lines.next(), None, "the CSV has more rows");
    assert_eq!(reader.metadata().file_metadata().num_rows(), rows);
    reader
}

#[test]
fn the_parquet_twin_says_what_the_csv_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let scenario = project("config/scenarios/demo.toml");
    // More than one group of rows.
    let long = fs::read_to_string(scenario).unwrap().replace("duration_s = 120.0", "duration_s = 400.0");
    fs::write(path.join("drive.toml"), long).unwrap();
    assert!(gripd_in(path, "simulate drive.toml -o drive.log").status.success());
    let config = project("config/demo.toml");
    for extension in ["csv", "parquet"] {
        let arguments = format!(
            "replay -c {} drive.log --estimates e.{extension} --samples s.{extension}",
            config.display()
        );
        let output = gripd_in(path, &arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let estimates = compare(&path.join("e.csv"), &path.join("e.parquet"));
    assert!(estimates.num_row_groups() > 1, "{} rows", estimates.metadata().file_metadata().num_rows());
    let about: BTreeMap<_, _> = estimates
        .metadata()
        .file_metadata()
        .key_value_metadata()
        .unwrap()
        .iter()
        .map(|pair| (pair.key.as_str(), pair.value.as_deref().unwrap()))
        .collect();
    assert_eq!((about["gripd.version"], about["gripd.table"]), (env!("CARGO_PKG_VERSION"), "estimates"));
    let units: BTreeMap<String, String> = serde_json::from_str(about["gripd.units"]).unwrap();
    assert_eq!(
        (units["t"].as_str(), units["cornering_front"].as_str(), units["mu_max"].as_str()),
        ("s", "1/rad", "1")
    );
    assert!(estimates.metadata().row_group(0).column(1).compression().to_string().contains("ZSTD"));
    compare(&path.join("s.csv"), &path.join("s.parquet"));
    let size = |name: &str| fs::metadata(path.join(name)).unwrap().len();
    assert!(2 * size("e.parquet") < size("e.csv"), "{} of {}", size("e.parquet"), size("e.csv"));
}

#[test]
fn a_replay_that_fails_leaves_the_table_that_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("e.parquet"), "old").unwrap();
    let config = project("config/demo.toml");
    let output = gripd_in(path, &format!("replay -c {} missing.log --estimates e.parquet", config.display()));
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(fs::read(path.join("e.parquet")).unwrap(), b"old");
    assert_eq!(fs::read_dir(path).unwrap().count(), 1);
}
