//! GIVEN the Python package of `src/python` WHEN it is asked what the commands are asked THEN it gives their numbers and their
//! words, as tables that pyarrow, polars and pandas take. WHEN it works through a fleet in an object store THEN nothing is lost and
//! nothing is there twice, whatever dies.

mod by_hand {
    use std::path::Path;
    use std::process::Command;

    use testing::program::{executable, project};

    #[test]
    #[ignore = "minutes: fetches maturin, pyarrow, polars and pandas, and builds a wheel"]
    fn the_python_package_says_what_the_commands_say() {
        passes("tests/peers/python_package.py", &[&executable()]);
    }

    #[test]
    #[ignore = "minutes: builds the same wheel, fetches Dask and an object store"]
    fn a_fleet_on_several_processes_loses_nothing() {
        passes("tests/peers/python_fleet.py", &[]);
    }

    /// A script's tests, which it is told where the project and a folder of its own are.
    fn passes(script: &str, first: &[&Path]) {
        let Some(python) = testing::package::python() else { return };
        let folder = tempfile::tempdir().unwrap();
        let mut tests = Command::new(&python);
        tests.arg(project(script)).args(first).arg(project(".")).arg(folder.path());
        let output = tests.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        println!("{}", String::from_utf8_lossy(&output.stdout));
    }
}
