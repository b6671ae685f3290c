//! CommonRoad's models of cars, which another author wrote: the Python package commonroad-vehicle-models.

use std::process::Command;

/// The Python that an environment variable names, or else the usual one, if it has the package. If not, a message says so.
pub fn python(variable: &str) -> Option<String> {
    let python = std::env::var(variable).unwrap_or_else(|_| "python3".into());
    let asked = Command::new(&python).args(["-c", "import vehiclemodels"]).output();
    if asked.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    println!("skipped: {python} has no package commonroad-vehicle-models");
    None
}
