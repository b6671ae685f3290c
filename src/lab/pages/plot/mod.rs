//! A recording to look into: what was measured, what gripd makes of it, and the car's handling.

mod drive;
mod estimated;
mod friction;
mod handling;
mod head;
mod measured;
mod scene;
mod track;

pub use drive::Drive;

use crate::report::Page;
use physics::model::Vehicle;

use scene::Scene;

/// The page of a drive with this car; `more` writes what else is told of it, below the plots.
pub fn page(drive: &Drive, vehicle: &Vehicle, more: impl FnOnce(&mut Page)) -> Page {
    let scene = Scene::new(drive, vehicle);
    let mut plots = scene.empty_plots();
    for panel in scene.measured().into_iter().chain(scene.estimated()) {
        plots.panel(panel);
    }
    plots.figure(scene.handling());
    plots.figure(scene.accelerations());
    plots.figure(scene.track());
    let mut page = Page::new("A drive, recorded from the car's CAN bus", &scene.lead());
    page.facts(&scene.facts());
    page.plots(&plots);
    more(&mut page);
    page.section("notes", "How to read this", "");
    for note in scene.notes() {
        page.paragraph(&note);
    }
    page
}
