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

use crate::report::interactive::Document;
use physics::model::Vehicle;

use scene::Scene;

/// The page of a drive with this car.
pub fn document(drive: &Drive, vehicle: &Vehicle) -> Document {
    let scene = Scene::new(drive, vehicle);
    let mut document = scene.empty_document();
    for panel in scene.measured().into_iter().chain(scene.estimated()) {
        document.panel(panel);
    }
    document.figure(scene.handling());
    document.figure(scene.accelerations());
    document.figure(scene.track());
    document
}
