//! Where the car went, by dead reckoning.

use super::scene::{Scene, most};
use crate::pages::explain::words::number;
use crate::pages::track::Track;
use crate::report::interactive::Figure;
use physics::Quantity;

/// More points than these are closer together than pixels.
const MOST_POINTS: usize = 5000;

impl Scene<'_> {
    /// The track, coloured by the lateral acceleration.
    pub fn track(&self) -> Figure {
        let mut figure = Figure::new("Track", "metres ahead of the start", "metres to the left of the start");
        figure.is_equal = true;
        let drift = self.drive.last.offsets.yaw_rate.map(|it| it.value);
        let (lateral, _) = self.lateral_acceleration();
        let track = Track {
            times: &self.drive.times,
            speed: &self.drive.speed,
            yaw_rate: self.drive.signal(Quantity::YawRate).unwrap_or_default(),
            offset: drift.unwrap_or(0.0),
            shade: &lateral,
        };
        let highest = f64::from(most(lateral.iter().map(|it| it.abs())).unwrap_or(1.0)).max(1.0);
        figure.points.push(track.points(("lateral acceleration, m/s²", highest), MOST_POINTS));
        let corrected = match drift {
            Some(drift) => format!(
                " The yaw rate's offset of {} °/s that was learned is taken off.",
                number(drift.to_degrees(), 2)
            ),
            None => String::new(),
        };
        figure.caption = format!(
            "From speed and yaw rate alone: it drifts by some per cent of the way. Wider where it was faster round the bend.{corrected}"
        );
        figure
    }
}
