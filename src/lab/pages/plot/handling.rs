//! The handling curve of a drive: when it was nearly steady, and on which surface.

use std::collections::BTreeMap;

use super::scene::Scene;
use crate::pages::handling::Handling;
use crate::report::interactive::Figure;
use identify::understeer::{self, Instant, Moment};
use physics::Quantity;
use physics::model::Uncertain;

impl Scene<'_> {
    /// The figure, with the understeer gradient where the drive tells it.
    pub fn handling(&self) -> Figure {
        let (lateral, is_sensor) = self.lateral_acceleration();
        let (moments, elsewhere) = self.on_one_surface(self.moments(&lateral));
        let told = self.learned().map(|it| ("from the cornering stiffness learned last", it));
        Handling { vehicle: self.vehicle, is_sensor, moments, elsewhere, told }.figure()
    }

    fn moments(&self, lateral: &[f32]) -> Vec<Moment> {
        let steering = self.drive.signal(Quantity::SteeringWheelAngle).unwrap_or_default();
        let yaw_rate = self.drive.signal(Quantity::YawRate).unwrap_or_default();
        let ratio = self.vehicle.steering_ratio.value;
        // As the track has it: an offset would look like another curve at each speed.
        let offset = self.drive.last.offsets.yaw_rate.map_or(0.0, |it| it.value);
        let of = |column: &[f32], place: usize| column.get(place).map_or(f64::NAN, |it| f64::from(*it));
        understeer::moments(self.drive.times.iter().enumerate().map(|(place, t)| Instant {
            t: *t,
            speed: of(&self.drive.speed, place),
            yaw_rate: of(yaw_rate, place) - offset,
            lateral_acceleration: of(lateral, place),
            road_angle: of(steering, place) / ratio,
        }))
    }

    /// Those between two changes of the surface, and all others: tires are softer on gravel, and one line through both says
    /// nothing of either. Of the stretches it is the one that tells most.
    fn on_one_surface(&self, moments: Vec<Moment>) -> (Vec<Moment>, Vec<Moment>) {
        let surface = |it: &Moment| {
            let place = self.drive.times.partition_point(|time| *time < it.t);
            self.drive.changes.get(place).copied().unwrap_or_default()
        };
        let mut told: BTreeMap<u32, f64> = BTreeMap::new();
        for it in &moments {
            *told.entry(surface(it)).or_default() += it.lateral_acceleration * it.lateral_acceleration;
        }
        let most = told.iter().max_by(|one, other| one.1.total_cmp(other.1)).map(|(surface, _)| *surface);
        moments.into_iter().partition(|it| Some(surface(it)) == most)
    }

    /// The gradient by the cornering stiffnesses at the end, if these were valid.
    fn learned(&self) -> Option<Uncertain> {
        let [front, rear] = self.drive.last.cornering;
        let as_uncertain = |it: physics::estimates::Estimate| Uncertain { value: it.value, std: it.std };
        let (front, rear) = (as_uncertain(front?), as_uncertain(rear?));
        self.drive.last.cornering_valid.then(|| understeer::of_stiffness(front, rear))
    }
}
