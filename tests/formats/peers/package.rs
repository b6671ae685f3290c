//! GIVEN the Python package of `src/python` WHEN it is asked what the commands are asked THEN it gives their numbers and their
//! words, as tables that pyarrow, polars and pandas take.

mod by_hand {
    use std::process::Command;

    use testing::program::{executable, project};

    #[test]
    #[ignore = "minutes: fetches maturin, pyarrow, polars and pandas, and builds a wheel"]
    fn the_python_package_says_what_the_commands_say() {
        let Some(python) = testing::package::python() else { return };
        let folder = tempfile::tempdir().unwrap();
        let script = project("tests/peers/python_package.py");
        let mut tests = Command::new(&python);
        tests.arg(script).arg(executable()).arg(project(".")).arg(folder.path());
        let output = tests.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}
